r"""Three-dimensional isotropic linear elasticity on hexahedra.

    K_(ai)(bj) = int [ lambda N_a,i N_b,j + mu N_a,j N_b,i + mu delta_ij N_a,k N_b,k ] dV

from the gradients of the shape functions alone, batched over elements. Elements are isoparametric: "hex20" and
"hex27" have curved sides when the mesh is a `skfem.MeshHex2`. "hex8i" adds the incompatible modes 1 - xi_i^2,
whose gradients are taken with the Jacobian at the element's centre, so that they do no work in a constant
stress (patch test), and are condensed on each element.

Source: R. L. Taylor, P. J. Beresford, E. L. Wilson, Int. J. Numer. Meth. Engng 10 (1976) 1211-1219;
J. Barlow, ibid. 10 (1976) 243-251 (stress is best at the 2 x 2 x 2 Gauss points).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import bsr_matrix, coo_matrix, csr_matrix
from skfem import Element, ElementHex1, ElementHex2, ElementHexS2, MeshHex
from skfem.assembly import Dofs
from skfem.quadrature import get_quadrature

from fem_reference.arrays import FloatArray, IntArray
from semiwear.scene import Material

STRESS_COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")
"""Order of the six components of stress, and of strain with engineering shear."""

_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
_BATCH = 400  # elements worked on at once, to bound the memory


@dataclass(frozen=True)
class _Kind:
    """A shape of element: scikit-fem's element, polynomial degree of the quadrature, incompatible modes."""

    element: Element
    degree: int
    modes: bool


ELEMENTS = {
    "hex8i": _Kind(ElementHex1(), 3, True),
    "hex20": _Kind(ElementHexS2(), 5, False),
    "hex27": _Kind(ElementHex2(), 5, False),
}
"""The elements by name: trilinear with incompatible modes, 20-node serendipity, 27-node."""


