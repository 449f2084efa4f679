r"""One pitch of a tooth section as curved quadratic quadrilaterals, built by blocks without a mesher.

Half a pitch is two blocks, mirrored about the centre line. T is the tip, M the middle of the fillet (where
the tangent has made half its turn), G the middle of the tooth space, C a point on the centre line below M,
B the foot of the centre line::

        T---.  tip corner
        |   |
        | 1  \     flank: element corners at the load heights
        |     \
        |     .M_____ G      fillet and root land
        |  .*        |
        C*     2     |
        |            |
        B------------'       held: back face of a rack, bore of a ring

Block 1 lies between the outline from tip to M and the centre line from T to C; block 2 hangs below the
outline from M to G, with the bent side M-C-B facing the straight side below G. Block 2 is interpolated
transfinitely, for a ring in polar coordinates about its centre. The side below G is the same for both halves,
so that pitches join node by node.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from skfem import ElementQuad2

from semiwear.errors import SemiwearError
from semiwear.geometry.section import RackRim, RingRim, ToothSection

__all__ = ["ELEMENT", "SectionMesh", "SectionMeshError", "jacobians", "section_mesh"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

ELEMENT = ElementQuad2()
"""Nine-node quadrilateral: unlike the eight-node one it keeps its order when its edges are curved."""

TOWARDS_SURFACE = 2.0
"""Exponent by which elements across the half tooth grow from the surface inwards."""


class SectionMeshError(SemiwearError, ValueError):
    """A tooth section cannot be meshed; the message names the section and the place."""


@dataclass(frozen=True)
class SectionMesh:
    """Quadratic mesh of one pitch, the tooth on the y axis, with the node sets that the prism needs.

    Attributes
    ----------
    nodes : (n, 2) array [mm]
    elements : (m, 9) array
        Nodes of each element in the order of `ELEMENT`; counter-clockwise.
    flank : (H,) array
        Nodes at the load heights, from the lower end of the flank to the tip.
    flank_normal : (H, 2) array
        Inward unit normal of the flank at those nodes.
    load_profile : (H,) array
        Profile coordinate of the load heights.
    fillet : (2 e + 1,) array
        Nodes along the fillet of the loaded side, from the end of the flank to the root, e elements.
    centre_line : (2 c + 1,) array
        Nodes on the centre line from the tip to the foot.
    left, right : (2 r + 1,) array
        Nodes on the mid-space sides (x < 0, x > 0), from the root to the foot, mirror images of each other.
    held : (h,) array
        Nodes on the back face or bore.
    """

    nodes: FloatArray
    elements: IntArray
    flank: IntArray
    flank_normal: FloatArray
    load_profile: FloatArray
    fillet: IntArray
    centre_line: IntArray
    left: IntArray
    right: IntArray
    held: IntArray


def section_mesh(
    section: ToothSection,
    *,
    heights: int = 12,
    fillet_elements: int = 8,
    elements_across: int = 4,
    elements_below: int = 3,
    name: str = "tooth section",
) -> SectionMesh:
    """Mesh one pitch of a tooth section.

    Parameters
    ----------
    section : ToothSection
        Half outline of the tooth [mm] and the rim that it stands on.
    heights : int
        Number of load heights, equally spaced in the profile coordinate from the lower end of the flank to
        its tip end; each is an element corner.
    fillet_elements : int
        Elements along the fillet (even).
    elements_across : int
        Elements across the half tooth.
    elements_below : int
        Elements below the tooth down to the held face.
    name : str
        What error messages call this section.

    Returns
    -------
    SectionMesh

    Raises
    ------
    SectionMeshError
        If the outline or rim is impossible (tip on or beyond the centre line, back face above the root,
        fillet beyond mid-space) or an element would be turned inside out.

    Notes
    -----
    Source: W. J. Gordon, C. A. Hall, Int. J. Numer. Meth. Engng 7 (1973) 461-477 (transfinite interpolation).
    """
    _check_counts(heights, fillet_elements, elements_across, elements_below)
    _check_outline(section, name)
    profile, flank, flank_normal = _flank_stations(section, heights)
    fillet = _fillet_stations(section, fillet_elements)
    frame = _Polar() if isinstance(section.rim, RingRim) else _Plane()
    land = _root_land(section, fillet, frame, fillet_elements)

    middle = fillet_elements  # of the 2 * fillet_elements + 1 points: M
    outline = np.vstack([flank, fillet[1 : middle + 1]])
    below_tooth = np.vstack([fillet[middle:], land])
    centre = _point_below_tooth(section, fillet, middle)

    across = _midpoints((np.arange(elements_across + 1) / elements_across) ** TOWARDS_SURFACE)
    block1 = _block_of_tooth(outline, centre, across, frame)
    block2 = _block_of_rim(block1[-1], below_tooth, section, elements_below, frame)

    # node numbers: the two blocks share the side M-C, both halves the centre line
    grid1 = np.arange(block1[..., 0].size).reshape(block1.shape[:2])
    shared = len(across)
    grid2 = np.empty(block2.shape[:2], dtype=np.int64)
    fresh = np.ones(grid2.shape, dtype=bool)
    fresh[:shared, 0] = False
    grid2[:shared, 0] = grid1[-1]
    grid2[fresh] = grid1.size + np.arange(fresh.sum())
    half = np.vstack([block1.reshape(-1, 2), block2[fresh]])
    centre_line = np.concatenate([grid1[:, -1], grid2[shared:, 0]])
    half[centre_line, 0] = 0.0

    mirror = np.empty(len(half), dtype=np.int64)
    off_centre = np.ones(len(half), dtype=bool)
    off_centre[centre_line] = False
    mirror[centre_line] = centre_line
    mirror[off_centre] = len(half) + np.arange(off_centre.sum())
    elements = np.vstack([_elements(grid1), _elements(grid2.T), _elements(mirror[grid1].T), _elements(mirror[grid2])])

    points_on_flank = 2 * (heights - 1) + 1
    mesh = SectionMesh(
        nodes=np.vstack([half, half[off_centre] * (-1.0, 1.0)]),
        elements=elements,
        flank=grid1[:points_on_flank:2, 0][::-1],
        flank_normal=flank_normal,
        load_profile=profile,
        fillet=np.concatenate([grid1[points_on_flank - 1 :, 0], grid2[0, 1 : fillet_elements + 1]]),
        centre_line=centre_line,
        left=mirror[grid2[:, -1]],
        right=grid2[:, -1],
        held=np.unique([grid2[-1], mirror[grid2[-1]]]),
    )
    _check_jacobians(mesh, name)
    return mesh


def jacobians(mesh: SectionMesh, points: FloatArray) -> FloatArray:
    """Jacobian matrices dx_i/dX_j of all elements at reference points.

    Parameters
    ----------
    mesh : SectionMesh
    points : (2, q) array
        In the unit square.

    Returns
    -------
    (m, q, 2, 2) array [mm]
    """
    gradients = np.array([ELEMENT.lbasis(points, a)[1] for a in range(mesh.elements.shape[1])])  # (9, 2, q)
    return np.einsum("mai,ajq->mqij", mesh.nodes[mesh.elements], gradients)


# --- outline -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Curve:
    """Smooth curve through points, by chord length."""

    length: FloatArray
    spline: CubicSpline

    @classmethod
    def through(cls, points: FloatArray) -> _Curve:
        steps = np.hypot(*np.diff(points, axis=0).T)
        keep = np.concatenate([[True], steps > 1e-9 * steps.sum()])
        length = np.concatenate([[0.0], np.cumsum(steps)])[keep]
        return cls(length, CubicSpline(length, points[keep]))

    def tangent(self, at: FloatArray) -> FloatArray:
        derivative = self.spline(at, 1)
        return derivative / np.linalg.norm(derivative, axis=-1, keepdims=True)


def _midpoints(corners: FloatArray) -> FloatArray:
    """Corner stations of elements -> corner and middle stations."""
    stations = np.empty(2 * len(corners) - 1)
    stations[::2] = corners
    stations[1::2] = (corners[1:] + corners[:-1]) / 2
    return stations


def _flank_stations(section: ToothSection, heights: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Profile coordinates (upwards), points with middles (downwards) and inward normals (upwards)."""
    curve = _Curve.through(section.flank)
    chords = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(section.flank, axis=0).T))])
    profile = np.linspace(section.flank_profile[-1], section.flank_profile[0], heights)
    sign = np.sign(section.flank_profile[-1] - section.flank_profile[0])
    order = CubicSpline(sign * section.flank_profile, chords)
    corners = order(sign * profile[::-1])
    corners[[0, -1]] = curve.length[[0, -1]]
    tangent = curve.tangent(corners)[::-1]  # pointing down
    normal = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    return profile, curve.spline(_midpoints(corners)), normal


