"""Compliance by substructures: the same as from a factor of the whole body, and the order of elimination."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix, eye_array, random_array
from skfem import MeshHex

import fem_reference.dissection
from fem_reference.condensation import SupportedBody
from fem_reference.dissection import Dissection
from fem_reference.elasticity import ElasticBody
from fem_reference.substructures import compliance_by_parts
from semiwear.errors import ConvergenceError


def bent_body(counts=(9, 6, 5)):
    """A block of distorted elements."""
    mesh = MeshHex.init_tensor(*(np.linspace(0.0, n, n + 1) ** 1.2 for n in counts))
    points = mesh.p.copy()
    points[0] += 0.1 * points[1] * points[2]
    return ElasticBody(MeshHex(points, mesh.t), youngs_modulus=2e5, poissons_ratio=0.3)


def loads_on(body, count, seed=0):
    """Some loads, each on a few unknowns."""
    return csr_matrix(random_array((body.points.size, count), density=0.01, rng=np.random.default_rng(seed)))


@pytest.mark.parametrize("least", [1, 10, 80, 10_000])
def test_compliance_is_that_of_the_whole_body(monkeypatch, least):
    """However small the parts; with whole nodes held and with single unknowns."""
    monkeypatch.setattr(fem_reference.dissection, "LEAST", least)
    body = bent_body()
    held = [body.dofs(np.flatnonzero(body.points[:, 2] < 1e-9)).ravel(), 3 * np.flatnonzero(body.points[:, 0] < 1e-9)]
    held = np.unique(np.concatenate(held))
    loads = loads_on(body, 30)
    whole = SupportedBody(body.stiffness, held).compliance(loads)
    parts = SupportedBody(body.stiffness, held, body.points).compliance(loads)
    np.testing.assert_allclose(parts, whole, atol=1e-12 * np.abs(whole).max())


def test_zeros_in_the_stiffness_do_not_hide_neighbours(monkeypatch):
    """Two nodes that touch by some of their nine terms only."""
    monkeypatch.setattr(fem_reference.dissection, "LEAST", 8)
    mesh = MeshHex.init_tensor(*(np.linspace(0.0, 1.0, n) for n in (6, 5, 4)))
    body = ElasticBody(mesh, youngs_modulus=2e5, poissons_ratio=0.3)
    stiffness = body.stiffness.copy()
    stiffness.data[np.abs(stiffness.data) < 1e-2 * np.abs(stiffness.data).max()] = 0.0
    stiffness += 10.0 * np.abs(stiffness).max() * csr_matrix(eye_array(stiffness.shape[0]))
    stiffness.eliminate_zeros()
    loads, free = loads_on(body, 20), np.arange(stiffness.shape[0])
    exact = loads.T @ np.linalg.solve(stiffness.toarray(), loads.toarray())
    found = compliance_by_parts(stiffness, free, body.points, loads)
    np.testing.assert_allclose(found, exact, atol=1e-12 * np.abs(exact).max())


def test_loads_on_held_unknowns_move_nothing():
    body = bent_body((4, 3, 3))
    held = body.dofs(np.flatnonzero(body.points[:, 2] < 1e-9)).ravel()
    loads = np.zeros((body.points.size, 3))
    loads[held[:2], [0, 1]] = 1.0
    loads[-1, 2] = 1.0
    found = SupportedBody(body.stiffness, held, body.points).compliance(csr_matrix(loads))
    assert found[2, 2] > 0.0
    found[2, 2] = 0.0
    np.testing.assert_array_equal(found, 0.0)


def test_a_body_that_is_not_held_is_refused():
    body = bent_body((3, 3, 3))
    with pytest.raises(ConvergenceError, match="hold its bore"):
        compliance_by_parts(body.stiffness, np.arange(body.points.size), body.points, loads_on(body, 2))


def test_parts_touch_only_what_stands_above_them():
    body = bent_body((12, 8, 6))
    graph = csr_matrix(body.stiffness)[::3][:, ::3]
    parts = Dissection.of(graph, body.points)
    count = len(body.points)
    np.testing.assert_array_equal(np.sort(parts.order), np.arange(count))
    part_of = np.empty(count, dtype=int)
    part_of[parts.order] = np.repeat(np.arange(len(parts.below)), np.diff(parts.ends))
    above = {child: k for k, below in enumerate(parts.below) for child in below}
    assert set(above) == set(range(len(parts.below) - 1))

    def line(part):
        """The part and all that stand above it."""
        return {part} if part not in above else {part} | line(above[part])

    lines = [line(part) for part in range(len(parts.below))]
    rows, columns = graph.nonzero()
    for a, b in set(zip(part_of[rows].tolist(), part_of[columns].tolist(), strict=True)):
        assert b in lines[a] or a in lines[b]


def test_cuts_fall_where_a_body_is_thin():
    """Two cubes joined by a neck part at the neck, not in the middle of the larger one."""
    ticks = [np.arange(13.0), np.arange(7.0), np.arange(7.0)]
    mesh = MeshHex.init_tensor(*ticks)
    x, y, z = mesh.p[:, mesh.t].mean(axis=1)
    neck = (x > 8.0) & (x < 9.0)
    mesh = mesh.restrict(np.flatnonzero(~neck | ((np.abs(y - 3.0) < 1.0) & (np.abs(z - 3.0) < 1.0))))
    body = ElasticBody(mesh, youngs_modulus=1.0, poissons_ratio=0.3)
    parts = Dissection.of(csr_matrix(body.stiffness)[::3][:, ::3], body.points)
    assert len(parts.order[parts.ends[-2] :]) == 9
