"""The loads that hold over an implicit step: after some three quarters of it, against those at its end."""

from dataclasses import replace

import numpy as np
import pytest

import semiwear as sw
from semiwear.plan import plan
from semiwear.wear.stepping import WearState, WearStepper
from tests.scenes import TINY

CYLINDER = TINY | {"gear_pair.centre_distance_mm": None}
# none of them is one of the runs by which the share was chosen
CASES = {
    "internal": (
        "spur_fzg_c",
        CYLINDER
        | {
            "gear_pair.pinion_teeth": 25,
            "gear_pair.gear_teeth": -60,
            "gear_pair.pinion_profile_shift": 0.4,
            "gear_pair.gear_profile_shift": -0.4,
        },
        4e8,
    ),
    "misaligned": ("face_gear_25x160", TINY | {"effects.misalignment": {"offset_mm": 0.1}}, 4e8),
    "spectrum": (
        "face_gear_25x160",
        TINY | {"effects.load_spectrum": {"torques_Nm": [800.0, 1600.0, 2200.0], "shares": [0.3, 0.5, 0.2]}},
        4e8,
    ),
}


@pytest.fixture(
    scope="module",
    params=["internal", "misaligned", pytest.param("spectrum", marks=pytest.mark.slow)],  # three loads a step
)
def case(request: pytest.FixtureRequest) -> tuple[WearStepper, float]:
    """A pair, and meshes that it wears for."""
    name, changes, meshes = CASES[request.param]
    until = {"wear.until.control_depths_um": None, "wear.control_point": None, "wear.until.meshes": meshes}
    physics = plan(sw.load_scene(name).replace(changes | until))
    return physics.wear_stepper(physics.loaded_teeth()), meshes


def worn(stepper: WearStepper, meshes: float, steps: int) -> WearState:
    """After so many equal steps."""
    state = stepper.start()
    for _ in range(steps):
        state = stepper.step(state, meshes / steps)
    return state


@pytest.mark.parametrize(("part", "share"), [(0.25, 0.75), (64.0, 0.65)])
def test_the_loads_of_a_step_are_those_after_three_quarters_of_it_or_less_where_it_is_shallow(case, part, share):
    stepper, meshes = case
    state = stepper.start()
    trial = stepper.trial(state, meshes / part)
    assert trial.theta == share
    late = stepper.trial(state, meshes / part, loads_after=share * meshes / part)
    for one, other in zip(trial.loads, late.loads, strict=True):
        np.testing.assert_allclose(one.force, other.force, atol=1e-3 * one.force.max())  # other loads were predicted
    at_end = stepper.trial(state, meshes / 8, loads_after=meshes / 8)
    trial = stepper.trial(state, meshes / 8)
    apart = [np.abs(x.force - y.force).max() / x.force.max() for x, y in zip(trial.loads, at_end.loads, strict=True)]
    assert max(apart) > 1e-2


def test_few_steps_err_less_than_under_the_loads_at_their_ends(case):
    stepper, meshes = case
    at_the_ends = replace(stepper, theta=1.0)
    finest = worn(stepper, meshes, 36).wear

    def error(one: WearStepper, steps: int) -> float:
        return float(np.sqrt(np.mean((worn(one, meshes, steps).wear - finest) ** 2)) / finest.max())

    for steps in (3, 6):
        assert error(stepper, steps) < 0.7 * error(at_the_ends, steps)
    assert error(stepper, 12) < 0.6 * error(stepper, 3)


def test_long_steps_stay_stable(case):
    """A third of what is fast changes sides in each, and dies out: the flank is that of many steps."""
    stepper, meshes = case
    few, many = worn(stepper, 8.0 * meshes, 6), worn(stepper, 8.0 * meshes, 18)
    assert (few.wear >= 0.0).all()
    np.testing.assert_allclose(few.wear, many.wear, atol=0.15 * many.wear.max())
    state = stepper.start()
    for _ in range(3):
        after = stepper.step(state, 2.0 * meshes)
        assert (after.wear >= state.wear).all()
        state = after
