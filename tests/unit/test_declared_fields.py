"""Every field of a scene is declared once, and its table's documentation says what it is."""

from dataclasses import MISSING, fields, is_dataclass

import pytest

from semiwear.scene.declare import derived_of
from semiwear.scene.schema import SCHEMAS

TABLES = [(schema.kind, name, owner) for schema in SCHEMAS.values() for name, owner in schema.tables.items()]
NESTED = {
    "until",
    "control_point",
    "pinion",
    "gear",
    "gear_pair",
    "material",
    "operation",
    "wear",
    "numerics",
    "effects",
}


@pytest.mark.parametrize(("kind", "name", "owner"), TABLES, ids=lambda value: str(value))
def test_fields_are_declared_or_tables(kind, name, owner):
    assert is_dataclass(owner)
    rules = SCHEMAS[kind].rules
    assert {key.rpartition(".")[2] for key in SCHEMAS[kind].fields_of(name)} <= {
        entry.name for entry in fields(owner)
    }
    for entry in fields(owner):
        key = f"{name}.{entry.name}" if name else entry.name
        if entry.name.startswith("_") or key in SCHEMAS[kind].tables or entry.name in NESTED:
            assert key not in rules
            continue
        assert key in rules, key
        said = entry.metadata["meaning"]
        assert said.endswith(".") and len(said) > 5, key
        if name:
            assert f"\n{entry.name} : " in owner.__doc__, key
            assert said.split()[0] in owner.__doc__


@pytest.mark.parametrize("schema", SCHEMAS.values(), ids=SCHEMAS)
def test_derived_defaults_come_after_what_they_need(schema):
    owner = schema.pair
    declared = {entry.name: entry for entry in fields(owner)}
    known = {name for name, entry in declared.items() if entry.default is not None}
    for name, default in derived_of(owner).items():
        assert set(default.needs) <= known, name
        known.add(name)
    assert schema.required == {key for key in schema.rules if schema.declared[key] is MISSING}
