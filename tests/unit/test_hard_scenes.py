"""Hard scenes by name: limits of geometry, load, placement and wear, and every failure found among them."""

from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from semiwear.contact.edge_share import closed_alone
from semiwear.contact.footprint import OF_PRESSED_EDGES
from semiwear.contact.gap import fresh_gap, fresh_slope
from semiwear.contact.line_contact import LINE
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.contact.position_solver import LEAST_WIDTH
from semiwear.contact.slice_pressure import solve_slices
from semiwear.meshing.contact_lines import trace_contact_lines
from semiwear.plan import plan
from semiwear.results.missing import away_from_edges
from tests.scenes import CONFORMAL, MEDIUM, NOMINAL_TORQUE, SHARP, SHIPPED, TINY, UNTIL_MESHES, problems_of, scene_of
from tests.strategies.finite import equations_hold

FIDELITIES = ["line", "patch"]


def loaded(
    *changes: dict[str, Any],
    fidelity: str = "line",
    placement: sw.Placement | None = None,
    wear: np.ndarray | None = None,
) -> xr.DataTree:
    """Loaded contact of the small scene, its equations tested."""
    tree = sw.loaded_contact(
        scene_of(*changes, {"numerics.fidelity": fidelity}), placement=placement, wear_depth=wear
    )
    equations_hold(tree)
    return tree


def worn(changes: dict[str, Any], fidelity: str = "line") -> xr.DataTree:
    """A run of the small scene."""
    return sw.simulate(scene_of(changes, {"numerics.fidelity": fidelity}, wears=True))


def torque(factor: float) -> dict[str, Any]:
    return {"operation.pinion_torque_Nm": factor * NOMINAL_TORQUE}


def pressure(tree: xr.DataTree) -> float:
    """Greatest away from borders, where edges do not decide."""
    return float(away_from_edges(tree["engagement"].to_dataset()).max())


# ---- limits of geometry


@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize(
    "changes",
    [
        {"gear_pair.gear_inner_radius_mm": 465.174},
        {"gear_pair.gear_outer_radius_mm": 569.32, "gear_pair.gear_tip_edge_radius_mm": 0.0},
        {"gear_pair.pinion_addendum_mm": 7.356},
        CONFORMAL,
        SHARP,
    ],
    ids=["undercut", "pointed", "pinion tip on the gear fillet", "near-conformal", "sharp edges"],
)
def test_a_tooth_at_its_limit_carries_its_load(fidelity, changes):
    tree = loaded(changes, fidelity=fidelity)
    # the limit lies at the ends of the tooth, the load in its middle
    assert 600.0 < pressure(tree) < 1000.0


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"gear_pair.gear_inner_radius_mm": 465.17}, "gear_pair.gear_inner_radius_mm"),
        ({"gear_pair.gear_outer_radius_mm": 569.34}, "gear_pair.gear_outer_radius_mm"),
        ({"gear_pair.gear_outer_radius_mm": 569.0}, "gear_pair.gear_tip_edge_radius_mm"),
        ({"gear_pair.pinion_addendum_mm": 7.357}, "gear_pair.shaper_tip_radius_mm"),
        ({"gear_pair.shaper_teeth": 26}, "gear_pair.shaper_tip_radius_mm"),
    ],
)
def test_a_tooth_beyond_its_limit_is_refused_before_computing(changes, field):
    assert field in problems_of(scene_of, changes)


@pytest.mark.slow
@pytest.mark.parametrize("slices", [7, 21, 300])
def test_a_handful_of_slices_and_hundreds_agree(slices):
    """300 slices are shorter than the contact is wide."""
    even = {"numerics.face_slices": slices}
    share = loaded(even, {"numerics.profile_points": 21})["engagement"].load_share.values
    fine = loaded({"numerics.face_slices": 101})["engagement"].load_share.values
    assert np.abs(share - fine).max() < (0.02 if slices > 7 else 0.06)


# ---- load and material


@cache
def curvature_across():
    """Roll positions, and the greatest principal curvature of the gap there."""
    unloaded = sw.tooth_contact_analysis(scene_of())
    return unloaded.roll_position, np.abs(unloaded.principal_relative_curvature.values).max(axis=1)


