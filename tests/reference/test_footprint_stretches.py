"""A footprint is cut into stretches on which the gap is straight: areas, moments, and removed material in between."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from semiwear.contact.fine_row import MOST_PARTS, fill_row, fine_row, forget_row, parts_of_cells
from semiwear.contact.footprint import segment
from semiwear.contact.gap import SliceGap
from semiwear.meshing.flank_grid import locate, smooth_value
from semiwear.wear import deposit

SPLIT = 10
NODES = np.concatenate([np.linspace(-3.0, -0.2, SPLIT + 1), np.linspace(-0.2, 3.0, 15)[1:]])
ROOTS = st.floats(0.0, 0.1)


@given(st.floats(0.01, 1.0), ROOTS, st.floats(1e-3, 0.1))
def test_integrals_of_a_stretch(width, t_a, t_b):
    a, b = t_a * t_a, t_b * t_b
    of = [quad(lambda x, n=n: (a + (b - a) * x) ** n, 0.0, 1.0, epsabs=1e-15)[0] for n in (0.5, 1.5)]
    assert segment(width, t_a, t_b) == pytest.approx((width * of[0], width * of[1]), rel=1e-6)
    assert segment(width, t_b, t_a) == pytest.approx(segment(width, t_a, t_b), rel=1e-12)


def test_nothing_touches_where_the_gap_is_open():
    assert segment(0.3, 0.0, 0.0) == (0.0, 0.0)


DEPTH = 1.2e-3
GAPS = st.lists(st.floats(0.0, 2e-3), min_size=2, max_size=12)


def outlined(gaps: list[float]) -> tuple[np.ndarray, np.ndarray, deposit.Pieces]:
    """An outline of these gaps, and memory that holds it."""
    space = deposit.piece_space(np.stack([NODES, NODES]))
    g = np.array(gaps)
    u = np.linspace(0.0, 0.1 * g.size, g.size)
    space.reach.u[: u.size], space.reach.g[: g.size] = u, g
    return u, g, space


def moments(u: np.ndarray, g: np.ndarray, least: float, parts: np.ndarray) -> list[float]:
    """Integrals of the density and of its moment, of which a part counts in every cell."""

    def density(x: float, power: int) -> float:
        return float(np.sqrt(max(DEPTH - np.interp(x, u, g) + least, 0.0)) * x**power)

    return [
        sum(
            part * quad(density, *cell, args=(power,), limit=200, epsabs=1e-14)[0]
            for part, cell in zip(parts, pairwise(u), strict=True)
        )
        for power in (0, 1)
    ]


@given(GAPS, st.floats(0.1, 1.0))
def test_stretches_share_a_footprint_by_their_areas_and_lie_at_their_centroids(gaps, share):
    u, g, space = outlined(gaps)
    pieces = deposit._add_pieces(g.size, g.min(), DEPTH, share, space, 0)
    mass, middle, ends = space.mass, space.middle, space.ends[:pieces]
    rounding = 1e-12  # a stretch may be no longer than that
    assert np.all(ends[:, 0] <= middle[:pieces] + rounding) and np.all(middle[:pieces] <= ends[:, 1] + rounding)
    assert mass[:pieces].sum() == pytest.approx(share, rel=1e-12)
    assert np.all(np.diff(middle[:pieces]) > 0.0)
    area, moment = moments(u, g, g.min(), np.ones(g.size - 1))
    assert mass[:pieces] @ middle[:pieces] == pytest.approx(share * moment / area, rel=1e-5)


@given(GAPS, st.lists(st.sampled_from([0.0, 0.3, 1.0]), min_size=12, max_size=12), st.booleans())
def test_one_side_of_a_ridge_has_its_part_of_every_stretch(gaps, sides, upper):
    """What belongs to it in part is its lowest point only where it lies lower by what such a point is lifted."""
    u, g, space = outlined(gaps)
    side = np.array(sides[: g.size])
    side[np.argmin(g)] = 1.0
    pieces = deposit._add_side(g.size, side, 2, upper, 1.0, DEPTH, 0.4, space, 0)
    mass, middle = space.mass[:pieces], space.middle[:pieces]
    parts = 0.5 * (side[1:] + side[:-1])
    area, moment = moments(u, g, g.min(), parts)
    assert mass.sum() == pytest.approx(0.4, rel=1e-12)
    assert mass @ middle == pytest.approx(0.4 * moment / area, rel=1e-5)
    assert (space.at_edge[:pieces] == 2).all()
    widths, cells = np.diff(space.ends[:pieces])[:, 0], np.searchsorted(u, middle) - 1
    assert (widths <= parts[cells] * 0.1 * g.size / (g.size - 1) + 1e-12).all()


def test_stretches_end_where_the_gap_is_no_longer_closed():
    """A gap of straight lines, closed from 0.1 + 0.05 to 0.4 - 0.05 mm."""
    _, g, space = outlined([2e-3, 2e-3, 0.4e-3, 0.4e-3, 2e-3])
    u = space.reach.u[: g.size]
    count = deposit._add_pieces(g.size, g.min(), DEPTH, 1.0, space, 0)
    count = deposit._add_side(g.size, np.ones(g.size), 2, False, 1.0, DEPTH, 1.0, space, count)
    closed = DEPTH / 1.6e-3
    ends = [[u[2] - closed * (u[2] - u[1]), u[2]], [u[2], u[3]], [u[3], u[3] + closed * (u[4] - u[3])]]
    np.testing.assert_allclose(space.ends[:count], 2 * ends, atol=1e-12)


@pytest.mark.parametrize(("lift", "least"), [(0.5e-3, 0.4e-3), (1e-3, 0.6e-3)])
def test_a_point_that_belongs_to_a_side_in_part_counts_as_higher(lift, least):
    """Its gap of 0.1 um is raised by 0.6 of the lift, above or below the 0.6 um of a point that belongs to it all."""
    u, g, space = outlined([0.6e-3, 0.9e-3, 0.1e-3, 1e-3, 1.1e-3])
    side = np.array([1.0, 1.0, 0.4, 0.0, 0.0])
    count = deposit._add_side(g.size, side, -1, False, lift, DEPTH, 1.0, space, 0)
    area, moment = moments(u, g, least, 0.5 * (side[1:] + side[:-1]))
    assert space.mass[:count] @ space.middle[:count] == pytest.approx(moment / area, rel=1e-5)


@given(st.lists(st.floats(0.0, 0.02), min_size=NODES.size, max_size=NODES.size), st.integers(1, 6))
def test_a_finer_row_is_the_flank_between_its_nodes(depths, parts):
    removed, row = np.array(depths), fine_row(NODES.size)
    gap = SliceGap(0.0, NODES[0], NODES[-1], np.zeros(5), 1.0, 0.0, 0.0, removed, NODES, SPLIT)
    # grows to either side, and begins anew where nothing near is known
    for first, end in ((8, 12), (11, 15), (4, 9), (20, 24), (0, 3)):
        fill_row(row, gap, parts, first, end)
        place = row.place[first * parts : end * parts + 1]
        np.testing.assert_allclose(
            place, np.interp(np.arange(first * parts, end * parts + 1) / parts, np.arange(25), NODES)
        )
        expected = [smooth_value(removed, NODES, SPLIT, *locate(NODES, SPLIT, p)) for p in place]
        np.testing.assert_allclose(row.removed[first * parts : end * parts + 1], expected, atol=1e-12)
    forget_row(row)
    assert not row.known.any()


@pytest.mark.parametrize("longest", [1.0, 0.2, 0.13, 0.05, 0.02, 1e-6])
def test_parts_of_cells_are_short_and_few(longest):
    width = max(NODES[1] - NODES[0], NODES[-1] - NODES[-2])
    parts = parts_of_cells(NODES, longest)
    assert parts == MOST_PARTS or width / parts <= longest
    assert parts <= max(1.0, 2.0 * width / longest) and parts <= MOST_PARTS
