"""Position of the pinion relative to its nominal position: mounting errors."""

from __future__ import annotations

from dataclasses import dataclass, fields

from semiwear.errors import Problem, SceneError
from semiwear.scene.values import Unreadable, number, shown


@dataclass(frozen=True)
class Placement:
    """A rigid displacement of the pinion from its nominal position; the default is perfect alignment.

    Translations are along the axes of the fixed frame, rotations about axes through the pitch point. For a face gear
    pair the origin is the intersection of the gear's axis, y, and the shaper's, z; the gear's teeth point to +y, and
    the pinion's axis is parallel to z, displaced towards -y by half the module times the difference of the shaper's
    and the pinion's numbers of teeth. For a cylindrical pair both axes are along z, and the gear lies below the
    pinion, towards -y: a motion along +y increases the centre distance of an external pair, the shaft angle error
    inclines the axes in their common plane, and the slope inclines them out of that plane.

    Attributes
    ----------
    offset_mm : float
        The pinion's motion along +x. Default 0.
    axial_pinion_mm : float
        The pinion's motion along +z, its own axis. Default 0.
    axial_gear_mm : float
        The pinion's motion along +y, away from the gear. Default 0.
    shaft_angle_error_mrad : float
        The pinion's rotation about +x. Default 0.
    pinion_slope_mrad : float
        The pinion's rotation about +y. Default 0.

    Raises
    ------
    SceneError
        For anything but finite numbers.
    """

    offset_mm: float = 0.0
    axial_pinion_mm: float = 0.0
    axial_gear_mm: float = 0.0
    shaft_angle_error_mrad: float = 0.0
    pinion_slope_mrad: float = 0.0

    def __post_init__(self) -> None:
        problems = []
        for entry in fields(self):
            raw = getattr(self, entry.name)
            try:
                object.__setattr__(self, entry.name, number(raw))
            except Unreadable as reason:
                key = f"placement.{entry.name}"
                problems.append(Problem(key, shown(raw), "a finite number", str(reason)))
        if problems:
            raise SceneError(problems, "placement")

    @property
    def is_aligned(self) -> bool:
        """Whether the pinion is exactly in its nominal position."""
        return self == Placement()
