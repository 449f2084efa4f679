r"""One pitch of a toothed body as four blocks, and their divisions.

On every face station one pitch is four blocks. T is the tip, M the middle of the fillet (where its tangent has made
half its turn), G the middle of the tooth space::

               T'----T
              /       \
             /  tooth  \          loaded side: x > 0
         M' /___________\ M
     ______/ |           | \______
   G'  under |   under   | under  G   fillet and root land from M to G
   |   space |   tooth   | space  |
   |_________|___________|________|   held: back face of a gear, bore of a pinion

All teeth have the same topology; they join node by node at G, because depth and face stations are common. The spacing
varies: along the profile it follows the line of a `Refinement` at every face station, through the
thickness it grows from the loaded flank inwards. Edges of tip and ends are sharp: their roundings are in the gap.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil
from typing import Protocol

import numpy as np
from scipy.interpolate import CubicSpline

from fem_reference.arrays import FloatArray
from fem_reference.hexahedra import MeshError, equal_shares, with_middles

_SAG = 0.15  # fall of the tooth's lower border from M to the middle and lean of the sides below M: opens M's angles
_FROM_END = 0.25  # growth of elements along the face from where contact may end, mm for each mm
_STEEPEST = 2.2  # exponent of the growth from a surface inwards


@dataclass(frozen=True)
class Refinement:
    """A refined patch on the loaded flank of a tooth.

    Attributes
    ----------
    profile_middle : function
        Profile coordinate of the middle of the patch at face coordinates [mm].
    profile_half_range : float
        Half the extent of the patch along the profile [mm].
    face_range : (float, float)
        Extent along the face [mm].
    element_size_profile, element_size_face : float
        Greatest element sizes within the patch [mm].
    growth : float
        Increase of the element size for each mm outside. Default 0.35.
    face_ends : tuple of float [mm]
        Face coordinates at which a contact may end: the ends of either body. Near them elements are short along the
        face.
    element_size_end : float [mm]
        Greatest element size along the face at these.
    """

    profile_middle: Callable[[FloatArray], FloatArray]
    profile_half_range: float
    face_range: tuple[float, float]
    element_size_profile: float
    element_size_face: float
    growth: float = 0.35
    face_ends: tuple[float, ...] = ()
    element_size_end: float = float("inf")


@dataclass(frozen=True)
class Divisions:
    """Numbers and sizes of elements where nothing is refined.

    Attributes
    ----------
    flank : int
        Elements along the flank.
    fillet : int
        Elements along the fillet (even).
    land : int
        Elements from the fillet to the middle of the tooth space.
    across : int
        Elements across half the tooth.
    depth : int
        Elements below the root.
    face_size : float
        Greatest element size along the face [mm].
    towards_fillet : float
        Exponent by which the flank's elements grow from the fillet to the tip: above 1 for loads beside the fillet.
    deeper : bool
        As many elements below the root as it takes to start with the size of the fillet's and to grow no faster than
        with the square of the depth, `depth` at least.
    """

    flank: int
    fillet: int
    land: int
    across: int
    depth: int
    face_size: float
    towards_fillet: float = 1.0
    deeper: bool = False

    def __post_init__(self) -> None:
        if self.fillet < 2 or self.fillet % 2:
            raise ValueError(f"divisions.fillet must be even and positive, not {self.fillet}")
        for name in ("flank", "land", "across", "depth"):
            if getattr(self, name) < 1:
                raise ValueError(f"divisions.{name} must be 1 at least, not {getattr(self, name)}")
        for name in ("face_size", "towards_fillet"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ValueError(f"divisions.{name} must be positive and finite, not {getattr(self, name)}")

    @classmethod
    def of_module(cls, module: float) -> Divisions:
        """A moderate mesh of a tooth of a module [mm]."""
        return cls(flank=6, fillet=4, land=1, across=3, depth=5, face_size=0.8 * module)

    @property
    def coarse(self) -> Divisions:
        """Divisions of an unloaded tooth: depth and face stay, since neighbours share them."""
        return replace(self, flank=3, fillet=2, land=1, across=2, towards_fillet=1.0)


class ToothSurface(Protocol):
    """A body that is made of pitches.

    Section points are (x, height) on a face station: x the arc from the middle of the tooth, positive to the loaded
    side; height y in the gear's frame or the pinion's radius. All lengths in mm.
    """

    def __hash__(self) -> int:
        """Hash of the data from which it is made."""

    @property
    def name(self) -> str:
        """Name of the body in error messages."""

    @property
    def face_limits(self) -> tuple[float, float]:
        """Ends of the teeth."""

    @property
    def foot(self) -> float:
        """Section height of the held back face or bore."""

    def half_pitch(self, face: float) -> float:
        """Section coordinate x of the middle of the tooth space."""

    def profile_limits(self, face: float) -> tuple[float, float]:
        """Profile coordinate of the lower end of the flank and of the tip."""

    def flank(self, profile: FloatArray, face: float) -> tuple[FloatArray, FloatArray]:
        """Section points (n, 2) of the loaded flank and its outward normals (n, 3) along arc, height and face."""

    def fillet(self, face: float) -> FloatArray:
        """Section points (k, 2) of the fillet, from the end of the flank to the root."""

    def to_space(self, section: FloatArray, face: float, tooth: int) -> FloatArray:
        """Points (..., 3) of section points (..., 2) of a tooth."""

    def directions(self, across: FloatArray, face: float, tooth: int) -> FloatArray:
        """Unit vectors (..., 3, 3) along arc, height and face at section coordinates x."""


# --- stations ----------------------------------------------------------------------------------------------


def face_corners(surface: ToothSurface, refinements: Iterable[Refinement], coarse: float) -> FloatArray:
    """Face stations: fine where any refined patch is, and finer still where contact may end."""
    low, high = surface.face_limits
    patches = tuple(refinements)

    def size(face: FloatArray) -> FloatArray:
        size = np.full_like(face, coarse)
        for patch in patches:
            start, end = patch.face_range
            outside = np.maximum(np.maximum(start - face, face - end), 0.0)
            size = np.minimum(size, patch.element_size_face + patch.growth * outside)
            for end in patch.face_ends:
                size = np.minimum(size, patch.element_size_end + _FROM_END * np.abs(face - end))
        return size

    return equal_shares(low, high, size)


def depth_corners(surface: ToothSurface, face: FloatArray, divisions: Divisions) -> FloatArray:
    """Fractions of the depth below the root: from the size of the fillet's elements, growing evenly."""
    middle = float(face[len(face) // 2])
    depth = surface.fillet(middle)[-1, 1] - surface.foot
    if depth <= 0.0:
        raise MeshError(f"{surface.name}: the held face lies above the root; make the rim thicker")
    first = _fillet_size(surface, middle, divisions) / depth
    count = max(divisions.depth, ceil(first**-0.5)) if divisions.deeper else divisions.depth
    return _growing(count, first)


def _fillet_size(surface: ToothSurface, face: float, divisions: Divisions) -> float:
    """Length of an element along the fillet [mm]."""
    return float(np.hypot(*np.diff(surface.fillet(face), axis=0).T).sum()) / divisions.fillet


def _growing(count: int, first: float) -> FloatArray:
    """Fractions from 0 to 1 whose first step is `first`, growing by a power law that is not too steep."""
    k = np.arange(count + 1) / count
    if count == 1 or first >= k[1]:
        return k
    return np.asarray(k ** min(np.log(first) / np.log(k[1]), _STEEPEST))


def _across_corners(
    thickness: float, fillet_size: float, divisions: Divisions, refinement: Refinement | None
) -> tuple[FloatArray, FloatArray]:
    """Fractions from the loaded flank to the middle, and from the opposite flank to the middle."""
    coarse = thickness / divisions.across
    towards_surface = _growing(divisions.across, fillet_size / thickness)
    if refinement is None:
        return towards_surface, towards_surface
    first, growth = refinement.element_size_profile, refinement.growth
    loaded = equal_shares(0.0, thickness, lambda d: np.minimum(first + growth * d, coarse), divisions.across)
    return loaded / thickness, towards_surface


# --- one pitch ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Pattern:
    """Section coordinates of one pitch on every face station.

    Attributes
    ----------
    blocks : four (levels, rows, columns, 2) arrays [mm]
        Tooth, under tooth, under space on the loaded and on the opposite side; rows from the tip down.
    profile : two (rows, levels) arrays [mm]
        Profile coordinates of the loaded and of the opposite flank, from the tip down.
    flank_points : int
        Rows of the flank, its lower end included.
    fillet_points : int
        Points of the lower half of the fillet, M left out.
    centre : int
        Column of the middle of the tooth.
    """

    blocks: tuple[FloatArray, ...]
    profile: tuple[FloatArray, FloatArray]
    flank_points: int
    fillet_points: int
    centre: int

    @classmethod
    def of(
        cls,
        surface: ToothSurface,
        face: FloatArray,
        depth: FloatArray,
        divisions: Divisions,
        refinement: Refinement | None,
    ) -> Pattern:
        """The pattern of a tooth on face stations `face` [mm] with fractions `depth` below the root."""
        profiles = _profiles(surface, face, divisions, refinement)
        middle = float(face[len(face) // 2])
        low, high = surface.profile_limits(middle)
        thickness = float(surface.flank(np.array([0.5 * (low + high)]), middle)[0][0, 0])
        across = _across_corners(thickness, _fillet_size(surface, middle, divisions), divisions, refinement)
        loaded, opposite = (with_middles(part) for part in across)
        sections = [
            _section(surface, float(r), depth, divisions, loaded, opposite, (profiles[0][:, k], profiles[1][:, k]))
            for k, r in enumerate(face)
        ]
        return cls(
            blocks=tuple(np.stack(parts) for parts in zip(*sections, strict=True)),
            profile=profiles,
            flank_points=len(profiles[0]),
            fillet_points=divisions.fillet,
            centre=len(loaded) - 1,
        )


def _profiles(
    surface: ToothSurface, face: FloatArray, divisions: Divisions, refinement: Refinement | None
) -> tuple[FloatArray, FloatArray]:
    """Profile coordinates (rows, levels) of the loaded and of the opposite flank, from the tip down."""
    limits = [surface.profile_limits(float(r)) for r in face]
    even = with_middles((np.arange(divisions.flank, -1, -1) / divisions.flank) ** divisions.towards_fillet)
    if refinement is None:
        both = np.stack([low + (high - low) * even for low, high in limits], axis=1)
        return both, both
    line = np.asarray(refinement.profile_middle(face), dtype=float) + 0.0 * face
    if not np.isfinite(line).all():
        raise MeshError(f"{surface.name}: the refinement's line is not finite at every face coordinate")

    def corners(k: int, count: int) -> FloatArray:
        low, high = limits[k]

        def size(profile: FloatArray) -> FloatArray:
            outside = np.maximum(np.abs(profile - line[k]) - refinement.profile_half_range, 0.0)
            size = refinement.element_size_profile + refinement.growth * outside
            return np.asarray(np.minimum(size, (high - low) / divisions.flank))

        return equal_shares(low, high, size, count)

    count = max(len(corners(k, 0)) - 1 for k in range(len(face)))
    loaded = np.stack([with_middles(corners(k, count))[::-1] for k in range(len(face))], axis=1)
    even = with_middles(np.linspace(1.0, 0.0, count + 1))
    spread = np.stack([low + (high - low) * even for low, high in limits], axis=1)
    return loaded, 0.5 * (loaded + spread)


def _section(
    surface: ToothSurface,
    face: float,
    depth: FloatArray,
    divisions: Divisions,
    loaded: FloatArray,
    opposite: FloatArray,
    profiles: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, ...]:
    """The four blocks of one pitch on a face station."""
    fillet = _fillet_points(surface, face, divisions.fillet).copy()
    bend = divisions.fillet  # of 2 * fillet + 1 lattice points: M
    sides = []
    for profile in profiles:
        flank, _ = surface.flank(profile, face)
        gap = np.linalg.norm(fillet[0] - flank[-1])
        if gap > 1e-3 * np.linalg.norm(fillet[-1] - fillet[0]):
            raise MeshError(f"{surface.name}: flank and fillet part by {gap:.3g} mm at face coordinate {face:.5g} mm")
        sides.append(np.vstack([flank, fillet[1 : bend + 1]]))
    if min(side[:, 0].min() for side in sides) <= 0.0:
        raise MeshError(f"{surface.name}: the tooth is pointed at face coordinate {face:.5g} mm")
    half_pitch = surface.half_pitch(face)
    if fillet[-1, 0] > half_pitch * (1.0 + 1e-6):
        raise MeshError(f"{surface.name}: the fillet passes the middle of the tooth space at {face:.5g} mm")
    right, left = sides

    # tooth: straight rows from the loaded flank to the middle and on to the opposite flank
    fall = np.linspace(0.0, 1.0, len(right)) ** 2
    centre = np.column_stack([np.zeros(len(right)), 0.5 * (right[:, 1] + left[:, 1]) - _SAG * right[-1, 0] * fall])
    to_middle = right[:, None] + loaded[None, :, None] * (centre - right)[:, None]
    mirrored = left * (-1.0, 1.0)
    from_middle = mirrored[:, None] + opposite[None, ::-1, None] * (centre - mirrored)[:, None]
    tooth = np.concatenate([to_middle, from_middle[:, 1:]], axis=1)

    # rim: straight columns from the surface to the held face; those below M lean inwards
    foot = surface.foot
    corner = fillet[bend]
    lean = 1.0 - min(_SAG * (corner[1] - foot) / corner[0], 0.35)
    under_tooth = _columns(tooth[-1], tooth[-1, :, 0] * lean, foot, depth)
    end = fillet[-1]
    land = with_middles(np.linspace(0.0, 1.0, divisions.land + 1))[1:, None] * (half_pitch - end[0], 0.0) + end
    top = np.vstack([fillet[bend:], land])
    share = (top[:, 0] - corner[0]) / (half_pitch - corner[0])
    under_space = _columns(top, lean * corner[0] + share * (half_pitch - lean * corner[0]), foot, depth)
    return tooth, under_tooth, under_space, under_space * (-1.0, 1.0)


def _columns(top: FloatArray, foot_across: FloatArray, foot: float, depth: FloatArray) -> FloatArray:
    """Straight columns (rows, columns, 2) from points of the surface to the held face."""
    bottom = np.column_stack([foot_across, np.full(len(top), foot)])
    return top + depth[:, None, None] * (bottom - top)


@lru_cache(maxsize=1024)  # the teeth of a body share their face stations
def _fillet_points(surface: ToothSurface, face: float, elements: int) -> FloatArray:
    """Lattice points (2 elements + 1) along a fillet, as many before as after the middle of its turning."""
    outline = surface.fillet(face)
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(outline, axis=0).T))])
    curve = CubicSpline(length, outline)
    tangent = curve(length, 1)
    turned = np.abs(np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0])) - np.arctan2(tangent[0, 1], tangent[0, 0]))
    turned = np.maximum.accumulate(turned)
    middle = float(np.interp(0.5 * turned[-1], turned, length))
    middle = float(np.clip(middle, 0.2 * length[-1], 0.8 * length[-1]))
    # half of the spacing by length, half by turning
    even = length / length[-1] + turned / turned[-1]
    bounds = np.interp([0.0, middle, length[-1]], length, even)
    shares = [np.linspace(a, b, elements // 2 + 1) for a, b in ((bounds[0], bounds[1]), (bounds[1], bounds[2]))]
    corners = np.interp(np.concatenate([shares[0], shares[1][1:]]), even, length)
    return np.asarray(curve(with_middles(corners)))
