"""Defaults that follow from other fields of a gear pair: of face gears, and those common to several kinds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import atan, cos, pi, radians, sin, sqrt, tan


@dataclass(frozen=True)
class DerivedDefault:
    """A default computed from other fields.

    Attributes
    ----------
    needs : tuple of str
        Field names of the gear pair that the formula takes, in order.
    formula : callable
        Function of those values that returns the default.
    """

    needs: tuple[str, ...]
    formula: Callable[..., float]


def rounded(length: float) -> float:
    """The length rounded to 12 digits, without binary noise."""
    return float(f"{length:.12g}")


def modules(factor: float, name: str = "module_mm") -> DerivedDefault:
    """Default proportional to the module."""
    return DerivedDefault((name,), lambda module_mm: rounded(factor * module_mm))


def face_centre(inner_mm: float, outer_mm: float) -> float:
    """Middle of the gear's radii [mm]."""
    return 0.5 * (inner_mm + outer_mm)


DEBURRED = 0.2  # mm, usual edge radius at a usual module
USUAL_MODULE = 6.35  # mm; at this module and 25 teeth defaults are round numbers


def bore_radius(module_mm: float, pinion_teeth: int) -> float:
    """0.63 pitch radii [mm]."""
    return rounded(50.0 / (USUAL_MODULE * 25) * module_mm * pinion_teeth)


def full_round_radius(module: float, alpha_deg: float, rack_addendum: float) -> float:
    """Radius of the full rounding of a rack's crest [mm]; negative if its flanks cross below the crest."""
    alpha = radians(alpha_deg)
    return (0.25 * pi * module - rack_addendum * tan(alpha)) * cos(alpha) / (1.0 - sin(alpha))


_ALMOST_FULL = 0.999  # of the full rounding of a crest, so that rounding errors do not matter


def rack_tip_radius(module_mm: float, pressure_angle_deg: float, rack_addendum_mm: float) -> float:
    """0.3 modules, or the full rounding of the rack's crest if that is less [mm]."""
    full = full_round_radius(module_mm, pressure_angle_deg, rack_addendum_mm)
    return rounded(min(0.3 * module_mm, max(_ALMOST_FULL * full, 0.0)))


def shaper_tip_radius(
    module_mm: float, pressure_angle_deg: float, shaper_teeth: int, shaper_addendum_mm: float
) -> float:
    """0.2 modules, or the full rounding of the shaper's crest if that is less [mm].

    The arc of a full rounding has its centre on the middle of the tooth at the crest radius less its own radius, and
    an involute offset inwards by a distance is the same involute turned by that distance over the base radius.
    """
    alpha = radians(pressure_angle_deg)
    pitch = 0.5 * module_mm * shaper_teeth
    base, crest = pitch * cos(alpha), pitch + shaper_addendum_mm
    half_base_angle = pi / (2 * shaper_teeth) + tan(alpha) - alpha
    full = 0.0
    for _ in range(60):  # the error falls by the sine of the pressure angle at the crest in every iteration
        roll = sqrt(max(((crest - full) / base) ** 2 - 1.0, 0.0))
        full = min(max(base * (half_base_angle - roll + atan(roll)), 0.0), crest - base)
    return rounded(min(0.2 * module_mm, _ALMOST_FULL * full))
