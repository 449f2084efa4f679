"""Loops of solvers end, and say what is wrong, where what they work on is no number or gets nowhere."""

from dataclasses import replace
from itertools import count
from types import SimpleNamespace

import numpy as np
import pytest

import semiwear as sw
from semiwear.contact import line_contact, patch_contact, patch_gap, slice_pressure
from semiwear.contact.gap import FlankGap
from semiwear.errors import ConvergenceError
from semiwear.plan import plan
from semiwear.wear import case_step
from semiwear.wear.adaptive import AdaptiveStepper
from semiwear.wear.laws import LoadLaw
from semiwear.wear.state import ControlPoint
from semiwear.wear.two_stage import TwoStageStepper
from tests.strategies.hard_cases import within

POINT = ControlPoint(face=508.0, profile=np.zeros(3))


@pytest.fixture(scope="module")
def coarse(shipped: sw.Scene) -> sw.Scene:
    return shipped.replace(
        {
            "numerics.face_slices": 15,
            "numerics.roll_positions": 8,
            "wear.until.control_depths_um": [5.0, 10.0],
            "effects.wear_law.load.reference_pressure_MPa": 1000.0,
        }
    )


@pytest.mark.slow
@pytest.mark.parametrize("exponent", [-0.9, -1.2])
def test_wear_that_grows_as_pressure_falls_is_finite(coarse, exponent):
    tree = sw.simulate(coarse.replace({"effects.wear_law.load.exponent": exponent}))
    wear = tree["flank"]["wear_depth"].values
    assert np.isfinite(wear[:, 1]).all()
    np.testing.assert_allclose(tree["history"]["wear_depth_control_point"], [0.0, 5.0, 10.0], rtol=0.02)
    assert float(tree["diagnostics"].wear_law_residual.max()) <= case_step._FACTOR_ERROR


def test_wear_and_loads_that_do_not_settle_are_an_error_that_keeps_the_steps_before(coarse, monkeypatch):
    scene = coarse.replace({"effects.wear_law.load.exponent": 1.5})
    settled = sw.simulate(scene)
    assert float(settled["diagnostics"].wear_law_residual.max()) <= case_step._FACTOR_TOLERANCE
    monkeypatch.setattr(case_step, "_FACTOR_ITERATIONS", 2)
    with pytest.raises(ConvergenceError, match=r"do not settle.*numerics\.wear_steps") as caught:
        sw.simulate(scene)
    assert caught.value.result is not None
    assert caught.value.result["history"].sizes["wear_step"] < settled["history"].sizes["wear_step"]


def test_a_factor_that_is_no_number_is_an_error_that_names_its_effect(coarse, monkeypatch):
    monkeypatch.setattr(LoadLaw, "factor", lambda self, conditions: np.full(conditions.line_load.shape, np.nan))
    with pytest.raises(ConvergenceError, match=r"effects\.wear_law\.load"):
        sw.simulate(coarse)


def test_bands_of_a_gap_that_is_no_number():
    u, g = np.linspace(0.0, 1.0, 50), np.linspace(-1.0, 1.0, 50) ** 2
    g[10:40:3] = np.nan
    first, last = np.empty(10, dtype=np.int64), np.empty(10, dtype=np.int64)
    with within(5.0):
        bands = slice_pressure._bands.py_func(u, g, 50, np.nan, 0.1, first, last)
    assert bands == 0
    with within(5.0):
        assert slice_pressure._bands.py_func(u, g, 50, 0.0, 0.1, first, last) > 0


@pytest.mark.parametrize(("bend", "approach"), [(np.nan, 0.01), (1e-3, np.inf), (1e-3, np.nan)])
def test_rows_of_cells_end_at_the_flank(bend, approach):
    one = np.ones((1, 1))
    separation = np.array([0.0, 0.0, bend, 0.0])[:, None, None] * np.ones((4, 1, 1))
    nodes, rows = np.linspace(-5.0, 5.0, 11)[None], np.zeros(1, dtype=np.int64)
    with within(5.0):
        flank = FlankGap(
            0.0 * one, -5.0 * one, 5.0 * one, separation, one, 0.2 * one, 0.2 * one, np.zeros((1, 1, 11)), rows,
            nodes, np.zeros(1, dtype=np.int64),
        )  # fmt: skip
        patch_gap._gaps.py_func(rows, rows, approach, 8, 0.1, flank, np.full((1, 8), np.inf))


def test_an_approach_that_only_grows_is_an_error(coarse, monkeypatch):
    teeth = plan(coarse.replace({"effects.wear_law": None})).loaded_teeth()
    worn = teeth.touch_solved(np.zeros(teeth.grid.profile.shape))

    def farther(candidates, *_):
        return 0, 2.0 * candidates.cap / float(candidates.lever.max()), 1, 0.0, 0.0, 0.0

    monkeypatch.setattr(line_contact, "share_torque", farther)
    with within(20.0), pytest.raises(ConvergenceError, match="mesh position 0/8: the approach"):
        teeth.fidelity.solve(teeth.problem, worn, positions=[0])


@pytest.mark.slow
def test_an_approach_of_patches_that_only_grows_is_an_error(coarse, monkeypatch):
    teeth = plan(coarse.replace({"effects.wear_law": None, "numerics.fidelity": "patch"})).loaded_teeth()
    worn = teeth.touch_solved(np.zeros(teeth.grid.profile.shape))
    solve, turns = patch_contact.share_torque, (2.0**k for k in count(-10))
    monkeypatch.setattr(patch_contact, "share_torque", lambda *args: replace(solve(*args), rotation=next(turns)))
    with within(60.0), pytest.raises(ConvergenceError, match="mesh position 0/8: the approach"):
        teeth.fidelity.solve(teeth.problem, worn, positions=[0])


def test_adaptive_steps_that_do_not_advance_are_an_error(monkeypatch):
    trial = SimpleNamespace(trial=None, meshes=0.5, error=0.0, size=1.0)
    monkeypatch.setattr("semiwear.wear.adaptive.measured", lambda *_: trial)
    state = SimpleNamespace(stride=(0.5, 1.0), error=0.0)
    stepper = AdaptiveStepper(SimpleNamespace(commit=lambda _: state), 0.01, 1.0)
    monkeypatch.setattr(
        "semiwear.wear.adaptive.replace", lambda one, **_: SimpleNamespace(stride=(0.5, 1.0), error=0.0)
    )
    with within(5.0), pytest.raises(ConvergenceError, match="no wear step advances"):
        stepper._until(state, 0.0, 1.0, lambda *_: None, lambda _: 0.0)


def test_halving_a_step_of_two_stages_ends(monkeypatch):
    plain = SimpleNamespace(meshes=1.0, loads=None, pace=1.0, worn=SimpleNamespace(driven=np.zeros((3, 2))))
    fake = SimpleNamespace(
        fully_implicit=lambda _: fake,
        trial_to_depth=lambda *_: plain,
        depth_at=lambda *_: 1.0,
        commit=lambda _: state,
        footprints_between=lambda *_: 1.0,
    )
    state = SimpleNamespace(worn=plain.worn)
    monkeypatch.setattr("semiwear.wear.two_stage._first_stage", lambda *_: plain)
    with pytest.raises(ConvergenceError, match="loses its load"):
        TwoStageStepper(fake).step_to_depth(state, POINT, 1.0)
