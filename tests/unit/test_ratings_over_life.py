"""Failure modes over the life: life curves, Miner's sum, when they fail, and how they stand in a run."""

from functools import partial
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import semiwear as sw
from semiwear.errors import EndlessWearError, SceneError
from semiwear.life import Life, life_group
from semiwear.plan import Plan, plan
from semiwear.ratings.bending import bending_curve
from semiwear.ratings.contact import RatedContact, RatedFlanks
from semiwear.ratings.failure import first_failure, meshes_to_failure
from semiwear.ratings.life_curve import LifeCurve
from semiwear.ratings.miner import StressHistory
from semiwear.ratings.mode import life_exponent
from semiwear.ratings.pitting import PitchPoint, Pitting, pitting_curve
from semiwear.results.rating_errors import safety_and_life_errors
from semiwear.scene.rating_tables import RatingTable
from semiwear.screen_ratings import nearness
from tests.scenes import problems_of
from tests.strategies.ratings import BENDING, PITTING
from tests.strategies.ratings import RATED_SPUR as SMALL
from tests.strategies.results import synthetic_tree

life_module = import_module("semiwear.life")
SLOPE = 13.22  # of the curve below: one power law from static strength to the end
CURVE = LifeCurve((1e5, 5e7), (1600.0, 1600.0 * 500.0 ** (-1.0 / SLOPE)))
ISO = pitting_curve(1500.0, "hardened", 0.85, 1.0, 1.0)


@pytest.fixture(scope="module")
def small():
    return sw.simulate(SMALL)


def history(stress, cycles, shares=(1.0,), curve=ISO):
    stress = np.asarray(stress, float)
    return StressHistory(
        np.asarray(cycles, float), np.asarray(shares), stress.reshape(len(cycles), len(shares), -1), curve
    )


# ---------------------------------------------------------------- life curves


@given(st.floats(1e5, 1e10), st.sampled_from(["hardened", "hardened_some_pits", "nitrided"]), st.floats(0.85, 0.99))
def test_the_life_is_the_inverse_of_the_permissible_stress(cycles, group, at_end):
    curve = pitting_curve(1200.0, group, at_end, 0.93, 1.0)
    cycles = max(cycles, curve.cycles[0] * 1.001)
    damage = curve.damage_per_cycle(np.log(curve.permissible(cycles)))
    assert damage * cycles == pytest.approx(1.0, rel=1e-6)


def test_a_curve_begins_at_static_strength_and_ends_in_endurance():
    stress = np.array([np.log(ISO.static * 1.001), np.log(ISO.endured * 0.999), -np.inf])
    assert ISO.damage_per_cycle(stress).tolist() == [np.inf, 0.0, 0.0]
    assert ISO.permissible(1.0) == pytest.approx(1.6 * 1500.0)
    assert ISO.permissible(1e12) == pytest.approx(0.85 * 1500.0)


def test_a_curve_that_is_flat_at_its_end_is_endured_from_the_reference_on():
    flat = bending_curve(430.0, "case_hardened", 1.0, 1.0, 1.0, 1.0)
    assert flat.damage_per_cycle(np.log([859.9])).item() == 0.0
    assert 1.0 / flat.damage_per_cycle(np.log([860.1])).item() == pytest.approx(3e6, rel=0.01)


def test_influences_count_from_the_reference_on_and_not_in_static_strength():
    with_oil, without = (pitting_curve(1500.0, "hardened", 0.85, film, 1.0) for film in (0.9, 1.0))
    ratio = with_oil.permissible([1e4, 5e7, 1e10]) / without.permissible([1e4, 5e7, 1e10])
    assert ratio == pytest.approx([1.0, 0.9, 0.9])
    assert pitting_curve(1500.0, "hardened", 0.85, 1.0, 1.1).permissible(1e3) == pytest.approx(1.1 * 2400.0)


def test_each_flank_has_the_curve_of_its_own_group_of_materials():
    table = SMALL.replace({"effects.pitting.gear_life_curve": "nitrided"}).effects.pitting
    pinion, gear = Pitting.of(table, PitchPoint(10.0, 5.0)).curves
    # straight to 5e7 and 2e6 cycles: 1.6 and 1.3 at 1e5, and then to 0.85 at 1e10
    assert pinion.cycles == (1e5, 5e7, 1e10) and gear.cycles == (1e5, 2e6, 1e10)
    assert (pinion.static, gear.static) == pytest.approx((1.6 * 1500.0, 1.3 * 1450.0))


