"""Problems of a nested mapping as a scene: every one at once."""

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
    """Fields of nested mappings laid out like a scene file, and what is wrong with them, besides what is known."""
    data = with_named_data(data)
    schema, *others = schemas_of_data(data)
    reading = read_fields(data, schema, kind_is_known=not others)
    # a rule over fields that this kind of gear pair does not have is never applied
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
    """The problems, those of defaults marked."""
    rules = reading.schema.rules
    return [replace(p, default=p.field in rules and not reading.has(p.field)) for p in problems]


def _with_defaults(reading: Reading, schema: Schema) -> Table:
    """Every value that is known: given, default or derived; None for the control point when there is none."""
    values = reading.given | {key: default for key, default in schema.defaults.items() if reading.lacks(key)}
    for name, derived in schema.derived.items():
        key, needs = f"gear_pair.{name}", [f"gear_pair.{need}" for need in derived.needs]
        if reading.lacks(key) and all(need in values for need in needs):
            try:
                values[key] = derived.formula(*(values[need] for need in needs))
            except (ArithmeticError, ValueError):  # of numbers that no tooth has
                fix = f"its default cannot be computed from {', '.join(derived.needs)}: correct these, or give it"
                reading.refused.add(key)
                reading.problems.append(Problem(key, None, schema.rules[key].allowed, fix))
    if reading.lacks("wear.worn_bodies"):
        # where no coefficient is known, that is the problem
        coefficient, mapping = values.get("wear.coefficient_mm2_per_N"), values.get("numerics.wear_mapping")
        values["wear.worn_bodies"] = default_worn_bodies(schema.pair.both_wear, coefficient, mapping)
    if reading.lacks("wear.control_point"):
        values |= dict.fromkeys(schema.fields_of("wear.control_point"))
    return values


def further_problems(check: Callable[[], Sequence[Problem]], found: Sequence[Problem]) -> list[Problem]:
    """Problems that the caller's checker adds; a field already reported is not reported twice."""
    try:
        further = list(check())
    except SceneError as error:
        further = list(error.problems)
    except Exception:
        # A scene already found wrong may be beyond what the checker can compute; a sound one may not.
        if not found:
            raise
        further = []
    reported = {problem.field for problem in found}
    return [problem for problem in further if problem.field not in reported]
