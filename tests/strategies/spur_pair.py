"""Involute spur pairs by the formulas of ISO 21771, for tests that compute by hand."""

from dataclasses import dataclass
from functools import cached_property
from math import acos, cos, pi, radians, sin, sqrt, tan


@dataclass(frozen=True)
class SpurPair:
    """Base circles and path of contact of an external pair with a pressure angle of 20 degrees; lengths in mm."""

    teeth: tuple[int, int]
    module: float
    centre_distance: float
    tip_radius: tuple[float, float]
    width: float = 20.0

    @cached_property
    def base_radius(self) -> tuple[float, float]:
        first, second = (0.5 * z * self.module * cos(radians(20.0)) for z in self.teeth)
        return first, second

    @cached_property
    def base_pitch(self) -> float:
        return 2.0 * pi * self.base_radius[0] / self.teeth[0]

    @cached_property
    def working_angle(self) -> float:
        return acos(sum(self.base_radius) / self.centre_distance)

    @cached_property
    def action(self) -> float:
        """Length of the line of action between the base circles: sum of the radii of curvature."""
        return self.centre_distance * sin(self.working_angle)

    @cached_property
    def pitch_curvature(self) -> tuple[float, float]:
        """Radii of curvature at the pitch point."""
        first, second = (base * tan(self.working_angle) for base in self.base_radius)
        return first, second

    @cached_property
    def tip_curvature(self) -> tuple[float, float]:
        """Radii of curvature at the tips."""
        first, second = (sqrt(tip**2 - b**2) for tip, b in zip(self.tip_radius, self.base_radius, strict=True))
        return first, second

    @cached_property
    def addendum_ratios(self) -> tuple[float, float]:
        """eps_1 and eps_2: parts of the contact ratio that the pinion's and the gear's addendum give."""
        first, second = (
            (tip - pitch) / self.base_pitch
            for tip, pitch in zip(self.tip_curvature, self.pitch_curvature, strict=True)
        )
        return first, second


C_GF = SpurPair((16, 24), 4.5, 91.5, (41.23, 59.18), 14.0)
"""Test gears of the FZG micropitting test."""