def test_nothing_is_permissible_above_static_strength_whatever_the_film():
    low, high = (pitting_curve(1000.0, "nitrocarburized", 0.85, film, 1.0) for film in (1.0, 1.164))
    assert high.stress[:2] == pytest.approx((1100.0, 1100.0)) and high.cycles[0] == 1e5
    # from there on the falling branch is that of the film: 1.164 of what it is without
    beyond = np.geomspace(high.cycles[1], 1e10, 5)
    assert high.permissible(beyond) == pytest.approx(1.164 * low.permissible(beyond))
    safety, _ = history([900.0, 900.0], [0.0, 3e8], curve=high).least_safeties()
    assert safety[1] == pytest.approx(high.permissible(3e8) / 900.0, rel=1e-6)
    whole = pitting_curve(1000.0, "nitrided", 1.0, 1.4, 1.0)
    assert set(whole.stress) == {1300.0} and whole.permissible(1e12) == 1300.0


# ---------------------------------------------------------------- Miner's sum


@given(st.floats(500.0, 3000.0), st.floats(1e3, 1e11))
def test_under_one_stress_the_safety_is_that_of_the_standard(stress, cycles):
    found, _ = history([stress, stress], [0.0, cycles]).least_safeties()
    assert found[1] == pytest.approx(ISO.permissible(cycles) / stress, rel=1e-6)
    assert found[0] == pytest.approx(ISO.static / stress, rel=1e-6)


@given(st.lists(st.tuples(st.floats(0.05, 1.0), st.floats(700.0, 1300.0)), min_size=2, max_size=4))
def test_a_spectrum_on_one_power_law_has_a_closed_form(bins):
    shares, stress = np.array(bins).T
    shares = shares / shares.sum()
    cycles = 3e6
    # D(S) = sum N s_i (S sigma_i)^p / (N_0 sigma_0^p) = 1
    power = cycles * np.sum(shares * stress**SLOPE) / (CURVE.cycles[0] * CURVE.static**SLOPE)
    expected = min(power ** (-1.0 / SLOPE), CURVE.static / stress.max())
    raised = expected * stress
    if raised.min() < CURVE.endured:  # below the end of the curve nothing counts
        return
    found, _ = history([stress, stress], [0.0, cycles], shares, CURVE).least_safeties()
    assert found[1] == pytest.approx(expected, rel=1e-6)


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 7, 200]))
def test_the_least_safety_is_that_of_the_worst_point(seed, points):
    draw = np.random.default_rng(seed)
    cycles = np.cumsum([0.0, *draw.uniform(1e4, 1e9, 3)])
    stress = draw.uniform(600.0, 2300.0, (4, 2, points))
    whole = history(stress, cycles, (0.3, 0.7))
    least, worst = whole.least_safeties()
    for step in range(1, 4):
        alone = history(stress[: step + 1], cycles[: step + 1], (0.3, 0.7)).safeties()
        assert alone.min() == pytest.approx(least[step], rel=1e-4)
        assert alone[worst[step]] == pytest.approx(least[step], rel=1e-4)
    # as much damage as that safety allows, or static strength
    assert whole.damages(least[-1] * (1.0 - 1e-7))[-1] <= 1.0
    assert whole.damages(least[-1] * (1.0 + 1e-6))[-1] >= 1.0


def test_the_worst_point_need_not_have_one_of_the_greatest_stresses():
    """A hundred points are stressed more, for a short while; few of them are looked at first."""
    cycles = [0.0, 1e4, 2e4, 1e8]
    stress = np.zeros((4, 1, 101))
    stress[:2, 0, :100] = np.linspace(1300.0, 1310.0, 100)
    of_these = history(stress, cycles).least_safeties()[0][-1]
    stress[:, 0, 100] = 1.05 * ISO.permissible(cycles[-1]) / of_these
    whole = history(stress, cycles)
    least, worst = whole.least_safeties()
    each = whole.safeties()
    assert stress[0, 0, 100] < 1000.0 and worst.tolist() == [99, 99, 99, 100]
    assert each.argmin() == 100 and least[-1] == pytest.approx(each.min(), rel=1e-4)
    assert least[-1] == pytest.approx(of_these / 1.05, rel=1e-4)


