"""The one table of result variables: group, name, dims, units, long name and published source.

Nothing else in semiwear writes a unit or a long name. A result is a tree of groups; a group is a set of
`VARIABLES`, and its dims take their labels from `COORDINATES`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from types import MappingProxyType

__all__ = [
    "COORDINATES",
    "GROUPS",
    "SCHEMA_VERSION",
    "VARIABLES",
    "Variable",
    "Zone",
    "coordinates_of",
    "variable",
    "variables_of",
]

SCHEMA_VERSION = "1"
"""Version of the result files; a file of another version is refused with a clear message."""


class Zone(IntEnum):
    """Part of a flank that a point belongs to: the pitch surface's band and its two sides (`/flank zone`)."""

    ROOT = 0
    PITCH = 1
    ADDENDUM = 2


@dataclass(frozen=True)
class Variable:
    """One variable or coordinate of a result.

    Attributes
    ----------
    group : str
        Group of the tree; empty for a coordinate, which goes wherever its dim goes.
    name : str
        Name in the dataset.
    dims : tuple of str
        Dimensions, in order; empty for a scalar.
    units : str
        Units as CF and UDUNITS write them; ``"1"`` for a pure number.
    long_name : str
        What it is, in words.
    references : str
        Published source of the quantity, or what it was measured with.
    dtype : str
        numpy dtype it is stored in; ``"str"`` for labels.
    optional : bool
        Whether a result may leave it out; a variable that could not be computed is absent.
    absent : str
        Why single values may be missing, which are NaN: the variable's attribute ``missing_because`` then says so.
        Empty where every value must be a number.
    flags : tuple of str
        Meanings of the integer values 0, 1, ... of a flag variable.
    labels : tuple of str
        The only labels a coordinate can have (``("pinion", "gear")``).
    """

    group: str
    name: str
    dims: tuple[str, ...]
    units: str
    long_name: str
    references: str
    dtype: str = "float64"
    optional: bool = False
    absent: str = ""
    flags: tuple[str, ...] = ()
    labels: tuple[str, ...] = ()

    @property
    def path(self) -> str:
        """Where it stands in the tree, e.g. ``"/history/load_share_max"``."""
        return f"/{self.group}/{self.name}"


_ISO_1122 = "ISO 1122-1:1998, Vocabulary of gear terms"
_ISO_21771 = "ISO 21771:2007, Cylindrical involute gears: concepts and geometry"
_ISO_6336_3 = "ISO 6336-3:2019, Calculation of tooth bending strength"
_ARCHARD = "Archard 1953, J. Appl. Phys. 24, 981-988; Flodin and Andersson 1997, Wear 207, 16-23"
_JOHNSON = "Johnson 1985, Contact Mechanics, chapter 4"
_LOVE = "Love 1929, Phil. Trans. R. Soc. A 228, 377-420; Johnson 1985, Contact Mechanics, chapter 3"
_LITVIN = "Litvin and Fuentes 2004, Gear Geometry and Applied Theory, chapter 9"
_FACE_GEAR = "Litvin and Fuentes 2004, Gear Geometry and Applied Theory, chapter 18"
_CONRY = "Conry and Seireg 1973, J. Eng. Ind. 95, 1115-1122"
_POLONSKY = "Polonsky and Keer 1999, Wear 231, 206-219"
_PARK = "Park and Kahraman 2009, Wear 267, 1595-1604"
_WALKER = "Walker 1938, The Engineer 166, 409-412 and 435-436"
_BLOK = "Blok 1937, Proc. General Discussion on Lubrication 2, 222-235"
_DOWSON = "Dowson and Higginson 1966, Elasto-Hydrodynamic Lubrication"
_MESH = "contact mesh of this run"
_CLOCK = "wall clock of this run"
_GRID = "numerical grid of this run"

_UNLOADED = "unloaded transmission error, gear side, positive when the gear leads"
_ON_FLANK = ("body", "profile", "face")
_ON_ROLL = ("wear_step", "roll_position")
_ON_CYCLE = ("wear_step", "mesh_position")
_ON_STEP = ("wear_step",)
_ON_STEP_BODY = ("wear_step", "body")


_PINION_ZONE = {
    Zone.ROOT: "root, which meets the gear's addendum",
    Zone.PITCH: "pitch band, which meets the gear's",
    Zone.ADDENDUM: "addendum, which meets the gear's root",
}


def _axis(
    name: str,
    units: str,
    long_name: str,
    references: str,
    dtype: str = "float64",
    labels: tuple[str, ...] = (),
) -> Variable:
    """A coordinate along its own dim."""
    return Variable("", name, (name,), units, long_name, references, dtype, labels=labels)


