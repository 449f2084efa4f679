"""Free edges: image loads against finite elements of a quarter-space, and what they must not do to the equations."""

from math import pi

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import quad
from skfem import MeshHex

from fem_reference.elasticity import ElasticBody
from fem_reference.solvers import factorise
from semiwear.closed_forms.stripe import stripe_table
from semiwear.compliance.free_edges import EdgeDistance, FreeBody, FreeEdges, image_factor, wedge_factor
from semiwear.contact.stripe import add_pairs, near_pairs, near_stripe, subtract_mid_surface
from semiwear.plan import plan

E, NU = 207000.0, 0.3
HALF = 0.5  # half the length of a slice, and half the width of the strip that is loaded
DEPTH_INDEX = 5  # node line below the surface that stands for the mid-surface
COUNT = 6  # slices, the first one at the edge


def graded(core: float, step: float, ratio: float, far: float) -> np.ndarray:
    """Even steps to `core`, growing ones to `far`."""
    nodes = list(np.arange(0.0, core + 1e-9, step))
    while nodes[-1] < far:
        step *= ratio
        nodes.append(nodes[-1] + step)
    return np.array(nodes)


def hat_integrals(nodes: np.ndarray, low: float, high: float) -> np.ndarray:
    """Integrals of the piecewise linear shape functions between nodes `low` and `high`."""
    inside = (nodes[:-1] > low - 1e-9) & (nodes[1:] < high + 1e-9)
    half = 0.5 * np.diff(nodes) * inside
    return np.append(half, 0.0) + np.insert(half, 0, 0.0)


def half_space(x: np.ndarray, depth: float, load: np.ndarray) -> np.ndarray:
    """Displacement of a half-space at (x, 0, depth) under unit force on strips about (load, 0) [mm/N]."""
    points, weights = np.polynomial.legendre.leggauss(24)
    p, q = np.meshgrid(HALF * points, HALF * points, indexing="ij")
    w = np.outer(weights, weights) / 4.0
    r2 = (x[:, None, None, None] - load[None, :, None, None] - p) ** 2 + q**2 + depth**2
    kernel = (1.0 + NU) / (2.0 * pi * E) * (depth**2 / r2**1.5 + 2.0 * (1.0 - NU) / np.sqrt(r2))
    return np.sum(w * kernel, axis=(-2, -1))


@pytest.fixture(scope="module")
def quarter_space():
    """Displacement by the free face at slices along a line normal to it: surface, mid-surface, places and depth.

    The difference between a free face and one that is held in its plane (which acts as a mirror) on the same mesh,
    plus the exact mirror image: the mesh's own error drops out.
    """
    x = graded(COUNT + 0.5, HALF, 1.8, 1000.0)
    y = graded(HALF, HALF, 1.8, 1000.0)
    z = graded(1.0, HALF, 1.8, 1000.0)
    mesh = MeshHex.init_tensor(x, y, z)
    body = ElasticBody(mesh, element="hex8i", youngs_modulus=E, poissons_ratio=NU)
    p = body.points
    far = np.flatnonzero((p >= np.array([x[-1], y[-1], z[-1]]) - 1e-9).any(axis=1))
    held = np.zeros(p.size, dtype=bool)
    held[body.dofs(far)] = True
    held[3 * np.flatnonzero(p[:, 1] == 0.0) + 1] = True
    centres = HALF + 2.0 * HALF * np.arange(COUNT)

    def node_line(depth: float) -> np.ndarray:
        on = np.flatnonzero((p[:, 1] == 0.0) & (p[:, 2] == depth) & np.isin(p[:, 0], centres))
        return on[np.argsort(p[on, 0])]

    surface = np.flatnonzero(p[:, 2] == 0.0)
    column, row = np.searchsorted(x, p[surface, 0]), np.searchsorted(y, p[surface, 1])
    across = hat_integrals(y, 0.0, HALF)
    load = np.zeros((p.size, COUNT))
    for k, centre in enumerate(centres):
        load[3 * surface + 2, k] = hat_integrals(x, centre - HALF, centre + HALF)[column] * across[row]
    load *= 0.5 / load.sum(axis=0)  # the other half of the force is beyond the plane of symmetry
    stiffness, solved = body.stiffness, []
    for mirror in (False, True):
        fixed = held.copy()
        fixed[3 * np.flatnonzero(p[:, 0] == 0.0)] |= mirror
        free = np.flatnonzero(~fixed)
        moved = np.zeros(load.shape)
        moved[free] = factorise(stiffness[free][:, free]).solve(load[free])
        solved.append(moved)
    by_edge = []
    for depth in (0.0, z[DEPTH_INDEX]):
        rows = 3 * node_line(depth) + 2
        by_edge.append(solved[0][rows] - solved[1][rows] + half_space(centres, depth, -centres))
    return by_edge[0], by_edge[1], centres, float(z[DEPTH_INDEX])


