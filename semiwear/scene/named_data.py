"""Named data in a scene: a table that names a set of data takes from it the fields that it leaves out.

The scene then has both the name and the numbers, and is refused if they differ, since the name states their source.
Changing one of the numbers removes the name.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial

from semiwear.errors import Problem
from semiwear.references.named_data import MATERIALS, OILS, WEAR, named_set, named_sets, oil_at
from semiwear.scene.across import RuleBook, across
from semiwear.scene.rules import BODIES, BodyCoefficients, BodyData
from semiwear.scene.tables import Material
from semiwear.untyped import Table, Value

NAMING = tuple(f"material.{body}" for body in BODIES)
"""Tables that may be replaced by a name, `material.gear = "POM"`."""

_BY_FOLDED_NAME = {name.casefold(): name for name in named_sets(MATERIALS)}
_MODULUS_RATIO = 10.0  # of a steel to a plastic, at least
_STEEL_SCATTER = 0.1  # relative difference of the moduli of steels, at most
_ELASTIC = ("youngs_modulus_MPa", "poissons_ratio")
_COEFFICIENT = "coefficient_mm2_per_N"
_OILED = {
    "effects.friction": ("viscosity_mPas",),
    "effects.lubrication": ("viscosity_mPas", "pressure_viscosity_per_GPa"),
}
# by table: fields that name data, and the fields taken from these
_NAMED: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    **{table: (("data",), ("name", *_ELASTIC)) for table in NAMING},
    "wear": (("data",), (_COEFFICIENT,)),
    **{table: (("data", "oil_temperature_C"), names) for table, names in _OILED.items()},
}


def dropped_with(key: str) -> tuple[str, ...]:
    """Fields removed by a change of this field: those taken from a changed name, or the name of changed data."""
    table, _, field = key.rpartition(".")
    naming, given = _NAMED.get(table, ((), ()))
    dropped = given if field in naming else naming if field in given and field != "name" else ()
    return tuple(f"{table}.{name}" for name in dropped)


def with_named_data(data: Mapping[str, Value]) -> Mapping[str, Value]:
    """Nested mappings of a scene with the fields of named data filled in; unknown names are kept."""
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
            own = {"name": found["title"]} | {name: found[name] for name in _ELASTIC} | _given(own)
        if own is not None:
            tables[body] = own
    return tables


def _wear(table: Table) -> Table:
    names, given = table.get("data"), table.get(_COEFFICIENT)
    if isinstance(names, Mapping) and (given is None or isinstance(given, Mapping)):
        found = {body: named_set(WEAR, name).get(_COEFFICIENT) for body, name in names.items() if name is not None}
        if found and None not in found.values() and set(found) <= set(BODIES):
            table[_COEFFICIENT] = found | _given(given or {})
    elif given is None and (coefficient := named_set(WEAR, names).get(_COEFFICIENT)):
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
            published = oil_at(oil, temperature)
            tables[effect] = {name: published[name] for name in names} | _given(own)
    return tables


def _given(table: Mapping[str, Value]) -> Table:
    return {name: value for name, value in table.items() if value is not None}


# ---- rules: numbers equal those of the named data


def _differs(key: str, found: object, published: object, table: str, name: str) -> Iterator[Problem]:
    if found != published:
        allowed = f"{published} of {name}, or left out"
        fix = f"leave it out to take that of {name}, or leave {table}.data out for a number of your own"
        yield Problem(key, found, allowed, fix)


NAMED_DATA_RULES: RuleBook = []
_across = partial(across, NAMED_DATA_RULES)

for _table in NAMING:

    @_across(_table, "data", *_ELASTIC)
    def _material_is_the_named_one(name: str | None, *elastic: float, table: str = _table) -> Iterator[Problem]:
        if name is not None:
            for field, value in zip(_ELASTIC, elastic, strict=True):
                yield from _differs(f"{table}.{field}", value, float(named_set(MATERIALS, name)[field]), table, name)

    @_across(_table, "name", "data", "youngs_modulus_MPa")
    def _plastic_has_not_the_modulus_of_steel(
        name: str, data: str | None, modulus: float, table: str = _table
    ) -> Iterator[Problem]:
        meant = _BY_FOLDED_NAME.get(name.casefold())
        published = float(named_set(MATERIALS, meant).get("youngs_modulus_MPa", modulus))
        of_steel = abs(modulus / Material.youngs_modulus_MPa - 1.0) < _STEEL_SCATTER
        if data is None and of_steel and _MODULUS_RATIO * published < modulus:
            fix = f'the name alone sets no stiffness: give data = "{meant}", or the modulus'
            yield Problem(f"{table}.youngs_modulus_MPa", modulus, f"about {published:g} MPa of {meant}", fix)


@_across("wear", "data", _COEFFICIENT)
def _coefficient_is_the_named_one(
    data: str | BodyData | None, coefficient: float | BodyCoefficients
) -> Iterator[Problem]:
    if data is None:
        return
    for body, name in (data.given if isinstance(data, BodyData) else dict.fromkeys(BODIES, data)).items():
        own = getattr(coefficient, body) if isinstance(coefficient, BodyCoefficients) else coefficient
        if own is not None:
            key = f"wear.{_COEFFICIENT}" + (f".{body}" if isinstance(coefficient, BodyCoefficients) else "")
            found = list(_differs(key, own, named_set(WEAR, name)[_COEFFICIENT], "wear", name))
            yield from found
            if found:
                return


for _table, _names in _OILED.items():

    @_across(_table, "data", "oil_temperature_C", *_names)
    def _oil_is_the_named_one(
        name: str | None,
        temperature: float | None,
        *own: float,
        table: str = _table,
        fields: tuple[str, ...] = _names,
    ) -> Iterator[Problem]:
        if (name is None) != (temperature is None):
            missing, present = ("oil_temperature_C", "data") if temperature is None else ("data", "oil_temperature_C")
            allowed = "degrees Celsius" if temperature is None else "the name of an oil (semiwear materials)"
            fix = f"needed by {table}.{present}: add it, or leave both out"
            yield Problem(f"{table}.{missing}", None, allowed, fix)
        elif name is not None and temperature is not None:
            published = oil_at(named_set(OILS, name), temperature)
            for field, value in zip(fields, own, strict=True):
                yield from _differs(f"{table}.{field}", value, published[field], table, name)
