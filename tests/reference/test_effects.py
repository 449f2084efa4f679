"""Effects of a scene against closed forms: published figures, superposition of small wear, kinematics by hand."""

from math import cos, exp, radians, sin

import numpy as np
import pytest

import semiwear as sw
from semiwear.meshing.deviation_grid import write_deviation_grid
from semiwear.plan import plan
from tests.strategies.effect_scenes import NEUTRAL, PLAIN, SPEED

PINION_TEETH, GEAR_TEETH, MODULE = 25, 160, 6.35
PRESSURE_ANGLE = radians(25.0)
BASE_RADIUS = 0.5 * MODULE * PINION_TEETH * cos(PRESSURE_ANGLE)
AXIS_OFFSET = 0.5 * MODULE * (28 - 25)
CURVATURE = 3.041e-2  # 1/mm, relative, across the line at the pitch point
ARCSEC_PER_MM = PINION_TEETH / GEAR_TEETH / BASE_RADIUS * np.degrees(1.0) * 3600.0
TORQUE = 1e3 * PLAIN.operation.pinion_torque_Nm  # N mm
GAS_CONSTANT = 8.314462618e-3  # kJ/(mol K)

# so little wear that loads stay as they are: depths are then linear in what the wear coefficient is multiplied by
FAINT = PLAIN.replace({"wear.until.meshes": 1e4, "numerics.wear_steps": 1})
DEEP = PLAIN.replace({"wear.until.meshes": 1e9, "numerics.wear_steps": 3})
LINEAR = 1e-3  # of the greatest depth: 2 nm, where light slices are pressed by some um; and factors are found so well

# design, section 4: where the unloaded contact passes the pitch point when the pinion is displaced, instead of 508 mm
CONTACT_RADIUS = [
    ("offset_mm", 0.1, 510.6),
    ("offset_mm", -0.1, 505.6),
    ("axial_gear_mm", 0.1, 502.7),
    ("axial_gear_mm", -0.1, 513.35),
    ("shaft_angle_error_mrad", 1.0, 515.3),
    ("shaft_angle_error_mrad", -1.0, 503.1),
    ("pinion_slope_mrad", 1.0, 497.0),
    ("pinion_slope_mrad", -1.0, 522.5),
    ("axial_pinion_mm", 0.1, 508.0),
]


def loaded(changes, **arguments):
    return sw.loaded_contact(PLAIN.replace(changes), **arguments)


def centre_of_load(tree):
    load = tree["engagement"].line_load
    return float((load * load.face).sum() / load.sum())


# ---------------------------------------------------------------- misalignment


@pytest.mark.slow
@pytest.mark.parametrize(("field", "value", "radius"), CONTACT_RADIUS)
def test_misalignment_of_the_table_moves_the_pattern(field, value, radius):
    table = {f"effects.misalignment.{field}": value}
    # the load follows the unloaded contact, held back by the ends of the face
    moved, unloaded = centre_of_load(loaded(table)) - centre_of_load(loaded({})), radius - 508.0
    assert 0.8 * abs(unloaded) - 0.3 < abs(moved) < 1.1 * abs(unloaded) + 0.3
    assert moved * unloaded >= 0.0


def test_misalignment_of_the_table_is_a_placement():
    errors = {"offset_mm": 0.07, "axial_gear_mm": -0.04, "shaft_angle_error_mrad": 0.6, "pinion_slope_mrad": -0.3}
    table, placed = loaded({"effects.misalignment": errors}), loaded({}, placement=sw.Placement(**errors))
    for group in ("engagement", "mesh_cycle"):
        assert table[group].dataset.equals(placed[group].dataset)
    unloaded = sw.tooth_contact_analysis(PLAIN.replace({"effects.misalignment": errors}))
    assert unloaded.equals(sw.tooth_contact_analysis(PLAIN, sw.Placement(**errors)))


# ---------------------------------------------------------------- modifications


FINE_ROLLS = {"numerics.roll_positions": 48}


