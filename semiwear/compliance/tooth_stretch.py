"""One tooth between its end faces in three dimensions, on the ground around its foot.

In the coordinates of the section (x, y) and z along the axis, for an inclined tooth along s,

    d/dx -> d/dx + sin(beta) d/dz,    d/ds -> cos(beta) d/dz

so that displacements are the quadratic elements of the section times polynomials along z, and with strains
B0 q + B1 dq/dz

    K = K00 (x) 1 + K01 (x) D + K01' (x) D' + K11 (x) D'D        D: derivative in terms of the polynomials.

Displacements w along the tooth are expanded in sums of polynomials of which all but two vanish at both ends, so that
ends can be held in that direction as in the cosines of a prism.

The ground is held below, and below the middle of the neighbouring teeth, which themselves are left out: the region
beyond changes root stress by 1 %. A tooth is symmetric under half a turn about its centre line, oblique ends
included; even and odd fields are solved separately, each on the loaded half.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular
from scipy.sparse import csr_matrix

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.compliance.condensation import levels_towards
from semiwear.compliance.polynomials import along_width, derivatives
from semiwear.compliance.section_elements import fillet_edges, section_integrals, unknowns_of
from semiwear.compliance.section_mesh import SectionMesh, section_mesh
from semiwear.compliance.section_outline import frame_of
from semiwear.geometry.section import ToothSection

HEIGHTS = 5
"""Load heights of the stretch."""

ORDERS = 12
"""Polynomials along the axis."""

_FILLET, _ACROSS, _BELOW = 2, 2, 2  # elements along the fillet, across half the tooth, below it


def _axial_basis() -> FloatArray:
    """Sums of polynomials, one per column; all but the first two vanish at both ends."""
    at_end = along_width(np.array([0.5]), ORDERS)[0]
    basis = np.eye(ORDERS)
    for order in range(2, ORDERS):
        basis[order - 2, order] = -at_end[order] / at_end[order - 2]
    return np.asarray(basis / np.linalg.norm(basis, axis=0))


_AXIAL = _axial_basis()


class StretchInfluence(NamedTuple):
    """Influence of loads normal to the flank; loads and deflections are expanded in P polynomials, see `along_width`.

    Attributes
    ----------
    deflection : (P H, P H) array [mm/N]
        Of the flank along its normal; symmetric.
    bending : (P H, P H) array [mm/N]
        Mean of both flanks, by loads shared by both: without local deflection under the loads. For square ends.
    stress : (P, F, P H) array [MPa/N]
        Tangential stress of the fillet on the loaded side, at two Gauss points per element.
    """

    deflection: FloatArray
    bending: FloatArray
    stress: FloatArray


@dataclass(frozen=True)
class Stretch:
    """A stretch of tooth with free ends on held ground.

    Attributes
    ----------
    mesh : SectionMesh
        Of the loaded half, with the ground as far as the middle of the neighbouring tooth.
    width : float [mm]
        Between the ends, along the axis.
    youngs_modulus : float [MPa]
    poissons_ratio : float
    along, lean : float
        Cosine and sine of the helix angle: d/ds = along d/dz, and d/dx includes lean d/dz. The sine is positive where
        the tooth runs with z in the direction of the load, and 0 makes the ends square.
    """

    mesh: SectionMesh
    width: float
    youngs_modulus: float
    poissons_ratio: float
    along: float = 1.0
    lean: float = 0.0

    @classmethod
    def of(
        cls,
        section: ToothSection,
        *,
        width: float,
        youngs_modulus: float,
        poissons_ratio: float,
        along: float = 1.0,
        name: str,
    ) -> Stretch:
        """Mesh the loaded half of a section and its neighbour's ground; the ends are square.

        Parameters
        ----------
        section : ToothSection
            Normal to the tooth [mm].
        width : float [mm]
            Between the ends, along the axis.
        youngs_modulus : float [MPa]
        poissons_ratio : float
        along : float
            Cosine of the helix angle.
        name : str
            Name of the section in error messages.
        """
        whole = section_mesh(
            section,
            heights=HEIGHTS,
            fillet_elements=_FILLET,
            elements_across=_ACROSS,
            elements_below=_BELOW,
            name=name,
        )
        return cls(_loaded_half(whole, section), width, youngs_modulus, poissons_ratio, along)

    def influence(self, *, mirrored: bool = False) -> StretchInfluence:
        """Influence of loads on the flank.

        Parameters
        ----------
        mirrored : bool
            Whether the tooth continues beyond its ends as its mirror image, instead of being free there. Only for
            square ends.
        """
        levels, observed = self._levels
        load = self._on_flank()
        moved, deflection = np.zeros_like(load), np.zeros((load.shape[1],) * 2)
        bending = np.zeros_like(deflection)
        # half a turn exchanges the flanks: z changes sign, and so does the bending load
        turned = np.repeat((-1.0) ** np.arange(ORDERS), HEIGHTS)
        for sign, free in self._fields(square=self.lean == 0.0, mirrored=mirrored):
            answer = np.zeros_like(deflection)
            for own, part in _solved(levels, observed, free, load):
                moved[own] += 0.5 * part
                answer += load[own].T @ (0.5 * part)
            deflection += answer
            shared = 0.5 * (1.0 - sign * turned)
            bending += shared[:, None] * answer * shared
        whole = moved.reshape(len(self.mesh.nodes), 3, ORDERS, -1)
        whole[:, 2] = np.einsum("pq,nql->npl", _AXIAL, whole[:, 2])
        stress = self._stress(whole)
        return StretchInfluence(0.5 * (deflection + deflection.T), 0.5 * (bending + bending.T), stress)

    @cached_property
    def _levels(self) -> tuple[list[_Level], int]:
        """Levels from the ground up, and the first with nodes of the flank or the fillet."""
        integrals = section_integrals(self.mesh, self.youngs_modulus, self.poissons_ratio, self.along, self.lean)
        k00, k01, k11 = (k.tocsr() * (self.width / self.along) for k in integrals)
        free = np.ones(len(self.mesh.nodes), dtype=bool)
        free[self.mesh.held] = False
        nodes = levels_towards(self.mesh.centre_line[:1], self.mesh.elements, free)
        surface = np.concatenate([self.mesh.flank, self.mesh.fillet])
        observed = [bool(np.isin(own, surface).any()) for own, _ in nodes].index(True)
        return list(_joined(k00, k01, k11, derivatives(ORDERS) / self.width, nodes)), observed

    def _on_flank(self) -> FloatArray:
        """Unit loads on the flank, expanded in polynomials, at heights: (unknowns, P H) array."""
        mesh = self.mesh
        rows = np.zeros((len(mesh.nodes), 3, HEIGHTS))
        rows[mesh.flank, :2, np.arange(HEIGHTS)] = mesh.flank_normal
        return np.asarray(np.einsum("nch,pq->ncpqh", rows, np.eye(ORDERS)).reshape(rows.shape[0] * 3 * ORDERS, -1))

    def _fields(self, *, square: bool, mirrored: bool) -> Iterator[tuple[float, BoolArray]]:
        """Fields of each symmetry: their sign under half a turn, and their unknowns."""
        even = np.arange(ORDERS) % 2 == 0
        for sign, turned in ((1.0, even), (-1.0, ~even)):
            free = np.ones((len(self.mesh.nodes), 3, ORDERS), dtype=bool)
            if mirrored:
                free[:, 2, :2] = False
            # half a turn about y reverses u, w and z: on the centre line u and w have the parity of z, v the opposite
            free[self.mesh.centre_line] &= np.stack([~turned, turned, ~turned])
            # square ends are also symmetric to each other: u and v are even in z where w is odd
            for alike in (even, ~even) if square else (np.ones_like(even),):
                opposite = ~alike if square else alike
                yield sign, (free & np.stack([alike, alike, opposite])).reshape(-1)

    def _stress(self, moved: FloatArray) -> FloatArray:
        nodes, slopes, values, tangent, _ = fillet_edges(self.mesh)
        steady = np.einsum("fa,fi,faipl->pfl", slopes, tangent, moved[nodes, :2], optimize=True)
        tangential = np.einsum("fa,fi,faipl->pfl", values, tangent, moved[nodes, :2], optimize=True)
        axial = np.einsum("fa,fapl->pfl", values, moved[nodes, 2], optimize=True)
        by_z = self.lean * tangent[None, :, :1] * tangential + self.poissons_ratio * self.along * axial
        strain = steady + np.tensordot(derivatives(ORDERS) / self.width, by_z, axes=1)
        stress: FloatArray = self.youngs_modulus / (1.0 - self.poissons_ratio**2) * strain
        return stress


def _loaded_half(whole: SectionMesh, section: ToothSection) -> SectionMesh:
    """Half with the loaded flank, and the adjacent half of its neighbour's ground, held in that tooth's middle."""
    count, half = len(whole.nodes), len(whole.elements) // 2
    ground = half + (HEIGHTS - 1 + _FILLET // 2) * _ACROSS  # behind the elements of the other half's tooth
    frame = frame_of(section)
    pitch = 2.0 * frame.from_xy(whole.nodes[whole.right[0]])[0]
    beside = frame.to_xy(frame.from_xy(whole.nodes) + np.array([pitch, 0.0]))
    numbers = count + np.arange(count)
    numbers[whole.left] = whole.right
    elements = np.vstack([whole.elements[:half], numbers[whole.elements[ground:]]])
    middle = np.intersect1d(whole.elements[ground:], whole.centre_line)
    held = np.concatenate([whole.held, numbers[whole.held], numbers[middle]])

    kept = np.unique(elements)
    renumbered = np.full(2 * count, -1)
    renumbered[kept] = np.arange(kept.size)
    return replace(
        whole,
        nodes=np.vstack([whole.nodes, beside])[kept],
        elements=renumbered[elements],
        flank=renumbered[whole.flank],
        fillet=renumbered[whole.fillet],
        centre_line=renumbered[whole.centre_line],
        left=renumbered[whole.right],
        right=renumbered[whole.right],
        held=renumbered[np.intersect1d(held, kept)],
    )


class _Level(NamedTuple):
    """Unknowns of a level of nodes, coupled to those of the level above and of the level below alone.

    Attributes
    ----------
    unknowns : (n,) int array
        All of them, of which a field uses some. Those coupled to the level below come last.
    stiffness : (n, n) array [N/mm]
    coupling : (n, m) array [N/mm]
        To the last m unknowns of the level above.
    """

    unknowns: IntArray
    stiffness: FloatArray
    coupling: FloatArray


def _joined(
    k00: csr_matrix, k01: csr_matrix, k11: csr_matrix, slope: FloatArray, levels: list[tuple[IntArray, int]]
) -> Iterator[_Level]:
    """Levels of unknowns, from integrals over the section and the derivative D (P, P) [1/mm]."""
    basis = np.hstack([np.eye(ORDERS), _AXIAL])
    along = np.array([0, 0, 1])  # half of the basis for u, v and w
    matrices, products = (k00, k01, k01.T.tocsr(), k11), []
    for product in (np.eye(ORDERS), slope, slope.T, slope.T @ slope):
        parts = (basis.T @ product @ basis).reshape(2, ORDERS, 2, ORDERS)
        products.append(parts[along][:, :, along])

    def between(rows: IntArray, columns: IntArray) -> FloatArray:
        parts = [k[unknowns_of(rows)][:, unknowns_of(columns)].toarray() for k in matrices]
        by_node = np.reshape(parts, (len(parts), rows.size, 3, columns.size, 3))
        block = np.einsum("tmcnd,tcpdq->cdmnpq", by_node, products, optimize=True)
        return np.asarray(block.transpose(2, 0, 4, 3, 1, 5).reshape(3 * ORDERS * rows.size, -1))

    for (own, _), (above, met) in zip(levels, [*levels[1:], (levels[-1][0], 0)], strict=True):
        unknowns = (3 * ORDERS * own[:, None] + np.arange(3 * ORDERS)).ravel()
        yield _Level(unknowns, between(own, own), between(own, above[above.size - met :]))


def _solved(
    levels: list[_Level], observed: int, free: BoolArray, load: FloatArray
) -> Iterator[tuple[IntArray, FloatArray]]:
    """Unknowns of every level from the tip down to `observed`, and their displacement.

    Parameters
    ----------
    levels : list of _Level
        From the ground up, as they are eliminated.
    observed : int
        No level below this one is under load.
    free : (unknowns,) bool array
        Unknowns of the field.
    load : (unknowns, loads) array [N]
    """
    chosen = [np.flatnonzero(free[level.unknowns]) for level in levels]
    forces = [load[level.unknowns[some]] for level, some in zip(levels, chosen, strict=True)]
    own, passed = levels[0].stiffness[np.ix_(chosen[0], chosen[0])], []
    for number, (level, above) in enumerate(pairwise(levels)):
        some, after = chosen[number], chosen[number + 1]
        first = above.unknowns.size - level.coupling.shape[1]
        met = after[after >= first]
        factor = cholesky(own, lower=True, overwrite_a=True, check_finite=False)
        # halves of the symmetric products C^T K^-1 C and C^T K^-1 F
        half = solve_triangular(factor, level.coupling[np.ix_(some, met - first)], lower=True, check_finite=False)
        own = above.stiffness[np.ix_(after, after)]
        own[-met.size :, -met.size :] -= half.T @ half
        if number >= observed:
            force = solve_triangular(factor, forces[number], lower=True, check_finite=False)
            forces[number + 1][-met.size :] -= half.T @ force
            passed.append((level.unknowns[some], factor, half, force))
    moved = cho_solve(cho_factor(own, lower=True, check_finite=False), forces[-1], check_finite=False)
    yield levels[-1].unknowns[chosen[-1]], moved
    for unknowns, factor, half, force in reversed(passed):
        force = force - half @ moved[-half.shape[1] :]
        moved = solve_triangular(factor, force, trans="T", lower=True, check_finite=False)
        yield unknowns, moved
