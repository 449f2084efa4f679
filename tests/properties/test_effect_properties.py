"""Effects of a scene: nothing at strength zero, smooth and of the right sign beyond, and any two run together."""

from functools import cache
from itertools import chain

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import semiwear as sw
from semiwear.plan import plan
from semiwear.scene import EFFECTS
from tests.strategies.effect_scenes import NEUTRAL, PLAIN, SPEED
from tests.strategies.finite import assert_finite_or_explained
from tests.strategies.scenes import effect_tables

# Residuals and seconds are rounding and chance; everything else of a run without the effect must come again.
CHANCE = ("seconds", "effect_seconds", "load_balance_residual", "complementarity_residual")
ROUNDING = 1e-11  # of the greatest value: sums in another order, carried through some ten iterations
BOTH_WORN = {"wear.worn_bodies": ["pinion", "gear"]}

# a share of the profile's examples, since each is a run, and shrinking is as slow
runs = settings(
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
    phases=[Phase.explicit, Phase.reuse, Phase.generate],
)


def assert_same(tree, plain):
    """Every variable of a run without the effect is in the other run, and the same."""
    for group in plain.children:
        for name, wanted in plain[group].data_vars.items():
            # a coefficient that changes with depth leaves no volume to compare with, whatever its strength
            unstated = name == "wear_volume_residual" and name not in tree[group].data_vars
            if name in CHANCE or unstated:
                continue
            expected, found = wanted.values.astype(float), tree[group][name].values.astype(float)
            atol = ROUNDING * np.nanmax(np.abs(expected))
            np.testing.assert_allclose(found, expected, rtol=0.0, atol=atol, err_msg=f"/{group}/{name}")


def neutral_changes():
    """All effects at once, each in the first way to do nothing; without the search for a life, of many steps."""
    first = {name: changes for name, changes in reversed(NEUTRAL) if name != "run_life"}
    return dict(chain.from_iterable(changes.items() for changes in first.values()))


# ---------------------------------------------------------------- strength zero


@pytest.fixture(scope="module")
def plain():
    return sw.simulate(PLAIN)


def test_every_effect_has_a_strength_of_zero():
    assert {name for name, _ in NEUTRAL} == set(EFFECTS)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "changes"), NEUTRAL, ids=[f"{k}-{name}" for k, (name, _) in enumerate(NEUTRAL)])
def test_without_strength_an_effect_does_nothing(plain, name, changes):
    scene = PLAIN.replace(changes)
    assert scene.effects.get(name) is not None
    assert_same(sw.simulate(scene), plain)


@pytest.mark.slow
@pytest.mark.parametrize("fidelity", ["line", "patch"])
def test_all_effects_without_strength_do_nothing(fidelity):
    worn = PLAIN.replace(BOTH_WORN)
    assert_same(sw.simulate(worn.replace(neutral_changes()), fidelity=fidelity), sw.simulate(worn, fidelity=fidelity))


def test_ways_in_which_teeth_follow_alike_are_one():
    once, twice = (PLAIN.replace({"effects.pitch_error.pinion_um": [0.0, 12.0] * times}) for times in (1, 2))
    planned = plan(twice)
    assert len(planned.wear_stepper(planned.loaded_teeth()).cases) == 2
    assert_same(sw.simulate(twice), sw.simulate(once))


@pytest.mark.slow
def test_what_only_tells_changes_nothing_at_full_strength(plain):
    """Flash temperature, oil film and life are told, and feed nothing back."""
    for changes in (
        {"effects.flash_temperature": {"friction_coefficient": 0.2}},
        {"effects.lubrication": {"viscosity_mPas": 100.0}},
        {"effects.run_life": {"depth_limit_um": 5.0}},
    ):
        assert_same(sw.simulate(PLAIN.replace(SPEED | changes)), plain)


# ---------------------------------------------------------------- strength grows


def mean_of(name):
    return lambda tree: float(tree["mesh_cycle"][name].mean())


def greatest(name):
    return lambda tree: float(tree["engagement"][name].max())


def centre_of_load(tree):
    """Mean face coordinate of the load of all pairs [mm]."""
    load = tree["engagement"].line_load
    return float((load * load.face).sum() / load.sum())


def centre_of_engagement(tree):
    """Mean roll position of the load of a pair."""
    share = tree["engagement"].load_share
    return float((share * share.roll_position).sum() / share.sum())


def spread_of_engagement(tree):
    """Roll positions over which a pair's load is spread: (sum s)^2 / sum s^2."""
    share = tree["engagement"].load_share.values
    return float(share.sum() ** 2 / (share**2).sum() / tree["mesh_cycle"].mesh_position.size)


