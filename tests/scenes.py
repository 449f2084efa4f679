"""Small scenes that tests share: grids from the coarsest on, and the shipped face gear with teeth that are rigid.

A test says what it needs beyond a grid; where an answer does not depend on the grid, `TINY` is enough.
"""

from collections.abc import Callable, Mapping
from typing import Any

import pytest

import semiwear as sw
from semiwear.errors import Problem
from semiwear.scene import Scene


def _grid(face_slices: int, roll_positions: int, profile_points: int, harmonics: int) -> dict[str, Any]:
    return {
        "numerics.face_slices": face_slices,
        "numerics.roll_positions": roll_positions,
        "numerics.profile_points": profile_points,
        "numerics.harmonics": harmonics,
    }


TINY = _grid(11, 8, 31, 3)
SMALL = _grid(15, 8, 41, 5)
MEDIUM = _grid(21, 12, 61, 9)
COARSE = _grid(31, 12, 101, 9)

SHIPPED = sw.load_scene("face_gear_25x160")
NOMINAL_TORQUE = SHIPPED.operation.pinion_torque_Nm
RIGID = _grid(21, 8, 41, 5) | {"numerics.cells_per_half_width": 3, "numerics.tooth_compliance": "rigid"}
"""Teeth that do not bend, so that a hard case takes a fraction of a second."""

UNTIL_MESHES: dict[str, Any] = {"wear.until.control_depths_um": None, "wear.control_point": None}
SHARP = {f"gear_pair.{body}_{edge}_edge_radius_mm": 0.0 for body in ("pinion", "gear") for edge in ("tip", "end")}
# One tooth more than the pinion's: the shaper is too small for its usual tip rounding.
CONFORMAL: dict[str, Any] = {"gear_pair.shaper_teeth": 26, "gear_pair.shaper_tip_radius_mm": 1.0}


def scene_of(*changes: Mapping[str, Any], wears: bool = False) -> Scene:
    """The shipped face gear with rigid teeth, changed; without a table [wear] unless it `wears`."""
    merged: dict[str, Any] = dict(RIGID) if wears else {"wear": None} | RIGID
    for more in changes:
        merged |= more
    return SHIPPED.replace(merged)


def one_rigid_tooth(scene: Scene, slices: int) -> Scene:
    """All of 1600 N m on one tooth that does not bend: its contact is nearly Hertz's ellipse."""
    return scene.replace(
        {
            "wear": None,
            "numerics.tooth_compliance": "rigid",
            "numerics.tooth_pairs": 1,
            "numerics.face_slices": slices,
            "operation.pinion_torque_Nm": 1600.0,
        }
    )


class Heard:
    """A progress that keeps what it hears."""

    def __init__(self) -> None:
        self.steps: list[tuple[int, int, str]] = []

    def step(self, done: int, total: int, text: str) -> None:
        self.steps.append((done, total, text))


def problems_of(make: Callable[..., object], *arguments: Any, **options: Any) -> dict[str, Problem]:
    """Problems by field of a scene that is refused: none is told twice, each with what is allowed and a way out."""
    with pytest.raises(sw.SceneError) as caught:
        make(*arguments, **options)
    by_field = {problem.field: problem for problem in caught.value.problems}
    assert len(by_field) == len(caught.value.problems), f"a field is told twice: {caught.value}"
    assert all(problem.allowed and problem.fix for problem in by_field.values()), caught.value
    return by_field
