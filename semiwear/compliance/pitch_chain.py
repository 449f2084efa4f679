"""Pitches of a toothed body in a row: one is condensed onto its sides, then all are joined.

All teeth are alike, so one pitch is condensed to its two mid-space sides once per wave number k; the pitches are
then joined by small dense algebra, a rack with free ends or a whole ring alike. Side unknowns are in the axes
of their own side, so that neighbours in a ring share them as neighbours in a rack do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bmat, coo_matrix, csc_matrix, csr_matrix
from scipy.sparse.linalg import splu

from semiwear.compliance.section_mesh import SectionMesh
from semiwear.geometry.section import RingRim, ToothSection

__all__ = ["DEFLECTION_OFFSETS", "STRESS_OFFSETS", "Condensed", "HarmonicMatrices", "Pitch", "join"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

HarmonicMatrices = tuple[csc_matrix, csc_matrix, csc_matrix]
"""Sparse K0, K1, K2 of the stiffness K0 + k K1 + k^2 K2 at wave number k; unknowns 3 node + (u, v, w)."""

DEFLECTION_OFFSETS = (-2, -1, 0, 1, 2)
"""Teeth whose deflection is kept; +1 is the neighbour that faces the loaded flank (x > 0)."""

STRESS_OFFSETS = (-1, 0, 1)
"""Teeth whose fillet stress is kept."""


@dataclass(frozen=True)
class Condensed:
    """One pitch at one wave number, in terms of its sides (left, then right; s unknowns each) and its own loads.

    Attributes
    ----------
    stiffness : (2 s, 2 s) array
        Stiffness of the sides.
    side_load : (2 s, H) array
        Loads that unit loads on the flank send to the sides.
    deflection : (H, 2 s) array
        Observed deflection for unit displacements of the sides.
    deflection_load : (H, H) array
        Observed deflection for unit loads on the pitch's own flank with its sides held.
    stress : (F, 2 s) array
        Observed stress for unit displacements of the sides.
    stress_load : (F, H) array
        Observed stress for unit loads on the pitch's own flank with its sides held.
    """

    stiffness: FloatArray
    side_load: FloatArray
    deflection: FloatArray
    deflection_load: FloatArray
    stress: FloatArray
    stress_load: FloatArray


@dataclass(frozen=True)
class Pitch:
    """Stiffness of one pitch, parted into inner and side unknowns; held unknowns are left out.

    Attributes
    ----------
    inner : tuple of three (i, i) sparse matrices
        Parts of K0, K1, K2 on the inner unknowns.
    coupling : tuple of three (i, 2 s) arrays
        Parts between inner unknowns and sides.
    sides : tuple of three (2 s, 2 s) arrays
        Parts on the sides.
    inner_unknowns : (i,) array
        Place of the inner unknowns among those of the mesh.
    turned_sides : (3 n, 2 s) sparse matrix
        Side unknowns in the sides' own axes -> unknowns of the mesh.
    """

    inner: HarmonicMatrices
    coupling: tuple[FloatArray, FloatArray, FloatArray]
    sides: tuple[FloatArray, FloatArray, FloatArray]
    inner_unknowns: IntArray
    turned_sides: csr_matrix

    @classmethod
    def of(cls, mesh: SectionMesh, section: ToothSection, matrices: HarmonicMatrices) -> Pitch:
        """Part the matrices of one pitch.

        Parameters
        ----------
        mesh : SectionMesh
            One pitch of the section.
        section : ToothSection
            Its rim says how the sides are turned against each other.
        matrices : HarmonicMatrices
            Stiffness of the pitch, (3 n, 3 n) each.
        """
        angle = _side_angle(section)
        size = 3 * len(mesh.nodes)
        left, right = (side[~np.isin(side, mesh.held)] for side in (mesh.left, mesh.right))
        free = np.setdiff1d(np.arange(len(mesh.nodes)), np.concatenate([mesh.held, left, right]))
        inner = _unknowns(free)
        turned = bmat([[_turned(left, -angle, size), _turned(right, angle, size)]]).tocsr()
        rows = [matrix.tocsr()[inner] for matrix in matrices]
        return cls(
            inner=tuple(row.tocsc()[:, inner] for row in rows),
            coupling=tuple((row @ turned).toarray() for row in rows),
            sides=tuple((turned.T @ (matrix @ turned)).toarray() for matrix in matrices),
            inner_unknowns=inner,
            turned_sides=turned,
        )

    def condense(self, k: float, load: csr_matrix, deflection: csr_matrix, stress: csr_matrix) -> Condensed:
        """Eliminate the inner unknowns at a wave number.

        Parameters
        ----------
        k : float
            Wave number [1/mm].
        load : (H, 3 n) sparse matrix
            Unit loads on the flank.
        deflection : (H, 3 n) sparse matrix
            Observed deflection as rows on the unknowns of the mesh.
        stress : (F, 3 n) sparse matrix
            Observed stress at wave number k, likewise.
        """
        parts = (self.inner, self.coupling, self.sides)
        inner, coupling, sides = (k0 + k * k1 + k**2 * k2 for k0, k1, k2 in parts)
        inner_load = load[:, self.inner_unknowns].toarray().T
        factor = splu(inner, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        solution = factor.solve(np.hstack([inner_load, -coupling]))
        own, carried = np.split(solution, [inner_load.shape[1]], axis=1)

        def by_sides(rows: csr_matrix) -> FloatArray:
            return rows[:, self.inner_unknowns] @ carried + (rows @ self.turned_sides).toarray()

        return Condensed(
            stiffness=sides + coupling.T @ carried,
            side_load=carried.T @ inner_load,
            deflection=by_sides(deflection),
            deflection_load=deflection[:, self.inner_unknowns] @ own,
            stress=by_sides(stress),
            stress_load=stress[:, self.inner_unknowns] @ own,
        )


def _unknowns(nodes: IntArray) -> IntArray:
    """Unknowns of nodes, node by node."""
    return (3 * nodes[:, None] + np.arange(3)).ravel()


def _turned(nodes: IntArray, angle: float, size: int) -> csr_matrix:
    """Unknowns of nodes in axes turned clockwise by angle -> unknowns of the mesh."""
    turn = np.array([[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    blocks = np.broadcast_to(turn, (len(nodes), 3, 3))
    rows = np.broadcast_to((3 * nodes[:, None] + np.arange(3))[:, :, None], blocks.shape)
    columns = np.broadcast_to(np.arange(3 * len(nodes)).reshape(-1, 1, 3), blocks.shape)
    return coo_matrix((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(size, 3 * len(nodes))).tocsr()


def _side_angle(section: ToothSection) -> float:
    """Half the angle between the sides of a pitch [rad]; those of a rack are parallel."""
    return np.pi / section.rim.teeth if isinstance(section.rim, RingRim) else 0.0


def join(condensed: list[Condensed], section: ToothSection, rack_teeth: int) -> tuple[FloatArray, FloatArray]:
    """Join alike pitches and load the flank of the middle one.

    Parameters
    ----------
    condensed : list of n Condensed
        The pitch at each wave number.
    section : ToothSection
        Its rim says whether the pitches make a ring, which is whole, or a rack, whose ends are free.
    rack_teeth : int
        Teeth of a rack, an odd number.

    Returns
    -------
    deflection : (n, 5, H, H) array
        Of the teeth at `DEFLECTION_OFFSETS` from the loaded one; zero beyond the ends of a rack.
    stress : (n, 3, F, H) array
        Of the teeth at `STRESS_OFFSETS`, likewise.
    """
    pitch = np.array([c.stiffness for c in condensed])
    count, side = len(pitch), pitch.shape[1] // 2
    teeth = 5 if isinstance(section.rim, RingRim) else min(rack_teeth, 5)
    whole = np.zeros((count, (teeth + 1) * side, (teeth + 1) * side))  # unknowns: sides of the teeth in order
    for tooth in range(teeth):
        whole[:, _sides(tooth, side), _sides(tooth, side)] += pitch
    first, last = slice(None, side), slice(teeth * side, None)
    near, far = slice(None, side), slice(side, None)
    if isinstance(section.rim, RingRim):
        rest = _chain(pitch, section.rim.teeth - teeth)
        whole[:, last, last] += rest[:, near, near]
        whole[:, last, first] += rest[:, near, far]
        whole[:, first, last] += rest[:, far, near]
        whole[:, first, first] += rest[:, far, far]
    elif rack_teeth > teeth:
        rest = _chain(pitch, (rack_teeth - teeth) // 2)
        whole[:, last, last] += _without(rest, near, far)
        whole[:, first, first] += _without(rest, far, near)

    middle = teeth // 2
    load = np.zeros((count, whole.shape[1], condensed[0].side_load.shape[1]))
    load[:, _sides(middle, side)] = [c.side_load for c in condensed]
    moved = np.linalg.solve(whole, load)

    def of_teeth(offsets: tuple[int, ...], rows: list[FloatArray], own: list[FloatArray]) -> FloatArray:
        values = np.zeros((count, len(offsets), *own[0].shape))
        for place, offset in enumerate(offsets):
            if abs(offset) <= middle:
                values[:, place] = np.array(rows) @ moved[:, _sides(middle + offset, side)]
        values[:, offsets.index(0)] += own
        return values

    deflection = [c.deflection for c in condensed], [c.deflection_load for c in condensed]
    stress = [c.stress for c in condensed], [c.stress_load for c in condensed]
    return of_teeth(DEFLECTION_OFFSETS, *deflection), of_teeth(STRESS_OFFSETS, *stress)


def _sides(tooth: int, side: int) -> slice:
    """Unknowns of both sides of a tooth."""
    return slice(tooth * side, (tooth + 2) * side)


def _without(stiffness: FloatArray, keep: slice, drop: slice) -> FloatArray:
    """Schur complement: stiffness of the unknowns kept when those dropped are free of load."""
    coupling = stiffness[:, drop, keep]
    carried = np.linalg.solve(stiffness[:, drop, drop], coupling)
    return stiffness[:, keep, keep] - coupling.swapaxes(1, 2) @ carried


def _chain(pitch: FloatArray, count: int) -> FloatArray:
    """Stiffness (n, 2 s, 2 s) of the outer sides of a chain of pitches, by doubling."""
    if count == 1:
        return pitch
    half = _chain(pitch, count // 2)
    double = _pair(half, half)
    return _pair(double, pitch) if count % 2 else double


def _pair(first: FloatArray, second: FloatArray) -> FloatArray:
    """Stiffness of the outer sides of two chains of pitches that share a side."""
    s = first.shape[1] // 2
    joined = np.zeros((len(first), 3 * s, 3 * s))  # unknowns: outer left, shared, outer right
    joined[:, : 2 * s, : 2 * s] += first
    joined[:, s:, s:] += second
    outer = np.concatenate([np.arange(s), np.arange(2 * s, 3 * s)])
    coupling = joined[:, s : 2 * s, outer]
    kept = joined[:, outer[:, None], outer]
    return kept - coupling.swapaxes(1, 2) @ np.linalg.solve(joined[:, s : 2 * s, s : 2 * s], coupling)
