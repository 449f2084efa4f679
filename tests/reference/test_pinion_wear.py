"""Wear of the driving flank: the swept line on its own surface, its volume, and its place in the mesh.

A pinion tooth meshes N2/N1 times as often as a gear tooth, under the same loads and the same sliding.
"""

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator

import semiwear as sw
from semiwear.plan import plan
from semiwear.wear.swept_line import fresh_sweep, wear_of_both_flanks, worn_sweep
from semiwear.wear.worn import Worn
from tests.strategies.aligned_face_gear import GEAR_TEETH, PINION_TEETH, sliding_speed, volume_off_gear
from tests.strategies.effect_scenes import PLAIN

RATIO = GEAR_TEETH / PINION_TEETH
LOAD = 300.0  # N/mm
BOTH = {"wear.worn_bodies": ["pinion", "gear"]}
# tooth compliance changes loads, not what they wear off; local contact alone is quick on a fine grid
FINE = sw.load_scene("face_gear_25x160").replace(
    BOTH
    | {
        "numerics.tooth_compliance": "rigid",
        "wear.control_point": None,
        "wear.until.meshes": 1e6,
        "numerics.wear_steps": 1,
    }
)
K_PINION, K_GEAR = 2.5e-13, 1e-13
DIFFERENT = {"wear.coefficient_mm2_per_N": {"pinion": K_PINION, "gear": K_GEAR}}


def speed_over_pinion(lines):
    """v_n1 [mm per radian]: of the line over the involute, which unrolls into a plane (arc length, axis)."""
    arc, axis, roll, face = lines.driving_profile, lines.driving_face, lines.roll, lines.face
    along = np.stack([np.gradient(arc, face, axis=1), np.gradient(axis, face, axis=1)], axis=-1)
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    move = np.stack([np.gradient(arc, roll, axis=0), np.gradient(axis, roll, axis=0)], axis=-1)
    return np.abs(move[..., 0] * along[..., 1] - move[..., 1] * along[..., 0]) * PINION_TEETH / (2.0 * np.pi)


@pytest.fixture(scope="module")
def fresh():
    teeth = plan(FINE).loaded_teeth()
    state = teeth.load(np.zeros(teeth.grid.profile.shape), None, np.zeros(teeth.driving.grid.profile.shape))
    return teeth, state


def free_of_borders(teeth, distance=2.0):
    """Places on the lines farther from the ends of both flanks than some half-widths, and not where lines turn."""
    lines, reach = teeth.fine, distance * teeth.half_width
    free = (np.minimum(lines.profile - lines.low, lines.high - lines.profile) * lines.spacing) > reach
    free &= np.isfinite(lines.separation[0])
    free[1:-1] &= free[2:] & free[:-2]
    free[[0, -1]] = False
    free[:, :2] = free[:, -2:] = False
    return free


def test_sliding_over_the_pinions_own_line_speed(fresh):
    """`driving_specific_sliding` of fresh lines is |v_s|/v_n1 from the motions and the unrolled involute."""
    teeth = fresh[0]
    lines, pair = teeth.fine, teeth.pair
    met = pair.meeting(lines.face[None, :], lines.profile, lines.roll[:, None])
    expected = sliding_speed(met.position, met.normal) / speed_over_pinion(lines)
    found = fresh_sweep(pair, lines).driving_specific_sliding
    free = free_of_borders(teeth)
    assert free.sum() > 3000
    assert np.abs(found - expected)[free].max() < 0.01 * expected[free].max()


def expected_on_pinion(teeth, amount):
    """A quantity known on the lines, at the pinion's nodes; NaN where no free line passes."""
    lines, own, free = teeth.fine, teeth.driving.grid, free_of_borders(teeth)
    places = np.column_stack([lines.driving_profile[free], lines.driving_face[free]])
    values = LinearNDInterpolator(places, amount[free])(
        own.profile, np.broadcast_to(own.face[:, None], own.profile.shape)
    )
    low = np.min(lines.driving_profile, axis=0, where=free, initial=np.inf)
    high = np.max(lines.driving_profile, axis=0, where=free, initial=-np.inf)
    # triangles span what lies beyond the free stretches of their three slices: it is not known
    for beside in (-1, 0, 1):
        reached = (own.profile > np.roll(low, beside)[:, None]) & (own.profile < np.roll(high, beside)[:, None])
        values[~reached] = np.nan
    return values


