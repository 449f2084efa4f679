"""Wear against the swept-line identity, conservation of volume, and its own refinement."""

from dataclasses import replace

import numpy as np
import pytest

import semiwear as sw
from semiwear.contact.footprint import Footprints
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_pair import DRIVEN, DRIVING
from semiwear.meshing.removed import Removed
from semiwear.plan import plan
from semiwear.wear.swept_line import EdgeShares, own_wear, sweep, wear_of_mesh, worn_sweep
from tests.strategies.aligned_face_gear import PINION_TEETH, sliding_speed, volume_off_gear
from tests.strategies.lines import even_grid, straight_lines

LOAD = 300.0  # N/mm
GOLDEN = 0.5 * (5.0**0.5 - 1.0)


class Valley:
    """Contact lines of the fresh aligned pair, by minimising the separation in every slice; (roll, face) arrays."""

    def __init__(self, pair, roll, face):
        self.pair, self.roll, self.face = pair, roll, face
        borders = pair.borders(face)
        # golden section, of all lines at once
        shape = roll.size, face.size
        low, high = (np.broadcast_to(end, shape).copy() for end in (borders.root - 1.0, borders.tip + 1.0))
        while (high - low).max() > 1e-9:
            left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
            first, second = (pair.meeting(face, place, roll[:, None]).separation for place in (left, right))
            low, high = np.where(first < second, low, left), np.where(first < second, right, high)
        self.profile = 0.5 * (low + high)

    def specific_sliding(self):
        """|v_s| / v_n of the gear at every inner roll position: v_n from where the line lies on the gear itself."""
        pair, u, f = self.pair, self.profile, self.face
        own, normals = pair.gear.points(f[None, :], u)
        along = np.gradient(own, f, axis=1)
        along /= np.linalg.norm(along, axis=-1, keepdims=True)
        per_roll = (own[2:] - own[:-2]) / (self.roll[2:] - self.roll[:-2])[:, None, None]
        across = np.cross(normals, along)[1:-1]
        speed = np.abs(np.sum(per_roll * across, axis=-1)) * PINION_TEETH / (2.0 * np.pi)
        met = pair.meeting(f[None, :], u, self.roll[:, None])
        # a line that rests on the bound of the search has left the flank
        moving = speed > 1e-3
        sliding = sliding_speed(met.position, met.normal)[1:-1]
        return np.where(moving, sliding / np.where(moving, speed, 1.0), np.nan)


def interior(teeth, nodes, profile, distance):
    """Nodes of a slice farther than `distance` half-widths from the ends of the loaded stretch."""
    reach = distance * teeth.half_width / teeth.lines.spacing.mean()
    return (nodes > profile.min() + reach) & (nodes < profile.max() - reach)


@pytest.fixture(scope="module")
def fresh(shipped):
    teeth = plan(shipped).loaded_teeth()
    state = teeth.load(np.zeros(teeth.grid.profile.shape))
    return teeth, state, worn_sweep(teeth, state)


@pytest.fixture(scope="module")
def valley(fresh):
    """Every ninth slice, at roll positions well inside the path of contact."""
    teeth = fresh[0]
    slices = np.arange(4, teeth.grid.face.size - 4, 9)
    roll = np.linspace(-1.3, 1.2, 101)
    around = teeth.grid.face[slices][:, None] + np.array([-0.5, 0.0, 0.5])
    found = Valley(teeth.pair, roll, around.ravel())
    sliding = found.specific_sliding().reshape(roll.size - 2, slices.size, 3)[..., 1]
    return slices, roll[1:-1], found.profile.reshape(roll.size, slices.size, 3)[1:-1, :, 1], sliding


def compare_with_identity(teeth, valley, mesh, line_load):
    """Difference from q |v_s|/v_n at smooth interior nodes over the greatest wear there, and their number."""
    slices, roll, place, sliding = valley
    worst, greatest, count = 0.0, 0.0, 0
    for column, i in enumerate(slices):
        # roll positions at which the fine grid's line is off every border and is loaded
        lines = teeth.fine
        free = (lines.profile[:, i] > lines.low[:, i] + 1e-6) & (lines.profile[:, i] < lines.high[:, i] - 1e-6)
        free &= line_load[:, i] > 0.0
        if not free.any():
            continue
        stretch = lines.profile[free, i]
        nodes = teeth.grid.profile[i]
        known = np.flatnonzero(np.isfinite(sliding[:, column]))
        at = known[np.argsort(place[known, column])]
        cusp = place[known[np.argmin(sliding[known, column])], column]
        inside = interior(teeth, nodes, stretch, 3.0) & (np.abs(nodes - cusp) > teeth.half_width)
        inside &= (nodes > place[at[0], column]) & (nodes < place[at[-1], column])
        load = np.interp(np.interp(nodes, place[at, column], roll[at]), lines.roll, line_load[:, i])
        expected = load * np.interp(nodes, place[at, column], sliding[at, column])
        if inside.any():
            worst = max(worst, np.abs(mesh[i] - expected)[inside].max())
            greatest = max(greatest, expected[inside].max())
            count += inside.sum()
    return worst / greatest, count


