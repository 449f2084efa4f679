"""Three-dimensional elasticity: patch test, rigid-body modes, order of convergence, solvers."""

import warnings

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from skfem import MeshHex, MeshHex2

from fem_reference import solvers
from fem_reference.elasticity import ELEMENTS, ElasticBody
from fem_reference.solvers import SOLVERS, SlowSolverWarning, factorise
from semiwear.errors import MissingExtraError

STEEL = {"youngs_modulus": 207000.0, "poissons_ratio": 0.3}


def unit_cube(cells, distortion=0.0, curved=False):
    """Cube of cells^3 hexahedra whose inner vertices are moved at random by a part of an element."""
    mesh = MeshHex.init_tensor(*[np.linspace(0.0, 1.0, cells + 1)] * 3)
    inside = ((mesh.p > 1e-9) & (mesh.p < 1.0 - 1e-9)).all(axis=0)
    moves = np.random.default_rng(1).uniform(-1.0, 1.0, mesh.p.shape) * distortion / cells
    mesh = MeshHex(mesh.p + np.where(inside, moves, 0.0), mesh.t)
    return MeshHex2.from_mesh(mesh) if curved else mesh


def boundary(body):
    return np.flatnonzero(((body.points < 1e-9) | (body.points > 1.0 - 1e-9)).any(axis=1))


def solve_with(body, displacement, load, solver="superlu"):
    """Displacement with given values on the boundary of the cube."""
    fixed = boundary(body)
    free = body.free_dofs(fixed)
    moved = np.zeros(body.points.size)
    moved[body.dofs(fixed)] = displacement[fixed]
    k = body.stiffness
    moved[free] = factorise(k[free][:, free], places=body.points[free // 3], prefer=solver).solve(
        (load - k @ moved)[free]
    )
    return moved


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("curved", [False, True])
def test_patch(element, curved):
    """A linear displacement on the boundary of distorted elements gives constant strain inside."""
    body = ElasticBody(unit_cube(3, 0.25, curved), element=element, **STEEL)
    gradient = 1e-3 * np.array([[1.0, 0.4, -0.2], [0.3, -0.7, 0.5], [-0.6, 0.1, 0.9]])
    exact = body.points @ gradient.T
    moved = solve_with(body, exact, np.zeros(body.points.size))
    np.testing.assert_allclose(moved.reshape(-1, 3), exact, atol=1e-10 * np.abs(exact).max())

    lame, shear = body.lame
    stress = lame * np.trace(gradient) * np.eye(3) + shear * (gradient + gradient.T)
    expected = stress[[0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]]
    for found in (body.stress(moved), body.stress(moved, "gauss").reshape(-1, 6)):
        np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), atol=1e-10 * np.abs(stress).max())


@pytest.mark.parametrize("element", ELEMENTS)
def test_six_rigid_body_modes_and_no_more(element):
    body = ElasticBody(unit_cube(2, 0.2), element=element, **STEEL)
    k = body.stiffness.toarray()
    np.testing.assert_allclose(k, k.T, atol=1e-11 * np.abs(k).max())
    values = np.linalg.eigvalsh(k)
    assert np.abs(values[:6]).max() < 1e-11 * values[-1]
    assert values[6] > 1e-5 * values[-1]


def manufactured(points, lame, shear):
    """Displacement u = (sin x sin 2y, cos(y + z), sin x cos z) and the body force that it needs."""
    x, y, z = points.T
    u = np.stack([np.sin(x) * np.sin(2 * y), np.cos(y + z), np.sin(x) * np.cos(z)], axis=1)
    laplace = np.stack([-5 * u[:, 0], -2 * u[:, 1], -2 * u[:, 2]], axis=1)
    # divergence: cos x sin 2y - sin(y + z) - sin x sin z
    grad_div = np.stack(
        [
            -np.sin(x) * np.sin(2 * y) - np.cos(x) * np.sin(z),
            2 * np.cos(x) * np.cos(2 * y) - np.cos(y + z),
            -np.cos(y + z) - np.sin(x) * np.cos(z),
        ],
        axis=1,
    )
    return u, -(lame + shear) * grad_div - shear * laplace


def manufactured_error(element, cells):
    """L2 norm of the error of the displacement, by an accurate quadrature."""
    body = ElasticBody(unit_cube(cells), element=element, **STEEL)
    from skfem.quadrature import get_quadrature

    points, weights = get_quadrature(ELEMENTS[element].element.refdom, 7)
    values = np.array([ELEMENTS[element].element.lbasis(points, a)[0] for a in range(body.elements.shape[1])])
    places = np.einsum("aq,mai->mqi", values, body.points[body.elements])
    exact, force = manufactured(places.reshape(-1, 3), *body.lame)
    volume = weights / cells**3
    load = np.zeros((len(body.points), 3))
    np.add.at(load, body.elements, np.einsum("q,aq,mqi->mai", volume, values, force.reshape(places.shape)))
    moved = solve_with(body, manufactured(body.points, *body.lame)[0], load.ravel()).reshape(-1, 3)
    found = np.einsum("aq,mai->mqi", values, moved[body.elements])
    return np.sqrt(np.einsum("q,mqi->", volume, (found - exact.reshape(places.shape)) ** 2))