@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize("factor", [1e-6, 1.0, 10.0])
def test_pressure_of_light_and_heavy_loads_follows_hertz(fidelity, factor):
    """Where single pairs bear, p^2 = E* kappa q/pi (Johnson 1985, eq. 4.45), from a millionth of the torque on."""
    tree = loaded(torque(factor), {"numerics.face_slices": 61}, fidelity=fidelity)
    engagement = tree["engagement"].to_dataset().isel(wear_step=0)
    curvature = np.interp(engagement.roll_position, *curvature_across())
    found = away_from_edges(engagement) ** 2 / engagement.line_load.max("face")
    bears = (np.abs(engagement.roll_position) < 0.3) & (engagement.load_share > 0.55)
    assert bears.sum() >= 2
    modulus = 206000.0 / (2.0 * (1.0 - 0.3**2))
    ratio = found.values[bears] / (modulus * curvature[bears] / np.pi)
    # ten times the torque takes in flank that is curved otherwise; cells of `patch` are an eighth of the half-width
    np.testing.assert_allclose(ratio, 1.0, atol=0.1 if factor > 1.0 else 0.02 if fidelity == "line" else 0.05)


@pytest.mark.parametrize("factor", [30.0, 60.0, 100.0])
def test_heavy_line_loads_do_not_gather_in_one_slice(factor):
    """Found: far from the line its cubic falls without end, the gap was -3 mm there, and one slice took all."""
    line, patch = (loaded(torque(factor), fidelity=fidelity)["engagement"] for fidelity in FIDELITIES)
    greatest = float(patch.line_load.max())
    assert float(line.line_load.max()) == pytest.approx(greatest, rel=0.6)
    np.testing.assert_allclose(line.load_share, patch.load_share, atol=0.06)


@pytest.mark.parametrize("fourth", [-0.2, 0.0, 1e-9, 0.2])
@pytest.mark.parametrize("third", [-0.5, 0.0, 1e-9, 0.5])
@pytest.mark.parametrize("second", [-0.1, 0.0, 0.02])
def test_the_separation_is_convex_and_smooth_however_far(second, third, fourth):
    away = np.linspace(-20.0, 20.0, 2001)
    terms = np.array([0.3, 0.01, second, third, fourth])
    gap = np.array([fresh_gap(x, terms) for x in away])
    assert np.diff(gap, 2).min() > -1e-12 * np.abs(gap).max()
    slope = np.array([fresh_slope(x, terms) for x in away])
    np.testing.assert_allclose(np.gradient(gap, away)[1:-1], slope[1:-1], atol=0.01 * max(np.abs(slope).max(), 1.0))


@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize("modulus", [500.0, 1e4, 1.5e6])
def test_extreme_material_contrast_is_solved(fidelity, modulus):
    loaded({"material.gear.youngs_modulus_MPa": modulus}, fidelity=fidelity)


@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_teeth_too_soft_for_their_load_are_refused(fidelity):
    """Found: an approach of metres was computed, on nine pairs of teeth."""
    with pytest.raises(sw.SceneError, match="stiffer"):
        loaded({"material.gear.youngs_modulus_MPa": 500.0}, torque(100.0), fidelity=fidelity)


# ---- placement


@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize(("slope", "inwards"), [(20.0, True), (-20.0, False)])
def test_misalignment_drives_contact_to_heel_or_toe(fidelity, slope, inwards):
    tree = loaded(fidelity=fidelity, placement=sw.Placement(pinion_slope_mrad=slope))
    load = tree["engagement"].line_load.sum(("wear_step", "roll_position")).values
    place = float((load * np.arange(load.size)).sum() / load.sum()) / (load.size - 1)
    assert place < 0.25 if inwards else place > 0.75


@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize(
    "placement",
    [sw.Placement(axial_pinion_mm=100.0), sw.Placement(axial_gear_mm=20.0), sw.Placement(axial_gear_mm=200.0)],
    ids=["beside the gear", "above it", "far above it"],
)
def test_a_pinion_out_of_reach_is_refused(fidelity, placement):
    """Found: beyond its tip the pinion's involute went on, and patches bore 33 GPa across an air gap of 200 mm."""
    with pytest.raises(sw.SceneError, match="placement"):
        loaded(fidelity=fidelity, placement=placement)
    with pytest.raises(sw.SceneError, match="placement"):
        sw.tooth_contact_analysis(SHIPPED, placement)


