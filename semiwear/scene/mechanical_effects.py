"""Tables of effects on geometry, meshing, compliance and load; exported by `semiwear.scene.effects`.

Like all tables of a scene they check nothing themselves. Tables for a screening are functions of the scene.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import ClassVar

from semiwear.scene.declare import declared, table
from semiwear.scene.effect_table import EffectTable, ScreenedScene
from semiwear.scene.placement import Placement
from semiwear.scene.rule import Rule, above, between, choice, grid_file, positive
from semiwear.scene.values import number, numbers
from semiwear.untyped import Table, Value

_SHIFT = "a shift in mm, usually below 0.1; give um divided by 1000"
_TURN = "a rotation in mrad, usually below 1; 1 degree is 17.45 mrad"
_SIGNED = "in um, of either sign; usually below 100"
_SHAFT = "shafts deflect in the direction of the load: 0 for rigid, 0.1 to 10 is usual"


def _shift(meaning: str) -> Value:
    return declared(between(number, -5.0, 5.0, _SHIFT, "mm"), meaning, default=0.0)


def _turn(meaning: str) -> Value:
    return declared(between(number, -50.0, 50.0, _TURN, "mrad"), meaning, default=0.0)


def _relief(end: str) -> Value:
    rule = between(number, 0.0, 1000.0, "in um, usually 5 to 100 at a module of some mm; 0 for none", "um")
    return declared(rule, f"{end.capitalize()} relief: amount at the {end}, normal to the flank.", default=0.0)


def _relief_length(end: str) -> Value:
    rule = positive("a length along the profile, or leave the field out for a third of the flank")
    meaning = (
        f"Extent along the profile from the {end}, an arc length, not a length of roll; left out: a third of the "
        "flank's profile length."
    )
    return declared(rule, meaning, default=None)


def _spring(meaning: str, unit: str, default: float) -> Value:
    return declared(between(number, 0.0, 1000.0, _SHAFT, unit), meaning, default=default)


def _grid_file() -> Rule:
    fix = "save the grid as CSV or netCDF, and give its path with the ending .csv or .nc"
    return grid_file("the path of a CSV (.csv) or netCDF (.nc) file of deviations", fix)


def _positive_list(allowed: str, fix: str, shares: bool = False) -> Rule:
    def holds(values: tuple[float, ...]) -> bool:
        return bool(values) and min(values) > 0.0 and (not shares or max(values) <= 1.0)

    return Rule(numbers, allowed, holds, _with_wrong_entry(lambda value: value <= 0.0, fix))


def _with_wrong_entry(is_wrong: Callable[[float], bool], fix: str) -> Callable[[tuple[float, ...]], str]:
    """The fix, preceded by the first wrong entry of the list."""

    def with_entry(values: tuple[float, ...]) -> str:
        wrong = next((k for k, value in enumerate(values) if is_wrong(value)), None)
        return fix if wrong is None else f"entry {wrong + 1} is {values[wrong]:g}: {fix}"

    return with_entry


def _pitch_deviations() -> Rule:
    limit = 1000.0

    def holds(values: tuple[float, ...]) -> bool:
        return len(values) >= 2 and all(abs(value) <= limit for value in values)

    def fix(values: tuple[float, ...]) -> str:
        if len(values) < 2:
            return "one value for each of several successive teeth, e.g. [0, 10, 0, -10]"
        return _with_wrong_entry(lambda value: abs(value) > limit, "in um; 10 is usual at quality 6")(values)

    return Rule(numbers, f"two or more deviations in um, each {-limit:g} to {limit:g}", holds, fix)


@table
class Misalignment(EffectTable):
    """Table ``[effects.misalignment]``: mounting errors of the pinion, with the signs of `Placement`."""

    title: ClassVar[str] = "mounting errors"
    acts_in: ClassVar[str] = "meshing"
    validity: ClassVar[str] = "a rigid displacement that stays the same under load; shifts far below the module"
    references: ClassVar[tuple[str, ...]] = (
        "Litvin and Fuentes 2004, Gear Geometry and Applied Theory, ch. 18 (face gears, errors of alignment)",
    )

    offset_mm: float = _shift("Shift of the pinion along +x.")
    axial_pinion_mm: float = _shift("Shift of the pinion along its axis.")
    axial_gear_mm: float = _shift("Shift of the pinion along +y, the axis of a face gear, away from the gear.")
    shaft_angle_error_mrad: float = _turn("Rotation of the pinion about +x through the pitch point.")
    pinion_slope_mrad: float = _turn("Rotation of the pinion about +y through the pitch point.")

    @property
    def placement(self) -> Placement:
        """Placement of the pinion with these errors."""
        return Placement(**asdict(self))

    @staticmethod
    def screening_table(scene: ScreenedScene) -> Table:
        """An offset of 0.05 mm and a shaft angle error of 0.5 mrad: a careful assembly."""
        return {"offset_mm": 0.05, "shaft_angle_error_mrad": 0.5}


@table
class FlankModification(EffectTable):
    """Table ``[effects.modification.pinion]`` or ``[effects.modification.gear]``: modification of a flank."""

    title: ClassVar[str] = "flank modification"
    acts_in: ClassVar[str] = "geometry"
    validity: ClassVar[str] = "deviations far below the module, normal to a flank whose normals stay as they are"
    references: ClassVar[tuple[str, ...]] = (
        "ISO 21771:2007 (tip and root relief, crowning, helix slope and bias modification)",
    )

    tip_relief_um: float = _relief("tip")
    tip_relief_length_mm: float | None = _relief_length("tip")
    root_relief_um: float = _relief("root")
    root_relief_length_mm: float | None = _relief_length("root")
    relief_shape: str = declared(
        choice("parabolic", "linear"), "Shape of the relief over its length.", default="parabolic"
    )
    crowning_um: float = declared(
        between(number, 0.0, 1000.0, "the relief at the ends of the face; for a hollow flank give a file", "um"),
        "Relief at both ends of the face, growing parabolically from zero in the middle.",
        default=0.0,
    )
    lead_slope_um: float = declared(
        between(number, -1000.0, 1000.0, _SIGNED, "um"),
        "Helix slope modification: change over the face width; positive removes at the upper end of the face "
        "(greater face coordinate), negative at the lower end.",
        default=0.0,
    )
    bias_um: float = declared(
        between(number, -1000.0, 1000.0, _SIGNED, "um"),
        "Twist: relief that is greatest at two opposite corners of the flank; positive: at the tip of the upper end "
        "of the face (greater face coordinate) and the root of the lower end.",
        default=0.0,
    )
    file: str | None = declared(
        _grid_file(), "CSV or netCDF grid of deviations, added to the other fields.", default=None
    )

    @staticmethod
    def screening_table(scene: ScreenedScene) -> Table:
        """A tip relief of 20 um, as usual at a module of some millimetres."""
        return {"tip_relief_um": 20.0}


@table
class FreeEdges(EffectTable):
    """Table ``[effects.free_edges]``: the half-space under a contact ends at a flank's free borders."""

    title: ClassVar[str] = "free edges of the half-space"
    acts_in: ClassVar[str] = "compliance"
    validity: ClassVar[str] = "pressure ends half a half-width or more from an edge; edges of about a right angle"
    references: ClassVar[tuple[str, ...]] = (
        "Hetenyi 1970, J. Appl. Mech. 37, 70-76 (elastic quarter-space)",
        "Keer, Lee and Mura 1983, Int. J. Solids Struct. 19, 497-508 (contact near the edge of a quarter-space)",
        "Guilbault 2011, J. Tribol. 133, 031402 (a factor on image loads)",
    )

    strength: float = declared(
        between(number, 0.0, 1.0, "the share of the correction: 1 for all of it"),
        "Share of the correction that is applied, 0 to 1.",
        default=1.0,
    )


