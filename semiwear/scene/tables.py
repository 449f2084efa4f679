"""The plain tables of a scene: material, operation, wear and numerics."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

from semiwear.errors import SceneError
from semiwear.plain_text import one_of
from semiwear.references.named_data import MATERIALS
from semiwear.scene.cylindrical import CylindricalControlPoint
from semiwear.scene.declare import declared, table
from semiwear.scene.flank_points import FlankPointsControlPoint
from semiwear.scene.rule import Rule, any_number, anything, between, choice, or_auto, positive
from semiwear.scene.rules import (
    BODIES,
    BodyCoefficients,
    BodyData,
    increasing_depths,
    named_data,
    tooth_compliance,
    watched_body,
    wear_coefficient,
    wear_data,
    worn_bodies,
    youngs_modulus,
)
from semiwear.scene.values import number, whole


@table
class Material:
    """Table ``[material.pinion]`` or ``[material.gear]``: an isotropic elastic material. Default: steel.

    ``gear = "POM"`` in ``[material]`` is short for ``data = "POM"`` here.
    """

    data: str | None = named_data(MATERIALS, "Named material, which gives the fields that are left out.")
    name: str = declared(anything(), "Name, for reports.", default="steel")
    youngs_modulus_MPa: float = declared(youngs_modulus(), "Young's modulus.", default=207000.0)
    poissons_ratio: float = declared(
        Rule(number, "above 0 and below 0.5", lambda value: 0.0 < value < 0.5, "0.3 for steel"),
        "Poisson's ratio.",
        default=0.3,
    )


@dataclass(frozen=True, kw_only=True)
class Materials:
    """The materials of both bodies."""

    pinion: Material = field(default_factory=Material)
    gear: Material = field(default_factory=Material)


@table
class Operation:
    """Table ``[operation]``: load and speed."""

    pinion_torque_Nm: float = declared(
        positive('give its size; for the other flank set operation.loaded_flank = "coast"', "N m"),
        "Torque on the pinion, which drives.",
    )
    loaded_flank: str = declared(
        choice("drive", "coast"),
        "Flank that bears the load; the coast flank is the mirror image of the drive flank.",
        default="drive",
    )
    pinion_speed_rpm: float | None = declared(
        positive("the pinion's speed in rev/min, without a sign", "rev/min"),
        "Pinion speed in rev/min; needed by the effects that depend on velocity.",
        default=None,
    )


@table
class WearUntil:
    """Table ``[wear.until]``: where a wear run ends; exactly one of the fields is given."""

    meshes: float | None = declared(
        positive("number of engagements of one gear tooth", ""), "Engagements of one gear tooth.", default=None
    )
    hours: float | None = declared(
        positive("running time at operation.pinion_speed_rpm", "h"),
        "Running time, converted to meshes with operation.pinion_speed_rpm: one for every revolution of the gear.",
        default=None,
    )
    control_depths_um: tuple[float, ...] | None = declared(
        increasing_depths(),
        "Wear depths at the control point, increasing; each is a step of the result, divided into parts if either "
        "body wears far deeper in it than in a usual step. The last depth ends the run.",
        default=None,
    )
    # whether the meshes follow from the hours
    _derived: bool = field(repr=False, compare=False, default=False)


@table
class ControlPoint:
    """Table ``[wear.control_point]``: the point of a flank whose wear depth is watched."""

    radius_mm: float = declared(
        positive("gear radius of the control point"),
        "Gear radius; for a point on the pinion, the distance from the gear's axis along the pinion's axis.",
    )
    height_mm: float = declared(
        any_number(""),
        "Height above the gear's pitch plane, for a point on the pinion above its pitch cylinder; negative on the "
        "dedendum.",
    )
    body: str | None = watched_body()

    @property
    def station_mm(self) -> float:
        """Face coordinate of the flanks [mm]."""
        return self.radius_mm


@table
class Wear:
    """Table ``[wear]``: Archard wear. A scene without it is loaded contact only."""

    data: str | BodyData | None = declared(
        wear_data(),
        "Named wear coefficient where coefficient_mm2_per_N is left out; one for both bodies, or a table "
        "`{pinion = ..., gear = ...}`.",
        default=None,
    )
    coefficient_mm2_per_N: float | BodyCoefficients = declared(
        wear_coefficient(),
        "Wear coefficient k: worn depth = k * pressure * sliding distance; one for both bodies, or a table "
        "`{pinion = ..., gear = ...}`.",
    )
    until: WearUntil
    worn_bodies: tuple[str, ...] = declared(
        worn_bodies(),
        "Bodies that wear, the pinion first. Left out: both for cylindrical gears, else the gear, as far as "
        "coefficients are given for them.",
        default=(),
    )
    control_point: ControlPoint | CylindricalControlPoint | FlankPointsControlPoint | None = None
    # whether the bodies are the default
    _derived: bool = field(repr=False, compare=False, default=False)

    @property
    def watched_body(self) -> str:
        """Body on whose flank the control point lies: the named body, else the gear if it wears, else the pinion."""
        named = None if self.control_point is None else self.control_point.body
        return named or default_watched_body(self.worn_bodies)

    def coefficient(self, body: str) -> float:
        """Wear coefficient of a body, ``"pinion"`` or ``"gear"`` [mm2/N].

        Raises
        ------
        SceneError
            If the scene gives none, as is allowed for a body that does not wear.
        """
        if body not in BODIES:
            raise SceneError.of("body", body, one_of(BODIES))
        given = self.coefficient_mm2_per_N
        if not isinstance(given, BodyCoefficients):
            return given
        value = given.given.get(body)
        if value is None:
            key, fix = f"wear.coefficient_mm2_per_N.{body}", "give it, or one number for both bodies"
            raise SceneError.of(key, None, "greater than 0 mm2/N", fix)
        return value


def default_worn_bodies(both: bool, coefficient: object, wear_mapping: object) -> tuple[str, ...]:
    """Bodies that wear if a scene does not give them: both for some kinds of pairs, else the gear.

    Only bodies with a wear coefficient are included; the mapping ``"marched"`` allows the gear alone.

    Parameters
    ----------
    both : bool
        Whether both bodies of this kind of gear pair wear by default.
    coefficient : float or BodyCoefficients
        ``wear.coefficient_mm2_per_N``.
    wear_mapping : str
        ``numerics.wear_mapping``.
    """
    usual = BODIES if both and wear_mapping != "marched" else ("gear",)
    if not isinstance(coefficient, BodyCoefficients):
        return usual
    given = tuple(coefficient.given)
    return tuple(body for body in usual if body in given) or given


def default_watched_body(worn: tuple[str, ...]) -> str:
    """Body of a control point for which none is given."""
    return "pinion" if worn == ("pinion",) else "gear"


RESOLUTION = ("wear_steps", "roll_positions", "face_slices", "cells_per_half_width", "profile_points", "harmonics")
"""Fields of `Numerics` that are chosen for a requested accuracy."""
MOST_PEAK_POSITIONS = 10_000
"""Greatest `numerics.peak_positions`."""


def _whole_or_auto(most: int) -> Rule:
    return or_auto(between(whole, 1, most, 'give "auto"'), f'"auto" or a whole number, 1 to {most}')


@table
class Numerics:
    """Table ``[numerics]``: models and resolution."""

    accuracy: float | None = declared(
        between(number, 1e-4, 0.5, "0.02 is usual: 2 % of the greatest value of each kind"),
        "Requested error, relative to the greatest value of each kind of quantity: the numbers of slices, roll "
        "positions, profile points, harmonics, cells and wear steps that are left out are then chosen for it. Left "
        "out: the defaults below.",
        default=None,
    )
    fidelity: str = declared(
        choice("line", "patch"),
        "Contact model: line loads with Hertzian pressure across the line, or pressure resolved in two dimensions.",
        default="line",
    )
    wear_mapping: str = declared(
        choice("interpolated", "marched"),
        "Wear interpolated between few roll positions, or summed over many; `marched` needs fidelity `patch` and "
        "wear of the gear alone.",
        default="interpolated",
    )
    wear_scheme: str = declared(
        choice("implicit", "two-stage", "explicit"),
        "Time integration of wear: `two-stage` is implicit as well; a step takes twice the time of an `implicit` one "
        "and replaces two, or more at little wear; `explicit` is for comparison.",
        default="implicit",
    )
    wear_steps: int | str = declared(_whole_or_auto(10_000), "Steps up to `wear.until.meshes`.", default="auto")
    roll_positions: int = declared(
        between(whole, 8, 10_000, "24 is usual"), "Roll positions per mesh cycle.", default=24
    )
    peak_positions: int | None = declared(
        between(whole, 8, MOST_PEAK_POSITIONS, "192 is usual"),
        "Roll positions per mesh cycle only for the amplitude of the transmission error: near its possible peaks, "
        "positions are solved at the spacing of this number. Left out: only `roll_positions`, between which peaks "
        "may lie; with `accuracy`, as many as it needs.",
        default=None,
    )
    face_slices: int = declared(
        between(whole, 7, 10_000, "61 is usual"),
        "Slices along the face; some of their borders are where the roundings of the end edges begin.",
        default=61,
    )
    cells_per_half_width: int = declared(
        between(whole, 2, 1000, "8 is usual"),
        "Cells of a patch across the Hertz half-width at the pitch point.",
        default=8,
    )
    profile_points: int = declared(
        between(whole, 21, 10_000, "141 is usual"), "Points of the flank grid along the tooth height.", default=141
    )
    tooth_pairs: int | str = declared(_whole_or_auto(7), "Tooth pairs that may share the load.", default="auto")
    tooth_compliance: str = declared(
        tooth_compliance(), "Finite prisms, local contact alone, or influence data from a file.", default="prism"
    )
    harmonics: int = declared(
        between(whole, 1, 1000, "33 is usual"), "Cosine terms of the prism series along the face width.", default=33
    )
    max_iterations: int = declared(
        between(whole, 1, 1_000_000, "60 is usual"),
        "Iterations of the load sharing at one roll position.",
        default=60,
    )
    threads: int | None = declared(
        between(whole, 1, 1024, "leave it out for all cores that the process may use"),
        "Number of threads of a run; it does not change results. Left out: the number of cores that the process may "
        "use.",
        default=None,
    )
    # given fields of `RESOLUTION`; they matter only with an accuracy, and only then for equality
    _given: frozenset[str] = field(repr=False, compare=False, default=frozenset())
    _kept: frozenset[str] = field(init=False, repr=False, default=frozenset())

    def __post_init__(self) -> None:
        changed = {entry.name for entry in fields(self) if getattr(self, entry.name) != entry.default}
        given = frozenset(name for name in RESOLUTION if name in self._given or name in changed)
        object.__setattr__(self, "_given", given)
        object.__setattr__(self, "_kept", frozenset() if self.accuracy is None else given)

    @property
    def chosen_for_accuracy(self) -> tuple[str, ...]:
        """Fields that are chosen for the requested accuracy; empty without one."""
        return () if self.accuracy is None else tuple(name for name in RESOLUTION if name not in self._given)

    @property
    def left_out(self) -> frozenset[str]:
        """Fields of `RESOLUTION` that were not given."""
        return frozenset(RESOLUTION) - self._given
