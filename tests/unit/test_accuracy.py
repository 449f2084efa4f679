"""An asked accuracy: what it chooses, what it leaves alone, and what it tells."""

import math
import re
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from semiwear.accuracy import resolution, run
from semiwear.accuracy.resolution import Contribution, Parameter, chosen_resolution, contributions_at, together
from semiwear.cli import main
from semiwear.results.checkpoint import peek
from semiwear.results.kinds import difference, history, step_errors
from semiwear.scene.load import parse_scene
from semiwear.scene.tables import RESOLUTION
from semiwear.simulate import simulate as simulate_as_given
from semiwear.wear.adaptive import AdaptiveStepper
from semiwear.wear.two_stage import (
    ERROR_SHARE,
    FIRST_STAGES,
    SECOND_ORDER,
    TwoStageStepper,
    first_stage_of,
    measured,
)
from semiwear.wear.worn import Worn
from tests.same_result import different_variables
from tests.scenes import SMALL, TINY

TWO_DEPTHS = TINY | {
    "wear.worn_bodies": ["gear"],
    "wear.until": {"control_depths_um": [2.0, 4.0]},
    "wear.control_point": {"face_mm": 7.0, "height_mm": -2.5},
}
"""Of the spur pair, whose prisms of other harmonics take a quarter of the time of the face gear's."""

# ---------------------------------------------------------------- the scene


def test_without_an_accuracy_a_scene_is_as_it_was(shipped):
    assert shipped.numerics.accuracy is None
    assert shipped.numerics.chosen_for_accuracy == ()
    assert "accuracy" not in shipped.to_toml()
    assert all(f"\n{name} = " in shipped.to_toml() for name in RESOLUTION)
    there_and_back = shipped.replace({"numerics.accuracy": 0.02}).replace({"numerics.accuracy": None})
    assert there_and_back == shipped
    assert there_and_back.sha256 == shipped.sha256


def test_a_number_that_is_given_is_not_chosen_even_if_it_is_the_default(shipped):
    scene = shipped.replace({"numerics.face_slices": shipped.numerics.face_slices, "numerics.accuracy": 0.02})
    assert set(scene.numerics.chosen_for_accuracy) == set(RESOLUTION) - {"face_slices"}
    given_all = {f"numerics.{name}": getattr(shipped.numerics, name) for name in RESOLUTION if name != "wear_steps"}
    assert shipped.replace({"numerics.accuracy": 0.02, **given_all}).numerics.chosen_for_accuracy == ("wear_steps",)
    assert scene.replace({"numerics.face_slices": None}).numerics.chosen_for_accuracy == RESOLUTION


def test_toml_keeps_what_an_accuracy_may_choose(shipped):
    scene = shipped.replace({"numerics.harmonics": 17, "numerics.accuracy": 0.05})
    again = parse_scene(scene.to_toml())
    assert again == scene
    assert again.sha256 == scene.sha256
    assert again.numerics.chosen_for_accuracy == scene.numerics.chosen_for_accuracy
    assert "face_slices" not in scene.to_toml()
    # another question, hence another scene
    assert shipped.replace({"numerics.accuracy": 0.05}) != scene.replace({"numerics.harmonics": 33})


@pytest.mark.parametrize("value", [0.0, 5e-5, 0.51, "fine"])
def test_an_accuracy_out_of_range_is_refused(shipped, value):
    with pytest.raises(sw.SceneError, match=r"numerics\.accuracy"):
        shipped.replace({"numerics.accuracy": value})


def test_the_plan_tells_what_will_be_chosen(shipped):
    assert "numerics.accuracy" not in str(sw.plan(shipped))
    scene = shipped.replace({"numerics.accuracy": 0.05, "numerics.harmonics": 17})
    row = next(choice for choice in sw.plan(scene).choices if choice.slot == "accuracy")
    chosen, kept = row.why.split("kept")
    assert "face_slices" in chosen
    assert "harmonics = 17" in kept


