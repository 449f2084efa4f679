"""What a footprint leaves between roll positions: even where it should be, and kind to ripples of any length."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from semiwear.plan import plan
from semiwear.simulate import simulate
from semiwear.wear.between_rolls import (
    VALLEY,
    lay,
    lay_points,
    lies_within,
    node_width,
    shifts_of,
    span_of,
    step_of,
)
from semiwear.wear.swept_line import wear_of_both_flanks, wear_of_mesh, worn_sweep

NODES = np.concatenate([np.linspace(-3.0, 0.2, 41), np.linspace(0.2, 4.0, 61)[1:]])
SPLIT = 40
SLICE = 4
RIGID = {"face_slices": 11, "tooth_compliance": "rigid"}  # how teeth bend does not matter to ripples


@given(st.floats(-2.5, 3.5), st.floats(-0.5, 0.5), st.floats(0.0, 10.0))
def test_what_is_laid_down_is_all_there_and_in_its_place(middle, step, amount):
    out = np.zeros(NODES.size)
    lay(NODES, SPLIT, middle, step, amount, out)
    assert np.all(out >= 0.0)
    assert out.sum() == pytest.approx(amount, rel=1e-9, abs=1e-12)
    assert out @ NODES == pytest.approx(amount * middle, rel=1e-6, abs=1e-9)


@given(st.floats(0.02, 0.6), st.floats(0.0, 1.0))
def test_even_steps_leave_an_even_depth(step, first):
    out = np.zeros(NODES.size)
    for middle in np.arange(-5.0 + first * step, 6.0, step):
        lay(NODES, SPLIT, middle, step, step, out)
    widths = np.convolve(np.diff(NODES), [0.5, 0.5], mode="full")
    np.testing.assert_allclose(out / widths, 1.0, rtol=1e-9)


@pytest.mark.parametrize("middle", [-3.05, -1.0, 0.18, 3.97])
@pytest.mark.parametrize("step", [3e-4, 0.05, 0.4])
def test_every_node_takes_its_share_of_what_fades_out(middle, step):
    """Against the integral of the density times the hat function of the node."""
    out = np.zeros(NODES.size)
    laid = lay(NODES, SPLIT, middle, step, 2.0, out)
    points, weights = np.polynomial.legendre.leggauss(3)
    even, reach = span_of(NODES, step)
    assert even + reach == pytest.approx(step)
    ends = np.unique(np.concatenate([NODES, middle + np.array([-reach, -even, even, reach])]))
    ends = ends[(ends >= NODES[0]) & (ends <= NODES[-1])]
    half = 0.5 * np.diff(ends)[:, None]
    x = 0.5 * (ends[1:] + ends[:-1])[:, None] + half * points
    density = np.clip((reach - np.abs(x - middle)) / (reach - even), 0.0, 1.0) / step
    amount = 2.0 * half * weights * density
    for node, found in enumerate(out):
        hat = np.interp(x, NODES, np.eye(NODES.size)[node])
        assert found == pytest.approx(float((amount * hat).sum()), abs=1e-14 / step)
    assert laid == pytest.approx(float(amount.sum()), abs=1e-14 / step)


@given(st.floats(1e-3, 3.0), st.floats(2.0, 100.0), st.sampled_from([0, 1, 2]))
def test_no_ripple_that_the_nodes_hold_is_worn_deeper(step, cells, coarser):
    """Its share of what is laid evenly over a step is the density's transform at its wavelength."""
    below, above = np.linspace(-3.0, 0.0, 31), np.linspace(0.0, 4.0, 41)
    scales = ((1.0, 1.0), (3.0, 1.0), (1.0, 3.0))[coarser]  # the finer cells decide, on whichever side they are
    nodes = np.concatenate([scales[0] * below[:-1], scales[1] * above])
    even, reach = span_of(nodes, step)
    waves = 1.0 / (0.1 * cells)
    assert np.sinc((reach + even) * waves) * np.sinc((reach - even) * waves) >= -1e-12


