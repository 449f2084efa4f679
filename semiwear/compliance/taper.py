r"""Teeth whose section changes along the face: a correction of finite prisms by a model of the tapered tooth.

A prism has the local section all along. Near the load that is right; farther away the tooth
is thicker on one side than on the other, load spreads to the stiffer side, and the prism's ends are mirrors where the
real ones are free. These effects are smooth, so few shapes of the section describe them. With the same mesh on every
section (its nodes move with z) and displacements

    u(X, z) = sum_r Phi_r(X) c_r(z)        c_r cubic B-splines along the face, Phi_r shapes of three pitches,

the strain is B_a u + B_b du/dz, where B_a contains the slant of the lines along the tooth (the derivative by z at a
point is that along such a line minus the slant times the derivatives in the section), and Galerkin's matrix

    int  c' A c + c' M c_z + c_z' M' c + c_z' B c_z  dz,   A = Phi' int B_a' D B_a Phi and so on, splines in z,

is small and banded; its ends are free by the natural boundary condition. The solution of the prisms of single
sections in the same shapes is subtracted, and that of the tapered tooth added: truncation errors are in both and
cancel.

Source: Ritz's method on a reduced basis: G. Rozza, D. B. P. Huynh, A. T. Patera, Arch. Comput. Methods Eng. 15 (2008)
229-275; C. de Boor, A Practical Guide to Splines, 2001 (B-splines).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BSpline, CubicSpline
from scipy.linalg import eigh
from scipy.sparse import coo_matrix, csr_matrix, vstack
from scipy.sparse.linalg import splu

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.compliance.block_band import solve_block_band
from semiwear.compliance.open_ends import EndJumps
from semiwear.compliance.pitch_chain import DEFLECTION_OFFSETS
from semiwear.compliance.prism import PrismSection
from semiwear.compliance.section_elements import (
    elasticity,
    fillet_edges,
    fillet_shares,
    gradients,
    harmonic_integrals,
    mid_surface,
    node_rows,
    plane_strains,
    shape_values,
    strain_integrals,
    unknowns_of,
    unknowns_of_elements,
)
from semiwear.compliance.section_mesh import SectionMesh, section_mesh
from semiwear.geometry.section import ToothSection
from semiwear.kept_on_disk import kept_on_disk
from semiwear.threads import in_threads

_OFFSETS = (-1, 0, 1)  # pitches of the tapered tooth
_SHAPE_TOLERANCE = 1e-4  # of the energy of the strongest shape
_SHAPE_WAVES = (0, 2, 6, 16)  # harmonics whose solutions give the shapes
_JUMPS = 8
_DEGREE = 3


@dataclass(frozen=True)
class Taper:
    """Correction of residual prisms for a tapered tooth, on load heights (H) and B-splines along the face (N).

    Attributes
    ----------
    knots : (N + 4,) array [mm]
        Knots of the cubic splines, in face coordinates.
    deflection : (3, H N, H N) array [mm/N]
        [tooth offset, observer, load], observers and loads (height, spline); a unit load at height i and z acts
        on the splines by their values at z.
    stations : (S,) array [mm]
        Face coordinates at which stress is read.
    stress : (3, H N, S F) array [MPa/N]
        [tooth offset, load, station and point of the root].
    """

    knots: FloatArray
    deflection: FloatArray
    stations: FloatArray
    stress: FloatArray

    def splines(self, face: FloatArray) -> FloatArray:
        """Values of the splines at face coordinates, (..., N)."""
        inside = np.clip(face, self.knots[0], self.knots[-1])
        return np.asarray(_splines(self.knots)(inside))


def _splines(knots: FloatArray) -> BSpline:
    return BSpline(knots, np.eye(len(knots) - _DEGREE - 1), _DEGREE)


@kept_on_disk
def tapered(
    sections: tuple[ToothSection, ...],
    faces: FloatArray,
    prisms: tuple[PrismSection, ...],
    stations: FloatArray,
    root: FloatArray,
    *,
    start: float,
    width: float,
    youngs_modulus: float,
    poissons_ratio: float,
    name: str = "tooth section",
) -> tuple[tuple[PrismSection, ...], Taper]:
    """Residual prisms of a tooth's sections, and the solution of the tapered tooth that replaces the subtracted part.

    Parameters
    ----------
    sections : tuple of B ToothSection
        On racks, from one end of the tooth to the other; four at least.
    faces : (B,) array [mm]
        Face coordinates of the sections, growing.
    prisms : tuple of B PrismSection
        Of those sections, with mirrored ends and the width of the tooth.
    stations : (S,) array [mm]
        Face coordinates at which stress is to be read.
    root : (F,) array
        Points of the root at which stress is to be read, as shares of the fillet's length.
    start, width : float [mm]
        Face coordinate of the lower end, and length of the tooth.
    youngs_modulus [MPa], poissons_ratio : float
    name : str
        Name of the sections in error messages.
    """
    heights, harmonics = prisms[0].load_profile.size, prisms[0].deflection.shape[0]
    meshes = [section_mesh(section, heights=heights, land_elements=1, name=name) for section in sections]
    elastic = youngs_modulus, poissons_ratio
    pitches = _Pitches.of(meshes[0])
    few = np.unique(np.linspace(0, len(meshes) - 1, 3).round().astype(int))
    shapes, axial = _shapes([meshes[k] for k in few], pitches, width, elastic)
    places = CubicSpline(faces, np.stack([mesh.nodes for mesh in meshes]))
    slants = places(faces, 1)

    def straight_and_slanted(section: int) -> tuple[PrismSection, _Reduced]:
        mesh = meshes[section]
        straight = _Reduced.of(mesh, np.zeros_like(mesh.nodes), shapes, elastic)
        residual = _residual(prisms[section], straight, axial, width)
        return residual, _Reduced.of(mesh, slants[section], shapes, elastic)

    residual, slanted = zip(*in_threads(straight_and_slanted, range(len(meshes))), strict=True)
    knots = _knots(start, width, harmonics + 7)
    return residual, _solved(list(slanted), faces, knots, stations, root)


def _knots(start: float, width: float, spans: int) -> FloatArray:
    """Knots at about the prisms' shortest half wave length, and at half of it beside the ends."""
    even = np.arange(spans + 1.0)
    beside = np.array([0.5, 1.5])
    places = start + width * np.sort(np.concatenate([even, beside, spans - beside])) / spans
    return np.concatenate([[start] * _DEGREE, places, [start + width] * _DEGREE])