# ---------------------------------------------------------------- kinds


def test_differences_are_relative_to_the_greatest_of_a_kind():
    reference = {"wear_depth_max_root": np.array([0.0, 40.0]), "wear_depth_max_pitch": np.array([0.0, 10.0])}
    values = {"wear_depth_max_root": np.array([0.0, 41.0]), "wear_depth_max_pitch": np.array([0.0, 8.0])}
    errors = difference(values, reference)
    assert errors == pytest.approx({"wear_depth_max_root": 1.0 / 40.0, "wear_depth_max_pitch": 2.0 / 40.0})


def test_a_wrong_depth_spoils_what_wear_has_changed_and_no_more():
    values = {"load_share_max": np.array([0.8, 0.9]), "wear_depth_max_root": np.array([0.0, 20.0])}
    errors = step_errors(0.05, values)
    assert errors == pytest.approx({"load_share_max": 0.05 * 0.1 / 0.9, "wear_depth_max_root": 0.05})


# ---------------------------------------------------------------- resolution


@pytest.mark.parametrize("order", [1.0, 2.0])
@pytest.mark.parametrize("other", [10, 40])
def test_two_runs_tell_an_error_that_follows_its_order(order, other):
    parameter = Parameter("n", 20, 500, order, 1.0)

    def error(n):
        return 7.0 * n**-order

    part = Contribution.between(parameter, 20, other, {"q": abs(error(other) - error(20))}, True)
    assert part.errors["q"] == pytest.approx(error(20))
    assert part.at(35)["q"] == pytest.approx(error(35))


def test_refining_gains_each_quantity_what_its_order_says():
    """The error where two runs are compared is that of the lower order, so that it is not too small for either."""
    parameter = Parameter("n", 20, 500, 1.0, 1.0, of_wear=2.0)
    part = Contribution.between(parameter, 20, 40, {"contact_pressure_root": 0.1, "wear_depth_max_root": 0.1}, True)
    assert part.at(20) == pytest.approx({"contact_pressure_root": 0.2, "wear_depth_max_root": 0.2})
    assert part.at(80) == pytest.approx({"contact_pressure_root": 0.05, "wear_depth_max_root": 0.0125})


def parts_of(**errors):
    return tuple(
        Contribution(Parameter(name, 10, most, 1.0, 1.0), 10, {"q": size}, free)
        for name, (size, most, free) in errors.items()
    )


def total(parts, values):
    return together(contributions_at(parts, values).values())["q"]


def test_what_dominates_is_refined_until_the_sum_is_allowed():
    parts = parts_of(a=(0.2, 1000, True), b=(0.01, 1000, True))
    values = chosen_resolution(parts, {}, 0.02)
    assert total(parts, values) <= 0.02
    assert total(parts, values) > 0.02 / 1.5, "paid for more than was asked for"
    assert values["a"] > 80
    assert values["b"] <= 15


def test_more_is_asked_for_where_experience_says_so():
    parts = parts_of(a=(0.2, 1000, True))
    usual, more = (chosen_resolution(parts, factors, 0.02)["a"] for factors in ({}, {"q": 3.0}))
    assert more == pytest.approx(3.0 * usual, rel=0.25)


def test_given_numbers_and_limits_hold():
    parts = parts_of(a=(0.2, 1000, False), b=(0.2, 40, True))
    assert chosen_resolution(parts, {}, 1e-3) == {"a": 10, "b": 40}


def test_patches_and_prisms_count_only_where_they_are(shipped):
    names = [p.name for p in resolution.parameters_of(shipped.numerics)]
    assert "cells_per_half_width" not in names
    rigid = shipped.replace({"numerics.tooth_compliance": "rigid", "numerics.fidelity": "patch"})
    names = [p.name for p in resolution.parameters_of(rigid.numerics)]
    assert "cells_per_half_width" in names
    assert "harmonics" not in names


