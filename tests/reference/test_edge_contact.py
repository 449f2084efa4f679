"""A tip edge that presses on the wall of its groove, while the valley beyond may bear as well: a slice of two bands.

Against the same plane contact on many even cells, written down here for itself.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import brentq

from semiwear.contact.edge_share import share_of_edge
from semiwear.contact.footprint import Footprints
from semiwear.contact.gap import SliceGap, most_places, outline
from semiwear.contact.slice_pressure import solve_slices
from semiwear.meshing.flank_grid import FlankGrid
from semiwear.meshing.removed import Removed
from tests.strategies.lines import straight_lines

MODULUS = 115e3
CURVATURE = 0.05  # 1/mm
EDGE, RADIUS = -2.0, 0.2  # mm
FAR = 10.0  # mm, where deflections are counted from
WALL = (EDGE - 0.1, EDGE + 0.3)  # mm: where the groove begins, and where it is as deep as the valley


class Solved(NamedTuple):
    """Approach [mm], and share of the edge and middle [mm] of the force."""

    approach: float
    share: float
    centre: float


def first() -> tuple[np.ndarray, float]:
    """What is known of an edge before the first cycle."""
    return np.zeros(4), 0.0


def shared(u: np.ndarray, *others: object) -> tuple[int, float, float]:
    """Share of an edge, whatever belongs to it."""
    return share_of_edge(u, *others, np.empty((2, u.size)))


def smooth_step(place: np.ndarray, start: float, stop: float) -> np.ndarray:
    x = np.clip((place - start) / (stop - start), 0.0, 1.0)
    return x**2 * (3.0 - 2.0 * x)


def fresh_gap(place: np.ndarray) -> np.ndarray:
    beyond, inside = np.maximum(EDGE - place, 0.0), np.maximum(place, EDGE)
    return 0.5 * CURVATURE * inside**2 - CURVATURE * EDGE * beyond + 0.5 * beyond**2 / RADIUS


def level() -> float:
    """Wear [mm] of the valley that brings it as near as the edge is to the wall."""
    place = np.linspace(EDGE - 0.2, EDGE + 0.1, 30001)
    return brentq(lambda depth: np.min(fresh_gap(place) + depth * smooth_step(place, *WALL)) - depth, 0.05, 0.3)


LEVEL = level()


def groove(deep: float):
    """A line at no border, an edge two millimetres below it, and a valley `deep` [mm] farther than the edge."""
    lines = straight_lines(np.zeros(1), 1, across=CURVATURE, half_height=8.0)
    nothing = np.zeros(lines.profile.shape)
    lines = replace(lines, low=nothing + EDGE, low_edge_radius=nothing + RADIUS)
    even = np.linspace(-8.0, 8.0, 3201)
    wear = LEVEL * smooth_step(even, *WALL) + deep * smooth_step(even, EDGE + 0.5, EDGE + 1.0)
    return lines, FlankGrid(lines.face, even[None], np.array([1600])), wear[None]


def gap_of(grid: FlankGrid, wear: np.ndarray, place: np.ndarray) -> np.ndarray:
    return fresh_gap(place) + np.interp(place, grid.profile[0], wear[0])


def solved_evenly(grid: FlankGrid, wear: np.ndarray, line_load: float) -> Solved:
    """Plane contact on cells of 1 um at the edge, 5 um in the valley: p >= 0, slack >= 0 and their product zero."""
    width = np.repeat([1e-3, 5e-3], [200, 320])
    place = np.concatenate([EDGE - 0.12 + 1e-3 * np.arange(200), -0.7975 + 5e-3 * np.arange(320)])
    away = np.abs(place[:, None] - place)
    high, low = away + 0.5 * width, away - 0.5 * width
    mean_log = (high * np.log(high) - low * np.log(np.abs(low))) / width - 1.0
    influence = 2.0 / (np.pi * MODULUS) * (np.log(FAR) - mean_log)
    gap = gap_of(grid, wear, place)
    on = gap < gap.min() + 2e-3
    for _ in range(200):
        both = np.linalg.solve(influence[np.ix_(on, on)], np.stack([gap[on], np.ones(on.sum())], axis=1))
        approach = (line_load + both[:, 0].sum()) / both[:, 1].sum()
        force = np.zeros(place.size)
        force[on] = approach * both[:, 1] - both[:, 0]
        slack = gap + influence @ force - approach
        new = np.where(on, force > 0.0, slack < -1e-12)
        if np.array_equal(new, on):
            edge = float(force[place < EDGE + 0.3].sum()) / line_load
            return Solved(float(approach), edge, float(force @ place) / line_load)
        on = new
    raise AssertionError("the contact set does not settle")


def touched_by(lines, grid: FlankGrid, wear: np.ndarray, line_load: float, *, smooth: bool = False) -> Footprints:
    nothing = np.zeros(lines.profile.shape)
    removed = Removed.met(grid, wear[None], 1)
    worn = Footprints(
        removed, lines.profile, nothing, nothing + CURVATURE, nothing + 0.3, nothing + 1.0, nothing, nothing
    )
    return solve_slices(lines, worn, nothing + line_load, MODULUS, 0.0, smooth=smooth)[1]


@pytest.mark.parametrize("line_load", [100.0, 300.0])
@pytest.mark.parametrize("deep", [-8e-3, -2e-3, 0.0, 2e-3, 5e-3, 20e-3])
def test_both_bands_are_found(deep, line_load):
    """Approach, its change by the load, and the middle of the force."""
    lines, grid, wear = groove(deep)
    exact = solved_evenly(grid, wear, line_load)
    found = touched_by(lines, grid, wear, line_load)
    closes = 2.0 * line_load / (np.pi * MODULUS)
    half_width = np.sqrt(2.0 * closes / found.curvature.item())
    approach = found.gap.item() + closes * (np.log(2.0 * FAR / half_width) + 0.5)
    assert approach == pytest.approx(exact.approach, abs=0.06 * closes)
    assert found.profile.item() == pytest.approx(max(exact.centre, EDGE), abs=0.06)
    more, less = (solved_evenly(grid, wear, factor * line_load).approach for factor in (1.02, 0.98))
    rate = (more - less) / (0.04 * closes)
    assert np.log(2.0 * FAR / half_width) == pytest.approx(rate, rel=0.04)


def half_widths(lines, grid: FlankGrid, wear: np.ndarray, loads: np.ndarray, *, smooth: bool) -> np.ndarray:
    found = [touched_by(lines, grid, wear, load, smooth=smooth).curvature.item() for load in loads]
    return np.sqrt(4.0 * loads / (np.pi * MODULUS) / np.array(found))


def test_a_smooth_half_width_is_that_of_hertz_at_every_load():
    lines, grid, wear = groove(-8e-3)
    lines = replace(lines, low=lines.low - 6.0)
    loads = np.linspace(100.0, 200.0, 101)
    hertz = np.sqrt(4.0 * loads / (np.pi * MODULUS * CURVATURE))
    steps, smooth = (half_widths(lines, grid, 0.0 * wear, loads, smooth=which) / hertz for which in (False, True))
    assert np.abs(np.diff(steps)).max() > 0.015  # by a cell
    assert np.abs(np.diff(smooth)).max() < 3e-3
    np.testing.assert_allclose(smooth, 1.0, atol=5e-3)


@pytest.mark.parametrize("deep", [-2e-3, 0.0, 2e-3, 20e-3])
def test_smooth_half_widths_of_edge_and_valley(deep):
    """They follow the load without the jumps of those in steps of a cell, and differ from them by no more."""
    loads = np.linspace(150.0, 200.0, 51)
    steps, smooth = (half_widths(*groove(deep), loads, smooth=which) for which in (False, True))
    jumps, left = (np.abs(np.diff(np.log(found), n=2)).max() for found in (steps, smooth))
    assert left < 0.2 * jumps
    np.testing.assert_allclose(smooth, steps, rtol=1.5 * jumps)


def test_the_cases_reach_from_the_valley_alone_to_the_edge_alone():
    shares = [solved_evenly(*groove(deep)[1:], 200.0).share for deep in (-8e-3, 0.0, 20e-3)]
    assert shares[0] == 0.0 and 0.3 < shares[1] < 0.7 and shares[2] == pytest.approx(1.0)


@pytest.mark.parametrize("line_load", [100.0, 300.0])
def test_shares_of_edge_and_valley(line_load):
    """Two Hertz contacts in one half-plane, against every cell of both."""
    closes = 2.0 * line_load / (np.pi * MODULUS)
    found, exact = [], []
    for deep in np.linspace(-6.0, 8.0, 8) * closes:
        lines, grid, wear = groove(float(deep))
        u, g = np.empty((2, most_places(grid.profile)))
        terms = lines.separation[:, 0, 0]
        gap = SliceGap(0.0, EDGE, 8.0, terms, 1.0, RADIUS, 0.0, wear[0], grid.profile[0], 1600)
        count = outline(gap, EDGE, 0.9, 3e-3, u, g)
        edge, share, apart = shared(u, g, count, EDGE, 8.0, 1.0, 3e-3, closes, *first())
        assert edge == -1 and apart == 1.0
        found.append(share)
        exact.append(solved_evenly(grid, wear, line_load).share)
    np.testing.assert_allclose(found, exact, atol=0.1)
    assert np.all(np.diff(found) >= 0.0)


def test_no_edge_no_share():
    u, g = np.linspace(-1.0, 1.0, 41), np.linspace(-1.0, 1.0, 41) ** 2
    assert shared(u, g, 41, -1.0, 1.0, 1.0, 1e-3, 1e-3, *first()) == (0, 0.0, 0.0)
    assert shared(u, g, 41, -2.0, 2.0, 1.0, 1e-3, 0.0, *first())[2] == 0.0


def test_the_upper_edge_mirrors_the_lower():
    u = np.linspace(-3.0, 0.5, 701)
    g = 0.1 + 1e-3 * np.minimum(50.0 * (u + 2.6) ** 2, 50.0 * u**2 + 0.5)
    lower = shared(u, g, u.size, -2.5, 9.0, 1.0, 1e-3, 1e-3, *first())
    upper = shared(-u[::-1], g[::-1].copy(), u.size, -9.0, 2.5, 1.0, 1e-3, 1e-3, *first())
    assert lower[0] == -1 and upper[0] == 1
    assert 0.5 < lower[1] < 1.0
    assert upper[1:] == pytest.approx(lower[1:], rel=1e-9)


def test_what_nothing_closes_takes_no_part_in_the_share_of_an_edge():
    """A far hollow behind a high ridge, though the gap falls most there, and another edge."""
    u = np.linspace(-3.0, 9.5, 2501)
    near = 0.1 + 1e-3 * np.minimum(50.0 * (u + 2.6) ** 2, 50.0 * u**2 + 0.5)
    far = np.where(u > 3.0, 0.2 + 0.1 * np.abs(u - 7.0), near)
    share = shared(u, near, np.searchsorted(u, 3.0), -2.5, 12.0, 1.0, 1e-3, 1e-3, *first())
    assert 0.5 < share[1] < 1.0
    assert shared(u, far, u.size, -2.5, 12.0, 1.0, 1e-3, 1e-3, *first()) == share
    assert shared(u, far, u.size, -2.5, 9.0, 1.0, 1e-3, 1e-3, *first()) == share
    edge, *others = shared(-u[::-1], far[::-1].copy(), u.size, -9.0, 2.5, 1.0, 1e-3, 1e-3, *first())
    assert edge == 1
    assert others == pytest.approx(share[1:], rel=1e-9)


def test_the_ridge_beside_an_edge_moves_on_evenly():
    """From one point of the outline to the next, whose gaps differ by a rounding error when it passes."""
    u, places = np.linspace(-3.0, 3.0, 61), np.linspace(-1.2, -1.0, 41)
    found = np.empty((places.size, u.size))
    for side, place in zip(found, places, strict=True):
        waves = 1.0 + np.cos(np.pi * np.clip((u - place) / 1.6, -1.0, 1.0))
        g = 0.1 + 1e-3 * (waves + np.maximum(np.abs(u - place) - 1.6, 0.0) ** 2)
        sides = np.empty((2, u.size))
        assert share_of_edge(u, g, u.size, -2.5, 9.0, 1.0, 1e-3, 1e-3, *first(), sides)[0] == -1
        side[:] = sides[0]
        assert (np.diff(side) <= 0.0).all() and side[0] == 1.0 and side[-1] == 0.0
    assert np.abs(np.diff(found, axis=0)).max() < 0.1
    ridge = u[0] + 0.1 * (found.sum(axis=1) - 0.5)  # of a step from 1 to 0
    np.testing.assert_allclose(ridge, places, atol=0.05)  # of 0.1 between points


BETWEEN = [-3.0, -2.6, -1.6, -1.0, -0.4, 0.4, 1.0, 1.8, 4.0]


def between_ridges(gaps: list[float]) -> tuple[float, float, np.ndarray]:
    """Share, how far apart and side of an edge where the gap goes by straight lines [um] between some places."""
    u, sides = np.linspace(-3.0, 4.0, 701), np.zeros((2, 701))
    g = 0.1 + 1e-3 * np.interp(u, BETWEEN, gaps)
    edge, share, apart = share_of_edge(u, g, u.size, -2.5, 9.0, 1.0, 1e-3, 1e-3, *first(), sides)
    assert edge == -1 and 0.2 < share < 0.9
    return share, apart, sides[0]


@pytest.mark.parametrize(
    ("gaps", "changed"),
    [
        ([1.5, 0.4, 1.2, 0.6, 1.2, 0.1, 0.7, 0.1, 9.0], 2),  # two ridges of a height
        ([1.5, 0.4, 1.2, 0.6, 1.2, 0.1, 0.7, 0.1, 9.0], 7),  # two valleys of a gap
        ([1.5, 0.4, 0.9, 0.2, 1.2, 0.5, 0.7, 0.6, 9.0], 5),  # two valleys with ridges as high over each
        ([1.5, 0.4, 0.9, 0.5, 1.2, 0.7, 0.8, 0.8, 9.0], 3),  # one that comes up before another one
        ([1.5, 0.4, 1.0, 0.5, 1.0, 0.55, 0.8, 0.8, 9.0], 4),  # one beyond a ridge as high as the first
        ([1.5, 0.4, 1.0, 0.1, 0.8, 0.2, 0.9, 0.8, 9.0], 4),  # one beyond a ridge that divides no more
    ],
)
def test_nothing_jumps_where_another_ridge_or_valley_counts(gaps, changed):
    """Beside an edge that presses, of two that are as high or as low but for a rounding error."""
    found = []
    for sign in (-1.0, 1.0):
        moved = list(gaps)
        moved[changed] += 1e-6 * sign
        found.append(between_ridges(moved))
    for low, high in zip(*found, strict=True):
        np.testing.assert_allclose(low, high, atol=1e-4)


def test_what_lies_between_two_ridges_belongs_to_edge_and_valley():
    side = between_ridges([1.5, 0.4, 1.2, 0.6, 1.2, 0.1, 0.7, 0.1, 9.0])[2]
    assert side[200] == pytest.approx(0.5, abs=1e-9)
    assert side[0] == side[80] == 1.0 and (side[300:] == 0.0).all()


def shares_over_cycles(edge_wears: float, valley_wears: float, cycles: int, *, known: bool = True) -> np.ndarray:
    """Shares of an edge that wears by so much [mm] in a cycle under all of the load, as the valley does."""
    u = np.linspace(-3.0, 3.0, 601)
    g = 0.1 + 1e-3 * np.minimum(30.0 * (u + 2.6) ** 2 + 0.5, 30.0 * u**2)
    edge = u < u[200:300][np.argmax(g[200:300])]
    (before, most), found = first(), []
    for _ in range(cycles):
        _, share, apart = shared(u, g, u.size, -2.5, 9.0, 1.0, 1e-3, 1e-3, before, most)
        assert apart == 1.0
        found.append(share)
        g += np.where(edge, share * edge_wears, (1.0 - share) * valley_wears)
        most = max(edge_wears, valley_wears)
        if not known:
            before[:] = 0.0
    return np.array(found)


@pytest.mark.parametrize("even", [0.0, 0.3])
@pytest.mark.parametrize("wears", [0.5e-3, 3e-3, 12e-3])
def test_shares_of_edge_and_valley_settle_over_cycles_that_wear_much(wears, even):
    """However many times what contact closes, until both wear by as much."""
    found = shares_over_cycles((1.0 + even) * wears, wears, 40)
    assert np.abs(np.diff(found[-10:])).max() < 2e-3
    assert found[-1] == pytest.approx(1.0 / (2.0 + even), abs=5e-3)


def test_shares_found_from_the_gap_alone_swing_over_cycles_that_wear_much():
    assert np.abs(np.diff(shares_over_cycles(12e-3, 12e-3, 8, known=False)[-3:])).min() > 0.9


def share_after(first_gap: np.ndarray) -> float:
    """Share of an edge in a cycle whose gap is the same whatever it was in the cycle before."""
    u = np.linspace(-3.0, 3.0, 601)
    g = 0.1 + 1e-3 * np.minimum(30.0 * (u + 2.6) ** 2 + 0.5, 30.0 * u**2)
    before, most = first()
    shared(u, first_gap, u.size, -2.5, 9.0, 1.0, 1e-3, 1e-3, before, most)
    return shared(u, g, u.size, -2.5, 9.0, 1.0, 1e-3, 1e-3, before, 3e-3)[1]


def test_an_edge_that_comes_to_press_is_foreseen_by_and_by():
    """Whether a ridge just stood beside it in the cycle before, or just not."""
    u = np.linspace(-3.0, 3.0, 601)
    slope = 0.1 + 2e-3 * np.abs(u + 2.6)
    heights = np.linspace(0.6e-3, 2.6e-3, 201)
    found = np.array([share_after(slope - height * np.exp(-(((u - 0.5) / 0.4) ** 2))) for height in heights])
    assert np.abs(np.diff(found)).max() < 5e-4 < 0.01 < np.ptp(found)


def test_a_share_that_is_known_and_stays_is_not_changed_by_foresight():
    u = np.linspace(-3.0, 3.0, 601)
    g = 0.1 + 1e-3 * np.minimum(8.0 * (u + 2.6) ** 2 + 0.3, 8.0 * u**2)
    (before, most), settled = first(), []
    for _ in range(200):
        settled.append(shared(u, g, u.size, -2.5, 9.0, 1.0, 1e-3, 1e-3, before, most)[1])
        most = 3e-3
    assert 0.2 < settled[0] < 0.8
    np.testing.assert_allclose(settled, settled[0], rtol=1e-12)


def test_an_outline_holds_every_node_of_a_fine_flank():
    nodes = np.linspace(-3.0, 5.0, 3001)
    u, g = np.empty((2, most_places(nodes[None])))
    wear = np.where(nodes < 0.0, 0.1, 0.0)
    gap = SliceGap(0.0, -3.0, 5.0, np.zeros(5), 1.0, RADIUS, RADIUS, wear, nodes, 1600)
    count = outline(gap, -3.0, 5.0, 3e-3, u, g)
    inside = (u[:count] >= -3.0) & (u[:count] <= 5.0)
    np.testing.assert_array_equal(u[:count][inside], nodes)
    np.testing.assert_array_equal(g[:count][inside], wear)


@pytest.mark.parametrize("radii", [(0.02, 0.0), (0.0, 0.02), (0.02, 0.4), (0.0, 0.0)])
def test_an_outline_has_an_arc_where_an_edge_is_rounded(radii):
    """However small the radius; beyond a sharp edge there is nothing."""
    nodes = np.linspace(-3.0, 5.0, 81)
    u, g = np.empty((2, most_places(nodes[None])))
    gap = SliceGap(0.0, -3.0, 5.0, np.zeros(5), 1.0, *radii, np.zeros(81), nodes, 40)
    count = outline(gap, -3.0, 5.0, 3e-3, u, g)
    for radius, beyond in zip(radii, (-3.0 - u[:count], u[:count] - 5.0), strict=True):
        arc = beyond > 0.0
        assert arc.any() == (radius > 0.0)
        # the arc is tangent to the flank at the border: x^2/(2 rho) near it
        expected = radius - np.sqrt(np.maximum(radius**2 - beyond[arc] ** 2, 0.0)) if radius else 0.0
        np.testing.assert_allclose(g[:count][arc], expected, atol=1e-12)
