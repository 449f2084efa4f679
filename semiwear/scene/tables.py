"""The plain tables of a scene: material, operation, wear and numerics."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

from semiwear.errors import SceneError
from semiwear.scene.cylindrical import CylindricalControlPoint
from semiwear.scene.flank_points import FlankPointsControlPoint

__all__ = [
    "BODIES",
    "RESOLUTION",
    "BodyCoefficients",
    "ControlPoint",
    "Material",
    "Materials",
    "Numerics",
    "Operation",
    "Wear",
    "WearUntil",
    "default_watched_body",
    "default_worn_bodies",
]

BODIES = ("pinion", "gear")
"""Both bodies, in the order in which a scene keeps them."""


@dataclass(frozen=True, kw_only=True)
class Material:
    """Table ``[material.pinion]`` or ``[material.gear]``: an isotropic elastic body. Default: steel."""

    name: str = "steel"
    youngs_modulus_MPa: float = 207000.0
    poissons_ratio: float = 0.3


@dataclass(frozen=True, kw_only=True)
class Materials:
    """The materials of both bodies."""

    pinion: Material = Material()
    gear: Material = Material()


@dataclass(frozen=True, kw_only=True)
class Operation:
    """Table ``[operation]``: how the pair runs.

    Attributes
    ----------
    pinion_torque_Nm : float
        Torque on the pinion (driving), required.
    loaded_flank : str
        ``"drive"`` (default) or ``"coast"``, its mirror image.
    pinion_speed_rpm : float or None
        Pinion speed in rev/min; needed by the effects that depend on velocity. Default None.
    """

    pinion_torque_Nm: float
    loaded_flank: str = "drive"
    pinion_speed_rpm: float | None = None


@dataclass(frozen=True, kw_only=True)
class WearUntil:
    """Table ``[wear.until]``: where a wear run ends; exactly one of the two fields is set.

    Attributes
    ----------
    meshes : float or None
        Engagements of one gear tooth.
    control_depths_um : tuple of float or None
        Wear depths at the control point, increasing; each is a step of the result, the last one ends the run.
    """

    meshes: float | None = None
    control_depths_um: tuple[float, ...] | None = None


@dataclass(frozen=True, kw_only=True)
class ControlPoint:
    """Table ``[wear.control_point]``: the point of a flank whose wear depth is watched.

    Attributes
    ----------
    radius_mm : float
        Gear radius; of a point on the pinion, the distance from the gear's axis along the pinion's.
    height_mm : float
        Height above the gear's pitch plane, of a point on the pinion above its pitch cylinder; negative on the
        dedendum.
    body : str or None
        ``"pinion"`` or ``"gear"``. Default None: the gear if it wears, else the pinion.
    """

    radius_mm: float
    height_mm: float
    body: str | None = None

    @property
    def station_mm(self) -> float:
        """Face coordinate of the flanks [mm]."""
        return self.radius_mm


@dataclass(frozen=True, kw_only=True)
class BodyCoefficients:
    """Wear coefficients of bodies that wear differently; None for a body that does not wear.

    Attributes
    ----------
    pinion, gear : float or None
        Wear coefficient [mm2/N].
    """

    pinion: float | None = None
    gear: float | None = None


@dataclass(frozen=True, kw_only=True)
class Wear:
    """Table ``[wear]``: Archard wear. A scene without it is loaded contact only.

    Attributes
    ----------
    coefficient_mm2_per_N : float or BodyCoefficients
        Wear coefficient k: worn depth = k * pressure * sliding distance; one for both bodies, or a table
        ``{pinion = ..., gear = ...}``; required.
    until : WearUntil
        Where the run ends; required.
    worn_bodies : tuple of str
        Bodies that wear, the pinion first. Left out, or ``()``: of cylindrical gears both, else the gear, as far as
        coefficients are given for them; `Scene` fills it in (`default_worn_bodies`).
    control_point : ControlPoint or None
        Needed by ``control_depths_um``. Default None.
    """

    coefficient_mm2_per_N: float | BodyCoefficients
    until: WearUntil
    worn_bodies: tuple[str, ...] = ()
    control_point: ControlPoint | CylindricalControlPoint | FlankPointsControlPoint | None = None
    # Whether the bodies were left to their default.
    _derived: bool = field(repr=False, compare=False, default=False)

    @property
    def watched_body(self) -> str:
        """Body on whose flank the control point lies: the one that it names, else the gear if it wears."""
        named = None if self.control_point is None else self.control_point.body
        return named or default_watched_body(self.worn_bodies)

    def coefficient(self, body: str) -> float:
        """Wear coefficient of a body, ``"pinion"`` or ``"gear"`` [mm2/N].

        Raises
        ------
        SceneError
            Where the scene gives none, as it may for a body that does not wear.
        """
        if body not in BODIES:
            raise SceneError.of("body", body, " or ".join(f'"{name}"' for name in BODIES))
        given = self.coefficient_mm2_per_N
        if not isinstance(given, BodyCoefficients):
            return given
        value: float | None = getattr(given, body)
        if value is None:
            key, fix = f"wear.coefficient_mm2_per_N.{body}", "give it, or one number for both bodies"
            raise SceneError.of(key, None, "greater than 0 mm2/N", fix)
        return value


def default_worn_bodies(kind: str, coefficient: object, wear_mapping: object) -> tuple[str, ...]:
    """Bodies that wear where a scene does not say: both of a cylindrical pair, else the gear.

    Of those, the ones that have a wear coefficient; and the gear alone where the mapping ``"marched"`` asks for it.

    Parameters
    ----------
    kind : str
        ``gear_pair.type``.
    coefficient : float or BodyCoefficients
        ``wear.coefficient_mm2_per_N``.
    wear_mapping : str
        ``numerics.wear_mapping``.
    """
    usual = BODIES if kind == "cylindrical" and wear_mapping != "marched" else ("gear",)
    if not isinstance(coefficient, BodyCoefficients):
        return usual
    given = tuple(body for body in BODIES if getattr(coefficient, body) is not None)
    return tuple(body for body in usual if body in given) or given


def default_watched_body(worn: tuple[str, ...]) -> str:
    """Body of a control point that names none."""
    return "pinion" if worn == ("pinion",) else "gear"


RESOLUTION = (
    "wear_steps",
    "roll_positions",
    "face_slices",
    "cells_per_half_width",
    "profile_points",
    "harmonics",
)
"""Fields of `Numerics` that an asked accuracy decides."""


@dataclass(frozen=True, kw_only=True)
class Numerics:
    """Table ``[numerics]``: models and resolution.

    Attributes
    ----------
    accuracy : float or None
        Error asked for, relative to the greatest value of each kind of quantity: of the fields in `RESOLUTION` those
        that a scene does not give are then chosen for it. Default None: the numbers below.
    fidelity : str
        Contact model: ``"line"`` (default, line loads with Hertz across them) or ``"patch"`` (pressure resolved in
        two dimensions).
    wear_mapping : str
        ``"interpolated"`` (default, few roll positions) or ``"marched"`` (many, summed where it happens; needs
        fidelity ``"patch"``, and the gear alone to wear).
    wear_scheme : str
        ``"implicit"`` (default), ``"two-stage"`` (implicit as well; for few, long steps: one is about as good as
        three plain ones, and takes less than twice the time of one) or ``"explicit"`` (for comparison).
    wear_steps : int or "auto"
        Steps up to ``wear.until.meshes``. Default ``"auto"``.
    roll_positions : int
        Roll positions per mesh cycle. Default 24.
    face_slices : int
        Slices along the face; some of their borders lie where the roundings of its ends begin. Default 61.
    cells_per_half_width : int
        Cells of a patch across the Hertz half-width at the pitch point. Default 8.
    profile_points : int
        Points of the flank grid along the tooth height. Default 141.
    tooth_pairs : int or "auto"
        Tooth pairs that may share the load. Default ``"auto"``.
    tooth_compliance : str
        ``"prism"`` (default, finite prisms), ``"rigid"`` (local contact alone) or a netCDF file of influence data.
    harmonics : int
        Cosine terms of the prism series along the face width. Default 33.
    max_iterations : int
        Iterations of the load sharing at one roll position. Default 60.
    """

    accuracy: float | None = None
    fidelity: str = "line"
    wear_mapping: str = "interpolated"
    wear_scheme: str = "implicit"
    wear_steps: int | str = "auto"
    roll_positions: int = 24
    face_slices: int = 61
    cells_per_half_width: int = 8
    profile_points: int = 141
    tooth_pairs: int | str = "auto"
    tooth_compliance: str = "prism"
    harmonics: int = 33
    max_iterations: int = 60
    # Which fields of `RESOLUTION` were given. It matters once an accuracy is asked for, and only then to equality.
    _given: frozenset[str] = field(repr=False, compare=False, default=frozenset())
    _kept: frozenset[str] = field(init=False, repr=False, default=frozenset())

    def __post_init__(self) -> None:
        changed = {entry.name for entry in fields(self) if getattr(self, entry.name) != entry.default}
        given = frozenset(name for name in RESOLUTION if name in self._given or name in changed)
        object.__setattr__(self, "_given", given)
        object.__setattr__(self, "_kept", frozenset() if self.accuracy is None else given)

    @property
    def chosen_for_accuracy(self) -> tuple[str, ...]:
        """Fields that the asked accuracy decides; none where none is asked for."""
        return () if self.accuracy is None else tuple(name for name in RESOLUTION if name not in self._given)

    @property
    def left_out(self) -> frozenset[str]:
        """Fields of `RESOLUTION` that were left to their defaults."""
        return frozenset(RESOLUTION) - self._given