# ---------------------------------------------------------------- wear steps


@dataclass(frozen=True)
class Decay:
    """A state of a load that decays as it wears: dh/dn = 1 - h, from h = 0."""

    meshes: float
    depth: Any
    pace: float = 1.0
    error: float = 0.0
    stride: tuple[float, ...] = ()

    @property
    def worn(self):
        return Worn(np.atleast_1d(self.depth))


@dataclass(frozen=True)
class DecayTrial:
    start: Decay
    meshes: float
    loads: tuple
    worn: Worn
    pace: float


class Implicit:
    """Its first-order implicit steps, in the manner of `WearStepper`."""

    def __init__(self):
        self.steps = 0

    def fully_implicit(self, depth):
        return self

    def start(self):
        return Decay(0.0, 0.0)

    def trial(self, state, meshes, estimate=None, *, loads_after=None):
        self.steps += 1
        felt = meshes if loads_after is None else loads_after
        rate = (1.0 - state.depth) / (1.0 + felt)
        return DecayTrial(state, meshes, (rate,), Worn(np.array([state.depth + meshes * rate])), 1.0)

    def commit(self, trial):
        return Decay(trial.start.meshes + trial.meshes, float(trial.worn.driven[0]))

    def footprints_worn(self, state, meshes):
        """A depth that settles at the rate 1 is a ripple on footprints of the depth 1."""
        return meshes


class Ripples(Implicit):
    """Depths that settle at rates of their own: dh/dn = 1 - rate h."""

    def __init__(self, rates):
        super().__init__()
        self.rates = rates

    def start(self):
        return Decay(0.0, np.zeros_like(self.rates))

    def trial(self, state, meshes, estimate=None, *, loads_after=None):
        felt = meshes if loads_after is None else loads_after
        rate = (1.0 - self.rates * state.depth) / (1.0 + felt * self.rates)
        return DecayTrial(state, meshes, (rate,), Worn(state.depth + meshes * rate), 1.0)

    def commit(self, trial):
        return Decay(trial.start.meshes + trial.meshes, trial.worn.driven)


def exact(meshes):
    return 1.0 - math.exp(-meshes)


def of_length(length):
    """A step of a length, whose two stages tell its error."""
    stepper = Implicit()
    return measured(stepper, stepper.start(), length, lambda at, loads: stepper.trial(at, length - at.meshes, loads))


LENGTHS = pytest.mark.parametrize("length", [0.01, 0.1, 0.5, 2.0, 7.0, 50.0, 1e3, 1e6])


def stays(g, z):
    """What two stages leave of a difference that decays at the rate z."""
    return (1.0 + (1.0 - 2.0 * g) * z) / (1.0 - g * z) ** 2


@LENGTHS
def test_two_stages_err_no_more_than_they_say(length):
    step = of_length(length)
    depth = float(step.trial.worn.driven[0])
    assert 1.0 - depth == pytest.approx(stays(SECOND_ORDER, -length), abs=1e-12)
    assert step.trial.start.meshes + step.trial.meshes == pytest.approx(length)
    assert abs(depth - exact(length)) <= step.error * (1.0 + 1e-6)
    assert step.size == pytest.approx(depth)
    assert step.meshes == pytest.approx(length)
    change = (1.0 - SECOND_ORDER) * length**2 / (1.0 + SECOND_ORDER * length) ** 2
    assert step.error == pytest.approx(ERROR_SHARE * change)


@LENGTHS
def test_steps_in_two_stages_do_what_they_are_derived_for(length):
    stepper = TwoStageStepper(Implicit())
    state = stepper.step(stepper.start(), length)
    assert state.meshes == pytest.approx(length)
    assert 1.0 - state.depth == pytest.approx(stays(first_stage_of(length), -length), abs=1e-12)
    assert abs(state.depth - exact(length)) < min(0.047, 0.2 * length**2)


