"""A cylindrical gear pair: table ``[gear_pair]`` with ``type = "cylindrical"``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field, replace
from math import acos, atan, ceil, cos, degrees, hypot, nan, radians, sin, tan
from typing import ClassVar

from semiwear.scene.declare import declared, filled_in, table
from semiwear.scene.defaults import DEBURRED, DerivedDefault, full_round_radius, modules, rounded
from semiwear.scene.rule import Rule, angle, any_number, at_least_zero, between, choice, positive
from semiwear.scene.rules import watched_body
from semiwear.scene.values import number, whole
from semiwear.untyped import Value

EDGE_RADIUS = modules(DEBURRED / 4.5, "normal_module_mm")
_NEWTON_ITERATIONS = 30


def _angle_of_involute(value: float) -> float:
    """Angle whose involute function is `value` [rad]; nan if there is none."""
    if not value >= 0.0:
        return nan
    angle = min((3.0 * value) ** (1.0 / 3.0), 1.4)
    for _ in range(_NEWTON_ITERATIONS):
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
    """Centre distance without backlash [mm], positive (ISO 21771, 5.4); nan if there is none."""
    alpha = _transverse(alpha_deg, beta_deg)
    teeth = z1 + z2
    if teeth == 0:
        return nan
    working = _angle_of_involute(tan(alpha) - alpha + 2.0 * (x1 + x2) / teeth * tan(radians(alpha_deg)))
    return abs(rounded(0.5 * module * teeth / cos(radians(beta_deg)) * cos(alpha) / cos(working)))


def _tip_shortening(module: float, beta_deg: float, z1: int, z2: int, x1: float, x2: float, distance: float) -> float:
    """Tip shortening of external gears that keeps the bottom clearance of both [mm]; 0 for internal gears."""
    if z2 < 0:
        return 0.0
    return max(0.5 * module * (z1 + z2) / cos(radians(beta_deg)) + module * (x1 + x2) - distance, 0.0)


def _pinion_tip(module: float, beta_deg: float, z1: int, z2: int, x1: float, x2: float, distance: float) -> float:
    shortened = _tip_shortening(module, beta_deg, z1, z2, x1, x2, distance)
    return rounded(module * z1 / cos(radians(beta_deg)) + 2.0 * (module * (1.0 + x1) - shortened))


def _gear_tip(
    module: float, beta_deg: float, z1: int, z2: int, x1: float, x2: float, distance: float,
    alpha_deg: float, rack_addendum: float, rack_tip_radius: float,
) -> float:  # fmt: skip
    shortened = _tip_shortening(module, beta_deg, z1, z2, x1, x2, distance)
    tip = abs(rounded(module * z2 / cos(radians(beta_deg)) + 2.0 * (module * (1.0 + x2) - shortened)))
    if z2 > 0:
        return tip
    # the tip of an internal gear reaches deeper than a rack, but not beyond the end of the pinion's involute
    alpha, per_tooth = _transverse(alpha_deg, beta_deg), 0.5 * module / cos(radians(beta_deg))
    base_1, base_2 = per_tooth * z1 * cos(alpha), -per_tooth * z2 * cos(alpha)
    cosine = (base_2 - base_1) / distance
    if not 0.0 < cosine <= 1.0:
        return tip
    depth = rack_addendum - x1 * module - rack_tip_radius * (1.0 - sin(radians(alpha_deg)))
    form = max(base_1 * tan(alpha) - depth / sin(alpha), 0.0)
    along = form + (base_2 - base_1) * tan(acos(cosine))
    # rounded outwards to a ten-thousandth of a module
    return max(tip, rounded(1e-4 * module * ceil(2e4 * hypot(base_2, along) / module)))


def _rack_tip_radius(module: float, alpha_deg: float, rack_addendum: float, z2: int = 1) -> float:
    if z2 < 0:
        return rounded(0.3 * module)  # less, since the tooth space of an internal gear narrows faster than a rack's
    # 0.38 modules as in ISO 53, profile A, if the crest is wide enough; the last digit rounded down
    full = full_round_radius(module, alpha_deg, rack_addendum)
    return rounded(min(0.38 * module, max(0.999 * full, 0.0)))


def _bore_radius(module: float, beta_deg: float, z1: int) -> float:
    return rounded(0.63 * 0.5 * module * z1 / cos(radians(beta_deg)))


def _rim_thickness(module: float, beta_deg: float, z2: int, x2: float, rack_addendum: float) -> float:
    if z2 < 0:
        return rounded(2.5 * module)
    reference = 0.5 * module * z2 / cos(radians(beta_deg))
    return rounded(0.37 * reference - rack_addendum + x2 * module)


_RADIANS = 0.8  # degrees: so little helix is likelier an angle of up to 45 degrees in radians
_PAIR = ("helix_angle_deg", "pinion_teeth", "gear_teeth", "pinion_profile_shift", "gear_profile_shift")


def _default(formula: Callable[..., float], *needs: str) -> DerivedDefault:
    return DerivedDefault(needs, formula)


_LENGTH = "a length, or leave the field out for its default"
_EDGE = "give 0 for a sharp edge, or leave the field out for a deburred one"
_CUTTER_TIP = "leave the field out for its default, 0.38 modules"
_TEETH = (12, 300)


def _gear_teeth() -> Rule:
    least, most = _TEETH
    fix = "count the teeth of the whole gear; an internal gear's number is negative (ISO 21771)"
    allowed = f"whole number, {least} to {most}, or {-most} to {-least} for an internal gear"
    return Rule(whole, allowed, lambda teeth: least <= abs(teeth) <= most, fix)


def _profile_shift(body: str) -> Value:
    rule = between(number, -2.0, 2.0, "in modules: the shift divided by the normal module, -0.5 to 1 is usual")
    return declared(rule, f"Profile shift coefficient of the {body}.", default=0.0)


def _dedendum(body: str) -> Value:
    meaning = f"Dedendum of the {body} before profile shift; left out: 1.25 m_n."
    return declared(positive(_LENGTH), meaning, derived=modules(1.25, "normal_module_mm"))


def _edge_radius(body: str, border: str) -> Value:
    meaning = f"Rounding between flank and {border} of the {body}; left out: 0.0444 m_n, 0.2 at a module of 4.5."
    return declared(at_least_zero(_EDGE), meaning, derived=EDGE_RADIUS)


@table
class CylindricalPair:
    """Table ``[gear_pair]``: an involute spur or helical pinion and its gear, external or internal.

    Terms and signs of ISO 21771: the number of teeth of an internal gear is negative, and a positive profile shift
    makes a tooth thicker, inside as outside. Lengths are positive. Fields without a default are required.
    """

    pitch_surfaces: ClassVar[tuple[str, str, str]] = ("pitch cylinder", "pitch cylinder", "pitch cylinder")
    both_wear: ClassVar[bool] = True
    references: ClassVar[tuple[str, ...]] = ("ISO 21771:2007, Cylindrical involute gears: concepts and geometry",)

    type: str = declared(choice("cylindrical"), "Kind of gear pair.")
    pinion_teeth: int = declared(
        between(whole, *_TEETH, "count the teeth of the whole pinion"), "Number of teeth of the pinion."
    )
    gear_teeth: int = declared(_gear_teeth(), "Number of teeth of the gear; negative for an internal gear.")
    normal_module_mm: float = declared(
        positive("the module in the normal section, as of the tool"), "Normal module m_n."
    )
    pressure_angle_deg: float = declared(angle(10.0, 35.0, "in degrees: 20 is usual"), "Normal pressure angle.")
    pinion_face_width_mm: float = declared(
        positive("the length of the pinion's teeth along the axis"), "Face width of the pinion."
    )
    gear_face_width_mm: float = declared(
        positive(_LENGTH),
        "Face width of the gear; left out: the pinion's.",
        derived=_default(lambda width: width, "pinion_face_width_mm"),
    )
    helix_angle_deg: float = declared(
        between(number, 0.0, 45.0, 'without a sign: the hand is the field "hand"', "degrees"),
        "Helix angle at the reference cylinder; 0 is a spur gear.",
        default=0.0,
    )
    hand: str = declared(
        choice("right", "left"), "Hand of the pinion's helix; an external gear has the other one.", default="right"
    )
    pinion_profile_shift: float = _profile_shift("pinion")
    gear_profile_shift: float = _profile_shift("gear")
    centre_distance_mm: float = declared(
        positive("a positive length, of an internal gear as well"),
        "Centre distance; left out: without backlash.",
        derived=_default(zero_backlash_distance, "normal_module_mm", "pressure_angle_deg", *_PAIR),
    )
    face_offset_mm: float = declared(
        any_number("the pinion's middle from the gear's, along the axis"),
        "Middle of the pinion's face width, from that of the gear, along the axis.",
        default=0.0,
    )
    pinion_tip_diameter_mm: float = declared(
        positive(_LENGTH),
        "Tip diameter of the pinion; left out: addendum 1 m_n and the profile shift, less the tip shortening that "
        "keeps the bottom clearance.",
        derived=_default(_pinion_tip, "normal_module_mm", *_PAIR, "centre_distance_mm"),
    )
    gear_tip_diameter_mm: float = declared(
        positive(_LENGTH),
        "Tip diameter of the gear; left out: as for the pinion; of an internal gear at least so great that its tips "
        "do not reach the pinion's fillet.",
        derived=_default(
            _gear_tip,
            "normal_module_mm",
            *_PAIR,
            "centre_distance_mm",
            "pressure_angle_deg",
            "pinion_rack_addendum_mm",
            "pinion_rack_tip_radius_mm",
        ),
    )
    pinion_rack_addendum_mm: float = _dedendum("pinion")
    gear_rack_addendum_mm: float = _dedendum("gear")
    pinion_rack_tip_radius_mm: float = declared(
        at_least_zero(_CUTTER_TIP),
        "Tip rounding of the pinion's tool, which generates the fillet; left out: 0.38 m_n, or the full rounding of "
        "the crest if that is less.",
        derived=_default(_rack_tip_radius, "normal_module_mm", "pressure_angle_deg", "pinion_rack_addendum_mm"),
    )
    gear_rack_tip_radius_mm: float = declared(
        at_least_zero(_CUTTER_TIP),
        "Tip rounding of the gear's tool; of an internal gear the radius of the fillet. Left out: 0.38 m_n, or the "
        "full rounding of the crest if that is less; 0.3 m_n for an internal gear.",
        derived=_default(
            _rack_tip_radius, "normal_module_mm", "pressure_angle_deg", "gear_rack_addendum_mm", "gear_teeth"
        ),
    )
    pinion_tip_edge_radius_mm: float = _edge_radius("pinion", "tip")
    gear_tip_edge_radius_mm: float = _edge_radius("gear", "tip")
    pinion_end_edge_radius_mm: float = _edge_radius("pinion", "end faces")
    gear_end_edge_radius_mm: float = _edge_radius("gear", "end faces")
    pinion_bore_radius_mm: float = declared(
        positive(_LENGTH),
        "Radius of the pinion's bore, on which it is fixed; left out: 0.63 reference radii.",
        derived=_default(_bore_radius, "normal_module_mm", "helix_angle_deg", "pinion_teeth"),
    )
    gear_rim_thickness_mm: float = declared(
        positive(_LENGTH),
        "Rim thickness between the gear's root and its bore, on which it is fixed, or the outside of an internal "
        "gear; left out: down to 0.63 reference radii, or 2.5 m_n for an internal gear.",
        derived=_default(
            _rim_thickness,
            "normal_module_mm",
            "helix_angle_deg",
            "gear_teeth",
            "gear_profile_shift",
            "gear_rack_addendum_mm",
        ),
    )
    # fields that have their derived default
    _derived: frozenset[str] = field(init=False, repr=False, compare=False, default=frozenset())

    def __post_init__(self) -> None:
        object.__setattr__(self, "_derived", filled_in(self))

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
        cosine = nominal * cos(alpha) / self.centre_distance_mm if self.centre_distance_mm > 0.0 else nan
        return acos(cosine) if 0.0 < cosine <= 1.0 else nan

    @property
    def normal_per_arc(self) -> float:
        """Normal distance between flanks per arc of the reference circle, cos(alpha_n) cos(beta)."""
        return cos(radians(self.pressure_angle_deg)) * cos(radians(self.helix_angle_deg))

    def mirrored(self) -> CylindricalPair:
        """The mirror image of the pair at x = 0; its drive flank is the coast flank of this pair."""
        return replace(self, hand="left" if self.hand == "right" else "right")

    @property
    def helix_in_radians(self) -> str:
        """The question whether a small helix angle is in radians; empty for others."""
        angle = self.helix_angle_deg
        told = f"helix_angle_deg = {angle:g}, is it in radians ({degrees(angle):.3g} degrees)?"
        return told if 0.0 < angle <= _RADIANS else ""

    @property
    def description(self) -> str:
        """The pair in a few words."""
        teeth = "helical" if self.helix_angle_deg else "spur"
        shifts = f"profile shifts {self.pinion_profile_shift:g}, {self.gear_profile_shift:g}"
        internal = "internal " if self.internal else ""
        return f"{internal}{teeth} gears {self.pinion_teeth}/{abs(self.gear_teeth)}, {shifts}"


@table
class CylindricalControlPoint:
    """Table ``[wear.control_point]`` of cylindrical gears: the point of a flank whose wear depth is watched."""

    face_mm: float = declared(
        any_number("from the middle of the gear's face width"),
        "Distance from the middle of the gear's face width, along the axis.",
    )
    height_mm: float = declared(
        any_number("above the working pitch cylinder"),
        "Height above the working pitch cylinder, towards the tip; negative on the dedendum.",
    )
    body: str | None = watched_body()

    @property
    def station_mm(self) -> float:
        """Face coordinate of the flanks [mm]."""
        return self.face_mm
