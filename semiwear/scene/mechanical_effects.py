"""Tables of effects on geometry, meshing, compliance and load; exported by `semiwear.scene.effects`.

Like all tables of a scene they check nothing themselves. Mappings that screen are functions of the scene.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from semiwear.scene.effect_table import EffectTable, ScreenedScene
from semiwear.scene.placement import Placement

__all__ = [
    "FlankModification",
    "FreeEdges",
    "LoadSpectrum",
    "Misalignment",
    "PitchError",
    "RunLife",
    "ShaftCompliance",
]


@dataclass(frozen=True, kw_only=True)
class Misalignment(EffectTable):
    """Table ``[effects.misalignment]``: mounting errors of the pinion, with the signs of `Placement`.

    Attributes
    ----------
    offset_mm, axial_pinion_mm, axial_gear_mm : float
        Shifts along +x, the pinion axis and the gear axis (away from the gear). Default 0.
    shaft_angle_error_mrad, pinion_slope_mrad : float
        Rotations about +x and +y through the pitch point. Default 0.
    """

    title: ClassVar[str] = "mounting errors"
    acts_in: ClassVar[str] = "meshing"
    validity: ClassVar[str] = "a rigid displacement that stays the same under load; shifts far below the module"
    references: ClassVar[tuple[str, ...]] = (
        "Litvin and Fuentes 2004, Gear Geometry and Applied Theory, ch. 18 (face gears, errors of alignment)",
    )

    offset_mm: float = 0.0
    axial_pinion_mm: float = 0.0
    axial_gear_mm: float = 0.0
    shaft_angle_error_mrad: float = 0.0
    pinion_slope_mrad: float = 0.0

    @property
    def placement(self) -> Placement:
        """Where these errors put the pinion."""
        return Placement(
            offset_mm=self.offset_mm,
            axial_pinion_mm=self.axial_pinion_mm,
            axial_gear_mm=self.axial_gear_mm,
            shaft_angle_error_mrad=self.shaft_angle_error_mrad,
            pinion_slope_mrad=self.pinion_slope_mrad,
        )

    @staticmethod
    def screening_table(scene: ScreenedScene) -> dict[str, Any]:
        """An offset of 0.05 mm and a shaft angle error of 0.5 mrad: a careful assembly."""
        return {"offset_mm": 0.05, "shaft_angle_error_mrad": 0.5}


@dataclass(frozen=True, kw_only=True)
class FlankModification(EffectTable):
    """Table ``[effects.modification.pinion]`` or ``[effects.modification.gear]``: what is ground off a flank.

    Attributes
    ----------
    tip_relief_um, root_relief_um : float
        Relief at the very tip and root, normal to the flank. Default 0.
    tip_relief_length_mm, root_relief_length_mm : float or None
        Extent along the profile from the tip or root. Default None: a third of the flank's profile length.
    relief_shape : str
        ``"parabolic"`` (default) or ``"linear"``: how relief grows over its length.
    crowning_um : float
        Relief at both ends of the face, growing parabolically from zero in the middle. Default 0.
    lead_slope_um : float
        Change over the face width, signed. Default 0.
    bias_um : float
        Twist: relief that is greatest at two opposite corners of the flank, signed. Default 0.
    file : str or None
        CSV or netCDF grid of deviations, added to the rest. Default None.
    """

    title: ClassVar[str] = "flank modification"
    acts_in: ClassVar[str] = "geometry"
    validity: ClassVar[str] = "deviations far below the module, normal to a flank whose normals stay as they are"
    references: ClassVar[tuple[str, ...]] = (
        "ISO 21771:2007 (tip and root relief, crowning, helix slope and bias modification)",
    )

    tip_relief_um: float = 0.0
    tip_relief_length_mm: float | None = None
    root_relief_um: float = 0.0
    root_relief_length_mm: float | None = None
    relief_shape: str = "parabolic"
    crowning_um: float = 0.0
    lead_slope_um: float = 0.0
    bias_um: float = 0.0
    file: str | None = None

    @staticmethod
    def screening_table(scene: ScreenedScene) -> dict[str, Any]:
        """A tip relief of 20 um, as usual at a module of some millimetres."""
        return {"tip_relief_um": 20.0}


@dataclass(frozen=True, kw_only=True)
class FreeEdges(EffectTable):
    """Table ``[effects.free_edges]``: the half-space under a contact ends at a flank's free borders.

    Attributes
    ----------
    strength : float
        Share of the correction that is applied, 0 to 1. Default 1.
    """

    title: ClassVar[str] = "free edges of the half-space"
    acts_in: ClassVar[str] = "compliance"
    validity: ClassVar[str] = "pressure ends half a half-width or more from an edge; edges of about a right angle"
    references: ClassVar[tuple[str, ...]] = (
        "Hetenyi 1970, J. Appl. Mech. 37, 70-76 (elastic quarter-space)",
        "Keer, Lee and Mura 1983, Int. J. Solids Struct. 19, 497-508 (contact near the edge of a quarter-space)",
        "Guilbault 2011, J. Tribol. 133, 031402 (a factor on image loads)",
    )

    strength: float = 1.0


@dataclass(frozen=True, kw_only=True)
class LoadSpectrum(EffectTable):
    """Table ``[effects.load_spectrum]``: torques that take turns, in place of the one torque of ``[operation]``.

    Attributes
    ----------
    torques_Nm : tuple of float
        Torques on the pinion, required.
    shares : tuple of float
        Share of the meshes at each torque, summing to 1; required.
    """

    title: ClassVar[str] = "load spectrum"
    acts_in: ClassVar[str] = "wear"
    validity: ClassVar[str] = "loads that alternate fast against wear, so that their order does not matter"
    references: ClassVar[tuple[str, ...]] = (
        "ISO 6336-6:2019 (variable load: a spectrum as torques and their shares)",
    )

    torques_Nm: tuple[float, ...]
    shares: tuple[float, ...]

    @staticmethod
    def screening_table(scene: ScreenedScene) -> dict[str, Any]:
        """Half, the whole and five quarters of the scene's torque, mostly at the whole."""
        torque = scene.operation.pinion_torque_Nm
        return {"torques_Nm": [0.5 * torque, 1.0 * torque, 1.25 * torque], "shares": [0.3, 0.5, 0.2]}


