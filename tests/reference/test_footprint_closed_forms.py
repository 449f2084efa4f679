"""Footprints and what they leave on a flank, where both are known: parabolas, edges, loads that move on evenly."""

from dataclasses import replace
from math import pi, sqrt
from types import SimpleNamespace

import numpy as np
import pytest

from semiwear.contact.edge_share import share_of_edge
from semiwear.contact.footprint import BESIDE, Footprints, footprints, reached
from semiwear.contact.gap import SliceGap, gap_of_flanks, slice_gap
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import FlankGrid
from semiwear.meshing.removed import Removed
from semiwear.wear.between_rolls import VALLEY
from semiwear.wear.deposit import (
    Nodes,
    Spread,
    factor_at,
    lay_footprint,
    piece_space,
    pieces_of,
    spread_over_flank,
)
from semiwear.wear.driving_deposit import spread_over_both_flanks
from tests.reference.test_edge_contact import CURVATURE as BEND
from tests.reference.test_edge_contact import EDGE, groove
from tests.reference.test_edge_contact import RADIUS as EDGE_RADIUS
from tests.strategies.lines import straight_lines

CURVATURE, HALF_WIDTH = 0.04, 0.5  # 1/mm, mm
NODES = np.linspace(-4.0, 4.0, 641)


def one_slice(place: np.ndarray, per_mm: float = 1.0, **changes: float) -> ContactLines:
    """Lines at some places of a slice where a profile coordinate is so many mm; `changes` are borders and edges."""
    lines = straight_lines(place, 1, across=CURVATURE * per_mm**2, half_height=4.0)
    one = np.ones(lines.profile.shape)
    return replace(lines, spacing=per_mm * one, **{name: value * one for name, value in changes.items()})