_EDGES_ALONE = "the pair bears on edges alone, where values depend on their rounding and on the mesh"
_NO_FILM = f"the pair bears no load, or {_EDGES_ALONE.removeprefix('the pair ')}"


def _zone_without(what: str) -> str:
    return (
        f"no roll position has its greatest pressure {what}: nothing bears there, or edges alone do "
        "(contact_pressure_max_edge of /engagement), or the roll positions are too far apart to meet it"
    )


_COORDINATES = (
    _axis("wear_step", "1", "wear step, 0 is unworn", _GRID, "int64"),
    Variable("", "meshes", _ON_STEP, "1", "engagements of one gear tooth", _PARK),
    _axis("body", "1", "toothed body", _ISO_1122, "str", ("pinion", "gear")),
    _axis("profile", "1", "flank grid index from root to tip", _GRID, "int64"),
    _axis("face", "mm", "station along the face, the radius for a face gear: middle of a slice", _ISO_1122),
    _axis("mesh_position", "1", "phase of the mesh in base pitches", _ISO_21771),
    _axis("roll_position", "1", "position of a tooth pair in base pitches, 0 at the pitch point", _ISO_21771),
    _axis("stage", "1", "stage of the computation", _CLOCK, "str"),
    _axis("effect", "1", "effect of the scene", _CLOCK, "str"),
    _axis("quantity", "1", "reported quantity", "this table", "str"),
    _axis("axis", "1", "axis of the fixed frame", _LITVIN, "str", ("x", "y", "z")),
    _axis("direction", "1", "principal direction of the contact", _JOHNSON, "str", ("along", "across")),
)

COORDINATES: Mapping[str, Variable] = MappingProxyType({entry.name: entry for entry in _COORDINATES})
"""Coordinates by name."""

