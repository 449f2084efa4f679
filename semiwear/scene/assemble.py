"""All problems of a nested mapping that is to become a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from semiwear.errors import Problem, SceneError
from semiwear.scene.across import find_conflicts
from semiwear.scene.cross_rules import CROSS_RULES
from semiwear.scene.cylindrical_rules import CYLINDRICAL_CROSS_RULES
from semiwear.scene.effect_cross_rules import EFFECT_CROSS_RULES, find_missing_needs
from semiwear.scene.flank_points_rules import FLANK_POINTS_CROSS_RULES
from semiwear.scene.named_data import NAMED_DATA_RULES, with_named_data
from semiwear.scene.reading import Reading, read_fields
from semiwear.scene.schema import Schema, schemas_of_data
from semiwear.scene.tables import default_worn_bodies
from semiwear.untyped import Table, Value


def examined(data: Mapping[str, Value], known: Sequence[Problem]) -> tuple[Reading, list[Problem]]:
    """Fields of nested mappings with the layout of a scene file, and their problems, added to the known ones."""
    data = with_named_data(data)
    schema, *others = schemas_of_data(data)
    reading = read_fields(data, schema, kind_is_known=not others)
    # rules over fields that this kind of gear pair does not have are skipped
    rules = [
        *CROSS_RULES,
        *CYLINDRICAL_CROSS_RULES,
        *FLANK_POINTS_CROSS_RULES,
        *EFFECT_CROSS_RULES,
        *NAMED_DATA_RULES,
    ]
    conflicts = find_conflicts(_with_defaults(reading, schema), rules)
    return reading, [*known, *reading.problems, *find_missing_needs(reading), *conflicts]


def with_origin(problems: Sequence[Problem], reading: Reading) -> list[Problem]:
    """The problems, with those of default values marked."""
    rules = reading.schema.rules
    return [replace(p, default=p.field in rules and not reading.has(p.field)) for p in problems]


def _with_defaults(reading: Reading, schema: Schema) -> Table:
    """All known values, given, default or derived; None for the fields of an absent control point."""
    values = reading.given | {key: default for key, default in schema.defaults.items() if reading.lacks(key)}
    for name, derived in schema.derived.items():
        key, needs = f"gear_pair.{name}", [f"gear_pair.{need}" for need in derived.needs]
        if reading.lacks(key) and all(need in values for need in needs):
            try:
                values[key] = derived.formula(*(values[need] for need in needs))
            except (ArithmeticError, ValueError):  # for impossible teeth
                fix = f"its default cannot be computed from {', '.join(derived.needs)}: correct these, or give it"
                reading.refused.add(key)
                reading.problems.append(Problem(key, None, schema.rules[key].allowed, fix))
    if reading.lacks("wear.worn_bodies"):
        # without a known coefficient, the missing coefficient is reported
        coefficient, mapping = values.get("wear.coefficient_mm2_per_N"), values.get("numerics.wear_mapping")
        values["wear.worn_bodies"] = default_worn_bodies(schema.pair.both_wear, coefficient, mapping)
    if reading.lacks("wear.control_point"):
        values |= dict.fromkeys(schema.fields_of("wear.control_point"))
    return values


def further_problems(check: Callable[[], Sequence[Problem]], found: Sequence[Problem]) -> list[Problem]:
    """Further problems found by the caller's check, without fields that are reported already."""
    try:
        further = list(check())
    except SceneError as error:
        further = list(error.problems)
    except Exception:
        # The check may be unable to compute a scene that is known to be wrong, but not a valid one.
        if not found:
            raise
        further = []
    reported = {problem.field for problem in found}
    return [problem for problem in further if problem.field not in reported]
