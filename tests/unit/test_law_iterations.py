"""How a wear law and the loads settle upon each other: steep laws, and friction in the loads."""

import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import semiwear as sw
from semiwear.contact import frictional_contact
from semiwear.contact.frictional_contact import FrictionalContact
from semiwear.life import find_life
from semiwear.wear import case_step
from semiwear.wear.settling import Settling
from tests.scenes import SMALL, TINY, UNTIL_MESHES, scene_of

RUBBING = scene_of(
    SMALL,
    {"wear.until.control_depths_um": [8.0, 20.0], "effects.wear_law.load": {"exponent": 0.5}, "effects.friction": {}},
    wears=True,
)


def history(scene: sw.Scene) -> dict[str, np.ndarray]:
    group = sw.simulate(scene)["history"]
    return {name: group[name].values for name in ("wear_depth_max", "wear_volume", "load_share_max", "meshes")}


@pytest.fixture
def counted(monkeypatch):
    """How often the moment of friction is worked out, and loads are found under a law."""
    counts = {"moments": 0, "solutions": 0}
    moment, solve = FrictionalContact.moment, case_step.CaseStep._solve

    def counting(*arguments):
        counts["moments"] += 1
        return moment(*arguments)

    def solving(*arguments):
        counts["solutions"] += 1
        return solve(*arguments)

    monkeypatch.setattr(FrictionalContact, "moment", counting)
    monkeypatch.setattr(case_step.CaseStep, "_solve", solving)
    return counts


def test_torque_is_balanced_roughly_until_a_law_has_settled_and_to_the_last_then(monkeypatch, counted):
    loads_of = case_step.CaseStep.loads
    missed: dict[bool, list[float]] = {True: [], False: []}

    def checked(self, meshes, positions, start, *, roughly=False):
        found, problem = loads_of(self, meshes, positions, start, roughly=roughly), self.case.teeth.problem
        borne = (found.force * problem.lines.lever_arm).sum(axis=1).reshape(-1, problem.per_cycle).sum(axis=0)
        moment = self.case.teeth.fidelity.solve.moment(problem, found, self.state.coarse)
        at = slice(None) if positions is None else list(positions)
        missed[roughly].append(np.abs((borne + moment) / problem.torque - 1.0)[at].max())
        return found

    rough, moments = history(RUBBING), counted["moments"]
    with monkeypatch.context() as patched:
        patched.setattr(case_step.CaseStep, "loads", checked)
        sw.simulate(RUBBING)
    assert max(missed[False]) < 1e-9
    assert 1e-9 < max(missed[True]) < 1e-3  # where a start or a length is looked for
    counted["moments"] = 0
    monkeypatch.setattr(frictional_contact, "ROUGHLY", frictional_contact._TOLERANCE)
    close = history(RUBBING)
    assert moments < 0.75 * counted["moments"]
    for name, values in rough.items():
        np.testing.assert_allclose(values, close[name], rtol=1e-4, atol=1e-12)


def test_a_law_settles_in_a_few_solutions_and_within_its_tolerance(monkeypatch, counted):
    """Each by what the last changes say; a half of every change takes twice as many."""
    mixed = history(RUBBING)
    few = counted["solutions"]
    monkeypatch.setattr(Settling, "after", lambda self, value, change, *_: value + 0.5 * change)
    counted["solutions"] = 0
    halves = history(RUBBING)
    assert few < 0.8 * counted["solutions"]
    monkeypatch.setattr(case_step, "_FACTOR_TOLERANCE", 1e-8)
    exact = history(RUBBING)
    for name, values in exact.items():
        scale = np.nanmax(np.abs(values))
        error, before = (float(np.nanmax(np.abs(one[name] - values))) / scale for one in (mixed, halves))
        assert error < max(2e-4, before)


@given(*(arrays(float, 6, elements=st.floats(0.0, 3.0, allow_subnormal=False)) for _ in range(4)))
def test_mixed_factors_stay_factors(value, wanted, last, last_wanted):
    """Never below zero, where nothing would bear; where changes grow they go half of the way."""
    change, last_change = wanted - value, last_wanted - last
    iteration = Settling()
    assert (iteration.after(last, last_change, 0.0) == last + 0.5 * last_change).all()
    mixed = iteration.after(value, change, 0.0)
    assert (mixed >= 0.0).all()
    if np.sum(change**2) > np.sum(last_change**2):
        assert (mixed == value + 0.5 * change).all()


@pytest.mark.parametrize("rates", [[-0.4, -0.4, -0.4], [-0.4, -0.6, -0.6], [-0.1, -0.4, 0.3]])
def test_as_many_changes_as_there_are_rates_tell_where_a_linear_iteration_ends(rates):
    fixed, value, iteration = np.array([0.3, 1.2, 0.8]), np.ones(3), Settling()
    for _ in range(len(set(rates)) + 1):
        change = (np.array(rates) - 1.0) * (value - fixed)
        value = iteration.after(value, change, 0.0)
    np.testing.assert_allclose(value, fixed, rtol=1e-12)


@given(
    *(arrays(float, 5, elements=st.floats(*ends, allow_subnormal=False)) for ends in ((0.01, 1e3), (0.0, 50.0))),
    st.floats(0.0, 0.3),
)
def test_steep_changes_settle_one_by_one(most, steep, others):
    """x = a exp(-b x) with a little of the other elements in it: where b a is great, mixed changes run in a cycle."""

    def change(value):
        return most * np.exp(-steep * (value + others * (value.mean() - value))) - value

    value, iteration = np.ones(5), Settling()
    for _ in range(120):
        found = change(value)
        if np.abs(found).max() <= 1e-3 * value.max():
            break
        value = iteration.after(value, found, 1e-3 * value.max())
    else:
        raise AssertionError("it does not settle")
    assert (value >= 0.0).all()