def greatest(g, footprints):
    """Error of two stages at rates up to so many footprints' depths."""
    z = -np.linspace(0.0, footprints, 4001)
    return np.abs(stays(g, z) - np.exp(z)).max()


@pytest.mark.parametrize("footprints", [one for one in FIRST_STAGES if one > 0.0])
def test_stages_err_least_over_the_rates_that_a_step_has(footprints):
    least = min(greatest(g, footprints) for g in np.linspace(0.25, 0.5, 2501))
    assert greatest(FIRST_STAGES[footprints], footprints) < 1.002 * least


@pytest.mark.parametrize("footprints", [0.1, 0.4, 0.75, 1.2, 2.5, 3.5, 7.0, 11.0])
def test_between_known_depths_stages_err_little_more(footprints):
    least = min(greatest(g, footprints) for g in np.linspace(0.25, 0.5, 2501))
    assert greatest(first_stage_of(footprints), footprints) < 1.05 * least


def test_the_stages_of_a_deep_step_err_least_at_any_rate():
    z, stage = -np.logspace(-3.0, 5.0, 4001), first_stage_of(1e9)
    error = np.abs(stays(stage, z) - np.exp(z)).max()
    assert error < min(np.abs(stays(g, z) - np.exp(z)).max() for g in np.linspace(0.25, 1.0, 301)) + 1e-4
    assert error < 0.25 * np.abs(1.0 / (1.0 - z) - np.exp(z)).max()
    assert first_stage_of(0.0) == SECOND_ORDER


def test_the_change_between_stages_covers_the_error_at_any_rate():
    z, g = -np.logspace(-2.0, 5.0, 40001), SECOND_ORDER
    first = z / (1.0 - g * z)  # rates of wear in the stages, of a difference of 1
    change = z * stays(g, z) - first
    np.testing.assert_allclose(change, (1.0 - g) * z**2 / (1.0 - g * z) ** 2)
    share = np.abs(stays(g, z) - np.exp(z)) / change
    assert share.max() <= ERROR_SHARE < 1.01 * share.max()
    assert z[share.argmax()] == pytest.approx(-3.5, abs=0.1)


@pytest.mark.parametrize("tolerance", [1e-1, 1e-2, 1e-3, 1e-4])
@pytest.mark.parametrize("rates", [np.ones(1), np.logspace(-2.0, 4.0, 25)], ids=["one rate", "of every size"])
def test_adaptive_steps_keep_their_tolerance(rates, tolerance):
    """Rates of every size as on a flank: ripples of every length, the shorter the faster."""
    adaptive = AdaptiveStepper(Ripples(rates), tolerance, 3.0)
    state = adaptive.step(adaptive.start(), 3.0)
    assert state.meshes == pytest.approx(3.0)
    settled = (1.0 - np.exp(-3.0 * rates)) / rates
    error = float(np.linalg.norm(state.depth - settled) / np.linalg.norm(settled))
    assert error <= state.error <= 1.01 * tolerance


def test_solutions_grow_no_faster_than_the_tolerance_shrinks():
    def solved(tolerance):
        adaptive = AdaptiveStepper(Implicit(), tolerance, 3.0)
        adaptive.step(adaptive.start(), 3.0)
        return adaptive.solved

    assert solved(1e-2) < solved(1e-4) <= 100.0 * solved(1e-2)


def test_an_early_step_may_err_by_more_and_what_came_before_counts_on():
    """Errors are told over the wear at the end of the run, and those of steps before stay, in part."""

    def stepped(end, error=0.0):
        adaptive = AdaptiveStepper(Implicit(), 1e-3, end)
        return adaptive, adaptive.step(replace(adaptive.start(), error=error), 0.3)

    (early, begun), (whole, ended) = stepped(3.0), stepped(0.3)
    assert early.solved < whole.solved
    assert stepped(3.0, 0.1)[1].error > begun.error
    assert stepped(0.3, 0.1)[1].error > ended.error