@pytest.mark.slow
@pytest.mark.parametrize(("body", "end"), [("gear", "first"), ("pinion", "last")])
def test_tip_relief_shortens_the_loaded_path_at_its_end(body, end):
    """A pair enters at the gear's tip and leaves at the pinion's: relief there takes load off that end."""
    paths, ends = [], []
    for relief in (0.0, 10.0, 20.0, 40.0):
        share = loaded(FINE_ROLLS | {f"effects.modification.{body}.tip_relief_um": relief})["engagement"].load_share
        on = share.roll_position.values[share.values[0] > 0.0]
        paths.append(np.ptp(on))
        ends.append(on[0] if end == "first" else -on[-1])
    assert np.all(np.diff(paths) <= 0.0) and paths[-1] < paths[0] - 0.1
    assert np.all(np.diff(ends) >= 0.0) and ends[-1] > ends[0]


@pytest.mark.parametrize("body", ["pinion", "gear"])
def test_crowning_draws_the_load_to_the_middle_of_the_face(body):
    low, high = PLAIN.gear_pair.gear_inner_radius_mm, PLAIN.gear_pair.gear_outer_radius_mm
    trees = [loaded({f"effects.modification.{body}.crowning_um": depth}) for depth in (0.0, 20.0, 40.0)]
    away = [abs(centre_of_load(tree) - 0.5 * (low + high)) for tree in trees]
    assert away[0] > away[1] > away[2]


def test_a_slope_of_either_body_is_the_same_gap():
    """Faces lie upon one another, so that it does not matter off which flank a slope is taken."""
    pinion, gear = (loaded({f"effects.modification.{body}.lead_slope_um": 20.0}) for body in ("pinion", "gear"))
    most = float(gear["engagement"].line_load.max())
    np.testing.assert_allclose(pinion["engagement"].line_load, gear["engagement"].line_load, atol=0.01 * most)


@pytest.mark.parametrize("body", ["pinion", "gear"])
def test_a_grid_of_deviations_is_the_modification_that_it_describes(body, tmp_path):
    places = np.linspace(0.0, 1.0, 5)
    write_deviation_grid(tmp_path / "slope.csv", places, places, np.tile(-20.0 * places, (5, 1)))
    from_file, by_name = (
        plan(PLAIN.replace({f"effects.modification.{body}.{field}": value})).loaded_teeth()
        for field, value in (("file", str(tmp_path / "slope.csv")), ("lead_slope_um", 20.0))
    )
    assert by_name.modification.max() > 0.019
    np.testing.assert_allclose(from_file.modification, by_name.modification, atol=1e-12)
    assert from_file.problem.reach == pytest.approx(by_name.problem.reach, rel=1e-12)


def test_a_tooth_that_stands_out_bears_alone():
    """The first sequence has it next to the pitch point, for a base pitch from there on."""
    share = loaded({"effects.pitch_error.pinion_um": [0.0, 0.0, 100.0, 0.0, 0.0]})["engagement"].load_share
    own = (share.roll_position.values >= 0.0) & (share.roll_position.values < 1.0)
    np.testing.assert_allclose(share.values[0], np.where(own, 1.0, 0.0), atol=1e-9)


# ---------------------------------------------------------------- friction, by kinematics of its own


def contact_places(scene, tree):
    """Points and normals of the loaded lines, (roll, face), found by halving the bracket of the least separation."""
    pair = plan(scene).flank_pair()
    engagement = tree["engagement"]
    face, roll = engagement.face.values[None, :], engagement.roll_position.values[:, None]
    borders = pair.borders(face[0])
    low, high = (np.broadcast_to(end, (roll.size, face.size)).copy() for end in (borders.root, borders.tip))
    ratio = 0.5 * (np.sqrt(5.0) - 1.0)
    for _ in range(40):
        left, right = high - ratio * (high - low), low + ratio * (high - low)
        one, two = (pair.meeting(face, place, roll) for place in (left, right))
        # beyond the pinion's tip there is no flank
        less = np.where(one.driving_profile > borders.driving_tip, np.inf, one.separation) < np.where(
            two.driving_profile > borders.driving_tip, 1e9, two.separation
        )
        low, high = np.where(less, low, left), np.where(less, right, high)
    return pair.meeting(face, 0.5 * (low + high), roll)


def velocities(position):
    """Of the pinion's and the gear's points [mm per radian of the pinion], which turns towards -z about z."""
    x, y, z = np.moveaxis(position, -1, 0)
    pinion = np.stack([y + AXIS_OFFSET, -x, 0.0 * z], axis=-1)
    gear = PINION_TEETH / GEAR_TEETH * np.stack([-z, 0.0 * y, x], axis=-1)
    return pinion, gear


