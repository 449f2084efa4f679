"""Explicit, implicit and extrapolated wear steps over a whole life of the shipped scene: stability, error, growth."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import semiwear as sw
from semiwear.wear.adaptive import AdaptiveStepper, doubled

LIFE = 1e10  # meshes: some 64 um at most


def stepper_of(shipped):
    scene = shipped.replace(
        {
            "wear.until.meshes": LIFE,
            "numerics.face_slices": 31,
            "numerics.roll_positions": 12,
            "numerics.profile_points": 101,
            "numerics.harmonics": 9,
        }
    )
    physics = sw.plan(scene)
    return physics.wear_stepper(physics.loaded_teeth())


class Life:
    """Wear after a life, by scheme and number of steps."""

    def __init__(self, stepper):
        self.stepper, self.explicit = stepper, replace(stepper, implicit=False)
        self.unworn = stepper.start()
        self.converged = self.fixed(self.explicit, 48)[-1]

    def fixed(self, stepper, count):
        states = [self.unworn]
        for _ in range(count):
            states.append(stepper.step(states[-1], LIFE / count))
        return [state.wear for state in states]

    def extrapolated(self, count):
        state, found = self.unworn, [self.unworn.wear]
        for k in range(count):
            step = doubled(self.stepper, state, lambda at, part, k=k: self.trial(at, (k + part) / count))
            state = self.stepper.commit(step.trial)
            found.append(state.wear)
        return found

    def trial(self, state, share):
        return self.stepper.trial(state, share * LIFE - state.meshes)

    def greatest_error(self, wear):
        return abs(float(wear.max() / self.converged.max()) - 1.0)

    def error(self, wear):
        return float(np.linalg.norm(wear - self.converged) / np.linalg.norm(self.converged))


@pytest.fixture(scope="module")
def life(shipped):
    return Life(stepper_of(shipped))


def test_few_implicit_steps_do_what_explicit_ones_need_many_for(life):
    """One implicit step is within 5 % in greatest wear; eight explicit ones still wreck the flank."""
    assert life.greatest_error(life.fixed(life.explicit, 8)[-1]) > 0.3
    wears = [life.fixed(life.stepper, count)[-1] for count in (1, 2, 4)]
    for wear, most in zip(wears, (0.05, 0.03, 0.03), strict=True):
        assert life.greatest_error(wear) < most
    one, two, four = (life.error(wear) for wear in wears)
    assert one < 0.1
    assert two < 0.62 * one and four < 0.62 * two  # of first order
    assert four < life.error(life.fixed(life.explicit, 12)[-1])


def test_extrapolation_is_better_than_the_steps_that_it_is_made_of(life):
    steps = (life.fixed(life.stepper, 1), life.fixed(life.stepper, 2), life.extrapolated(1))
    whole, halves, extrapolated = (life.error(wear[-1]) for wear in steps)
    assert extrapolated < halves < whole


def test_wear_never_shrinks(life):
    for wear in (life.extrapolated(2), life.fixed(life.stepper, 2), life.fixed(life.explicit, 2)):
        assert all((after >= before).all() for before, after in pairwise(wear))


def test_adaptive_steps_err_as_they_say(life):
    """The estimate covers the error over the flank as a whole, and is not far above it."""
    adaptive = AdaptiveStepper(life.stepper, 0.03, LIFE)
    state = adaptive.step(life.unworn, LIFE)
    assert state.meshes == pytest.approx(LIFE)
    assert state.error <= 1.01 * 0.03
    found = life.error(state.wear)
    assert found <= 1.5 * state.error
    assert state.error <= 3.0 * found
    assert life.greatest_error(state.wear) <= 0.03
