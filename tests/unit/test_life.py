"""Life until a depth of wear: against a plain run, and against what scales with what."""

from dataclasses import dataclass, replace
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest

import semiwear as sw
from semiwear.errors import ConvergenceError, EndlessWearError
from semiwear.life import _Counter, _life_along, _Path, _under, _zero_of, find_life, step_lengths_to
from semiwear.meshing.flank_pair import DRIVEN, DRIVING
from semiwear.plan import Compared, Plan, plan
from semiwear.wear.step_count import life_steps_for_depth, steps_of_life
from semiwear.wear.two_stage import TwoStageStepper
from semiwear.wear.worn import Worn
from tests.scenes import TINY, Heard

life_module = import_module("semiwear.life")

LIFE = TINY | {
    "wear.until.meshes": 1e8,
    "wear.control_point": None,
    "numerics.wear_steps": 1,
    "effects.run_life.depth_limit_um": 10.0,
}


@pytest.fixture(scope="module")
def tiny(shipped):
    return shipped.replace(LIFE)


@pytest.fixture(scope="module")
def tree(tiny):
    return sw.simulate(tiny.replace({"operation.pinion_speed_rpm": 1500.0}))


def life_of(scene):
    physics = plan(scene)
    return find_life(physics, physics.wear_stepper(physics.loaded_teeth()))


@pytest.fixture(scope="module")
def life(tiny):
    return life_of(tiny)


def test_a_run_of_that_many_meshes_wears_to_the_limit(tiny, tree):
    """In as many plain steps, of equal length: on so coarse a grid their lengths matter by some per cent."""
    meshes = float(tree["life"]["meshes_to_limit"])
    run = sw.simulate(tiny.replace({"wear.until.meshes": meshes, "numerics.wear_steps": 3, "effects.run_life": None}))
    greatest = float(run["flank"]["wear_depth"].isel(wear_step=-1).sel(body="gear").max())
    assert greatest == pytest.approx(10.0, rel=0.05)
    assert "life" not in run.children


@pytest.mark.slow
@pytest.mark.parametrize("limit_um", [8.0, 20.0])
def test_six_steps_find_the_life_of_many(tiny, limit_um):
    """Three of them are up to 5 % long, three plain ones 8 %."""
    physics = plan(tiny.replace({"numerics.face_slices": 21, "numerics.profile_points": 71}))
    stepper, limit = physics.wear_stepper(physics.loaded_teeth()), 1e-3 * limit_um
    few = step_lengths_to(stepper, DRIVEN, limit)
    assert len(few) == 6
    many = sum(step_lengths_to(stepper, DRIVEN, limit, [sum(few) / 32] * 32))
    assert sum(few) == pytest.approx(many, rel=0.01)


def test_the_last_step_ends_at_the_limit(tiny):
    physics = plan(tiny)
    stepper = physics.wear_stepper(physics.loaded_teeth())
    state = stepper.start()
    for length in step_lengths_to(stepper, DRIVEN, 10e-3):
        assert state.wear.max() < 10e-3
        state = TwoStageStepper(stepper).step(state, length)
    assert state.wear.max() == pytest.approx(10e-3, rel=1e-5)


@pytest.fixture
def made(monkeypatch):
    """A stepper of a gear whose greatest depth over the meshes is given."""

    def stepper(depth):
        def state(meshes):
            return SimpleNamespace(meshes=meshes, worn=Worn(np.array([0.0, depth(meshes)]), None))

        scheme = SimpleNamespace(start=lambda: state(0.0), step=lambda begin, length: state(begin.meshes + length))
        monkeypatch.setattr(life_module, "TwoStageStepper", lambda _: scheme)
        return SimpleNamespace(teeth=SimpleNamespace(pair=SimpleNamespace(base_pitch=14.0)))

    return stepper


def test_even_wear_takes_steps_of_one_length(made):
    steps = life_steps_for_depth(0.06, 14.0)
    assert steps == 10
    np.testing.assert_allclose(step_lengths_to(made(lambda n: 2e-9 * n), DRIVEN, 0.06), [3e7 / steps] * steps)


@pytest.mark.parametrize("power", [0.6, 1.3])
def test_wear_that_slows_down_or_speeds_up_has_the_life_at_which_it_reaches_the_limit(made, power):
    lengths = step_lengths_to(made(lambda n: 0.02 * (n / 1e7) ** power), DRIVEN, 0.06)
    assert sum(lengths) == pytest.approx(1e7 * 3.0 ** (1.0 / power), rel=1e-4)


