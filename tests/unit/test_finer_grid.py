"""Where the driven flank meets the wear of the driving one: between its nodes, and beyond its tip."""

import numpy as np
import pytest

from semiwear.meshing.finer_grid import finer_grid
from semiwear.meshing.flank_grid import FlankGrid, locate

PROFILE = np.array(
    [
        np.concatenate([np.linspace(-2.0, 0.5, 11), np.linspace(0.5, 3.0, 21)[1:]]),
        np.concatenate([np.linspace(-2.5, 0.0, 11), np.linspace(0.0, 2.0, 21)[1:]]),
    ]
)
GRID = FlankGrid(np.array([-1.0, 1.0]), PROFILE, np.array([10, 10]))


@pytest.mark.parametrize("parts", [1, 2, 3])
@pytest.mark.parametrize("beyond", [0.0, 0.35])
def test_a_straight_depth_stays_straight_and_even_beyond_the_tip(parts, beyond):
    finer = finer_grid(GRID, parts, beyond)
    depth = 0.2 + 0.1 * PROFILE
    found = finer.from_grid(np.stack([depth, 2.0 * depth]))
    tip = PROFILE[:, -1:]
    expected = 0.2 + 0.1 * np.minimum(finer.profile, tip)
    np.testing.assert_allclose(found, [expected, 2.0 * expected], rtol=1e-12)
    assert np.all(finer.profile[:, -1:] - tip >= beyond - 1e-12)
    assert np.all(np.diff(finer.profile) > 0.0)


@pytest.mark.parametrize("parts", [1, 2, 3])
def test_places_are_found_on_it(parts):
    finer = finer_grid(GRID, parts, 0.35)
    for nodes, split in zip(finer.profile, finer.split, strict=True):
        for place in np.linspace(nodes[0], nodes[-1], 97):
            cell, x = locate(nodes, split, place)
            assert nodes[cell] + x * (nodes[cell + 1] - nodes[cell]) == pytest.approx(place, abs=1e-12)


def test_in_one_part_and_no_further_it_is_the_grid():
    same = finer_grid(GRID, 1, 0.0)
    np.testing.assert_array_equal(same.profile, GRID.profile)
    np.testing.assert_array_equal(same.split, GRID.split)
    np.testing.assert_array_equal(same.from_grid(PROFILE), PROFILE)
