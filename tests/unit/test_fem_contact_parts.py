"""Parts of the finite-element contact: segments, mortar, condensation, active set, and what it refuses."""

from functools import cache

import numpy as np
import pytest
from scipy.optimize import nnls
from scipy.sparse import csr_matrix, diags_array
from skfem import MeshHex

from fem_reference.active_set import solve_complementarity
from fem_reference.condensation import SupportedBody
from fem_reference.contact import ContactMeshError, ContactPair, condense, solve_contact
from fem_reference.elasticity import ElasticBody
from fem_reference.mortar import couple
from fem_reference.segments import bilinear, clip, integration_points, local_coordinates, signed_area
from fem_reference.surface import Surface, outward_quads
from semiwear.errors import ConvergenceError, SceneError

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def sheet(counts, half=(1.0, 1.0), *, up=True, height=0.0, turn=0.0, jitter=0.0, seed=0, body=None, **names):
    """A grid of quadrilaterals, its inner nodes moved by up to `jitter` of a cell."""
    rng = np.random.default_rng(seed)
    x, y = (np.linspace(-h, h, n + 1) for h, n in zip(half, counts, strict=True))
    points = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((len(x), len(y)))], axis=-1)
    cell = 2.0 * np.array(half) / counts
    points[1:-1, 1:-1, :2] += jitter * cell * rng.uniform(-1.0, 1.0, (counts[0] - 1, counts[1] - 1, 2))
    number = np.arange(len(x) * len(y)).reshape(len(x), len(y))
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    points = points.reshape(-1, 3)
    c, s = np.cos(turn), np.sin(turn)
    points[:, :2] = points[:, :2] @ np.array([[c, s], [-s, c]])
    points[:, 2] = height(points[:, 0], points[:, 1]) if callable(height) else height
    return Surface(body, points, quads if up else quads[:, ::-1], **names)


# ---------------------------------------------------------------- segments


@pytest.mark.parametrize(
    ("window", "area"),
    [
        (SQUARE, 1.0),
        (SQUARE + np.array([0.25, 0.5]), 0.375),
        (0.5 * SQUARE + 0.25, 0.25),
        (3.0 * SQUARE - 1.0, 1.0),
        (SQUARE + np.array([1.0, 0.0]), 0.0),
        (SQUARE + np.array([2.0, 3.0]), 0.0),
        # a square on its corner cuts the four corners off: eight sides
        (0.5 + 0.6 * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]) * 1.25, 1.0 - 4 * 0.5 * 0.25**2),
    ],
)
def test_area_of_an_intersection(window, area):
    polygon, count = clip(SQUARE[None], window[None])
    assert signed_area(polygon)[0] == pytest.approx(area, abs=1e-14)
    assert integration_points(polygon, count)[2].sum() == pytest.approx(area, abs=1e-14)
    swapped, _ = clip(window[None], SQUARE[None])
    assert signed_area(swapped)[0] == pytest.approx(area, abs=1e-14)


def test_octagon_has_eight_corners():
    diamond = 0.5 + 0.75 * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    assert clip(SQUARE[None], diamond[None])[1][0] == 8


@pytest.mark.parametrize(("i", "j"), [(i, j) for i in range(8) for j in range(8) if i + j <= 7])
def test_integration_is_exact_to_degree_seven(i, j):
    polygon, count = clip(SQUARE[None], SQUARE[None])
    _, point, weight = integration_points(polygon, count)
    assert weight @ (point[:, 0] ** i * point[:, 1] ** j) == pytest.approx(1.0 / ((i + 1) * (j + 1)), rel=1e-13)


def test_local_coordinates_invert_the_bilinear_map():
    rng = np.random.default_rng(1)
    corner = 2.0 * SQUARE - 1.0 + rng.uniform(-0.3, 0.3, (50, 4, 2))
    xi = rng.uniform(-1.0, 1.0, (50, 2))
    point = np.einsum("qa,qak->qk", bilinear(xi), corner)
    np.testing.assert_allclose(local_coordinates(corner, point), xi, atol=1e-12)


# ---------------------------------------------------------------- mortar

