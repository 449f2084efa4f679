"""Roll positions: which tooth pairs are followed, and given positions."""

import numpy as np
import pytest

from semiwear.errors import SceneError
from semiwear.meshing import roll_grid
from semiwear.meshing.pairs import flank_pair
from semiwear.meshing.roll_grid import RollGrid, even_roll_grid, given_roll_grid, pairs_that_can_touch
from semiwear.scene import Placement


@pytest.fixture
def followed(shipped, monkeypatch):
    """Pairs followed where the flanks are near between two roll positions."""
    pair = flank_pair(shipped.gear_pair, Placement())

    def found(first: float, last: float) -> tuple[float, int]:
        roll = np.linspace(-4.0, 4.0, 161)
        apart = np.where((roll >= first - 1e-9) & (roll <= last + 1e-9), 0.0, 1.0)
        monkeypatch.setattr(roll_grid, "separation_of_neighbours", lambda *_: (roll, apart, np.zeros(161)))
        return pairs_that_can_touch(pair, 0.5)

    return found


@pytest.fixture
def followed_apart(shipped, monkeypatch):
    """Pairs followed where the nearest flanks are apart by some distance, and others by 1 mm more."""
    pair = flank_pair(shipped.gear_pair, Placement())

    def found(least: float) -> tuple[float, int]:
        roll = np.linspace(-4.0, 4.0, 161)
        apart = least + np.where(np.abs(roll + 0.15) < 1.1, 0.0, 1.0)
        monkeypatch.setattr(roll_grid, "separation_of_neighbours", lambda *_: (roll, apart, np.full(161, least)))
        return pairs_that_can_touch(pair, 0.3)

    return found


@pytest.mark.parametrize(
    ("first", "last", "start", "pairs"),
    [(-1.2, 0.9, -2.0, 3), (-0.5, 0.5, -1.0, 2), (0.1, 0.2, 0.0, 1), (-1.0, 1.0, -1.0, 3), (-2.95, 2.95, -3.0, 6)],
)
def test_every_base_pitch_in_which_flanks_are_near_is_followed(followed, first, last, start, pairs):
    assert followed(first, last) == (start, pairs)


@pytest.mark.parametrize(("first", "last"), [(-4.0, 0.5), (-0.5, 4.0), (-4.0, 4.0)])
def test_flanks_that_are_near_as_far_as_is_looked_are_an_error(followed, first, last):
    with pytest.raises(SceneError, match="base pitches from the pitch point"):
        followed(first, last)


def test_given_positions_are_taken_modulo_one():
    grid = given_roll_grid(-1.0, 2, np.array([0.25]))
    assert grid.phase.tolist() == [0.25]
    assert given_roll_grid(-1.0, 2, np.array([1.25, -0.5, 0.25])).phase.tolist() == [0.25, 0.5]


@pytest.mark.parametrize("wanted", [[], [0.1, np.nan], [np.inf]])
def test_positions_that_are_none_are_an_error(wanted):
    with pytest.raises(SceneError, match="finite numbers, one at least"):
        given_roll_grid(-1.0, 2, np.array(wanted))


def test_given_positions_that_are_the_same_but_for_rounding_are_solved_once():
    grid = given_roll_grid(-1.0, 2, np.array([0.25, 1.25, -0.75, 3.0 - 1e-15, 1.0]))
    assert grid.phase.tolist() == [0.0, 0.25]


def test_an_even_grid_follows_one_pair_after_another():
    """Three positions and seven at least for wear: two pairs, by whole steps of a base pitch."""
    grid = even_roll_grid(-1.0, 2, 3, 7)
    thirds, ninths = np.arange(3) / 3, np.arange(9) / 9
    np.testing.assert_allclose(grid.roll, [*(thirds - 1.0), *thirds])
    np.testing.assert_allclose(grid.fine_roll, [*(ninths - 1.0), *ninths])
    np.testing.assert_allclose(grid.mesh_position, thirds)
    np.testing.assert_array_equal(even_roll_grid(-1.0, 2, 3, 3).fine_roll, even_roll_grid(-1.0, 2, 3, 3).roll)


def test_pairs_are_near_beside_the_nearest_one(followed_apart):
    """Flanks that are all apart by the same, as misplaced ones are, are followed as those that touch."""
    assert followed_apart(0.0) == followed_apart(0.4) == (-2.0, 3)


def test_mesh_positions_just_below_a_whole_number_are_that_number():
    assert RollGrid(0.5, 1, np.array([0.5 - 1e-13, 0.75])).mesh_position.tolist() == [0.0, 0.25]
