"""Finite-element contact against Hertz, against the monolithic solution, and against itself mirrored and doubled."""

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from scipy.sparse import bmat, csr_matrix
from scipy.sparse.linalg import spsolve
from skfem import MeshHex

from fem_reference.condensation import SupportedBody
from fem_reference.contact import ContactPair, condense, solve_contact
from fem_reference.elasticity import ElasticBody
from fem_reference.surface import Surface, outward_quads
from semiwear.closed_forms.hertz import effective_modulus, elliptic_contact

E, NU = 210e3, 0.3
MODULUS = effective_modulus(E, NU, E, NU)


def graded(step, fine, end, growth=1.45):
    """Even steps up to `fine`, then growing ones that end at `end`."""
    count = int(np.ceil(fine / step - 1e-9))
    rest = np.cumsum(growth ** np.arange(1, 2 + int(np.log((end - fine) / step * (growth - 1) + 1) / np.log(growth))))
    even = step * np.arange(count + 1)
    return np.concatenate([even, even[-1] + rest * (end - even[-1]) / rest[-1]])


def both_ways(x):
    return np.concatenate([-x[:0:-1], x])


def block(x, y, z, *, jitter=0.0, seed=0):
    """An elastic block; its nodes with z = 0 stay in that plane and on its outline when the others are shaken."""
    mesh = MeshHex.init_tensor(x, y, z)
    points = mesh.p.copy()
    shake = jitter * np.random.default_rng(seed).uniform(-1.0, 1.0, points.shape)
    for axis, ticks in enumerate((x, y, z)):
        inside = (points[axis] > ticks[0]) & (points[axis] < ticks[-1])
        points[axis] += np.where(inside, shake[axis] * np.diff(ticks).min(), 0.0)
    return ElasticBody(MeshHex(points, mesh.t), youngs_modulus=E, poissons_ratio=NU)


def top_or_bottom(name, body, where=lambda p: p[0] > -np.inf, **names):
    """Facets of a block in the plane z = 0."""
    mesh = body.mesh
    facets = mesh.facets_satisfying(lambda p: (np.abs(p[2]) < 1e-9) & where(p), boundaries_only=True)
    return Surface(name, body.points, outward_quads(mesh, facets), **names)


def held(*parts):
    return np.unique(np.concatenate([np.ravel(part) for part in parts]))


# ---------------------------------------------------------------- Hertz

LOAD, CURVATURES = 2000.0, (3e-2, 3e-3)  # half-axes 0.49 and 2.21 mm
HERTZ = elliptic_contact(LOAD, *CURVATURES, MODULUS)
REACH = 3.0 * HERTZ.major_half_axis


def half_space_displacement(points):
    """Displacement below the Hertz pressure on z < 0 (Boussinesq; Johnson 1985, eq. 3.19), by 12 x 24 point loads."""
    radius, weight = leggauss(12)
    radius, weight = 0.5 * (radius + 1.0), 0.5 * weight
    angle = 2.0 * np.pi * (np.arange(24) + 0.5) / 24
    share = (weight * radius * np.sqrt(1.0 - radius**2))[:, None] * np.ones(24)
    share *= LOAD / share.sum()
    total = np.zeros_like(points)
    for r, row in zip(radius, share, strict=True):
        for t, force in zip(angle, row, strict=True):
            place = [HERTZ.minor_half_axis * r * np.cos(t), HERTZ.major_half_axis * r * np.sin(t), 0.0]
            d = (points - place) * [1.0, 1.0, -1.0]
            rho = np.linalg.norm(d, axis=1)
            inward = d[:, 2] / rho**3 - (1.0 - 2.0 * NU) / (rho * (rho + d[:, 2]))
            total += force * np.stack(
                [inward * d[:, 0], inward * d[:, 1], -(d[:, 2] ** 2 / rho**3 + 2.0 * (1.0 - NU) / rho)], axis=1
            )
    return total * (1.0 + NU) / (2.0 * np.pi * E)