@pytest.fixture(scope="module")
def rubbing():
    """Loaded contact with friction, and for a unit force of each slice: sliding speed, moment of its friction.

    The friction of a slice that slides hardly faster than its surfaces stretch is less by Carter's share; relative
    curvature and rolling speed are taken as they are at the pitch point.
    """
    scene = PLAIN.replace({"effects.friction.coefficient": 0.1, "numerics.face_slices": 41})
    tree = sw.loaded_contact(scene)
    met = contact_places(scene, tree)
    pinion, gear = velocities(met.position)
    slip = pinion - gear
    slip = slip - np.sum(slip * met.normal, axis=-1, keepdims=True) * met.normal
    speed = np.linalg.norm(slip, axis=-1)
    face = tree["engagement"].face.values
    along = np.linalg.norm(np.gradient(met.position, face, axis=1), axis=-1)
    force = tree["engagement"].line_load.values[0] * along * (face[1] - face[0])
    rolling = pinion - np.sum(pinion * met.normal, axis=-1, keepdims=True) * met.normal
    line_load = tree["engagement"].line_load.values[0]
    stretch = np.sqrt(4.0 * line_load * CURVATURE / (np.pi * plan(scene).modulus))  # b/R
    full = np.maximum(0.1 * stretch * np.linalg.norm(rolling, axis=-1), 1e-12)
    lever = np.zeros(speed.shape)
    for part in (np.arange(20) + 0.5) / 20 - 0.5:  # of a slice, along which sliding changes
        there = slip + part * np.gradient(slip, axis=1)
        size = np.linalg.norm(there, axis=-1)
        share = 1.0 - np.maximum(1.0 - size / full, 0.0) ** 2
        lever += share * np.sum(there * pinion, axis=-1) / size / 20
    return tree, force, speed, lever


def test_friction_loss_is_force_times_sliding(rubbing):
    """Sum of mu F |v_s| over the path of contact, with places and velocities found here, against /engagement."""
    tree, force, speed, _ = rubbing
    expected = 1e-3 * 0.1 * np.sum(force * speed, axis=1)
    found = tree["engagement"].friction_torque_loss.values[0]
    np.testing.assert_allclose(found, expected, atol=0.01 * expected.max())
    efficiency = 1.0 - expected.sum() / tree["mesh_cycle"].mesh_position.size / (1e-3 * TORQUE)
    assert 0.985 < efficiency < 0.995


def test_the_efficiency_of_a_run_is_one_less_the_loss():
    tree = sw.simulate(PLAIN.replace({"effects.friction.coefficient": 0.1}))
    loss = tree["engagement"].friction_torque_loss.isel(wear_step=0).values.sum() / PLAIN.numerics.roll_positions
    found = float(tree["history"].mesh_efficiency[0])
    assert found == pytest.approx(1.0 - loss / (1e-3 * TORQUE), abs=1e-12)
    assert "friction_power_loss_mean" not in tree["history"]


def test_a_speed_makes_the_loss_a_number_of_watts():
    """Without one it is a torque on the pinion, which the angular velocity makes a power."""
    without, told = (sw.simulate(FAINT.replace({**speed, "effects.friction": {}})) for speed in ({}, SPEED))
    torque, loss = without["engagement"].friction_torque_loss, told["engagement"].friction_power_loss
    assert (torque.attrs["units"], loss.attrs["units"]) == ("N m", "W")
    np.testing.assert_allclose(loss, torque * 300.0 * np.pi / 30.0, rtol=1e-9)
    assert "friction_power_loss" not in without["engagement"] and "friction_torque_loss" not in told["engagement"]
    one, two = without["history"], told["history"]
    np.testing.assert_allclose(two.mesh_efficiency, one.mesh_efficiency, rtol=1e-12)
    power = PLAIN.operation.pinion_torque_Nm * 300.0 * np.pi / 30.0
    np.testing.assert_allclose(two.friction_power_loss_mean, (1.0 - one.mesh_efficiency) * power, rtol=1e-9)