@pytest.mark.parametrize(
    ("element", "order", "cells"), [("hex8i", 2, (4, 8)), ("hex20", 3, (3, 6)), ("hex27", 3, (3, 6))]
)
def test_order_of_convergence(element, order, cells):
    coarse, fine = (manufactured_error(element, n) for n in cells)
    found = np.log2(coarse / fine)
    print(f"\n{element}: order {found:.2f}, error {fine:.2e}")
    assert order - 0.15 < found < order + 1.2


def test_slender_beam_in_bending_with_one_layer_of_elements():
    """What the incompatible modes are for: a tip load bends a beam ten times as long as high as it should."""
    mesh = MeshHex.init_tensor(np.linspace(0, 10, 11), np.linspace(0, 1, 2), np.linspace(0, 1, 2))
    body = ElasticBody(mesh, element="hex8i", youngs_modulus=1000.0, poissons_ratio=0.0)
    free = body.free_dofs(np.flatnonzero(body.points[:, 0] < 1e-9))
    tip = np.flatnonzero(body.points[:, 0] > 10 - 1e-9)
    load = np.zeros(body.points.size)
    load[body.dofs(tip)[:, 1]] = 0.25
    moved = np.zeros_like(load)
    moved[free] = factorise(body.stiffness[free][:, free], prefer="superlu").solve(load[free])
    euler, timoshenko = 4 * 10**3 / 1000, 10 / (5 / 6 * 500)
    assert moved[body.dofs(tip)[:, 1]].mean() == pytest.approx(euler + timoshenko, rel=0.01)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("columns", [(), (3,)])
def test_solvers(solver, columns):
    body = ElasticBody(unit_cube(4), element="hex8i", **STEEL)
    free = body.free_dofs(np.flatnonzero(body.points[:, 2] == 0.0))
    k = csr_matrix(body.stiffness[free][:, free])
    try:
        factor = factorise(k, places=body.points[free // 3], prefer=solver)
    except MissingExtraError as reason:
        pytest.skip(str(reason))
    exact = np.random.default_rng(2).normal(size=(len(free), *columns))
    assert factor.name == solver
    np.testing.assert_allclose(factor.solve(k @ exact), exact, atol=1e-9)
    assert factor.solve(k @ exact).shape == exact.shape


def test_without_pardiso_the_solver_needs_scipy_alone_and_a_slow_one_says_so(monkeypatch):
    def absent(matrix):
        raise ImportError

    monkeypatch.setattr(solvers, "_Pardiso", absent)
    monkeypatch.setattr(solvers, "_SUPERLU_SLOW", 100)
    body = ElasticBody(unit_cube(4), element="hex20", **STEEL)
    free = body.free_dofs(np.flatnonzero(body.points[:, 2] == 0.0))
    k = csr_matrix(body.stiffness[free][:, free])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        factor = factorise(k, places=body.points[free // 3])
    assert factor.name == "dissection"
    with pytest.warns(SlowSolverWarning, match=r"pip install .*semiwear\[fem\]"):
        slow = factorise(k)
    load = np.random.default_rng(3).normal(size=(len(free), 2))
    np.testing.assert_allclose(factor.solve(load), slow.solve(load), atol=1e-12)
    with pytest.raises(MissingExtraError, match="pypardiso"):
        factorise(k, prefer="pardiso")


@pytest.mark.parametrize("element", ELEMENTS)
def test_stress_at_chosen_nodes_is_theirs_in_any_order_and_number(element):
    body = ElasticBody(unit_cube(2, 0.2), element=element, **STEEL)
    moved = np.random.default_rng(4).normal(size=body.points.size)
    chosen = np.array([7, 3, 3, 0, 7])
    np.testing.assert_allclose(body.stress(moved, nodes=chosen), body.stress(moved)[chosen], rtol=1e-12)


def test_bad_input_is_named():
    mesh = unit_cube(1)
    with pytest.raises(ValueError, match="hex9"):
        ElasticBody(mesh, element="hex9", **STEEL)
    with pytest.raises(ValueError, match="material"):
        ElasticBody(mesh, youngs_modulus=1.0, poissons_ratio=0.5)
    folded = mesh.p.copy()
    folded[:, np.flatnonzero(mesh.p.sum(axis=0) == 3.0)] = -0.2
    with pytest.raises(ValueError, match="folded"):
        _ = ElasticBody(MeshHex(folded, mesh.t), **STEEL).stiffness
    with pytest.raises(ValueError, match="prefer"):
        factorise(csr_matrix(np.eye(2)), prefer="magic")