@pytest.mark.parametrize("more", [0.01, 0.2])  # what is missed is made good by the wear rate, or searched for
def test_another_torque_has_the_life_at_which_it_reaches_the_limit(made, more):
    """Wear in proportion to the torque, after something more at the beginning."""
    path, rate = _Path([1e7, 2e7], 2e-9, []), 1.05 * 2e-9
    found = _life_along(made(lambda n: more * 0.06 + rate * n), DRIVEN, 0.06, path, 1.05, _Counter(None, 0, ""))
    assert found == pytest.approx((1.0 - more) * 0.06 / rate, rel=1e-4)


@pytest.mark.parametrize(("deepest", "words"), [(0.0, "at 0 um of 60 um"), (0.03, "at 30 um of 60 um")])
def test_a_flank_that_stops_wearing_before_the_limit_says_where(made, deepest, words):
    with pytest.raises(EndlessWearError, match=f"the gear wears no further {words}"):
        step_lengths_to(made(lambda n: min(2e-9 * n, deepest)), DRIVEN, 0.06)


@dataclass(frozen=True)
class Planned:
    """In place of a stepper: the plan that it is of."""

    physics: Plan
    implicit: bool = False


def test_another_torque_is_that_of_every_level_and_run_as_the_torque_itself(tiny, monkeypatch):
    spectrum = {"torques_Nm": [800.0, 1600.0], "shares": [0.25, 0.75]}
    scene = tiny.replace({"effects.load_spectrum": spectrum})
    monkeypatch.setattr(Plan, "loaded_teeth", lambda _: None)
    monkeypatch.setattr(Plan, "wear_stepper", lambda physics, _: Planned(physics))
    for compared in (None, Compared.with_runs_of(scene)):
        found = _under(replace(plan(scene), compared=compared), 1.05)
        assert found.implicit and found.physics.compared == compared
        assert found.physics.scene.effects.load_spectrum.torques_Nm == pytest.approx((840.0, 1680.0))
        assert found.physics.scene.operation.pinion_torque_Nm == pytest.approx(1.05 * 1600.0)


def test_hours_are_turns_of_the_gear(tree):
    life = tree["life"]
    gear_rpm = 1500.0 * 25 / 160
    assert float(life["hours_to_limit"]) == pytest.approx(float(life["meshes_to_limit"]) / gear_rpm / 60.0)


def test_without_a_speed_there_are_no_hours(life, tree):
    assert life.hours is None
    assert life.meshes == pytest.approx(float(tree["life"]["meshes_to_limit"]))


@pytest.mark.slow
def test_the_wear_coefficient_counts_only_times_the_meshes(tiny, life):
    """Also where a law acts through the depth."""
    scene = tiny.replace({"effects.wear_law.hardness": {"case_depth_um": 4.0}})
    plain, life = life, life_of(scene)
    assert life.meshes < 0.9 * plain.meshes
    more = life_of(scene.replace({"wear.coefficient_mm2_per_N": 1.5e-13}))
    assert np.log(more.meshes / life.meshes) / np.log(1.5) == pytest.approx(life.sensitivity_to_wear_coefficient)


def test_at_a_depth_of_nothing_torque_acts_as_on_the_unworn_wear_rate(tiny):
    """The greatest wear of a few meshes, of scenes that are built anew under the other torques."""
    short = tiny.replace({"effects.run_life.depth_limit_um": 1e-5})
    few = {"wear.until.meshes": 3.0, "numerics.wear_steps": 3, "effects.run_life": None}
    rates = [
        float(
            sw.simulate(tiny.replace(few | {"operation.pinion_torque_Nm": factor * 1600.0}))["flank"][
                "wear_depth"
            ].max()
        )
        for factor in (0.95, 1.05)
    ]
    expected = -np.log(rates[1] / rates[0]) / np.log(1.05 / 0.95)
    assert life_of(short).sensitivity_to_torque == pytest.approx(expected, rel=0.01)


@pytest.mark.slow
def test_a_spectrum_of_one_torque_is_that_torque(tiny, life):
    spectrum = {"torques_Nm": [1600.0], "shares": [1.0]}
    same = life_of(tiny.replace({"effects.load_spectrum": spectrum}))
    assert same.meshes == pytest.approx(life.meshes, rel=1e-4)
    assert same.sensitivity_to_torque == pytest.approx(life.sensitivity_to_torque, abs=0.01)


