"""Named data in a scene: tables that name a set take from it the fields that they leave out.

A scene then holds both, the name and the numbers, and is refused where they differ: a name says where numbers come
from. To change one of the numbers drops the name.
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
"""Tables for which a name may stand alone, `material.gear = "POM"`."""

_BY_SMALL_NAME = {name.casefold(): name for name in named_sets(MATERIALS)}
_FAR_OFF = 10.0  # times the modulus of a plastic
_NEAR = 0.1  # share by which moduli of steels differ at most
_ELASTIC = ("youngs_modulus_MPa", "poissons_ratio")
_COEFFICIENT = "coefficient_mm2_per_N"
_OILED = {
    "effects.friction": ("viscosity_mPas",),
    "effects.lubrication": ("viscosity_mPas", "pressure_viscosity_per_GPa"),
}
# by table: fields that name data, and those that follow from them
_NAMED: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    **{table: (("data",), ("name", *_ELASTIC)) for table in NAMING},
    "wear": (("data",), (_COEFFICIENT,)),
    **{table: (("data", "oil_temperature_C"), names) for table, names in _OILED.items()},
}


def dropped_with(key: str) -> tuple[str, ...]:
    """Fields that a change of this one leaves nothing of: what a name gives, or the name of data that are changed."""
    table, _, field = key.rpartition(".")
    naming, given = _NAMED.get(table, ((), ()))
    dropped = given if field in naming else naming if field in given and field != "name" else ()
    return tuple(f"{table}.{name}" for name in dropped)


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
            own = {"name": found["title"]} | {name: found[name] for name in _ELASTIC} | _said(own)
        if own is not None:
            tables[body] = own
    return tables


def _wear(table: Table) -> Table:
    names, given = table.get("data"), table.get(_COEFFICIENT)
    if isinstance(names, Mapping) and (given is None or isinstance(given, Mapping)):
        found = {body: named_set(WEAR, name).get(_COEFFICIENT) for body, name in names.items() if name is not None}
        if found and None not in found.values() and set(found) <= set(BODIES):
            table[_COEFFICIENT] = found | _said(given or {})
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
            given = oil_at(oil, temperature)
            tables[effect] = {name: given[name] for name in names} | _said(own)
    return tables


def _said(table: Mapping[str, Value]) -> Table:
    return {name: value for name, value in table.items() if value is not None}


# ---- rules: numbers are those of the data that are named


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
    def _a_label_gives_no_stiffness(
        name: str, data: str | None, modulus: float, table: str = _table
    ) -> Iterator[Problem]:
        meant = _BY_SMALL_NAME.get(name.casefold())
        published = float(named_set(MATERIALS, meant).get("youngs_modulus_MPa", modulus))
        of_steel = abs(modulus / Material.youngs_modulus_MPa - 1.0) < _NEAR
        if data is None and of_steel and _FAR_OFF * published < modulus:
            fix = f'the name alone gives no stiffness: give data = "{meant}", or the modulus'
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
            missing, there = ("oil_temperature_C", "data") if temperature is None else ("data", "oil_temperature_C")
            allowed = "degrees Celsius" if temperature is None else "the name of an oil (semiwear materials)"
            fix = f"needed by {table}.{there}: add it, or leave both out"
            yield Problem(f"{table}.{missing}", None, allowed, fix)
        elif name is not None and temperature is not None:
            given = oil_at(named_set(OILS, name), temperature)
            for field, value in zip(fields, own, strict=True):
                yield from _differs(f"{table}.{field}", value, given[field], table, name)
