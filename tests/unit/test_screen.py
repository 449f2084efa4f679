"""Screening: what is called for, what comes along, and what cannot be run."""

import importlib

import numpy as np
import pytest

import semiwear as sw
from semiwear.errors import ConvergenceError
from semiwear.plan import plan
from semiwear.scene import EFFECTS
from semiwear.screen import QUANTITIES, ScreenedEffect, Screening
from semiwear.wear.step_count import steps_of_life
from tests.scenes import TINY, Heard
from tests.strategies.ratings import RATED


@pytest.fixture(scope="module")
def tiny(shipped):
    return shipped.replace(TINY)


@pytest.fixture
def only(monkeypatch):
    """Leaves out all other effects, which would take their time."""

    def chosen(*names):
        monkeypatch.setattr(importlib.import_module("semiwear.screen"), "EFFECTS", {n: EFFECTS[n] for n in names})

    return chosen


@pytest.fixture(scope="module")
def heard():
    return Heard()


@pytest.fixture(scope="module")
def screening(tiny, heard):
    return sw.screen(tiny, progress=heard)


@pytest.fixture(scope="module")
def rows(screening):
    return {row.effect: row for row in screening.rows}


def test_every_effect_has_a_row(screening):
    assert [row.effect for row in screening.rows] == list(EFFECTS)
    assert not any(row.present for row in screening.rows)


def test_what_only_tells_changes_nothing(rows):
    for name in ("flash_temperature", "lubrication"):
        assert set(rows[name].changes.values()) == {0.0}
        assert "at 1000 rpm" in rows[name].note
    assert "contact_temperature_max" in rows["flash_temperature"].note


def test_numbers_are_those_of_loaded_contact(tiny, screening, rows):
    """The greatest root stress and the transmission error, as the analysis of the same scenes gives them."""
    table = EFFECTS["misalignment"].screening_table(tiny)
    plain, misaligned = (sw.loaded_contact(scene) for scene in (tiny, tiny.replace({"effects.misalignment": table})))
    for tree, name, value in (
        (plain, "", screening.base),
        (misaligned, "misalignment", None),
    ):
        stress = float(tree["engagement"]["root_stress"].sel(body="gear").max())
        error = float(tree["mesh_cycle"]["transmission_error_loaded"].mean())
        told = value or {key: screening.base[key] * (1.0 + rows[name].changes[key]) for key in screening.base}
        assert told["root stress gear"] == pytest.approx(stress, rel=1e-6)
        assert told["transmission error mean"] == pytest.approx(error, rel=1e-6)


def test_the_wear_rate_is_that_of_a_short_run(tiny, screening):
    short = {"wear.until.meshes": 1e4, "wear.control_point": None, "numerics.wear_steps": 1}
    tree = sw.simulate(tiny.replace(short))
    assert screening.base["wear rate"] == pytest.approx(float(tree["flank"]["wear_depth"].max()) / 1e4, rel=0.01)


def test_hardness_is_judged_where_the_run_ends(rows):
    """At 60 um all wear is in the core of 400 HV: 700/400 times as fast."""
    assert rows["wear_law.hardness"].changes["wear rate"] == pytest.approx(700.0 / 400.0 - 1.0)
    assert "60 um" in rows["wear_law.hardness"].note


def test_hardness_is_not_judged_where_no_step_leads_to_the_end_of_the_run(tiny, only, monkeypatch):
    only("wear_law.hardness")

    def too_deep(scene, teeth):
        raise ConvergenceError("the tooth is worn away long before")

    monkeypatch.setattr(importlib.import_module("semiwear.screen"), "_depths_at_the_end", too_deep)
    (row,) = sw.screen(tiny).rows
    assert row.note == "not judged at the end of the run: the tooth is worn away long before"
    assert row.changes["wear rate"] == 0.0 and row.time is not None


def test_called_for_is_by_the_threshold(screening):
    greatest = {row.effect: row.greatest for row in screening.rows}
    assert set(screening.called_for) == {name for name, value in greatest.items() if value >= 0.02}
    assert "misalignment" in screening.called_for and "lubrication" not in screening.called_for
    called = [greatest[name] for name in screening.called_for]
    assert called == sorted(called, reverse=True)


def test_a_life_is_not_judged_by_a_mesh_cycle(rows, tiny):
    assert not rows["run_life"].changes and "changes nothing" in rows["run_life"].note
    steps = steps_of_life(0.05, plan(tiny).flank_pair().base_pitch)  # as the plan says, until the default's 50 um
    assert f"takes about {steps} wear steps in two stages" in rows["run_life"].note


def test_the_table_says_it_all(screening):
    text = str(screening)
    assert all(name in text for name in EFFECTS)
    assert "called for at 2 %: " + screening.called_for[0] in text
    assert max(map(len, text.splitlines())) <= 120


