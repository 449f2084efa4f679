"""Finite prisms: a tooth body of constant section as plane finite elements times cosines along its width.

A body of width L (coordinate z in [0, L]) has one plane section, several teeth on their rim. With k = n pi/L

    u = sum_n U_n(x, y) cos(k z),   v = sum_n V_n cos(k z),   w = sum_n W_n sin(k z)

so that strains are a cosine (or sine) times (B0 + k B1) q and the harmonics decouple:

    K_n = K0 + k K1 + k^2 K2,   K0 = int B0' D B0,   K1 = int (B0' D B1 + B1' D B0),   K2 = int B1' D B1

A point load P at z0 moves the section at z by  sum_n (c_n/L) cos(k z) cos(k z0) K_n^-1 P,  c_0 = 1, c_n = 2.
The cosines mirror the body at its ends: shear stress and axial displacement vanish there; `tooth_ends` sets that
displacement free. Each harmonic is assembled for one pitch; `pitch_chain` joins the pitches.

Source: Y. K. Cheung, Finite Strip Method in Structural Analysis, Pergamon 1976, ch. 6 (finite prisms);
O. C. Zienkiewicz, R. L. Taylor, The Finite Element Method, vol. 2, 5th ed. 2000, ch. 9 (semi-analytical).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix, vstack
from skfem.quadrature import get_quadrature

from semiwear.compliance.pitch_chain import (
    DEFLECTION_OFFSETS,
    STRESS_OFFSETS,
    HarmonicMatrices,
    Pitch,
    PitchRows,
    join,
)
from semiwear.compliance.section_mesh import ELEMENT, SectionMesh, SectionMeshError, jacobians, section_mesh
from semiwear.geometry.section import RingRim, ToothSection
from semiwear.kept_on_disk import kept_on_disk

__all__ = [
    "DEFLECTION_OFFSETS",
    "STRESS_OFFSETS",
    "PrismSection",
    "elasticity",
    "fillet_edges",
    "fillet_shares",
    "harmonic_matrices",
    "mid_surface",
    "prism_section",
    "section_integrals",
]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class PrismSection:
    """Influence of unit loads on the flank of one tooth, harmonic by harmonic along the width.

    A load P at height j and width coordinate z0, along the inward normal of the flank, gives at z

        deflection  P sum_n cos(n pi z/L) cos(n pi z0/L) deflection[n, offset, i, j]   [mm]
        stress      P sum_n cos(n pi z/L) cos(n pi z0/L) stress[n, offset, f, j]       [MPa]

    (the factors 1/L, 2/L are in the arrays).

    Attributes
    ----------
    width : float
        Width L of the prism [mm].
    load_profile : (H,) array
        Profile coordinate of the load heights, from the lower end of the flank to the tip.
    depth : (H,) array [mm]
        Distance from the flank to the mid-surface point that belongs to it, along the inward normal.
    deflection : (N, 5, H, H) array [mm/N]
        Displacement of the mid-surface point of height i of the tooth at an offset of `DEFLECTION_OFFSETS`,
        along the inward normal at i, for a unit load at height j of the middle tooth. Made reciprocal:
        ``deflection[:, 2 + o] == deflection[:, 2 - o]`` transposed.
    stress : (N, 3, F, H) array [MPa/N]
        Tangential stress at the points of the fillet on the loaded side (x > 0) of the tooth at an offset of
        `STRESS_OFFSETS`, tensile positive.
    fillet_points : (F, 2) array [mm]
        Where the stress is given, from the end of the flank to the root.
    fillet_share : (F,) array
        The same places as length from the end of the flank over the fillet's.
    asymmetry : float
        Greatest change that making the deflection reciprocal brought, relative to the greatest at n = 0.
    """

    width: float
    load_profile: FloatArray
    depth: FloatArray
    deflection: FloatArray
    stress: FloatArray
    fillet_points: FloatArray
    fillet_share: FloatArray
    asymmetry: float


@kept_on_disk
def prism_section(
    section: ToothSection,
    *,
    width: float,
    youngs_modulus: float,
    poissons_ratio: float,
    harmonics: int = 33,
    heights: int = 12,
    rack_teeth: int = 21,
    solve_every: bool = False,
    fillet_elements: int = 8,
    elements_across: int = 5,
    elements_below: int | None = None,
    name: str = "tooth section",
) -> PrismSection:
    """Influence of flank loads on mid-surface deflection and fillet stress of a prismatic tooth body.

    Parameters
    ----------
    section : ToothSection
        Half outline of a tooth and its rim [mm].
    width : float
        Width L of the prism [mm].
    youngs_modulus : float
        Young's modulus [MPa].
    poissons_ratio : float
        Poisson's ratio, below 0.5.
    harmonics : int
        Number N of cosines, n = 0 ... N - 1. The shortest wave, 2 L/(N - 1), should be at most about a third
        of the tooth height.
    heights : int
        Number H of load heights.
    rack_teeth : int
        Teeth of a rack, an odd number; its ends are free. Influence on teeth beyond them is zero. A ring is
        always whole.
    solve_every : bool
        Solve every harmonic instead of about fourteen with a spline between them.
    fillet_elements, elements_across, elements_below, name
        See `section_mesh`; by default 3 elements below a tooth, and more on a ring whose bore is small. These and
        the heights are spent where they count: the greatest fillet stress is within 0.8 % of the converged
        section's. With six along the fillet, a load within half a millimetre of its upper end leaves a false
        stress below it, half as high as the true peak.

    Returns
    -------
    PrismSection

    Raises
    ------
    SectionMeshError
        If the section cannot be meshed, or a ring has fewer than 6 teeth.
    ValueError
        If a number is out of its range.

    Notes
    -----
    Two limits. Loads are points of the section, so that stress within about 2 mm of a load depends on the
    mesh; the lowest height is the end of the fillet itself. And waves shorter than 2 L/(N - 1) are missing:
    where the mid-surface lies closer to the load than half of that (thin tips), its deflection under a point
    load is too small, though not under one spread over such a length.
    """
    _check_numbers(width, youngs_modulus, poissons_ratio, harmonics, rack_teeth)
    if isinstance(section.rim, RingRim) and section.rim.teeth < 6:
        raise SectionMeshError(f"{name}: a ring needs 6 teeth at least, not {section.rim.teeth}")
    mesh = section_mesh(
        section,
        heights=heights,
        fillet_elements=fillet_elements,
        elements_across=elements_across,
        elements_below=_elements_below(section) if elements_below is None else elements_below,
        name=name,
    )
    observer = _Observer.of(mesh, youngs_modulus, poissons_ratio)
    k0, mixed, k2 = _mixed_matrices(mesh, youngs_modulus, poissons_ratio)
    pitch = Pitch.of(mesh, section, (k0, mixed + mixed.T, k2), observer.rows)

    solved = np.arange(harmonics) if solve_every else _solved_harmonics(harmonics)
    wave_number = np.arange(harmonics) * np.pi / width
    deflection, stress = join([pitch.condense(k) for k in wave_number[solved]], section, rack_teeth)

    weight = np.where(np.arange(harmonics) == 0, 1.0, 2.0)[:, None, None, None] / width
    tooth_height = mesh.nodes[mesh.centre_line[0], 1] - mesh.nodes[mesh.fillet[-1], 1]
    variable = np.arcsinh(4 * tooth_height * wave_number)
    deflection = weight * _between_harmonics(variable[solved], deflection, variable)
    stress = weight * _between_harmonics(variable[solved], stress, variable)
    reciprocal = (deflection + deflection[:, ::-1].swapaxes(2, 3)) / 2
    asymmetry = np.abs(reciprocal - deflection).max() / np.abs(deflection[0]).max()
    return PrismSection(
        width=float(width),
        load_profile=mesh.load_profile,
        depth=observer.depth,
        deflection=reciprocal,
        stress=stress,
        fillet_points=observer.fillet_points,
        fillet_share=fillet_shares(mesh),
        asymmetry=float(asymmetry),
    )


def harmonic_matrices(mesh: SectionMesh, youngs_modulus: float, poissons_ratio: float) -> HarmonicMatrices:
    """Matrices K0, K1, K2 of the stiffness K_n = K0 + k K1 + k^2 K2, unknowns 3 node + (u, v, w).

    Parameters
    ----------
    mesh : SectionMesh
    youngs_modulus : float
        [MPa]
    poissons_ratio : float

    Returns
    -------
    tuple of three (3 n, 3 n) sparse matrices [N/mm^2], [N/mm], [N]
        Of one and the same pattern.
    """
    k0, mixed, k2 = _mixed_matrices(mesh, youngs_modulus, poissons_ratio)
    return k0, mixed + mixed.T, k2


def _mixed_matrices(mesh: SectionMesh, youngs_modulus: float, poissons_ratio: float) -> HarmonicMatrices:
    """K0, M = int B0' D B1, whose sum with its transpose is K1, and K2."""
    values = _values()
    along = np.zeros((values.shape[1], 6, 9, 3))
    along[:, 2, :, 2] = values.T
    along[:, 4, :, 1] = along[:, 5, :, 0] = -values.T
    return _integrals(mesh, youngs_modulus, poissons_ratio, along)