def amplitude(tree):
    return float(np.ptp(tree["mesh_cycle"].transmission_error_loaded.values))


def loss(tree):
    return float(tree["engagement"].friction_torque_loss.sum())


def field(key):
    """Changes of a scene by one field."""
    return lambda value: {key: value}


TE = "transmission_error_loaded"
SHAFTS = dict(NEUTRAL)["shaft_compliance"]["effects.shaft_compliance"]
# field at full strength, what is watched, and which way it goes; `loaded_contact` is enough
CONTACT = [
    ("misalignment.offset_mm", 0.1, centre_of_load, +1),
    ("misalignment.offset_mm", -0.1, centre_of_load, -1),
    ("misalignment.axial_gear_mm", 0.1, centre_of_load, -1),
    ("misalignment.axial_gear_mm", -0.1, centre_of_load, +1),
    ("misalignment.shaft_angle_error_mrad", 1.0, centre_of_load, +1),
    ("misalignment.shaft_angle_error_mrad", -1.0, centre_of_load, -1),
    ("misalignment.pinion_slope_mrad", 1.0, centre_of_load, -1),
    ("misalignment.pinion_slope_mrad", -1.0, centre_of_load, +1),
    # a pair enters at the gear's tip and the pinion's root, and leaves at the gear's root and the pinion's tip
    ("modification.gear.tip_relief_um", 40.0, spread_of_engagement, -1),
    ("modification.gear.tip_relief_um", 40.0, centre_of_engagement, +1),
    ("modification.pinion.tip_relief_um", 40.0, spread_of_engagement, -1),
    ("modification.pinion.tip_relief_um", 40.0, centre_of_engagement, -1),
    ("modification.gear.root_relief_um", 40.0, centre_of_engagement, -1),
    ("modification.pinion.root_relief_um", 40.0, centre_of_engagement, +1),
    ("modification.gear.crowning_um", 40.0, greatest("contact_pressure_max"), +1),
    ("modification.pinion.crowning_um", 40.0, greatest("contact_pressure_max"), +1),
    # the slope is taken off the upper end when positive
    ("modification.gear.lead_slope_um", 40.0, centre_of_load, -1),
    ("modification.gear.lead_slope_um", -40.0, centre_of_load, +1),
    ("modification.pinion.lead_slope_um", 40.0, centre_of_load, -1),
    ("modification.pinion.lead_slope_um", -40.0, centre_of_load, +1),
    # positive bias takes tip and upper end on either body, and the tip of one meets the root of the other
    ("modification.gear.bias_um", 40.0, spread_of_engagement, -1),
    ("modification.pinion.bias_um", -40.0, spread_of_engagement, -1),
    ("free_edges.strength", 1.0, mean_of(TE), -1),
    ("friction.coefficient", 0.2, loss, +1),
    ("shaft_compliance.offset_um_per_kN", 2.0, mean_of(TE), -1),
    ("shaft_compliance.axial_gear_um_per_kN", 2.0, mean_of(TE), -1),
    ("shaft_compliance.shaft_angle_mrad_per_kNm", 2.0, mean_of(TE), -1),
    ("shaft_compliance.pinion_slope_mrad_per_kNm", 2.0, mean_of(TE), -1),
    # the load pushes the pinion along +x and away from the gear, as an offset and an axial error would
    ("shaft_compliance.offset_um_per_kN", 2.0, centre_of_load, +1),
    ("shaft_compliance.axial_gear_um_per_kN", 2.0, centre_of_load, -1),
]
STRENGTHS = np.linspace(0.0, 1.0, 4)


def assert_grows_smoothly(values, sign):
    """One way all along, and no step differs from its neighbour by more than half of the whole response."""
    steps = sign * np.diff(values)
    assert np.all(steps > 0.0), values
    assert np.abs(np.diff(steps)).max() < 0.5 * steps.sum(), values


@cache
def loaded_with(key, value):
    """Loaded contact of the plain scene with a field of its effects."""
    scene = PLAIN.replace({"effects.shaft_compliance": SHAFTS}) if key.startswith("shaft") else PLAIN
    return sw.loaded_contact(scene.replace({f"effects.{key}": value}))


@pytest.mark.slow
@pytest.mark.parametrize(("key", "full", "watched", "sign"), CONTACT, ids=[f"{k[0]}={k[1]}" for k in CONTACT])
def test_contact_answers_smoothly_and_the_right_way(key, full, watched, sign):
    values = [watched(loaded_with(key, float(full * s))) for s in STRENGTHS]
    assert_grows_smoothly(values, sign)