@pytest.mark.slow
def test_specific_sliding_of_the_lines(fresh, valley):
    teeth, _, motion = fresh
    slices, roll, _, expected = valley
    checked = 0
    for column, i in enumerate(slices):
        # at an edge the footprint's middle is not where the valley is
        lines = teeth.fine
        margin = np.minimum(lines.high - lines.profile, lines.profile - lines.low)[:, i]
        free = margin * lines.spacing[:, i] > 1.5 * teeth.half_width
        known = np.isfinite(expected[:, column])
        free &= (teeth.fine.roll > roll[known][0]) & (teeth.fine.roll < roll[known][-1])
        found = motion.specific_sliding[free, i]
        wanted = np.interp(teeth.fine.roll[free], roll[known], expected[known, column])
        np.testing.assert_allclose(found, wanted, atol=0.01 * wanted.max())
        checked += free.sum()
    assert checked > 300


def unworn(teeth):
    return teeth.removed(np.zeros(teeth.grid.profile.shape))


@pytest.mark.slow
def test_constant_load_wears_as_the_swept_line(fresh, valley):
    teeth, _, motion = fresh
    lines = teeth.fine
    line_load = np.where((lines.profile > lines.low) & (lines.profile < lines.high), LOAD, 0.0)
    mesh = wear_of_mesh(lines, teeth.grid, unworn(teeth), motion, line_load, teeth.half_width, teeth.problem.modulus)
    worst, count = compare_with_identity(teeth, valley, mesh, line_load)
    assert count > 200
    assert worst < 0.02


@pytest.mark.slow
def test_solved_load_wears_as_the_swept_line(fresh, valley):
    teeth, state, motion = fresh
    line_load = teeth.on_fine_rolls(teeth.problem.line_load(state.loads))
    mesh = wear_of_mesh(
        teeth.fine, teeth.grid, unworn(teeth), motion, line_load, teeth.half_width, teeth.problem.modulus
    )
    worst, count = compare_with_identity(teeth, valley, mesh, line_load)
    assert count > 100
    assert worst < 0.02


@pytest.mark.slow
def test_volume_is_load_times_sliding_distance(fresh):
    teeth, state, motion = fresh
    grid, lines, pair = teeth.grid, teeth.fine, teeth.pair
    touched = teeth.touch(np.zeros(teeth.grid.profile.shape))
    # what an edge's rounding bears wears no flank
    line_load = np.where(touched.edge, 0.0, teeth.on_fine_rolls(teeth.problem.line_load(state.loads)))
    mesh = wear_of_mesh(lines, grid, unworn(teeth), motion, line_load, teeth.half_width, teeth.problem.modulus)

    met = pair.meeting(lines.face[None, :], touched.profile, lines.roll[:, None])
    time = np.gradient(lines.roll) * 2.0 * np.pi / PINION_TEETH
    work = float(np.sum(line_load * lines.length * sliding_speed(met.position, met.normal) * time[:, None]))
    assert volume_off_gear(pair, grid, mesh) == pytest.approx(work, rel=0.01)


@pytest.mark.slow
def test_nothing_wears_where_nothing_touches(fresh):
    teeth, _, motion = fresh
    line_load = np.where(teeth.problem.is_near(teeth.fine), LOAD, 0.0)
    line_load[:, :20] = 0.0
    line_load[:, 40:] = 0.0
    mesh = wear_of_mesh(
        teeth.fine, teeth.grid, unworn(teeth), motion, line_load, teeth.half_width, teeth.problem.modulus
    )
    assert (mesh[:20] == 0.0).all()
    assert (mesh[40:] == 0.0).all()
    assert (mesh[20:40].max(axis=1) > 0.0).all()
    assert (mesh >= 0.0).all()


# ---------------------------------------------------------------- wear steps

LIFE = 1e10