def section_integrals(
    mesh: SectionMesh, youngs_modulus: float, poissons_ratio: float, along: float, lean: float
) -> HarmonicMatrices:
    """Integrals over a section of a body whose sections are alike along z: strains are B0 q + B1 dq/dz.

    Parameters
    ----------
    mesh : SectionMesh
    youngs_modulus : float [MPa]
    poissons_ratio : float
    along, lean : float
        Along the body d/ds = along d/dz, and d/dx takes in lean d/dz: 1 and 0 where z stands on the section.

    Returns
    -------
    tuple of three (3 n, 3 n) sparse matrices
        Of B0' D B0, B0' D B1 and B1' D B1.
    """
    values = _values()
    by_z = np.zeros((values.shape[1], 6, 9, 3))
    by_z[:, 2, :, 2] = by_z[:, 4, :, 1] = by_z[:, 5, :, 0] = along * values.T
    for strain, component in ((0, 0), (3, 1), (5, 2)):
        by_z[:, strain, :, component] += lean * values.T
    return _integrals(mesh, youngs_modulus, poissons_ratio, by_z)


def _values() -> FloatArray:
    """Shape functions at the quadrature places: (9, q) array."""
    points, _ = get_quadrature(ELEMENT.refdom, 4)
    return np.array([ELEMENT.lbasis(points, a)[0] for a in range(9)])