@pytest.mark.parametrize("step", [0.02, 0.1, 0.15, 0.3])
def test_wear_is_smoothed_by_little_more_than_the_step_itself(step):
    """Second moment of what is laid: of an even step step^2/12, of a triangle twice as much; the nodes add theirs."""
    nodes = np.linspace(-3.0, 4.0, 71)
    out = np.zeros(nodes.size)
    lay(nodes, 35, 0.5, step, 1.0, out)
    fades = np.clip(step / 0.2, 0.5, 1.0)
    inside = out @ (nodes - 0.5) ** 2 - (1.0 + fades**2) * step**2 / 12.0
    assert -1e-12 < inside < 0.1**2 / 4.0


@given(st.lists(st.floats(-2.0, 2.5), min_size=1, max_size=40), st.floats(0.006, 0.9), st.floats(0.1, 10.0))
def test_amounts_laid_together_lie_as_one_by_one(places, step, scale):
    middle = np.sort(np.array(places))
    amount = scale * (1.0 + np.sin(np.arange(middle.size)))
    assert lies_within(NODES, middle, middle.size, step)
    together, alone = np.zeros(NODES.size), np.zeros(NODES.size)
    lay_points(NODES, SPLIT, middle, amount, middle.size, step, together)
    for place, one in zip(middle, amount, strict=True):
        lay(NODES, SPLIT, place, step, one, alone)
    assert np.all(together >= 0.0)
    np.testing.assert_allclose(together, alone, atol=1e-8 * amount.sum())


def test_amounts_that_reach_beyond_the_nodes_are_laid_one_by_one():
    assert not lies_within(NODES, np.array([-2.9, 0.0]), 2, 0.2)
    assert not lies_within(NODES, np.array([0.0, 3.9]), 2, -0.2)
    assert not lies_within(NODES, np.array([0.0]), 1, 1e-4)
    assert not lies_within(NODES, np.array([]), 0, 0.1)


def test_a_place_that_moves_evenly_has_one_step_wherever_it_bears():
    """Also where roll positions begin and end, and beside some that bear nothing, whose places say nothing."""
    place, rate = 0.3 * np.arange(6.0), np.ones(6)
    assert [step_of(place, rate, k) for k in range(6)] == pytest.approx([0.3] * 6)
    place[[0, 5]], rate[[0, 5]] = 99.0, 0.0
    assert [step_of(place, rate, k) for k in range(1, 5)] == pytest.approx([0.3] * 4)
    assert step_of(np.array([5.0, 0.3, 7.0]), np.array([0.0, 1.0, 0.0]), 1) == 0.0


def test_nodes_stand_for_all_of_the_height_between_them():
    widths = [node_width(NODES, p) for p in range(NODES.size)]
    np.testing.assert_allclose(widths, np.convolve(np.diff(NODES), [0.5, 0.5], mode="full"))


def at(places: np.ndarray) -> np.ndarray:
    """Ends of stretches that are points."""
    return np.stack([places, places], axis=1)


def test_only_one_stretch_moves_as_a_whole():
    middle, shift = np.array([-1.0, 0.0, 1.0]), np.zeros(3)
    ends = (-3.0, 4.0, 0.1, 0.5, 0.0, 0.0)
    for marks, alike in (([0, 0, 0], True), ([VALLEY] * 3, True), ([0, 0, VALLEY], False), ([0, 0, 1], False)):
        assert shifts_of(middle, at(middle), np.array(marks), 3, *ends, shift) == alike
    assert not shifts_of(middle, at(middle), np.zeros(3, dtype=np.int64), 3, -3.0, 1.0, *ends[2:], shift)


def test_what_lies_beyond_a_border_wears_no_flank():
    out = np.zeros(NODES.size)
    lay(NODES, SPLIT, NODES[-1], 0.3, 2.0, out)
    assert out.sum() == pytest.approx(1.0)
    lay(NODES, SPLIT, NODES[-1] + 0.4, 0.3, 2.0, out)
    assert out.sum() == pytest.approx(1.0)