def test_points_without_stress_are_not_rated():
    nothing = np.array([[[np.nan, 0.0]], [[np.nan, 0.0]]])
    found, point = history(nothing, [0.0, 1e8]).least_safeties()
    assert np.isnan(found).all() and (point == -1).all()
    some = np.array([[[np.nan, 900.0]], [[1000.0, np.nan]]])
    found, point = history(some, [0.0, 1e8]).least_safeties()
    assert np.isfinite(found).all() and point.tolist() == [1, 0]


def test_growing_stress_converges_with_the_square_of_the_wear_steps():
    """Stress that grows in proportion to the cycles, on one power law: the damage is an integral in closed form."""
    whole, low, high = 2e6, 1200.0, 1400.0
    p = SLOPE
    integral = (high ** (p + 1) - low ** (p + 1)) / ((p + 1) * (high - low))
    exact = (whole * integral / (CURVE.cycles[0] * CURVE.static**p)) ** (-1.0 / p)
    errors = []
    for steps in (2, 4, 8, 16):
        at = np.linspace(0.0, 1.0, steps + 1)
        found, _ = history(low + (high - low) * at, whole * at, curve=CURVE).least_safeties()
        errors.append(abs(found[-1] / exact - 1.0))
    ratios = np.array(errors[:-1]) / errors[1:]
    assert (ratios > 3.5).all() and (ratios < 4.5).all()
    assert errors[1] < 2e-3


# ---------------------------------------------------------------- when it fails


def test_a_mode_without_memory_fails_where_its_safety_crosses():
    safety = np.array([[1.6, 0.9], [1.2, 0.8], [0.8, 0.7], [0.7, 0.6]])
    ends = meshes_to_failure(np.array([0.0, 10.0, 20.0, 30.0]), safety, 1.0)
    assert ends == pytest.approx([15.0, 0.0])
    assert np.isnan(meshes_to_failure(np.array([0.0, 10.0]), safety[:2, :1] + 1.0, 1.0)).all()


def test_a_mode_that_adds_up_damage_fails_where_the_sum_is_one():
    """Under constant stress that is the life of the curve, whatever the wear steps."""
    stress, required = 1500.0, 1.1
    life = 1.0 / ISO.damage_per_cycle(np.log([required * stress])).item()
    for steps in (2, 7):
        cycles = np.linspace(0.0, 3.0 * life, steps)
        own = history(np.full(steps, stress), cycles)
        assert own.life(required) == pytest.approx(life, rel=1e-6)
        assert np.isnan(own.life(0.1))
        assert own.life(2.0) == 0.0  # beyond static strength at once
    # from 1500 MPa beyond static strength in one step: where the stress is 2400
    assert history([1500.0, 3000.0], [0.0, 300.0]).life(1.0) == pytest.approx(180.0)


@pytest.mark.parametrize("length", [1e4, 1e6, 1e8])
def test_on_the_way_to_static_strength_damage_adds_up(length):
    """From 97 to 120 % of it in one step, on one power law: the damage is an integral in closed form."""
    low, grown, p = 0.97, 0.23, SLOPE
    share = ((low ** (p + 1) + (p + 1) * grown * CURVE.cycles[0] / length) ** (1 / (p + 1)) - low) / grown
    exact = length * min(share, (1.0 - low) / grown)
    # one point that grows so, another that stays half as stressed
    stress = CURVE.static * np.array([[0.5, low], [0.5, low + grown]])
    assert history(stress, [0.0, length], curve=CURVE).life(1.0) == pytest.approx(exact, rel=0.02)


def test_the_load_that_comes_to_static_strength_first_ends_the_life():
    """One load falls from 90 % of it to half of it, another rises from a tenth to 130 %, a third to 105 %."""
    stress = CURVE.static * np.array([[[0.9], [0.1], [0.2]], [[0.5], [1.3], [1.05]]])
    short = history(stress, [0.0, 3.0], shares=(0.2, 0.5, 0.3), curve=CURVE)  # too short for damage to add up
    assert short.life(1.0) == pytest.approx(3.0 * 0.9 / 1.2, rel=1e-9)