def hertz_block(name, cells, centre, quarter):
    """A block with `cells` elements to a half-axis; its far sides move like the half-space (slave below, z < 0)."""
    b, a = HERTZ.minor_half_axis, HERTZ.major_half_axis
    ticks = [graded(axis / n, 1.25 * axis, REACH) for axis, n in zip((b, a), cells, strict=True)]
    if not quarter:
        ticks = [both_ways(t) + 0.0 for t in ticks]
        # the contact is not where the nodes are
        ticks = [t + shift * (1.0 - (t / REACH) ** 2) for t, shift in zip(ticks, centre, strict=True)]
    depth = graded(b / cells[0], b, REACH)
    sign = -1.0 if name == "slave" else 1.0
    body = block(*ticks, np.sort(sign * depth))
    points = body.points
    far = np.flatnonzero((np.abs(points) > REACH - 1e-9).any(axis=1))
    fixed = [body.dofs(far)]
    mirror = np.empty(0, dtype=np.int64)
    if quarter:
        fixed += [3 * np.flatnonzero(points[:, k] < 1e-9) + k for k in (0, 1)]
        mirror = np.flatnonzero((points[:, :2] < 1e-9).any(axis=1))
    supported = SupportedBody(body.stiffness, held(*fixed))
    given = np.zeros_like(points)
    turn = np.array([1.0, 1.0, -sign])
    given[far] = half_space_displacement(points[far] * turn) * turn
    moved = supported.displacement(np.zeros(points.size), given.ravel())
    extent = 1.3 if name == "slave" else 2.0
    surface = top_or_bottom(
        name, body, lambda p: (np.abs(p[0]) < extent * b) & (np.abs(p[1]) < extent * a), symmetry=mirror
    )
    return supported, surface, moved


def hertz(cells, master_cells, *, centre=(0.0, 0.0), quarter=True):
    """Contact of two blocks with different meshes and a Hertz gap, as if they were half-spaces.

    The far sides are held where the half-space under the same Hertz pressure would have them: the displacement
    that this alone gives the flanks is added to the gap. So the blocks are not felt to be finite, and the approach is
    that of Hertz.
    """
    bodies, surfaces, moved = {}, {}, {}
    for name, n, place in (("slave", cells, centre), ("master", master_cells, (0.0, 0.0))):
        bodies[name], surfaces[name], moved[name] = hertz_block(name, n, place, quarter)

    def gap(p):
        return 0.5 * CURVATURES[0] * p[:, 0] ** 2 + 0.5 * CURVATURES[1] * p[:, 1] ** 2

    contact = condense(bodies, [ContactPair(surfaces["slave"], surfaces["master"], gap=gap)])
    (mortar,) = contact.mortars
    slave_load, master_load = mortar.unit_loads()
    worn = np.zeros(len(surfaces["slave"].points))
    worn[mortar.nodes] = mortar.average(gap) + slave_load.T @ moved["slave"] + master_load.T @ moved["master"]
    return contact.solve(LOAD / 4 if quarter else LOAD, gaps=[worn]), surfaces["slave"].points[mortar.nodes]


# elements to a half-axis across and along; along the long axis one more is worth it
@pytest.mark.slow
@pytest.mark.parametrize(("cells", "pressure", "approach"), [((3, 4), 0.02, 0.01), ((4, 5), 0.01, 0.01)])
def test_hertz_ellipse(cells, pressure, approach):
    solution, place = hertz(cells, tuple(1.3 * n for n in cells))
    (pair,) = solution.require_resolved().pairs
    assert pair.peak_pressure == pytest.approx(HERTZ.peak_pressure, rel=pressure)
    assert pair.pressure[np.linalg.norm(place, axis=1).argmin()] == pair.peak_pressure
    assert solution.rotation == pytest.approx(HERTZ.approach, rel=approach)
    assert pair.load == pytest.approx(LOAD / 4, rel=1e-12)
    # the contact ends where Hertz says, within an element
    ends = place[pair.active, :2].max(axis=0)
    half_axes = np.array([HERTZ.minor_half_axis, HERTZ.major_half_axis])
    assert (np.abs(ends - half_axes) <= 1.01 * half_axes / cells).all()


@pytest.mark.slow
def test_hertz_ellipse_gets_better_with_the_mesh():
    errors = [abs(hertz((n, n + 1), (1.3 * n, 1.3 * (n + 1)))[0].pairs[0].peak_pressure / HERTZ.peak_pressure - 1.0)
              for n in (2, 4)]  # fmt: skip
    assert errors[1] < 0.5 * errors[0] < 0.05


@pytest.mark.slow
def test_hertz_ellipse_between_the_nodes():
    """The whole contact, its centre in the middle of a facet: nodes miss the peak by the Hertz ellipse itself."""
    half_step = 0.5 * np.array([HERTZ.minor_half_axis, HERTZ.major_half_axis]) / (3, 4)
    solution, place = hertz((3, 4), (2.6, 3.3), centre=half_step, quarter=False)
    (pair,) = solution.require_resolved().pairs
    below = 1.0 - (place[:, 0] / HERTZ.minor_half_axis) ** 2 - (place[:, 1] / HERTZ.major_half_axis) ** 2
    exact = HERTZ.peak_pressure * np.sqrt(np.maximum(below, 0.0))
    assert exact.max() < 0.985 * HERTZ.peak_pressure
    assert pair.peak_pressure == pytest.approx(exact.max(), rel=0.025)
    assert solution.rotation == pytest.approx(HERTZ.approach, rel=0.01)


