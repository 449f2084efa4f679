"""A gear pair whose flanks are given as points: table ``[gear_pair]`` with ``type = "flank_points"``."""

from __future__ import annotations

from dataclasses import field
from hashlib import sha256
from math import hypot
from pathlib import Path
from typing import ClassVar

from semiwear.errors import SceneError
from semiwear.scene.declare import declared, table
from semiwear.scene.rule import Rule, any_number, at_least_zero, between, choice, grid_file, or_auto, positive
from semiwear.scene.rules import watched_body
from semiwear.scene.values import number, numbers, whole
from semiwear.untyped import Value

Vector = tuple[float, float, float]


def _content(path: str) -> str:
    """Digest of a plain file; empty if it cannot be read, which is reported elsewhere."""
    try:
        return sha256(Path(path).read_bytes()).hexdigest() if Path(path).is_file() else ""
    except (OSError, ValueError):
        return ""


_EDGE = '0 for a sharp edge; "auto" is 0.044 normal modules'
_TEETH = "count the teeth of the whole body; of a worm its threads"
_NOISE = "the noise of the points: 0 for none, 0.5 to 3 for measured flanks"


def _length(fix: str, meaning: str) -> Value:
    return declared(or_auto(positive(fix), '"auto" or greater than 0 mm'), meaning, default="auto")


def _tooth_thickness(body: str) -> Value:
    meaning = (
        f"Tooth thickness of the {body} in the normal section at the pitch surface. Left out: half the pitch. With "
        "the next three fields it describes the section of the tooth for bending, if the file of points has none."
    )
    return _length('in the normal section, at the pitch surface; "auto" is half the pitch', meaning)


def _fillet_radius(body: str) -> Value:
    meaning = f"Radius of the arc between flank and root of the {body}. Left out: 0.3 normal modules."
    return _length('the arc between flank and root; "auto" is 0.3 normal modules', meaning)


def _root_depth(body: str) -> Value:
    meaning = f"Distance from the lower end of the {body}'s flank to its root. Left out: the height of the fillet."
    return _length('from the lower end of the flank to the root; "auto" is the height of the fillet', meaning)


def _rim_thickness(body: str) -> Value:
    meaning = f"Rim thickness of the {body} below the root, down to where it is fixed. Left out: 2.5 normal modules."
    return _length('material under the root; "auto" is 2.5 normal modules', meaning)


def _edge_radius(body: str, border: str) -> Value:
    meaning = f"Rounding between flank and {border} of the {body}. Left out: 0.0444 normal modules."
    return declared(or_auto(at_least_zero(_EDGE), '"auto", 0 mm or greater'), meaning, default="auto")


def _axis_point(body: str) -> Value:
    fix = "the origin of the body's own frame, in the fixed frame"
    rule = Rule(numbers, "three numbers of mm", lambda value: len(value) == 3, fix)
    meaning = f"Origin of the {body}'s own frame, in the fixed frame."
    return declared(rule, meaning, default=(0.0, 0.0, 0.0))


def _file() -> Rule:
    fix = "name a file from export_flank or write_points; its name ends with .nc or .csv"
    return grid_file("a .nc or .csv file of points", fix)


def _direction() -> Rule:
    fix = "give the direction of the body's own z axis in the fixed frame, e.g. [0, 0, 1]"
    return Rule(numbers, "three numbers, not all 0", lambda value: len(value) == 3 and hypot(*value) > 0.0, fix)


