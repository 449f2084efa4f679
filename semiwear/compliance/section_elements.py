"""Plane elements of a tooth's section: its stiffness, rows of loads and readings, and Gauss points of its fillet.

Unknowns are 3 node + (u, v, w). Strains are (xx, yy, zz, xy, yz, xz), shear as angles; from the unknowns of an
element, nine nodes with three components, they are matrices (6, 9, 3) at each quadrature point. B0 gives the
strains of a displacement that is constant along z, B1 those of its derivative along z.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix
from skfem.quadrature import get_quadrature

from semiwear.arrays import FloatArray, IntArray
from semiwear.compliance.quadratic import quadratic_slopes, quadratic_values
from semiwear.compliance.section_mesh import ELEMENT, SectionMesh, jacobians

HarmonicMatrices = tuple[csc_matrix, csc_matrix, csc_matrix]
"""Sparse K0, K1, K2 of the stiffness K0 + k K1 + k^2 K2 at wave number k; unknowns 3 node + (u, v, w)."""


def unknowns_of(nodes: IntArray) -> IntArray:
    """Unknowns of nodes, node by node."""
    return (3 * nodes[:, None] + np.arange(3)).ravel()


def harmonic_integrals(mesh: SectionMesh, youngs_modulus: float, poissons_ratio: float) -> HarmonicMatrices:
    """K0, M and K2 of the stiffness K0 + k (M + M') + k^2 K2 of cosines along z, of wave number k.

    Parameters
    ----------
    mesh : SectionMesh
    youngs_modulus : float [MPa]
    poissons_ratio : float

    Returns
    -------
    tuple of three (3 n, 3 n) sparse matrices [N/mm^2], [N/mm], [N]
    """
    values = shape_values()
    along = np.zeros((values.shape[1], 6, 9, 3))
    along[:, 2, :, 2] = values.T
    along[:, 4, :, 1] = along[:, 5, :, 0] = -values.T
    return _of_constant_section(mesh, along, youngs_modulus, poissons_ratio)


def section_integrals(
    mesh: SectionMesh, youngs_modulus: float, poissons_ratio: float, along: float, lean: float
) -> HarmonicMatrices:
    """Integrals over a section of a body with constant section along z: strains are B0 q + B1 dq/dz.

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
    values = shape_values()
    by_z = np.zeros((values.shape[1], 6, 9, 3))
    by_z[:, 2, :, 2] = by_z[:, 4, :, 1] = by_z[:, 5, :, 0] = along * values.T
    for strain, component in ((0, 0), (3, 1), (5, 2)):
        by_z[:, strain, :, component] += lean * values.T
    return _of_constant_section(mesh, by_z, youngs_modulus, poissons_ratio)


def _of_constant_section(
    mesh: SectionMesh, along: FloatArray, youngs_modulus: float, poissons_ratio: float
) -> HarmonicMatrices:
    """Integrals with strains in the plane as B0, and `along` as B1, (q, 6, 9, 3)."""
    gradient, area = gradients(mesh)
    found = strain_integrals(area, plane_strains(gradient), along, elasticity(youngs_modulus, poissons_ratio))
    unknowns = unknowns_of_elements(mesh)
    where = np.repeat(unknowns, 27, axis=1).ravel(), np.tile(unknowns, (1, 27)).ravel()
    shape = (3 * len(mesh.nodes),) * 2
    fixed, mixed, twice = (coo_matrix((part.ravel(), where), shape=shape).tocsc() for part in found)
    return fixed, mixed, twice


def shape_values() -> FloatArray:
    """Shape functions at the quadrature points: (9, q) array."""
    points, _ = get_quadrature(ELEMENT.refdom, 4)
    return np.array([ELEMENT.lbasis(points, a)[0] for a in range(9)])


def gradients(mesh: SectionMesh) -> tuple[FloatArray, FloatArray]:
    """Gradients of shape functions, (m, q, 2, 9) [1/mm], and areas of the quadrature points, (m, q) [mm^2]."""
    points, weights = get_quadrature(ELEMENT.refdom, 4)
    reference = np.array([ELEMENT.lbasis(points, a)[1] for a in range(9)])  # (9, 2, q)
    jacobian = jacobians(mesh, points)
    gradient = np.einsum("ajq,mqji->mqia", reference, np.linalg.inv(jacobian))
    return gradient, np.linalg.det(jacobian) * weights


def plane_strains(gradient: FloatArray) -> FloatArray:
    """B0 of a section that is constant along z, (m, q, 6, 9, 3), from `gradients`."""
    plane = np.zeros((*gradient.shape[:2], 6, 9, 3))
    plane[:, :, 0, :, 0] = plane[:, :, 3, :, 1] = plane[:, :, 5, :, 2] = gradient[:, :, 0]
    plane[:, :, 1, :, 1] = plane[:, :, 3, :, 0] = plane[:, :, 4, :, 2] = gradient[:, :, 1]
    return plane


def strain_integrals(
    area: FloatArray, fixed: FloatArray, along: FloatArray, hooke: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Integrals of B0' D B0, B0' D B1 and B1' D B1 over every element of a section, (m, 27, 27).

    Parameters
    ----------
    area : (m, q) array [mm^2]
        Of `gradients`.
    fixed : (m, q, 6, 9, 3) array
        B0.
    along : (q, 6, 9, 3) array
        B1, the same in all elements.
    hooke : (6, 6) array [MPa]
        D.
    """
    b0 = fixed.reshape(*fixed.shape[:3], 27)
    b1 = np.broadcast_to(along.reshape(-1, 6, 27), b0.shape)
    s0, s1 = (area[:, :, None, None] * (hooke @ b) for b in (b0, b1))

    def integral(b: FloatArray, stress: FloatArray) -> FloatArray:
        return np.asarray(b.reshape(len(b), -1, 27).swapaxes(1, 2) @ stress.reshape(len(b), -1, 27))

    return integral(b0, s0), integral(b0, s1), integral(b1, s1)


def unknowns_of_elements(mesh: SectionMesh) -> IntArray:
    """Unknowns of every element in the order of `strain_integrals`, (m, 27)."""
    return unknowns_of(mesh.elements.ravel()).reshape(len(mesh.elements), -1)


def elasticity(youngs_modulus: float, poissons_ratio: float) -> FloatArray:
    """Hooke's law of an isotropic body, (xx, yy, zz, xy, yz, xz) with engineering shear strain [MPa]."""
    shear = youngs_modulus / (2 * (1 + poissons_ratio))
    lame = 2 * shear * poissons_ratio / (1 - 2 * poissons_ratio)
    matrix = np.diag([2 * shear] * 3 + [shear] * 3)
    matrix[:3, :3] += lame
    return matrix


def node_rows(mesh: SectionMesh, nodes: IntArray, components: FloatArray) -> csr_matrix:
    """Rows that sum components (R, p, 2 or 3) times the displacements of nodes (R, p)."""
    row = np.broadcast_to(np.arange(len(nodes))[:, None, None], (*nodes.shape, components.shape[-1]))
    column = np.broadcast_to(3 * nodes[:, :, None] + np.arange(components.shape[-1]), row.shape)
    values = np.broadcast_to(components, row.shape)
    shape = (len(nodes), 3 * len(mesh.nodes))
    return coo_matrix((values.ravel(), (row.ravel(), column.ravel())), shape=shape).tocsr()


def mid_surface(mesh: SectionMesh) -> tuple[IntArray, FloatArray, FloatArray]:
    """Intersections of the inward normals with the centre line: nodes and their weights (H, 3), points (H, 2).

    On a thin rim they stay above half its thickness, away from the held face, which does not deflect.
    """
    flank, normal = mesh.nodes[mesh.flank], mesh.flank_normal
    height = mesh.nodes[mesh.centre_line, 1]  # falling
    rim = np.linalg.norm(mesh.nodes[mesh.right[0]] - mesh.nodes[mesh.right[-1]])
    cut = np.clip(flank[:, 1] - flank[:, 0] * normal[:, 1] / normal[:, 0], height[-1] + 0.5 * rim, height[0])
    element = np.clip(np.searchsorted(-height[::2], -cut) - 1, 0, len(height) // 2 - 1)
    local = 2 * element[:, None] + np.arange(3)
    position = (cut - height[local[:, 0]]) / (height[local[:, 2]] - height[local[:, 0]])
    weights = quadratic_values(2 * position - 1).T
    return mesh.centre_line[local], weights, np.stack([np.zeros(len(cut)), cut], axis=1)


def fillet_edges(mesh: SectionMesh) -> tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Two Gauss points a fillet edge: nodes, d/ds and value weights (F, 3), tangents and points (F, 2)."""
    edges = mesh.fillet[2 * np.arange(len(mesh.fillet) // 2)[:, None] + np.arange(3)]
    gauss = np.array([-1.0, 1.0]) / np.sqrt(3.0)
    values = np.tile(quadratic_values(gauss).T, (len(edges), 1))
    slopes = np.tile(quadratic_slopes(gauss).T, (len(edges), 1))
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
    return np.asarray((edges @ quadratic_values(np.array([-1.0, 1.0]) / np.sqrt(3.0))).ravel() / arc[-1])
