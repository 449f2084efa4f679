"""Chain of the pitches of a toothed body: one pitch is condensed onto its sides, then all are joined.

All teeth are equal, so one pitch is condensed to its two mid-space sides once per wave number k, by one sparse
factorisation whose last columns are those sides; the pitches are then joined by small dense algebra, to a rack with
free ends or to a whole ring. Side unknowns are in the axes of their own side, so that neighbours in a ring share
them as neighbours in a rack do.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import floor

import numpy as np
from scipy.sparse import block_array, coo_matrix, csc_matrix, csr_matrix, diags_array, hstack
from scipy.sparse.linalg import SuperLU, splu

from semiwear.arrays import FloatArray, IntArray
from semiwear.compliance.section_mesh import SectionMesh
from semiwear.geometry.section import RingRim, ToothSection

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
        Loads on the sides by unit loads on the flank.
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
class PitchRows:
    """Loads and readings of one pitch: rows on the unknowns of its mesh, ``fixed + k * along`` at wave number k.

    Attributes
    ----------
    fixed, along : (R, 3 n) sparse matrices
    load, deflection, stress : slices
        Rows of unit loads (H of them), readings of deflection and readings of stress (F). A row may be both
        load and reading.
    """

    fixed: csr_matrix
    along: csr_matrix
    load: slice
    deflection: slice
    stress: slice


@dataclass(frozen=True)
class Pitch:
    """Stiffness of one pitch whose sides are free, bordered by its loads and readings; held unknowns are left out.

    Unknowns are the inner ones, in an order that keeps their factor sparse, then the sides, then one for each row of
    `PitchRows`: the end of the factor is that of the sides' stiffness and of the effect of loads with the sides held.

    Attributes
    ----------
    data : (3, z) array
        Coefficients of 1, k and k^2 at wave number k, in the order of ...
    places, starts : (z,), (m + 1,) arrays
        ... a sparse matrix by columns.
    sides : int
        Number 2 s of side unknowns, in the sides' own axes.
    apart : (R,) array
        Subtracted from the rows' diagonal: equal rows, as on a thin rim, would make it singular.
    load, deflection, stress : slices
        See `PitchRows`.
    """

    data: FloatArray
    places: IntArray
    starts: IntArray
    sides: int
    apart: FloatArray
    load: slice
    deflection: slice
    stress: slice

    @classmethod
    def of(cls, mesh: SectionMesh, section: ToothSection, matrices: HarmonicMatrices, rows: PitchRows) -> Pitch:
        """Order the matrices of one pitch.

        Parameters
        ----------
        mesh : SectionMesh
            One pitch of the section.
        section : ToothSection
            Its rim defines the angle between the sides.
        matrices : HarmonicMatrices
            Stiffness of the pitch, (3 n, 3 n) each.
        rows : PitchRows
        """
        angle = _side_angle(section)
        size = 3 * len(mesh.nodes)
        left, right = (side[~np.isin(side, mesh.held)] for side in (mesh.left, mesh.right))
        free = np.setdiff1d(np.arange(len(mesh.nodes)), np.concatenate([mesh.held, left, right]))
        inner = unknowns_of(free)
        order = np.argsort(symmetric_factor(matrices[0].tocsr()[inner].tocsc()[:, inner], "MMD_AT_PLUS_A").perm_c)
        among = coo_matrix((np.ones(inner.size), (inner[order], np.arange(inner.size))), shape=(size, inner.size))
        turned = hstack([among, _turned(left, -angle, size), _turned(right, angle, size)]).tocsr()
        stiffness = [turned.T @ (matrix @ turned) for matrix in matrices]
        observed = rows.fixed.shape[0]
        borders = (rows.fixed @ turned, rows.along @ turned, csr_matrix((observed, turned.shape[1])))
        # approximate reading of a row under its own load
        apart = np.asarray(borders[0].power(2) @ (1.0 / stiffness[0].diagonal()))
        bordered = [
            block_array([[matrix, border.T], [border, corner]], format="csc")
            for matrix, border, corner in zip(stiffness, borders, (diags_array(-apart), None, None), strict=True)
        ]
        data, places, starts = _on_one_pattern(bordered)
        sides = 3 * (left.size + right.size)
        return cls(data, places, starts, sides, apart, rows.load, rows.deflection, rows.stress)

    def condense(self, k: float) -> Condensed:
        """Eliminate the inner unknowns at a wave number [1/mm]."""
        count, sides = len(self.starts) - 1, self.sides
        values = self.data[0] + k * self.data[1] + k**2 * self.data[2]
        factor = symmetric_factor(csc_matrix((values, self.places, self.starts), shape=(count, count)), "NATURAL")
        kept = slice(count - sides - self.apart.size, None)
        rest = (factor.L[kept, kept] @ factor.U[kept, kept]).toarray()
        # reactions of held sides to the rows: by symmetry also the readings of the rows under the sides' motion
        sent, own = rest[:sides, sides:], -(rest[sides:, sides:] + np.diag(self.apart))[:, self.load]
        return Condensed(
            stiffness=rest[:sides, :sides],
            side_load=sent[:, self.load],
            deflection=sent[:, self.deflection].T,
            deflection_load=own[self.deflection],
            stress=sent[:, self.stress].T,
            stress_load=own[self.stress],
        )


def symmetric_factor(matrix: csc_matrix, order: str) -> SuperLU:
    """Factor of a symmetric matrix, without pivoting."""
    return splu(matrix, permc_spec=order, diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def _on_one_pattern(matrices: list[csc_matrix]) -> tuple[FloatArray, IntArray, IntArray]:
    """Entries (matrix, z), their rows (z,) and the starts of columns of sparse matrices, zeros filled in."""
    pattern = abs(matrices[0])
    for matrix in matrices[1:]:
        pattern = pattern + abs(matrix)
    pattern.sort_indices()
    places = _places(pattern)
    data = np.zeros((len(matrices), places.size))
    for values, matrix in zip(data, matrices, strict=True):
        matrix.eliminate_zeros()
        values[np.searchsorted(places, _places(matrix))] = matrix.data
    return data, pattern.indices, pattern.indptr


def _places(matrix: csc_matrix) -> IntArray:
    """Linear indices of a sparse matrix's entries, column after column."""
    size = matrix.shape[0]
    return np.asarray(np.repeat(np.arange(size) * size, np.diff(matrix.indptr)) + matrix.indices)


def unknowns_of(nodes: IntArray) -> IntArray:
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
    """Join equal pitches and load the flank of the middle one.

    Parameters
    ----------
    condensed : list of n Condensed
        The pitch at each wave number.
    section : ToothSection
        By its rim the pitches make a ring, which is whole, or a rack, whose ends are free.
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
        rest = _chain_of(pitch, section.rim.teeth - teeth)
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
    """Schur complement: stiffness of the kept unknowns with the dropped ones free of load."""
    coupling = stiffness[:, drop, keep]
    carried = np.linalg.solve(stiffness[:, drop, drop], coupling)
    return stiffness[:, keep, keep] - coupling.swapaxes(1, 2) @ carried


def _chain_of(pitch: FloatArray, count: float) -> FloatArray:
    """Stiffness of the outer sides of a chain of pitches, whose number need not be whole.

    Between whole numbers the stiffness is linear: the ring of a virtual spur gear has no whole number of teeth.
    """
    whole = floor(count)
    part = count - whole
    chain = _chain(pitch, whole)
    return chain if part == 0.0 else (1.0 - part) * chain + part * _pair(chain, pitch)


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