@pytest.fixture(scope="module")
def by_steps(shipped):
    """Gear wear [um] of a whole life, by wear scheme and number of steps."""

    life = shipped.replace({"wear.until.meshes": LIFE, "numerics.face_slices": 31})

    def run(scheme, steps):
        return sw.simulate(life.replace({"numerics.wear_steps": steps, "numerics.wear_scheme": scheme}))

    runs = {("implicit", steps): run("implicit", steps) for steps in (1, 3, 12, 48)}
    return runs | {("explicit", 3): run("explicit", 3)}


def greatest(tree):
    return float(tree["flank"].wear_depth.isel(wear_step=-1).max())


@pytest.mark.slow
@pytest.mark.parametrize(("steps", "tolerance"), [(1, 0.12), (3, 0.05), (12, 0.02)])
def test_implicit_steps_converge(by_steps, steps, tolerance):
    assert greatest(by_steps["implicit", steps]) == pytest.approx(greatest(by_steps["implicit", 48]), rel=tolerance)


@pytest.mark.slow
def test_explicit_steps_overshoot_where_implicit_ones_do_not(by_steps):
    converged = greatest(by_steps["implicit", 48])
    assert greatest(by_steps["explicit", 3]) > 1.5 * converged
    assert greatest(by_steps["implicit", 3]) < 1.05 * converged


@pytest.mark.slow
def test_wear_is_not_negative_and_never_shrinks(by_steps, worn):
    for tree in (*by_steps.values(), worn):
        depth = tree["flank"].wear_depth.values
        assert (depth[0] == 0.0).all()
        assert (np.diff(depth, axis=0) >= 0.0).all()


@pytest.mark.slow
def test_wear_where_nothing_ever_touches_is_zero(by_steps):
    tree = by_steps["implicit", 12]
    loaded = (tree["engagement"].line_load > 0.0).any(("wear_step", "roll_position")).values
    depth = tree["flank"].wear_depth.sel(body="gear").isel(wear_step=-1)
    # a slice can have come into contact within the last step only: the last entry shows those too
    np.testing.assert_array_equal(depth.max("profile").values[~loaded] == 0.0, True)
    assert (depth.max("profile").values[loaded] > 0.0).any()


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["implicit", "two-stage", "explicit"])
def test_meshes_and_wear_coefficient_count_as_their_product(small, scheme):
    common = {"numerics.wear_steps": 2, "numerics.wear_scheme": scheme}
    one = sw.simulate(small.replace({**common, "wear.until.meshes": 4e9}))
    two = sw.simulate(small.replace({**common, "wear.until.meshes": 2e9, "wear.coefficient_mm2_per_N": 2e-13}))
    depth = one["flank"].wear_depth.values
    np.testing.assert_allclose(two["flank"].wear_depth.values, depth, rtol=1e-12, atol=1e-12 * depth.max())
    np.testing.assert_allclose(2.0 * two["history"].meshes, one["history"].meshes, rtol=1e-12)


@pytest.mark.slow
def test_control_depths_are_hit_and_meshes_grow(small):
    depths = [1.0, 2.5, 18.0, 19.0, 45.0]
    tree = sw.simulate(small.replace({"wear.until.control_depths_um": depths}))
    np.testing.assert_allclose(tree["history"].wear_depth_control_point, [0.0, *depths], atol=0.01)
    assert (np.diff(tree["history"].meshes) > 0.0).all()


@pytest.mark.slow
def test_wear_is_least_at_the_pitch_cone(worn):
    """On every well-worn slice the depth on the pitch cone is below that on either side of it."""
    flank = worn["flank"]
    depth = flank.wear_depth.sel(body="gear").isel(wear_step=1).values
    zone = flank.zone.sel(body="gear").values
    checked = 0
    for i in range(depth.shape[1]):
        sides = [depth[zone[:, i] == side, i] for side in (0, 1, 2)]
        if any(part.size == 0 for part in sides) or min(sides[0].max(), sides[2].max()) < 1.0:
            continue
        assert sides[1].min() < 0.25 * min(sides[0].max(), sides[2].max())
        checked += 1
    assert checked > 10