def _integrals(
    mesh: SectionMesh, youngs_modulus: float, poissons_ratio: float, along: FloatArray
) -> HarmonicMatrices:
    """Integrals of B0' D B0, B0' D B1 and B1' D B1 with B1 given at the quadrature places, (q, 6, 9, 3)."""
    points, weights = get_quadrature(ELEMENT.refdom, 4)
    reference = np.array([ELEMENT.lbasis(points, a)[1] for a in range(9)])  # (9, 2, q)
    jacobian = jacobians(mesh, points)
    gradient = np.einsum("ajq,mqji->mqia", reference, np.linalg.inv(jacobian))
    area = np.linalg.det(jacobian) * weights

    # strains (xx, yy, zz, xy, yz, xz) of element unknowns (9 nodes, 3 components)
    plane = np.zeros((*gradient.shape[:2], 6, 9, 3))
    plane[:, :, 0, :, 0] = plane[:, :, 3, :, 1] = plane[:, :, 5, :, 2] = gradient[:, :, 0]
    plane[:, :, 1, :, 1] = plane[:, :, 3, :, 0] = plane[:, :, 4, :, 2] = gradient[:, :, 1]
    b0 = plane.reshape(*plane.shape[:3], 27)
    b1 = np.broadcast_to(along.reshape(-1, 6, 27), b0.shape)

    hooke = elasticity(youngs_modulus, poissons_ratio)
    s0, s1 = (area[:, :, None, None] * (hooke @ b) for b in (b0, b1))
    unknowns = (3 * mesh.elements[:, :, None] + np.arange(3)).reshape(len(mesh.elements), 27)
    size = 3 * len(mesh.nodes)
    rows = np.repeat(unknowns, 27, axis=1).ravel()
    columns = np.tile(unknowns, (1, 27)).ravel()

    def assemble(b: FloatArray, stress: FloatArray) -> csc_matrix:
        return coo_matrix((_integral(b, stress).ravel(), (rows, columns)), shape=(size, size)).tocsc()

    return assemble(b0, s0), assemble(b0, s1), assemble(b1, s1)