def two_blocks(rotation=None, mirror=False):
    """A slave below, a master above, meshes shaken, far sides clamped; mirrored in x or turned in space."""
    bodies, surfaces = {}, {}
    for name, x, z, seed in (
        ("slave", np.linspace(-1.0, 1.0, 9), np.linspace(-1.0, 0.0, 4), 1),
        ("master", np.linspace(-1.2, 1.2, 8), np.linspace(0.0, 1.0, 5), 2),
    ):
        body = block(x, 0.8 * x, z, jitter=0.15, seed=seed)
        mesh = body.mesh
        facets = mesh.facets_satisfying(lambda p: np.abs(p[2]) < 1e-9, boundaries_only=True)
        back = np.flatnonzero(np.abs(body.points[:, 2]) == 1.0)
        points = mesh.p.copy()
        if mirror:
            points[0] *= -1.0
        if rotation is not None:
            points = rotation @ points
        body = ElasticBody(MeshHex(points, mesh.t), youngs_modulus=E, poissons_ratio=NU)
        bodies[name] = SupportedBody(body.stiffness, held(body.dofs(back)))
        surfaces[name] = Surface(name, body.points, outward_quads(body.mesh, facets))
    return bodies, surfaces


def lopsided(p):
    return 0.02 * ((p[:, 0] - 0.17) ** 2 + 0.5 * (p[:, 1] + 0.1) ** 2)


def test_condensed_equals_monolithic():
    """All displacements, forces and the rotation from one sparse saddle point, its own active set from nothing."""
    bodies, surfaces = two_blocks()
    pair = ContactPair(surfaces["slave"], surfaces["master"], gap=lopsided, lever=lambda p: 3.0 + 0.2 * p[:, 0])
    contact = condense(bodies, [pair])
    torque = 5000.0
    solution = contact.solve(torque, displacements=True)
    (mortar,), (found,) = contact.mortars, solution.pairs
    gap, lever = mortar.average(pair.gap), mortar.average(pair.lever)

    stiffness, loads = [], []
    for name, body in bodies.items():
        stiffness.append(body.stiffness[body.free][:, body.free])
        loads.append(contact.unit_loads[name][body.free])
    active = gap <= gap.min()
    for _ in range(30):
        b = [load[:, active] for load in loads]
        arm = csr_matrix(lever[active])
        matrix = bmat(
            [
                [stiffness[0], None, -b[0], None],
                [None, stiffness[1], -b[1], None],
                [-b[0].T, -b[1].T, None, arm.T],
                [None, None, arm, None],
            ]
        )
        sizes = [k.shape[0] for k in stiffness]
        rhs = np.concatenate([np.zeros(sum(sizes)), gap[active], [torque]])
        answer = spsolve(matrix.tocsc(), rhs)
        moved = np.split(answer[: sum(sizes)], sizes[:1])
        force = np.zeros(len(gap))
        force[active] = answer[sum(sizes) : -1]
        opening = gap + sum(load.T @ u for load, u in zip(loads, moved, strict=True)) - lever * answer[-1]
        following = (active & (force > 0.0)) | (~active & (opening < -1e-14))
        if (following == active).all():
            break
        active = following
    assert 5 < active.sum() < len(gap)
    np.testing.assert_array_equal(found.active, active)
    np.testing.assert_allclose(found.force, force, atol=1e-10 * force.max())
    assert solution.rotation == pytest.approx(answer[-1], rel=1e-10)
    for u, (name, body) in zip(moved, bodies.items(), strict=True):
        found_u = solution.displacement[name].ravel()[body.free]
        np.testing.assert_allclose(found_u, u, atol=1e-10 * np.abs(u).max())
    assert found.force @ lever == pytest.approx(torque, rel=1e-12)
    assert solution.equilibrium_residual < 1e-12