def test_pitch_errors_answer_smoothly():
    trees = [sw.loaded_contact(PLAIN.replace({"effects.pitch_error.pinion_um": [0.0, 12.0 * s]})) for s in STRENGTHS]
    assert_grows_smoothly([amplitude(tree) for tree in trees], +1)
    assert_grows_smoothly([greatest("load_share")(tree) for tree in trees], +1)
    # of the moved teeth half are late; the mean is of the early one's mesh
    assert_grows_smoothly([mean_of(TE)(tree) for tree in trees], -1)


def test_compliance_along_the_pinion_axis_takes_no_load():
    """A spur pinion's flanks lie along its axis."""
    soft = PLAIN.replace({"effects.shaft_compliance": SHAFTS | {"axial_pinion_um_per_kN": 5.0}})
    one, two = sw.loaded_contact(PLAIN), sw.loaded_contact(soft)
    # half-widths are found to 1e-5, which leaves the approach uncertain by a hundredth of that
    np.testing.assert_allclose(two["mesh_cycle"][TE], one["mesh_cycle"][TE], rtol=1e-7)


def volume(tree):
    """Mean wear of the gear [um], on a flank whose grid is nearly even."""
    return float(tree["flank"].wear_depth.isel(wear_step=-1).sel(body="gear").mean())


def deepest(tree):
    return float(tree["flank"].wear_depth.isel(wear_step=-1).sel(body="gear").max())


def told(name):
    return lambda tree: float(tree["history"][name].values[-1])


def spectrum(share):
    torque = PLAIN.operation.pinion_torque_Nm
    shares = [1.0 - 0.8 * share - 0.1, 0.8 * share + 0.1]
    return {"effects.load_spectrum": {"torques_Nm": [0.5 * torque, 1.5 * torque], "shares": shares}}


def hot(share):
    return {
        "operation.pinion_speed_rpm": 100.0 * 30.0**share,
        "effects.flash_temperature": {},
        "effects.wear_law.temperature": {},
    }


def oiled(share):
    return {
        "operation.pinion_speed_rpm": 1000.0 * 5.0**share,
        "effects.lubrication": {},
        "effects.wear_law.lubrication": {},
    }


def soft_core(share):
    return {"effects.wear_law.hardness": {"core_hardness_HV": 700.0 - 400.0 * share, "case_depth_um": 8.0}}


def running_in(share):
    """Flanks that grow smoother under the film, which wear them less."""
    return oiled(0.5) | {"effects.running_in": {"strength": 0.8 * share, "depth_um": 0.5}}


WEAR = [
    ("softer core", soft_core, ((deepest, +1),)),
    ("wear by pressure, below its reference", field("effects.wear_law.load.exponent"), ((volume, -1),)),
    ("heavier spectrum", spectrum, ((volume, +1),)),
    ("hotter with speed", hot, ((told("contact_temperature_max"), +1), (volume, +1))),
    ("smoother flanks as they run in", running_in, ((volume, -1),)),
    ("thicker film with speed", oiled, ((told("lambda_ratio_min"), +1), (volume, -1))),
]


@pytest.mark.slow
@pytest.mark.parametrize(("changes", "responses"), [e[1:] for e in WEAR], ids=[e[0] for e in WEAR])
def test_wear_answers_smoothly_and_the_right_way(changes, responses):
    trees = [sw.simulate(PLAIN.replace(changes(float(s)))) for s in STRENGTHS]
    for watched, sign in responses:
        assert_grows_smoothly([watched(tree) for tree in trees], sign)


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {"effects.wear_law.load.exponent": 1.0},
        {
            "operation.pinion_speed_rpm": 3000.0,
            "effects.flash_temperature": {},
            "effects.wear_law.temperature.activation_energy_kJ_per_mol": 50.0,
        },
        {"operation.pinion_speed_rpm": 5000.0, "effects.lubrication": {}, "effects.wear_law.lubrication": {}},
        {"effects.wear_law.hardness": {"core_hardness_HV": 300.0, "case_depth_um": 8.0}},
        {"effects.load_spectrum": {"torques_Nm": [800.0, 2400.0], "shares": [0.5, 0.5]}},
        {"effects.pitch_error.pinion_um": [0.0, 20.0]},
        {"effects.friction.coefficient": 0.2},
    ],
    ids=lambda changes: " ".join(changes),
)
def test_long_steps_are_stable_with_every_law(changes):
    """Two implicit steps are within a quarter of eight (5 % without a law); unstable ones would be off by times."""
    two, eight = (deepest(sw.simulate(PLAIN.replace(changes | {"numerics.wear_steps": n}))) for n in (2, 8))
    assert two == pytest.approx(eight, rel=0.25)