def test_a_footprint_cut_off_stays_at_its_end():
    middle, at_edge, shift = np.linspace(1.0, 2.0, 11), np.zeros(11, dtype=np.int64), np.zeros(11)
    shifts_of(middle, at(middle), at_edge, 11, -3.0, 2.0, 0.1, 0.5, 0.0, 0.0, shift)
    np.testing.assert_allclose(shift, 0.5 * (2.0 - middle), atol=1e-12)
    # the lower end moves by itself
    shifts_of(middle, at(middle), at_edge, 11, 1.0, 4.0, 0.1, 0.5, -0.2, 0.0, shift)
    np.testing.assert_allclose(shift, -0.2 + 0.7 * (middle - 1.0), atol=1e-12)
    shifts_of(middle, at(middle), at_edge, 11, -3.0, 4.0, 0.1, 0.5, 0.0, 0.0, shift)
    np.testing.assert_allclose(shift, 0.5)


@pytest.mark.parametrize("end", ["low", "high"])
def test_a_footprint_comes_to_be_held_by_and_by(end):
    """As it nears an end of the slice, and as a stretch is added there that weighs nothing."""
    slack, held = 0.1, -0.2 if end == "low" else 0.1

    def shifts(distance: float, added: float) -> np.ndarray:
        """Of ten stretches and perhaps a short one, the last of which ends at a distance from the border."""
        places = np.append(np.arange(10) * 0.1 + 0.05, [0.1 * 9 + 0.1 + 0.5 * added] * (added > 0.0))
        width = np.append(np.full(10, 0.1), [added] * (added > 0.0))
        places = places + 4.0 - 1.0 - distance
        stretches = np.stack([places - 0.5 * width, places + 0.5 * width], axis=1)
        if end == "low":
            places, stretches = 1.0 - places[::-1], 1.0 - stretches[::-1, ::-1]
        shift = np.zeros(places.size)
        none = np.zeros(places.size, dtype=np.int64)
        shifts_of(places, stretches, none, places.size, -3.0, 4.0, slack, 0.5, -0.2, 0.1, shift)
        return (shift if end == "high" else shift[::-1])[:10]

    distances = np.linspace(-0.05, 0.15, 81)
    path = np.array([shifts(distance, 0.0) for distance in distances])
    assert np.abs(np.diff(path, axis=0)).max() < 0.7 * (distances[1] - distances[0]) / slack * 1.2
    np.testing.assert_array_equal(path[-1], 0.5)
    assert path[0, -1] == pytest.approx(held, abs=0.1)
    for distance in distances:
        np.testing.assert_allclose(shifts(distance, 1e-9), shifts(distance, 0.0), atol=1e-7)


def test_a_pressed_edge_moves_with_its_end_of_the_slice():
    middle, at_edge, shift = np.array([-3.0, 0.0, 0.5, 4.0]), np.array([-1, 0, 0, 1]), np.zeros(4)
    assert not shifts_of(middle, at(middle), at_edge, 4, -3.0, 4.0, 0.1, 0.5, -0.2, 0.1, shift)
    np.testing.assert_array_equal(shift, [-0.2, 0.5, 0.5, 0.1])


def test_a_valley_by_itself_is_not_what_an_edge_cuts_off():
    """Stretches that weigh next to nothing change nothing: as the edge lifts off, all passes into one footprint."""
    whole, apart = np.linspace(1.5, 2.1, 7), np.linspace(1.4, 1.9, 5)
    middle = np.concatenate([whole, apart, [2.05]])
    at_edge = np.array([0] * 7 + [VALLEY] * 5 + [1], dtype=np.int64)
    alone, together = np.zeros(7), np.zeros(13)
    ends = (-3.0, 2.0, 0.05, 0.5, 0.0, 0.1)
    shifts_of(whole, at(whole), at_edge[:7], 7, *ends, alone)
    shifts_of(middle, at(middle), at_edge, 13, *ends, together)
    np.testing.assert_array_equal(together[:7], alone)
    np.testing.assert_array_equal(together[7:], [0.5] * 5 + [0.1])


