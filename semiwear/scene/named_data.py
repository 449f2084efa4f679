"""Named data in a scene: tables that name a set take from it the fields that they leave out.

A scene then holds both, the name and the numbers, so that it means the same when the sets change. Where they differ
the scene's own number holds.
"""

from __future__ import annotations

from collections.abc import Mapping

from semiwear.references.named_data import MATERIALS, OILS, WEAR, named_set, oil_at
from semiwear.scene.rules import BODIES
from semiwear.untyped import Table, Value

__all__ = ["NAMING", "given_by", "with_named_data"]

NAMING = tuple(f"material.{body}" for body in BODIES)
"""Tables for which a name may stand alone, `material.gear = "POM"`."""

_ELASTIC = ("name", "youngs_modulus_MPa", "poissons_ratio")
_COEFFICIENT = "coefficient_mm2_per_N"
_OILED = {
    "effects.friction": ("viscosity_mPas",),
    "effects.lubrication": ("viscosity_mPas", "pressure_viscosity_per_GPa"),
}
_GIVEN = {
    **{f"{table}.data": tuple(f"{table}.{name}" for name in _ELASTIC) for table in NAMING},
    "wear.data": (f"wear.{_COEFFICIENT}",),
    **{
        f"{table}.{decides}": tuple(f"{table}.{name}" for name in names)
        for table, names in _OILED.items()
        for decides in ("data", "oil_temperature_C")
    },
}


def given_by(key: str) -> tuple[str, ...]:
    """Fields that follow from a field which names data, by dotted key: its change leaves nothing of them."""
    return _GIVEN.get(key, ())


def with_named_data(data: Mapping[str, Value]) -> Mapping[str, Value]:
    """Nested mappings of a scene with the fields that named data give; what is no name is left as it is."""
    filled = dict(data)
    _fill(filled, "material", _materials)
    _fill(filled, "wear", _wear)
    _fill(filled, "effects", _oils)
    return filled


def _fill(data: Table, name: str, fill: Value) -> None:
    if isinstance(data.get(name), Mapping):
        data[name] = fill(dict(data[name]))


def _materials(tables: Table) -> Table:
    for body in BODIES:
        own = tables.get(body)
        if isinstance(own, str):
            own = {"data": own}
        if isinstance(own, Mapping) and (found := named_set(MATERIALS, own.get("data"))):
            own = {"name": found["title"]} | {name: found[name] for name in _ELASTIC[1:]} | _said(own)
        if own is not None:
            tables[body] = own
    return tables


def _wear(table: Table) -> Table:
    if table.get(_COEFFICIENT) is not None:
        return table
    names = table.get("data")
    if isinstance(names, Mapping):
        found = {body: named_set(WEAR, name).get(_COEFFICIENT) for body, name in names.items() if name is not None}
        if found and None not in found.values() and set(found) <= set(BODIES):
            table[_COEFFICIENT] = found
    elif coefficient := named_set(WEAR, names).get(_COEFFICIENT):
        table[_COEFFICIENT] = coefficient
    return table


def _oils(tables: Table) -> Table:
    for key, names in _OILED.items():
        effect = key.removeprefix("effects.")
        own = tables.get(effect)
        if not isinstance(own, Mapping) or not (oil := named_set(OILS, own.get("data"))):
            continue
        temperature = own.get("oil_temperature_C")
        if isinstance(temperature, int | float) and -60.0 <= temperature <= 200.0:
            given = oil_at(oil, temperature)
            tables[effect] = {name: given[name] for name in names} | _said(own)
    return tables


def _said(table: Mapping[str, Value]) -> Table:
    return {name: value for name, value in table.items() if value is not None}
