"""A gear pair whose flanks are given as points: table ``[gear_pair]`` with ``type = "flank_points"``."""

from __future__ import annotations

from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any, ClassVar

from semiwear.scene.defaults import DerivedDefault

__all__ = ["FLANK_POINTS_DEFAULTS", "FlankPointsControlPoint", "FlankPointsPair"]

FLANK_POINTS_DEFAULTS: dict[str, DerivedDefault] = {}

Vector = tuple[float, float, float]


def _content(path: str) -> str:
    """Digest of a plain file; empty where it cannot be read, which is a problem of another place."""
    try:
        return sha256(Path(path).read_bytes()).hexdigest() if Path(path).is_file() else ""
    except (OSError, ValueError):
        return ""


def _tupled(value: Any) -> Any:
    return tuple(float(item) for item in value)


@dataclass(frozen=True, kw_only=True)
class FlankPointsPair:
    """Table ``[gear_pair]``: one flank of each body as a grid of points, on axes that may lie anywhere.

    The pinion drives. The points of a body are given in its own frame: its axis is z, any direction across it is x
    (the angle of the tooth about its axis is found from the contact). Rows run from root to tip, columns along the
    tooth (`semiwear.geometry.point_grid` describes the files). Axes are given in the fixed frame of
    `semiwear.scene.Placement`, whose z axis should lie along the pinion's. Spiral bevel, hypoid, worm and any other
    pair with a constant ratio. Two such tables are equal only if their files hold the same.

    Attributes
    ----------
    type : str
        Kind of gear pair: ``"flank_points"``.
    pinion_file, gear_file : str
        Files of points, .nc or .csv.
    pinion_teeth, gear_teeth : int
        Numbers of teeth, without sign.
    pinion_axis_point_mm, gear_axis_point_mm : three numbers
        Where the origin of the body's own frame lies in the fixed frame. Default [0, 0, 0].
    pinion_axis_direction, gear_axis_direction : three numbers
        Direction of the body's own z axis in the fixed frame; of any length. Default of the pinion: [0, 0, 1].
    pinion_rotation, gear_rotation : str
        Sense in which the body turns about its axis direction: ``"positive"`` (right-handed) or ``"negative"``.
        It says which side of a flank is out of the material: the pinion pushes, the gear is pushed.
    smoothing_um : float or "auto"
        Root mean square by which the surface may miss the points. 0: it runs through all of them. Default
        ``"auto"``: through all of them, unless they are noisy; then as much as their noise.
    pinion_tooth_thickness_mm, gear_tooth_thickness_mm : float or "auto"
        Tooth thickness in the normal section where the flank crosses the pitch surface. Default: half the pitch.
        This and the next three describe the sections of teeth that bend, where the file of points brings none.
    pinion_fillet_radius_mm, gear_fillet_radius_mm : float or "auto"
        Radius of the arc between flank and root. Default 0.3 normal modules.
    pinion_root_depth_mm, gear_root_depth_mm : float or "auto"
        From the lower end of the flank to the root. Default: what the arc takes.
    pinion_rim_thickness_mm, gear_rim_thickness_mm : float or "auto"
        Material between the root and where the body is held. Default 2.5 normal modules.
    pinion_tip_edge_radius_mm, gear_tip_edge_radius_mm : float or "auto"
        Edge rounding between flank and tip. Default 0.0444 normal modules, as of a
        cylindrical pair.
    pinion_end_edge_radius_mm, gear_end_edge_radius_mm : float or "auto"
        Edge rounding between flank and end faces. Default 0.0444 normal modules, as of a
        cylindrical pair.
    """

    references: ClassVar[tuple[str, ...]] = (
        "Litvin and Fuentes 2004, Gear Geometry and Applied Theory, ch. 2, 3 and 9",
        "de Boor 2001, A Practical Guide to Splines, ch. 17",
    )

    type: str
    pinion_file: str
    gear_file: str
    pinion_teeth: int
    gear_teeth: int
    pinion_axis_point_mm: Vector = (0.0, 0.0, 0.0)
    pinion_axis_direction: Vector = (0.0, 0.0, 1.0)
    gear_axis_point_mm: Vector = (0.0, 0.0, 0.0)
    gear_axis_direction: Vector
    pinion_rotation: str
    gear_rotation: str
    smoothing_um: float | str = "auto"
    pinion_tooth_thickness_mm: float | str = "auto"
    gear_tooth_thickness_mm: float | str = "auto"
    pinion_fillet_radius_mm: float | str = "auto"
    gear_fillet_radius_mm: float | str = "auto"
    pinion_root_depth_mm: float | str = "auto"
    gear_root_depth_mm: float | str = "auto"
    pinion_rim_thickness_mm: float | str = "auto"
    gear_rim_thickness_mm: float | str = "auto"
    pinion_tip_edge_radius_mm: float | str = "auto"
    gear_tip_edge_radius_mm: float | str = "auto"
    pinion_end_edge_radius_mm: float | str = "auto"
    gear_end_edge_radius_mm: float | str = "auto"
    # No default follows from another field.
    _derived: frozenset[str] = field(init=False, repr=False, compare=False, default=frozenset())
    # What the files held when the table was made: what is kept for a table must not outlive a change of its files.
    _contents: tuple[str, str] = field(init=False, repr=False, default=("", ""))

    def __post_init__(self) -> None:
        for body in ("pinion", "gear"):
            for name in (f"{body}_axis_point_mm", f"{body}_axis_direction"):
                object.__setattr__(self, name, _tupled(getattr(self, name)))
        object.__setattr__(self, "_contents", (_content(self.pinion_file), _content(self.gear_file)))

    @property
    def description(self) -> str:
        """What it is, in a few words."""
        return f"flanks as points {self.pinion_teeth}/{self.gear_teeth}"


@dataclass(frozen=True, kw_only=True)
class FlankPointsControlPoint:
    """Table ``[wear.control_point]`` of flanks given as points: the point of a flank that is watched.

    Attributes
    ----------
    face_mm : float
        Face coordinate of the file, or, where it gives none, the length along the tooth from its middle.
    height_mm : float
        Height above the pitch surface, normal to it, towards the tip; negative on the dedendum.
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