@dataclass(frozen=True)
class _Pitches:
    """Three pitches side by side as one: maps (3 n, m) from their free unknowns to those of each pitch's mesh."""

    maps: tuple[csr_matrix, ...]

    @classmethod
    def of(cls, mesh: SectionMesh) -> _Pitches:
        count, total = len(mesh.nodes), 0
        numbers: list[IntArray] = []
        for pitch in range(len(_OFFSETS)):
            number = np.full(count, -1)
            if pitch:
                number[mesh.left] = numbers[-1][mesh.right]
            fresh = np.flatnonzero(number < 0)
            number[fresh] = total + np.arange(fresh.size)
            total += fresh.size
            numbers.append(number)
        held = np.unique([number[mesh.held] for number in numbers])
        free = np.setdiff1d(np.arange(total), held)
        place = np.full(total, -1)
        place[free] = np.arange(free.size)
        maps = []
        for number in numbers:
            own = np.flatnonzero(place[number] >= 0)
            rows, columns = unknowns_of(own), unknowns_of(place[number[own]])
            maps.append(coo_matrix((np.ones(rows.size), (rows, columns)), shape=(3 * count, 3 * free.size)).tocsr())
        return cls(tuple(maps))

    def joined(self, matrix: csr_matrix) -> csr_matrix:
        """Matrix of the three pitches from that of each."""
        return sum((m.T @ matrix @ m for m in self.maps[1:]), start=self.maps[0].T @ matrix @ self.maps[0])


