"""Loads of few digits where nothing but a start or a length needs them: what is kept has all of its digits."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import semiwear as sw
from semiwear.contact.line_contact import solve_lines
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.contact.patch_contact import solve_cells
from semiwear.plan import plan
from semiwear.wear import stepping
from semiwear.wear.state import WearState
from semiwear.wear.stepping import WearStepper
from tests.scenes import TINY

DEPTH = 5e-3  # mm
_ROUGH = 0.01  # of half-widths: wear then differs by 3e-4 of the greatest; from 0.02 on other cells bear on the way


def prepared(fidelity: str) -> tuple[WearStepper, stepping.ControlPoint]:
    scene = sw.load_scene("face_gear_25x160").replace(TINY | {"numerics.fidelity": fidelity})
    physics = plan(scene)
    stepper = physics.wear_stepper(physics.loaded_teeth())
    assert isinstance(stepper, WearStepper)
    return stepper, physics.control_point(stepper.teeth)


def rougher(stepper: WearStepper, tolerance: float) -> WearStepper:
    """The same with such a tolerance where loads may be rough."""
    solve = solve_lines if stepper.teeth.problem.cells is None else solve_cells
    fidelity = replace(stepper.teeth.fidelity, roughly=partial(solve, tolerance=tolerance))
    return replace(stepper, teeth=replace(stepper.teeth, fidelity=fidelity))


def two_steps(stepper: WearStepper, point: stepping.ControlPoint) -> WearState:
    state = stepper.step_to_depth(stepper.start(), point, DEPTH)
    return stepper.step_to_depth(state, point, 2.0 * DEPTH)


def off_exact(teeth: LoadedTeeth, state: WearState) -> float:
    """Greatest change of a force on a slice, of the greatest, when the loads are found to many more digits."""
    loads = state.contact.loads
    solve = partial(solve_lines, tolerance=1e-10) if teeth.problem.cells is None else teeth.fidelity.solve
    exact = solve(teeth.problem, state.contact.coarse, loads).force
    return float(np.abs(loads.force - exact).max() / exact.max())


@pytest.mark.parametrize("fidelity", ["line", "patch"])
def test_loads_of_a_state_are_exact_however_rough_those_on_the_way_are(fidelity: str) -> None:
    stepper, point = prepared(fidelity)
    kept, rough = (two_steps(one, point) for one in (stepper, rougher(stepper, _ROUGH)))
    for state in (kept, rough):
        assert off_exact(stepper.teeth, state) < 3e-6
        assert stepper.depth_at(point, state.worn.driven) == pytest.approx(2.0 * DEPTH, rel=1e-6)
    np.testing.assert_allclose(rough.wear, kept.wear, rtol=0.0, atol=0.1 * _ROUGH * kept.wear.max())
    close = two_steps(rougher(stepper, 1e-9), point)
    np.testing.assert_allclose(kept.wear, close.wear, rtol=0.0, atol=2e-5 * kept.wear.max())


def test_a_length_is_taken_after_one_trial_that_misses_by_little(monkeypatch: pytest.MonkeyPatch) -> None:
    """The depth is what was asked for either way, and hardly anything else differs."""
    stepper, point = prepared("line")
    trials: list[int] = []
    loads = stepping._Step.loads

    def counted(self, meshes, positions=None, start=None):
        trials.append(positions is not None)
        return loads(self, meshes, positions, start)

    monkeypatch.setattr(stepping._Step, "loads", counted)
    once = two_steps(stepper, point)
    few = sum(trials)
    trials.clear()
    monkeypatch.setattr(stepping, "_LINEAR", 0.0)
    more = two_steps(stepper, point)
    assert few < sum(trials)
    for state in (once, more):
        assert stepper.depth_at(point, state.worn.driven) == pytest.approx(2.0 * DEPTH, rel=1e-6)
    np.testing.assert_allclose(once.wear, more.wear, rtol=0.0, atol=1e-3 * more.wear.max())
