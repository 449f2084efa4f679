"""From a nested mapping to a checked scene, or to every problem at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from semiwear.errors import Problem, SceneError
from semiwear.scene.across import find_conflicts
from semiwear.scene.cross_rules import CROSS_RULES
from semiwear.scene.cylindrical_rules import CYLINDRICAL_CROSS_RULES
from semiwear.scene.effect_cross_rules import EFFECT_CROSS_RULES, find_missing_needs
from semiwear.scene.flank_points_rules import FLANK_POINTS_CROSS_RULES
from semiwear.scene.model import SceneTables
from semiwear.scene.reading import Reading, read_fields
from semiwear.scene.schema import Schema, built_tables, schema_of_data
from semiwear.scene.tables import default_worn_bodies
from semiwear.untyped import Table, Value

__all__ = ["assembled"]

SceneT = TypeVar("SceneT", bound=SceneTables)


def assembled(
    make: Callable[[Table], SceneT],
    data: Mapping[str, Value],
    name: str,
    check: Callable[[SceneT], Sequence[Problem]] | None,
    problems: Sequence[Problem],
) -> SceneT:
    """A scene from nested mappings laid out like a scene file.

    Parameters
    ----------
    make : callable
        From the tables of a scene, as arguments, to the scene.
    data : mapping
        Tables and fields; None stands for a field left out.
    name : str
        What to call the scene in errors.
    check : callable or None
        Further limits; applied when every field is in its own range.
    problems : sequence of Problem
        Problems already known, to be reported with the others.

    Raises
    ------
    SceneError
        With every problem found.
    """
    schema = schema_of_data(data)
    reading = read_fields(data, schema)
    # a rule over fields that this kind of gear pair does not have is never applied
    rules = [*CROSS_RULES, *CYLINDRICAL_CROSS_RULES, *FLANK_POINTS_CROSS_RULES, *EFFECT_CROSS_RULES]
    conflicts = find_conflicts(_with_defaults(reading, schema), rules)
    found = [*problems, *reading.problems, *find_missing_needs(reading), *conflicts]
    if reading.refused or any(reading.lacks(key) for key in schema.required):
        raise SceneError(_with_origin(found, reading), name)
    scene = make(built_tables(schema, reading.given, reading.tables))
    if check is not None:
        found += _further_problems(scene, check, found)
    if found:
        raise SceneError(_with_origin(found, reading), name)
    return scene


def _with_origin(problems: Sequence[Problem], reading: Reading) -> list[Problem]:
    """The problems, those of defaults marked."""
    rules = reading.schema.rules
    return [replace(p, default=p.field in rules and not reading.has(p.field)) for p in problems]


def _with_defaults(reading: Reading, schema: Schema) -> Table:
    """Every value that is known: given, default or derived; None for the control point when there is none."""
    values = reading.given | {key: default for key, default in schema.defaults.items() if reading.lacks(key)}
    for name, derived in schema.derived.items():
        needs = [f"gear_pair.{need}" for need in derived.needs]
        if reading.lacks(f"gear_pair.{name}") and all(need in values for need in needs):
            values[f"gear_pair.{name}"] = derived.formula(*(values[need] for need in needs))
    if reading.lacks("wear.worn_bodies"):
        # where no coefficient is known, that is the problem
        coefficient, mapping = values.get("wear.coefficient_mm2_per_N"), values.get("numerics.wear_mapping")
        values["wear.worn_bodies"] = default_worn_bodies(schema.pair.both_wear, coefficient, mapping)
    if reading.lacks("wear.control_point"):
        values |= dict.fromkeys(schema.fields_of("wear.control_point"))
    return values


def _further_problems(
    scene: SceneT, check: Callable[[SceneT], Sequence[Problem]], found: Sequence[Problem]
) -> list[Problem]:
    """Problems that the caller's checker adds; a field already reported is not reported twice."""
    try:
        further = list(check(scene))
    except SceneError as error:
        further = list(error.problems)
    except Exception:
        # A scene already found wrong may be beyond what the checker can compute; a sound one may not.
        if not found:
            raise
        further = []
    reported = {problem.field for problem in found}
    return [problem for problem in further if problem.field not in reported]