def _fillet_stations(section: ToothSection, elements: int) -> FloatArray:
    """Points along the fillet, as many elements before as after the middle of its turning."""
    curve = _Curve.through(section.fillet)
    fine = np.linspace(0.0, curve.length[-1], 401)
    tangent = curve.tangent(fine)
    angle = np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0]))
    turning = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(angle)))])
    turned = turning / turning[-1] if turning[-1] > 0.1 else fine / fine[-1]
    middle = np.interp(0.5, turned, fine)
    middle = np.clip(middle, 0.15 * fine[-1], 0.85 * fine[-1])
    stations = []
    for start, end in ((0.0, middle), (middle, fine[-1])):
        part = np.linspace(start, end, 201)
        bend = np.interp(part, fine, turned)
        even = (part - start) / (end - start) + (bend - bend[0]) / max(bend[-1] - bend[0], 1e-12)
        corners = np.interp(np.linspace(0.0, even[-1], elements // 2 + 1), even, part)
        stations.append(_midpoints(corners))
    return curve.spline(np.concatenate([stations[0], stations[1][1:]]))


def _root_land(section: ToothSection, fillet: FloatArray, frame: _Plane, fillet_elements: int) -> FloatArray:
    """Points from the end of the fillet (left out) to mid-space; snaps a fillet that all but ends there."""
    end = frame.from_xy(fillet[-1])
    middle = np.array([_half_pitch(section), end[1]])
    length = np.linalg.norm(frame.to_xy(middle) - fillet[-1])
    size = np.linalg.norm(np.diff(fillet, axis=0), axis=1).sum() / fillet_elements
    if length < 0.1 * size:
        fillet[-1] = frame.to_xy(middle)
        return np.empty((0, 2))
    count = int(np.clip(round(0.7 * length / size), 1, 4))
    along = np.linspace(0.0, 1.0, 2 * count + 1)[1:, None]
    return frame.to_xy(end + along * (middle - end))


def _half_pitch(section: ToothSection) -> float:
    """Half a pitch in the coordinates of the frame: length for a rack, angle for a ring."""
    rim = section.rim
    return np.pi / rim.teeth if isinstance(rim, RingRim) else rim.pitch / 2


def _foot(section: ToothSection) -> float:
    """Height (radius) of the held face."""
    rim = section.rim
    return rim.bore_radius if isinstance(rim, RingRim) else rim.back_height


def _point_below_tooth(section: ToothSection, fillet: FloatArray, middle: int) -> float:
    """Height of C, where the normal of the outline at M meets the centre line, but well inside the rim."""
    x, y = fillet[middle]
    tangent = fillet[middle + 1] - fillet[middle - 1]
    normal_foot = y + x * tangent[0] / tangent[1] if tangent[1] < -1e-3 * tangent[0] else -np.inf
    root = min(y, fillet[-1, 1])
    rim = root - _foot(section)
    return float(np.clip(normal_foot, root - 0.5 * rim, root - 0.2 * rim))


# --- blocks ------------------------------------------------------------------------------------------------


class _Plane:
    """Coordinates in which the rim is a rectangle: (x, y) of a rack."""

    def from_xy(self, xy: FloatArray) -> FloatArray:
        return xy

    def to_xy(self, coordinates: FloatArray) -> FloatArray:
        return coordinates


class _Polar(_Plane):
    """Coordinates in which the rim is a rectangle: (angle from the y axis, radius) of a ring."""

    def from_xy(self, xy: FloatArray) -> FloatArray:
        return np.stack([np.arctan2(xy[..., 0], xy[..., 1]), np.hypot(xy[..., 0], xy[..., 1])], axis=-1)

    def to_xy(self, coordinates: FloatArray) -> FloatArray:
        angle, radius = coordinates[..., 0], coordinates[..., 1]
        return np.stack([radius * np.sin(angle), radius * np.cos(angle)], axis=-1)


def _block_of_tooth(outline: FloatArray, foot: float, across: FloatArray, frame: _Plane) -> FloatArray:
    """Points (rows from tip to M, columns from outline to centre line) of block 1."""
    chords = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(outline, axis=0).T))])
    corners = chords[::2] / chords[-1]
    tip = frame.from_xy(outline[0])[1]
    centre = np.zeros_like(outline)
    centre[:, 1] = tip + (foot - tip) * _midpoints(corners)
    return outline[:, None] + across[None, :, None] * (centre - outline)[:, None]


