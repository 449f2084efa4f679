"""Meshes of both bodies whose refined patches follow the contact lines, and their candidate contact surfaces."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from fem_reference.arrays import BoolArray, FloatArray, IntArray
from fem_reference.contact import ContactPair
from fem_reference.elasticity import ElasticBody
from fem_reference.moved_nodes import moved_flanks
from fem_reference.pair_motion import PairMotion, Pose, rounded
from fem_reference.pairs import body_mesh, module_of
from fem_reference.rigid_lines import Forecast, RigidFlank, RigidLine, effective_modulus
from fem_reference.root_load import BODIES
from fem_reference.surface import Surface
from fem_reference.tooth_mesh import LOADED, Divisions, FlankGrid, Refinement, ToothMesh
from semiwear.errors import SceneError

WORN_FLANK = ("gap", "moved_nodes")
"""Treatment of wear: as a gap over the unworn mesh, or by nodes moved along their normals."""

FEWEST_TEETH = 5
"""Teeth in the mesh of a body: fewer leave out some that touch."""

_MASTER = 1.4  # the pinion's candidates reach this much farther than the gear's
_LEAST_WIDTH = 0.4  # of the widest pair's half-width: least half-width for which the others are meshed
_LIGHT, _LIGHT_WIDTH = 0.1, 0.8  # share of the load below which elements may be larger, and how large in the same way
_APPROACH = 1.5  # forecast approaches that are allowed for
_AT_END = 0.08  # of the element length: elements at the ends of a contact are no shorter, however sharp the edge
_LENGTH, _LENGTHS = 0.4, 14  # modules of an element along the line, and fewest elements over the face
_APART = 0.16  # modules: the gap where nothing lies opposite
_REACH = 0.32  # modules, of facets that are tried against each other
_BESIDE = 0.16  # modules of face that are meshed finely beyond the contact


@dataclass(frozen=True)
class MeshSettings:
    """Resolution of the contact meshes.

    Attributes
    ----------
    elements_per_half_width : float
        Elements across the expected half-width of the contact on the present flank, worn or not.
    element_length : float
        Length of elements along the line [mm]; see `usual_element_length`.
    gear_teeth, pinion_teeth : int
        Teeth in the meshes; the bore and the back face are held, the cut planes free. None is every tooth (of
        cylindrical gears).
    growth : float
        Growth of elements outside the patch, mm for each mm.
    patch : float
        Half the refined width over the forecast half-width.
    wider : dict from pair to float
        Factors on `patch` for single pairs.
    worn_flank : str
        One of `WORN_FLANK`.
    """

    elements_per_half_width: float
    element_length: float
    gear_teeth: int | None = 5
    pinion_teeth: int | None = 9
    growth: float = 0.6
    patch: float = 1.4
    wider: Mapping[int, float] = field(default_factory=dict)
    worn_flank: str = "gap"

    def __post_init__(self) -> None:
        if self.worn_flank not in WORN_FLANK:
            raise SceneError.of("worn_flank", self.worn_flank, f"one of {', '.join(WORN_FLANK)}")
        for name in ("elements_per_half_width", "element_length"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise SceneError.of(name, getattr(self, name), "a finite number > 0")
        for name, teeth in (("teeth", self.gear_teeth), ("pinion_teeth", self.pinion_teeth)):
            if teeth is not None and not (teeth >= FEWEST_TEETH and teeth % 1 == 0):
                raise SceneError.of(name, teeth, f"a whole number >= {FEWEST_TEETH}")


def usual_element_length(pair: PairMotion) -> float:
    """Length of elements along the line unless it is given [mm]: `_LENGTH`, or a share of a narrow face."""
    low, high = pair.gear_face
    return min(_LENGTH * module_of(pair.scene), (high - low) / _LENGTHS)


def line_meshes(
    flank: RigidFlank, mesh_position: float, expected: Forecast, settings: MeshSettings
) -> dict[str, ToothMesh]:
    """Meshes of gear and pinion in their own frames for a mesh position."""
    scene = flank.pair.scene
    divisions = Divisions.of_module(module_of(scene))
    divisions = replace(divisions, depth=4, face_size=2.0 * settings.element_length)
    refined = _refinements(flank, expected, settings)
    meshed = partial(body_mesh, divisions=divisions, detailed=(), explicit=0)
    gear = meshed(scene, "gear", teeth=settings.gear_teeth, refinements=refined["gear"])
    if settings.worn_flank == "moved_nodes":
        gear = moved_flanks(gear, flank.wear, {-j for j in expected.lines})
    pinion = meshed(scene, "pinion", teeth=settings.pinion_teeth, refinements=refined["pinion"])
    return {"gear": gear, "pinion": pinion}


@dataclass(frozen=True)
class Candidates:
    """Candidate contact surfaces of a pair, and the gap between them; arrays are over all nodes of the gear.

    Attributes
    ----------
    contact : ContactPair
        Its gap is that of `fresh` alone.
    fresh : array [mm]
        Distance of the meshed flanks, roundings of the edges included.
    moved : array [mm]
        Wear by which the nodes were moved already.
    face, profile : arrays [mm]
        Coordinates on the gear's flank; zero elsewhere.
    pinion_face, pinion_profile : arrays [mm]
        The corresponding points of the pinion.
    on_flank : int array
        Nodes for which these are defined.
    """

    contact: ContactPair
    fresh: FloatArray
    moved: FloatArray
    face: FloatArray
    profile: FloatArray
    pinion_face: FloatArray
    pinion_profile: FloatArray
    on_flank: IntArray

    def gap(self, flank: RigidFlank) -> FloatArray:
        """Gap at all nodes with the wear of a flank [mm]."""
        gap, at = self.fresh.copy(), self.on_flank
        worn = flank.wear.depth(self.face[at], self.profile[at]) - self.moved[at]
        gap[at] = np.minimum(gap[at] + worn, _apart(flank))
        return gap


def _apart(flank: RigidFlank) -> float:
    """Gap where nothing lies opposite [mm]."""
    return _APART * module_of(flank.pair.scene)


def _patch(flank: RigidFlank, expected: Forecast, pair: int, settings: MeshSettings) -> tuple[RigidLine, float]:
    """Middle of the patch of a pair, the unworn line, and half its width [mm]: the possible contact and a margin."""
    line, load = expected.lines[pair], expected.line_load[pair]
    middle = RigidFlank(flank.pair).line(line.roll)
    widest = max(float(width.max()) for width in expected.half_width.values())
    width = max(float(expected.half_width[pair].max()), _LEAST_WIDTH * widest)
    rise = 2.0 * load / (np.pi * effective_modulus(flank.pair.scene))
    # patches of lightly loaded pairs stay small: `reaches_border` reports contact beyond them
    aside = max(line.farthest(rise, middle.profile) - width, 0.0) if expected.share(pair) > _LIGHT else 0.0
    return middle, settings.wider.get(pair, 1.0) * (settings.patch * width + aside)


def _element_size(expected: Forecast, pair: int, settings: MeshSettings) -> float:
    """Size of the elements across the line of a pair [mm]."""
    usual = max(expected.usual_half_width(k) for k in expected.lines)
    least = _LEAST_WIDTH if expected.share(pair) > _LIGHT else _LIGHT_WIDTH
    return max(expected.usual_half_width(pair), least * usual) / settings.elements_per_half_width


def _refinements(flank: RigidFlank, expected: Forecast, settings: MeshSettings) -> dict[str, dict[int, Refinement]]:
    """Refined patches of all loaded teeth of both bodies: pair j is pinion tooth j on gear tooth -j."""
    result: dict[str, dict[int, Refinement]] = {name: {} for name in BODIES}
    beside = _BESIDE * module_of(flank.pair.scene)
    for j, line in expected.lines.items():
        middle, half = _patch(flank, expected, j, settings)
        near = line.gap - expected.least < 1.5 * expected.approach
        ends, at_end = _face_ends(flank, middle, settings)
        tables = {
            "gear": (-j, middle.face, middle.profile), "pinion": (j, middle.pinion_face, middle.pinion_profile),
        }  # fmt: skip
        for name, (tooth, face, profile) in tables.items():
            low, high = float(face[near].min()) - beside, float(face[near].max()) + beside
            result[name][tooth] = Refinement(
                profile_middle=_curve(face, profile),
                profile_half_range=half,
                face_range=(low, high),
                element_size_profile=_element_size(expected, j, settings),
                element_size_face=settings.element_length,
                growth=settings.growth,
                face_ends=tuple(end for end in ends[name] if low <= end <= high),
                element_size_end=at_end,
            )
    return result


def _face_ends(flank: RigidFlank, line: RigidLine, settings: MeshSettings) -> tuple[dict[str, list[float]], float]:
    """Ends of both bodies, in face coordinates of each, and the element size along the face there [mm].

    The nodes of an end are recessed by the rounding and carry no load, so that a contact ends within the outermost
    elements: it is short by half an element, whose load its neighbours would carry.
    """
    pair, table = flank.pair, flank.pair.scene.gear_pair
    order = {"gear": np.argsort(line.face), "pinion": np.argsort(line.pinion_face)}
    places = {"gear": line.face, "pinion": line.pinion_face}
    ends = {"gear": list(pair.gear_face), "pinion": list(pair.pinion_face)}
    met: dict[str, list[float]] = {}
    for name, other in (("gear", "pinion"), ("pinion", "gear")):
        by = order[other]
        known, here = places[other][by], places[name][by]
        met[name] = [float(np.interp(end, known, here)) for end in ends[other] if known[0] < end < known[-1]]
    radius = max(float(table.gear_end_edge_radius_mm), float(table.pinion_end_edge_radius_mm))
    size = min(max(radius, _AT_END * settings.element_length), settings.element_length)
    return {name: ends[name] + met[name] for name in BODIES}, size


def _curve(face: FloatArray, profile: FloatArray) -> Callable[[FloatArray], FloatArray]:
    return lambda at: np.interp(at, face, profile)


def candidates(
    flank: RigidFlank,
    expected: Forecast,
    j: int,
    settings: MeshSettings,
    meshes: Mapping[str, ToothMesh],
    bodies: Mapping[str, ElasticBody],
    poses: Mapping[str, Pose],
) -> Candidates:
    """Candidates of a pair with their exact gap."""
    pair, (line, half) = flank.pair, _patch(flank, expected, j, settings)
    gear, pinion = meshes["gear"].flanks[-j, LOADED], meshes["pinion"].flanks[j, LOADED]
    face = np.broadcast_to(gear.face, gear.profile.shape)
    worn = flank.wear.depth(face, gear.profile)
    moved = settings.worn_flank == "moved_nodes"
    own, normal = pair.gear.points(face, gear.profile)
    met = pair.met_by(own - worn[..., None] * normal if moved else own, normal, line.roll)
    fresh = met.gap + rounded(pair, face, gear.profile, met)
    apart = _apart(flank)
    fresh = np.where(np.isfinite(fresh), np.minimum(fresh, apart), apart)
    gap = fresh if moved else fresh + worn
    place = np.abs(gear.profile - np.interp(gear.face, line.face, line.profile))
    # elastic deflection only opens the gap: no node with a gap above the approach comes into contact
    highest = _APPROACH * settings.wider.get(j, 1.0) * expected.approach
    near = (place < half) & (gap - expected.least < highest)
    other = np.abs(pinion.profile - np.interp(pinion.face, line.pinion_face, line.pinion_profile)) < _MASTER * half

    count = len(bodies["gear"].points)

    def at_nodes(values: FloatArray, elsewhere: float = 0.0) -> FloatArray:
        result = np.full(count, elsewhere)
        result[gear.nodes] = values
        return result

    normals = np.zeros((count, 3))
    normals[gear.nodes] = poses["gear"].vectors(gear.normals)
    at_fresh = at_nodes(fresh, apart)
    contact = ContactPair(
        slave=_surface("gear", bodies["gear"].points, gear, near, poses["gear"]),
        master=_surface("pinion", bodies["pinion"].points, pinion, other, poses["pinion"]),
        gap=at_fresh,
        lever=pair.lever,
        normals=None if moved else normals,
        reach=_REACH * module_of(pair.scene),
        name=f"pair {j:+d}",
    )
    return Candidates(
        contact,
        at_fresh,
        at_nodes(worn if moved else 0.0 * worn),
        at_nodes(face),
        at_nodes(gear.profile),
        at_nodes(met.pinion_face),
        at_nodes(met.pinion_profile),
        np.unique(gear.nodes),
    )


def _surface(name: str, points: FloatArray, grid: FlankGrid, chosen: BoolArray, pose: Pose) -> Surface:
    """Facets of a flank with a chosen node, counter-clockwise from outside, and the flank's real edges."""
    n = grid.nodes
    quads = np.stack([n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]], axis=-1)
    kept = chosen[:-1, :-1] | chosen[1:, :-1] | chosen[1:, 1:] | chosen[:-1, 1:]
    corner = points[quads[0, 0]]
    outward = np.cross(corner[2] - corner[0], corner[3] - corner[1]) @ pose.vectors(grid.normals[0, 0])
    quads = quads[kept]
    edges = {"tip": n[-1], "inner end": n[:, 0], "outer end": n[:, -1], "fillet": n[0]}
    return Surface(name, points, quads if outward > 0.0 else quads[:, ::-1], edges)
