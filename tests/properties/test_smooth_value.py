"""Wear between the nodes of a slice: smooth where nodes are, and nowhere higher than a groove leaves the flank."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from semiwear.meshing.flank_grid import locate, locate_all, slope_at, slopes_between, smooth_value

DEPTHS = arrays(float, st.integers(2, 12), elements=st.floats(0.0, 2.0, allow_subnormal=False))
PLACES = np.linspace(0.0, 1.0, 21)


def between(values: np.ndarray) -> np.ndarray:
    """Values in all cells of even nodes, (cell, place)."""
    nodes, last = np.arange(float(values.size)), values.size - 1
    return np.array([[smooth_value(values, nodes, last, cell, x) for x in PLACES] for cell in range(last)])


@given(DEPTHS)
def test_nodes_keep_their_values(values: np.ndarray) -> None:
    found = between(values)
    np.testing.assert_array_equal(found[:, 0], values[:-1])
    np.testing.assert_allclose(found[:, -1], values[1:], atol=1e-15)


@given(DEPTHS)
def test_a_row_that_rises_rises_between_its_nodes(values: np.ndarray) -> None:
    values = np.sort(values)
    assert (np.diff(between(values), axis=1) > -1e-15).all()


@given(DEPTHS, st.integers(0, 10), st.integers(0, 10), st.floats(0.0, 2.0))
def test_what_lies_beside_a_groove_stays_level(depths: np.ndarray, before: int, after: int, level: float) -> None:
    values = np.concatenate([np.full(2 + before, level), level + depths, np.full(2 + after, level)])
    found = between(values)
    np.testing.assert_array_equal(found[: 1 + before], level)
    np.testing.assert_array_equal(found[found.shape[0] - 1 - after :], level)


@given(DEPTHS)
def test_between_nodes_it_leaves_them_by_less_than_their_bends(values: np.ndarray) -> None:
    """An extremum between nodes is as far beyond them as that of a parabola with a bend like one of both nodes'."""
    straight = np.concatenate([[2 * values[0] - values[1]], values, [2 * values[-1] - values[-2]]])
    bend = np.abs(np.diff(straight, 2))
    beyond = np.maximum(bend[:-1], bend[1:])[:, None] / 8.0
    low, high = np.minimum(values[:-1], values[1:])[:, None], np.maximum(values[:-1], values[1:])[:, None]
    found = between(values)
    assert (found >= low - beyond - 1e-15).all()
    assert (found <= high + beyond + 1e-15).all()


@given(DEPTHS)
def test_a_row_and_its_mirror_image_agree(values: np.ndarray) -> None:
    np.testing.assert_allclose(between(values[::-1].copy()), between(values)[::-1, ::-1], atol=1e-15)


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-0.1, 0.1))
def test_a_parabola_comes_again_with_its_top(level: float, slope: float, bend: float) -> None:
    u = np.arange(12.0) - 5.5
    values = level + slope * u + bend * u**2
    places = u[:-1, None] + PLACES
    expected = level + slope * places + bend * places**2
    np.testing.assert_allclose(between(values)[3:-3], expected[3:-3], atol=1e-12)


@given(st.floats(0.0, 1.0), st.floats(0.2, 3.0))
def test_a_ridge_of_a_few_cells_keeps_the_slopes_of_its_parabolas(aside: float, width: float) -> None:
    """A hyperbola, anywhere between nodes: nothing is cut off at its top, nor where it begins to bend."""
    values = np.hypot(np.arange(14.0) - 6.0 - aside, width)
    slopes = 0.5 * (values[2:] - values[:-2])
    x, rise = PLACES, np.diff(values)[1:-1, None]
    low, high = slopes[:-1, None] - rise, rise - slopes[1:, None]
    expected = values[1:-2, None] + rise * x + x * (1.0 - x) * ((1.0 - x) * low + x * high)
    np.testing.assert_allclose(between(values)[2:-2], expected[1:-1], atol=1e-12)


def test_refining_smooth_wear_converges_with_the_third_order() -> None:
    """Also at its extrema, where limits on slopes often keep the second."""
    errors = []
    for nodes in (41, 81, 161, 321):
        u = np.linspace(0.0, 2.0, nodes)
        place = u[:-1, None] + PLACES * (u[1] - u[0])
        error = np.abs(between(np.cos(7.0 * u)) - np.cos(7.0 * place))
        errors.append(error[2:-2].max())
    assert (np.diff(np.log2(errors)) < -2.8).all()


@given(st.data())
def test_slopes_and_cells_of_many_are_those_of_one(data):
    points = data.draw(st.integers(6, 30))
    split = data.draw(st.one_of(st.integers(2, points - 3), st.just(points - 1)))
    widths = np.where(np.arange(points - 1) < split, data.draw(st.floats(0.1, 2.0)), data.draw(st.floats(0.1, 2.0)))
    nodes = np.concatenate([[0.0], np.cumsum(widths)])
    values = np.array(data.draw(st.lists(st.floats(-1.0, 1.0), min_size=points, max_size=points)))
    first, end = sorted(data.draw(st.tuples(st.integers(0, points), st.integers(0, points))))
    slopes = np.full(points, np.inf)
    slopes_between(values, nodes, split, first, end, slopes)
    expected = [slope_at(values, nodes, split, n) for n in range(first, end)]
    assert slopes[first:end].tolist() == expected
    assert np.isinf(slopes[:first]).all()
    assert np.isinf(slopes[end:]).all()
    between = data.draw(st.lists(st.floats(-1.0, nodes[-1] + 1.0), max_size=20))
    places = np.concatenate([nodes, between])
    cells, parts = np.empty(places.size, dtype=np.int64), places.copy()
    locate_all(nodes, split, parts, cells)
    assert list(zip(cells.tolist(), parts.tolist(), strict=True)) == [locate(nodes, split, p) for p in places]