@pytest.mark.slow
def test_specific_sliding_of_the_flanks_has_the_signs_of_the_standard(worn):
    """Negative on the dedendum and positive on the addendum of either body (ISO 21771), and that of a rack here."""
    flank = worn["flank"].to_dataset()
    station = int(np.abs(flank.face.values - 508.0).argmin())
    for body in ("pinion", "gear"):
        here = flank.sel(body=body).isel(face=station)
        height, sliding = (here[name].values[here.active.values > 0] for name in ("flank_height", "specific_sliding"))
        assert np.all(sliding[height < -1.0] < 0.0)
        assert np.all(sliding[height > 1.0] > 0.0)
    # a gear this large is nearly a rack: sliding l per radian, line speed r_b tan(alpha) per radian
    base = 0.5 * 25 * 6.35 * np.cos(np.radians(25.0))
    rack = height / np.sin(np.radians(25.0)) / (base * np.tan(np.radians(25.0)))
    np.testing.assert_allclose(sliding, rack, atol=0.02)


def test_lines_leave_no_ripples_between_roll_positions():
    """Also where an edge bears on a band far narrower than the way between two positions, with nodes finer still."""
    scene = sw.load_scene("face_gear_25x160")
    teeth = plan(scene.replace({"numerics.profile_points": 401, "numerics.tooth_compliance": "rigid"})).loaded_teeth()
    removed = teeth.removed(np.zeros(teeth.grid.profile.shape))
    motion = sweep(teeth.fine, teeth.touch(np.zeros(teeth.grid.profile.shape)).profile, teeth.pair.roll_per_time)
    load = np.full(teeth.fine.profile.shape, LOAD)
    for i in (30, 45, 50):
        wear = wear_of_mesh(
            teeth.fine, teeth.grid, removed, motion, load, teeth.half_width, teeth.problem.modulus, np.array([i])
        )[i]
        middle = wear[130:270]
        assert np.abs(np.diff(middle, 2)).max() < 0.06 * middle.mean()


def test_nodes_between_which_a_flank_is_round_need_not_be_fine():
    """A flank worn evenly, but for a place outside of the contact, feels as the fresh one does."""
    scene = sw.load_scene("face_gear_25x160").replace({"numerics.profile_points": 61})
    teeth = plan(scene.replace({"numerics.tooth_compliance": "rigid"})).loaded_teeth()
    fresh = teeth.touch(np.zeros(teeth.grid.profile.shape))
    depth = np.zeros(teeth.grid.profile.shape)
    depth[:, 0] = 1e-6
    worn = teeth.touch(depth)
    inside = fresh.near & ~fresh.edge & (np.abs(teeth.fine.roll) < 0.4)[:, None]
    assert inside.sum() > 1000
    # the cubic against its parabola; chords from node to node would leave 4e-4
    assert np.abs(worn.gap[inside] - fresh.gap[inside]).max() < 4e-5


# ---------------------------------------------------------------- lines of no gear in particular


def moving_lines(place: np.ndarray, sliding: float = 1.5, slope: float = 0.7) -> ContactLines:
    """Straight lines on a flank whose profile coordinate is 0.7 mm."""
    lines = straight_lines(place, 2, step=0.5, across=0.02, sliding=sliding, sliding_slope=slope)
    lines.sliding[..., 1] = 2.0
    return replace(lines, spacing=0.7 * lines.spacing)


def test_lines_move_as_their_places_and_slide_as_the_places_that_they_have():
    """Ten base pitches per unit time; worn lines lie 0.2 below the fresh ones."""
    lines = moving_lines(-3.0 * np.linspace(-0.5, 0.5, 6))
    motion = sweep(lines, lines.profile - 0.2, 10.0)
    np.testing.assert_allclose(motion.speed, 3.0 * 0.7 * 10.0)
    np.testing.assert_array_equal(motion.direction, -1.0)
    np.testing.assert_allclose(motion.sliding, np.broadcast_to([1.5 - 0.7 * 0.2, 2.0], (6, 2, 2)))
    np.testing.assert_allclose(motion.time, 0.02)
    np.testing.assert_allclose(motion.specific_sliding, np.hypot(1.36, 2.0) / 21.0)
    np.testing.assert_allclose(motion.driving_specific_sliding, np.hypot(1.36, 2.0) / (21.0 + 1.36))


def test_a_line_moves_by_the_mean_of_its_steps_and_never_stands_still():
    """The flank is 20 high; on the driving one a line moves by no less than a thousandth of what it does here."""
    lines = moving_lines(np.array([0.0, 1.0, 3.0, 6.0, 6.0, 6.0]))
    motion = sweep(lines, lines.profile, 2.0)
    expected = 0.7 * 2.0 / 0.2 * np.array([1.0, 1.5, 2.5, 1.5, 0.0, 0.0])
    expected[4:] = 7.5e-8 * 20.0 * 0.7 * 2.0
    np.testing.assert_allclose(motion.speed[:, 0], expected)
    rolling = replace(motion, sliding=np.stack([motion.speed, 0.0 * motion.speed], axis=-1))
    np.testing.assert_allclose(rolling.driving_specific_sliding[:4], 1e3)