@pytest.fixture(scope="module")
def fine_teeth(shipped):
    """Nodes a fifth of a roll step apart."""
    changes = RIGID | {"profile_points": 801, "roll_positions": 24}
    teeth = plan(shipped.replace({f"numerics.{name}": value for name, value in changes.items()})).loaded_teeth()
    return teeth, teeth.load(np.zeros(teeth.grid.profile.shape))


@pytest.mark.slow
@pytest.mark.parametrize("length", [0.4, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.5, 2.0, 4.0])
@pytest.mark.parametrize("phase", [0.0, 0.25])
def test_no_ripple_is_worn_deeper(fine_teeth, length, phase):
    # laid down evenly along a roll step, what is worn made those of half a step to a step deeper
    teeth, state = fine_teeth
    motion = worn_sweep(teeth, state)
    line_load = teeth.on_fine_rolls(teeth.problem.line_load(state.loads))
    nodes = teeth.grid.profile[SLICE]
    step = np.median(np.abs(np.diff(teeth.fine.profile[:, SLICE])))
    assert np.diff(nodes).max() < 0.25 * step

    def mesh(ripple):
        depth = np.full(teeth.grid.profile.shape, 1e-3)
        depth[SLICE] += 1e-5 * ripple
        removed, slices = teeth.removed(depth), np.array([SLICE])
        what = (motion, line_load, teeth.half_width, teeth.problem.modulus, slices)
        return wear_of_mesh(teeth.fine, teeth.grid, removed, *what)[SLICE]

    wave = np.sin(2.0 * np.pi * (nodes / (length * step) + phase))
    even = mesh(1e-6 * wave)
    inner = (nodes > nodes[0] + 0.6 * np.ptp(nodes)) & (nodes < nodes[0] + 0.85 * np.ptp(nodes))
    answer = np.sum(((mesh(wave) - even) * wave)[inner]) / np.sum(wave[inner] ** 2)
    assert answer < 0.0
    # long ones wear away as Winkler's footprint has it: the wear over the depth that the contact reaches down
    if length >= 4.0:
        depth = 0.5 * np.median(state.touched.curvature[:, SLICE]) * teeth.half_width**2
        assert answer == pytest.approx(-1e-5 * even[inner].mean() / depth, rel=0.5)


@pytest.fixture(scope="module")
def fine_pinion(shipped):
    """Both flanks wear; the pinion's nodes are a roll step apart."""
    changes = RIGID | {"profile_points": 201, "roll_positions": 96}
    numerics = {f"numerics.{name}": value for name, value in changes.items()}
    teeth = plan(shipped.replace(numerics | {"wear.worn_bodies": ["pinion", "gear"]})).loaded_teeth()
    return teeth, teeth.load(np.zeros(teeth.grid.profile.shape), None, np.zeros(teeth.driving.grid.profile.shape))


@pytest.mark.slow
@pytest.mark.parametrize("phase", [0.0, 0.25])
def test_ripples_of_the_driving_flank_are_met_however_short(fine_pinion, phase):
    """Near its root the driven flank's nodes pass it nearly twice as far apart as its own are.

    Read at those alone, ripples of two to three nodes were worn away at a fifth of the speed, and stayed.
    """
    teeth, state = fine_pinion
    motion = worn_sweep(teeth, state)
    line_load = teeth.on_fine_rolls(teeth.problem.line_load(state.loads))
    nodes = teeth.driving.grid.profile[0]
    near_root = (nodes > -4.5) & (nodes < -2.0)
    place, slope = teeth.fine.driving_profile[:, SLICE], np.abs(teeth.fine.driving_slope[:, SLICE])
    assert np.median(slope[(place > -4.5) & (place < -2.0)]) > 1.5

    def answer(length):
        wave = np.sin(2.0 * np.pi * (np.arange(nodes.size) / length + phase))
        depth = np.full(teeth.driving.grid.profile.shape, 1e-3)
        what = (motion, line_load, teeth.half_width, teeth.problem.modulus, np.arange(teeth.grid.face.size))
        meshes = []
        for ripple in (1e-8 * wave, 1e-3 * wave):
            removed = teeth.removed(state.wear, depth + ripple)
            meshes.append(wear_of_both_flanks(teeth.fine, teeth.grid, teeth.driving, removed, *what)[0][SLICE])
        return np.sum(((meshes[1] - meshes[0]) * wave)[near_root])

    long = answer(10.0)
    assert long < 0.0
    for length, least in ((2.2, 0.07), (2.5, 0.12), (3.2, 0.3)):
        assert answer(length) < least * long