@pytest.mark.slow
def test_the_life_of_the_pinion(tiny):
    scene = tiny.replace(
        {"wear.worn_bodies": ["pinion", "gear"], "effects.run_life": {"body": "pinion", "depth_limit_um": 2.0}}
    )
    physics = plan(scene)
    stepper = physics.wear_stepper(physics.loaded_teeth())
    state = stepper.start()
    for length in step_lengths_to(stepper, DRIVING, 2e-3):
        state = TwoStageStepper(stepper).step(state, length)
    assert state.worn.driving.max() == pytest.approx(2e-3, rel=1e-4)


@pytest.mark.slow
def test_a_limit_beyond_the_tooth_says_what_to_change(tiny):
    with pytest.raises(ConvergenceError, match=r"run_life.*depth_limit_um") as caught:
        sw.simulate(tiny.replace({"effects.run_life.depth_limit_um": 2000.0}))
    assert caught.value.result["history"].sizes["wear_step"] == 2


@pytest.mark.parametrize("trial", [0.01, 0.9, 30.0])
@pytest.mark.parametrize("function", [lambda x: x - 2.0, lambda x: x**5 - 32.0, lambda x: np.tanh(x - 2.0)])
def test_the_search_finds_the_zero(function, trial):
    assert _zero_of(function, function(0.0), trial, 1e-9) == pytest.approx(2.0, rel=1e-6)


def test_the_search_ends_where_depths_jump_across_the_limit():
    found = _zero_of(lambda x: x - 2.0 + (1e-3 if x > 1.9999 else -1e-3), -2.0, 1.0, 1e-6)
    assert found == pytest.approx(1.9999, rel=2e-5)


@pytest.mark.slow
def test_the_shipped_scene_has_a_life_although_depths_jump_at_its_end(shipped):
    """At 10 um, by 1.5e-4 of it; a run of as many meshes wears that deep."""
    found = life_of(shipped.replace({"effects.run_life.depth_limit_um": 10.0}))
    assert -1.5 < found.sensitivity_to_torque < -0.7
    until = {"wear.until.control_depths_um": None, "wear.until.meshes": found.meshes, "numerics.wear_steps": 12}
    run = sw.simulate(shipped.replace(until))
    assert float(run["flank"]["wear_depth"].max()) == pytest.approx(10.0, rel=0.03)


def test_a_search_without_a_zero_gives_up():
    with pytest.raises(ConvergenceError, match="loses its load"):
        _zero_of(lambda x: -1.0 - 1.0 / (1.0 + x), -2.0, 1.0, 1e-6)


def test_it_takes_the_steps_that_the_plan_says_and_tells_of_them(tiny, life, monkeypatch):
    """Three lives to the limit: one is searched for, those of other torques follow from where its steps lead."""
    taken, heard = [], Heard()
    step = TwoStageStepper.step

    def counted(self, state, meshes):
        taken.append(meshes)
        return step(self, state, meshes)

    monkeypatch.setattr(TwoStageStepper, "step", counted)
    tree = sw.simulate(tiny, progress=heard)
    assert float(tree["life"]["meshes_to_limit"]) == pytest.approx(life.meshes)
    told = steps_of_life(10e-3, plan(tiny).flank_pair().base_pitch)
    assert len(taken) <= told + 2
    assert f"costs about {told} wear steps" in " ".join(str(plan(tiny)).split())
    steps = [(done, total) for done, total, text in heard.steps if text.startswith("life until 10 um")]
    assert steps[-1] == (told, told) and sorted(steps) == steps and len(steps) >= 9
    one_life = life_steps_for_depth(10e-3, plan(tiny).flank_pair().base_pitch)
    assert "at 0.95 of the torque" in heard.steps[-one_life - 1][2] + heard.steps[-one_life - 2][2]


@pytest.mark.slow
def test_the_shorter_search_finds_what_torque_does_as_whole_searches_do(tiny, life):
    """Lives under both torques, each searched for to its end."""
    physics = [plan(tiny.replace({"operation.pinion_torque_Nm": factor * 1600.0})) for factor in (0.95, 1.05)]
    lives = [sum(step_lengths_to(one.wear_stepper(one.loaded_teeth()), DRIVEN, 10e-3)) for one in physics]
    expected = np.log(lives[1] / lives[0]) / np.log(1.05 / 0.95)
    assert life.sensitivity_to_torque == pytest.approx(expected, abs=0.02)