@pytest.mark.parametrize("static", [1146.9630400077335, 1600.0])
def test_stress_borne_for_ever_up_to_static_strength_adds_no_damage(static):
    """Where the curve is flat all through, a point lasts until its stress comes there."""
    flat = LifeCurve((1e5, 5e7), (static, static))
    for high in (1242.78549099, 1167.91380973, 2000.0, 3000.0):
        if high > static:
            assert history([0.0, high], [0.0, 1e11], curve=flat).life(1.0) == pytest.approx(1e11 * static / high)


@settings(max_examples=30)
@given(st.floats(700.0, 1500.0), st.floats(1.0, 1.3), st.integers(1, 5))
def test_the_life_is_where_the_safety_passes_what_is_required(stress, growth, steps):
    cycles = np.linspace(0.0, 1e9, steps + 1)
    own = history(np.linspace(stress, growth * stress, steps + 1), cycles)
    least, _ = own.least_safeties()
    # with a little more than the safety of the last step required the run does not last, with a little less it does
    assert own.life(float(least[-1]) * 1.0001) <= 1e9
    assert np.isnan(own.life(float(least[-1]) * 0.9999))


def test_the_first_of_all_modes_and_bodies():
    assert first_failure(np.array([[np.nan, 5.0], [4.0, np.nan]])) == (1, 0)
    assert first_failure(np.full((2, 2), np.nan)) is None


# ---------------------------------------------------------------- in a run


def test_unworn_the_least_safety_is_that_of_the_greatest_pressure_and_root_stress(small):
    ratings, engagement = small["ratings"].to_dataset(), small["engagement"].to_dataset()
    inner = engagement.contact_pressure_max.where(engagement.contact_pressure_on_edge == 0)
    pitting = ratings.safety.sel(mode="pitting").isel(wear_step=0)
    limits = np.array([PITTING["pinion_limit_MPa"], PITTING["gear_limit_MPa"]])
    np.testing.assert_allclose(pitting, 1.6 * limits / float(inner.isel(wear_step=0).max()), rtol=1e-6)
    bending = ratings.safety.sel(mode="bending").isel(wear_step=0)
    root = small["history"].root_stress_max.isel(wear_step=0)
    np.testing.assert_allclose(bending, 2.5 * 2.0 * BENDING["pinion_limit_MPa"] / root, rtol=1e-6)


def test_the_group_is_whole(small):
    ratings = small["ratings"].to_dataset()
    assert ratings.mode.values.tolist() == ["pitting", "bending"]
    safety = ratings.safety.values
    assert np.isfinite(safety).all() and (np.diff(safety, axis=1) < 0.0).all()
    on_flank = ratings.safety_on_flank.min(("profile", "face")).values
    np.testing.assert_allclose(on_flank, safety[:, -1], rtol=2e-4)
    assert ratings.fails_first.values.tolist() == [1, 0]
    assert ratings.hours.values == pytest.approx(ratings.meshes.values * (24 / 16) / (60.0 * 1500.0))
    ends, hours = ratings.meshes_to_failure.values, ratings.hours_to_failure.values
    assert np.isfinite(ends[0]).all() and np.isnan(ends[1]).all()
    assert hours[0] == pytest.approx(ends[0] * (24 / 16) / 9e4)
    for mode, words in (
        ("pitting", "K_Halpha, K_Falpha = 1: the load sharing between tooth pairs is solved"),
        ("bending", "Y_F, Y_S = 1: "),
    ):
        assert words in ratings.attrs[mode]
    # the fine point of damage: it passes 1 where the safety passes what is required
    damage = ratings.damage_sum.sel(mode="pitting").values
    assert ((damage > 1.0) == (safety[0] < 1.0)).all()


def test_safeties_scale_with_limits_and_load_factors(small):
    changed = sw.simulate(
        SMALL.replace(
            {
                "effects.pitting.pinion_limit_MPa": 3000.0,
                "effects.pitting.gear_limit_MPa": 2900.0,
                "effects.pitting.application_factor": 1.21,
                "effects.pitting.dynamic_factor": 1.44,
                "effects.bending.application_factor": 1.5,
                "effects.bending.dynamic_factor": 2.0,
            }
        )
    )
    ratio = (changed["ratings"].safety / small["ratings"].safety).values
    np.testing.assert_allclose(ratio[0], 2.0 / (1.1 * 1.2), rtol=1e-6)  # pressure grows with the root of the load
    np.testing.assert_allclose(ratio[1], 1.0 / 3.0, rtol=1e-6)
    for group in ("flank", "engagement", "history"):
        for name, values in small[group].to_dataset().data_vars.items():
            np.testing.assert_array_equal(changed[group][name].values, values.values)