def one_body(centres: np.ndarray, half_width: float, depth: float | None, strength: float = 1.0) -> np.ndarray:
    """Free-edge compliance of one body along a line normal to its end."""
    place = centres[None]
    end = EdgeDistance.of(place, place)
    body = FreeBody(E, NU, None if depth is None else np.full(place.shape, depth), (end,))
    edges = FreeEdges(place, np.full(place.shape, 2.0 * HALF), (body,), half_width, strength)
    at = np.zeros(centres.size, dtype=np.int64), np.arange(centres.size)
    return edges.matrix(at, np.array([0, centres.size]))


# a strip of even pressure spreads as a semi-elliptic stripe of this half-width does
STRIPE = 2.0 / np.sqrt(3.0) * HALF


@pytest.mark.slow
def test_images_against_finite_elements(quarter_space):
    by_edge, _, centres, _ = quarter_space
    found = one_body(centres, STRIPE, None)
    away = centres >= 1.5
    np.testing.assert_allclose(found[np.ix_(away, away)], by_edge[np.ix_(away, away)], rtol=0.03)
    # the slice that ends in the edge: half a slice from it no image is exact
    np.testing.assert_allclose(found, by_edge, rtol=0.12)
    # against the whole displacement under the load
    whole = np.diag(half_space(centres, 0.0, centres)) + np.diag(by_edge)
    assert (np.diag(by_edge) / whole)[0] > 0.3
    assert np.abs(np.diag(found) - np.diag(by_edge))[1:].max() < 0.01 * whole.max()


@pytest.mark.slow
def test_local_part_against_finite_elements(quarter_space):
    """Surface less mid-surface, which is what tooth compliance leaves over."""
    by_edge, below, centres, depth = quarter_space
    local = by_edge - below
    found = one_body(centres, STRIPE, depth)
    whole = half_space(centres, 0.0, centres)[0, 0]
    assert np.abs(found - local)[1:, 1:].max() < 0.02 * whole
    # less far from the edge than the depth, little is left of it
    assert abs(found[-1, -1]) < 0.02 * whole > abs(local[-1, -1])


@pytest.mark.parametrize(
    ("nu", "single", "equal"),
    [
        (0.0, 1.001, 1.360),
        (0.1, 1.086, 1.442),
        (0.2, 1.235, 1.593),
        (0.25, 1.340, 1.699),
        (0.3, 1.468, 1.831),
        (0.35, 1.625, 1.991),
        (0.4, 1.818, 2.188),
    ],
)
def test_factor_is_that_of_a_fine_quarter_space(nu, single, equal):
    """Finite elements of 107 thousand unknowns, patch 8 half-sides from the edge, read at edge and load."""
    low, more = image_factor(nu)
    assert low == pytest.approx(single, rel=0.01)
    assert low + more == pytest.approx(equal, rel=0.01)


@pytest.mark.parametrize(
    ("degrees", "seen"), [(100.0, 3.299), (95.0, 2.451), (85.0, 1.346), (75.0, 0.724), (65.0, 0.372), (55.0, 0.168)]
)
def test_wedges(degrees, seen):
    """Finite elements of wedges, nu = 0.3, under a patch 8 half-sides from the edge; 1.819 at a right angle.

    On the same mesh the images of obtuse wedges err by some 0.02 in the factor itself, acute ones by a few per cent.
    """
    assert wedge_factor(np.radians(degrees)) == pytest.approx(seen / 1.819, abs=0.02, rel=0.07)
    assert wedge_factor(0.0) == 0.0


