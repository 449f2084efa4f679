"""Cycles of a wear step: at which flanks the contact's shape is looked at, and what they sum up to."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from semiwear.plan import plan
from semiwear.wear.mapping import _apart, _parts
from semiwear.wear.stepping import WearStepper, _Step
from tests.scenes import TINY


@given(cycles=st.floats(2.0, 130.0))
def test_shapes_lie_about_the_middle_of_a_step(cycles):
    weights = _parts(cycles)
    assert sum(weights) == pytest.approx(cycles) and 0.0 < min(weights) <= 1.0
    moments = _apart(weights) * np.arange(len(weights))
    assert np.average(moments, weights=weights) == pytest.approx(0.5)
    # those of whole numbers go from the start to the end
    whole = _parts(float(int(cycles)))
    assert _apart(whole) * (len(whole) - 1) == pytest.approx(1.0)


@given(cycles=st.integers(3, 130))
def test_a_further_shape_comes_in_by_and_by(cycles):
    before, after = _parts(float(cycles)), _parts(cycles + 1e-9)
    assert len(after) == len(before) + 1 and after[-1] < 1e-6
    assert _apart(after) == pytest.approx(_apart(before), rel=1e-8)


@given(cycles=st.integers(3, 60), share=st.floats(0.05, 0.95))
def test_ripples_that_wear_away_never_come_out_greater(cycles, share):
    """Of any rate up to twice the number of stretches between shapes, as the docstring says, in the linear case."""
    weights, rate = _parts(float(cycles)), 2.0 * (cycles - 1) * share
    height, total = 1.0, 0.0
    for weight in weights:
        total += weight * height
        height -= rate * _apart(weights) * height
    assert abs(1.0 - rate * total / cycles) <= 1.0


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
        few, many = (step.worn(loads, meshes, cycles=count).driven for count in (4.0, 192.0))
        errors.append(np.sqrt(np.mean((few - many) ** 2)))
    assert 0.0 < errors[1] < 2e-4 * depth
    assert errors[1] / errors[0] == pytest.approx(8.0, abs=1.0)