def test_friction_takes_its_moment_off_the_normal_forces(rubbing):
    """sum F (r_b + mu t) = T at every mesh position, with the levers t found here."""
    tree, force, _, lever = rubbing
    positions = tree["mesh_cycle"].mesh_position.size
    moment = np.sum(force * (BASE_RADIUS + 0.1 * lever), axis=1).reshape(-1, positions).sum(axis=0)
    np.testing.assert_allclose(moment, TORQUE, rtol=1e-3)
    plain = np.sum(force * BASE_RADIUS, axis=1).reshape(-1, positions).sum(axis=0)
    assert np.abs(plain / TORQUE - 1.0).max() > 5e-3


def test_losses_are_proportional_to_a_small_coefficient():
    """To first order: friction changes the forces that rub by mu t/r_b, which nearly cancels over the mesh."""
    losses = [
        float(loaded({"effects.friction.coefficient": mu})["engagement"].friction_torque_loss.sum())
        for mu in (0.01, 0.02, 0.1)
    ]
    assert losses[1] / losses[0] == pytest.approx(2.0, rel=2e-3)
    assert losses[2] / losses[0] == pytest.approx(10.0, rel=2e-2)


# ---------------------------------------------------------------- mounting


@pytest.mark.parametrize(("field", "cosine"), [("offset", cos(PRESSURE_ANGLE)), ("axial_gear", sin(PRESSURE_ANGLE))])
def test_shafts_give_way_by_force_times_flexibility(field, cosine):
    """The load T/r_b along the line of action moves the pinion by c F cos, of which cos opens the gap."""
    rigid = dict(NEUTRAL)["shaft_compliance"]["effects.shaft_compliance"]
    errors = [
        float(
            loaded({"effects.shaft_compliance": rigid | {f"{field}_um_per_kN": c}})[
                "mesh_cycle"
            ].transmission_error_loaded.mean()
        )
        for c in (0.0, 2.0)
    ]
    expected = -2e-6 * TORQUE / BASE_RADIUS * cosine**2 * ARCSEC_PER_MM
    # normals along the line of contact differ by some degrees from the line of action
    assert errors[1] - errors[0] == pytest.approx(expected, rel=0.03)


def test_free_edges_soften_in_proportion_to_their_strength():
    errors = [
        float(loaded({"effects.free_edges.strength": s})["mesh_cycle"].transmission_error_loaded.mean())
        for s in (0.0, 0.5, 1.0)
    ]
    assert errors[0] > errors[1] > errors[2]
    assert errors[1] - errors[0] == pytest.approx(0.5 * (errors[2] - errors[0]), rel=0.05)


# ---------------------------------------------------------------- laws of wear, while loads stay as they are


def depth(changes, scene=FAINT):
    """Wear of the gear at the end [um]."""
    return sw.simulate(scene.replace(changes))["flank"].wear_depth.isel(wear_step=-1).sel(body="gear").values


def assert_proportional(found, expected):
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=LINEAR * expected.max())


@pytest.mark.slow
def test_a_spectrum_wears_as_the_sum_of_its_loads():
    torques, shares = [800.0, 1600.0, 2000.0], [0.3, 0.5, 0.2]
    together = depth({"effects.load_spectrum": {"torques_Nm": torques, "shares": shares}})
    each = [depth({"effects.load_spectrum": {"torques_Nm": [torque], "shares": [1.0]}}) for torque in torques]
    assert each[0].max() < 0.8 * each[2].max()
    apart = np.tensordot(shares, each, axes=1)
    assert together.sum() == pytest.approx(apart.sum(), rel=1e-5)
    assert np.sqrt(np.mean((together - apart) ** 2)) < 1e-4 * apart.max()
    np.testing.assert_allclose(together, apart, rtol=0.0, atol=1e-3 * apart.max())


@pytest.mark.slow
@pytest.mark.parametrize("torque", [800.0, 4000.0])
def test_a_spectrum_stands_in_place_of_the_torque_of_operation(torque):
    only = depth({"effects.load_spectrum": {"torques_Nm": [1600.0], "shares": [1.0]}}, DEEP)
    plain = depth({"operation.pinion_torque_Nm": 1600.0}, DEEP)
    aside = depth(
        {"effects.load_spectrum": {"torques_Nm": [1600.0], "shares": [1.0]}} | {"operation.pinion_torque_Nm": torque},
        DEEP,
    )
    np.testing.assert_allclose(only, plain, rtol=0.0, atol=1e-9 * plain.max())
    # what is left is where the search for contact begins; widths of 800 and 4000 N m left 16 % and more
    np.testing.assert_allclose(aside, plain, rtol=0.0, atol=1e-2 * plain.max())


