"""Hard cases: each is solved, and then meets its equations and answers to small changes with small ones, or refused.

Refused: a named error that says what and what to try. `--hypothesis-profile=nightly` runs ten times the examples.
"""

from __future__ import annotations

import tempfile
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st

import semiwear as sw
from semiwear.closed_forms.stripe import stripe_table
from semiwear.contact.line_contact import LINE
from semiwear.contact.line_solver import LineStatus, NearField, Slices, solve_line_loads
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.problem import Candidates, picked, usual_approach
from semiwear.contact.rounded_contact import Rounding
from semiwear.contact.stripe import add_pairs, near_pairs, near_stripe
from semiwear.meshing.deviation_grid import write_deviation_grid
from semiwear.plan import plan
from tests.scenes import NOMINAL_TORQUE, scene_of
from tests.strategies.finite import BALANCE, equations_hold
from tests.strategies.hard_cases import (
    HardCase,
    LineGap,
    gear_pairs,
    hard_cases,
    hard_placements,
    line_gaps,
    measured_flanks,
    mirrored,
    torque_factors,
    wear_maps,
    wear_runs,
    within,
)

NIGHTLY = settings.default.max_examples >= 100
LONGEST = 60.0  # s of processor time that an example may take
WIDTHS = 1e-4  # of the approach: half-widths are iterated to 1e-5 of the greatest
SOLVED = 0.75  # of the hard cases within the limits of teeth, at least
SMALL_CHANGE = 1e-6
SMALL_ANSWER = 1e-3  # of the greatest value: loads go with gaps over the approach, some micrometres


def examples(count: int) -> Any:
    """So many in the usual profile, all together 200, and ten times as many at night."""
    return settings(
        max_examples=10 * count if NIGHTLY else count,
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much],
        phases=[Phase.explicit, Phase.reuse, Phase.generate],
    )


def says_what_to_try(error: sw.SemiwearError) -> None:
    """A remedy follows what is wrong."""
    if isinstance(error, sw.SceneError):
        assert error.problems
        assert all(problem.field and problem.allowed for problem in error.problems)
    else:
        assert isinstance(error, sw.ConvergenceError)
        assert len(str(error)) > 40
        remedies = ("numerics.", "check ", "choose ", "ask for ", "smaller ")
        assert any(remedy in str(error) for remedy in remedies), str(error)


def solved(case: HardCase) -> xr.DataTree:
    """The loaded contact of a hard case; an example that is refused counts, if the refusal says why."""
    try:
        with within(LONGEST):
            return sw.loaded_contact(case.scene(), placement=case.placement, wear_depth=case.wear)
    except (sw.SceneError, sw.ConvergenceError) as error:
        says_what_to_try(error)
        return xr.DataTree()


@pytest.mark.slow
def test_a_hard_contact_meets_its_equations_or_is_refused() -> None:
    """Most are solved: a solver that refused whatever is hard would do without."""
    solved_of: list[bool] = []
    refused: list[HardCase] = []

    @given(hard_cases())
    @examples(70)
    def hold(case: HardCase) -> None:
        tree = solved(case)
        try:
            case.scene()
        except sw.SceneError:  # beyond the limits of its teeth
            refused.append(case)
            return
        solved_of.append(bool(tree.children))
        if tree.children:
            equations_hold(tree)

    hold()
    assert sum(solved_of) >= SOLVED * len(solved_of)
    assert len(refused) <= len(solved_of)


def displacement_anew(
    teeth: LoadedTeeth, force: np.ndarray, state: LoadedState, position: int
) -> tuple[np.ndarray, Candidates]:
    """Slack of all candidates of a mesh position [mm], from the forces alone."""
    problem, loads, worn = teeth.problem, state.loads, state.coarse
    assert teeth.fidelity is LINE
    turned = float(loads.rotation[position] * teeth.lines.lever_arm.max())
    system = problem.candidates(position, turned)
    limit = system.farthest_move
    moved = np.clip(worn.profile.ravel()[system.flat] - system.profile, -limit, limit)
    each = np.arange(system.flat.size)
    matrix = picked(system.static, system.slope, each, moved)
    # what is told without a matrix is the same, of all and of some
    for some in (each, each[1::2]):
        told = system.deflection(some, loads.force, worn)
        np.testing.assert_allclose(told, (matrix @ force)[some], rtol=1e-9)
    width = np.where(force > 0.0, loads.half_width.ravel()[system.flat], 0.1 * problem.usual_half_width)
    factor = 1.0 / (pi * problem.modulus)
    pairs = near_pairs(system.starts, system.arc, system.length, teeth.problem.near_field)
    add_pairs(matrix, pairs, near_stripe(pairs, width, factor, stripe_table()))
    gap = worn.gap.ravel()[system.flat] + worn.softer.ravel()[system.flat] * force
    return gap + matrix @ force - loads.rotation[position] * system.lever, system