def test_a_spectrum_of_one_torque_twice_is_that_torque(small):
    torque = SMALL.operation.pinion_torque_Nm
    spectrum = {"torques_Nm": [torque, torque], "shares": [0.25, 0.75]}
    found = sw.simulate(SMALL.replace({"effects.load_spectrum": spectrum}))["ratings"].safety.values
    np.testing.assert_allclose(found, small["ratings"].safety.values, rtol=1e-9)


@pytest.mark.slow
def test_a_spectrum_is_rated_between_its_torques(small):
    spectrum = {"torques_Nm": [150.0, 250.0], "shares": [0.7, 0.3]}
    mixed, low, high = (
        sw.simulate(SMALL.replace(change))["ratings"].safety.values[:, 1]
        for change in (
            {"effects.load_spectrum": spectrum},
            {"operation.pinion_torque_Nm": 150.0},
            {"operation.pinion_torque_Nm": 250.0},
        )
    )
    assert (mixed < low).all() and (mixed > 0.99 * high).all()


def test_extremes_of_roll_positions_are_not_lost_between_nodes():
    physics = plan(SMALL)
    teeth = physics.loaded_teeth()
    state = teeth.load(np.zeros(teeth.grid.profile.shape))
    contact = RatedContact(teeth, state, 1.0, RatedFlanks.of(teeth), lambda _: None)
    pressure = contact.pressures.inner
    found = contact.on_flanks(pressure)
    for body in range(2):
        assert np.nanmax(found[body]) == pressure.max()
        assert np.nanmin(found[body]) >= pressure[pressure > 0.0].min()
    least = contact.on_flanks(-pressure, worst=np.fmin)
    assert np.nanmin(least) == -pressure.max()
    # the pinion's root meets the gear's tip: roll positions run the other way on the other flank
    rated = contact.rated[:, 5]
    driving, driven = contact.places[:, rated, 5]
    assert (np.diff(driving[np.argsort(driven)]) <= 1e-9).all()


def test_both_flanks_are_rated_where_worn_ones_touch():
    """Places of the pinion are those that the motions bring opposite the gear's, off the fresh line too."""
    physics = plan(SMALL)
    teeth = physics.loaded_teeth()
    nodes = (teeth.driving_profile, teeth.grid.profile)
    height = [(own - own[:, :1]) / np.ptp(own, axis=1, keepdims=True) for own in nodes]
    driving, driven = (0.02 * np.exp(-(((h - 0.35) / 0.12) ** 2)) for h in height)
    state = teeth.load(driven, None, driving)
    contact = RatedContact(teeth, state, 1.0, RatedFlanks.of(teeth), lambda _: None)
    lines, (found, on_gear) = teeth.lines, contact.places
    met = teeth.pair.meeting(lines.face[None, :], on_gear, lines.roll[:, None]).driving_profile
    assert np.abs(on_gear - lines.profile)[contact.rated].max() > 0.05
    np.testing.assert_allclose(found[contact.rated], met[contact.rated], atol=2e-3)


@pytest.mark.slow
def test_a_life_ends_at_the_first_failure():
    life = {"effects.run_life": {"depth_limit_um": 4.0, "ends_at": "first_failure"}}
    told = sw.simulate(SMALL.replace(life))["life"].to_dataset()
    assert str(told.ended_by.values) == "pitting"
    assert 0.0 < float(told.meshes_to_end) < float(told.meshes_to_limit)
    assert float(told.hours_to_end) == pytest.approx(float(told.meshes_to_end) * 1.5 / 9e4)
    strong = life | {"effects.pitting.required_safety": 0.1, "effects.bending.required_safety": 0.1}
    told = sw.simulate(SMALL.replace(strong))["life"].to_dataset()
    assert str(told.ended_by.values) == "wear" and float(told.meshes_to_end) == float(told.meshes_to_limit)


