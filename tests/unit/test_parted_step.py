"""Steps to control depths that are deep are taken in parts."""

from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import semiwear as sw
from semiwear.plan import Plan, plan
from semiwear.wear import parted_step
from semiwear.wear.parted_step import parted_step_to_depth
from semiwear.wear.state import ControlPoint, WearState
from semiwear.wear.step_count import DEEP, MOST_STEPS, PLAIN_STEPS, depth_of_step, parts_of_step
from semiwear.wear.worn import Worn
from tests.scenes import TINY, scene_of

BOTH = {"wear.worn_bodies": ["pinion", "gear"], "wear.until.control_depths_um": [4.0, 8.0]}


@dataclass
class Stepper:
    """Wears both flanks in proportion to the depth at the control point, and keeps the depths it was asked for."""

    per_depth: float
    asked: list[float]

    def step_to_depth(self, _state: WearState, _point: ControlPoint, depth: float) -> WearState:
        self.asked.append(depth)
        return worn_by(depth, self.per_depth)


@dataclass
class State:
    """What a step reads of a wear state."""

    worn: Worn


def worn_by(depth: float, per_depth: float) -> WearState:
    return cast(WearState, State(Worn(np.array([[depth]]), np.array([[per_depth * depth]]))))


def steps(per_depth: float, depths: list[float], known: int = 1, smooth: bool = False) -> list[float]:
    """Depths that are asked for on the way to `depths[known]`, where a part is 1 deep."""
    stepper, point = Stepper(per_depth, []), ControlPoint(0.0, np.zeros(1))
    states = [worn_by(depth, per_depth) for depth in depths[:known]]
    parted_step_to_depth(stepper, states, point, depths, 1.0, smooth=smooth)
    return stepper.asked


def test_a_step_that_is_not_deep_is_taken_whole() -> None:
    assert steps(DEEP, [0.0, 1.0]) == [1.0]
    assert steps(0.1, [0.0, DEEP]) == [DEEP]


def test_the_first_step_is_taken_once_more_where_it_was_deep() -> None:
    assert steps(4.0, [0.0, 1.0]) == [1.0, 0.25, 0.5, 0.75, 1.0]


def test_parts_are_alike_unless_results_are_to_be_smooth() -> None:
    assert steps(3.5, [0.0, 1.0]) == [1.0, 0.25, 0.5, 0.75, 1.0]
    assert steps(3.5, [0.0, 1.0], smooth=True) == pytest.approx([1.0, 1.0 / 3.5, 2.0 / 3.5, 3.0 / 3.5, 1.0])
    assert len(steps(4.005, [0.0, 1.0], smooth=True)) == 1 + 4  # without a splinter


def test_the_step_before_foretells_the_parts_of_the_next() -> None:
    assert steps(4.0, [0.0, 1.0, 2.5], known=2) == pytest.approx([1.25, 1.5, 1.75, 2.0, 2.25, 2.5])
    assert steps(4.0, [0.0, 1.0, 1.5, 2.5], known=3) == pytest.approx([1.75, 2.0, 2.25, 2.5])


def test_parts_are_no_more_than_the_most_steps_of_a_run() -> None:
    asked = steps(1e4, [0.0, 1.0, 2.0], known=2)
    assert len(asked) == MOST_STEPS and asked[-1] == 2.0


@given(st.floats(0.0, 1e3), st.booleans())
def test_parts_rise_to_the_end_of_the_step(depth: float, smooth: bool) -> None:
    ends = parted_step._ends(parts_of_step(depth, 1.0), smooth)
    assert ends[-1] == 1.0 and np.all(np.diff([0.0, *ends]) > 0.0)
    assert len(ends) == 1 if depth <= DEEP else len(ends) > 1


@given(st.floats(DEEP + 0.1, MOST_STEPS - 0.1), st.floats(-1e-3, 1e-3))
def test_parts_of_smooth_results_move_smoothly(depth: float, change: float) -> None:
    before, after = parted_step._ends(depth, True), parted_step._ends(depth + change, True)
    # a last part that comes or goes is short
    common = min(len(before), len(after)) - 1
    np.testing.assert_allclose(before[:common], after[:common], atol=1e-3)
    assert all(end > 1.0 - 0.02 / DEEP for end in [*before[common:], *after[common:]])


@pytest.fixture
def shares(monkeypatch: pytest.MonkeyPatch) -> list[list[float]]:
    """Shares at which the parts of steps end, one list for each time that a step is taken."""
    ends, found = parted_step._ends, []

    def watched(parts: float, smooth: bool) -> list[float]:
        found.append(ends(parts, smooth))
        return found[-1]

    monkeypatch.setattr(parted_step, "_ends", watched)
    return found


@pytest.mark.parametrize("scheme", ["implicit", pytest.param("two-stage", marks=pytest.mark.slow)])
def test_a_deep_step_ends_where_a_run_to_its_parts_does(scheme: str, shares: list[list[float]]) -> None:
    depth = 8.0
    scene = scene_of(
        TINY, BOTH, {"numerics.wear_scheme": scheme, "wear.until.control_depths_um": [depth]}, wears=True
    )
    deep = sw.simulate(scene)["flank"].isel(wear_step=-1)
    ends = shares[-1]
    assert [len(one) for one in shares] == [1, len(ends)] and len(ends) > DEEP
    shallow = sw.simulate(scene.replace({"wear.until.control_depths_um": [depth * share for share in ends]}))["flank"]
    assert all(len(one) == 1 for one in shares[2:])
    last = shallow.isel(wear_step=-1)
    np.testing.assert_allclose(deep["wear_depth"], last["wear_depth"], rtol=1e-9, atol=1e-9)


def test_parts_err_less_than_whole_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    def last(scene: sw.Scene) -> xr.DataArray:
        return sw.simulate(scene)["flank"].wear_depth.isel(wear_step=-1)

    def error(found: xr.DataArray) -> float:
        return float(abs(found - short).max() / short.max())

    scene = scene_of(TINY, BOTH, wears=True)
    short = last(scene.replace({"wear.until.control_depths_um": [0.5 * (k + 1) for k in range(16)]}))
    parted = error(last(scene))
    monkeypatch.setattr(Plan, "depth_of_part", lambda *_: None)
    whole = error(last(scene))
    assert parted < 0.5 * whole


def test_a_run_goes_on_with_the_same_parts(tmp_path: Path, shares: list[list[float]]) -> None:
    scene, first = scene_of(TINY, BOTH, wears=True), {"wear.until.control_depths_um": [4.0]}
    straight, parts = sw.simulate(scene), [len(one) for one in shares]
    sw.simulate(scene.replace(first), checkpoint=tmp_path)
    shares.clear()
    resumed = sw.simulate(scene, checkpoint=tmp_path, resume=True)
    assert [len(one) for one in shares] == parts[-1:] and parts[-1] > DEEP
    np.testing.assert_array_equal(resumed["flank"].wear_depth, straight["flank"].wear_depth)


def test_explicit_steps_and_those_of_an_accuracy_are_not_parted() -> None:
    scene = scene_of(TINY, BOTH, wears=True)
    teeth = plan(scene).loaded_teeth()
    plain = plan(scene).depth_of_part(teeth)
    assert plain == depth_of_step(teeth.pair.base_pitch)
    two_stage = plan(scene.replace({"numerics.wear_scheme": "two-stage"})).depth_of_part(teeth)
    assert two_stage == PLAIN_STEPS * plain
    for other in ({"numerics.wear_scheme": "explicit"}, {"numerics.accuracy": 0.05}):
        assert plan(scene.replace(other)).depth_of_part(teeth) is None
