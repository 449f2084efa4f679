"""The problems of the validation: scenes are built, references finer than what is measured, hard cases named."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from semiwear.closed_forms.hertz import line_contact_half_width, line_contact_pressure
from semiwear.errors import SemiwearError
from validation.hard_cases import HARD_EXAMPLES, attempt
from validation.iso_spur import iso_rows
from validation.problems import FIGURES, METHODS, WEAR_PROBLEMS, Figure, wear_problem
from validation.standing_contact import StandingContact, loads_of_strips, strips
from validation.wear_schemes import life_of

KINDS = {
    "undercut limit",
    "pointing limit",
    "pinion tip on the gear fillet",
    "heel and toe",
    "corner contact",
    "torque",
    "near-conformal flanks",
    "localised contact",
    "zero sliding at the pitch line",
    "pairs change within a roll step",
    "deep wear",
    "wear steps too large",
    "noisy measured flank",
    "slices",
    "mirrored flanks",
    "material contrast",
    "tooth numbers",
}


# ---- wear problems


@pytest.mark.parametrize("problem", WEAR_PROBLEMS, ids=lambda problem: problem.name)
def test_every_problem_is_a_scene_that_every_method_takes(problem):
    for method in METHODS:
        for quick in (True, False):
            for setting in (*method.swept(quick), method.converged(quick)):
                scene = problem.scene(method.changes, setting.changes)
                assert scene.wear is not None
                assert scene.wear.until.meshes is not None
                assert scene.numerics.face_slices == setting.face_slices
                assert scene.numerics.wear_steps == setting.wear_steps
    assert problem.marches
    assert wear_problem(problem.name) is problem


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
@pytest.mark.parametrize("quick", [True, False])
def test_what_counts_as_converged_is_finer_than_what_is_measured(method, quick):
    converged = method.converged(quick)
    for setting in method.swept(quick):
        for name in ("roll_positions", "face_slices", "profile_points", "wear_steps"):
            assert getattr(setting, name) <= getattr(converged, name), name
        assert setting.roll_positions < converged.roll_positions


def test_figures_are_the_greatest_of_the_last_state():
    history = xr.Dataset(
        {"a": ("wear_step", [1.0, -3.0]), "b": (("wear_step", "body"), [[9.0, 9.0], [2.0, 1.0]])},
    )
    tree = xr.DataTree.from_dict({"/history": history})
    other = xr.DataTree.from_dict({"/history": history * 1.5})
    figure = Figure("size", "mm", ("a", "b", "not there"))
    assert figure.greatest(tree) == -3.0
    assert figure.error(other, tree) == pytest.approx(0.5)
    assert [one.name for one in FIGURES] == ["greatest wear", "peak pressure", "root stress", "transmission error"]


@pytest.mark.slow
def test_a_life_by_any_scheme_ends_alike():
    coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.profile_points": 41}
    # a micrometre in all: explicit steps far below what gears bear
    changes = coarse | {"numerics.tooth_compliance": "rigid", "wear.until.meshes": 2e7}
    life = life_of(wear_problem("face_gear").scene(changes))
    converged = life.states("two-stage", 4)[-1]
    for scheme, count in (("explicit", 16), ("implicit", 16), ("two-stage", 2)):
        run = life.run(scheme, count, converged)
        assert run.error < 0.02 and run.flank_error < 0.02
        assert not run.shrinks
    assert life.run("two-stage", 2, converged).solves == 10


# ---- hard cases


def test_the_hard_cases_are_those_that_were_asked_for():
    assert {example.kind for example in HARD_EXAMPLES} == KINDS
    names = [(example.kind, example.name) for example in HARD_EXAMPLES]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize(
    "example", [e for e in HARD_EXAMPLES if e.refused and not e.runs], ids=lambda e: f"{e.kind}, {e.name}"
)
def test_what_cannot_be_is_refused_before_computing(example):
    with pytest.raises(sw.SceneError) as error:
        example.solve({"numerics.fidelity": "line"})
    assert all(problem.field and problem.allowed for problem in error.value.problems)
    outcome = attempt(example, "line")
    assert outcome.as_it_should_be
    assert outcome.error == str(error.value.problems[0])


@pytest.mark.slow
@pytest.mark.parametrize("fidelity", ["line", "patch"])
def test_what_came_of_a_case_is_measured(fidelity):
    example = next(e for e in HARD_EXAMPLES if e.name == "noise of 2 um")
    outcome = attempt(example, fidelity, doublings=2)
    assert outcome.as_it_should_be
    assert outcome.pressure > 0.0
    # loads are about in proportion to the torque
    assert 0.1 < outcome.continuity < 10.0
    assert len(outcome.refinements) == 2


def test_a_case_that_ends_otherwise_is_told():
    limit = next(e for e in HARD_EXAMPLES if e.name == "inner radius 465.17 mm")
    assert not attempt(type(limit)(limit.kind, limit.name, limit.changes), "line").as_it_should_be
    fine = type(limit)("slices", "21", neighbours=False, refused=True)
    assert not attempt(fine, "line").as_it_should_be


# ---- standing contact


def test_strips_bear_what_hertz_says():
    contact = StandingContact(20.0, 100.0, 115e3, 1e-9, half_length=0.4, count=400)
    pressure = contact.pressure(np.zeros(400))
    curvature, load = np.array(1 / 20.0), np.array(100.0)
    half_width = float(line_contact_half_width(load, curvature, 115e3))
    assert pressure.sum() * contact.cell == pytest.approx(100.0, rel=1e-12)
    assert pressure.max() == pytest.approx(float(line_contact_pressure(load, curvature, 115e3)), rel=1e-3)
    assert 0.5 * contact.cell * (pressure > 0.0).sum() == pytest.approx(half_width, abs=contact.cell)


def test_implicit_steps_wear_by_the_pressure_at_their_end():
    contact = StandingContact(20.0, 10.0, 115e3, 2e-9, half_length=1.0, count=80)
    slid = 50.0 * contact.explicit_limit
    worn = contact.step(np.zeros(80), slid)
    np.testing.assert_allclose(worn, contact.coefficient * slid * contact.pressure(worn), atol=1e-6 * worn.max())


@pytest.mark.parametrize(("factor", "stable"), [(0.8, True), (0.95, True), (1.1, False), (1.2, False)])
def test_explicit_steps_beyond_the_limit_leave_every_other_strip_of_a_scar_bare(factor, stable):
    contact = StandingContact(20.0, 10.0, 115e3, 2e-9, half_length=0.5, count=100)
    distance = (120 * factor * contact.explicit_limit,)
    explicit, implicit = (
        contact.pressure(contact.run(distance, 120, implicit=implicit)[-1]) for implicit in (False, True)
    )
    scar = implicit > 0.0
    assert scar.sum() >= 10
    bare = (explicit[scar] <= 0.0).mean()
    off = np.abs(explicit - implicit)[scar].max() / implicit.max()
    assert (bare == 0.0 and off < 0.5) if stable else (bare > 0.3 and off > 0.9)


def test_strips_that_cannot_be_solved_say_so():
    with pytest.raises(SemiwearError, match="strips"):
        loads_of_strips(-strips(5), np.zeros(5), 1.0)


# ---- spur gears


@pytest.mark.slow
def test_spur_gears_follow_the_standard():
    rows = {row.name: row for row in iso_rows(sw.load_scene("spur_fzg_c").replace({"numerics.face_slices": 11}))}
    for name in ("working pressure angle", "base pitch", "pressure at the pitch point, even load"):
        assert abs(rows[name].difference) < 1e-6
    for name, row in rows.items():
        if name.startswith("specific sliding"):
            assert abs(row.difference) < 2e-3
        assert abs(row.difference) < 0.15
    with pytest.raises(SemiwearError, match="spur"):
        iso_rows(sw.load_scene("face_gear_25x160"))