def test_bounds_that_were_wrong_are_let_go():
    """The fixed point moves away from between its bounds, up or down."""
    for start, end in ((1.0, 30.0), (30.0, 1.0)):
        value, iteration = np.array([5.0]), Settling()
        for number in range(120):
            fixed = start if number < 40 else end
            value = iteration.after(value, np.array([fixed - value[0]]), 1e-3)
        np.testing.assert_allclose(value, end, rtol=1e-3)


STEEP = scene_of(
    TINY,
    {
        "numerics.tooth_compliance": "rigid",
        "operation.pinion_torque_Nm": 2800.0,
        "operation.pinion_speed_rpm": 3000.0,
        "effects.flash_temperature": {"friction_coefficient": 0.1},
        "effects.wear_law.temperature": {"activation_energy_kJ_per_mol": 50.0},
        "effects.wear_law.load": {"exponent": 1.0},
    },
    wears=True,
)


def test_wear_that_grows_steeply_with_the_load_is_found_in_steps_of_any_length():
    """Changes that are mixed alone run in a cycle here."""
    two, ten = (
        sw.simulate(STEEP.replace({"wear.until.control_depths_um": list(np.linspace(0.0, 20.0, steps + 1)[1:])}))
        for steps in (2, 10)
    )
    for one in (two, ten):
        assert 0.0 < one["diagnostics"].wear_law_residual.values.max() <= case_step._FACTOR_TOLERANCE
    for name, within in {"wear_depth_max": 0.05, "meshes": 0.03, "contact_pressure_pitch": 0.005}.items():
        few, many = (one["history"][name].values[-1] for one in (two, ten))
        np.testing.assert_allclose(few, many, rtol=within)


@pytest.mark.parametrize("fidelity", ["line", pytest.param("patch", marks=pytest.mark.slow)])
@pytest.mark.parametrize("meshes", [1e9, 1e10, 1e11, 1e12, 1e13])
def test_tangents_find_the_loads_that_bounds_find(monkeypatch, fidelity, meshes):
    """Steps in which a film comes to carry all load, and slices lie at its kinks."""
    film = {"effects.lubrication.roughness_um": 0.15, "effects.wear_law.lubrication.full_film_lambda": 1.0}
    ends = {"wear.until.meshes": meshes, "operation.pinion_speed_rpm": 1500.0, "numerics.fidelity": fidelity}
    physics = sw.plan(scene_of(SMALL, UNTIL_MESHES, ends | film, wears=True))
    stepper = replace(physics.wear_stepper(physics.loaded_teeth()), implicit=True)
    start = stepper.start()
    found = stepper.trial(start, meshes)
    after = Settling.after
    monkeypatch.setattr(Settling, "after", lambda self, value, change, least, _: after(self, value, change, least))
    bounded = stepper.trial(start, meshes)
    assert max(found.law_residual, bounded.law_residual) <= case_step._FACTOR_TOLERANCE
    np.testing.assert_allclose(found.worn.driven, bounded.worn.driven, atol=2e-3 * found.worn.driven.max())


SPUR = {"numerics.face_slices": 11, "numerics.roll_positions": 12, "numerics.profile_points": 61}
SPUR |= {"numerics.harmonics": 5, "operation.pinion_speed_rpm": 1500.0}


@cache
def life_of_film(roughness_um):
    """The life of the spur pair under a film on so rough flanks."""
    film = {"effects.lubrication": {"roughness_um": roughness_um}, "effects.run_life.depth_limit_um": 4.0}
    film |= {"effects.wear_law.lubrication.full_film_lambda": 1.0, "operation.pinion_torque_Nm": 200.0}
    physics = sw.plan(sw.load_scene("spur_fzg_c").replace(SPUR | film))
    return find_life(physics, physics.wear_stepper(physics.loaded_teeth()))


@pytest.mark.parametrize("roughness", [0.12, *(pytest.param(um, marks=pytest.mark.slow) for um in (0.15, 0.165))])
def test_a_film_that_carries_nearly_all_load_leaves_a_long_life_or_one_without_end(roughness):
    """Bounds alone let the law change by up to 7 % to the last, and ended in an error."""
    found = life_of_film(roughness)
    assert found.meshes > 3.0 * life_of_film(0.18).meshes
    assert max(state.law_residual for state in found.states) <= case_step._FACTOR_TOLERANCE


@pytest.mark.slow
def test_a_rougher_flank_has_a_shorter_life():
    """A last step of up to 30000 times the meshes before it gave 5.8e12, no end, 9.4e12, 1.4e10, 1.6e13, 2e10 ..."""
    lives = [life_of_film(um).meshes for um in (0.11, 0.12, 0.13, 0.14, 0.15, 0.17, 0.18, 0.19, 0.2)]
    assert lives[:5] == [np.inf] * 5
    assert np.all(np.diff(lives[4:]) < 0.0)


def test_a_full_film_everywhere_leaves_no_wear_and_no_warning():
    scene = scene_of(
        TINY,
        UNTIL_MESHES,
        {
            "wear.until.meshes": 1e8,
            "operation.pinion_speed_rpm": 3000.0,
            "effects.lubrication": {"viscosity_mPas": 100.0, "roughness_um": 0.05},
            "effects.wear_law.lubrication": {"strength": 1.0},
        },
        wears=True,
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        history = sw.simulate(scene)["history"]
    assert float(history.lambda_ratio_min.min()) > 4.0
    assert float(history.wear_depth_max.max()) == 0.0