@pytest.mark.parametrize("modulus", [1e3, 1e5])
def test_a_load_wears_a_plane_flank_as_a_line_sweeps_it(modulus):
    lines = moving_lines(4.0 * np.linspace(-0.5, 0.5, 61), slope=0.0)
    motion, grid = sweep(lines, lines.profile, 10.0), even_grid(lines, 401)
    removed, load = Removed.met(grid, np.zeros((1, 2, 401)), 61), np.full((61, 2), 300.0)
    depth = wear_of_mesh(lines, grid, removed, motion, load, 0.1, modulus)
    inner = np.abs(grid.profile) < 1.5
    np.testing.assert_allclose(depth[inner], 300.0 * np.hypot(1.5, 2.0) / motion.speed[0, 0], rtol=5e-3)


def test_shares_of_edges_are_kept_with_the_wear_of_the_cycle_before():
    known, wear = EdgeShares.unknown((3, 2)), np.array([1e-3, 2e-3])
    after = known.after(wear)
    assert after.edges is known.edges and after.most is wear


def own_wear_of(
    lines: ContactLines, distance: np.ndarray, body: int = DRIVEN, fades: float = 0.0, half_width: float = 0.6
) -> np.ndarray:
    """Implicit wear compliance of the first slice where the approach grows by 1 um."""
    removed = Removed.met(even_grid(lines, 11), np.zeros((1, 2, 11)), lines.roll.size)
    one = np.ones(lines.profile.shape)
    worn = Footprints(removed, lines.profile, 0.0 * one, one, half_width * one, one, 0.0 * one, 0.0 * one)
    motion = sweep(lines, lines.profile, 10.0)
    return own_wear(lines, motion, worn, distance[:, None] * one, 1e-3, body, fades)[:, 0]


def test_the_wear_compliance_of_a_moving_line_is_specific_sliding_over_the_length_of_a_slice():
    """On either flank; the driving one is a mirror image, twice as high."""
    lines = moving_lines(4.0 * np.linspace(-0.5, 0.5, 61), slope=0.0)
    expected = np.hypot(1.5, 2.0) / (4.0 * 0.7 * 10.0) / 0.5
    np.testing.assert_allclose(own_wear_of(lines, np.zeros(61))[26:-26], expected, rtol=1e-3)
    mirrored = replace(lines, driving_profile=-2.0 * lines.profile, driving_slope=-2.0 * np.ones((61, 2)))
    np.testing.assert_allclose(own_wear_of(mirrored, np.zeros(61), DRIVING)[26:-26], expected, rtol=1e-3)
    # at the first position half of what overlaps and half of itself; narrow footprints fill the step to the next ones
    own = 35.0 / 64.0 * (4.0 / 60.0) / np.array([0.6 / 0.7, 0.5 * 4.0 / 60.0])
    assert own_wear_of(lines, np.zeros(61))[0] == pytest.approx(expected * (0.5 + 0.5 * own[0]), rel=1e-3)
    np.testing.assert_allclose(own_wear_of(lines, np.zeros(61), half_width=1e-6)[1:-1], expected * own[1], rtol=1e-9)


def test_roll_positions_that_come_into_contact_later_count_in_part():
    """By a cubic from 1 to 0; what is farther than 7.5 % of the flank's height has no compliance."""
    lines, at = moving_lines(4.0 * np.linspace(-0.5, 0.5, 61), slope=0.0), np.arange(61)
    whole, at_once, later, never, far = (
        own_wear_of(lines, np.where(at == 33, late, 0.0), fades=4e-3)
        for late in (0.0, 1e-3, 1e-3 + 0.3 * 4e-3, 5.1e-3, 1.51)
    )
    near = np.abs(at - 33) < 8
    np.testing.assert_array_equal(at_once, whole)
    assert (whole - never)[near & (at != 33)].min() > 1e-3 * whole[33]
    np.testing.assert_allclose((whole - later)[at != 33], (1.0 - 1.6 * 0.49) * (whole - never)[at != 33], atol=1e-12)
    np.testing.assert_allclose(later[33], whole[33], rtol=1e-9)  # all others are in contact when it is
    assert far[33] == 0.0 and own_wear_of(lines, np.where(at == 33, 1.49, 0.0))[33] > 0.0
