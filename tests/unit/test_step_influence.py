"""Wear of a step read off footprints that were followed once, against footprints that are found again."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest

import semiwear as sw
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.meshing.flank_pair import DRIVEN, DRIVING
from semiwear.plan import plan
from semiwear.wear import step_influence
from semiwear.wear.footprint_rows import no_rows
from semiwear.wear.step_influence import Cycles, SpreadLoad, StepInfluence, followed
from semiwear.wear.swept_line import Sweep, wear_of_both_flanks, wear_of_mesh, worn_sweep
from semiwear.wear.worn import Worn
from tests.scenes import TINY

STEP = 2e-5  # mm^2/N: wear coefficient times meshes, some micrometres


def after(worn: Worn, mesh: Worn, share: float, step: float = STEP) -> Worn:
    """Both bodies wear alike, in proportion."""
    return worn.plus(step * share, mesh)


@dataclass
class Case:
    """Teeth that are worn already, and what they wear under."""

    teeth: LoadedTeeth
    motion: Sweep
    worn: Worn
    line_load: np.ndarray

    def followed(self, line_load: np.ndarray, cycles: float, ahead: float = 0.0, step: float = STEP) -> StepInfluence:
        """Under these loads."""
        wears = partial(after, step=step)
        return followed([SpreadLoad(self.teeth, line_load)], self.motion, self.worn, wears, Cycles(cycles, ahead))

    def found(self, line_load: np.ndarray) -> tuple[Worn, np.ndarray]:
        """On the flanks as they are, and what is taken."""
        teeth, taken, slices = self.teeth, np.zeros((2, 2)), np.arange(self.teeth.grid.face.size)
        what = (self.motion, line_load, teeth.half_width, teeth.problem.modulus, slices)
        if teeth.driving is None:
            removed = teeth.removed(self.worn.driven)
            return Worn(wear_of_mesh(teeth.fine, teeth.grid, removed, *what, taken[DRIVEN])), taken
        removed = teeth.removed(*self.worn)
        driving, driven = wear_of_both_flanks(teeth.fine, teeth.grid, teeth.driving, removed, *what, taken)
        return Worn(driven, driving), taken


@pytest.fixture(scope="module", params=["gear", "both", "helical"])
def case(request: pytest.FixtureRequest) -> Case:
    """A face gear of which one body wears or both, and a helical pair."""
    name = "spur_fzg_c" if request.param == "helical" else "face_gear_25x160"
    scene = sw.load_scene(name).replace(TINY | {"numerics.tooth_compliance": "rigid"})
    if request.param == "helical":
        scene = scene.replace({"gear_pair.helix_angle_deg": 15.0, "gear_pair.centre_distance_mm": None})
    elif request.param == "both":
        scene = scene.replace({"wear.worn_bodies": ["pinion", "gear"]})
    teeth = plan(scene).loaded_teeth()
    flanks = [teeth.grid] if teeth.driving is None else [teeth.grid, teeth.driving.grid]
    worn = Worn(
        *(3e-3 * (1.0 + np.sin(np.arange(grid.profile.size).reshape(grid.profile.shape) / 5)) for grid in flanks)
    )
    state = teeth.load(worn.driven, driving_wear=worn.driving)
    line_load = teeth.on_fine_rolls(teeth.problem.line_load(state.loads))
    return Case(teeth, worn_sweep(teeth, state), worn, line_load)


def all_slices(case: Case) -> np.ndarray:
    """Of the driven flank."""
    return np.arange(case.teeth.grid.face.size)


def close(one: Worn, other: Worn, within: float = 1e-12) -> None:
    """Both flanks agree, to a share of the greatest value."""
    for x, y in zip(one, other, strict=True):
        assert (x is None) == (y is None)
        if x is not None and y is not None:
            assert y.max() > 0.0
            np.testing.assert_allclose(x, y, rtol=0.0, atol=within * y.max())


@pytest.mark.parametrize("ahead", [0.0, 1.0])
@pytest.mark.parametrize("cycles", [1.0, 3.0, 3.4])
def test_the_loads_that_were_followed_wear_what_was_followed(case, cycles, ahead):
    influence = case.followed(case.line_load, cycles, ahead)
    course = influence.course
    assert len(course.shapes) == len(course.parts) + 1 and sum(course.parts) == pytest.approx(cycles)
    mesh, taken = influence.mesh([case.line_load], all_slices(case))
    close(after(case.worn, mesh, 1.0), influence.course.shapes[-1])
    assert (taken[:, 0] >= taken[:, 1]).all() and taken[DRIVEN, 0] > 0.0
    assert (taken[DRIVING, 0] > 0.0) == (case.teeth.driving is not None)


def test_of_one_cycle_it_is_the_wear_of_the_flanks_as_they_are(case):
    mesh, taken = case.followed(case.line_load, 1.0).mesh([case.line_load], all_slices(case))
    expected, expected_taken = case.found(case.line_load)
    close(mesh, expected)
    np.testing.assert_allclose(taken, expected_taken, rtol=1e-12)


def test_it_is_linear_in_each_load(case):
    influence, slices = case.followed(case.line_load, 3.0), all_slices(case)
    times = np.linspace(0.0, 2.9, case.line_load.size).reshape(case.line_load.shape)
    some, others = (
        influence.mesh([times * case.line_load], slices),
        influence.mesh([(3.0 - times) * case.line_load], slices),
    )
    whole = influence.mesh([3.0 * case.line_load], slices)
    close(some[0].plus(1.0, others[0]), whole[0])
    np.testing.assert_allclose(some[1] + others[1], whole[1], rtol=1e-12)


def test_slices_whose_loads_were_not_predicted_are_found_on_the_flanks(case):
    late = case.line_load.copy()
    late[:, 3:] = 0.0
    influence = case.followed(late, 1.0)
    close(influence.mesh([case.line_load], all_slices(case))[0], case.found(case.line_load)[0])
    # and where they wear on, between what the first and the last of the flanks would have them wear
    ends = [Case(case.teeth, case.motion, worn, case.line_load).found(case.line_load)[0] for worn in case_ends(case)]
    mesh = case.followed(late, 5.0).mesh([case.line_load], all_slices(case))[0]
    total = mesh.driven[4:].sum()
    low, high = sorted(float(one.driven[4:].sum()) for one in ends)
    assert 0.999 * low < total < 1.001 * high


def test_unpredicted_loads_are_found_on_the_flanks_that_the_others_met(case, monkeypatch):
    late = case.line_load.copy()
    late[:, 3:] = 0.0
    influence, met = case.followed(late, 3.0, 1.0), []
    over = step_influence._MeshWear.over
    monkeypatch.setattr(
        step_influence._MeshWear, "over", lambda self, worn, *rest: met.append(worn) or over(self, worn, *rest)
    )
    influence.mesh([case.line_load], all_slices(case))
    assert len(met) == 3 and all(one is other for one, other in zip(met, influence.course.met, strict=True))
    assert len({id(one) for one in met}) == 3


@pytest.mark.parametrize("cycles", [2.0, 3.0, 3.4, 6.0])
def test_cycles_that_look_ahead_find_footprints_about_the_middle_of_the_step(case, cycles):
    """Of a short one, in which all wears evenly: by their lengths they are found there on average."""
    course = case.followed(case.line_load, cycles, 1.0, 0.01 * STEP).course
    start, end = course.shapes[0].driven, course.shapes[-1].driven
    met = sum(part * one.driven for part, one in zip(course.parts, course.met, strict=True)) / cycles
    np.testing.assert_allclose(met - start, 0.5 * (end - start), atol=2e-2 * (end - start).max())


def case_ends(case: Case) -> tuple[Worn, Worn]:
    """Flanks before and after the step, of whose slices some wear."""
    influence = case.followed(case.line_load, 5.0)
    return influence.course.shapes[0], influence.course.shapes[-1]


def test_a_load_far_above_the_predicted_one_changes_over_evenly(case):
    """Its footprint goes over from the one that was kept to one that is found for it."""
    few = case.line_load.copy()
    few[:, 4] *= 0.2
    influence, slices = case.followed(few, 3.0), all_slices(case)
    loads = [case.line_load.copy() for _ in range(3)]
    for share, one in zip((0.6 - 1e-7, 0.6, 0.6 + 1e-7), loads, strict=True):
        one[:, 4] *= share  # three times the predicted one
    below, at, above = (influence.mesh([one], slices)[0].driven for one in loads)
    rise = np.abs(at - below).max()
    assert 0.0 < rise < 1e-6 * at.max() and np.abs(above - at).max() < 3.0 * rise


def test_flanks_between_cycles(case):
    influence = case.followed(case.line_load, 2.5)
    close(influence.course.at(0.0), influence.course.shapes[0])
    close(influence.course.at(1.0), influence.course.shapes[-1])
    first, second = influence.course.shapes[1:3]
    close(influence.course.at(0.6), first.plus(0.5, second.plus(-1.0, first)))


def test_three_cycles_that_look_ahead_err_less_than_six_that_do_not(case):
    step = 0.3 * STEP
    exact = case.followed(case.line_load, 48.0, 1.0, step).course.shapes[-1]

    def error(cycles: float, ahead: float) -> float:
        apart = case.followed(case.line_load, cycles, ahead, step).course.shapes[-1].plus(-1.0, exact)
        return float(np.sqrt(sum(np.sum(np.square(one)) for one in apart if one is not None)))

    plain, ahead = [error(cycles, 0.0) for cycles in (3.0, 6.0)], [error(cycles, 1.0) for cycles in (3.0, 6.0)]
    assert ahead[0] < plain[1] < plain[0] and ahead[1] < 0.5 * ahead[0]


def test_footprints_need_not_be_kept(case):
    rows = no_rows(case.line_load.shape)
    assert rows.amount.size == 0 and (rows.row == -1).all()


@pytest.mark.parametrize("cycles", [1.0, 3.0])
def test_footprints_of_two_widths_wear_the_same_flanks(case, cycles):
    """Each as by itself, times its share, on shapes that both of them wear; equal widths as one of them alone."""
    wide, slices = replace(case.teeth, half_width=1.5 * case.teeth.half_width), all_slices(case)
    load, wears = case.line_load, Cycles(cycles)
    spread = [SpreadLoad(case.teeth, load, 0.25), SpreadLoad(wide, 0.5 * load, 0.75)]
    both = followed(spread, case.motion, case.worn, after, wears)
    meshes = [one.mesh(part.line_load, slices, both.course)[0] for one, part in zip(both.widths, spread, strict=True)]
    mesh = both.mesh([part.line_load for part in spread], slices)[0]
    close(mesh, meshes[0].towards(0.75, meshes[1]))
    close(case.worn.plus(STEP, mesh), both.course.shapes[-1])
    assert both.differs_from([load, load]) == pytest.approx(0.375)
    if cycles == 1.0:
        for teeth, part, mesh in zip((case.teeth, wide), spread, meshes, strict=True):
            alone = followed([SpreadLoad(teeth, part.line_load)], case.motion, case.worn, after, wears)
            close(mesh, alone.mesh([part.line_load], slices)[0])
        assert np.abs(meshes[0].driven - 2.0 * meshes[1].driven).max() > 0.05 * meshes[0].driven.max()
    alike = [SpreadLoad(case.teeth, load, share) for share in (0.25, 0.75)]
    close(
        followed(alike, case.motion, case.worn, after, wears).course.shapes[-1],
        case.followed(load, cycles).course.shapes[-1],
    )
