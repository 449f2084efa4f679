"""Roll positions: which tooth pairs are followed, and given positions."""

from __future__ import annotations

import numpy as np
import pytest

from semiwear.errors import SceneError
from semiwear.meshing import roll_grid
from semiwear.meshing.pairs import flank_pair
from semiwear.meshing.roll_grid import given_roll_grid, pairs_that_can_touch
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
