"""Structured hexahedra: grading, blocks that are joined into one mesh, and the check of their Jacobians.

A body is a stack of plane lattices, one a face station. Every lattice has the same blocks; a block is a grid of
points with odd numbers of rows and columns, of which the even ones are element corners and the odd ones lie midway
between them, so that one lattice serves trilinear and curved quadratic elements alike.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from skfem import ElementHex1, ElementHex2, MeshHex, MeshHex2
from skfem.assembly import Dofs

from fem_reference.arrays import FloatArray, IntArray
from fem_reference.elasticity import ELEMENTS
from semiwear.errors import SemiwearError

_SAMPLES = 4001  # at which an element size is integrated


class MeshError(SemiwearError, ValueError):
    """A body cannot be meshed; the message names the body and the place."""


def equal_shares(low: float, high: float, size: Callable[[FloatArray], FloatArray], count: int = 0) -> FloatArray:
    """Element corners between two ends, spaced in proportion to a target element size.

    Parameters
    ----------
    low, high : float
        Ends of the interval [mm].
    size : function
        Target element size at coordinates [mm].
    count : int
        Number of elements, when it must agree with that of another interval; at least the number from the size.

    Returns
    -------
    (count + 1,) array [mm]
    """
    at = np.linspace(low, high, _SAMPLES)
    density = 1.0 / size(at)
    shares = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(at))])
    count = max(count, int(np.ceil(shares[-1] - 1e-6)), 1)
    corners = np.interp(np.linspace(0.0, shares[-1], count + 1), shares, at)
    corners[[0, -1]] = low, high
    return corners


def with_middles(corners: FloatArray) -> FloatArray:
    """Element corners and the points midway between them."""
    stations = np.empty(2 * len(corners) - 1)
    stations[::2] = corners
    stations[1::2] = 0.5 * (corners[1:] + corners[:-1])
    return stations


@dataclass(frozen=True)
class JoinedBlocks:
    """Plane lattices with the points that blocks share counted once.

    Attributes
    ----------
    ids : list of (rows, columns) arrays
        Number in the plane of every point of every block.
    points : (levels, n, 3) array [mm]
    """

    ids: list[IntArray]
    points: FloatArray


def join_blocks(blocks: Sequence[FloatArray], *, name: str) -> JoinedBlocks:
    """Join blocks (levels, rows, columns, 3) at the points in which they coincide on the first level.

    Raises
    ------
    MeshError
        If points that coincide on the first level part on another one.
    """
    flat = np.concatenate([block.reshape(len(block), -1, 3) for block in blocks], axis=1)
    extent = float(np.ptp(flat[0], axis=0).max())
    pairs = cKDTree(flat[0]).query_pairs(1e-9 * extent, output_type="ndarray")
    count = flat.shape[1]
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    joined, number = connected_components(graph, directed=False)
    points = np.empty((len(flat), joined, 3))
    points[:, number] = flat
    if np.abs(points[:, number] - flat).max() > 1e-7 * extent:
        raise MeshError(f"{name}: blocks that meet at one end of the teeth part along the face")
    ends = np.cumsum([block.shape[1] * block.shape[2] for block in blocks])[:-1]
    ids = [
        part.reshape(b.shape[1:3]).astype(np.int64) for part, b in zip(np.split(number, ends), blocks, strict=True)
    ]
    return JoinedBlocks(ids, points)


@dataclass(frozen=True)
class Lattice:
    """A mesh made of joined blocks.

    Attributes
    ----------
    mesh : skfem.MeshHex or skfem.MeshHex2
        Straight for "hex8i", curved for "hex20" and "hex27".
    number : (levels, n) array
        Displacement node at each lattice point; -1 where the element has none.
    """

    mesh: MeshHex
    number: IntArray

    @classmethod
    def of(cls, joined: JoinedBlocks, element: str, *, name: str) -> Lattice:
        """Mesh the blocks with an element of `elasticity.ELEMENTS` and check every Jacobian."""
        levels, plane, _ = joined.points.shape
        points = joined.points.reshape(-1, 3)

        def members(offsets: FloatArray) -> IntArray:
            level, row, column = (2 * offsets.T).round().astype(int)
            steps = 2 * np.arange(levels // 2)[:, None, None, None] + level
            numbers = []
            for ids in joined.ids:
                down = 2 * np.arange(ids.shape[0] // 2)[:, None, None] + row
                across = 2 * np.arange(ids.shape[1] // 2)[None, :, None] + column
                numbers.append((steps * plane + ids[down, across]).reshape(-1, len(offsets)))
            return np.concatenate(numbers)

        corners = members(np.asarray(ElementHex1.doflocs))
        used, vertices = np.unique(corners, return_inverse=True)
        number = np.full(levels * plane, -1, dtype=np.int64)
        mesh = MeshHex(np.ascontiguousarray(points[used].T), np.ascontiguousarray(vertices.reshape(corners.shape).T))
        number[used] = np.arange(len(used))
        if element != "hex8i":
            nodes = Dofs(mesh, ElementHex2()).element_dofs.T
            lattice = members(np.asarray(ElementHex2.doflocs))
            number[lattice] = nodes
            places = np.empty((3, int(nodes.max()) + 1))
            places[:, nodes] = points[lattice].transpose(2, 0, 1)
            mesh = MeshHex2(places, mesh.t)
            number[number >= Dofs(mesh, ELEMENTS[element].element).N] = -1
        check_jacobians(mesh, name=name)
        return cls(mesh, number.reshape(levels, plane))


def check_jacobians(mesh: MeshHex, *, name: str) -> None:
    """Check that no element is folded, at its corners and at 2 x 2 x 2 Gauss points.

    Raises
    ------
    MeshError
        Naming the place of the worst element.
    """
    element = ElementHex2() if mesh.doflocs.shape[1] > mesh.nvertices else ElementHex1()
    nodes = Dofs(mesh, element).element_dofs.T
    corners = np.asarray(ElementHex1.doflocs).T
    gauss = 0.5 + (corners - 0.5) / np.sqrt(3.0)
    at = np.hstack([corners, gauss])
    gradients = np.array([element.lbasis(at, a)[1] for a in range(nodes.shape[1])])
    for start in range(0, len(nodes), 4000):
        places = mesh.doflocs.T[nodes[start : start + 4000]]
        determinant = np.linalg.det(np.einsum("ajq,mai->mqij", gradients, places))
        determinant *= np.sign(determinant.mean(axis=1, keepdims=True))
        worst = determinant.min(axis=1)
        if not (worst > 0.0).all():
            place = places[np.argmin(worst)].mean(axis=0)
            raise MeshError(
                f"{name}: an element near x = {place[0]:.4g}, y = {place[1]:.4g}, z = {place[2]:.4g} mm is folded; "
                "the tooth may be pointed or undercut there, the rim too thin, or the refinement too abrupt"
            )