FILM = {"effects.lubrication": {"roughness_um": 0.05}, "effects.wear_law.lubrication": {"full_film_lambda": 1.0}}


def test_a_flank_that_wears_no_further_lives_until_another_failure():
    """A film carries all load: pitting ends the life when the unworn contact has the required safety."""
    scene = SMALL.replace(FILM | {"effects.run_life": {"depth_limit_um": 4.0, "ends_at": "first_failure"}})

    def life(**changes):
        physics = plan(scene.replace({f"effects.{key}": value for key, value in changes.items()}))
        return life_group(physics, physics.wear_stepper(physics.loaded_teeth()))

    told = life()
    end = float(told["meshes_to_end"])
    assert str(told["ended_by"]) == "pitting" and float(told["hours_to_end"]) == pytest.approx(end * 1.5 / 9e4)
    assert told["meshes_to_limit"] == told["hours_to_limit"] == np.inf and np.isnan(told["sensitivity_to_torque"])
    safety = sw.loaded_contact(scene.replace({"effects.run_life": None}), meshes=end)["ratings"].safety
    assert float(safety.sel(mode="pitting").min()) == pytest.approx(1.0, abs=1e-4)
    assert float(safety.sel(mode="bending").min()) > 1.0
    with pytest.raises(EndlessWearError, match="wears no further at 0 um of 4 um"):
        life(run_life={"depth_limit_um": 4.0})
    with pytest.raises(EndlessWearError, match="wears no further"):
        life(pitting=PITTING | {"required_safety": 0.1}, bending=BENDING | {"required_safety": 0.1})


def test_a_life_is_ended_by_the_first_of_all_modes_and_bodies(monkeypatch):
    """Of three modes, whose failures are made up, at 16 teeth against 24 and 1500 rev/min."""
    physics = plan(SMALL.replace({"effects.run_life": {"depth_limit_um": 4.0, "ends_at": "first_failure"}}))
    stepper = physics.wear_stepper(physics.loaded_teeth())
    monkeypatch.setattr(life_module, "find_life", lambda *_: Life(4e-3, 1e8, 1.5e8 / 9e4, -1.0, -0.9))

    def end(failures):
        rated = SimpleNamespace(
            modes=("pitting", "bending", "scuffing"), arrays={"meshes_to_failure": np.array(failures)}
        )
        monkeypatch.setattr(Plan, "ratings", lambda *_: rated)
        told = life_group(physics, stepper)
        assert told["depth_limit"] == pytest.approx(4.0)
        assert told["hours_to_end"] == pytest.approx(told["meshes_to_end"] * 1.5 / 9e4)
        return str(told["ended_by"]), float(told["meshes_to_end"])

    assert end([[np.nan, 9e7], [np.nan, np.nan], [3e7, 5e7]]) == ("scuffing", 3e7)
    assert end([[np.nan, np.nan], [np.nan, 9e7], [2e8, np.nan]]) == ("bending", 9e7)
    assert end([[np.nan, np.nan], [2e8, np.nan], [np.nan, np.nan]]) == ("wear", 1e8)


# ---------------------------------------------------------------- errors that are carried over


def test_errors_of_safeties_and_lives_follow_from_those_of_the_run():
    tree = synthetic_tree(5, profiles=5, faces=4)
    ratings = tree["ratings"].to_dataset().drop_vars(["safety_error", "meshes_to_failure_error"])
    diagnostics = tree["diagnostics"].to_dataset()
    estimates = diagnostics.assign_coords(quantity=["safety_pitting", "safety_bending"])
    found = safety_and_life_errors(ratings, estimates)
    safety, life = ratings.safety.values, ratings.meshes_to_failure.values[0]
    assert found["safety_error"] == pytest.approx([0.004 * safety[0].max(), 0.02 * safety[1].max()])
    changed = 2.5 * found["safety_error"][0] / ratings.required_safety.values[0]
    assert found["meshes_to_failure_error"][0] == pytest.approx(changed * life)
    assert np.isnan(found["meshes_to_failure_error"][1]).all()
    assert safety_and_life_errors(ratings, diagnostics.drop_vars("error_estimate")) == {}