@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_a_gear_inside_the_base_circle_is_refused(fidelity):
    """Found: a division by zero where the involute ends."""
    with pytest.raises(sw.SceneError, match="base circle"):
        loaded(fidelity=fidelity, placement=sw.Placement(axial_gear_mm=-50.0))


def test_slices_beyond_the_pinion_tip_never_touch():
    pair = plan(scene_of()).flank_pair(sw.Placement(axial_gear_mm=30.0))
    lines = trace_contact_lines(pair, np.array([-0.5, 0.0, 0.5]), np.array([490.0, 510.0, 550.0]))
    assert np.isinf(lines.separation[0]).all()


@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_flanks_that_transmit_unevenly_are_followed_everywhere(fidelity):
    """Found: slices were sought near the least separation of the whole cycle; elsewhere no flank could touch."""
    tree = loaded(torque(1e-3), fidelity=fidelity, placement=sw.Placement(axial_gear_mm=11.0))
    # the tips touch, one pair after the other
    assert np.ptp(tree["mesh_cycle"].transmission_error_unloaded.values) > 0.15 * 448.0


@pytest.mark.parametrize("shift", [-4.0, 4.0])
def test_a_helical_pinion_shifted_along_its_axis_is_followed_where_it_turns_to(shift):
    """Found: its flanks open or close by a millimetre before it turns; open ones counted as off the path."""
    helical = sw.load_scene("spur_fzg_c").replace(
        TINY | {"numerics.wear_steps": 1, "wear.until.meshes": 1e5, "gear_pair.helix_angle_deg": 15.0}
        | {"gear_pair.centre_distance_mm": None, "effects.misalignment": {"axial_pinion_mm": shift}}
        | {"numerics.tooth_compliance": "rigid"}
    )  # fmt: skip
    assert plan(helical).loaded_teeth().on_path.any(axis=0).sum() > 0.5 * helical.numerics.face_slices
    worn = sw.simulate(helical)["history"].isel(wear_step=-1)
    assert np.all(worn.wear_depth_max > 0.0) and np.isfinite(worn.wear_depth_max_pinion_pitch)


@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_light_loads_on_a_displaced_pinion_balance_to_rounding(fidelity):
    """Found: a gap of millimetres took digits from an approach of a nanometre; the torque was off by 2e-9."""
    placement = sw.Placement(-3.6, 0.98, 0.086, 3.3, -3.2)
    tree = loaded(torque(1e-6), fidelity=fidelity, placement=placement)
    assert tree["diagnostics"].load_balance_residual.item() < 1e-13


def test_a_contact_narrower_than_a_cell_is_found():
    """Found: at a steep edge no cell's middle was nearer than the approach, and the residual was not a number."""
    placement = sw.Placement(1.8835782, 0.9288454, 0.7145596, 2.3161279, 1.5713963)
    grids = {"numerics.face_slices": 7, "numerics.profile_points": 21}
    loaded(CONFORMAL, grids, torque(3e-5), fidelity="patch", placement=placement)


@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_contact_on_the_rounding_of_an_edge_is_found(fidelity):
    """Found: the flanks are nearer on the rounding than at the border where it begins, by more than the approach."""
    placement = sw.Placement(-4.384986, 3.516189, 2.440418, -23.239043, 16.448611)
    changes = {
        "gear_pair.gear_outer_radius_mm": 565.0,
        "gear_pair.gear_tip_edge_radius_mm": 0.0,
        "numerics.face_slices": 7,
        "numerics.profile_points": 21,
    }
    loaded(changes, torque(2e-4), fidelity=fidelity, placement=placement, wear=np.full((21, 7), 0.0078))


@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_load_share_is_continuous_where_the_pairs_in_contact_change(fidelity):
    scene = scene_of({"numerics.fidelity": fidelity})
    coarse = sw.loaded_contact(scene, roll_positions=np.linspace(0.0, 1.0, 8, endpoint=False))
    assert len(set(coarse["mesh_cycle"].pairs_in_contact.values[0].tolist())) > 1
    fine = sw.loaded_contact(scene, roll_positions=np.linspace(0.0, 1.0, 64, endpoint=False))
    share = fine["engagement"].load_share.values[0]
    # a share goes from nothing to all and back within two mesh cycles: a jump would stand out
    assert np.abs(np.diff(share)).max() < 6.0 / 64.0


