"""A fold through designs: two planes of which the greater counts."""

from importlib import import_module

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from semiwear.optimise.designs import COARSE
from semiwear.optimise.fold import Fold, fold_near
from semiwear.optimise.search import _next, _Region, search
from tests.unit.test_optimise_search import FREE, Tried, known

module = import_module("semiwear.optimise.fold")


@given(seed=st.integers(0, 10_000), fields=st.integers(1, 4))
def test_two_planes_are_found_again(seed, fields):
    """Wherever each has as many designs as numbers."""
    draw = np.random.default_rng(seed)
    first, second = draw.normal(size=(2, 1 + fields))
    centre = np.full(fields, 0.5)
    second[0] += (first - second) @ [1.0, *centre]  # the fold goes through the centre
    inputs = draw.uniform(size=(4 * (1 + fields), fields))
    values = np.maximum(first[0] + inputs @ first[1:], second[0] + inputs @ second[1:])
    upper = (inputs - centre) @ (first - second)[1:] > 0.0
    assume(min(upper.sum(), (~upper).sum()) > fields)
    fold = fold_near(centre, inputs, values)
    assert fold is not None
    np.testing.assert_allclose(fold.at(inputs), values, atol=1e-7)


def test_too_few_designs_make_no_fold():
    inputs = np.random.default_rng(1).uniform(size=(6, 2))
    assert fold_near(np.zeros(2), inputs, inputs.sum(axis=1)) is None
    assert fold_near(np.zeros(2), np.zeros((12, 2)), np.ones(12)) is None  # all at one place: nothing parts them


def test_designs_far_away_do_not_count():
    """A dozen designs on a fold, others far from it with other values."""
    draw = np.random.default_rng(2)
    near, far = 0.4 + 0.2 * draw.uniform(size=(12, 2)), 10.0 + draw.uniform(size=(30, 2))
    inputs = np.vstack([far, near])
    values = np.abs(inputs[:, 0] - 0.5) + 0.1 * inputs[:, 1]
    values[:30] = draw.normal(size=30)
    fold = fold_near(np.array([0.5, 0.5]), inputs, values)
    assert fold is not None
    np.testing.assert_allclose(fold.at(near), values[30:], atol=1e-9)


@pytest.mark.parametrize("designs", [4, 5])
def test_a_fold_needs_more_designs_than_two_planes_have_numbers(designs):
    inputs = np.linspace(-1.0, 1.0, designs)[:, None]
    fold = fold_near(np.zeros(1), inputs, np.abs(inputs[:, 0] - 0.05))
    assert (fold is None) == (designs == 4)


def test_no_plane_goes_through_fewer_designs_than_it_has_numbers():
    """One design above the line of seven others, at its end: lines of any slope go through it."""
    x = np.arange(8.0)
    values = np.where(x == 0.0, 3.0, 10.0 * x)
    assert module._fitted(np.stack([np.ones(8), x], axis=1), values, np.ones(8), x == 0.0) is None


def test_designs_count_by_half_at_their_median_distance():
    """Left of the centre a line, right of it designs with errors: their line by weighted least squares."""
    x = np.array([-0.4, -0.3, -0.2, -0.1, 0.15, 0.3, 0.5, 0.8])
    errors = np.array([0.03, -0.05, 0.06, -0.02])
    values = np.concatenate([-x[:4], 2.0 * x[4:] + errors])
    fold = fold_near(np.array([5.0]), 5.0 + x[:, None], values)
    assert fold is not None
    weights = 1.0 / (1.0 + (x[4:] / np.median(np.abs(x))) ** 2)
    slope, level = np.polyfit(x[4:], values[4:], 1, w=np.sqrt(weights))
    rising = fold.planes[np.argmax(fold.planes[:, 1])]
    np.testing.assert_allclose(rising, [level - 5.0 * slope, slope], rtol=1e-9)


def test_of_all_starts_the_fold_is_taken_that_errs_least_near_the_centre(monkeypatch):
    """One errs by 0.38 at four designs far from it, the other by 0.3 at four near it."""
    inputs = np.array([[0.0], [0.1], [-0.1], [0.1], [1.0], [1.0], [-1.0], [-1.0]])
    near, far = (Fold(np.array([[0.3 * one, 0.0], [0.3 * one, 0.0]])) for one in (0.0, 1.0))
    values = np.where(np.abs(inputs[:, 0]) > 0.5, 0.38, 0.0)
    found = iter([None, far, near, far, None, near, far, near, near, far, far, None])
    monkeypatch.setattr(module, "_fitted", lambda *_: next(found))
    assert fold_near(np.zeros(1), inputs, values) is near


@pytest.mark.parametrize("lean", [-0.2, 0.0, 0.2])
@pytest.mark.parametrize("seed", [0, 1, 5])
def test_one_design_of_four_lies_on_the_floor_of_a_fold(lean, seed):
    """As far along it as the region and the smaller ones about its best reach; smooth functions lead up a wall."""

    def fold(place: np.ndarray) -> float:
        return 3.0 * abs(place[0] - 0.3 - lean * place[1]) + 0.1 * (1.0 - place[1])

    centre = np.array([0.3 + 0.3 * lean, 0.3])
    around = centre + 0.15 * np.random.default_rng(seed).uniform(-1.0, 1.0, size=(11, 2))
    designs = known(fold, np.vstack([centre, around]))
    aims = []
    for turn in (0, 1, 2, 5):
        found = _next(designs, FREE, centre, _Region(0.2), turn)
        assert found is not None
        aims.append(fold(found))
    reach = 0.2 * (1.0 + 0.3 + 0.09 + 0.027)
    assert max(aims[1], aims[3]) < fold(centre) - 0.1 * 0.8 * reach
    assert min(aims[0], aims[2]) > fold(centre)


def ends(lean: float) -> list[float]:
    """Where searches end that begin with other designs: steep to both sides of a floor that falls by 0.1."""
    found = []
    for seed in (4, 5, 6):
        designs = Tried(lambda place, _: ([3.0 * abs(place[0] - 0.3 - lean * place[1]) + 0.1 * (1.0 - place[1])], []))
        designs.solved(list(np.random.default_rng(seed).uniform(size=(12, 2))), COARSE)
        found.append(float(search(designs, FREE, 24).aims[0]))
    return found


@pytest.mark.slow
def test_the_floor_of_a_fold_is_followed_to_its_end(monkeypatch):
    """Half of all searches get there, which of them is a matter of rounding; the others stop on the floor."""
    leans = (-0.2, 0.0, 0.1, 0.2, 0.3)
    with_folds = np.array([ends(lean) for lean in leans])
    assert np.sum(with_folds < 1e-3) >= 3
    monkeypatch.setattr(import_module("semiwear.optimise.surrogate"), "fold_near", lambda *_: None)
    without = np.array([ends(lean) for lean in leans])
    assert np.median(without) > 0.01  # no smooth function of so few designs sees it
    assert without.min() > 1e-3
    assert with_folds.max() < without.max()
