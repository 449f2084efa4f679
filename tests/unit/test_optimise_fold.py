"""A fold through designs: two planes of which the greater counts."""

from importlib import import_module

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from semiwear.optimise.designs import COARSE
from semiwear.optimise.fold import fold_near
from semiwear.optimise.search import search
from tests.unit.test_optimise_search import FREE, Tried


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


def ends(lean: float) -> list[float]:
    """Where searches end that begin with other designs: steep to both sides of a floor that falls by 0.1."""
    found = []
    for seed in (4, 5, 6):
        designs = Tried(lambda place, _: ([3.0 * abs(place[0] - 0.3 - lean * place[1]) + 0.1 * (1.0 - place[1])], []))
        designs.solved(list(np.random.default_rng(seed).uniform(size=(12, 2))), COARSE)
        found.append(float(search(designs, FREE, 24).aims[0]))
    return found


def test_the_floor_of_a_fold_is_followed_to_its_end(monkeypatch):
    leans = (-0.2, 0.0, 0.1, 0.2, 0.3)
    with_folds = np.array([ends(lean) for lean in leans])
    assert np.median(with_folds) < 1e-3
    assert with_folds.max() < 0.03
    monkeypatch.setattr(import_module("semiwear.optimise.surrogate"), "fold_near", lambda *_: None)
    without = np.array([ends(lean) for lean in leans])
    assert np.median(without) > 0.01  # no smooth function of so few designs sees it