def _integral(b: FloatArray, stress: FloatArray) -> FloatArray:
    """Sum over quadrature points of B' S: two (m, q, 6, 27) arrays -> (m, 27, 27)."""
    return b.reshape(len(b), -1, 27).swapaxes(1, 2) @ stress.reshape(len(b), -1, 27)


def elasticity(youngs_modulus: float, poissons_ratio: float) -> FloatArray:
    """Hooke's law of an isotropic body, (xx, yy, zz, xy, yz, xz) with engineering shear strain [MPa]."""
    shear = youngs_modulus / (2 * (1 + poissons_ratio))
    lame = 2 * shear * poissons_ratio / (1 - 2 * poissons_ratio)
    matrix = np.diag([2 * shear] * 3 + [shear] * 3)
    matrix[:3, :3] += lame
    return matrix


@dataclass(frozen=True)
class _Observer:
    """Loads and observed quantities of one tooth as sparse rows on its degrees of freedom."""

    load: csr_matrix  # (H, 3 n): unit loads on the flank
    deflection: csr_matrix  # (H, 3 n)
    stress: csr_matrix  # (F, 3 n): part that the section strains, and ...
    stress_along: csr_matrix  # ... part to be multiplied by k
    depth: FloatArray
    fillet_points: FloatArray

    @classmethod
    def of(cls, mesh: SectionMesh, youngs_modulus: float, poissons_ratio: float) -> _Observer:
        plane_stress = youngs_modulus / (1 - poissons_ratio**2)
        load = _rows(mesh, mesh.flank[:, None], mesh.flank_normal[:, None])
        nodes, weights, middle = mid_surface(mesh)
        deflection = _rows(mesh, nodes, weights[:, :, None] * mesh.flank_normal[:, None])
        nodes, slopes, values, tangent, points = fillet_edges(mesh)
        stress = plane_stress * _rows(mesh, nodes, slopes[:, :, None] * tangent[:, None])
        stretch = values[:, :, None] * np.array([0.0, 0.0, 1.0])
        stress_along = plane_stress * poissons_ratio * _rows(mesh, nodes, stretch)
        depth = np.linalg.norm(middle - mesh.nodes[mesh.flank], axis=1)
        return cls(load, deflection, stress, stress_along, depth, points)

    @property
    def rows(self) -> PitchRows:
        """Loads and readings (deflection; stress) of a pitch."""
        heights, gauges = self.load.shape[0], self.stress.shape[0]
        steady = csr_matrix(self.load.shape)
        return PitchRows(
            fixed=vstack([self.load, self.deflection, self.stress]).tocsr(),
            along=vstack([steady, steady, self.stress_along]).tocsr(),
            load=slice(0, heights),
            deflection=slice(heights, 2 * heights),
            stress=slice(2 * heights, 2 * heights + gauges),
        )


def _rows(mesh: SectionMesh, nodes: IntArray, components: FloatArray) -> csr_matrix:
    """Rows that sum components (R, p, 2 or 3) times the displacements of nodes (R, p)."""
    row = np.broadcast_to(np.arange(len(nodes))[:, None, None], (*nodes.shape, components.shape[-1]))
    column = np.broadcast_to(3 * nodes[:, :, None] + np.arange(components.shape[-1]), row.shape)
    values = np.broadcast_to(components, row.shape)
    shape = (len(nodes), 3 * len(mesh.nodes))
    return coo_matrix((values.ravel(), (row.ravel(), column.ravel())), shape=shape).tocsr()