# ---- wear


@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize("depth", [200.0, 2000.0])
def test_wear_deeper_than_usual_moves_contact_to_where_flanks_were_apart(fidelity, depth):
    """Found: slices farther apart than 0.15 mm were taken as unworn however deep the wear."""
    shape = (41, 21)
    inner = (np.arange(21) < 16) * np.ones(shape)
    one, two = (loaded(fidelity=fidelity, wear=more * depth * inner)["engagement"] for more in (1.0, 2.0))
    load = one.line_load.values
    assert load[..., :16].max() == 0.0 if depth > 1000.0 else load.max() > 0.0
    if depth > 1000.0:
        np.testing.assert_allclose(two.line_load, load, atol=1e-6 * load.max())
    ridge = depth * np.abs(np.linspace(-1.0, 1.0, 41))[:, None] * np.ones(shape)
    loaded(fidelity=fidelity, wear=ridge)
    even = loaded(fidelity=fidelity, wear=np.full(shape, depth))["engagement"]
    fresh = loaded(fidelity=fidelity)["engagement"]
    np.testing.assert_allclose(even.load_share, fresh.load_share, atol=1e-3)


def grooved_heel() -> tuple[LoadedTeeth, np.ndarray]:
    """Coast flanks that meet at the heel, with deep grooves of one row each."""
    placement = sw.Placement(
        offset_mm=0.38,
        axial_pinion_mm=38.52101093326968,
        axial_gear_mm=-0.7915789807843923,
        shaft_angle_error_mrad=3.2698161581115652,
        pinion_slope_mrad=0.6605964093548913,
    )
    scene = scene_of(
        {"numerics.face_slices": 11, "operation.loaded_flank": "coast", "operation.pinion_torque_Nm": 1600.0}
    )
    teeth = plan(scene).loaded_teeth(placement)
    wear = np.zeros(teeth.grid.profile.shape)
    wear[:, [4, 10, 15, 38]] = 1.83463248237
    return teeth, wear


def test_loads_are_those_of_the_footprints_that_a_state_keeps():
    """Found: a crest beside a groove was pressed in one pass and not in the next, which kept the former's loads.

    It bore the whole load, on one slice, where the flanks were 0.03 mm apart.
    """
    teeth, wear = grooved_heel()
    state = teeth.load(wear)
    again = teeth.fidelity.solve(teeth.problem, state.coarse, state.loads)
    scale = state.loads.force.max()
    np.testing.assert_allclose(again.force, state.loads.force, atol=1e-3 * scale)
    np.testing.assert_allclose(again.rotation, state.loads.rotation, rtol=1e-4)
    # beside grooves the flank is as high as it was: more than one slice bears
    per_cycle = teeth.rolls.phase.size
    bearing = (state.loads.force > 0.0).sum(axis=1).reshape(-1, per_cycle).sum(axis=0)
    assert bearing.min() >= 3


def test_edges_that_were_pressed_stay_so_while_a_state_is_found():
    teeth, wear = grooved_heel()
    worn = teeth.touch_solved(wear)
    loads = teeth.fidelity.solve(teeth.problem, worn)
    pressed = teeth.fidelity.with_edges(teeth.problem, worn, loads, worn)
    assert (pressed.gap != worn.gap).any()
    apart = replace(loads, force=np.zeros_like(loads.force), rotation=loads.rotation - 1.0)
    assert teeth.fidelity.with_edges(teeth.problem, worn, apart, worn) is worn
    held = teeth.fidelity.with_edges(teeth.problem, worn, apart, pressed)
    np.testing.assert_array_equal(held.gap != worn.gap, pressed.gap != worn.gap)