def test_as_a_dataset(screening, rows):
    found = screening.to_dataset()
    change = found["change"].sel(effect="friction", quantity="pressure")
    assert float(change) == rows["friction"].changes["pressure"]
    assert np.isnan(found["time_ratio"].sel(effect="run_life"))


def test_progress_hears_of_every_effect(screening, heard):
    assert [done for done, _, _ in heard.steps] == list(range(1, len(EFFECTS) + 2))
    assert heard.steps[-1][1] == len(EFFECTS) + 1


@pytest.mark.slow
def test_present_effects_are_removed_with_what_needs_them(tiny, only):
    only("friction", "flash_temperature", "lubrication", "wear_law.hardness", "wear_law.lubrication", "pitch_error")
    scene = tiny.replace(
        {
            "numerics.tooth_compliance": "rigid",
            "operation.pinion_speed_rpm": 500.0,
            "effects.lubrication": {},
            "effects.wear_law.lubrication": {"full_film_lambda": 1.0, "boundary_lambda": 0.01},
            "effects.friction.law": "iso_14179",
            "effects.wear_law.hardness.case_depth_um": 200.0,
            "effects.pitch_error.pinion_um": [0.0, 0.0],
        }
    )
    screening = sw.screen(scene)
    rows = {row.effect: row for row in screening.rows}
    assert {name for name, row in rows.items() if row.present} == {name for name, _ in scene.effects.present()}
    assert "together with wear_law.lubrication" in rows["lubrication"].note
    assert rows["lubrication"].changes == rows["wear_law.lubrication"].changes
    assert rows["lubrication"].changes["wear rate"] > 0.02
    assert "rpm" not in rows["flash_temperature"].note
    assert "acts only beyond 200 um" in rows["wear_law.hardness"].note
    assert set(screening.could_go) == {"pitch_error", "wear_law.hardness"} | (
        {"friction"} if rows["friction"].greatest < 0.02 else set()
    )


def test_without_wear_the_laws_are_skipped(tiny, only):
    laws = ("wear_law.hardness", "wear_law.lubrication", "wear_law.temperature", "wear_law.load", "run_life")
    only("misalignment", "lubrication", "flash_temperature", *laws)
    screening = sw.screen(tiny.replace({"wear": None, "numerics.tooth_compliance": "rigid"}))
    rows = {row.effect: row for row in screening.rows}
    for name in laws:
        assert not rows[name].changes and "needs [wear]" in rows[name].note
    assert set(rows["misalignment"].changes) == {
        "pressure",
        "transmission error mean",
        "transmission error amplitude",
    }
    assert "wear_law.load" not in screening.called_for


def test_what_cannot_be_combined_is_listed(tiny, only, monkeypatch):
    """A table that the scene's rules refuse: the reason stands in the row."""
    only("pitch_error")
    table = {"pinion_um": [0.0] * 40}
    monkeypatch.setattr(EFFECTS["pitch_error"], "screening_table", staticmethod(lambda scene: table))
    (row,) = sw.screen(tiny).rows
    assert row.note.startswith("not run: effects.pitch_error.pinion_um") and row.time is None


def test_failure_modes_near_their_limits_are_named(only):
    """Of the modes that the scene rates, and no others; one that needs data of the materials says so."""
    only("pitting", "bending", "scuffing")
    pair = sw.load_scene("spur_fzg_c").replace(
        RATED | TINY | {"operation.pinion_torque_Nm": 200.0, "effects.bending.required_safety": 2.7}
    )
    found = sw.screen(pair)
    verdicts = {row.effect: row.note.partition(":")[0] for row in found.rows}
    assert verdicts == {"pitting": "fails", "bending": "near its limit", "scuffing": "not run"}
    assert found.near_limits == ("pitting", "bending")
    assert "failure modes that fail or come near it: pitting, bending" in str(found)
    calm = pair.replace({"effects.pitting.required_safety": 0.1, "effects.bending.required_safety": 0.1})
    assert sw.screen(calm).near_limits == ()


@pytest.mark.parametrize("threshold", [0.0, -1.0, float("nan"), float("inf")])
def test_a_threshold_is_above_zero(tiny, threshold):
    with pytest.raises(sw.SceneError, match="threshold"):
        sw.screen(tiny, threshold)


def test_a_speed_is_above_zero_and_told_with_the_threshold(tiny):
    with pytest.raises(sw.SceneError, match=r"2 problems\n.*threshold: .*\n.*speed_rpm: found -5\.0"):
        sw.screen(tiny, 0.0, speed_rpm=-5.0)


def test_a_change_from_nothing_counts(tiny):
    row = ScreenedEffect("friction", False, dict.fromkeys(QUANTITIES, -0.5), 1.0)
    screening = Screening(tiny, 0.5, dict.fromkeys(QUANTITIES, 1.0), 1.0, (row,))
    assert screening.called_for == ("friction",) and screening.could_go == ()
