"""Rules over several fields of a gear pair with flanks given as points."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import hypot

from semiwear.errors import Problem
from semiwear.scene.across import RuleBook, across

FLANK_POINTS_CROSS_RULES: RuleBook = []
_across = partial(across, FLANK_POINTS_CROSS_RULES)

_PARALLEL = 1e-9


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
        fix = "give a point on the gear's axis: parallel axes need a centre distance"
        yield Problem("gear_pair.gear_axis_point_mm", list(gear_point), "an axis of its own: both are the same", fix)


@_across("operation", "loaded_flank", "gear_pair.pinion_file")
def _the_given_flank_is_loaded(loaded: str, file: str) -> Iterator[Problem]:
    if loaded == "coast":
        fix = "only one flank of each body is given: give the files of the coast flanks, and turn both rotations"
        yield Problem("operation.loaded_flank", loaded, '"drive", for flanks given as points', fix)