def test_a_narrow_pressed_edge_yields_as_its_plane_contact():
    """Approach and its change by the load, though load sharing takes no line for as narrow."""
    teeth = plan(SHIPPED.replace(MEDIUM | {"numerics.harmonics": 3})).loaded_teeth()
    problem, worn = teeth.problem, teeth.touch_solved(np.zeros(teeth.grid.profile.shape))
    loads = teeth.fidelity.solve(problem, worn)
    edged = teeth.fidelity.with_edges(problem, worn, loads, worn)
    line_load = problem.line_load(loads)
    narrow = (edged.softer > 0.0) & (line_load > 0.1 * problem.usual_load)
    assert narrow.sum() > 5

    def approach(footprints, share):
        closes = closed_alone(share * line_load, problem.modulus)
        half_width = np.sqrt(2.0 * closes / footprints.curvature)[narrow]
        straight = (footprints.softer * share * loads.force)[narrow]
        return (
            footprints.gap[narrow] + closes[narrow] * (0.5 - np.log(half_width)) + straight,
            half_width,
            closes[narrow],
        )

    def exact(share):
        load = np.where(narrow, share * line_load, 0.0)
        return approach(solve_slices(teeth.lines, worn, load, problem.modulus, 0.0)[1], share)

    found, width, closes = approach(edged, 1.0)
    assert width.min() > LEAST_WIDTH * problem.usual_half_width
    np.testing.assert_allclose(found, exact(1.0)[0], atol=1e-9 * closes.max())
    # of all of them together: one by one the contact grows in steps of a cell
    change = float((approach(edged, 1.1)[0] - found).sum())
    expected = float((exact(1.1)[0] - exact(1.0)[0]).sum())
    assert change == pytest.approx(expected, rel=0.03)
    hertz = change - 0.1 * float((edged.softer * loads.force)[narrow].sum())
    assert hertz < 0.9 * expected


def test_pressed_edges_are_looked_for_where_asked():
    teeth, wear = grooved_heel()
    worn = teeth.touch_solved(wear)
    loads, per_cycle = teeth.fidelity.solve(teeth.problem, worn), teeth.rolls.phase.size
    before = teeth.fidelity.with_edges(teeth.problem, worn, loads, worn)
    more = replace(loads, force=1.5 * loads.force)
    whole = teeth.fidelity.with_edges(teeth.problem, worn, more, before)
    rolls = np.tile(np.arange(per_cycle) % 2 == 0, teeth.problem.pairs)
    some = teeth.fidelity.with_edges(teeth.problem, worn, more, before, rolls)
    assert (whole.gap != before.gap)[rolls].any() and (whole.gap != before.gap)[~rolls].any()
    for name in OF_PRESSED_EDGES:
        np.testing.assert_array_equal(getattr(some, name)[rolls], getattr(whole, name)[rolls])
        np.testing.assert_array_equal(getattr(some, name)[~rolls], getattr(before, name)[~rolls])


def test_mesh_positions_whose_edges_have_settled_are_not_solved_again():
    teeth, wear = grooved_heel()
    solved: list[list[int]] = []
    looked: list[np.ndarray] = []

    def solve(problem, worn, start=None, wear_compliance=None, positions=None):
        solved.append(positions)
        return LINE.solve(problem, worn, start, wear_compliance, positions)

    def with_edges(problem, worn, loads, before, rolls=None):
        looked.append(rolls.reshape(problem.pairs, -1))
        return LINE.with_edges(problem, worn, loads, before, rolls)

    state = replace(teeth, fidelity=replace(LINE, solve=solve, with_edges=with_edges)).load(wear)
    for positions, rolls in zip(solved[1:], looked, strict=False):
        assert (rolls == rolls[0]).all() and set(positions) <= set(np.flatnonzero(rolls[0]))
    assert looked[0].all() and not looked[-1].all()
    assert solved[0] is None and len(solved) > 2
    for before, after in pairwise([set(range(teeth.rolls.phase.size)), *map(set, solved[1:])]):
        assert after <= before
    assert len(solved[-1]) < teeth.rolls.phase.size
    # a position that is left alone has the loads of the edges that it makes
    again = teeth.fidelity.with_edges(teeth.problem, teeth.touch_solved(wear), state.loads, state.coarse)
    loads = teeth.fidelity.solve(teeth.problem, again, state.loads)
    np.testing.assert_allclose(loads.force, state.loads.force, atol=5e-3 * state.loads.force.max())