@pytest.mark.slow
@given(hard_cases())
@examples(25)
def test_line_loads_press_where_the_gap_is_closed(case: HardCase) -> None:
    """The displacement anew, from the forces, without the active set."""
    try:
        with within(LONGEST):
            scene = scene_of(case.changes | {"numerics.fidelity": "line"})
            teeth = plan(scene).loaded_teeth(case.placement)
            wear = np.zeros(teeth.grid.profile.shape) if case.wear is None else 1e-3 * case.wear.T
            state = teeth.load(np.ascontiguousarray(wear))
    except (sw.SceneError, sw.ConvergenceError) as error:
        says_what_to_try(error)
        return
    loads, worn = state.loads, state.coarse
    for position in range(teeth.rolls.phase.size):
        rolls = teeth.problem.rolls_of(position)
        system = teeth.problem.candidates(position, float(loads.rotation[position] * teeth.lines.lever_arm.max()))
        force = loads.force.ravel()[system.flat]
        slack, system = displacement_anew(teeth, force, state, position)
        approach = float((loads.rotation[position] * system.lever - worn.gap.ravel()[system.flat]).max())
        assert approach > 0.0
        assert (force >= 0.0).all()
        assert np.abs(slack[force > 0.0]).max() < WIDTHS * approach
        assert slack.min() > -WIDTHS * approach
        # what is no candidate is farther than the approach
        others = np.ones(worn.gap.size, dtype=bool)
        others[system.flat] = False
        shift = (loads.rotation[position] * teeth.lines.lever_arm)[rolls]
        apart = (worn.least[rolls] - shift)[others.reshape(worn.gap.shape)[rolls]]
        assert apart.size == 0 or apart.min() > -WIDTHS * approach
        moment = float((loads.force * teeth.lines.lever_arm)[rolls].sum())
        np.testing.assert_allclose(moment, teeth.problem.torque[position], rtol=BALANCE)


def answers(tree: xr.DataTree) -> dict[str, np.ndarray]:
    """Results that go with the input; the greater of the two pressures, since which it is has a threshold."""
    engagement = tree["engagement"]
    pressure = np.maximum(engagement.contact_pressure_max.values, engagement.contact_pressure_max_edge.values)
    loaded, unloaded = (tree["mesh_cycle"][f"transmission_error_{name}"].values for name in ("loaded", "unloaded"))
    return {
        "line_load": engagement.line_load.values,
        "load_share": engagement.load_share.values,
        "pressure": pressure,
        "lag": unloaded - loaded,
    }


@pytest.mark.slow
@given(gear_pairs(), torque_factors(), st.sampled_from(["line", "patch"]), st.data())
@examples(20)
def test_a_small_change_changes_little(
    pair: dict[str, Any], factor: float, fidelity: str, data: st.DataObject
) -> None:
    changes = pair | {"numerics.fidelity": fidelity, "numerics.face_slices": 11, "numerics.profile_points": 21}
    torque = changes.get("operation.pinion_torque_Nm", NOMINAL_TORQUE) * factor
    changes["operation.pinion_torque_Nm"] = torque
    placement = data.draw(st.one_of(st.none(), hard_placements(changes.get("gear_pair.module_mm", 6.35))))
    wear = data.draw(st.one_of(st.none(), wear_maps((21, 11))))
    more = dict(changes)
    what = data.draw(st.sampled_from(["torque", "stiffness", "wear"]))
    more_wear = wear
    if what == "torque":
        more["operation.pinion_torque_Nm"] = torque * (1.0 + SMALL_CHANGE)
    elif what == "stiffness":
        more["material.gear.youngs_modulus_MPa"] = 207000.0 * (1.0 + SMALL_CHANGE)
    elif wear is not None:
        more_wear = wear * (1.0 + SMALL_CHANGE)
    one = solved(HardCase(changes, placement, wear))
    two = solved(HardCase(more, placement, more_wear))
    assume(bool(one.children))
    assert two.children
    if what == "wear" and wear is not None:
        # what counts is how much of the approach the gap has changed by
        lag = answers(one)["lag"]
        scene = scene_of(changes)
        base = scene.gear_pair.pinion_pitch_radius_mm * np.cos(np.radians(scene.gear_pair.pressure_angle_deg))
        ratio = scene.gear_pair.pinion_teeth / scene.gear_pair.gear_teeth
        approach = np.abs(lag).min() / (ratio / base * np.degrees(1.0) * 3600.0)
        assume(SMALL_CHANGE * 1e-3 * float(np.ptp(wear)) < SMALL_CHANGE * 100.0 * approach)
    others = answers(two)
    for name, values in answers(one).items():
        greatest = np.abs(values).max()
        assert np.abs(others[name] - values).max() <= SMALL_ANSWER * greatest, name


