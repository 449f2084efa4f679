"""Cycles of a wear step: at which flanks the contact's shape is looked at, and what they sum up to."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from semiwear.plan import plan
from semiwear.wear.mapping import _apart, _groups
from semiwear.wear.stepping import WearStepper, _Step
from tests.scenes import TINY


@given(cycles=st.floats(1.0, 130.0))
def test_groups_hold_all_cycles(cycles):
    groups = _groups(cycles)
    assert sum(map(sum, groups)) == pytest.approx(cycles)
    assert all(group == [1.0, 1.0, 1.0] for group in groups[:-1]) and 0.0 < min(groups[-1]) <= max(groups[-1]) <= 1.0


@given(rest=st.floats(2.0, 3.0))
def test_shapes_lie_about_the_middle_of_their_part_of_a_step(rest):
    weights = _groups(rest)[0]
    assert np.average(_apart(weights) * np.arange(len(weights)), weights=weights) == pytest.approx(0.5)


def test_three_shapes_lie_at_start_middle_and_end():
    assert _apart([1.0, 1.0, 1.0]) == 0.5


def wear_of(cycles: float, rate: float) -> float:
    """What a height of 1 loses in a step of so many cycles, of a rate of itself."""
    height = 1.0
    for weights in _groups(cycles):
        stage, total = height, 0.0
        for weight in weights:
            total += weight * stage
            stage -= rate * _apart(weights) * sum(weights) / cycles * stage
        height -= rate * total / cycles
    return 1.0 - height


@given(cycles=st.integers(1, 60), rate=st.floats(0.01, 3.0))
def test_a_further_cycle_comes_in_by_and_by(cycles, rate):
    assert wear_of(cycles + 1e-9, rate) == pytest.approx(wear_of(float(cycles), rate), abs=1e-7)


@given(groups=st.integers(1, 20), share=st.floats(0.02, 1.0))
def test_ripples_that_wear_away_never_come_out_greater(groups, share):
    """Up to a rate of 4/3 a cycle, as the docstring says."""
    assert abs(1.0 - wear_of(3.0 * groups, 4.0 * groups * share)) <= 1.0 + 1e-12


@given(groups=st.integers(2, 20), rate=st.floats(0.05, 2.0))
def test_what_wears_away_does_so_as_it_should(groups, rate):
    """Error of a twelfth of the cube of the rate in every group of three."""
    bound = groups * (rate / groups) ** 3 / 12.0
    assert wear_of(3.0 * groups, rate) == pytest.approx(1.0 - np.exp(-rate), abs=bound)


@pytest.mark.parametrize("name", ["shipped", "spur"])
def test_cycles_of_a_step_are_of_second_order_in_its_length(request, name):
    """Under the loads of the start, against many cycles: what one step errs by falls to an eighth with half of it."""
    physics = plan(request.getfixturevalue(name).replace(TINY))
    stepper = physics.wear_stepper(physics.loaded_teeth())
    assert isinstance(stepper, WearStepper)
    step = _Step(stepper, stepper.start())
    loads = [loaded.loads for loaded in step.state.loaded]
    errors = []
    for depth in (1e-3, 2e-3):
        meshes = depth / step.worn(loads, 1.0, cycles=1.0).driven.max()
        few, many = (step.worn(loads, meshes, cycles=count).driven for count in (3.0, 192.0))
        errors.append(np.sqrt(np.mean((few - many) ** 2)))
    assert 0.0 < errors[1] < 5e-4 * depth
    assert errors[1] / errors[0] == pytest.approx(8.0, abs=1.0)