def test_load_on_slices_that_were_not_followed_is_named():
    teeth = plan(scene_of()).loaded_teeth()
    footprints = teeth.touch_solved(np.zeros(teeth.grid.profile.shape))
    assert footprints.near is not None
    per_cycle = teeth.rolls.phase.size
    force, positions = np.where(footprints.near, 1.0, 0.0), np.arange(per_cycle)
    footprints.require_followed(force, positions, per_cycle)
    roll, face = np.argwhere(~footprints.near & (np.arange(len(force)) % per_cycle == 3)[:, None])[0]
    force[roll, face] = 1e-3
    with pytest.raises(sw.ConvergenceError, match=rf"3/{per_cycle}.*shorter wear steps"):
        footprints.require_followed(force, positions, per_cycle)
    footprints.require_followed(force, positions[positions != 3], per_cycle)  # whose loads are of another state


@pytest.mark.slow
@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_depths_far_apart_end_or_say_why(fidelity):
    try:
        tree = worn({"wear.until.control_depths_um": [30.0, 60.0, 90.0, 120.0]}, fidelity)
    except sw.ConvergenceError as error:
        assert "control point" in str(error)
        tree = error.result
    depth = tree["flank"].wear_depth.values
    assert (np.diff(depth, axis=0) >= 0.0).all()
    assert float(tree["history"].wear_depth_control_point[1]) == pytest.approx(30.0, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize("bodies", [["gear"], ["pinion", "gear"]], ids=["gear", "both"])
@pytest.mark.parametrize("scheme", ["implicit", "two-stage", "explicit"])
def test_a_step_a_thousand_times_too_large_says_that_the_tooth_is_gone(fidelity, bodies, scheme):
    """Found: `line` blamed the compliance; slices that are flat at a border were given contacts of metres' width."""
    changes = {
        **TINY,
        **UNTIL_MESHES,
        "numerics.face_slices": 7,
        "numerics.profile_points": 21,
        "wear.until.meshes": 6e12,
        "wear.worn_bodies": bodies,
        "numerics.wear_steps": 2,
        "numerics.wear_scheme": scheme,
    }
    with pytest.raises(sw.ConvergenceError, match=r"the tooth is worn away long before; ask for fewer") as error:
        worn(changes, fidelity)
    assert error.value.result is not None


@pytest.mark.slow
def test_gears_lose_stability_with_explicit_steps_of_many_micrometres_only():
    def greatest(scheme: str, steps: int) -> float:
        changes = {
            **UNTIL_MESHES,
            "wear.until.meshes": 1e9,
            "numerics.wear_steps": steps,
            "numerics.wear_scheme": scheme,
            "numerics.face_slices": 11,
        }
        return float(worn(changes)["flank"].wear_depth[-1].max())

    settled = greatest("implicit", 16)
    assert greatest("implicit", 1) == pytest.approx(settled, rel=0.25)
    assert greatest("explicit", 32) == pytest.approx(settled, rel=0.05)  # about half a micrometre a step
    assert greatest("explicit", 1) > 2.0 * settled


@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_wear_vanishes_where_sliding_does(fidelity):
    tree = worn({**UNTIL_MESHES, "wear.until.meshes": 1e8, "numerics.wear_steps": 2}, fidelity)
    depth = tree["flank"].wear_depth.sel(body="gear").values[-1]
    slide = np.abs(tree["flank"].specific_sliding.sel(body="gear").values)
    worked = depth > 0.02 * depth.max()
    least = slide <= np.quantile(slide[worked], 0.05)
    assert depth[least & worked].max(initial=0.0) < 0.35 * depth.max()


@pytest.mark.slow
def test_long_steps_with_both_bodies_worn_answer_small_changes_by_small_ones():
    """Edge and valley took turns at the load from cycle to cycle: 1e-6 of a torque moved wear by a thousandth."""
    depths = [5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0]
    scene = SHIPPED.replace(MEDIUM | {"wear.worn_bodies": ["pinion", "gear"], "wear.until.control_depths_um": depths})
    one, other = (sw.simulate(scene.replace(torque(factor)))["flank"].wear_depth for factor in (1.0, 1.0 + 1e-6))
    apart = np.abs(other - one).max(["body", "profile", "face"]) / one.max(["body", "profile", "face"])
    assert 0.0 < apart[1:].max() < 5e-6