OVERHANGS = {
    "same extent": {"counts": (7, 11), "half": (1.0, 1.0)},
    "master smaller and turned": {"counts": (7, 11), "half": (0.73, 0.61), "turn": 0.3},
    "master larger and coarse": {"counts": (2, 3), "half": (1.7, 1.4), "turn": -0.4},
    "master ends on nodes": {"counts": (5, 5), "half": (0.5, 0.5)},
}


@pytest.mark.parametrize("name", OVERHANGS)
def test_mortar_carries_linear_fields(name):
    """P reproduces linear fields, hence force and moment pass to the other side; slivers may blur moments."""
    slave = sheet((8, 8), jitter=0.2)
    master = sheet(**OVERHANGS[name], up=False, height=0.3, jitter=0.15, seed=2)
    mortar = couple(slave, master)
    np.testing.assert_allclose(mortar.transfer.sum(axis=1), 1.0, atol=1e-10)
    np.testing.assert_allclose(mortar.distance, 0.3, atol=1e-9)
    area = {"same extent": 4.0, "master larger and coarse": 4.0, "master ends on nodes": 1.0}
    assert mortar.weight.sum() == pytest.approx(area.get(name, 4.0 * 0.73 * 0.61), rel=1e-10)
    assert (mortar.weight > 0.0).all()
    miss = (mortar.transfer @ master.points - mortar.shares @ slave.points)[:, :2]
    blur = 1e-4 if name == "master smaller and turned" else 1e-9
    assert np.abs(mortar.weight[:, None] / mortar.weight.max() * miss).max() < blur

    force = mortar.weight * np.random.default_rng(3).uniform(size=len(mortar.nodes))
    on_slave, on_master = mortar.unit_loads()
    there, back = (on_master @ force).reshape(-1, 3), (on_slave @ force).reshape(-1, 3)
    np.testing.assert_allclose(there.sum(axis=0), [0.0, 0.0, force.sum()], atol=1e-10)
    moments = np.cross(master.points, there).sum(axis=0), -np.cross(slave.points, back).sum(axis=0)
    np.testing.assert_allclose(*moments, atol=blur * force.sum())


def test_dual_functions_are_dual():
    """Averages of the slave's own interpolant are its node values, on covered parts of elements as well."""
    slave = sheet((6, 5), jitter=0.2)
    mortar = couple(slave, sheet((9, 4), (0.8, 1.2), up=False, turn=0.2))
    a, b, c, d = 0.3, -1.1, 0.7, 0.4
    linear = lambda p: a + b * p[:, 0] + c * p[:, 1]  # noqa: E731
    np.testing.assert_allclose(mortar.average(linear), linear(mortar.shares @ slave.points), atol=1e-9)
    flat = sheet((6, 5))
    mortar = couple(flat, sheet((9, 4), (0.8, 1.2), up=False))
    twisted = lambda p: linear(p) + d * p[:, 0] * p[:, 1]  # noqa: E731
    np.testing.assert_allclose(mortar.average(twisted), mortar.shares @ twisted(flat.points), atol=1e-8)
    np.testing.assert_array_equal(mortar.average(np.arange(42.0)), np.arange(42.0)[mortar.nodes])
    np.testing.assert_array_equal(mortar.average(2.0), np.full(len(mortar.nodes), 2.0))


def border_master(end):
    """A master above the slave's x from -1 to `end`."""
    half = 0.5 * (end + 1.0)
    master = sheet((5, 3), (half, 1.0), up=False, height=0.0)
    return Surface(None, master.points + np.array([half - 1.0, 0.0, 0.0]), master.quads)


@pytest.mark.parametrize("covered", [1e-6, 1e-4, 1e-3, 1e-2])
def test_a_node_of_next_to_no_covered_area_is_carried_by_its_neighbour(covered):
    """Element edges at multiples of 1/4: the master ends just beyond one, over a sliver of the next elements."""
    slave = sheet((8, 4))
    mortar = couple(slave, border_master(0.25 + 0.25 * covered))
    x = slave.points[mortar.nodes, 0]
    assert x.max() == pytest.approx(0.25)
    # nothing is lost: area, constant and linear fields
    assert mortar.weight.sum() == pytest.approx(2.0 * (1.25 + 0.25 * covered), rel=1e-10)
    np.testing.assert_allclose(mortar.shares.sum(axis=1), 1.0, atol=1e-14)
    np.testing.assert_allclose(mortar.transfer.sum(axis=1), 1.0, atol=1e-10)
    whole = couple(slave, border_master(0.25)).weight
    np.testing.assert_allclose(mortar.weight, whole, rtol=2.1 * covered)
    # a gap that is known at the nodes is that of the node that stays, whatever lies beyond the border
    far = np.where(slave.points[:, 0] > 0.3, 1.0, 1e-3)
    np.testing.assert_array_equal(mortar.average(far), 1e-3)
    # and the border is still known
    assert (mortar.covered[x > 0.2] < 0.98).all()
    np.testing.assert_allclose(mortar.covered[x < 0.2], 1.0, atol=1e-12)


