"""The gear pair of a scene: table ``[gear_pair]``."""

from __future__ import annotations

from dataclasses import field
from math import cos, radians
from typing import ClassVar

from semiwear.scene.declare import declared, filled_in, table
from semiwear.scene.defaults import (
    DEBURRED,
    USUAL_MODULE,
    DerivedDefault,
    bore_radius,
    face_centre,
    modules,
    rack_tip_radius,
    shaper_tip_radius,
)
from semiwear.scene.rule import Rule, angle, at_least_zero, between, choice, positive
from semiwear.scene.values import number, whole
from semiwear.untyped import Value

# Upper limits of whole numbers are far beyond use; they keep typing errors from exhausting memory.
_TEETH = "count the teeth of the whole gear"
_CUTTER_TIP = "leave the field out for its default, which grows with the module"
_LENGTH = "a length, or leave the field out for its default"
_RADIUS = "a radius from the gear axis; the teeth lie around the pitch radius m z2/2"
_EDGE = "give 0 for a sharp edge, or leave the field out for a deburred one"


def _edge_radius(body: str, border: str) -> Value:
    meaning = f"Rounding between flank and {border} of the {body}; left out: 0.0315 m, 0.2 at a module of 6.35."
    return declared(at_least_zero(_EDGE), meaning, derived=modules(DEBURRED / USUAL_MODULE))


@table
class FaceGearPair:
    """Table ``[gear_pair]``: an involute spur pinion and the face gear that a shaper generates.

    Fields without a default are required. Defaults that follow from other fields are computed here, so that a pair
    always has numbers; `Scene.replace` derives them anew when those fields change.
    """

    pitch_surfaces: ClassVar[tuple[str, str, str]] = ("pitch cone", "pitch cylinder", "pitch plane")
    both_wear: ClassVar[bool] = False
    references: ClassVar[tuple[str, ...]] = ("Litvin and Fuentes 2004, Gear Geometry and Applied Theory, ch. 18",)

    type: str = declared(choice("face_gear"), "Kind of gear pair.")
    pinion_teeth: int = declared(between(whole, 12, 1000, _TEETH), "Number of teeth of the pinion.")
    shaper_teeth: int = declared(
        between(whole, 12, 1000, _TEETH), "Number of teeth of the shaper, one to three more than the pinion's."
    )
    gear_teeth: int = declared(between(whole, 12, 1000, _TEETH), "Number of teeth of the gear.")
    module_mm: float = declared(
        positive("the module is the pitch diameter divided by the number of teeth"), "Module m."
    )
    pressure_angle_deg: float = declared(
        angle(10.0, 35.0, "in degrees: 20 and 25 are usual"),
        "Pressure angle of pinion, shaper and basic rack.",
    )
    gear_inner_radius_mm: float = declared(positive(_RADIUS), "Radius (not diameter) from which the gear has teeth.")
    gear_outer_radius_mm: float = declared(positive(_RADIUS), "Radius up to which the gear has teeth.")
    pinion_face_width_mm: float = declared(
        positive("usually about the gear's outer less its inner radius"), "Face width of the pinion."
    )
    shaft_angle_deg: float = declared(
        Rule(number, "90 degrees", lambda value: value == 90.0, "not available yet; only 90"),
        "Shaft angle.",
        default=90.0,
    )
    pinion_centre_mm: float = declared(
        positive("distance of the middle of the pinion's face width from the gear axis"),
        "Distance of the middle of the pinion's face width from the gear axis; left out: middle of the gear radii.",
        derived=DerivedDefault(("gear_inner_radius_mm", "gear_outer_radius_mm"), face_centre),
    )
    pinion_addendum_mm: float = declared(
        positive(_LENGTH), "Tip height of the pinion beyond the pitch surface; left out: 1 m.", derived=modules(1.0)
    )
    gear_addendum_mm: float = declared(
        positive(_LENGTH), "Tip height of the gear beyond the pitch surface; left out: 1 m.", derived=modules(1.0)
    )
    shaper_addendum_mm: float = declared(
        positive(_LENGTH),
        "Height of the shaper's crest, the gear's dedendum; left out: 1.25 m.",
        derived=modules(1.25),
    )
    rack_addendum_mm: float = declared(
        positive(_LENGTH),
        "Height of the basic rack's crest, the pinion's dedendum; left out: 1.25 m.",
        derived=modules(1.25),
    )
    shaper_tip_radius_mm: float = declared(
        at_least_zero(_CUTTER_TIP),
        "Tip rounding of the shaper, which generates the gear's fillet; left out: 0.2 m, or the full rounding of the "
        "crest if that is less.",
        derived=DerivedDefault(
            ("module_mm", "pressure_angle_deg", "shaper_teeth", "shaper_addendum_mm"), shaper_tip_radius
        ),
    )
    rack_tip_radius_mm: float = declared(
        at_least_zero(_CUTTER_TIP),
        "Tip rounding of the basic rack, which generates the pinion's fillet; left out: 0.3 m, or the full rounding "
        "of the crest if that is less.",
        derived=DerivedDefault(("module_mm", "pressure_angle_deg", "rack_addendum_mm"), rack_tip_radius),
    )
    pinion_tip_edge_radius_mm: float = _edge_radius("pinion", "tip")
    gear_tip_edge_radius_mm: float = _edge_radius("gear", "tip")
    pinion_end_edge_radius_mm: float = _edge_radius("pinion", "end faces")
    gear_end_edge_radius_mm: float = _edge_radius("gear", "end faces")
    pinion_bore_radius_mm: float = declared(
        positive(_LENGTH),
        "Radius of the pinion's bore, on which it is fixed; left out: 0.63 pitch radii, 50 for 25 teeth at a module "
        "of 6.35.",
        derived=DerivedDefault(("module_mm", "pinion_teeth"), bore_radius),
    )
    gear_rim_thickness_mm: float = declared(
        positive(_LENGTH), "Thickness of the gear under its root; left out: 2.5 m.", derived=modules(2.5)
    )
    # fields that have their derived default
    _derived: frozenset[str] = field(init=False, repr=False, compare=False, default=frozenset())

    def __post_init__(self) -> None:
        object.__setattr__(self, "_derived", filled_in(self))

    @property
    def pinion_pitch_radius_mm(self) -> float:
        """Pitch radius of the pinion, m z1/2 [mm]."""
        return 0.5 * self.module_mm * self.pinion_teeth

    @property
    def shaper_pitch_radius_mm(self) -> float:
        """Pitch radius of the shaper, m zs/2 [mm]."""
        return 0.5 * self.module_mm * self.shaper_teeth

    @property
    def gear_pitch_radius_mm(self) -> float:
        """Gear radius of the pitch point, m z2/2 [mm]."""
        return 0.5 * self.module_mm * self.gear_teeth

    @property
    def normal_per_arc(self) -> float:
        """Normal distance between flanks per arc of the pinion's pitch circle, cos(alpha)."""
        return cos(radians(self.pressure_angle_deg))

    def mirrored(self) -> FaceGearPair:
        """The mirror image of the pair at x = 0, which is the pair itself."""
        return self

    @property
    def description(self) -> str:
        """The pair in a few words."""
        return f"face gear {self.pinion_teeth}/{self.gear_teeth}, shaper {self.shaper_teeth}"
