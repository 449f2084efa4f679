"""Wear steps: counted by the wear of whichever body wears most, or found to a depth of the control point."""

import math
from dataclasses import replace

import numpy as np
import pytest

import semiwear as sw
from semiwear.plan import plan
from semiwear.wear import step_influence
from semiwear.wear.step_count import (
    LEAST_STEPS,
    MOST_STEPS,
    life_steps_for_depth,
    steps_for_depth,
    steps_of_life,
)
from semiwear.wear.stepping import WearStepper
from tests.scenes import TINY, Heard


def worn(**changes):
    progress = Heard()
    scene = sw.load_scene("spur_fzg_c").replace(
        TINY | {"numerics.face_slices": 7, "numerics.profile_points": 41, "wear.until.meshes": 5e8} | changes
    )
    return sw.simulate(scene, progress=progress), progress.steps


@pytest.fixture(scope="module")
def runs():
    return {bodies: worn(**{"wear.worn_bodies": list(bodies)}) for bodies in (("pinion",), ("pinion", "gear"))}


def deepest(tree):
    return [float(depth) for depth in tree["flank"].wear_depth[-1].max(("profile", "face"))]


@pytest.mark.slow
@pytest.mark.parametrize("bodies", [("pinion",), ("pinion", "gear")])
def test_steps_are_counted_by_the_deepest_wear_of_either_body(runs, bodies):
    tree, heard = runs[bodies]
    pitch = plan(sw.load_scene("spur_fzg_c")).flank_pair().base_pitch
    taken = tree.sizes["wear_step"] - 1 if "wear_step" in tree.sizes else tree["history"].sizes["wear_step"] - 1
    assert LEAST_STEPS < taken == heard[-1][1]
    # the prediction of a single step, which is what counts them, is some per cent too shallow
    asked = steps_for_depth(1e-3 * max(deepest(tree)), pitch)
    assert asked - 1 <= taken <= asked


@pytest.mark.parametrize("scheme", ["implicit", "explicit", pytest.param("two-stage", marks=pytest.mark.slow)])
def test_a_depth_is_predicted_at_less_than_the_price_of_a_step(scheme, monkeypatch):
    physics = plan(sw.load_scene("spur_fzg_c").replace(TINY | {"numerics.wear_scheme": scheme}))
    stepper = physics.wear_steps(physics.wear_stepper(physics.loaded_teeth()))
    state, swept = stepper.start(), []
    over = step_influence._MeshWear.over
    monkeypatch.setattr(step_influence._MeshWear, "over", lambda *a: swept.append(1) or over(*a))
    predicted, spent = stepper.predicted_depth(state, 1e8), len(swept)
    assert predicted == pytest.approx(max(stepper.step(state, 1e8).deepest.values()), rel=0.1)
    assert spent == 1 if scheme == "explicit" else 0 < spent < len(swept) - spent
    with pytest.raises(sw.ConvergenceError, match="the tooth is worn away long before"):
        stepper.predicted_depth(state, 1e14)


@pytest.mark.parametrize("bodies", [["gear"], ["pinion", "gear"]])
def test_footprints_worn_are_those_of_an_explicit_step(bodies):
    physics = plan(sw.load_scene("spur_fzg_c").replace(TINY | {"wear.worn_bodies": bodies}))
    stepper = physics.wear_stepper(physics.loaded_teeth())
    state = stepper.start()
    worn = replace(stepper, implicit=False).trial(state, 1e7).worn
    footprints = stepper.footprints_worn(state, 1e7)
    assert 0.0 < footprints == pytest.approx(stepper.footprints_between(state, worn))
    assert stepper.footprints_worn(state, 2e7) == pytest.approx(2.0 * footprints)
    # the sagitta of the flanks over the half-width, where both are those of the pitch point
    teeth = stepper.teeth
    bend = np.median(teeth.lines.curvature[state.contact.loads.force > 0.0])
    deepest = sum(float(one.max()) for one in worn if one is not None)
    assert footprints == pytest.approx(deepest / (0.5 * bend * teeth.half_width**2))


def test_progress_tells_the_depth_of_every_worn_body(runs):
    pinion, gear = deepest(runs["pinion", "gear"][0])
    assert runs["pinion", "gear"][1][-1][2] == f"5e+08 meshes, pinion {pinion:.3g} um, gear {gear:.3g} um at most"
    pinion = deepest(runs["pinion",][0])[0]
    assert runs["pinion",][1][-1][2] == f"5e+08 meshes, {pinion:.3g} um at most"


def test_few_and_many_steps_are_bounded():
    assert steps_for_depth(0.0, 10.0) == LEAST_STEPS
    assert steps_for_depth(1.0, 10.0) == MOST_STEPS
    assert steps_for_depth(0.02, 10.0) == steps_for_depth(0.2, 100.0)


def test_a_step_is_of_six_micrometres_at_a_module_of_four_and_a_half():
    """5.98 um, hand-counted; a life has six at least, and is worn at three torques besides its search."""
    pitch = math.pi * 4.5 * math.cos(math.radians(20.0))
    depths = (0.005, 0.017, 0.023, 0.059, 0.15, 1.0)
    assert [steps_for_depth(depth, pitch) for depth in depths] == [3, 3, 4, 10, 26, 40]
    assert [life_steps_for_depth(depth, pitch) for depth in depths] == [6, 6, 6, 10, 26, 40]
    assert [steps_of_life(depth, pitch) for depth in depths[2:5]] == [21, 33, 81]


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