@st.composite
def slices(draw):
    """Slices of one line across a tooth with ends and tips at any distance, their local compliance, and the edges."""
    count = draw(st.integers(2, 60))
    b = draw(st.floats(0.05, 1.0))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    length = draw(st.floats(0.2, 20.0)) * b * random.uniform(0.8, 1.25, (1, count))
    arc = np.cumsum(length, axis=1) - 0.5 * length
    nu = draw(st.floats(0.0, 0.45))
    taper = np.linspace(1.0, draw(st.floats(0.7, 1.4)), count)[None]
    depth = [np.maximum(draw(st.floats(1.5, 40.0)) * taper, 1.5) * b for _ in "12"]
    bodies = []
    for own in depth:
        outside = [draw(st.sampled_from([0.0, 0.1, 3.0])) * b for _ in "12"]
        tip = draw(st.floats(0.0, 30.0)) * b + draw(st.floats(-0.3, 0.3)) * (arc - arc.mean())
        turn, lean = draw(st.floats(0.5, 1.8)), draw(st.floats(-0.2, 0.2))
        ends = (
            EdgeDistance.of(arc + outside[0], arc, 0.5 * pi + lean),
            EdgeDistance.of(arc[0, -1] - arc + outside[1], arc, 0.5 * pi - lean),
        )
        bodies.append(FreeBody(E, nu, own, ends, (EdgeDistance.of(tip, arc, turn),)))
    widths = b * random.uniform(0.3, 2.0, count)
    return arc, length, b, widths, nu, depth, tuple(bodies)


@given(slices())
def test_compliance_stays_positive_definite(case):
    arc, length, b, widths, nu, depth, bodies = case
    count, starts = arc.size, np.array([0, arc.size])
    modulus = 0.5 * E / (1.0 - nu**2)
    local = np.zeros((count, count))
    pairs = near_pairs(starts, arc[0], length[0], np.inf)
    add_pairs(local, pairs, near_stripe(pairs, widths, 1.0 / (pi * modulus), stripe_table()))
    shear = np.full(2, (1.0 + nu) / (2.0 * pi * E))
    subtract_mid_surface(local, starts, arc[0], length[0], np.concatenate(depth), shear, np.full(2, nu))
    at = np.zeros(count, dtype=np.int64), np.arange(count)
    edges = FreeEdges(arc, length, bodies, b).matrix(at, starts)
    assert np.all(np.isfinite(edges))
    np.testing.assert_array_equal(edges, edges.T)
    # wide stripes above a shallow mid-surface are held up by the tooth, not by their own local part
    assume(np.linalg.eigvalsh(local)[0] > 0.0)
    assert np.linalg.eigvalsh(local + edges)[0] > 0.0


def test_strength_and_lines():
    centres = HALF + 2.0 * HALF * np.arange(6)
    place = np.stack([centres, centres])
    body = FreeBody(E, NU, np.full(place.shape, 5.0), (EdgeDistance.of(place, place),))
    full = one_body(centres, 0.5, 5.0)
    np.testing.assert_allclose(one_body(centres, 0.5, 5.0, 0.25), 0.25 * full)
    assert not one_body(centres, 0.5, 5.0, 0.0).any()
    # slices of two lines do not see each other's images, and a part of a line sees its own as before
    edges = FreeEdges(place, np.full(place.shape, 1.0), (body,), 0.5)
    at = np.array([0, 0, 0, 1, 1]), np.array([0, 1, 2, 0, 3])
    found = edges.matrix(at, np.array([0, 3, 3, 5]))
    assert not found[:3, 3:].any() and not found[3:, :3].any()
    np.testing.assert_allclose(found[:3, :3], full[:3, :3])
    np.testing.assert_allclose(found[3:, 3:], full[np.ix_([0, 3], [0, 3])])
    # the end of another body lies elsewhere: shares add
    other = FreeBody(E, NU, np.full(place.shape, 5.0), (EdgeDistance.of(place + 100.0, place),))
    both = FreeEdges(place, np.full(place.shape, 1.0), (body, other), 0.5).matrix(at, np.array([0, 3, 3, 5]))
    np.testing.assert_array_equal(both, found)
    with pytest.raises(ValueError, match="strength"):
        one_body(centres, 0.5, 5.0, 1.5)


def test_edge_parallel_to_the_line_against_its_end():
    """The image of a line in an edge beside it: nowhere negative near it, the weaker the farther."""
    place = (0.05 + 0.1 * np.arange(20))[None]
    at, starts = (np.zeros(20, dtype=np.int64), np.arange(20)), np.array([0, 20])
    seen = []
    for distance in (0.5, 1.0, 2.0, 4.0):
        tip = EdgeDistance.of(np.full(place.shape, distance), place)
        body = FreeBody(E, NU, np.full(place.shape, 5.0), (), (tip,))
        seen.append(FreeEdges(place, np.full(place.shape, 0.1), (body,), 0.1).matrix(at, starts)[10, 10])
    # surface less mid-surface of a point load at twice the distance
    r = 2.0 * np.array([2.0, 4.0])
    deep = np.sqrt(r**2 + 25.0)
    shear = (1.0 + NU) / (2.0 * pi * E)
    expected = 1.831 * shear * (1.4 / r - 25.0 / deep**3 - 1.4 / deep)
    np.testing.assert_allclose(seen[2:], expected, rtol=0.03)
    assert np.all(np.diff(seen) < 0.0)