@cache
def punched_block(covered):
    """Contact of a block, held below, under a rigid flat punch that ends just beyond an edge of its elements."""
    ticks = [np.linspace(-1.0, 1.0, 9), np.linspace(-1.0, 1.0, 5), np.linspace(-1.0, 0.0, 4)]
    mesh = MeshHex.init_tensor(*ticks)
    body = ElasticBody(mesh, youngs_modulus=2e5, poissons_ratio=0.3)
    top = mesh.facets_satisfying(lambda p: p[2] > -1e-9, boundaries_only=True)
    slave = Surface("block", body.points, outward_quads(mesh, top))
    supported = SupportedBody(body.stiffness, body.dofs(np.flatnonzero(body.points[:, 2] < -0.99)))
    pair = ContactPair(slave, border_master(0.25 + 0.25 * covered), reach=1.0)
    return solve_contact({"block": supported}, [pair], 1000.0)


@pytest.mark.parametrize("covered", [1e-7, 1e-5, 1e-3, 1e-2, 0.1, 0.2, 0.5])
def test_pressure_at_a_border_does_not_grow_as_less_of_an_element_is_covered(covered):
    """Force over area at nodes just over the master's border went to infinity with the area (to 1e5 MPa on teeth)."""
    ends_there, beyond = punched_block(0.0), punched_block(covered)
    # an edge presses differently with its place in the mesh, but not without bound
    ratio = beyond.pairs[0].peak_pressure / ends_there.pairs[0].peak_pressure
    assert 0.7 < ratio < 1.1
    if covered < 0.02:
        assert beyond.rotation == pytest.approx(ends_there.rotation, rel=1e-3 + covered)


def test_covered_share_marks_the_border_of_the_master():
    slave = sheet((8, 8))
    mortar = couple(slave, sheet((5, 5), (0.6, 2.0), up=False))
    x = np.abs(slave.points[mortar.nodes, 0])
    np.testing.assert_allclose(mortar.covered[x < 0.3], 1.0, atol=1e-12)
    assert (mortar.covered[x > 0.4] < 0.95).all()


def test_gap_between_curved_meshes():
    """Discrete normals and distances of a sphere above a plane, within what a mesh of this size gives."""
    radius = 20.0
    slave = sheet((16, 16), height=lambda x, y: -(x**2 + y**2) / (2.0 * radius))
    mortar = couple(slave, sheet((11, 11), (1.5, 1.5), up=False, height=0.1))
    points = slave.points[mortar.nodes]
    exact = 0.1 + (points[:, 0] ** 2 + points[:, 1] ** 2) / (2.0 * radius)
    assert np.abs(mortar.distance - exact).max() < 0.02 * exact.max()
    assert (mortar.normals[:, 2] > 0.99).all()


def test_surfaces_that_do_not_face_each_other():
    for other in (sheet((4, 4), up=True), sheet((4, 4), up=False, height=50.0)):
        with pytest.raises(SceneError, match="opposite the slave surface"):
            couple(sheet((4, 4)), other)


# ---------------------------------------------------------------- surface


def test_borders_have_names():
    base = sheet((3, 2))
    x, y = base.points[:, 0], base.points[:, 1]
    surface = sheet((3, 2), edges={"tip": np.flatnonzero(y == 1.0)}, symmetry=np.flatnonzero(x == -1.0))
    assert set(surface.border) == {"tip", "candidates"}
    np.testing.assert_array_equal(surface.border["tip"], np.flatnonzero(y == 1.0))
    np.testing.assert_array_equal(surface.border["candidates"], np.flatnonzero((x == 1.0) | (y == -1.0)))