# ---------------------------------------------------------------- any two together

SHORT_LIFE = {"depth_limit_um": 5.0}  # few steps reach it


def needs_of(names, tables):
    """What effects need beside their own tables, with moderate values."""
    needed = {}
    waiting = list(names)
    while waiting:
        name = waiting.pop()
        needs = [*EFFECTS[name].needs]
        for (key, value), more in EFFECTS[name].needs_if.items():
            needs += more if tables.get(name, {}).get(key) == value else ()
        for need in needs:
            if need.startswith(f"effects.{name}."):
                continue  # a field of its own, which the table gives
            if need.startswith("effects."):
                if need.removeprefix("effects.") not in names:
                    needed[need] = {}
                    waiting.append(need.removeprefix("effects."))
            elif need != "wear":
                needed[need] = 1000.0
    return needed


@st.composite
def pairs(draw):
    """Changes of `PLAIN` by two effects, and which bodies wear."""
    drawn = effect_tables(PLAIN)
    names = draw(st.lists(st.sampled_from(sorted(EFFECTS)), min_size=2, max_size=2, unique=True))
    tables = {name: draw(drawn[name]) for name in names}
    if "run_life" in tables:
        tables["run_life"] |= SHORT_LIFE
    changes = needs_of(names, tables) | {f"effects.{name}": table for name, table in tables.items()}
    return changes | (BOTH_WORN if draw(st.booleans()) else {})


def assert_sound(tree, scene):
    for group in tree.children:
        for name, values in tree[group].data_vars.items():
            assert_finite_or_explained(name, values)
    worn = tree["flank"].wear_depth
    assert float(worn.min()) >= 0.0
    assert (worn.diff("wear_step") >= 0.0).all()
    for body in scene.wear.worn_bodies:
        assert float(worn.sel(body=body).isel(wear_step=-1).max()) > 0.0
    shares = tree["engagement"].load_share.values
    positions = tree["mesh_cycle"].mesh_position.size
    np.testing.assert_allclose(shares.reshape(shares.shape[0], -1, positions).sum(axis=1), 1.0, atol=1e-12)
    assert float(tree["diagnostics"].load_balance_residual.max()) < 1e-9


@pytest.mark.slow
@given(pairs())
@settings(runs, max_examples=max(settings.default.max_examples // 3, 6))
def test_any_two_effects_run_together(changes):
    scene = PLAIN.replace(changes)
    assert_sound(sw.simulate(scene), scene)


RATINGS = ("pitting", "bending", "micropitting", "scuffing", "flank_fracture")
_NOT_EMPTY = ("load_spectrum", "pitch_error", "run_life", *RATINGS)
ALONE = {name: {f"effects.{name}": {}} | needs_of([name], {}) for name in EFFECTS if name not in _NOT_EMPTY} | {
    **{name: dict(NEUTRAL)[name] for name in RATINGS},  # they only tell
    "run_life": {"effects.run_life": SHORT_LIFE},
    "running_in": oiled(0.5) | {"effects.running_in": {}},
    "load_spectrum": spectrum(0.5),
    "pitch_error": {"effects.pitch_error.pinion_um": [0.0, 10.0, 0.0, -10.0]},
    "modification.pinion": {"effects.modification.pinion.tip_relief_um": 20.0},
    "modification.gear": {"effects.modification.gear": {"crowning_um": 20.0, "bias_um": -10.0}},
    "misalignment": {"effects.misalignment": {"offset_mm": 0.05, "shaft_angle_error_mrad": 0.5}},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", EFFECTS)
def test_every_effect_runs_with_patches(name):
    """Pressure resolved in two dimensions, its wear summed in place; friction laws and films as with lines."""
    scene = PLAIN.replace(ALONE[name] | {"numerics.fidelity": "patch"})
    assert_sound(sw.simulate(scene), scene)


@pytest.mark.slow
def test_all_effects_run_together():
    """But for the search for a life, which wears eight load cases many times over."""
    together = (changes for name, changes in ALONE.items() if name != "run_life")
    scene = PLAIN.replace(dict(chain.from_iterable(each.items() for each in together)) | BOTH_WORN)
    assert len(list(scene.effects.present())) == len(EFFECTS) - 1
    assert_sound(sw.simulate(scene), scene)