@table
class FlankPointsPair:
    """Table ``[gear_pair]``: one flank of each body as a grid of points, on axes that may lie anywhere.

    The pinion drives. The points of a body are given in its own frame: its axis is z, any direction across it is x
    (the angle of the tooth about its axis is found from the contact). Rows run from root to tip, columns along the
    tooth (`semiwear.geometry.point_grid` describes the files). Axes are given in the fixed frame of
    `semiwear.scene.Placement`, whose z axis should lie along the pinion's. For spiral bevel, hypoid, worm and any
    other pair with a constant ratio. Two such tables are equal only if their files have the same content.
    """

    pitch_surfaces: ClassVar[tuple[str, str, str]] = ("pitch surface", "pitch surface", "pitch surface")
    both_wear: ClassVar[bool] = False
    references: ClassVar[tuple[str, ...]] = (
        "Litvin and Fuentes 2004, Gear Geometry and Applied Theory, ch. 2, 3 and 9",
        "de Boor 2001, A Practical Guide to Splines, ch. 17",
    )

    type: str = declared(choice("flank_points"), "Kind of gear pair.")
    pinion_file: str = declared(_file(), "File of the pinion's points.")
    gear_file: str = declared(_file(), "File of the gear's points.")
    pinion_teeth: int = declared(
        between(whole, 1, 1000, _TEETH), "Number of teeth of the pinion, without sign; of a worm its threads."
    )
    gear_teeth: int = declared(between(whole, 2, 1000, _TEETH), "Number of teeth of the gear, without sign.")
    pinion_axis_point_mm: Vector = _axis_point("pinion")
    pinion_axis_direction: Vector = declared(
        _direction(),
        "Direction of the pinion's own z axis in the fixed frame, of any length.",
        default=(0.0, 0.0, 1.0),
    )
    gear_axis_point_mm: Vector = _axis_point("gear")
    gear_axis_direction: Vector = declared(
        _direction(), "Direction of the gear's own z axis in the fixed frame, of any length."
    )
    pinion_rotation: str = declared(
        choice("positive", "negative"),
        "Sense of rotation of the pinion about its axis direction (positive: right-handed). It decides on which side "
        "of a flank the material is, since the pinion drives.",
    )
    gear_rotation: str = declared(
        choice("positive", "negative"), "Sense of rotation of the gear about its axis direction; the gear is driven."
    )
    smoothing_um: float | str = declared(
        or_auto(between(number, 0.0, 100.0, _NOISE), '"auto" or 0 um to 100 um'),
        "Root mean square deviation of the fitted surface from the points; 0: it interpolates them. Left out: the "
        "noise of the points, 0 for smooth points.",
        default="auto",
    )
    pinion_tooth_thickness_mm: float | str = _tooth_thickness("pinion")
    gear_tooth_thickness_mm: float | str = _tooth_thickness("gear")
    pinion_fillet_radius_mm: float | str = _fillet_radius("pinion")
    gear_fillet_radius_mm: float | str = _fillet_radius("gear")
    pinion_root_depth_mm: float | str = _root_depth("pinion")
    gear_root_depth_mm: float | str = _root_depth("gear")
    pinion_rim_thickness_mm: float | str = _rim_thickness("pinion")
    gear_rim_thickness_mm: float | str = _rim_thickness("gear")
    pinion_tip_edge_radius_mm: float | str = _edge_radius("pinion", "tip")
    gear_tip_edge_radius_mm: float | str = _edge_radius("gear", "tip")
    pinion_end_edge_radius_mm: float | str = _edge_radius("pinion", "end faces")
    gear_end_edge_radius_mm: float | str = _edge_radius("gear", "end faces")
    # no default follows from another field
    _derived: frozenset[str] = field(init=False, repr=False, compare=False, default=frozenset())
    # digests of the files when the table was made, since data cached for a table depend on them
    _contents: tuple[str, str] = field(init=False, repr=False, default=("", ""))

    def __post_init__(self) -> None:
        for body in ("pinion", "gear"):
            for name in (f"{body}_axis_point_mm", f"{body}_axis_direction"):
                object.__setattr__(self, name, tuple(map(float, getattr(self, name))))
        object.__setattr__(self, "_contents", (_content(self.pinion_file), _content(self.gear_file)))

    def mirrored(self) -> FlankPointsPair:
        """Always an error, since only one flank of each body is given.

        Raises
        ------
        SceneError
        """
        fix = "give the points of the coast flanks, and turn both rotations"
        raise SceneError.of("operation.loaded_flank", "coast", '"drive": only that flank is given', fix)

    @property
    def description(self) -> str:
        """The pair in a few words."""
        return f"flanks as points {self.pinion_teeth}/{self.gear_teeth}"


@table
class FlankPointsControlPoint:
    """Table ``[wear.control_point]`` of flanks given as points: the point of a flank that is watched."""

    face_mm: float = declared(
        any_number("the face coordinate of the gear's points"),
        "Face coordinate of the file, or, if it has none, the length along the tooth from its middle.",
    )
    height_mm: float = declared(
        any_number("above the pitch surface, negative on the dedendum"),
        "Height above the pitch surface, normal to it, towards the tip; negative on the dedendum.",
    )
    body: str | None = watched_body()

    @property
    def station_mm(self) -> float:
        """Face coordinate of the flanks [mm]."""
        return self.face_mm