# ---------------------------------------------------------------- condensation


def test_compliance_and_displacement_of_springs():
    """A chain of springs held at one end: node i moves by the sum of 1/k up to it."""
    stiffness = csr_matrix(diags_array([[2.0, 2.0, 2.0, 1.0], [-1.0] * 3, [-1.0] * 3], offsets=[0, 1, -1]))
    body = SupportedBody(stiffness, np.array([0]))
    np.testing.assert_allclose(body.compliance(csr_matrix(np.eye(4)))[1:, 1:], [[1, 1, 1], [1, 2, 2], [1, 2, 3]])
    np.testing.assert_allclose(body.displacement(np.array([0.0, 0.0, 1.0, 0.0])), [0, 1, 2, 2])
    np.testing.assert_allclose(body.displacement(np.zeros(4), np.array([0.5, 9.0, 9.0, 9.0])), 0.5)
    with pytest.raises(SceneError, match="bore or back face"):
        SupportedBody(stiffness, np.array([], dtype=int))


# ---------------------------------------------------------------- active set


def problem(seed, size=40):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(size, size))
    compliance = root @ root.T / size + 0.1 * np.eye(size)
    return compliance, rng.uniform(0.0, 1.0, size), rng.uniform(0.5, 1.5, size)


@pytest.mark.parametrize("seed", range(10))
def test_active_set_solves_the_complementarity_problem(seed):
    compliance, gap, lever = problem(seed)
    found = solve_complementarity(compliance, gap, lever, 2.0)
    assert found.equilibrium_residual < 1e-12
    assert (found.force >= 0.0).all()
    assert found.gap.min() > -1e-12
    assert np.abs(found.force * found.gap).max() < 1e-12
    assert 1 < found.active.sum() < len(gap)
    # at this rotation the forces minimise the energy: non-negative least squares
    root = np.linalg.cholesky(compliance)
    force, _ = nnls(root.T, np.linalg.solve(root, lever * found.rotation - gap))
    np.testing.assert_allclose(found.force, force, atol=1e-9)


def test_active_set_takes_a_start_and_negative_gaps():
    compliance, gap, lever = problem(3)
    cold = solve_complementarity(compliance, gap, lever, 2.0)
    warm = solve_complementarity(compliance, gap, lever, 2.0, start=cold.active)
    assert warm.iterations == 1
    np.testing.assert_allclose(warm.force, cold.force, rtol=1e-12)
    shifted = solve_complementarity(compliance, gap - 5.0 * lever, lever, 2.0)
    assert shifted.rotation == pytest.approx(cold.rotation - 5.0, rel=1e-12)
    np.testing.assert_allclose(shifted.force, cold.force, atol=1e-11)


@pytest.mark.parametrize("unit", [1e-9, 1e6])
def test_active_set_does_not_care_for_units(unit):
    compliance, gap, lever = problem(4)
    one = solve_complementarity(compliance, gap, lever, 2.0)
    start = np.arange(len(gap)) == np.argmin(gap)
    other = solve_complementarity(unit * compliance, unit * gap, lever, 2.0, start=start)
    np.testing.assert_allclose(other.force, one.force, atol=1e-10)
    assert other.rotation == pytest.approx(unit * one.rotation, rel=1e-10)


def changed(which, change):
    """The problem of seed 0 with another compliance (0), gap (1) or lever (2)."""
    parts = list(problem(0))
    parts[which] = change(parts[which])
    return parts


def holed(values):
    values.flat[3] = np.nan
    return values


@pytest.mark.parametrize(
    ("parts", "torque", "options", "error", "words"),
    [
        *((problem(0), torque, {}, SceneError, r"torque.*> 0") for torque in (0.0, -1.0, np.nan, np.inf)),
        *((changed(which, holed), 1.0, {}, SceneError, r"1 of .* not finite") for which in (0, 1, 2)),
        (changed(2, np.negative), 1.0, {}, SceneError, "no rotation closes the gap"),
        (changed(0, np.negative), 1.0, {}, ConvergenceError, "not positive definite"),
        (problem(1), 2.0, {"max_iterations": 1}, ConvergenceError, "raise max_iterations"),
    ],
)
def test_active_set_says_what_it_cannot_solve(parts, torque, options, error, words):
    with pytest.raises(error, match=words):
        solve_complementarity(*parts, torque, **options)


