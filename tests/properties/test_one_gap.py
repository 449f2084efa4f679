"""One gap: footprints, pressures across slices and patches see the same worn flank between nodes and on its edges."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from semiwear.contact import patch_gap, slice_pressure
from semiwear.contact.footprint import depth_of, reach_space, reached
from semiwear.contact.gap import FlankGap, SliceGap
from semiwear.meshing.finer_grid import finer_grid
from semiwear.meshing.flank_grid import FlankGrid, first_from, locate, smooth_value

SPLIT, RADIUS, LOW, HIGH, HALF_WIDTH = 10, 0.4, -2.9, 2.8, 0.5
NODES = np.concatenate([np.linspace(-3.0, -0.2, SPLIT + 1), np.linspace(-0.2, 3.0, 15)[1:]])
DEPTHS = arrays(float, NODES.size, elements=st.floats(0.0, 0.02, allow_subnormal=False))
PLACES = st.floats(-2.9, 2.8)


def gap(place: np.ndarray, at: float, bend: float, depth: np.ndarray) -> np.ndarray:
    """A parabola, tangents that fall away along arcs beyond both ends, and what is gone."""
    inside = np.clip(place, LOW, HIGH)
    beyond = np.abs(place - inside)
    tangent = 0.5 * bend * (inside - at) ** 2 + bend * (inside - at) * (place - inside)
    gone = [smooth_value(depth, NODES, SPLIT, *locate(NODES, SPLIT, p)) for p in place]
    return tangent + RADIUS - np.sqrt(RADIUS**2 - beyond**2) + np.array(gone)


def by_footprint(at: float, bend: float, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    space, terms = reach_space(NODES[None]), np.array([0.0, 0.0, bend, 0.0, 0.0])
    slice_ = SliceGap(at, LOW, HIGH, terms, 1.0, RADIUS, RADIUS, depth, NODES, SPLIT)
    _, count, _ = reached(slice_, HALF_WIDTH, space)
    return space.u[:count], space.g[:count]


def by_pressure(at: float, bend: float, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    place, width, found = np.empty(96), np.empty(96), np.empty(96)
    ends = np.array([LOW - 0.9 * RADIUS, HIGH + 0.9 * RADIUS])
    terms = np.array([0.0, 0.0, bend, 0.0, 0.0])
    slice_ = SliceGap(at, LOW, HIGH, terms, 1.0, RADIUS, RADIUS, depth, NODES, SPLIT)
    n = slice_pressure._cells(slice_, 1, ends[:1], ends[1:], place, width, found)
    return place[:n], found[:n]


def by_patch(at: float, bend: float, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    columns, width = 160, 0.1
    one, found = np.ones((1, 1)), np.full((1, columns), np.inf)
    flank = FlankGap(
        at * one, LOW * one, HIGH * one, np.array([0.0, 0.0, bend, 0.0, 0.0])[:, None, None] * one, one,
        RADIUS * one, RADIUS * one, depth[None, None], np.array([0]), NODES[None], np.array([SPLIT]),
    )  # fmt: skip
    patch_gap._gaps(np.array([0]), np.array([0]), 1e3, columns, width, flank, found)
    place = at + (np.arange(columns) - 0.5 * (columns - 1)) * width
    met = np.isfinite(found[0])
    return place[met], found[0, met]


@pytest.mark.slow
@given(DEPTHS, PLACES, st.floats(1e-3, 0.1))
def test_all_kernels_see_one_gap(depth: np.ndarray, at: float, bend: float) -> None:
    for kernel in (by_footprint, by_pressure, by_patch):
        place, found = kernel(at, bend, depth)
        assert place.size > 2
        inside = np.abs(place - np.clip(place, LOW, HIGH)) < RADIUS
        np.testing.assert_allclose(found[inside], gap(place[inside], at, bend, depth), atol=1e-12)


@given(DEPTHS, st.floats(-0.8, 0.8), st.floats(0.01, 0.08))
def test_an_outline_holds_all_that_a_footprint_can_close(depth: np.ndarray, at: float, bend: float) -> None:
    place = np.linspace(LOW, HIGH, 4001)
    fine = gap(place, at, bend, depth)
    closed = place[fine < fine.min() + depth_of(bend, HALF_WIDTH)]
    outline, _ = by_footprint(at, bend, depth)
    assert outline[0] <= closed[0] and closed[-1] <= outline[-1]


@given(st.floats(-0.01, 0.01), st.floats(0.0, 1.0))
def test_a_straight_depth_stays_straight_where_the_spacing_changes(slope: float, level: float) -> None:
    depth = level + slope * NODES
    for place in np.linspace(NODES[0], NODES[-1], 97):
        assert abs(smooth_value(depth, NODES, SPLIT, *locate(NODES, SPLIT, place)) - level - slope * place) < 1e-14


@given(DEPTHS, st.integers(1, 3), st.sampled_from([0.0, 0.2, 0.35]))
def test_finer_nodes_read_the_driven_flank_alike(depth: np.ndarray, parts: int, beyond: float) -> None:
    """In every slice, evenly on beyond its tip; in one part and no farther they are the nodes themselves."""
    rows = np.stack([NODES, 0.8 * NODES - 0.1])
    finer = finer_grid(FlankGrid(np.array([-1.0, 1.0]), rows, np.array([SPLIT, SPLIT])), parts, beyond)
    found = finer.from_grid(np.stack([depth, 2.0 * depth]))
    for nodes, values, fine, split, read in zip(
        rows, (depth, 2.0 * depth), finer.profile, finer.split, found, strict=True
    ):
        tip = nodes[-1]
        inside = np.minimum(fine, tip)
        expected = [smooth_value(values, nodes, SPLIT, *locate(nodes, SPLIT, place)) for place in inside]
        np.testing.assert_allclose(read, expected, atol=1e-13)
        assert fine[-1] - tip >= beyond - 1e-12 and np.all(np.diff(fine) > 0.0)
        for place in np.linspace(fine[0], fine[-1], 97):
            cell, x = locate(fine, split, place)
            assert abs(fine[cell] + x * (fine[cell + 1] - fine[cell]) - place) < 1e-12
    if parts == 1 and beyond == 0.0:
        np.testing.assert_array_equal(finer.profile, rows)
        np.testing.assert_array_equal(finer.split, SPLIT)


@given(arrays(float, st.integers(0, 12), elements=st.integers(-4, 4)), st.integers(-5, 5))
def test_first_node_from_a_place_is_the_one_that_numpy_finds(numbers, place):
    rising = np.sort(numbers)
    assert first_from(rising, float(place)) == np.searchsorted(rising, place)