@given(hard_placements(), torque_factors(), st.sampled_from(["line", "patch"]))
@examples(10)
def test_coast_flanks_mirror_drive_flanks(placement: sw.Placement, factor: float, fidelity: str) -> None:
    changes = {
        "numerics.fidelity": fidelity,
        "numerics.face_slices": 11,
        "operation.pinion_torque_Nm": NOMINAL_TORQUE * factor,
    }
    one = solved(HardCase(changes, placement, None))
    two = solved(HardCase(changes | {"operation.loaded_flank": "coast"}, mirrored(placement), None))
    assert set(one.children) == set(two.children)
    for group in one.children:
        assert two[group].dataset.equals(one[group].dataset), group


@given(measured_flanks(), torque_factors(), st.sampled_from([".csv", ".nc"]), st.sampled_from(["line", "patch"]))
@examples(10)
def test_noisy_measured_flanks_meet_the_equations(
    grid: tuple[np.ndarray, np.ndarray, np.ndarray], factor: float, suffix: str, fidelity: str
) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"measured{suffix}"
        write_deviation_grid(path, *grid)
        changes = {
            "effects.modification.gear.file": str(path),
            "numerics.fidelity": fidelity,
            "numerics.face_slices": 11,
            "operation.pinion_torque_Nm": NOMINAL_TORQUE * factor,
        }
        tree = solved(HardCase(changes, None, None))
    if tree.children:
        equations_hold(tree)


@pytest.mark.slow
@given(wear_runs())
@examples(15)
def test_wear_steps_of_any_size_end_or_say_why(changes: dict[str, Any]) -> None:
    scene = scene_of(changes, wears=True)
    try:
        with within(LONGEST):
            tree = sw.simulate(scene)
    except sw.ConvergenceError as error:
        says_what_to_try(error)
        tree = error.result
        if tree is None:
            return
    equations_hold(tree)
    depth = tree["flank"].wear_depth.values
    assert (depth[0] == 0.0).all()
    assert (np.diff(depth, axis=0) >= 0.0).all()


@given(line_gaps(), st.sampled_from([0.0, 0.0, 1e-3, 0.02, 0.3]))
@examples(125)
def test_any_gaps_are_closed_by_complementary_loads(case: LineGap, rounding: float) -> None:
    size = case.gap.size
    usual = float(np.sqrt(4.0 * case.torque / case.length.sum() / (pi * case.modulus * case.curvature[0])))
    # slices as they are in gears: no half-width is much longer than the line
    assume(usual < 3.0 * float(case.length.sum()))
    width, active = np.full(size, usual), case.gap <= np.quantile(case.gap, 0.25)
    static, near = np.diag(case.wear_compliance), 12.0 * usual
    touching = case.gap.min()
    gap = case.gap - touching
    line_load = case.torque / float(case.length.sum())
    depth, full = rounding * usual_approach(line_load, case.modulus), rounding * line_load * case.length
    rounded = Rounding(depth, rounding * line_load) if rounding else None
    pairs = near_pairs(case.starts, case.arc, case.length, near)
    with within(LONGEST):
        floor = np.full(size, 0.1 * usual)
        status, rotation, force, _, _, change = solve_line_loads(
            Slices(static, gap, np.ones(size), case.arc, case.length, floor, case.curvature, case.starts, pairs),
            NearField(case.modulus, 2.0 * usual, stripe_table()), case.torque, rounded, 1e-5, 60, active, width,
        )  # fmt: skip
    assert np.isfinite([rotation, change]).all()
    if status != LineStatus.CONVERGED:
        # said, not hidden
        assert status in set(LineStatus)
        return
    assert np.isfinite(force).all()
    assert (force >= 0.0).all()
    matrix = static.copy()
    add_pairs(matrix, pairs, near_stripe(pairs, width, 1.0 / (pi * case.modulus), stripe_table()))
    anew = gap + matrix @ force - rotation
    # the loads of slices of other widths were found with widths 1e-5 of the greatest off
    limit = WIDTHS * (rotation + float(np.abs(matrix @ force).max()))
    bears = force > 0.0
    open_by = depth * (1.0 - np.sqrt(np.minimum(force[bears] / full[bears], 1.0))) ** 2 if rounding else 0.0
    assert np.abs(anew[bears] - open_by).max() < limit
    assert anew[~bears].min(initial=np.inf) > depth - limit
    assert float(force.sum()) == pytest.approx(case.torque, rel=BALANCE)
