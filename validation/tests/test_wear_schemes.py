"""Explicit, implicit and two-stage wear steps over a whole life of the shipped scene: stability, error, growth."""

from __future__ import annotations

import numpy as np
import pytest

from semiwear.wear.adaptive import AdaptiveStepper
from tests.scenes import COARSE
from validation.wear_schemes import life_of

pytestmark = pytest.mark.slow

LIFE = 1e10  # meshes: some 64 um at most


@pytest.fixture(scope="module")
def life(shipped):
    return life_of(shipped.replace(COARSE | {"wear.until.meshes": LIFE}))


@pytest.fixture(scope="module")
def converged(life):
    return life.states("explicit", 96)[-1]


def test_few_implicit_steps_do_what_explicit_ones_need_many_for(life, converged):
    """One implicit step is within 5 % in greatest wear; eight explicit ones still wreck the flank."""
    assert life.run("explicit", 8, converged).error > 0.3
    one, two, four = (life.run("implicit", count, converged) for count in (1, 2, 4))
    assert one.error < 0.05 and two.error < 0.03 and four.error < 0.03
    assert one.flank_error < 0.1
    assert two.flank_error < 0.62 * one.flank_error and four.flank_error < 0.62 * two.flank_error  # of first order
    assert four.flank_error < life.run("explicit", 10, converged).flank_error


def test_two_stages_are_better_than_half_as_many_plain_steps_again(life, converged):
    """And four plain steps, which take as many solutions, are as good within a seventh or so: 0.7 and 0.8 %."""
    one = life.run("two-stage", 1, converged)
    assert one.error < 0.02
    assert one.flank_error < 0.5 * life.run("implicit", 1, converged).flank_error
    assert one.flank_error < 0.9 * life.run("implicit", 2, converged).flank_error
    two, four = (life.run("two-stage", count, converged) for count in (2, 4))
    assert four.flank_error < two.flank_error < 0.7 * one.flank_error
    assert two.flank_error < 0.0083
    assert two.flank_error < life.run("implicit", 3, converged).flank_error
    assert life.run("implicit", 4, converged).flank_error < 0.0073


@pytest.mark.parametrize("scheme", ["two-stage", "implicit", "explicit"])
def test_wear_never_shrinks(life, converged, scheme):
    assert not life.run(scheme, 2, converged).shrinks


def test_adaptive_steps_err_as_they_say(life, converged):
    """The estimate covers the error over the flank as a whole, and is not far above it."""
    adaptive = AdaptiveStepper(life.stepper, 0.03, LIFE)
    state = adaptive.step(adaptive.start(), LIFE)
    assert state.meshes == pytest.approx(LIFE)
    assert state.error <= 1.01 * 0.03
    found = float(np.linalg.norm(state.wear - converged) / np.linalg.norm(converged))
    assert found <= state.error <= 4.0 * found
    assert state.wear.max() == pytest.approx(converged.max(), rel=0.03)