def _shapes(
    meshes: list[SectionMesh], pitches: _Pitches, width: float, elastic: tuple[float, float]
) -> tuple[tuple[FloatArray, ...], BoolArray]:
    """Shapes (3 n, r) of the three pitches, and which of the r are axial.

    They are prism solutions at a few sections and waves for loads on the flank and jumps of an end
    (`open_ends`); motion in the section and along the face are separate shapes. Those of greatest energy are kept.
    """
    reference_wave = 4.0 * np.pi / width  # wave number for energies along the face

    def solutions_of(mesh: SectionMesh) -> tuple[FloatArray, csr_matrix]:
        k0, mixed, k2 = harmonic_integrals(mesh, *elastic)
        jumps = EndJumps.of(mesh, k0, mixed, k2, _JUMPS)
        own = pitches.maps[_OFFSETS.index(0)]
        load = node_rows(mesh, mesh.flank[:, None], mesh.flank_normal[:, None])
        whole = [pitches.joined(matrix) for matrix in (k0, mixed + mixed.T, k2)]
        jump = np.kron(jumps.jump, np.array([[0.0], [0.0], [1.0]]))
        found = [(own.T @ jump) / (reference_wave * np.sqrt(np.diag(jumps.stiffness)))]
        for wave in _SHAPE_WAVES:
            k = wave * np.pi / width
            loads = (vstack([load, jumps.strained + k * jumps.stretched]) @ own).toarray().T
            stiffness = (whole[0] + k * whole[1] + k**2 * whole[2]).tocsc()
            # symmetric and positive: no pivoting
            symmetric = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
            moved = splu(stiffness, **symmetric).solve(loads)
            found.append(moved / np.sqrt(np.einsum("ij,ij->j", moved, loads)))
        return np.hstack(found), whole[0] + reference_wave**2 * whole[2]

    each = in_threads(solutions_of, meshes)
    solutions, mixed_energy = np.hstack([found for found, _ in each]), each[len(meshes) // 2][1]
    component = np.arange(len(solutions)) % 3
    kept = []
    for part in (component < 2, component == 2):
        own_part = np.where(part[:, None], solutions, 0.0)
        energy, vector = eigh(own_part.T @ (mixed_energy @ own_part))
        strong = energy > _SHAPE_TOLERANCE * energy[-1]
        kept.append(own_part @ (vector[:, strong] / np.sqrt(energy[strong])))
    shapes = np.hstack(kept)
    axial = np.arange(shapes.shape[1]) >= kept[0].shape[1]
    return tuple(m @ shapes for m in pitches.maps), axial


@dataclass(frozen=True)
class _Reduced:
    """A section on few shapes.

    Attributes
    ----------
    stiffness : (3, r, r) array
        A [N/mm^2], M [N/mm], B [N].
    load : (H, r) array
        Unit loads.
    deflection : (3, H, r) array
        Readings on the teeth at `_OFFSETS`.
    stress, stress_along : (3, G, r) arrays
        Readings at the Gauss points of the fillet, of c and of its derivative along the face.
    fillet_share : (G,) array
    """

    stiffness: FloatArray
    load: FloatArray
    deflection: FloatArray
    stress: FloatArray
    stress_along: FloatArray
    fillet_share: FloatArray

    @classmethod
    def of(
        cls, mesh: SectionMesh, slant: FloatArray, shapes: tuple[FloatArray, ...], elastic: tuple[float, float]
    ) -> _Reduced:
        """A section whose nodes move by `slant` (n, 2) for each millimetre along the face."""
        unknowns = unknowns_of_elements(mesh)
        side_by_side, count = np.hstack(shapes), shapes[0].shape[1]
        in_elements = side_by_side[unknowns]
        onto = coo_matrix((np.ones(unknowns.size), (unknowns.ravel(), np.arange(unknowns.size)))).tocsr()
        stiffness = []
        for matrices in _slanted_matrices(mesh, slant, elastic):
            loaded = onto @ (matrices @ in_elements).reshape(unknowns.size, -1)
            stiffness.append(sum(p.T @ loaded[:, k * count : (k + 1) * count] for k, p in enumerate(shapes)))
        # the normal of a tapered flank has a component along the face
        along = -np.einsum("hi,hi->h", mesh.flank_normal, slant[mesh.flank])
        normal = np.column_stack([mesh.flank_normal, along])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        nodes, weights, _ = mid_surface(mesh)
        own = shapes[_OFFSETS.index(0)]
        reading = node_rows(mesh, nodes, weights[:, :, None] * normal[:, None])
        stress, stress_along = _gauges(mesh, slant, elastic)
        return cls(
            stiffness=np.stack(stiffness),
            load=node_rows(mesh, mesh.flank[:, None], normal[:, None]) @ own,
            deflection=np.stack([reading @ p for p in shapes]),
            stress=np.stack([stress @ p for p in shapes]),
            stress_along=np.stack([stress_along @ p for p in shapes]),
            fillet_share=fillet_shares(mesh),
        )


def _slanted_matrices(
    mesh: SectionMesh, slant: FloatArray, elastic: tuple[float, float]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Integrals B_a' D B_a, B_a' D B_b and B_b' D B_b over every element of a section, (m, 27, 27)."""
    gradient, area = gradients(mesh)
    values = shape_values()
    drift = np.einsum("bq,mbi,mqia->mqa", values, slant[mesh.elements], gradient, optimize=True)
    fixed = plane_strains(gradient)
    fixed[:, :, 2, :, 2] = fixed[:, :, 4, :, 1] = fixed[:, :, 5, :, 0] = -drift
    along = np.zeros((values.shape[1], 6, 9, 3))
    along[:, 2, :, 2] = along[:, 4, :, 1] = along[:, 5, :, 0] = values.T
    return strain_integrals(area, fixed, along, elasticity(*elastic))


def _gauges(mesh: SectionMesh, slant: FloatArray, elastic: tuple[float, float]) -> tuple[csr_matrix, csr_matrix]:
    """Tangential stress of the fillet: rows on displacement and on its derivative along the tooth's lines."""
    youngs_modulus, poissons_ratio = elastic
    nodes, slopes, values, tangent, _ = fillet_edges(mesh)
    moves = np.einsum("fa,fai->fi", values, slant[nodes])
    slid = np.einsum("fi,fi->f", moves, tangent)
    stretch = np.sqrt(1.0 + np.einsum("fi,fi->f", moves, moves) - slid**2)[:, None]
    # unit vector across the fillet in its surface: along the line minus its component down the fillet
    across = np.column_stack([moves - slid[:, None] * tangent, np.ones(len(slid))]) / stretch
    down = np.column_stack([tangent, np.zeros(len(slid))])
    strain = slopes[:, :, None] * (down - poissons_ratio * (slid[:, None] / stretch) * across)[:, None]
    along = poissons_ratio * (values / stretch)[:, :, None] * across[:, None]
    plane_stress = youngs_modulus / (1 - poissons_ratio**2)
    return tuple(plane_stress * node_rows(mesh, nodes, part) for part in (strain, along))


def _residual(prism: PrismSection, reduced: _Reduced, axial: BoolArray, width: float) -> PrismSection:
    """A prism minus its solution in the few shapes, wave by wave."""
    fixed, mixed, along = reduced.stiffness
    # u and v follow cosines, w sines: d/dz is -k of the former and +k of the latter
    signed = np.where(axial, 1.0, -1.0)
    mixed = mixed * signed
    deflection, stress = prism.deflection.copy(), prism.stress.copy()
    # the prism may have more elements along its fillet
    onto = _at_root(reduced, prism.fillet_share)
    strained, stretched = onto @ reduced.stress, onto @ (reduced.stress_along * signed)
    middle = DEFLECTION_OFFSETS.index(0)
    for n in range(len(deflection)):
        k = n * np.pi / width
        moved = (
            (1.0 if n == 0 else 2.0)
            / width
            * np.linalg.solve(fixed + k * (mixed + mixed.T) + k**2 * along, reduced.load.T)
        )
        seen = reduced.deflection @ moved
        seen = 0.5 * (seen + seen[::-1].swapaxes(1, 2))
        deflection[n, middle - 1 : middle + 2] -= seen
        stress[n] -= (strained + k * stretched) @ moved
    return replace(prism, deflection=deflection, stress=stress)


def _solved(
    sections: list[_Reduced], faces: FloatArray, knots: FloatArray, stations: FloatArray, root: FloatArray
) -> Taper:
    """Solution of the tapered tooth for unit loads at every height and spline."""
    basis = _splines(knots)
    slope = basis.derivative()
    count, shapes = len(knots) - _DEGREE - 1, sections[0].load.shape[1]
    between = CubicSpline(faces, np.eye(len(faces)))  # from values on the sections, (position, section)

    # integrals over the face of products of splines and of section values interpolated between sections
    ends = np.unique(knots)
    points, weights = np.polynomial.legendre.leggauss(_DEGREE + 2)
    half = np.diff(ends)[:, None] / 2
    at = (ends[:-1, None] + half * (1 + points)).ravel()
    weighted = (half * weights).ravel()[:, None] * between(at)
    value, derivative = basis(at), slope(at)
    fixed, mixed, along = (np.stack([s.stiffness[k] for s in sections]).reshape(len(sections), -1) for k in range(3))
    band = np.zeros((count, _DEGREE + 1, shapes, shapes))  # block of splines (a + d, a)
    for d in range(_DEGREE + 1):
        first = np.arange(count - d)
        a, b = value[:, d:], value[:, : count - d]
        a_z, b_z = derivative[:, d:], derivative[:, : count - d]
        block = ((a * b).T @ weighted) @ fixed + ((a_z * b_z).T @ weighted) @ along
        block = block.reshape(-1, shapes, shapes)
        block += (((a * b_z).T @ weighted) @ mixed).reshape(block.shape)
        block += (((a_z * b).T @ weighted) @ mixed).reshape(block.shape).swapaxes(1, 2)
        band[first, d] = block

    # unit loads on splines: a load at z is the splines' values at z times these, with the section at each spline
    greville = np.array([knots[k + 1 : k + 1 + _DEGREE].mean() for k in range(count)])
    heights = len(sections[0].load)
    load = np.einsum("ab,bhr->ahr", between(greville), np.stack([s.load for s in sections]))
    seen = np.einsum("ab,bphr->pahr", between(greville), np.stack([s.deflection for s in sections]))
    right = np.zeros((count, shapes, heights, count))
    right[np.arange(count), :, :, np.arange(count)] = load.swapaxes(1, 2)
    moved = solve_block_band(band, right.reshape(count, shapes, -1))
    deflection = np.einsum("pahr,arl->phal", seen, moved, optimize=True)
    deflection = deflection.reshape(len(_OFFSETS), heights * count, heights * count)
    deflection = 0.5 * (deflection + deflection[::-1].swapaxes(1, 2))

    gauges, gauges_along = (
        np.stack([[_at_root(s, root) @ part for part in getattr(s, name)] for s in sections])
        for name in ("stress", "stress_along")
    )
    own, own_along = (np.einsum("sb,bpfr->spfr", between(stations), part) for part in (gauges, gauges_along))
    shape_at, shape_along = (np.einsum("sa,arl->srl", f(stations), moved, optimize=True) for f in (basis, slope))
    stress = np.einsum("spfr,srl->plsf", own, shape_at, optimize=True)
    stress += np.einsum("spfr,srl->plsf", own_along, shape_along, optimize=True)
    return Taper(knots, deflection, stations, stress.reshape(len(_OFFSETS), heights * count, -1))


def _at_root(section: _Reduced, root: FloatArray) -> FloatArray:
    """Splines from the Gauss points of a fillet to points of the root."""
    share = section.fillet_share
    return np.asarray(CubicSpline(share, np.eye(len(share)))(root))
