"""A cylindrical gear pair: table ``[gear_pair]`` with ``type = "cylindrical"``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import acos, atan, ceil, cos, hypot, nan, radians, sin, tan
from typing import ClassVar, cast

from semiwear.scene.defaults import EDGE_RADIUS_FIELDS, DerivedDefault, edge_radius_of, filled_in, full_round_radius

__all__ = ["CYLINDRICAL_DEFAULTS", "CylindricalControlPoint", "CylindricalPair", "edge_radius"]

edge_radius = edge_radius_of(4.5)

# Replaced by a number in `CylindricalPair.__post_init__`: no reader of a pair ever meets None.
_DERIVED = cast(float, None)

_NEWTON_PASSES = 30


def _digits(length: float) -> float:
    """Free of binary noise in the last digits."""
    return float(f"{length:.12g}")


def _angle_of_involute(value: float) -> float:
    """Angle whose involute function is `value` [rad]; nan where there is none."""
    if not value >= 0.0:
        return nan
    angle = min((3.0 * value) ** (1.0 / 3.0), 1.4)
    for _ in range(_NEWTON_PASSES):
        slope = tan(angle) ** 2
        if slope == 0.0:
            break
        angle = min(max(angle - (tan(angle) - angle - value) / slope, 1e-9), 1.5)
    return float(angle)


def _transverse(pressure_angle_deg: float, helix_angle_deg: float) -> float:
    """Transverse pressure angle [rad]."""
    return atan(tan(radians(pressure_angle_deg)) / cos(radians(helix_angle_deg)))


def zero_backlash_distance(
    module: float, alpha_deg: float, beta_deg: float, z1: int, z2: int, x1: float, x2: float
) -> float:
    """Centre distance without backlash [mm], positive (ISO 21771, 5.4); nan where there is none."""
    alpha = _transverse(alpha_deg, beta_deg)
    teeth = z1 + z2
    if teeth == 0:
        return nan
    working = _angle_of_involute(tan(alpha) - alpha + 2.0 * (x1 + x2) / teeth * tan(radians(alpha_deg)))
    return abs(_digits(0.5 * module * teeth / cos(radians(beta_deg)) * cos(alpha) / cos(working)))


def _tip_shortening(module: float, beta_deg: float, z1: int, z2: int, x1: float, x2: float, distance: float) -> float:
    """By how much the tips of external gears are lowered so that both keep their bottom clearance [mm]."""
    if z2 < 0:
        return 0.0
    return max(0.5 * module * (z1 + z2) / cos(radians(beta_deg)) + module * (x1 + x2) - distance, 0.0)


def _pinion_tip(module: float, beta_deg: float, z1: int, z2: int, x1: float, x2: float, distance: float) -> float:
    shortened = _tip_shortening(module, beta_deg, z1, z2, x1, x2, distance)
    return _digits(module * z1 / cos(radians(beta_deg)) + 2.0 * (module * (1.0 + x1) - shortened))


def _gear_tip(
    module: float, beta_deg: float, z1: int, z2: int, x1: float, x2: float, distance: float,
    alpha_deg: float, rack_addendum: float, rack_tip_radius: float,
) -> float:  # fmt: skip
    shortened = _tip_shortening(module, beta_deg, z1, z2, x1, x2, distance)
    tip = abs(_digits(module * z2 / cos(radians(beta_deg)) + 2.0 * (module * (1.0 + x2) - shortened)))
    if z2 > 0:
        return tip
    # the tip of an internal gear reaches deeper than a rack: it must not pass the end of the pinion's involute
    alpha, per_tooth = _transverse(alpha_deg, beta_deg), 0.5 * module / cos(radians(beta_deg))
    base_1, base_2 = per_tooth * z1 * cos(alpha), -per_tooth * z2 * cos(alpha)
    cosine = (base_2 - base_1) / distance
    if not 0.0 < cosine <= 1.0:
        return tip
    depth = rack_addendum - x1 * module - rack_tip_radius * (1.0 - sin(radians(alpha_deg)))
    form = max(base_1 * tan(alpha) - depth / sin(alpha), 0.0)
    along = form + (base_2 - base_1) * tan(acos(cosine))
    # to a ten-thousandth of a module, outwards
    return max(tip, _digits(1e-4 * module * ceil(2e4 * hypot(base_2, along) / module)))


def _rack_addendum(module: float) -> float:
    return _digits(1.25 * module)


def _rack_tip_radius(module: float, alpha_deg: float, rack_addendum: float, z2: int = 1) -> float:
    if z2 < 0:
        return _digits(0.3 * module)  # an arc: the tooth space of an internal gear narrows faster than a rack's
    # 0.38 of ISO 53, profile A, where the crest is wide enough; the last digit rounded down.
    full = full_round_radius(module, alpha_deg, rack_addendum)
    return _digits(min(0.38 * module, max(0.999 * full, 0.0)))


def _bore_radius(module: float, beta_deg: float, z1: int) -> float:
    return _digits(0.63 * 0.5 * module * z1 / cos(radians(beta_deg)))


def _rim_thickness(module: float, beta_deg: float, z2: int, x2: float, rack_addendum: float) -> float:
    if z2 < 0:
        return _digits(2.5 * module)
    reference = 0.5 * module * z2 / cos(radians(beta_deg))
    return _digits(0.37 * reference - rack_addendum + x2 * module)


def _same(width: float) -> float:
    return width


_PAIR = ("helix_angle_deg", "pinion_teeth", "gear_teeth", "pinion_profile_shift", "gear_profile_shift")


def _default(formula: Callable[..., float], *needs: str) -> DerivedDefault:
    return DerivedDefault(needs, formula)


CYLINDRICAL_DEFAULTS: dict[str, DerivedDefault] = {
    "centre_distance_mm": _default(zero_backlash_distance, "normal_module_mm", "pressure_angle_deg", *_PAIR),
    "gear_face_width_mm": _default(_same, "pinion_face_width_mm"),
    "pinion_rack_addendum_mm": _default(_rack_addendum, "normal_module_mm"),
    "gear_rack_addendum_mm": _default(_rack_addendum, "normal_module_mm"),
    "pinion_rack_tip_radius_mm": _default(
        _rack_tip_radius, "normal_module_mm", "pressure_angle_deg", "pinion_rack_addendum_mm"
    ),
    "gear_rack_tip_radius_mm": _default(
        _rack_tip_radius, "normal_module_mm", "pressure_angle_deg", "gear_rack_addendum_mm", "gear_teeth"
    ),
    "pinion_tip_diameter_mm": _default(_pinion_tip, "normal_module_mm", *_PAIR, "centre_distance_mm"),
    "gear_tip_diameter_mm": _default(
        _gear_tip,
        "normal_module_mm",
        *_PAIR,
        "centre_distance_mm",
        "pressure_angle_deg",
        "pinion_rack_addendum_mm",
        "pinion_rack_tip_radius_mm",
    ),
    **{name: _default(edge_radius, "normal_module_mm") for name in EDGE_RADIUS_FIELDS},
    "pinion_bore_radius_mm": _default(_bore_radius, "normal_module_mm", "helix_angle_deg", "pinion_teeth"),
    "gear_rim_thickness_mm": _default(
        _rim_thickness,
        "normal_module_mm",
        "helix_angle_deg",
        "gear_teeth",
        "gear_profile_shift",
        "gear_rack_addendum_mm",
    ),
}


@dataclass(frozen=True, kw_only=True)
class CylindricalPair:
    """Table ``[gear_pair]``: an involute spur or helical pinion and its gear, external or internal.

    Terms and signs of ISO 21771: the number of teeth of an internal gear is negative, and a positive profile shift
    makes a tooth thicker, inside as outside. Lengths are positive. Fields without a default are required.

    Attributes
    ----------
    type : str
        Kind of gear pair: ``"cylindrical"``.
    pinion_teeth, gear_teeth : int
        Numbers of teeth; `gear_teeth` is negative for an internal gear.
    normal_module_mm : float
        Normal module m_n.
    pressure_angle_deg : float
        Normal pressure angle.
    pinion_face_width_mm, gear_face_width_mm : float
        Face widths. Default of the gear: the pinion's.
    helix_angle_deg : float
        Helix angle at the reference cylinder. Default 0: spur teeth.
    hand : str
        Hand of the pinion's helix, ``"right"`` (default) or ``"left"``; an external gear has the other one.
    pinion_profile_shift, gear_profile_shift : float
        Profile shift coefficients. Default 0.
    centre_distance_mm : float
        Default: without backlash.
    face_offset_mm : float
        Middle of the pinion's face width, from that of the gear, along the axis. Default 0.
    pinion_tip_diameter_mm, gear_tip_diameter_mm : float
        Default: addendum 1 m_n and the profile shift, less the tip shortening that keeps the bottom clearance; of an
        internal gear less what would reach the pinion's fillet.
    pinion_rack_addendum_mm, gear_rack_addendum_mm : float
        Dedendum before profile shift. Default 1.25 m_n.
    pinion_rack_tip_radius_mm, gear_rack_tip_radius_mm : float
        Tip rounding of the generating rack; of an internal gear the arc that is its fillet. Default 0.38 m_n, or
        what the rack's crest has room for; 0.3 m_n for that arc.
    pinion_tip_edge_radius_mm, gear_tip_edge_radius_mm : float
        Edge rounding between flank and tip. Default 0.0444 m_n: 0.2 at a module of 4.5.
    pinion_end_edge_radius_mm, gear_end_edge_radius_mm : float
        Edge rounding between flank and end faces. Default 0.0444 m_n: 0.2 at a module of 4.5.
    pinion_bore_radius_mm : float
        Radius of the pinion's bore, where it is held. Default 0.63 reference radii.
    gear_rim_thickness_mm : float
        Material between the gear's root and where it is held: its bore, or outside an internal gear. Default: down
        to 0.63 reference radii, or 2.5 m_n for an internal gear.
    """

    references: ClassVar[tuple[str, ...]] = ("ISO 21771:2007, Cylindrical involute gears: concepts and geometry",)

    type: str
    pinion_teeth: int
    gear_teeth: int
    normal_module_mm: float
    pressure_angle_deg: float
    pinion_face_width_mm: float
    gear_face_width_mm: float = _DERIVED
    helix_angle_deg: float = 0.0
    hand: str = "right"
    pinion_profile_shift: float = 0.0
    gear_profile_shift: float = 0.0
    centre_distance_mm: float = _DERIVED
    face_offset_mm: float = 0.0
    pinion_tip_diameter_mm: float = _DERIVED
    gear_tip_diameter_mm: float = _DERIVED
    pinion_rack_addendum_mm: float = _DERIVED
    gear_rack_addendum_mm: float = _DERIVED
    pinion_rack_tip_radius_mm: float = _DERIVED
    gear_rack_tip_radius_mm: float = _DERIVED
    pinion_tip_edge_radius_mm: float = _DERIVED
    gear_tip_edge_radius_mm: float = _DERIVED
    pinion_end_edge_radius_mm: float = _DERIVED
    gear_end_edge_radius_mm: float = _DERIVED
    pinion_bore_radius_mm: float = _DERIVED
    gear_rim_thickness_mm: float = _DERIVED
    # Which fields were left to their derived default.
    _derived: frozenset[str] = field(init=False, repr=False, compare=False, default=frozenset())

    def __post_init__(self) -> None:
        object.__setattr__(self, "_derived", filled_in(self, CYLINDRICAL_DEFAULTS))

    @property
    def internal(self) -> bool:
        """Whether the gear's teeth point to its axis."""
        return self.gear_teeth < 0

    @property
    def working_pressure_angle(self) -> float:
        """Transverse working pressure angle from the centre distance [rad]; nan inside the base circles."""
        beta = radians(self.helix_angle_deg)
        alpha = _transverse(self.pressure_angle_deg, self.helix_angle_deg)
        nominal = 0.5 * self.normal_module_mm * abs(self.pinion_teeth + self.gear_teeth) / cos(beta)
        cosine = nominal * cos(alpha) / self.centre_distance_mm
        return acos(cosine) if 0.0 < cosine <= 1.0 else nan

    @property
    def normal_per_arc(self) -> float:
        """Normal distance between flanks per arc of the reference circle, cos(alpha_n) cos(beta)."""
        return cos(radians(self.pressure_angle_deg)) * cos(radians(self.helix_angle_deg))

    @property
    def description(self) -> str:
        """What it is, in a few words."""
        teeth = "helical" if self.helix_angle_deg else "spur"
        shifts = f"profile shifts {self.pinion_profile_shift:g}, {self.gear_profile_shift:g}"
        where = "internal " if self.internal else ""
        return f"{where}{teeth} gears {self.pinion_teeth}/{abs(self.gear_teeth)}, {shifts}"


@dataclass(frozen=True, kw_only=True)
class CylindricalControlPoint:
    """Table ``[wear.control_point]`` of cylindrical gears: the point of a flank whose wear depth is watched.

    Attributes
    ----------
    face_mm : float
        Distance from the middle of the gear's face width, along the axis.
    height_mm : float
        Height above the working pitch cylinder, towards the tip; negative on the dedendum.
    body : str or None
        ``"pinion"`` or ``"gear"``. Default None: the gear if it wears, else the pinion.
    """

    face_mm: float
    height_mm: float
    body: str | None = None

    @property
    def station_mm(self) -> float:
        """Face coordinate of the flanks [mm]."""
        return self.face_mm
