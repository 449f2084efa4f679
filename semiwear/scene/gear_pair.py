"""The gear pair of a scene: table ``[gear_pair]``."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, radians
from typing import ClassVar, cast

from semiwear.scene.defaults import DERIVED_DEFAULTS, filled_in

__all__ = ["FaceGearPair"]

# Replaced by a number in `FaceGearPair.__post_init__`: no reader of a pair ever meets None.
_DERIVED = cast(float, None)


@dataclass(frozen=True, kw_only=True)
class FaceGearPair:
    """Table ``[gear_pair]``: an involute spur pinion and the face gear that a shaper generates.

    Fields without a default are required. A default that follows from other fields is resolved here,
    so that a pair always holds numbers; `Scene.replace` derives it anew when those fields change.

    Attributes
    ----------
    type : str
        Kind of gear pair: ``"face_gear"``.
    pinion_teeth, shaper_teeth, gear_teeth : int
        Numbers of teeth. The shaper has one to three teeth more than the pinion.
    module_mm : float
        Module m.
    pressure_angle_deg : float
        Pressure angle of pinion, shaper and basic rack.
    gear_inner_radius_mm, gear_outer_radius_mm : float
        Radii (not diameters) between which the gear has teeth.
    pinion_face_width_mm : float
        Face width of the pinion.
    shaft_angle_deg : float
        Shaft angle. Default 90.
    pinion_centre_mm : float
        Distance of the middle of the pinion's face width from the gear axis. Default: middle of the
        gear radii.
    pinion_addendum_mm, gear_addendum_mm : float
        Tip heights beyond the pitch surface. Default 1 m.
    shaper_addendum_mm, rack_addendum_mm : float
        Heights of the cutters' crests; the first is the gear's dedendum, the second (basic rack) the
        pinion's. Default 1.25 m.
    shaper_tip_radius_mm, rack_tip_radius_mm : float
        Tip roundings of the cutters, which leave the fillets. Defaults 0.2 m and 0.3 m, or what the crests have
        room for.
    pinion_tip_edge_radius_mm, gear_tip_edge_radius_mm : float
        Edge rounding between flank and tip. Default 0.0315 m: 0.2 at a module of 6.35.
    pinion_end_edge_radius_mm, gear_end_edge_radius_mm : float
        Edge rounding between flank and end faces. Default 0.0315 m: 0.2 at a module of 6.35.
    pinion_bore_radius_mm : float
        Radius of the pinion's bore, where it is held. Default 0.63 pitch radii: 50 for 25 teeth at that module.
    gear_rim_thickness_mm : float
        Thickness of the gear under its root. Default 2.5 m.
    """

    references: ClassVar[tuple[str, ...]] = ("Litvin and Fuentes 2004, Gear Geometry and Applied Theory, ch. 18",)

    type: str
    pinion_teeth: int
    shaper_teeth: int
    gear_teeth: int
    module_mm: float
    pressure_angle_deg: float
    gear_inner_radius_mm: float
    gear_outer_radius_mm: float
    pinion_face_width_mm: float
    shaft_angle_deg: float = 90.0
    pinion_centre_mm: float = _DERIVED
    pinion_addendum_mm: float = _DERIVED
    gear_addendum_mm: float = _DERIVED
    shaper_addendum_mm: float = _DERIVED
    rack_addendum_mm: float = _DERIVED
    shaper_tip_radius_mm: float = _DERIVED
    rack_tip_radius_mm: float = _DERIVED
    pinion_tip_edge_radius_mm: float = _DERIVED
    gear_tip_edge_radius_mm: float = _DERIVED
    pinion_end_edge_radius_mm: float = _DERIVED
    gear_end_edge_radius_mm: float = _DERIVED
    pinion_bore_radius_mm: float = _DERIVED
    gear_rim_thickness_mm: float = _DERIVED
    # Which fields were left to their derived default.
    _derived: frozenset[str] = field(init=False, repr=False, compare=False, default=frozenset())

    def __post_init__(self) -> None:
        object.__setattr__(self, "_derived", filled_in(self, DERIVED_DEFAULTS))

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

    @property
    def description(self) -> str:
        """What it is, in a few words."""
        return f"face gear {self.pinion_teeth}/{self.gear_teeth}, shaper {self.shaper_teeth}"
