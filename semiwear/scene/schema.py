"""Schema of a scene file: its tables, their dataclasses and fields, for every kind of gear pair."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import MISSING, dataclass, fields
from functools import cached_property
from itertools import islice

from semiwear.scene.closest import closest
from semiwear.scene.declare import derived_of, rules_of
from semiwear.scene.defaults import DerivedDefault
from semiwear.scene.effects import EFFECTS, Effects, Modifications, WearLaws
from semiwear.scene.kinds import KINDS, GearPair
from semiwear.scene.model import SceneTables
from semiwear.scene.rule import Rule, choice
from semiwear.scene.rules import BODIES, BodyCoefficients, BodyData
from semiwear.scene.tables import Material, Materials, Numerics, Operation, Wear, WearUntil
from semiwear.untyped import Options, Table, Value

OPTIONAL_TABLES = ("wear", "wear.control_point", *(f"effects.{name}" for name in EFFECTS))
_MOST_TABLES = 200  # searched for a misspelled one
# These tables contain only effects; empty, they would have no effect.
NEVER_EMPTY = ("effects.modification", "effects.wear_law")
INLINE_TABLES = ("wear.data", "wear.coefficient_mm2_per_N")

_COMMON_TABLES: dict[str, type] = {
    "": SceneTables,
    "material": Materials,
    "material.pinion": Material,
    "material.gear": Material,
    "operation": Operation,
    "wear": Wear,
    "wear.until": WearUntil,
    "numerics": Numerics,
    "effects": Effects,
    "effects.modification": Modifications,
    "effects.wear_law": WearLaws,
} | {f"effects.{name}": table for name, table in EFFECTS.items()}
# In the order in which a scene is written.
_ORDER = (
    "",
    "gear_pair",
    "material.pinion",
    "material.gear",
    "operation",
    "wear",
    "wear.until",
    "wear.control_point",
    "numerics",
    *(f"effects.{name}" for name in EFFECTS),
)


def parent(key: str) -> str:
    """Table of a dotted key; the empty string is the top level."""
    return key.rpartition(".")[0]


def last_of(key: str) -> str:
    """Name of a field or table: its dotted key without the parent."""
    return key.rpartition(".")[2]


_WHICH_KIND = 'spur and helical gears are "cylindrical", bevel, hypoid and worm gears come as points: "flank_points"'


@dataclass(frozen=True, eq=False)
class Schema:
    """The fields that a scene with one kind of gear pair may have.

    Attributes
    ----------
    kind : str
        The value of ``gear_pair.type``.
    """

    kind: str

    @property
    def pair(self) -> type[GearPair]:
        """The dataclass of the table ``[gear_pair]``."""
        return KINDS[self.kind][0]

    @cached_property
    def tables(self) -> dict[str, type]:
        """Dataclasses by dotted name."""
        pair, control_point = KINDS[self.kind]
        return {**_COMMON_TABLES, "gear_pair": pair, "wear.control_point": control_point}

    @cached_property
    def rules(self) -> dict[str, Rule]:
        """Rules by dotted key, in the order in which a scene is written."""
        rules: dict[str, Rule] = {}
        for name in _ORDER:
            rules |= rules_of(self.tables[name], name)
        return rules | {"gear_pair.type": choice(*KINDS, otherwise=_WHICH_KIND)}

    @property
    def derived(self) -> Mapping[str, DerivedDefault]:
        """Defaults of fields of the gear pair that follow from others, each after those that it needs."""
        return derived_of(self.pair)

    @cached_property
    def declared(self) -> Table:
        """Defaults as declared by the dataclasses, MISSING if there is none."""
        by_name = {
            (table, entry.name): entry.default for table, owner in self.tables.items() for entry in fields(owner)
        }
        return {key: by_name[parent(key), last_of(key)] for key in self.rules}

    @cached_property
    def derived_keys(self) -> frozenset[str]:
        """Fields whose default follows from others."""
        return frozenset(f"gear_pair.{name}" for name in self.derived)

    @cached_property
    def required(self) -> frozenset[str]:
        """Fields without a default."""
        return frozenset(key for key, default in self.declared.items() if default is MISSING)

    @cached_property
    def defaults(self) -> Table:
        """Defaults that do not depend on other fields."""
        without = self.required | self.derived_keys
        return {key: default for key, default in self.declared.items() if key not in without}

    @cached_property
    def _by_table(self) -> dict[str, tuple[str, ...]]:
        """Fields of every table."""
        tables = dict.fromkeys(map(parent, self.rules))
        return {table: tuple(key for key in self.rules if parent(key) == table) for table in tables}

    def fields_of(self, table: str) -> tuple[str, ...]:
        """Dotted keys of the fields directly in a table."""
        return self._by_table.get(table, ())

    def children(self, table: str) -> list[str]:
        """Dotted keys of fields and then tables directly in a table."""
        return [*self.fields_of(table), *(name for name in self.tables if name and parent(name) == table)]


SCHEMAS: dict[str, Schema] = {kind: Schema(kind) for kind in KINDS}
"""Schemas by kind of gear pair."""


def schemas_of_data(data: Mapping[str, Value]) -> list[Schema]:
    """Schemas that fit nested mappings, valid or not: by the type, else by the greatest number of known names."""
    pair = data.get("gear_pair")
    if not isinstance(pair, Mapping):
        tables = (name for name, table in data.items() if isinstance(table, Mapping))
        named = closest("gear_pair", islice(tables, _MOST_TABLES))
        pair = {} if named is None else data[named]
    kind = pair.get("type")
    if isinstance(kind, str) and (meant := closest(kind, SCHEMAS)) is not None:
        return [SCHEMAS[meant]]
    fitting = [sum(f"gear_pair.{name}" in schema.rules for name in pair) for schema in SCHEMAS.values()]
    return [schema for schema, count in zip(SCHEMAS.values(), fitting, strict=True) if count == max(fitting)]


def schema_of_data(data: Mapping[str, Value]) -> Schema:
    """The first schema that fits nested mappings."""
    return schemas_of_data(data)[0]


def schema_of_scene(scene: SceneTables) -> Schema:
    """The schema of a scene."""
    return next(schema for schema in SCHEMAS.values() if schema.pair is type(scene.gear_pair))


def schemas_of_scene(scene: SceneTables | None) -> list[Schema]:
    """The schema of a scene; those of all kinds of gear pair without one."""
    return list(SCHEMAS.values()) if scene is None else [schema_of_scene(scene)]


def built_tables(schema: Schema, values: Mapping[str, Value], tables: Collection[str]) -> Options:
    """The tables of a scene, as arguments of `SceneTables`.

    Parameters
    ----------
    schema : Schema
    values : mapping
        Values under their dotted keys; fields left out have their defaults.
    tables : collection of str
        The tables that are present, of which an empty one may be an effect.
    """

    def arguments(table: str) -> Table:
        return {last_of(key): values[key] for key in schema.fields_of(table) if key in values}

    def present(container: str) -> Table:
        keys = [key for key in schema.children(container) if key in tables and key in OPTIONAL_TABLES]
        return {last_of(key): schema.tables[key](**arguments(key)) for key in keys}

    numerics, wear = arguments("numerics"), None
    if "wear" in tables:
        watched = arguments("wear.control_point")
        wear = Wear(
            until=WearUntil(**arguments("wear.until")),
            control_point=schema.tables["wear.control_point"](**watched) if watched else None,
            **arguments("wear"),
        )
    return dict(
        gear_pair=schema.tables["gear_pair"](**arguments("gear_pair")),
        material=Materials(**{body: Material(**arguments(f"material.{body}")) for body in BODIES}),
        operation=Operation(**arguments("operation")),
        wear=wear,
        # given fields are stored, since `numerics.accuracy` decides the others
        numerics=Numerics(**numerics, _given=frozenset(name for name, value in numerics.items() if value != "auto")),
        effects=Effects(
            modification=Modifications(**present("effects.modification")),
            wear_law=WearLaws(**present("effects.wear_law")),
            **present("effects"),
        ),
        **arguments(""),
    )


def to_dict(scene: SceneTables, *, without_derived: bool = False) -> Table:
    """The scene as nested dicts of plain values; None and absent tables are left out.

    Parameters
    ----------
    scene : SceneTables
        The scene.
    without_derived : bool
        Leave out fields with their derived default.
    """
    nested: Table = {}
    hidden = {f"gear_pair.{name}" for name in scene.gear_pair._derived} if without_derived else set()
    if without_derived or scene.numerics.accuracy is not None:
        hidden |= {f"numerics.{name}" for name in scene.numerics.left_out}
    if without_derived and scene.wear is not None and scene.wear._derived:
        hidden.add("wear.worn_bodies")
    if scene.wear is not None and scene.wear.until._derived:
        hidden.add("wear.until.meshes")
    rules = schema_of_scene(scene).rules
    for key, value in _flat(scene, rules):
        if value is None or key in hidden:
            continue
        *path, name = key.split(".")
        table = nested
        for step in path:
            table = table.setdefault(step, {})
        # Converted again, since constructors accept module_mm=6 and equal scenes must give equal text.
        table[name] = _plain(rules[key].read(value))
    return nested


def _plain(value: Value) -> Value:
    if isinstance(value, tuple):
        return list(value)
    if isinstance(value, BodyCoefficients | BodyData):
        return value.given
    return value


def _flat(scene: SceneTables, rules: Mapping[str, Rule]) -> Iterator[tuple[str, Value]]:
    for key in rules:
        value: Value = scene
        for step in key.split("."):
            value = None if value is None else getattr(value, step)
        yield key, value