def test_displacements_close_the_gap_and_balance_the_load():
    """What the displacement fields say: no gap under pressure, and supports that take the whole load."""
    bodies, surfaces = two_blocks()
    pair = ContactPair(surfaces["slave"], surfaces["master"], gap=lopsided)
    contact = condense(bodies, [pair])
    solution = contact.solve(1500.0, displacements=True)
    (mortar,), (found,) = contact.mortars, solution.pairs
    opening = mortar.average(lopsided) - solution.rotation
    for name in bodies:
        opening = opening + contact.unit_loads[name].T @ solution.displacement[name].ravel()
    np.testing.assert_allclose(opening, found.gap, atol=1e-12)
    assert np.abs(opening[found.active]).max() < 1e-12
    assert opening[~found.active].min() > 0.0
    for name, up in (("slave", 1.0), ("master", -1.0)):
        pull = bodies[name].stiffness @ solution.displacement[name].ravel()
        pull -= contact.unit_loads[name] @ found.force
        np.testing.assert_allclose(pull.reshape(-1, 3).sum(axis=0), [0.0, 0.0, up * 1500.0], atol=1e-7)


def test_patch_test():
    """Uniform pressure passes through meshes that do not match, shaken in all directions."""
    bodies, surfaces = {}, {}
    for name, counts, z, seed in (
        ("slave", (6, 5), np.linspace(-1.0, 0.0, 4), 1),
        ("master", (4, 7), np.linspace(0.0, 1.5, 5), 2),
    ):
        x, y = np.linspace(0.0, 2.0, counts[0] + 1), np.linspace(0.0, 1.0, counts[1] + 1)
        body = block(x, y, z, jitter=0.1, seed=seed)
        back = np.flatnonzero(body.points[:, 2] == (z[0] if name == "slave" else z[-1]))
        sides = [3 * np.flatnonzero(body.points[:, k] == 0.0) + k for k in (0, 1)]
        bodies[name] = SupportedBody(body.stiffness, held(3 * back + 2, *sides))
        surfaces[name] = top_or_bottom(name, body)
    solution = solve_contact(bodies, [ContactPair(surfaces["slave"], surfaces["master"])], 400.0, displacements=True)
    np.testing.assert_allclose(solution.pairs[0].pressure, 200.0, rtol=1e-8)
    assert solution.rotation == pytest.approx(200.0 / E * 2.5, rel=1e-8)
    for name in bodies:
        points = surfaces[name].points
        fixed = -1.0 if name == "slave" else 1.5
        strain = 200.0 / E * np.array([NU, NU, -1.0])
        exact = strain * (points - [0.0, 0.0, fixed])
        np.testing.assert_allclose(solution.displacement[name], exact, atol=1e-8 * np.abs(exact).max())


def test_space_has_no_preferred_direction():
    axis_1, axis_2 = 0.7, -0.4
    about_z = np.array([[np.cos(axis_1), -np.sin(axis_1), 0], [np.sin(axis_1), np.cos(axis_1), 0], [0, 0, 1]])
    about_x = np.array([[1, 0, 0], [0, np.cos(axis_2), -np.sin(axis_2)], [0, np.sin(axis_2), np.cos(axis_2)]])
    turn = about_x @ about_z
    answers = []
    for rotation, gap in ((None, lopsided), (turn, lambda p: lopsided(p @ turn))):
        bodies, surfaces = two_blocks(rotation)
        answers.append(solve_contact(bodies, [ContactPair(surfaces["slave"], surfaces["master"], gap=gap)], 1500.0))
    straight, turned = answers
    np.testing.assert_allclose(turned.pairs[0].pressure, straight.pairs[0].pressure, atol=1e-6)
    assert turned.rotation == pytest.approx(straight.rotation, rel=1e-9)


def test_mirrored_meshes_give_mirrored_pressures():
    answers = []
    for mirror in (False, True):
        bodies, surfaces = two_blocks(mirror=mirror)
        flip = np.array([-1.0 if mirror else 1.0, 1.0, 1.0])
        pair = ContactPair(surfaces["slave"], surfaces["master"], gap=lambda p, flip=flip: lopsided(p * flip))
        answers.append(solve_contact(bodies, [pair], 1500.0))
    # not to the last digit: the triangles under the integration points are not mirrored
    np.testing.assert_allclose(answers[1].pairs[0].pressure, answers[0].pairs[0].pressure, atol=1e-2)
    assert answers[0].pairs[0].peak_pressure > 1000.0
    assert answers[1].rotation == pytest.approx(answers[0].rotation, rel=1e-6)