@table
class LoadSpectrum(EffectTable):
    """Table ``[effects.load_spectrum]``: alternating torques, in place of the single torque of ``[operation]``."""

    title: ClassVar[str] = "load spectrum"
    acts_in: ClassVar[str] = "wear"
    validity: ClassVar[str] = "loads that alternate fast against wear, so that their order does not matter"
    references: ClassVar[tuple[str, ...]] = (
        "ISO 6336-6:2019 (variable load: a spectrum as torques and their shares)",
    )

    torques_Nm: tuple[float, ...] = declared(
        _positive_list("one or more torques, each greater than 0 N m", "give the size of the torque"),
        "Torques on the pinion.",
    )
    shares: tuple[float, ...] = declared(
        _positive_list(
            "as many shares as torques, each above 0 and up to 1, summing to 1",
            "leave out what never occurs; not in per cent",
            shares=True,
        ),
        "Share of the meshes at each torque, summing to 1.",
    )

    @staticmethod
    def screening_table(scene: ScreenedScene) -> Table:
        """Spectrum of 50, 100 and 125 % of the scene's torque, mostly 100 %."""
        torque = scene.operation.pinion_torque_Nm
        return {"torques_Nm": [0.5 * torque, 1.0 * torque, 1.25 * torque], "shares": [0.3, 0.5, 0.2]}