class ToDepth(Implicit):
    """The same, also to a depth; keeps the lengths that were tried, and after how much of them loads hold."""

    def __init__(self):
        super().__init__()
        self.asked = []

    def trial(self, state, meshes, estimate=None, *, loads_after=None):
        self.asked.append((meshes, loads_after))
        return super().trial(state, meshes, estimate, loads_after=loads_after)

    def trial_to_depth(self, state, point, depth, estimate=None):
        # depth + h = 1 - (1 - depth)/(1 + n)
        return super().trial(state, (1.0 - state.depth) / (1.0 - depth) - 1.0, estimate)

    def depth_at(self, point, wear):
        return float(wear[0])


class Watched:
    """The only point that there is."""

    def wear(self, worn):
        return worn.driven


def test_first_stages_are_a_share_of_the_predicted_step():
    stepper = ToDepth()
    adaptive = AdaptiveStepper(stepper, 0.4, 1.0)
    adaptive.step(stepper.start(), 0.25)
    assert stepper.asked[0] == pytest.approx(((1.0 - SECOND_ORDER) * 0.25, SECOND_ORDER * 0.25))
    stepper.asked.clear()
    adaptive.step_to_depth(stepper.start(), Watched(), 0.2)
    plain = stepper.trial_to_depth(stepper.start(), Watched(), 0.2).meshes
    assert plain == pytest.approx(0.25)
    assert stepper.asked[0] == pytest.approx(((1.0 - SECOND_ORDER) * plain, SECOND_ORDER * plain))


def test_adaptive_steps_go_on_where_the_last_ones_ended():
    adaptive = AdaptiveStepper(Implicit(), 1e-3, 3.0)
    state = adaptive.start()
    spent = []
    for _ in range(4):
        before = adaptive.solved
        state = adaptive.step(state, 0.75)
        spent.append(adaptive.solved - before)
    assert state.meshes == pytest.approx(3.0)
    assert abs(state.depth - exact(3.0)) <= 1e-3
    assert spent[-1] <= spent[0]


# ---------------------------------------------------------------- whole runs