def swept_depth_on_pinion(teeth, line_load):
    """q |v_s|/v_n1 at the pinion's nodes [N/mm], from the motions alone."""
    lines = teeth.fine
    met = teeth.pair.meeting(lines.face[None, :], lines.profile, lines.roll[:, None])
    speed = np.maximum(speed_over_pinion(lines), 1e-6)
    return expected_on_pinion(teeth, line_load * sliding_speed(met.position, met.normal) / speed)


def off_the_cusp(teeth, values):
    """Known nodes more than a contact width from where the line slides least, and off the ends of the face."""
    lines, own = teeth.fine, teeth.driving.grid
    sliding = np.where(free_of_borders(teeth), np.hypot(*np.moveaxis(lines.sliding, -1, 0)), np.inf)
    cusp = lines.driving_profile[np.argmin(sliding, axis=0), np.arange(own.face.size)]
    clear = np.isfinite(values) & (np.abs(own.profile - cusp[:, None]) > 2.0 * teeth.half_width)
    clear[:3] = clear[-3:] = False
    return clear


def test_the_rounding_of_the_gears_tip_meets_the_wall_beyond_it(fresh):
    """The driving flank goes on where the driven one ends; what is gone from the latter ends with it."""
    teeth, state = fresh
    lines, own = teeth.fine, teeth.driving.grid
    wall = np.maximum(own.profile - own.profile[:, :1], 0.0) * 1e-3
    removed = teeth.removed(state.wear + 5e-3, wall)
    places = removed.grid.profile
    k, i = np.nonzero(teeth.driving.near & np.isfinite(lines.separation[0]))
    rounding = (lines.high_edge_radius / lines.spacing)[k, i]
    at_tip = np.isclose(lines.high[k, i], teeth.grid.profile[i, -1])
    assert at_tip.sum() > 100
    for a, b, reach in zip(k[at_tip], i[at_tip], rounding[at_tip], strict=True):
        beyond = (places[b] > lines.high[a, b]) & (places[b] <= lines.high[a, b] + reach)
        met = lines.driving_profile[a, b] + lines.driving_slope[a, b] * (places[b][beyond] - lines.profile[a, b])
        expected = 5e-3 + 1e-3 * np.clip(met - own.profile[0, 0], 0.0, np.ptp(own.profile[0]))
        assert beyond.any() and places[b, -1] >= lines.high[a, b] + reach - 1e-9
        np.testing.assert_allclose(removed.depth[removed.row[a], b, beyond], expected, atol=1e-6)


def test_a_constant_load_wears_the_pinion_as_the_swept_line(fresh):
    teeth, state = fresh
    lines, slices = teeth.fine, np.arange(teeth.grid.face.size)
    line_load = np.where((lines.profile > lines.low) & (lines.profile < lines.high), LOAD, 0.0)
    motion = worn_sweep(teeth, state)
    removed = teeth.removed(state.wear, state.driving_wear)
    mesh, _ = wear_of_both_flanks(
        lines, teeth.grid, teeth.driving, removed, motion, line_load, teeth.half_width, teeth.problem.modulus, slices
    )
    expected = swept_depth_on_pinion(teeth, line_load)
    clear = off_the_cusp(teeth, expected)
    assert clear.sum() > 2000
    assert np.abs(mesh - expected)[clear].max() < 0.02 * expected[clear].max()


@pytest.fixture(scope="module")
def one_step():
    """A step so small that wear changes no load, with a coefficient for each body."""
    physics = plan(FINE.replace(DIFFERENT))
    teeth = physics.loaded_teeth()
    stepper = physics.wear_stepper(teeth)
    return teeth, stepper, stepper.step(stepper.start(), 1e5)


def test_a_solved_load_wears_the_pinion_as_the_swept_line(one_step):
    teeth, _, state = one_step
    line_load = teeth.on_fine_rolls(teeth.problem.line_load(state.contact.loads))
    expected = 1e5 * RATIO * K_PINION * swept_depth_on_pinion(teeth, line_load)
    clear = off_the_cusp(teeth, expected)
    assert clear.sum() > 1000
    depth = state.contact.driving_wear
    # the contact's width blurs the ends of the load, which are few of the nodes
    assert np.quantile(np.abs(depth - expected)[clear], 0.95) < 0.02 * expected[clear].max()


def volumes(teeth, worn):
    """Volume worn off one tooth of each body [mm^3]."""
    grid, own = teeth.grid, teeth.driving.grid
    width = grid.face[1] - grid.face[0]
    # the pinion's profile coordinate is the arc length of its involute, and its face coordinate lies along its axis
    pinion = width * np.trapezoid(worn.driving, own.profile, axis=1).sum()
    return float(pinion), volume_off_gear(teeth.pair, grid, worn.driven)


