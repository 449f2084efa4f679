"""Steps to a depth: their length is searched for where contact passes the control point; others move it a little."""

from dataclasses import replace

import numpy as np
import pytest

import semiwear as sw
from semiwear.plan import plan
from semiwear.wear.step_influence import Cycles
from semiwear.wear.stepping import ControlPoint, WearStepper, _Step
from semiwear.wear.worn import Worn
from tests.scenes import TINY

DEPTH = 4e-3  # mm


@pytest.fixture(scope="module", params=[["gear"], ["pinion", "gear"]], ids=" and ".join)
def to_depth(request, shipped) -> tuple[WearStepper, ControlPoint]:
    physics = plan(shipped.replace(TINY | {"wear.worn_bodies": request.param}))
    teeth = physics.loaded_teeth()
    stepper, point = physics.wear_stepper(teeth), physics.control_point(teeth)
    assert isinstance(stepper, WearStepper) and point is not None
    return stepper, point


def searched(monkeypatch, off: float) -> list[bool]:
    """Let the search near the point end at a length that is off by a share of itself; tells what was searched."""
    search, tried = _Step.meshes_to, []

    def meshes_to(self, point, depth, *, nearby, first=None):
        tried.append(nearby)
        meshes, share = search(self, point, depth, nearby=nearby, first=first), 1.0 + off if nearby else 1.0
        self.pace *= share
        return share * meshes

    monkeypatch.setattr(_Step, "meshes_to", meshes_to)
    return tried


def test_a_step_that_nearly_ends_at_the_depth_is_scaled_to_it(monkeypatch, to_depth):
    stepper, point = to_depth
    state = stepper.start()
    exact = stepper.trial_to_depth(state, point, DEPTH)
    tried = searched(monkeypatch, 1.5e-3)
    trial = stepper.trial_to_depth(state, point, DEPTH)
    assert tried == [True] and trial.pace == pytest.approx(exact.pace, rel=5e-4)
    assert stepper.depth_at(point, point.wear(trial.worn)) == pytest.approx(DEPTH, rel=1e-12)
    assert trial.volume.driven == pytest.approx(exact.volume.driven, rel=5e-4)
    for one, other in zip(trial.worn, exact.worn, strict=True):
        if one is not None:
            np.testing.assert_allclose(one, other, atol=1e-3 * other.max())


def test_a_step_that_ends_far_off_is_searched_for_again(monkeypatch, to_depth):
    stepper, point = to_depth
    state = stepper.start()
    tried = searched(monkeypatch, -0.1)
    trial = stepper.trial_to_depth(state, point, DEPTH)
    assert tried == [True, False]
    assert stepper.depth_at(point, point.wear(trial.worn)) == pytest.approx(DEPTH, rel=1e-4)


def test_what_the_search_missed_is_corrected_in_the_next_step(monkeypatch, to_depth):
    stepper, point = to_depth
    tried = searched(monkeypatch, -0.02)
    state = stepper.step_to_depth(stepper.start(), point, DEPTH)
    assert tried == [True, False] and state.depth_ratio == pytest.approx(0.98, abs=5e-3)
    tried.clear()
    state = stepper.step_to_depth(state, point, 2.0 * DEPTH)
    assert tried == [True] and state.depth_ratio == pytest.approx(0.98, abs=5e-3)
    assert stepper.depth_at(point, point.wear(state.worn)) == pytest.approx(2.0 * DEPTH, rel=3e-4)


def test_a_step_that_went_wrong_says_little_of_the_next(monkeypatch, to_depth):
    stepper, point = to_depth
    searched(monkeypatch, -0.9)
    state = stepper.step_to_depth(stepper.start(), point, DEPTH)
    assert state.depth_ratio == 0.8
    assert stepper.depth_at(point, point.wear(state.worn)) == pytest.approx(DEPTH, rel=3e-4)


@pytest.mark.parametrize("most_worn", [1.0, 2.0 / 3.0])
def test_cycles_are_as_many_as_footprints_are_worn_deep(to_depth, most_worn):
    stepper = replace(to_depth[0], most_worn=most_worn)
    step = _Step(stepper, stepper.start())
    flanks = sum(one is not None for one in step.state.worn)

    def cycles(depth: float, *, roughly: bool = False) -> Cycles:
        worn = Worn(*(None if one is None else one + depth / flanks for one in step.state.worn))
        assert step._cycles_to(worn, roughly=roughly) == step.cycles
        return step.cycles

    deep = 1e-7
    while cycles(deep).ahead == 1.0:
        deep *= 1.2
    footprint = deep / (3.0 * (1.0 - 0.5 * cycles(deep).ahead))
    assert cycles(0.0) == (3.0, 1.0)
    for depth in (0.4, 1.7, 2.9, 7.3, 60.5):
        number, ahead = cycles(depth * footprint)
        assert number == max(np.ceil(depth / most_worn), 3.0)
        # twice a footprint's depth in a cycle is the limit without looking ahead, once with it
        assert ahead == pytest.approx(min(2.0 * (1.0 - depth / number), 1.0))
        assert step.theta == pytest.approx(min(max(1.0 - 0.75 / depth, 0.65), 0.75))
    assert cycles(1e3 * footprint) == (128.0, 0.0)
    step = _Step(replace(stepper, theta=1.0), step.state)
    assert cycles(0.4 * footprint) and step.theta == 1.0
    assert [cycles(depth * footprint, roughly=True) for depth in (0.5, 5.8)] == [(2.0, 1.0), (4.0, 0.0)]


def test_a_control_point_that_bears_nothing_is_told_by_its_place_along_the_face():
    off_contact = {
        "numerics.tooth_compliance": "rigid",
        "wear.until.meshes": None,
        "wear.until.control_depths_um": [0.1],
        "wear.control_point": {"face_mm": 6.9, "height_mm": 0.1},
        "effects.misalignment.shaft_angle_error_mrad": -40.0,
    }
    with pytest.raises(sw.ConvergenceError, match=r"control point \(face 6\.9 mm\) carries no load"):
        sw.simulate(sw.load_scene("spur_fzg_c").replace(TINY | off_contact))


def test_a_run_to_a_depth_that_takes_the_tooth_is_told_to_ask_for_less_deep_ones():
    too_deep = {
        "numerics.tooth_compliance": "rigid",
        "wear.until.meshes": None,
        "wear.until.control_depths_um": [4000.0],
        "wear.control_point": {"face_mm": 0.0, "height_mm": 0.5},
    }
    with pytest.raises(sw.ConvergenceError, match=r"less deep wear\.until\.control_depths_um"):
        sw.simulate(sw.load_scene("spur_fzg_c").replace(TINY | too_deep))