class ElasticBody:
    """A body of one isotropic material.

    Parameters
    ----------
    mesh : skfem.MeshHex or skfem.MeshHex2
        Lengths in mm.
    element : str
        ``"hex8i"``, ``"hex20"`` or ``"hex27"``.
    youngs_modulus : float
        Young's modulus [MPa].
    poissons_ratio : float
        Poisson's ratio.

    Attributes
    ----------
    points : (n, 3) array [mm]
        Displacement nodes; the first ones are the vertices of the mesh, in its order.
    elements : (m, k) array
        Displacement nodes of each element, in scikit-fem's order.

    Raises
    ------
    ValueError
        For an unknown element, an impossible material or a folded element.
    """

    def __init__(self, mesh: MeshHex, *, element: str = "hex8i", youngs_modulus: float, poissons_ratio: float):
        if element not in ELEMENTS:
            raise ValueError(f"element must be one of {', '.join(ELEMENTS)}, not {element!r}")
        if not (youngs_modulus > 0.0 and -1.0 < poissons_ratio < 0.5):
            raise ValueError(f"impossible material: E = {youngs_modulus} MPa, nu = {poissons_ratio}")
        self.mesh = mesh
        self.element = element
        self.youngs_modulus = float(youngs_modulus)
        self.poissons_ratio = float(poissons_ratio)
        self._kind = ELEMENTS[element]
        self.elements: IntArray = Dofs(mesh, self._kind.element).element_dofs.T.astype(np.int64)
        self.points: FloatArray = self._node_points()

    @classmethod
    def of(cls, mesh: MeshHex, element: str, material: Material) -> ElasticBody:
        """A body of a scene's material."""
        elastic = {"youngs_modulus": material.youngs_modulus_MPa, "poissons_ratio": material.poissons_ratio}
        return cls(mesh, element=element, **elastic)

    @property
    def lame(self) -> tuple[float, float]:
        """Lame's constants lambda and mu [MPa]."""
        e, nu = self.youngs_modulus, self.poissons_ratio
        return e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu))

    def dofs(self, nodes: IntArray) -> IntArray:
        """Numbers of the x, y and z unknowns of displacement nodes: (..., 3) array."""
        return 3 * np.asarray(nodes, dtype=np.int64)[..., None] + np.arange(3)

    def free_dofs(self, fixed_nodes: IntArray) -> IntArray:
        """Numbers of the unknowns left when displacement nodes are held."""
        free = np.ones(self.points.size, dtype=bool)
        free[self.dofs(fixed_nodes)] = False
        return np.flatnonzero(free)

    @cached_property
    def stiffness(self) -> csr_matrix:
        """Stiffness matrix of the unsupported body [N/mm]."""
        nodes = self.elements.shape[1]
        lame, shear = self.lame
        blocks = np.empty((len(self.elements), nodes, nodes, 3, 3))
        for start in range(0, len(self.elements), _BATCH):
            part = slice(start, start + _BATCH)
            local = _local_stiffness(*self._gradients(part, _gauss(self._kind.degree)), lame, shear)
            local = _condense(local, 3 * nodes)[0]
            blocks[part] = local.reshape(-1, nodes, 3, nodes, 3).transpose(0, 1, 3, 2, 4)
        return _assemble(self.elements, blocks.reshape(-1, 3, 3), len(self.points))

    def stress(self, displacement: FloatArray, points_on: str = "nodes", nodes: IntArray | None = None) -> FloatArray:
        """Stress from a displacement.

        Parameters
        ----------
        displacement : (3 n,) or (3 n, k) array [mm]
            One displacement of all unknowns, or k of them.
        points_on : str
            ``"nodes"``: extrapolated from the 2 x 2 x 2 Gauss points and averaged over the elements of a node;
            ``"gauss"``: at the 2 x 2 x 2 Gauss points of each element.
        nodes : array of int, optional
            Displacement nodes; default all.

        Returns
        -------
        (nodes, 6) or (elements, 8, 6) array, with k as last axis for k displacements [MPa]
            Components as in `STRESS_COMPONENTS`.
        """
        if points_on not in ("nodes", "gauss"):
            raise ValueError(f"points_on must be 'nodes' or 'gauss', not {points_on!r}")
        columns = displacement.shape[1:]
        if points_on == "nodes":
            chosen = np.arange(len(self.points)) if nodes is None else np.asarray(nodes)
            return np.asarray((self.stress_operator(chosen) @ displacement).reshape(len(chosen), 6, *columns))
        result = np.empty((len(self.elements), 8, 6, *columns))
        for start in range(0, len(self.elements), _BATCH):
            part = slice(start, start + _BATCH)
            unknowns = self._element_dofs(part)
            result[part] = np.einsum("mqsa,ma...->mqs...", self._stress_matrices(part), displacement[unknowns])
        return result

    def stress_operator(self, nodes: IntArray) -> csr_matrix:
        """Matrix that turns a displacement into the nodal stress at some nodes: (6 nodes, 3 n) [MPa/mm]."""
        chosen, back = np.unique(nodes, return_inverse=True)
        row_of = np.full(len(self.points), -1, dtype=np.int64)
        row_of[chosen] = np.arange(len(chosen))
        touching = np.flatnonzero((row_of[self.elements] >= 0).any(axis=1))
        to_nodes = _trilinear(_local_nodes(self._kind.element), _gauss(3)[0])
        share = np.bincount(self.elements.ravel(), minlength=len(self.points))
        rows, columns, values = [], [], []
        for part in np.array_split(touching, len(touching) // _BATCH + 1):
            at_nodes = np.einsum("pq,mqsa->mpsa", to_nodes, self._stress_matrices(part))
            element, local = np.nonzero(row_of[self.elements[part]] >= 0)
            node = self.elements[part][element, local]
            block = at_nodes[element, local] / share[node, None, None]
            unknowns = self._element_dofs(part)[element]
            row = 6 * row_of[node][:, None] + np.arange(6)
            rows.append(np.broadcast_to(row[:, :, None], block.shape).ravel())
            columns.append(np.broadcast_to(unknowns[:, None, :], block.shape).ravel())
            values.append(block.ravel())
        triplets = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        once = coo_matrix(triplets, shape=(6 * len(chosen), self.points.size)).tocsr()
        return once[(6 * back[:, None] + np.arange(6)).ravel()]

    # --- inside ------------------------------------------------------------------------------------------------

    def _node_points(self) -> FloatArray:
        """Places of the displacement nodes: those of a curved mesh, or midway between straight vertices."""
        count = int(self.elements.max()) + 1
        if self.mesh.doflocs.shape[1] >= count:
            return np.ascontiguousarray(self.mesh.doflocs[:, :count].T)
        corners = self.mesh.p.T[self.mesh.t.T]
        weights = np.array([ElementHex1().lbasis(_local_nodes(self._kind.element).T, a)[0] for a in range(8)])
        points = np.empty((count, 3))
        points[self.elements] = np.einsum("ap,mai->mpi", weights, corners)
        return points

    def _element_dofs(self, part: slice | IntArray) -> IntArray:
        unknowns = self.dofs(self.elements[part])
        return unknowns.reshape(len(unknowns), -1)

    def _gradients(
        self, part: slice | IntArray, quadrature: tuple[FloatArray, FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        """Gradients (elements, points, functions, 3) of shape functions and modes, and volumes of the points."""
        points, weights = quadrature
        element, corners = self._kind.element, self.points[self.elements[part]]
        reference = _reference_gradients(element, points)
        jacobian = np.einsum("ajq,mai->mqij", reference, corners)
        determinant = np.linalg.det(jacobian)
        determinant = determinant * np.sign(determinant[:, :1])  # scikit-fem's own numbering is left-handed
        if not (determinant > 0.0).all():
            place = corners[np.argmin(determinant.min(axis=1))].mean(axis=0)
            raise ValueError(f"an element near {np.round(place, 3)} mm is folded: its Jacobian changes sign")
        gradients = np.einsum("ajq,mqji->mqai", reference, np.linalg.inv(jacobian))
        if self._kind.modes:
            centre = np.einsum("aj,mai->mij", _reference_gradients(element, np.full((3, 1), 0.5))[..., 0], corners)
            # d(1 - xi_j^2)/dxi_j on the unit cube, xi_j = 2 X_j - 1, with the Jacobian of the centre
            slope = -4.0 * (2.0 * points - 1.0).T
            ratio = np.abs(np.linalg.det(centre))[:, None] / determinant
            modes = np.einsum("mq,qj,mji->mqji", ratio, slope, np.linalg.inv(centre))
            gradients = np.concatenate([gradients, modes], axis=2)
        return gradients, determinant * weights

    def _stress_matrices(self, part: slice | IntArray) -> FloatArray:
        """Stress at the 2 x 2 x 2 Gauss points from the element's unknowns: (elements, 8, 6, 3 nodes) [MPa/mm]."""
        lame, shear = self.lame
        gradients, volumes = self._gradients(part, _gauss(3))
        strain = np.zeros((*gradients.shape[:2], 6, gradients.shape[2], 3))
        for row, (i, j) in enumerate(_PAIRS):
            strain[:, :, row, :, i] = gradients[..., j]
            strain[:, :, row, :, j] = gradients[..., i]
        strain = strain.reshape(*gradients.shape[:2], 6, -1)
        if self._kind.modes:
            outer = 3 * self.elements.shape[1]
            amplitudes = _condense(_local_stiffness(gradients, volumes, lame, shear), outer)[1]
            strain = strain[..., :outer] - strain[..., outer:] @ amplitudes[:, None]
        hooke = shear * np.diag([2.0, 2.0, 2.0, 1.0, 1.0, 1.0])
        hooke[:3, :3] += lame
        return hooke @ strain


def _gauss(degree: int) -> tuple[FloatArray, FloatArray]:
    """Gauss points (3, q) of the unit cube and weights (q,), exact for a degree in each direction."""
    points, weights = get_quadrature(ElementHex1().refdom, degree)
    return np.asarray(points, dtype=np.float64), np.asarray(weights, dtype=np.float64)


def _local_nodes(element: Element) -> FloatArray:
    """Local places (nodes, 3) of an element's nodes in the unit cube."""
    return np.asarray(element.doflocs, dtype=float)


def _reference_gradients(element: Element, points: FloatArray) -> FloatArray:
    """Gradients (nodes, 3, q) of the shape functions in the unit cube."""
    return np.array([element.lbasis(points, a)[1] for a in range(len(element.doflocs))])


def _trilinear(at: FloatArray, through: FloatArray) -> FloatArray:
    """Weights (p, 8) of the trilinear extrapolation from eight points `through` (3, 8) to points `at` (p, 3)."""

    def terms(x: FloatArray) -> FloatArray:
        return np.stack([x[0] ** i * x[1] ** j * x[2] ** k for i in (0, 1) for j in (0, 1) for k in (0, 1)], axis=1)

    return terms(at.T) @ np.linalg.inv(terms(through))


def _local_stiffness(gradients: FloatArray, volumes: FloatArray, lame: float, shear: float) -> FloatArray:
    """Element stiffnesses (m, 3 f, 3 f) from the gradients of f functions."""
    m, q, f, _ = gradients.shape
    flat = gradients.reshape(m, q, 3 * f)
    product = flat.swapaxes(1, 2) @ (volumes[:, :, None] * flat)  # int N_a,i N_b,j
    product = product.reshape(m, f, 3, f, 3)
    local = lame * product + shear * product.transpose(0, 1, 4, 3, 2)
    inner = shear * np.einsum("makbk->mab", product)
    for i in range(3):
        local[:, :, i, :, i] += inner
    return local.reshape(m, 3 * f, 3 * f)


def _condense(local: FloatArray, outer: int) -> tuple[FloatArray, FloatArray]:
    """Element stiffness without its inner unknowns, and minus these for unit outer ones."""
    if local.shape[1] == outer:
        return local, np.zeros((len(local), 0, outer))
    amplitudes: FloatArray = np.linalg.solve(local[:, outer:, outer:], local[:, outer:, :outer]).astype(np.float64)
    return local[:, :outer, :outer] - local[:, :outer, outer:] @ amplitudes, amplitudes


def _assemble(elements: IntArray, blocks: FloatArray, nodes: int) -> csr_matrix:
    """Sum 3 x 3 blocks of all node pairs of all elements into one matrix."""
    first = np.broadcast_to(elements[:, :, None], (*elements.shape, elements.shape[1]))
    keys = (first * nodes + elements[:, None, :]).ravel()
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    starts = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
    summed = np.add.reduceat(blocks[order], starts, axis=0)
    rows, columns = np.divmod(ordered[starts], nodes)
    pointers = np.searchsorted(rows, np.arange(nodes + 1))
    return bsr_matrix((summed, columns, pointers), shape=(3 * nodes, 3 * nodes)).tocsr()