def _block_of_rim(
    inner_side: FloatArray, top: FloatArray, section: ToothSection, elements_below: int, frame: _Plane
) -> FloatArray:
    """Points (rows from the surface to the foot, columns from M-C-B to mid-space) of block 2."""
    foot = _foot(section)
    slant = np.linalg.norm(inner_side[-1] - inner_side[0])
    drop = inner_side[-1, 1] - foot
    last = np.linalg.norm(inner_side[-1] - inner_side[-3])
    growth = np.clip(np.log(drop / last) / np.log(elements_below), 1.0, 2.5)
    down = _midpoints((np.arange(elements_below + 1) / elements_below) ** growth)
    below = np.stack([np.zeros(len(down)), inner_side[-1, 1] - drop * down], axis=1)

    west = frame.from_xy(np.vstack([inner_side, below[1:]]))
    along = np.linalg.norm(inner_side - inner_side[0], axis=1)
    depth = np.concatenate([along, slant + drop * down[1:]]) / (slant + drop)
    north = frame.from_xy(top)
    east = np.stack([np.full(len(depth), north[-1, 0]), north[-1, 1] + (foot - north[-1, 1]) * depth], axis=1)
    chords = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(top, axis=0).T))])
    even = np.linspace(0.0, 1.0, len(top))
    width = _midpoints((0.5 * chords / chords[-1] + 0.5 * even)[::2])
    south = np.stack([east[-1, 0] * width, np.full(len(width), foot)], axis=1)

    s, t = width[None, :, None], depth[:, None, None]
    edges = (1 - s) * west[:, None] + s * east[:, None] + (1 - t) * north[None] + t * south[None]
    corners = (1 - s) * ((1 - t) * west[0] + t * west[-1]) + s * ((1 - t) * east[0] + t * east[-1])
    points = frame.to_xy(edges - corners)
    points[0], points[: len(inner_side), 0] = top, inner_side
    return points