@given(
    st.lists(st.floats(0.3, 5.0), min_size=4, max_size=4),
    st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4),
    st.floats(-3.0, 3.0),
    st.booleans(),
    st.sampled_from([1, 2]),
)
def test_two_slices_see_the_mean_of_one_another_s_images(distances, slopes, apart, elastic, count):
    """By quadrature of the local displacement along either image, whatever the edges' slopes along the line."""
    half_width, lengths, deep = 0.2, np.array([0.8, 1.1]), np.array([1.7, 2.3])
    near = [(np.array(distances[2 * n : 2 * n + 2]), np.array(slopes[2 * n : 2 * n + 2])) for n in range(count)]
    edges = tuple(EdgeDistance(e[None], turn[None], np.array([[1.0, 0.7]])) for e, turn in near)
    body = FreeBody(E, NU, deep[None] if elastic else None, edges[:1], edges[1:])
    free = FreeEdges(np.array([[0.0, apart]]), lengths[None], (body,), half_width)
    at = np.zeros(2, dtype=np.int64), np.arange(2)
    found, both = np.zeros((2, 2)), 0.0
    free._add_image(found, at, body, edges)
    single, equal = image_factor(NU)
    length, depth = np.sqrt(lengths.prod()), np.sqrt(deep.prod())

    def displacement(x: float, here: int) -> float:
        """At a slice, under unit force at a place of the other one's image."""
        s = apart if here == 0 else -apart
        r2 = (s + x) ** 2 + sum(4.0 * e[here] * (e[1 - here] + turn[1 - here] * x) for e, turn in near)
        middle = s + 2.0 * sum(e[here] * turn[1 - here] for e, turn in near)
        r2 = max(r2, (x + middle) ** 2)  # an image is no nearer than the line on which it lies
        value = 2.0 * (1.0 - NU) / np.sqrt(r2 + 0.25 * half_width**2)
        if elastic:
            value -= depth**2 / (r2 + depth**2) ** 1.5 + 2.0 * (1.0 - NU) / np.sqrt(r2 + depth**2)
        return (1.0 + NU) / (2.0 * pi * E) * value

    for here in (0, 1):
        middle = -(apart if here == 0 else -apart) - 2.0 * sum(e[here] * turn[1 - here] for e, turn in near)
        nearest = [middle] if abs(middle) < 0.5 * length else None
        both += 0.5 * quad(displacement, -0.5 * length, 0.5 * length, args=(here,), points=nearest)[0] / length
    for e, _ in near:
        both *= np.sqrt(0.7) * (single + equal * 4.0 * e.prod() / e.sum() ** 2)
    np.testing.assert_allclose(found[0, 1], both, rtol=1e-6, atol=1e-6 * abs(both) + 1e-14)
    assert found[0, 1] == found[1, 0]


@pytest.mark.slow
def test_real_lines_stay_positive_definite(small):
    teeth = plan(small.replace({"numerics.harmonics": 9})).loaded_teeth()
    problem, lines = teeth.problem, teeth.lines
    bodies = [on_lines.body for on_lines in problem.bodies]
    edges = FreeEdges.of(
        lines, teeth.pair.borders(lines.face, sharp=True), (bodies[0], bodies[1]),
        (problem.bodies[0].depth, problem.bodies[1].depth), problem.usual_half_width, tip_turns=(1.05, 1.13),
    )  # fmt: skip
    for position in (0, 5):
        system = problem.candidates(position, 0.1)
        at = np.unravel_index(system.flat, lines.profile.shape)
        width = np.full(system.flat.size, problem.usual_half_width)
        matrix = system.smooth.copy()
        factor = 1.0 / (pi * problem.modulus)
        pairs = near_pairs(system.starts, system.arc, system.length, np.inf)
        add_pairs(matrix, pairs, near_stripe(pairs, width, factor, stripe_table()))
        added = edges.matrix(at, system.starts)
        assert np.linalg.eigvalsh(matrix + added)[0] > 0.5 * np.linalg.eigvalsh(matrix)[0] > 0.0
        ends, middle = (at[1] == 0) | (at[1] == lines.face.size - 1), np.abs(at[1] - lines.face.size // 2) < 9
        middle &= np.minimum(lines.high - lines.profile, lines.profile - lines.low)[at] > 1.0  # away from the tips
        share = np.diag(added) / np.diag(matrix)
        assert share[ends].min() > 0.03 and share[ends].max() < 1.0
        assert np.abs(share[middle]).max() < 0.01