def test_volumes_are_as_coefficients_times_meshes(one_step):
    """Both flanks feel the same force over the same sliding distance: V1/V2 = k1 N2/(k2 N1)."""
    teeth, _, state = one_step
    pinion, gear = volumes(teeth, state.worn)
    assert pinion / gear == pytest.approx(RATIO * K_PINION / K_GEAR, rel=0.01)


def test_volume_of_the_pinion_is_load_times_sliding_distance(fresh):
    teeth, state = fresh
    lines, pair = teeth.fine, teeth.pair
    # what an edge's rounding bears wears no flank
    load = np.where(free_of_borders(teeth), LOAD, 0.0)
    motion = worn_sweep(teeth, state)
    removed = teeth.removed(state.wear, state.driving_wear)
    slices = np.arange(teeth.grid.face.size)
    mesh, _ = wear_of_both_flanks(
        lines, teeth.grid, teeth.driving, removed, motion, load, teeth.half_width, teeth.problem.modulus, slices
    )
    met = pair.meeting(lines.face[None, :], lines.profile, lines.roll[:, None])
    time = np.gradient(lines.roll) * 2.0 * np.pi / PINION_TEETH
    work = float(np.sum(load * lines.length * sliding_speed(met.position, met.normal) * time[:, None]))
    assert volumes(teeth, Worn(state.wear, mesh))[0] == pytest.approx(work, rel=0.002)


def test_depths_where_the_flanks_meet_are_as_their_line_speeds(one_step):
    """h1/h2 = (k1 N2/N1) v_n2/(k2 v_n1): load and sliding are common, and the line sweeps over both flanks."""
    teeth, _, state = one_step
    lines, own = teeth.fine, teeth.driving.grid
    motion = fresh_sweep(teeth.pair, lines)
    free = free_of_borders(teeth, 4.0) & (motion.specific_sliding > 0.05)
    checked = []
    for i in range(4, lines.face.size - 4, 3):
        rolls = np.flatnonzero(free[:, i])
        gear = np.interp(lines.profile[rolls, i], teeth.grid.profile[i], state.worn.driven[i])
        pinion = np.array(
            [
                np.interp(
                    lines.driving_face[k, i],
                    own.face,
                    [
                        np.interp(lines.driving_profile[k, i], own.profile[j], state.worn.driving[j])
                        for j in range(own.face.size)
                    ],
                )
                for k in rolls
            ]
        )
        expected = (
            RATIO * K_PINION / K_GEAR * motion.driving_specific_sliding[rolls, i] / motion.specific_sliding[rolls, i]
        )
        deep = gear > 0.1 * state.worn.driven.max()
        checked.append((pinion[deep] / gear[deep]) / expected[deep])
    ratio = np.concatenate(checked)
    assert ratio.size > 100
    # rolls are a hundredth of a base pitch apart, and where load begins and ends depths are blurred
    assert abs(np.median(ratio) - 1.0) < 0.01
    assert np.quantile(np.abs(ratio - 1.0), 0.9) < 0.05


# ---------------------------------------------------------------- wear runs


def depths(changes):
    return sw.simulate(PLAIN.replace(changes))["flank"].wear_depth.values


@pytest.mark.slow
def test_a_gear_that_hardly_wears_leaves_the_pinion_alone():
    alone = depths({"wear.worn_bodies": ["pinion"]})
    meshes = PLAIN.wear.until.meshes
    few = {"wear.until.meshes": 1e-8 * meshes, "wear.coefficient_mm2_per_N": {"pinion": 1e-5, "gear": 1e-16}}
    both = depths(BOTH | few)
    assert alone[-1, 0].max() > 10.0
    assert (alone[:, 1] == 0.0).all()
    np.testing.assert_allclose(both[:, 0], alone[:, 0], rtol=0.0, atol=1e-9 * alone.max())