@pytest.mark.parametrize("stress", [1600.0, 1475.0])
def test_lives_of_one_stress_follow_the_slope_of_the_curve(stress):
    # 1600 MPa fail on the steep branch, in the first wear step already, 1475 MPa on the flat one
    curve = pitting_curve(1500.0, "hardened", 0.85, 1.0, 1.0)
    history = StressHistory(np.linspace(0.0, 2.4e8, 5), np.ones(1), np.full((5, 1, 1), stress), curve)
    (found,) = life_exponent(lambda required: np.array([history.life(required)]), 1.0)
    (first, second), (low, high) = ((1e5, 5e7), (1.6, 1.0)) if stress > 1500.0 else ((5e7, 1e10), (1.0, 0.85))
    assert found == pytest.approx(np.log(second / first) / np.log(high / low), rel=0.02)


@pytest.mark.parametrize("required", [1.05, 1.005])  # with less than the latter the run ends before
def test_lives_of_a_straight_safety_have_its_slope(required):
    meshes, safety = np.array([0.0, 1.0, 2.0]), np.array([[1.2, 3.0, 0.9], [1.1, 3.0, 0.8], [1.0, 3.0, 0.7]])
    found = life_exponent(partial(meshes_to_failure, meshes, safety), required)
    life = (1.2 - required) / 0.1
    assert found[0] == pytest.approx(-required / 0.1 / life)
    assert np.isnan(found[1:]).all()  # never, and unworn already


@pytest.mark.slow
def test_an_asked_accuracy_is_told_of_the_safeties():
    scene = SMALL.replace(
        {
            "numerics.accuracy": 0.3,
            "numerics.wear_steps": None,
            "wear.until.meshes": 2e7,
            "effects.pitting.required_safety": 1.15,
        }
    )
    tree = sw.simulate(scene)
    ratings = tree["ratings"].to_dataset()
    assert (ratings.safety_error.values > 0.0).all()
    share = tree["diagnostics"].error_estimate.sel(quantity="safety_pitting")
    assert float(share) * float(ratings.safety.sel(mode="pitting").max()) == pytest.approx(
        float(ratings.safety_error.sel(mode="pitting"))
    )


# ---------------------------------------------------------------- scenes and screening


@pytest.mark.parametrize(
    ("field", "usual"),
    [
        ("pitting.pinion_limit_MPa", "1300 to 1650 case-hardened"),
        ("pitting.gear_limit_MPa", "1000 to 1250 nitrided"),
        ("pitting.gear_life_curve", '"hardened" or'),
        ("bending.pinion_limit_MPa", "310 to 525 case-hardened"),
        ("bending.gear_life_curve", '"case_hardened" or'),
        ("bending.root_roughness_Rz_um", "up to 40 um"),
    ],
)
def test_missing_data_of_the_materials_are_named_with_what_is_usual(field, usual):
    problem = problems_of(SMALL.replace, {"effects.pitting": {}, "effects.bending": {}})[f"effects.{field}"]
    assert problem.value is None and usual in problem.allowed


def test_what_a_rating_needs():
    found = problems_of(SMALL.replace, {"numerics.tooth_compliance": "rigid"})
    assert (
        set(found) == {"numerics.tooth_compliance"} and "[effects.bending]" in found["numerics.tooth_compliance"].fix
    )
    given_factor = {"effects.pitting.film_factors": "given", "effects.pitting.viscosity_40_mm2_per_s": None}
    assert set(problems_of(SMALL.replace, given_factor)) == {"effects.pitting.film_factor"}
    assert SMALL.replace(given_factor | {"effects.pitting.film_factor": 0.92})
    bare = SMALL.replace({"effects.pitting": None, "effects.bending": None})
    with pytest.raises(
        SceneError, match=r"ends_at: found 'first_failure'; allowed: needs one of \[effects.pitting\]"
    ):
        bare.replace({"effects.run_life.ends_at": "first_failure"})


def test_a_screening_says_how_near_the_limits_are():
    assert nearness(SMALL, "bending").startswith("far from its limit: safety of the pinion ")
    words = nearness(SMALL, "pitting")
    assert words.startswith("fails: safety of the ") and "below it after about" in words
    # more than static strength asks for
    high = SMALL.replace({"effects.pitting.required_safety": 5.0})
    assert nearness(high, "pitting").endswith(", 5 required, below it unworn already")
    assert not RatingTable.screening_table(SMALL)