@pytest.mark.slow
def test_nothing_piles_up_at_the_tip(shipped):
    """The last nodes before the gear's tip wear as evenly as those before them, whatever the roll step."""
    numerics = {"face_slices": 11, "profile_points": 401, "roll_positions": 24, "harmonics": 9, "wear_steps": 4}
    worn = simulate(shipped.replace({f"numerics.{name}": value for name, value in numerics.items()}))
    depth = worn["flank/wear_depth"].isel(wear_step=-1).sel(body="gear").values
    tip = depth[-8:, depth[-1] > 0.2 * depth.max()]
    assert tip.shape[1] >= 3
    bend = np.abs(np.diff(tip, 2, axis=0)) / tip.max(axis=0)
    assert bend.max() < 0.02


@pytest.mark.slow
def test_long_steps_of_light_loads_leave_no_ripple(shipped):
    """A contact that reaches down less than a step wears must follow the wear within it."""
    numerics = {"face_slices": 11, "profile_points": 201, "roll_positions": 24, "harmonics": 9}
    light = shipped.replace(
        {f"numerics.{name}": value for name, value in numerics.items()}
        | {"operation.pinion_torque_Nm": 100.0, "wear.until.control_depths_um": None, "wear.until.meshes": 2e11}
    )
    few, many = (simulate(light.replace({"numerics.wear_steps": steps}))["history"].to_dataset() for steps in (4, 16))
    assert float(few.wear_depth_max_root[-1]) == pytest.approx(float(many.wear_depth_max_root[-1]), rel=0.03)
    for zone in ("root", "addendum", "pitch"):
        pressures = [float(one[f"contact_pressure_{zone}"][-1]) for one in (few, many)]
        # ripples made it eleven times as high; so few steps err by an eighth at the root
        assert pressures[0] == pytest.approx(pressures[1], rel=0.25), zone


# in parts, the wall where the gear's tip begins is steeper, and its foot bends as far as node 32
@pytest.mark.slow
@pytest.mark.parametrize(
    ("until", "wall"),
    [
        ({"wear.until.meshes": 1.27e9, "numerics.wear_steps": 2, "wear.control_point": None}, 20),
        ({"wear.until.control_depths_um": [5.0, 10.0]}, 32),
    ],
    ids=["two deep steps", "in parts"],
)
def test_both_flanks_wear_evenly_on_fine_grids(shipped, until, wall):
    """The first of two deep steps used to leave ripples in the pinion that the second one stumbled over."""
    changes = {
        "numerics.roll_positions": 16,
        "numerics.face_slices": 11,
        "numerics.harmonics": 9,
        "numerics.profile_points": 401,
        "wear.worn_bodies": ["pinion", "gear"],
        "wear.coefficient_mm2_per_N": {"pinion": 1e-13, "gear": 1e-13},
    }
    worn = simulate(shipped.replace(changes | until))
    depth = worn["flank/wear_depth"].isel(wear_step=-1).sel(body="pinion").transpose("face", "profile").values
    # off that wall, and off the pinion's tip
    bend = np.abs(np.diff(depth[:, wall:-4], 4, axis=1))
    assert bend.max() < 0.03 * depth.max()
