"""Wear steps to a depth of the control point: how many meshes they take, and when none do."""

import math

import pytest

import semiwear as sw
from semiwear.wear.stepping import WearStepper
from tests.scenes import TINY

DEPTHS = [4.0, 8.0]  # um
FOUR_DEPTHS = TINY | {"wear.until.control_depths_um": DEPTHS}


def worn_in_jumps(monkeypatch, size):
    """Let depths at the control point jump by `size` [mm], as they do when a slice comes into contact."""
    depth_at = WearStepper.depth_at

    def jumping(self, point, wear):
        depth = depth_at(self, point, wear)
        return size * (math.floor(depth / size) + 0.5) if depth > 0.0 else 0.0

    monkeypatch.setattr(WearStepper, "depth_at", jumping)


@pytest.mark.slow
def test_a_depth_that_jumps_a_little_over_the_one_asked_for_is_met(shipped, monkeypatch):
    smooth = sw.simulate(shipped.replace(FOUR_DEPTHS))["history"].to_dataset()
    worn_in_jumps(monkeypatch, 2e-4 * 4e-3)
    jumping = sw.simulate(shipped.replace(FOUR_DEPTHS))["history"].to_dataset()
    assert jumping.meshes.values == pytest.approx(smooth.meshes.values, rel=1e-3)
    assert jumping.wear_depth_control_point.values[1:] == pytest.approx(DEPTHS, rel=3e-4)


def test_one_that_jumps_far_over_it_is_not(shipped, monkeypatch):
    worn_in_jumps(monkeypatch, 4e-4)
    with pytest.raises(sw.ConvergenceError, match="no number of meshes wears the control point"):
        sw.simulate(shipped.replace(FOUR_DEPTHS))