def mid_surface(mesh: SectionMesh) -> tuple[IntArray, FloatArray, FloatArray]:
    """Where the inward normals cut the centre line: nodes and their weights (H, 3), points (H, 2)."""
    flank, normal = mesh.nodes[mesh.flank], mesh.flank_normal
    height = mesh.nodes[mesh.centre_line, 1]  # falling
    cut = np.clip(flank[:, 1] - flank[:, 0] * normal[:, 1] / normal[:, 0], height[-1], height[0])
    element = np.clip(np.searchsorted(-height[::2], -cut) - 1, 0, len(height) // 2 - 1)
    local = 2 * element[:, None] + np.arange(3)
    position = (cut - height[local[:, 0]]) / (height[local[:, 2]] - height[local[:, 0]])
    weights = np.stack(_edge_values(2 * position - 1), axis=1)
    return mesh.centre_line[local], weights, np.stack([np.zeros(len(cut)), cut], axis=1)


def fillet_edges(mesh: SectionMesh) -> tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Two Gauss points a fillet edge: nodes, d/ds and value weights (F, 3), tangents and points (F, 2)."""
    edges = mesh.fillet[2 * np.arange(len(mesh.fillet) // 2)[:, None] + np.arange(3)]
    gauss = np.array([-1.0, 1.0]) / np.sqrt(3.0)
    values = np.tile(np.stack(_edge_values(gauss), axis=1), (len(edges), 1))
    slopes = np.tile(np.stack([gauss - 0.5, -2 * gauss, gauss + 0.5], axis=1), (len(edges), 1))
    nodes = np.repeat(edges, 2, axis=0)
    points = np.einsum("fa,fai->fi", values, mesh.nodes[nodes])
    tangent = np.einsum("fa,fai->fi", slopes, mesh.nodes[nodes])
    stretch = np.linalg.norm(tangent, axis=1, keepdims=True)
    return nodes, slopes / stretch, values, tangent / stretch, points


def fillet_shares(mesh: SectionMesh) -> FloatArray:
    """Length from the end of the flank over the fillet's, at two Gauss points an edge: (F,) array."""
    steps = np.linalg.norm(np.diff(mesh.nodes[mesh.fillet], axis=0), axis=1)
    arc = np.concatenate([[0.0], np.cumsum(steps)])
    edges = arc[2 * np.arange(len(arc) // 2)[:, None] + np.arange(3)]
    return np.asarray((edges @ np.array(_edge_values(np.array([-1.0, 1.0]) / np.sqrt(3.0)))).ravel() / arc[-1])


def _edge_values(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Quadratic shape functions of an edge, -1 <= x <= 1, of its first, middle and last node."""
    return x * (x - 1) / 2, 1 - x**2, x * (x + 1) / 2


def _solved_harmonics(harmonics: int) -> IntArray:
    """Harmonics to solve: 0 to 6 and then by steps of a quarter, 8, 10, 12, 16 ..., and the last."""
    solved = [0]
    while solved[-1] < harmonics - 1:
        solved.append(min(max(solved[-1] + 1, round(1.25 * solved[-1])), harmonics - 1))
    return np.array(solved)


def _elements_below(section: ToothSection) -> int:
    """Elements from a tooth down to where it is held: towards a small bore strains grow as 1/r^2."""
    if not isinstance(section.rim, RingRim) or section.rim.bore_radius <= 0.0:
        return 3  # a ring without a bore is refused when it is meshed
    ratio = float(np.hypot(*section.fillet[-1])) / section.rim.bore_radius
    return 3 + max(0, ceil(2.0 * log(ratio / 2.5)))


def _between_harmonics(solved: FloatArray, values: FloatArray, wanted: FloatArray) -> FloatArray:
    """Quintic spline through the solved harmonics and their mirror images: influence is even in k."""
    if len(solved) == len(wanted):
        return values
    mirrored = np.concatenate([-solved[:0:-1], solved])
    return np.asarray(make_interp_spline(mirrored, np.concatenate([values[:0:-1], values]), k=5)(wanted))


def _check_numbers(
    width: float, youngs_modulus: float, poissons_ratio: float, harmonics: int, rack_teeth: int
) -> None:
    if not (width > 0 and youngs_modulus > 0):
        raise ValueError(f"width and Young's modulus must be positive, not {width} and {youngs_modulus}")
    if not -1 < poissons_ratio < 0.5:
        raise ValueError(f"Poisson's ratio must lie between -1 and 0.5, not {poissons_ratio}")
    if harmonics < 1:
        raise ValueError(f"harmonics must be 1 at least, not {harmonics}")
    if rack_teeth < 1 or rack_teeth % 2 == 0:
        raise ValueError(f"rack_teeth must be odd and positive, not {rack_teeth}")