COARSE_NUMBERS = SMALL | {"numerics.profile_points": 61}
TO_9_UM: dict[str, Any] = COARSE_NUMBERS | {"wear.until.control_depths_um": [3.0, 9.0]}
NOT_FITTED: dict[str, tuple[str, dict[str, Any]]] = {
    "spur pair": ("spur_fzg_c", COARSE_NUMBERS | {"wear.until.meshes": 1e9}),
    "both bodies": ("face_gear_25x160", TO_9_UM | {"wear.worn_bodies": ["pinion", "gear"]}),
    "tip": ("face_gear_25x160", TO_9_UM | {"wear.control_point.height_mm": 2.5}),
    "friction": ("face_gear_25x160", TO_9_UM | {"effects.friction": {}}),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", NOT_FITTED)
def test_adaptive_steps_tell_their_error_where_nothing_was_fitted(name):
    shipped, changes = NOT_FITTED[name]
    scene = sw.load_scene(shipped).replace(changes)
    told, near = (simulate_as_given(scene.replace({"numerics.accuracy": asked})) for asked in (0.03, 0.002))
    wear, reference = (tree["flank"].wear_depth.fillna(0.0) for tree in (told, near))
    flank = [dim for dim in wear.dims if dim != "wear_step"]
    error = np.sqrt(((wear - reference) ** 2).sum(flank) / (reference.isel(wear_step=-1) ** 2).sum())
    assert 0.0 < float(error.max()) <= float(told["diagnostics"].error_estimate.max()) <= 0.015


@pytest.fixture(scope="module")
def asked(spur):
    scene = spur.replace(TWO_DEPTHS | {"numerics.roll_positions": None, "numerics.accuracy": 0.4})
    return scene, sw.simulate(scene)


@pytest.mark.slow
def test_a_result_tells_its_error(asked):
    _, tree = asked
    estimate = tree["diagnostics"]["error_estimate"]
    # what would free a tip is advice, not a quantity whose error is asked for
    assert set(estimate["quantity"].values) == set(tree["history"].data_vars) - {"tip_relief_to_free"} | {"meshes"}
    assert (estimate.values >= 0.0).all()
    assert 0.0 < float(estimate.max()) <= 0.4
    assert tree.attrs["accuracy"].startswith("0.4 asked for")


@pytest.mark.slow
def test_what_it_tells_holds_over_the_ridges_of_two_flanks(shipped):
    """Both wear equally deep, and each keeps a ridge at the pitch line: no other figure asks for as many points."""
    k = shipped.wear.coefficient_mm2_per_N
    both = {"wear.worn_bodies": ["pinion", "gear"], "wear.coefficient_mm2_per_N": {"pinion": k / 6.4, "gear": k}}
    until = {"wear.until.control_depths_um": [30.0]}
    tree = sw.simulate(shipped.replace(both | until | {"numerics.accuracy": 0.05}))
    chosen = parse_scene(tree.attrs["scene_toml"])
    numbers = chosen.numerics
    finer = {
        "numerics.accuracy": None,
        "numerics.profile_points": 401,
        "numerics.roll_positions": 2 * numbers.roll_positions,
        "numerics.face_slices": 2 * numbers.face_slices - 1,
    }
    found = difference(history(tree), history(simulate_as_given(chosen.replace(finer))))
    estimate = tree["diagnostics"].error_estimate.sel(quantity="contact_pressure_pitch")
    assert max(found.values()) <= 0.05
    assert found["contact_pressure_pitch"] <= float(estimate)


@pytest.mark.slow
def test_given_numbers_stay_and_chosen_ones_are_in_the_scene_of_the_result(asked):
    _, tree = asked
    assert tree["flank"].sizes["face"] == 11
    assert tree["flank"].sizes["profile"] == 31
    used = parse_scene(tree.attrs["scene_toml"])
    assert used.numerics.roll_positions == tree["mesh_cycle"].sizes["mesh_position"]
    assert used.numerics.chosen_for_accuracy == ("wear_steps", "cells_per_half_width")
    np.testing.assert_allclose(tree["history"].wear_depth_control_point, [0.0, 2.0, 4.0], atol=1e-3)


@pytest.mark.slow
def test_an_accuracy_out_of_reach_is_an_error_that_holds_the_result(spur, monkeypatch):
    scene = spur.replace(TWO_DEPTHS | {"numerics.roll_positions": None, "numerics.accuracy": 0.01})
    within = tuple(replace(p, start=8, most=9) for p in resolution.PARAMETERS)
    monkeypatch.setattr(run, "parameters_of", lambda numerics: within[:1])
    with pytest.raises(sw.ConvergenceError, match=r"accuracy 0\.01 not reached") as caught:
        sw.simulate(scene)
    assert float(caught.value.result["diagnostics"]["error_estimate"].max()) > 0.01


def test_a_run_at_half_the_numbers_is_asked_where_the_coarse_ones_say_too_much(shipped, monkeypatch):
    """A quantity with an error of second order: from far away first order makes too much of it."""
    ran, steps_of = [], []

    def error(count):
        return 0.3 * (12.0 / count) ** 2

    def solve(scene, **_):
        ran.append(scene.numerics.roll_positions)
        steps_of.append((scene.numerics.accuracy, scene.numerics.wear_scheme))
        size = [1.0, 1.0 + error(ran[-1])]
        values = xr.Dataset({"contact_pressure_root": ("wear_step", size), "meshes": ("wear_step", [0.0, 1.0])})
        steps = xr.Dataset({"error_estimate": ("quantity", [0.0])}, {"quantity": ["contact_pressure_root"]})
        return xr.DataTree.from_dict({"/history": values, "/diagnostics": steps})

    within = resolution.parameters_of(shipped.numerics)
    monkeypatch.setattr(run, "parameters_of", lambda numerics: within[:1])
    monkeypatch.setattr(run, "simulate_as_given", solve)
    # one depth: the coarse runs see every state
    scene = shipped.replace(
        {"numerics.accuracy": 0.02, "numerics.roll_positions": None, "wear.until.control_depths_um": [60.0]}
    )
    tree = sw.simulate(scene)
    assert ran == [12, 24, 144, 72]
    assert steps_of == 2 * [(None, "two-stage")] + 2 * [(0.02, "implicit")], "coarse runs take the same steps"
    told = float(tree["diagnostics"].error_estimate.max())
    assert error(144) <= told <= 0.02


@pytest.mark.parametrize("own", [{"numerics.wear_steps": 3}, {"numerics.wear_scheme": "explicit"}])
def test_coarse_runs_leave_steps_alone_that_a_scene_gives(shipped, own):
    scene = shipped.replace({"numerics.accuracy": 0.02} | own)
    assert run._in_fixed_steps(scene) == scene
    free = run._in_fixed_steps(shipped.replace({"numerics.accuracy": 0.02}))
    assert (free.numerics.accuracy, free.numerics.wear_scheme) == (None, "two-stage")


@pytest.mark.slow
def test_a_stopped_run_to_an_accuracy_goes_on(asked, tmp_path):
    scene, undisturbed = asked
    file = tmp_path / "kept"

    class Stopper:
        def step(self, done, total, text):
            if text.endswith("control point"):
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sw.simulate(scene, progress=Stopper(), checkpoint=file)
    assert peek(file).finished == 1
    assert different_variables(sw.simulate(scene, checkpoint=file, resume=True), undisturbed) == []
    assert run.round_checkpoint(file, 2) == tmp_path / "kept.3"
    with pytest.raises(sw.SceneError, match="give checkpoint=FOLDER"):
        sw.simulate(scene, resume=True)


@pytest.mark.slow
@pytest.mark.parametrize("positions", [8, 9, 10, 16])
def test_a_number_just_above_the_coarsest_is_judged_by_a_finer_one(positions):
    """Nine roll positions beside eight tell of scatter, and Richardson's factor multiplies it tenfold."""
    scene = sw.load_scene("spur_fzg_c").replace(
        {
            "numerics.accuracy": 0.2,
            "numerics.face_slices": 16,
            "numerics.profile_points": 81,
            "numerics.roll_positions": positions,
            "numerics.wear_steps": 3,
        }
    )
    tree = sw.simulate(scene)
    assert 0.05 < float(tree["diagnostics"].error_estimate.max()) < 0.2


@pytest.mark.slow
def test_numbers_that_are_all_given_are_judged():
    given = {"face_slices": 11, "roll_positions": 8, "profile_points": 31, "harmonics": 5, "wear_steps": 1}
    scene = sw.load_scene("spur_fzg_c").replace(
        {"numerics.accuracy": 0.001} | {f"numerics.{name}": value for name, value in given.items()}
    )
    asked, estimated = re.findall(r"[\d.]+", sw.simulate(scene).attrs["accuracy"])
    assert asked == "0.001" and float(estimated) > 0.05


@pytest.mark.slow
def test_the_command_line_runs_to_an_accuracy(spur, tmp_path, capsys):
    file, output = tmp_path / "scene.toml", tmp_path / "worn.nc"
    file.write_text(spur.replace(TWO_DEPTHS | {"numerics.accuracy": 0.4}).to_toml(), encoding="utf-8")
    assert main(["run", str(file), "-o", str(output)]) == 0
    assert "0.4 asked for" in sw.open_results(output).attrs["accuracy"]
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["scene.toml", "worn.nc"]