def _elements(grid: IntArray) -> IntArray:
    """Nine-node elements of a grid of corner and middle nodes, local x along the columns."""
    column, row = (2 * ELEMENT.doflocs.T).round().astype(int)
    first = 2 * np.arange(grid.shape[0] // 2)[:, None, None]
    second = 2 * np.arange(grid.shape[1] // 2)[None, :, None]
    return grid[first + row, second + column].reshape(-1, len(row))


# --- checks ------------------------------------------------------------------------------------------------


def _check_counts(heights: int, fillet_elements: int, elements_across: int, elements_below: int) -> None:
    if heights < 3 or elements_across < 1 or elements_below < 2:
        raise ValueError("a section mesh needs 3 heights, 1 element across and 2 below at least")
    if fillet_elements < 2 or fillet_elements % 2:
        raise ValueError(f"fillet_elements must be even and positive, not {fillet_elements}")


def _check_outline(section: ToothSection, name: str) -> None:
    outline = np.vstack([section.flank, section.fillet])
    if not np.isfinite(outline).all():
        raise SectionMeshError(f"{name}: the outline holds values that are not finite")
    steps = np.diff(section.flank_profile)
    if len(section.flank_profile) != len(section.flank) or not (np.all(steps > 0) or np.all(steps < 0)):
        raise SectionMeshError(f"{name}: flank_profile must be monotonic, one value a flank point")
    if (outline[:, 0] <= 0).any():
        x, y = outline[np.argmin(outline[:, 0])]
        raise SectionMeshError(
            f"{name}: the tooth is pointed or the outline crosses the centre line (x = {x:.4g} mm at "
            f"y = {y:.4g} mm); lower the tip or cut the section elsewhere"
        )
    frame = _Polar() if isinstance(section.rim, RingRim) else _Plane()
    across, height = frame.from_xy(section.fillet[-1])
    if across > _half_pitch(section) * (1 + 1e-6):
        raise SectionMeshError(f"{name}: the fillet passes the middle of the tooth space")
    if isinstance(section.rim, RackRim) or section.rim.bore_radius > 0:
        if height - _foot(section) > 0:
            return
        raise SectionMeshError(
            f"{name}: the held face at {_foot(section):.4g} mm lies above the root at {height:.4g} mm; "
            "make the rim thicker"
        )
    raise SectionMeshError(f"{name}: the bore radius must be above zero")


def _check_jacobians(mesh: SectionMesh, name: str) -> None:
    determinant = np.linalg.det(jacobians(mesh, ELEMENT.doflocs.T))
    if (determinant <= 0).any():
        element = np.argmin(determinant.min(axis=1))
        x, y = mesh.nodes[mesh.elements[element]].mean(axis=0)
        raise SectionMeshError(
            f"{name}: an element near x = {x:.4g} mm, y = {y:.4g} mm is turned inside out; the outline may "
            "bend too sharply there, or the rim be too thin for the tooth"
        )