# ---------------------------------------------------------------- flags, on a bed of springs


def bed(gap, *, counts=(12, 10), torque=1.0, master=None, **names):
    """A slave sheet on springs below a rigid master."""
    slave = sheet(counts, body="bed", **names)
    size = 3 * len(slave.points)
    body = SupportedBody(csr_matrix(diags_array(np.full(size, 10.0))), np.array([0]))
    master = master or sheet((3, 3), (2.0, 2.0), up=False)
    return solve_contact({"bed": body}, [ContactPair(slave, master, gap=gap)], torque)


def bump(x=0.0, y=0.0, curvature=1.0):
    return lambda p: 0.5 * curvature * ((p[:, 0] - x) ** 2 + (p[:, 1] - y) ** 2)


def test_a_sound_contact_has_no_problems():
    solution = bed(bump(), torque=20.0)
    assert solution.problems == ()
    assert solution.require_resolved() is solution
    (pair,) = solution.pairs
    assert pair.load == pytest.approx(20.0, rel=1e-12)
    assert pair.nodes_across >= 3
    assert pair.edges == ()
    assert solution.smallest_gap > -1e-12


def test_contact_at_the_end_of_the_candidates():
    solution = bed(bump(x=1.0), torque=20.0)
    assert solution.pairs[0].borders == ("bed: candidates",)
    with pytest.raises(ContactMeshError, match="'bed: candidates'; widen the refined area"):
        solution.require_resolved()


def test_contact_at_a_real_edge_is_only_told():
    tip = np.flatnonzero(sheet((12, 10)).points[:, 0] == 1.0)
    solution = bed(bump(x=1.0), torque=20.0, edges={"tip": tip})
    (pair,) = solution.pairs
    assert pair.edges == ("bed: tip",)
    assert solution.problems == ()
    np.testing.assert_array_equal(pair.nodes[pair.on_edge], tip)
    assert 0.0 < pair.pressure[~pair.on_edge].max() < pair.peak_pressure


def test_contact_that_hangs_over_the_master():
    short = {"counts": (3, 3), "half": (0.55, 2.0), "up": False}
    solution = bed(bump(x=0.5), torque=20.0, master=sheet(**short))
    assert solution.pairs[0].borders == ("rigid: candidates",)
    end = np.flatnonzero(np.abs(sheet(**short).points[:, 0]) == 0.55)
    solution = bed(bump(x=0.5), torque=20.0, master=sheet(**short, edges={"end face": end}))
    assert solution.pairs[0].edges == ("rigid: end face",)
    assert solution.problems == ()


@pytest.mark.parametrize(("torque", "across"), [(0.1, 1), (4.0, 3), (20.0, 5)])
def test_nodes_across(torque, across):
    solution = bed(bump(), torque=torque)
    assert solution.pairs[0].nodes_across == across
    assert (len(solution.problems) == 1) == (across < 3)


def test_a_patch_that_is_too_narrow():
    with pytest.raises(ContactMeshError, match=r"1 node\(s\) across the contact, needs 3"):
        bed(lambda p: 100.0 * p[:, 0] ** 2 + 0.01 * p[:, 1] ** 2, torque=1.0).require_resolved()


def test_a_contact_that_covers_all_is_resolved():
    solution = bed(0.0, torque=1e3)
    assert solution.pairs[0].nodes_across == 13 * 11
    assert solution.pairs[0].resolved


def test_gap_that_is_nan():
    def holed(p):
        return np.where(p[:, 0] > 0.9, np.nan, bump()(p))

    with pytest.raises(SceneError, match=r"gap: found '\d+ of 143 not finite'"):
        bed(holed)


def test_a_slave_node_in_two_pairs():
    slave = sheet((4, 4), body="bed")
    body = SupportedBody(csr_matrix(diags_array(np.ones(75))), np.array([0]))
    with pytest.raises(SceneError, match="node 0 of bed in two pairs"):
        condense({"bed": body}, 2 * [ContactPair(slave, sheet((2, 2), up=False))])


def test_unknown_body():
    slave = sheet((2, 2), body="moon")
    with pytest.raises(SceneError, match="moon"):
        condense({}, [ContactPair(slave, sheet((2, 2), up=False))])