_TABLE = (
    # ------------------------------------------------------------------ the flanks and their wear
    Variable(
        "flank",
        "flank_height",
        _ON_FLANK,
        "mm",
        "height above the pitch plane, for a pinion above its pitch cylinder",
        _ISO_1122,
    ),
    Variable("flank", "flank_radius", _ON_FLANK, "mm", "radius about the body's own axis", _ISO_1122),
    Variable(
        "flank",
        "zone",
        _ON_FLANK,
        "1",
        "side of the pitch surface",
        _LITVIN,
        "int8",
        flags=tuple(zone.name.lower() for zone in Zone),
    ),
    Variable(
        "flank",
        "active",
        _ON_FLANK,
        "1",
        "whether the mating flank reaches the point",
        _ISO_21771,
        "int8",
        flags=("inactive", "active"),
    ),
    Variable(
        "flank",
        "specific_sliding",
        _ON_FLANK,
        "1",
        "sliding velocity over the contact's own velocity on the flank",
        _ISO_21771,
    ),
    Variable(
        "flank",
        "surface_error",
        ("body",),
        "um",
        "estimated error of the surface through given points, along its normal; 95 % of the flank are within",
        "de Boor 2001, A Practical Guide to Splines, ch. 17",
        optional=True,
    ),
    Variable("flank", "wear_depth", ("wear_step", *_ON_FLANK), "um", "wear depth along the normal", _ARCHARD),
    Variable(
        "flank",
        "contact_pattern",
        ("wear_step", "profile", "face"),
        "MPa",
        "greatest pressure that a point of the gear's flank feels in a mesh",
        _LITVIN,
        optional=True,
    ),
    # ------------------------------------------------------------------ one tooth pair, entry to exit
    Variable("engagement", "load_share", _ON_ROLL, "1", "share of the load on the tooth pair", _CONRY),
    Variable(
        "engagement",
        "contact_pressure_max",
        _ON_ROLL,
        "MPa",
        "greatest contact pressure away from borders, or that of the edge where nothing else bears",
        _JOHNSON,
    ),
    Variable(
        "engagement",
        "contact_pressure_on_edge",
        _ON_ROLL,
        "1",
        "where the greatest contact pressure is: on an edge alone, it depends on the mesh",
        _JOHNSON,
        "int8",
        optional=True,
        flags=("flank", "edge"),
    ),
    Variable(
        "engagement",
        "contact_pressure_max_edge",
        _ON_ROLL,
        "MPa",
        "greatest contact pressure at the borders, mesh-dependent",
        _JOHNSON,
        optional=True,
    ),
    Variable(
        "engagement",
        "tip_load_share",
        (*_ON_ROLL, "body"),
        "1",
        "share of the load on slices in which the tip edge of the body presses",
        _WALKER,
        optional=True,
    ),
    Variable(
        "engagement",
        "line_load",
        (*_ON_ROLL, "face"),
        "N/mm",
        "load per length of the contact line; times line_length it is the normal force on the slice, "
        "and times lever_arm the moment of that force about the pinion's axis",
        _CONRY,
        optional=True,
    ),
    Variable(
        "engagement",
        "line_length",
        ("roll_position", "face"),
        "mm",
        "length of the contact line in the slice",
        _CONRY,
        optional=True,
    ),
    Variable(
        "engagement",
        "lever_arm",
        ("roll_position", "face"),
        "mm",
        "lever arm of the normal force about the pinion's axis; forces times levers of all pairs at a mesh position "
        "are the pinion's torque, less what friction takes",
        _LITVIN,
        optional=True,
    ),
    Variable(
        "engagement",
        "sliding_distance",
        (*_ON_ROLL, "body"),
        "mm",
        "sliding distance of a flank point in one mesh, where the pressure is greatest",
        _PARK,
        absent=_EDGES_ALONE,
    ),
    Variable(
        "engagement",
        "root_stress",
        (*_ON_ROLL, "body"),
        "MPa",
        "greatest tangential stress of the root fillet, tensile side",
        _ISO_6336_3,
        optional=True,
    ),
    Variable(
        "engagement",
        "friction_coefficient",
        _ON_ROLL,
        "1",
        "coefficient of friction of the tooth pair, weighted with the load",
        "ISO/TR 14179-2:2001, Gears: thermal capacity",
        optional=True,
        absent="the pair bears no load",
    ),
    Variable(
        "engagement",
        "friction_power_loss",
        _ON_ROLL,
        "W",
        "power that friction takes on the tooth pair; per rad/s of the pinion where the scene gives no speed",
        "Ohlendorf 1958, dissertation, TU Munich",
        optional=True,
    ),
    Variable(
        "engagement",
        "flash_temperature_max",
        _ON_ROLL,
        "K",
        "greatest rise of the surface temperature, away from edges",
        _BLOK,
        optional=True,
        absent=_EDGES_ALONE,
    ),
    Variable(
        "engagement",
        "film_thickness_min",
        _ON_ROLL,
        "um",
        "least oil film thickness, away from edges",
        _DOWSON,
        optional=True,
        absent=_NO_FILM,
    ),
    # ------------------------------------------------------------------ one mesh cycle
    Variable(
        "mesh_cycle",
        "transmission_error_loaded",
        _ON_CYCLE,
        "arcsec",
        "loaded transmission error, gear side, positive when the gear leads",
        _LITVIN,
    ),
    Variable("mesh_cycle", "transmission_error_unloaded", _ON_CYCLE, "arcsec", _UNLOADED, _LITVIN),
    Variable("mesh_cycle", "pairs_in_contact", _ON_CYCLE, "1", "tooth pairs that carry load", _ISO_21771, "int32"),
    # ------------------------------------------------------------------ one value a wear step
    Variable("history", "wear_depth_max_root", _ON_STEP, "um", "greatest wear at the gear's root", _ARCHARD),
    Variable("history", "wear_depth_max_addendum", _ON_STEP, "um", "greatest wear at the gear's addendum", _ARCHARD),
    Variable("history", "wear_depth_max_pitch", _ON_STEP, "um", "greatest wear in the gear's pitch band", _ARCHARD),
    Variable(
        "history",
        "wear_depth_max",
        _ON_STEP_BODY,
        "um",
        "greatest wear of each body's flank; 0 where it does not wear",
        _ARCHARD,
        optional=True,
    ),
    *(
        Variable(
            "history",
            f"wear_depth_max_pinion_{zone.name.lower()}",
            _ON_STEP,
            "um",
            f"greatest wear at the pinion's {_PINION_ZONE[zone]}",
            _ARCHARD,
            optional=True,
        )
        for zone in Zone
    ),
    Variable(
        "history",
        "wear_depth_control_point",
        _ON_STEP,
        "um",
        "wear at the control point, on the body that the scene names",
        _ARCHARD,
        optional=True,
    ),
    Variable(
        "history",
        "wear_depth_max_pinion",
        _ON_STEP,
        "um",
        "greatest wear on the pinion's flank",
        _ARCHARD,
        optional=True,
    ),
    Variable(
        "history",
        "wear_volume",
        _ON_STEP_BODY,
        "mm^3",
        "volume worn off the flank of one tooth, between the roundings of its edges",
        _ARCHARD,
        optional=True,
    ),
    Variable(
        "history",
        "wear_volume_on_edges",
        _ON_STEP_BODY,
        "mm^3",
        "volume worn off the roundings of tip and ends of one tooth, which is in no map of wear",
        _ARCHARD,
        optional=True,
    ),
    Variable("history", "load_share_max", _ON_STEP, "1", "greatest share of the load on a tooth pair", _CONRY),
    Variable(
        "history",
        "root_stress_max",
        _ON_STEP_BODY,
        "MPa",
        "greatest tangential root stress over the engagement",
        _ISO_6336_3,
        optional=True,
    ),
    Variable(
        "history",
        "contact_pressure_root",
        _ON_STEP,
        "MPa",
        "greatest pressure at the gear's root, clear of the pitch band",
        _JOHNSON,
        absent=_zone_without("at the gear's root, clear of the pitch band"),
    ),
    Variable(
        "history",
        "contact_pressure_addendum",
        _ON_STEP,
        "MPa",
        "greatest pressure at the gear's addendum, clear of the pitch band",
        _JOHNSON,
        absent=_zone_without("at the gear's addendum, clear of the pitch band"),
    ),
    Variable(
        "history",
        "contact_pressure_pitch",
        _ON_STEP,
        "MPa",
        "greatest pressure in the gear's pitch band",
        _JOHNSON,
        absent=_zone_without("within the pitch band"),
    ),
    Variable(
        "history",
        "tip_relief_to_free",
        _ON_STEP_BODY,
        "um",
        "further relief of the tip with which its edge would bear nothing; 0 where it does not press",
        _WALKER,
        optional=True,
    ),
    Variable(
        "history",
        "subsurface_stress_max",
        _ON_STEP,
        "MPa",
        "greatest von Mises stress below the gear's surface, where the pressure is greatest",
        _LOVE,
        optional=True,
    ),
    Variable(
        "history",
        "subsurface_stress_depth",
        _ON_STEP,
        "mm",
        "depth of the greatest von Mises stress",
        _LOVE,
        optional=True,
    ),
    Variable(
        "history",
        "transmission_error_mean",
        _ON_STEP,
        "arcsec",
        "mean of the loaded transmission error",
        _LITVIN,
    ),
    Variable(
        "history",
        "transmission_error_amplitude",
        _ON_STEP,
        "arcsec",
        "peak to peak of the loaded transmission error",
        _LITVIN,
    ),
    Variable(
        "history",
        "mesh_efficiency",
        _ON_STEP,
        "1",
        "efficiency of the mesh: one less the friction loss over the power that goes in",
        "Ohlendorf 1958, dissertation, TU Munich",
        optional=True,
    ),
    Variable(
        "history",
        "friction_power_loss_mean",
        _ON_STEP,
        "W",
        "power that friction takes of the mesh, mean over a mesh cycle",
        "Ohlendorf 1958, dissertation, TU Munich",
        optional=True,
    ),
    Variable(
        "history",
        "contact_temperature_max",
        _ON_STEP,
        "degC",
        "greatest bulk and flash temperature together, away from edges",
        _BLOK,
        optional=True,
        absent=f"at every roll position {_EDGES_ALONE}",
    ),
    Variable(
        "history",
        "lambda_ratio_min",
        _ON_STEP,
        "1",
        "least film thickness over the roughness of both flanks, away from edges",
        _DOWSON,
        optional=True,
        absent=f"at every roll position {_NO_FILM}",
    ),
    # ------------------------------------------------------------------ life until a depth of wear
    Variable("life", "depth_limit", (), "um", "depth of wear that ends the life", _ARCHARD),
    Variable("life", "meshes_to_limit", (), "1", "engagements of one gear tooth until the depth limit", _ARCHARD),
    Variable("life", "hours_to_limit", (), "h", "running time until the depth limit", _ARCHARD, optional=True),
    Variable(
        "life",
        "sensitivity_to_wear_coefficient",
        (),
        "1",
        "relative change of the life over that of the wear coefficient",
        _ARCHARD,
    ),
    Variable(
        "life",
        "sensitivity_to_torque",
        (),
        "1",
        "relative change of the life over that of the torque",
        _ARCHARD,
    ),
    # ------------------------------------------------------------------ how well it was computed
    Variable(
        "diagnostics",
        "iterations",
        _ON_STEP,
        "1",
        "iterations of the contact solver in the wear step",
        _POLONSKY,
        "int64",
        optional=True,
    ),
    Variable(
        "diagnostics",
        "load_balance_residual",
        _ON_STEP,
        "1",
        "greatest torque residual over the torque",
        _CONRY,
        optional=True,
    ),
    Variable(
        "diagnostics",
        "complementarity_residual",
        _ON_STEP,
        "1",
        "greatest product of pressure over its peak and gap over approach",
        _POLONSKY,
        optional=True,
    ),
    Variable(
        "diagnostics",
        "edge_residual",
        _ON_STEP,
        "1",
        "greatest change of a slice's force in the last pass over pressed edges, over the greatest force",
        _JOHNSON,
        optional=True,
    ),
    Variable(
        "diagnostics",
        "wear_law_residual",
        _ON_STEP,
        "1",
        "change of the wear coefficient in the last iteration with the loads of a step, over the greatest",
        _ARCHARD,
        optional=True,
    ),
    Variable(
        "diagnostics",
        "wear_volume_residual",
        _ON_STEP_BODY,
        "1",
        "volume worn off flank and edges over the wear coefficient times force times sliding distance, less one",
        _ARCHARD,
        optional=True,
    ),
    Variable(
        "diagnostics",
        "elements_across",
        _ON_ROLL,
        "1",
        "elements across the contact where it is widest",
        _MESH,
        optional=True,
    ),
    Variable(
        "diagnostics",
        "reaches_border",
        _ON_ROLL,
        "1",
        "whether the contact reaches the border of the refined patch",
        _MESH,
        optional=True,
    ),
    Variable(
        "diagnostics",
        "edge_contact",
        _ON_ROLL,
        "1",
        "whether an edge carries load or the greatest pressure, which then depends on the mesh",
        _MESH,
        optional=True,
    ),
    Variable(
        "diagnostics",
        "smallest_gap",
        _ON_CYCLE,
        "mm",
        "smallest gap under load, a penetration where negative",
        _MESH,
        optional=True,
    ),
    Variable("diagnostics", "seconds", ("stage",), "s", "time spent in the stage", _CLOCK, optional=True),
    Variable(
        "diagnostics",
        "effect_seconds",
        ("effect",),
        "s",
        "time that an effect took by itself; what is woven into the contact solution is not in it",
        _CLOCK,
        optional=True,
    ),
    Variable(
        "diagnostics",
        "error_estimate",
        ("quantity",),
        "1",
        "estimated relative error of the reported quantity",
        "Richardson 1911, Phil. Trans. R. Soc. A 210, 307-357",
        optional=True,
    ),
    # ------------------------------------------------------------------ unloaded tooth contact analysis
    Variable(
        "tooth_contact",
        "path_of_contact",
        ("roll_position", "axis"),
        "mm",
        "path of contact, fixed frame",
        _LITVIN,
    ),
    Variable("tooth_contact", "transmission_error", ("roll_position",), "arcsec", _UNLOADED, _LITVIN),
    Variable(
        "tooth_contact",
        "principal_relative_curvature",
        ("roll_position", "direction"),
        "1/mm",
        "principal relative curvature",
        _JOHNSON,
    ),
    Variable(
        "tooth_contact",
        "contact_ellipse_angle",
        ("roll_position",),
        "deg",
        "angle of the contact ellipse's long axis to the face direction",
        _LITVIN,
    ),
    Variable("tooth_contact", "contact_ratio", (), "1", "unloaded contact ratio", _ISO_21771),
    Variable(
        "tooth_contact",
        "undercut_radius",
        (),
        "mm",
        "gear radius within which the shaper undercuts",
        _FACE_GEAR,
        optional=True,
    ),
    Variable(
        "tooth_contact",
        "pointing_radius",
        (),
        "mm",
        "gear radius beyond which the tooth is pointed",
        _FACE_GEAR,
        optional=True,
    ),
)

VARIABLES: Mapping[tuple[str, str], Variable] = MappingProxyType({(v.group, v.name): v for v in _TABLE})
"""Every variable of every group, by (group, name)."""

GROUPS: tuple[str, ...] = tuple(dict.fromkeys(v.group for v in _TABLE))
"""Groups in the order of the tree."""


def variable(group: str, name: str) -> Variable | None:
    """Entry of a variable, or of a coordinate that the group can carry; None where there is none."""
    return VARIABLES.get((group, name)) or (COORDINATES[name] if name in coordinates_of(group) else None)


def variables_of(group: str) -> tuple[Variable, ...]:
    """Variables of a group, in order."""
    return tuple(v for v in _TABLE if v.group == group)


def coordinates_of(group: str) -> tuple[str, ...]:
    """Names of the coordinates that a group can carry: those of its dims, and `meshes` on `wear_step`."""
    dims = {dim for v in variables_of(group) for dim in v.dims}
    return tuple(name for name, entry in COORDINATES.items() if set(entry.dims) <= dims)