def grid_of(nodes: np.ndarray) -> FlankGrid:
    return FlankGrid(np.zeros(1), nodes[None], np.array([nodes.size // 2]))


def touched(lines: ContactLines, depth: np.ndarray, near: bool = True, nodes: np.ndarray = NODES) -> Footprints:
    """Footprints where depths (rows, points) are gone."""
    removed = Removed.met(grid_of(nodes), depth[:, None], lines.roll.size)
    return footprints(lines, removed, HALF_WIDTH, np.full(lines.profile.shape, near))


@pytest.mark.parametrize("per_mm", [1.0, 0.7])
def test_a_parabola_worn_off_a_parabola_leaves_a_parabola(per_mm):
    """Of curvatures B and c about places x apart: B + c about c x/(B + c), where B c/(B + c) x^2/2 is open."""
    bend, worn, apart = CURVATURE * per_mm**2, np.array([0.05, 0.02, 0.05]), np.array([0.4, -0.6, 0.1])
    depth = 0.5 * worn[:, None] * (NODES - apart[:, None]) ** 2
    found = touched(one_slice(np.zeros(3), per_mm), depth)
    both = bend + worn
    open_gap = 0.5 * bend * worn / both * apart**2
    np.testing.assert_allclose(found.profile[:, 0], worn * apart / both, atol=1e-3)
    np.testing.assert_allclose(found.least[:, 0], open_gap, atol=3e-6)  # at nodes
    np.testing.assert_allclose(found.gap[:, 0], open_gap, atol=1e-5)
    np.testing.assert_allclose(found.half_width[:, 0], HALF_WIDTH * np.sqrt(bend / both), rtol=2e-3)
    np.testing.assert_allclose(found.curvature[:, 0], both / per_mm**2, rtol=4e-3)
    assert not found.edge.any()


@pytest.mark.parametrize("depth", [0.0, 3e-3])
def test_a_fresh_slice_and_one_that_is_not_near_touch_by_their_own_curvature(depth):
    """What is gone all over is a gap that is open."""
    gone = np.full((1, NODES.size), depth)
    gone_oddly = gone + 0.05 * (NODES - 0.4) ** 2
    for found in (
        touched(one_slice(np.zeros(1), 0.7), gone),
        touched(one_slice(np.zeros(1), 0.7), gone_oddly, False),
    ):
        assert found.profile[0, 0] == 0.0 and not found.edge.any()
        assert found.curvature[0, 0] == pytest.approx(CURVATURE)
        assert found.half_width[0, 0] == HALF_WIDTH
    assert found.gap[0, 0] == pytest.approx(depth + 0.05 * 0.4**2)


CUT = {
    "at a node": (0.3, 0.0, 0.0, 0.7),
    "between nodes": (0.307, 0.0, 0.0, 0.7),
    "worn": (0.307, 0.03, 0.2, 1.0),
    "worn at a node": (0.3, 0.03, 0.2, 1.0),
    "rounded": (0.207, 0.0, 0.0, 1.0),
    "rounded at a node": (0.2, 0.0, 0.0, 1.0),
    "hardly": (0.457, 0.0, 0.0, 1.0),
    "worn beyond": (-0.2, 0.06, 0.9, 1.0),
}


@pytest.mark.parametrize("upper", [False, True])
@pytest.mark.parametrize("case", CUT)
def test_a_footprint_that_an_edge_cuts_off_is_the_root_of_the_gap_up_to_there(case, upper):
    """Its moments by plain sums over the gap: parabola, what is worn off about another place, and a rounded edge."""
    before, worn, apart, per_mm = CUT[case]
    radius = 0.3 if "rounded" in case else 0.0
    sign = 1.0 if upper else -1.0
    border, apart = sign * before, sign * apart
    ends = {"high": border, "high_edge_radius": radius} if upper else {"low": border, "low_edge_radius": radius}
    found = touched(one_slice(np.zeros(1), per_mm, **ends), 0.5 * worn * (NODES - apart)[None] ** 2)

    bend = CURVATURE * per_mm**2
    place = border - sign * np.linspace(-0.999 * radius / per_mm, 3.0, 400_001)
    inside, beyond = sign * np.minimum(sign * place, sign * border), np.maximum(sign * (place - border), 0.0) * per_mm
    gap = 0.5 * bend * inside**2 + bend * inside * (place - inside) + 0.5 * worn * (place - apart) ** 2
    gap += radius - np.sqrt(np.maximum(radius**2 - beyond**2, 0.0))
    depth, least = 0.5 * bend * (HALF_WIDTH / per_mm) ** 2, gap.min()
    root = np.sqrt(np.maximum(depth - gap + least, 0.0))
    width = abs(place[1] - place[0])
    area = root.sum() * width

    at_border = 0.5 * bend * border**2 + 0.5 * worn * (border - apart) ** 2
    half_width = 2.0 * area * per_mm / (pi * sqrt(depth))
    assert found.edge.all()
    assert found.cut[0, 0] == pytest.approx(1.0 - (at_border - least) / depth, abs=1e-3)
    assert found.least[0, 0] == pytest.approx(least, abs=3e-6)
    assert found.profile[0, 0] == pytest.approx((root * place).sum() * width / area, abs=2e-3)
    assert found.half_width[0, 0] == pytest.approx(half_width, rel=5e-3)
    assert found.curvature[0, 0] == pytest.approx(2.0 * depth / half_width**2, rel=1e-2)
    mean = (root * gap).sum() * width / area
    assert found.gap[0, 0] == pytest.approx(mean - 0.25 * depth, abs=1e-2 * depth)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_slice_far_from_its_line_touches_at_its_end(sign):
    lines = one_slice(np.array([sign * 2.0]), **{"high" if sign > 0.0 else "low": sign * 0.3})
    found = touched(lines, np.full((1, NODES.size), 1e-3))
    assert found.cut[0, 0] == 1.0
    both = touched(lines, 0.5 * 0.01 * NODES[None] ** 2)
    assert both.least[0, 0] == pytest.approx(0.5 * CURVATURE * 1.7**2 + 0.5 * 0.01 * 0.3**2, rel=1e-6)


def test_a_footprint_on_the_rounding_of_an_edge_is_counted_at_the_border():
    """The line lies on the border, and the rounding is flatter than the flank is bent."""
    found = touched(one_slice(np.zeros(1), low=0.0, low_edge_radius=200.0), np.zeros((1, NODES.size)))
    assert found.profile[0, 0] == 0.0 and found.least[0, 0] == 0.0


@pytest.mark.parametrize("shift", [0.0, 0.02, 0.04])
def test_nothing_beyond_a_window_is_read_and_nothing_in_it_is_left_out(shift):
    """Windows reach a few nodes beyond a footprint: on coarse nodes, each in its turn is the last one needed."""
    nodes = np.linspace(-4.0, 4.0, 81)
    depth = 0.5 * 0.05 * (nodes - 0.3 - shift)[None] ** 2
    lines = one_slice(np.zeros(1))
    whole = touched(lines, depth, nodes=nodes)
    centre, reach = 0.05 * (0.3 + shift) / (CURVATURE + 0.05), HALF_WIDTH * sqrt(CURVATURE / (CURVATURE + 0.05))
    first, last = np.searchsorted(nodes, centre - reach) - 1, np.searchsorted(nodes, centre + reach)
    known = np.array([[[first - BESIDE + 1, last + BESIDE]]])
    unread = np.full_like(depth, np.nan)
    unread[0, known[0, 0, 0] : known[0, 0, 1]] = depth[0, known[0, 0, 0] : known[0, 0, 1]]
    removed = Removed(grid_of(nodes), unread[:, None], np.zeros(1, dtype=np.int64), known)
    found = footprints(lines, removed, HALF_WIDTH, np.ones((1, 1), dtype=bool))
    for name in ("profile", "gap", "curvature", "half_width", "least", "cut"):
        np.testing.assert_allclose(getattr(found, name), getattr(whole, name), rtol=1e-9, atol=1e-12, err_msg=name)


# ---------------------------------------------------------------------- what they leave


def spread(
    lines: ContactLines, rate: np.ndarray, sliding: np.ndarray, slope: tuple[float, float], depth: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Density at the nodes of one slice, and what is taken."""
    shape = lines.profile.shape
    what = Spread(
        lines.profile, rate[:, None], sliding[:, None], np.broadcast_to(slope, (*shape, 2)).copy(),
        np.full(shape, 1e-4), np.zeros((*shape, 4)), np.zeros(1),
    )  # fmt: skip
    grid, taken = grid_of(NODES), np.zeros(2)
    removed = Removed.met(grid, depth[:, None], shape[0])
    return spread_over_flank(lines, grid, removed, HALF_WIDTH, what, np.zeros(1, dtype=np.int64), taken)[0], taken


NOTHING = np.zeros((1, NODES.size))
WIDTHS = np.gradient(NODES) * np.where(np.arange(NODES.size) % (NODES.size - 1) == 0, 0.5, 1.0)


def test_the_factor_of_a_place_is_the_length_of_its_vector():
    assert factor_at((2.0, 3.0, 4.0, 0.5, -1.0), 2.2) == pytest.approx(np.hypot(3.1, 3.8))


@pytest.mark.parametrize("across", [0.0, 2.0])
def test_loads_that_move_on_evenly_leave_load_times_sliding_over_their_speed(across):
    """Both linear in the place: their product, as sliding is that of the place and not that of the line."""
    per_mm, step = 0.7, 0.04
    place = step * np.arange(-60, 61)
    sliding = np.stack([2.0 + 0.5 * place, np.full(place.size, across)], axis=-1)
    lines = one_slice(place, per_mm)
    density, taken = spread(lines, 3.0 + 1.2 * place, sliding, (0.5, 0.0), NOTHING)
    middle = np.abs(NODES) < 1.2
    expected = (3.0 + 1.2 * NODES) * np.hypot(2.0 + 0.5 * NODES, across) / (per_mm * step)
    np.testing.assert_allclose(density[middle], expected[middle], rtol=2e-3)
    assert taken[0] == pytest.approx(density @ WIDTHS * per_mm * lines.length[0, 0], rel=1e-9) and taken[1] == 0.0


@pytest.mark.parametrize("per_mm", [1.0, 0.7])
def test_what_the_rounding_of_an_edge_bears_lies_beyond_the_nodes(per_mm):
    nodes_end = float(NODES[-1])
    lines = one_slice(nodes_end - 0.04 * np.arange(40)[::-1], per_mm, high_edge_radius=0.3)
    even = np.ones(lines.roll.size)
    density, taken = spread(lines, even, np.stack([even, 0.0 * even], axis=-1), (0.0, 0.0), NOTHING)
    assert 0.01 * taken[0] < taken[1] < 0.2 * taken[0]
    assert taken[0] == pytest.approx(even.sum(), rel=1e-9)
    assert taken[0] - taken[1] == pytest.approx(density @ WIDTHS * per_mm, rel=1e-9)


def test_what_is_taken_is_counted_over_the_length_of_each_roll_position():
    lines = one_slice(0.3 * np.arange(-3, 4))
    lines = replace(lines, length=1.0 + np.arange(7.0)[:, None])
    rate = np.array([0.0, 1.0, 0.5, 0.0, 2.0, 1.0, 0.0])
    taken = spread(lines, rate, np.tile([3.0, 4.0], (7, 1)), (0.0, 0.0), NOTHING)[1]
    assert taken[0] == pytest.approx(5.0 * rate @ lines.length[:, 0], rel=1e-9)


def test_each_roll_position_meets_its_own_row_of_what_is_gone():
    """Two of them at one place leave what each leaves by itself; one without a contact leaves nothing."""
    lines = one_slice(np.zeros(3))
    lines.separation[:, 2] = np.nan
    depth = 0.02 * (NODES - np.array([[0.3], [-0.4], [0.0]])) ** 2
    sliding = np.ones((3, 2))
    first, second, both, all_three = (
        spread(lines, np.array(rate), sliding, (0.0, 0.0), depth)[0]
        for rate in ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0])
    )
    assert np.abs(first - second).max() > 0.5 * first.max()
    np.testing.assert_allclose(both, first + second, atol=1e-9 * both.max())
    np.testing.assert_allclose(all_three, both, atol=1e-9 * both.max())


@pytest.mark.parametrize("mark", [-1, 0, 1, VALLEY])
def test_stretches_move_with_the_footprint_or_with_the_border_at_which_they_are(mark):
    """Three roll positions: footprint, lower and upper border move by different steps, and the fresh line not at all.

    Half a node below the upper border a stretch is held by half; the mean of its own movement and the border's is
    weighed by its distance from there over that of two nodes.
    """
    rolls = np.array([-1.0, 0.0, 1.0])
    lines = replace(one_slice(np.zeros(3)), low=-2.0 + 0.2 * rolls[:, None], high=2.0 - 0.3 * rolls[:, None])
    flank, grid = gap_of_flanks(lines, Removed.met(grid_of(NODES), NOTHING[:, None], 3)), grid_of(NODES)
    one, none = np.ones((3, 1)), np.zeros((3, 1, 2))
    what = Spread(0.1 * rolls[:, None], one, none + np.array([1.0, 0.0]), none, one, np.zeros((3, 1, 4)), np.zeros(1))
    space, cell = piece_space(NODES[None]), NODES[1] - NODES[0]
    for place, plain in ((0.5, 0.1), (2.0 - 0.5 * cell, 0.1 + 0.5 * (-0.3 - 0.1) * (1.0 - 0.5))):
        space.mass[0], space.middle[0], space.ends[0], space.at_edge[0] = 1.0, place, place, mark
        gap, nodes = slice_gap(flank, 1, 0), Nodes(grid.profile, grid.split)
        lay_footprint(flank, what, nodes, gap, 1, 0, 1.0, 1, space, np.zeros(NODES.size))
        assert space.shift[0] == pytest.approx({-1: 0.2, 1: -0.3}.get(mark, plain))


@pytest.mark.parametrize("upper", [False, True])
def test_an_edge_and_its_valley_share_a_footprint_without_a_rest(upper):
    """Whether they are one contact, two, or in between; the edge's stretches end where those of the valley begin."""
    _, grid, wear = groove(1e-3)
    nodes, depth = grid.profile[0], wear[0]
    if upper:
        nodes, depth = -nodes[::-1].copy(), depth[::-1].copy()
    low, high = (-8.0, -EDGE) if upper else (EDGE, 8.0)
    radii = (0.0, EDGE_RADIUS) if upper else (EDGE_RADIUS, 0.0)
    gap = SliceGap(0.0, low, high, np.array([0.0, 0.0, BEND, 0.0, 0.0]), 1.0, *radii, depth, nodes, 1600)
    known, found = [], np.zeros((1, 1))
    for closes in (1e-4, 1e-3, 1e-2, 3e-2, 0.1, 1.0):
        edges = np.zeros((1, 1, 4))
        none = np.zeros((1, 1, 2))
        what = Spread(found, found + 1.0, none, none, found + closes, edges, np.zeros(1))
        space = piece_space(nodes[None])
        count = pieces_of(gap, 0.3, what, 0, 0, space)
        mark, mass, ends_of = space.at_edge[:count], space.mass[:count], space.ends[:count]
        assert mass.sum() == pytest.approx(1.0, rel=1e-12) and (mass >= 0.0).all()
        known.append(edges[0, 0, 3])
        edge, valley = ends_of[mark == (1 if upper else -1)], ends_of[mark == VALLEY]
        if edge.size and valley.size:
            assert edge.min() >= valley.max() - 1e-12 if upper else edge.max() <= valley.min() + 1e-12
    assert 1.0 in known and any(0.0 < one < 1.0 for one in known)


@pytest.mark.parametrize("radius", [0.0, 0.3])
def test_a_driving_flank_that_is_a_mirror_image_twice_as_high_wears_as_the_mirror_image(radius):
    """Footprints move on and are cut off by borders that move otherwise, some by the lower, some by the upper one."""
    steps = np.arange(7.0)
    lines = straight_lines(0.2 * steps - 0.6, 3, across=0.5 * CURVATURE, sliding=steps - 2.0, sliding_slope=0.7)
    one = np.ones(lines.profile.shape)
    lines = replace(
        lines, spacing=0.7 * one, low=(-0.5 + 0.07 * steps)[:, None] * one, high=(0.72 - 0.03 * steps)[:, None] * one,
        driving_profile=-2.0 * lines.profile, driving_slope=-2.0 * one,
        low_edge_radius=radius * one, high_edge_radius=radius * one,
    )  # fmt: skip
    nodes = np.tile(np.linspace(-0.5, 0.72, 123), (3, 1))
    grid = FlankGrid(lines.face, nodes, np.full(3, 61))
    removed = Removed.met(grid, 0.5 * 0.03 * (nodes[None] - 0.2) ** 2, 7)
    what = Spread(
        lines.profile, (1.0 + steps)[:, None] * one, lines.sliding, lines.sliding_slope, 1e-4 * one,
        np.zeros((*one.shape, 4)), np.zeros(3),
    )  # fmt: skip
    driving, taken = SimpleNamespace(grid=replace(grid, profile=-2.0 * nodes[:, ::-1])), np.zeros((2, 2))
    found = spread_over_both_flanks(lines, grid, driving, removed, HALF_WIDTH, what, np.arange(3), taken)
    assert (found[1].max(axis=1) > 0.0).all() and (np.ptp(found[1], axis=0) < 1e-12).all()
    np.testing.assert_allclose(found[0], found[1][:, ::-1], rtol=1e-9, atol=1e-9 * found[1].max())
    np.testing.assert_allclose(taken[0], taken[1], rtol=1e-9)
    assert taken[1, 1] > 0.0
    # of the last slice, a quarter of which lies beyond the width of the last station, a quarter is lost
    lines, beside = replace(lines, driving_face=lines.driving_face + 0.25), np.zeros((2, 2))
    spread_over_both_flanks(lines, grid, driving, removed, HALF_WIDTH, what, np.arange(3), beside)
    np.testing.assert_allclose(beside[0], [taken[0, 0], taken[0, 1] + (taken[0, 0] - taken[0, 1]) / 12.0], rtol=1e-9)


BETWEEN = [-3.0, -2.6, -1.6, -1.0, -0.4, 0.4, 1.0, 1.8, 4.0]
RIDGES = {
    "of a height": [1.5, 0.4, 1.2, 0.6, 1.2, 0.1, 0.7, 0.1, 9.0],
    "the farther one higher": [1.5, 0.4, 1.2, 0.6, 1.26, 0.1, 0.7, 0.1, 9.0],
}


def ridged(gaps: list[float], low: float = -2.5, bend: float = 0.05) -> SliceGap:
    """A slice with a rounded lower edge whose gap goes by straight lines [um] between some places."""
    nodes = np.linspace(-3.5, 4.5, 1601)
    inside, beyond = np.maximum(nodes, low), np.maximum(low - nodes, 0.0)
    fresh = 0.5 * bend * inside**2 - bend * low * beyond + 3.0 - np.sqrt(9.0 - beyond**2)
    removed, terms = 1e-3 * np.interp(nodes, BETWEEN, gaps) - fresh, np.array([0.0, 0.0, bend, 0.0, 0.0])
    return SliceGap(0.0, low, 9.0, terms, 1.0, 3.0, 0.0, removed, nodes, 800)


def test_a_hollow_between_ridges_counts_as_higher_by_what_contact_may_reach():
    """It belongs to the edge by 0.8; its 0.15 um, raised by 0.2 of 2.15 um, count as more than the edge's 0.45 um.

    That is 1.25 times a footprint's depth of 1 um, and nine times the 0.1 um that the contact closes.
    """
    gap, none, closes = ridged([1.5, 0.45, 1.3, 0.15, 1.312, 0.1, 1.6, 1.7, 9.0]), np.zeros((1, 1)), 1e-4
    vector = np.zeros((1, 1, 2))
    what = Spread(none, none + 1.0, vector, vector, none + closes, np.zeros((1, 1, 4)), np.zeros(1))
    space = piece_space(gap.nodes[None])
    space.reach.u.fill(-1e9)  # memory that nothing writes may hold anything
    count = pieces_of(gap, 0.2, what, 0, 0, space)
    own = space.at_edge[:count] == -1
    u, side = space.reach.u, space.side[0]
    places = np.flatnonzero(np.diff(u) <= 0.0)[0] + 1 if (np.diff(u) <= 0.0).any() else u.size
    assert side[np.searchsorted(u[:places], -1.0)] == pytest.approx(0.8, abs=0.01)
    x = np.linspace(-3.0, 0.4, 340_001)
    root = np.sqrt(np.maximum(1e-3 + 0.45e-3 - np.interp(x, u[:places], space.reach.g[:places]), 0.0))
    root *= np.interp(x, u[:places], side[:places])
    middle = space.mass[:count][own] @ space.middle[:count][own] / space.mass[:count][own].sum()
    assert middle == pytest.approx((root @ x) / root.sum(), abs=1e-4)


@pytest.mark.parametrize("upper", [False, True])
@pytest.mark.parametrize("ridges", RIDGES)
def test_between_two_ridges_edge_and_valley_lie_beside_each_other_in_every_stretch(ridges, upper):
    """The stretches belong to both by half, or to the edge rather; the share is the one that cycles before tell."""
    gap = ridged(RIDGES[ridges])
    if upper:
        gap = gap._replace(
            low=-9.0,
            high=2.5,
            low_radius=0.0,
            high_radius=3.0,
            removed=gap.removed[::-1].copy(),
            nodes=-gap.nodes[::-1],
        )
    found, none, closes = np.zeros((1, 1)), np.zeros((1, 1, 2)), 1e-3
    before, most = np.array([[[0.3, 0.35e-3, 0.1e-3, 1.0]]]), 3e-3
    what = Spread(found, found + 1.0, none, none, found + closes, before.copy(), np.array([most]))
    space = piece_space(gap.nodes[None])
    count = pieces_of(gap, 0.25, what, 0, 0, space)
    mass, ends, mark = space.mass[:count], space.ends[:count], space.at_edge[:count]
    own, valley = mark == (1 if upper else -1), mark == VALLEY

    reach, sides = piece_space(gap.nodes[None]).reach, np.zeros((2, space.reach.u.size))
    depth, places, _ = reached(gap, 0.25, reach)
    outline = reach.u, reach.g, places, gap.low, gap.high, 1.0, depth, closes
    edge, share, apart = share_of_edge(*outline, before[0, 0], most, sides)
    assert edge == (1 if upper else -1) and 0.1 < share < 0.4 and 0.7 < apart < 1.0
    assert mass[own].sum() == pytest.approx(apart * share, rel=1e-9)
    assert mass[valley].sum() == pytest.approx(apart * (1.0 - share), rel=1e-9)
    # where both have a part of a stretch that is closed, one begins where the other ends
    between = (sides[0, : places - 1] > 0.0) & (sides[0, : places - 1] < 1.0)
    start, stop = reach.u[: places - 1][between].min() + 0.1, reach.u[: places - 1][between].max() - 0.1
    inner = (space.middle[:count] > start) & (space.middle[:count] < stop)
    before_it, beyond = (ends[which & inner] for which in ((valley, own) if upper else (own, valley)))
    assert len(before_it) > 20 and (np.diff(before_it) > 0.0).all() and (np.diff(beyond) > 0.0).all()
    np.testing.assert_allclose(before_it[:, 1], beyond[:, 0], atol=1e-12)
