"""Rules of a gear pair whose flanks are given as points: of each field by itself, and across fields."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import hypot
from typing import Any

from semiwear.errors import Problem
from semiwear.scene.across import RuleBook, across
from semiwear.scene.rule import Rule, advice, between, choice
from semiwear.scene.values import Unreadable, number, numbers, text, whole

__all__ = ["FLANK_POINTS_CROSS_RULES", "FLANK_POINTS_RULES"]

FLANK_POINTS_CROSS_RULES: RuleBook = []
_across = partial(across, FLANK_POINTS_CROSS_RULES)

_SUFFIXES = (".nc", ".csv")
_EDGE = '0 for a sharp edge; "auto" is 0.044 normal modules'
_PARALLEL = 1e-9


def _number_or_auto(raw: Any) -> float | str:
    if isinstance(raw, str):
        if raw != "auto":
            raise Unreadable('give "auto", or a number without quotes')
        return raw
    return number(raw)


def _length_or_auto(fix: str) -> Rule:
    return Rule(
        _number_or_auto, '"auto" or greater than 0 mm', lambda value: value == "auto" or value > 0.0, advice(fix)
    )


def _radius_or_auto() -> Rule:
    def holds(value: float | str) -> bool:
        return value == "auto" or float(value) >= 0.0

    return Rule(_number_or_auto, '"auto", 0 mm or greater', holds, advice(_EDGE))


def _file() -> Rule:
    fix = "name a file that export_flank or write_points made; its name ends with .nc or .csv"

    def is_points(path: str) -> bool:
        return path.casefold().endswith(_SUFFIXES)

    return Rule(text, "a .nc or .csv file of points", is_points, advice(fix), is_points)


def _vector(fix: str, unit: str) -> Rule:
    return Rule(numbers, f"three numbers{unit}", lambda value: len(value) == 3, advice(fix))


def _direction() -> Rule:
    fix = "give the direction of the body's own z axis in the fixed frame, e.g. [0, 0, 1]"
    return Rule(
        numbers, "three numbers, not all 0", lambda value: len(value) == 3 and hypot(*value) > 0.0, advice(fix)
    )


_THICKNESS = 'in the normal section, at the pitch surface; "auto" is half the pitch'
_FILLET = 'the arc between flank and root; "auto" is 0.3 normal modules'
_DEPTH = 'from the lower end of the flank to the root; "auto" is what the fillet takes'
_RIM = 'material under the root; "auto" is 2.5 normal modules'
_TEETH = "count the teeth of the whole body; of a worm its threads"
_POINT = "where the origin of the body's own frame lies in the fixed frame"

FLANK_POINTS_RULES: dict[str, Rule] = {
    f"gear_pair.{name}": rule
    for name, rule in {
        "pinion_file": _file(),
        "gear_file": _file(),
        "pinion_teeth": between(whole, 1, 1000, _TEETH),
        "gear_teeth": between(whole, 2, 1000, _TEETH),
        "pinion_axis_point_mm": _vector(_POINT, " of mm"),
        "pinion_axis_direction": _direction(),
        "gear_axis_point_mm": _vector(_POINT, " of mm"),
        "gear_axis_direction": _direction(),
        "pinion_rotation": choice("positive", "negative"),
        "gear_rotation": choice("positive", "negative"),
        "smoothing_um": Rule(
            _number_or_auto,
            '"auto" or 0 um to 100 um',
            lambda value: value == "auto" or 0.0 <= value <= 100.0,
            advice("the noise of the points: 0 for none, 0.5 to 3 for measured flanks"),
        ),
        "pinion_tooth_thickness_mm": _length_or_auto(_THICKNESS),
        "gear_tooth_thickness_mm": _length_or_auto(_THICKNESS),
        "pinion_fillet_radius_mm": _length_or_auto(_FILLET),
        "gear_fillet_radius_mm": _length_or_auto(_FILLET),
        "pinion_root_depth_mm": _length_or_auto(_DEPTH),
        "gear_root_depth_mm": _length_or_auto(_DEPTH),
        "pinion_rim_thickness_mm": _length_or_auto(_RIM),
        "gear_rim_thickness_mm": _length_or_auto(_RIM),
        "pinion_tip_edge_radius_mm": _radius_or_auto(),
        "gear_tip_edge_radius_mm": _radius_or_auto(),
        "pinion_end_edge_radius_mm": _radius_or_auto(),
        "gear_end_edge_radius_mm": _radius_or_auto(),
    }.items()
} | {
    "wear.control_point.face_mm": Rule(
        number, "a number of mm", lambda value: True, advice("the face coordinate of the gear's points")
    ),
    "wear.control_point.height_mm": Rule(
        number, "a number of mm", lambda value: True, advice("above the pitch surface, negative on the dedendum")
    ),
    "wear.control_point.body": choice("pinion", "gear"),
}


@_across("gear_pair", "pinion_axis_point_mm", "pinion_axis_direction", "gear_axis_point_mm", "gear_axis_direction")
def _axes_differ(
    pinion_point: tuple[float, ...],
    pinion_direction: tuple[float, ...],
    gear_point: tuple[float, ...],
    gear_direction: tuple[float, ...],
) -> Iterator[Problem]:
    def crossed(a: tuple[float, ...], b: tuple[float, ...]) -> float:
        return hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])

    size = hypot(*pinion_direction)
    between_points = tuple(g - p for g, p in zip(gear_point, pinion_point, strict=True))
    parallel = crossed(pinion_direction, gear_direction) <= _PARALLEL * size * hypot(*gear_direction)
    if parallel and crossed(pinion_direction, between_points) <= _PARALLEL * size * max(hypot(*between_points), 1.0):
        fix = "give where the gear's axis lies: parallel axes need a centre distance"
        yield Problem("gear_pair.gear_axis_point_mm", list(gear_point), "an axis of its own: both are the same", fix)


@_across("operation", "loaded_flank", "gear_pair.pinion_file")
def _the_given_flank_is_loaded(loaded: str, file: str) -> Iterator[Problem]:
    if loaded == "coast":
        fix = "only one flank of each body is given: give the files of the coast flanks, and turn both rotations"
        yield Problem("operation.loaded_flank", loaded, '"drive", for flanks given as points', fix)