@table
class PitchError(EffectTable):
    """Table ``[effects.pitch_error]``: pitch deviations of the pinion's teeth."""

    title: ClassVar[str] = "pitch error"
    acts_in: ClassVar[str] = "meshing"
    validity: ClassVar[str] = "deviations far below the module; the teeth keep their shape"
    references: ClassVar[tuple[str, ...]] = ("ISO 1328-1:2013 (single and cumulative pitch deviation)",)

    pinion_um: tuple[float, ...] = declared(
        _pitch_deviations(),
        "Deviations of successive pinion teeth, as they come into mesh, from their true place, along the pitch "
        "circle; positive where the tooth is ahead and takes more load; repeated around the pinion.",
    )

    @staticmethod
    def screening_table(scene: ScreenedScene) -> Table:
        """Neighbouring teeth that differ by 10 um, in both directions."""
        return {"pinion_um": [0.0, 10.0, 0.0, -10.0]}


@table
class ShaftCompliance(EffectTable):
    """Table ``[effects.shaft_compliance]``: shafts and bearings deflect, so that load misaligns the pair."""

    title: ClassVar[str] = "shaft and bearing compliance"
    acts_in: ClassVar[str] = "compliance"
    validity: ClassVar[str] = "linear bearings and shafts; each direction deflects under its own force alone"
    references: ClassVar[tuple[str, ...]] = ("ISO 6336-1:2019 (face load factor: deflection of shafts and bearings)",)

    offset_um_per_kN: float = _spring("Shift along +x per force in that direction.", "um/kN", 1.0)
    axial_pinion_um_per_kN: float = _spring(
        "Shift along the pinion's axis per force in that direction.", "um/kN", 1.0
    )
    axial_gear_um_per_kN: float = _spring(
        "Shift along y, the axis of a face gear, per force in that direction.", "um/kN", 1.0
    )
    shaft_angle_mrad_per_kNm: float = _spring("Rotation about +x per moment about that axis.", "mrad/kNm", 0.1)
    pinion_slope_mrad_per_kNm: float = _spring("Rotation about +y per moment about that axis.", "mrad/kNm", 0.1)


@table
class RunLife(EffectTable):
    """Table ``[effects.run_life]``: number of meshes until wear reaches a limit."""

    title: ClassVar[str] = "life until a depth of wear"
    acts_in: ClassVar[str] = "results"
    needs: ClassVar[tuple[str, ...]] = ("wear",)
    validity: ClassVar[str] = "steady mild wear, after running in"
    references: ClassVar[tuple[str, ...]] = ("Archard 1953, Contact and rubbing of flat surfaces (wear law)",)

    depth_limit_um: float = declared(
        above(0.0, 10_000.0, "in um: the case depth is a usual limit", "um"),
        "Greatest wear depth that is allowed anywhere on the flank.",
        default=50.0,
    )
    body: str = declared(
        choice("gear", "pinion"), "Body whose wear is limited; it must be one that wears.", default="gear"
    )
    ends_at: str = declared(
        choice("depth", "first_failure"),
        "End of the life: the wear depth, or the first of it and of the failure modes that the scene rates.",
        default="depth",
    )

    @staticmethod
    def screening_table(scene: ScreenedScene) -> Table:
        """The body whose wear is limited: the gear if it wears, else the pinion."""
        worn = ("gear",) if scene.wear is None else scene.wear.worn_bodies
        return {} if "gear" in worn else {"body": worn[0]}