@dataclass(frozen=True, kw_only=True)
class PitchError(EffectTable):
    """Table ``[effects.pitch_error]``: pinion teeth that are not quite in their place.

    Attributes
    ----------
    pinion_um : tuple of float
        Deviations of successive pinion teeth from their true place, along the pitch circle, repeated around the
        pinion; required.
    """

    title: ClassVar[str] = "pitch error"
    acts_in: ClassVar[str] = "meshing"
    validity: ClassVar[str] = "deviations far below the module; the teeth keep their shape"
    references: ClassVar[tuple[str, ...]] = ("ISO 1328-1:2013 (single and cumulative pitch deviation)",)

    pinion_um: tuple[float, ...]

    @staticmethod
    def screening_table(scene: ScreenedScene) -> dict[str, Any]:
        """Neighbours that differ by 10 um, in both directions."""
        return {"pinion_um": [0.0, 10.0, 0.0, -10.0]}


@dataclass(frozen=True, kw_only=True)
class ShaftCompliance(EffectTable):
    """Table ``[effects.shaft_compliance]``: shafts and bearings give way, so that load misaligns the pair.

    Attributes
    ----------
    offset_um_per_kN, axial_pinion_um_per_kN, axial_gear_um_per_kN : float
        Shifts per force in the same direction, with the directions of `Placement`. Default 1.
    shaft_angle_mrad_per_kNm, pinion_slope_mrad_per_kNm : float
        Rotations per moment about the same axis through the pitch point. Default 0.1.
    """

    title: ClassVar[str] = "shaft and bearing compliance"
    acts_in: ClassVar[str] = "compliance"
    validity: ClassVar[str] = "linear bearings and shafts; each direction gives way to its own force alone"
    references: ClassVar[tuple[str, ...]] = ("ISO 6336-1:2019 (face load factor: deflection of shafts and bearings)",)

    offset_um_per_kN: float = 1.0
    axial_pinion_um_per_kN: float = 1.0
    axial_gear_um_per_kN: float = 1.0
    shaft_angle_mrad_per_kNm: float = 0.1
    pinion_slope_mrad_per_kNm: float = 0.1


@dataclass(frozen=True, kw_only=True)
class RunLife(EffectTable):
    """Table ``[effects.run_life]``: how many meshes until wear reaches a limit.

    Attributes
    ----------
    depth_limit_um : float
        Greatest wear depth that is allowed anywhere on the flank. Default 50.
    body : str
        ``"gear"`` (default) or ``"pinion"``; must be a worn body.
    """

    title: ClassVar[str] = "life until a depth of wear"
    acts_in: ClassVar[str] = "results"
    needs: ClassVar[tuple[str, ...]] = ("wear",)
    validity: ClassVar[str] = "steady mild wear, after running in"
    references: ClassVar[tuple[str, ...]] = ("Archard 1953, Contact and rubbing of flat surfaces (wear law)",)

    depth_limit_um: float = 50.0
    body: str = "gear"

    @staticmethod
    def screening_table(scene: ScreenedScene) -> dict[str, Any]:
        """A body that wears."""
        worn = ("gear",) if scene.wear is None else scene.wear.worn_bodies
        return {} if "gear" in worn else {"body": worn[0]}