def two_spots(lever=1.0, gaps=(0.0, 0.0)):
    """Two blocks that touch at two places, mirrored in x: two pairs that share both bodies."""
    bodies, surfaces = {}, {}
    for name, x, z in (
        ("slave", np.linspace(-2.0, 2.0, 17), np.linspace(-1.0, 0.0, 4)),
        ("master", np.linspace(-2.0, 2.0, 13), np.linspace(0.0, 1.0, 4)),
    ):
        body = block(x, np.linspace(-0.5, 0.5, 5 if name == "slave" else 6), z)
        bodies[name] = SupportedBody(body.stiffness, body.dofs(np.flatnonzero(np.abs(body.points[:, 2]) == 1.0)))
        surfaces[name] = body

    def gap(p):
        return 0.05 * (np.abs(p[:, 0]) - 1.0) ** 2 + np.where(p[:, 0] < 0.0, *gaps)

    def pair(sides):
        parts = [top_or_bottom(name, surfaces[name], sides) for name in ("slave", "master")]
        return ContactPair(*parts, gap=gap, lever=lever)

    return bodies, [pair(lambda p: p[0] < -0.2), pair(lambda p: p[0] > 0.2)], pair(lambda p: np.abs(p[0]) > 0.2)


def test_equal_pairs_share_the_load():
    bodies, pairs, _ = two_spots()
    solution = solve_contact(bodies, pairs, 3000.0)
    left, right = solution.pairs
    assert left.load == pytest.approx(1500.0, rel=1e-10)
    assert right.load == pytest.approx(1500.0, rel=1e-10)
    np.testing.assert_allclose(np.sort(left.pressure), np.sort(right.pressure), atol=1e-7 * left.pressure.max())


def test_pairs_feel_one_another_as_one_surface_does():
    """Cut into two pairs or not, the bodies are the same: nothing is lost where they share them."""
    bodies, pairs, whole = two_spots(gaps=(0.0, 2e-3))
    parts, one = solve_contact(bodies, pairs, 3000.0), solve_contact(bodies, [whole], 3000.0)
    left, right = parts.pairs
    assert left.load > 1.1 * right.load > 0.0
    force = np.zeros(bodies["slave"].size // 3)
    for pair in parts.pairs:
        np.add.at(force, pair.nodes, pair.force)
    np.testing.assert_allclose(force[one.pairs[0].nodes], one.pairs[0].force, atol=1e-9 * force.max())
    assert parts.rotation == pytest.approx(one.rotation, rel=1e-10)
    # and they do feel one another: a layer that is pressed here bulges there
    alone = solve_contact(bodies, pairs[:1], left.load)
    assert abs(alone.rotation / parts.rotation - 1.0) > 1e-3


def test_torque_is_the_sum_over_pairs():
    bodies, pairs, _ = two_spots(lever=lambda p: 20.0 + p[:, 0])
    contact = condense(bodies, pairs)
    solution = contact.solve(6e4)
    moment = sum(
        pair.force @ mortar.average(one.lever)
        for pair, mortar, one in zip(solution.pairs, contact.mortars, pairs, strict=True)
    )
    assert moment == pytest.approx(6e4, rel=1e-12)
    assert solution.smallest_gap > -1e-12


def test_loads_superpose_while_the_contact_keeps_its_nodes():
    """Over a gap of zero the response is linear: two torques together do what they do apart."""
    bodies, pairs, _ = two_spots()
    contact = condense(bodies, pairs)
    one, two, three = (contact.solve(torque, gaps=[0.0, 0.0]) for torque in (1000.0, 2000.0, 3000.0))
    for a, b, c in zip(one.pairs, two.pairs, three.pairs, strict=True):
        assert a.active.any()
        np.testing.assert_allclose(a.pressure + b.pressure, c.pressure, atol=1e-9 * c.pressure.max())
    assert one.rotation + two.rotation == pytest.approx(three.rotation, rel=1e-10)


def test_wear_shifts_load_to_the_other_pair():
    """Wear of either body opens the gap alike, and a pair worn far enough carries nothing."""
    bodies, pairs, _ = two_spots()
    contact = condense(bodies, pairs)
    (mortar, _), depth = contact.mortars, 4e-3
    slave_points = pairs[0].slave.points
    whole = pairs[0].gap(slave_points)
    by_slave, by_master = whole.copy(), whole.copy()
    by_slave[mortar.nodes] += depth
    by_master[mortar.nodes] += mortar.transfer @ np.full(len(pairs[0].master.points), depth)
    fresh, slave_worn, master_worn, far_worn = (
        contact.solve(3000.0, gaps=[gap, whole]) for gap in (whole, by_slave, by_master, whole + 1.0)
    )
    np.testing.assert_allclose(master_worn.pairs[0].force, slave_worn.pairs[0].force, atol=1e-8)
    assert 0.0 < slave_worn.pairs[0].load < 0.9 * fresh.pairs[0].load
    assert far_worn.pairs[0].load == 0.0
    assert far_worn.pairs[1].load == pytest.approx(3000.0, rel=1e-12)
    assert far_worn.pairs[0].resolved