@pytest.mark.slow
def test_wear_of_both_depends_on_coefficient_times_meshes():
    one = depths(BOTH | {"wear.coefficient_mm2_per_N": {"pinion": 2e-13, "gear": 1e-13}})
    two = depths(BOTH | {"wear.coefficient_mm2_per_N": {"pinion": 8e-13, "gear": 4e-13}, "wear.until.meshes": 5e8})
    np.testing.assert_allclose(two, one, rtol=0.0, atol=1e-10 * one.max())


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["implicit", "two-stage", "explicit"])
def test_wear_of_both_never_shrinks(scheme):
    meshes = 1e8 if scheme == "explicit" else 2e9  # explicit steps must be short
    worn = depths(BOTH | {"numerics.wear_steps": 5, "wear.until.meshes": meshes, "numerics.wear_scheme": scheme})
    assert (worn[0] == 0.0).all()
    assert (np.diff(worn, axis=0) >= 0.0).all()
    assert (worn[-1].max(axis=(1, 2)) > 1.0).all()


@pytest.mark.slow
def test_long_steps_of_both_are_stable():
    """Six times as many meshes make the pinion the faster to wear: two steps are within 15 % of eight."""
    two, eight = (depths(BOTH | {"numerics.wear_steps": n})[-1].max() for n in (2, 8))
    assert two == pytest.approx(eight, rel=0.15)


@pytest.mark.parametrize("depth", [0.001, 0.05])
def test_an_even_depth_off_either_flank_only_delays(depth):
    """Off the pinion or off the gear: the separation grows by it everywhere, and all else stays."""
    physics = plan(PLAIN.replace(BOTH))
    teeth = physics.loaded_teeth()
    gear, pinion = np.zeros(teeth.grid.profile.shape), np.zeros(teeth.driving.grid.profile.shape)
    fresh = teeth.load(gear, None, pinion)
    off_gear, off_pinion = teeth.load(gear + depth, None, pinion), teeth.load(gear, None, pinion + depth)
    for state in (off_gear, off_pinion):
        later = teeth.problem.approach(state.loads) - teeth.problem.approach(fresh.loads)
        np.testing.assert_allclose(later, depth, rtol=0.0, atol=1e-6)
        # the loads are found to 1e-6 of the widths, and elastic ones start elsewhere
        np.testing.assert_allclose(
            state.loads.force, fresh.loads.force, rtol=0.0, atol=1e-4 * fresh.loads.force.max()
        )
    gaps = [teeth.touch(one.wear, one.driving_wear).gap for one in (off_pinion, off_gear)]
    np.testing.assert_allclose(*(gap[teeth.driving.near] for gap in gaps), rtol=1e-12)


@pytest.mark.parametrize(("worn", "height"), [(["pinion"], -1.0), (["pinion", "gear"], 2.0)])
def test_a_control_point_on_the_pinion_is_worn_to_its_depths(worn, height):
    """The depths asked for are those of the pinion's own map at the point's height."""
    point = {"face_mm": 0.0, "height_mm": height, "body": "pinion"}
    rigid = {"numerics.tooth_compliance": "rigid", "numerics.roll_positions": 12, "numerics.face_slices": 11}
    end = {"wear.worn_bodies": worn, "wear.until.control_depths_um": [2.0, 5.0], "wear.control_point": point}
    tree = sw.simulate(sw.load_scene("spur_fzg_c").replace(rigid | end))
    history = tree["history"].to_dataset()
    np.testing.assert_allclose(history["wear_depth_control_point"], [0.0, 2.0, 5.0], rtol=1e-3)
    flank = tree["flank"].to_dataset().sel(body="pinion").isel(face=5, wear_step=-1)
    assert np.interp(height, flank["flank_height"], flank["wear_depth"]) == pytest.approx(5.0, rel=2e-3)


def test_every_worn_body_is_in_the_history():
    """Greatest wear of both bodies and of the pinion's zones, as its map has them."""
    rigid = {"numerics.tooth_compliance": "rigid", "numerics.roll_positions": 12, "numerics.face_slices": 11}
    tree = sw.simulate(sw.load_scene("spur_fzg_c").replace(rigid | {"numerics.wear_steps": 2}))
    history, flank = tree["history"].to_dataset(), tree["flank"].to_dataset().isel(wear_step=-1)
    np.testing.assert_allclose(history["wear_depth_max"][-1], flank["wear_depth"].max(("profile", "face")))
    pinion = flank.sel(body="pinion")
    for value, zone in enumerate(("root", "pitch", "addendum")):
        there = float(pinion["wear_depth"].where(pinion["zone"] == value).max())
        # borders of zones are read as well as nodes
        assert there <= float(history[f"wear_depth_max_pinion_{zone}"][-1]) <= 1.3 * there
    # where the driven flank's band is met: a fresh half-width to either side of the pitch cylinder
    band = pinion["flank_height"].where(pinion["zone"] == 1)
    assert float(band.min()) < 0.0 < float(band.max()) < 1.0