def test_the_reference_pressure_scales_the_load_law():
    one, two = (
        depth({"effects.wear_law.load": {"exponent": 0.7, "reference_pressure_MPa": p}}) for p in (1000.0, 500.0)
    )
    assert_proportional(two, 2.0**0.7 * one)


def test_the_reference_temperature_scales_arrhenius():
    def worn_at(reference):
        law = {"activation_energy_kJ_per_mol": 30.0, "reference_temperature_C": reference}
        return depth(SPEED | {"effects.flash_temperature": {}, "effects.wear_law.temperature": law})

    factor = exp(30.0 / GAS_CONSTANT * (1.0 / 333.15 - 1.0 / 353.15))
    assert factor > 1.8
    assert_proportional(worn_at(80.0), worn_at(60.0) / factor)


def test_a_hot_bulk_is_arrhenius_factor_of_the_contact_temperature():
    """Without friction the contact has the temperature of the bulk."""
    heat = {"bulk_temperature_C": 120.0, "friction_coefficient": 0.0}
    law = {"activation_energy_kJ_per_mol": 30.0, "reference_temperature_C": 80.0}
    hot = depth(SPEED | {"effects.flash_temperature": heat, "effects.wear_law.temperature": law})
    assert_proportional(hot, exp(30.0 / GAS_CONSTANT * (1.0 / 353.15 - 1.0 / 393.15)) * depth({}))


def test_a_film_spares_wear_in_proportion_to_its_strength():
    def worn(strength):
        speed = {"operation.pinion_speed_rpm": 3000.0, "effects.lubrication": {}}
        return depth(speed | {"effects.wear_law.lubrication.strength": strength})

    none, half, all_of_it = worn(0.0), worn(0.5), worn(1.0)
    assert all_of_it.max() < 0.95 * none.max()
    assert_proportional(half, 0.5 * (none + all_of_it))


@pytest.mark.slow
def test_depth_has_a_kink_at_the_case_depth():
    """Under steady loads depth grows in proportion to meshes, and faster by H_case/H_core below the case."""
    law = {"surface_hardness_HV": 700.0, "core_hardness_HV": 400.0, "case_depth_um": 0.02}
    many = FAINT.replace({"numerics.wear_steps": 10, "wear.until.meshes": 1e6})
    tree = sw.simulate(many.replace({"effects.wear_law.hardness": law}))
    grown = tree["flank"].wear_depth.sel(body="gear").values
    plain = sw.simulate(many)["flank"].wear_depth.sel(body="gear").values
    expected = np.where(plain <= 0.02, plain, 0.02 + 700.0 / 400.0 * (plain - 0.02))
    assert (plain[-1] > 0.05).any() and ((plain[-1] > 0.0) & (plain[-1] < 0.02)).any()
    # a tenth of a micrometre against approaches of some um: loads stay within some per cent
    np.testing.assert_allclose(grown, expected, rtol=0.0, atol=0.03 * expected.max())
    np.testing.assert_allclose(grown[plain <= 0.015], plain[plain <= 0.015], atol=5e-4)


def test_a_harder_pitch_band_wears_less_and_only_there():
    law = {"surface_hardness_HV": 600.0, "core_hardness_HV": 600.0, "case_depth_um": 30.0}
    band = law | {"pitch_hardness_HV": 800.0, "pitch_band_mm": 1.5}
    plain, hard = (sw.simulate(FAINT.replace({"effects.wear_law.hardness": table}))["flank"] for table in (law, band))
    before, after = (flank.wear_depth.isel(wear_step=-1).sel(body="gear").values for flank in (plain, hard))
    worn = before > 0.05 * before.max()
    ratio = after[worn] / before[worn]
    near = np.abs(ratio - 0.75) < 1e-3
    away = np.abs(ratio - 1.0) < 1e-3
    assert near.sum() > 20 and away.sum() > 100
    assert np.all(near | away)
