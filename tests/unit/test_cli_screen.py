"""Command line: screen, and plan with an earlier result."""

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from semiwear.cli import main
from semiwear.commands.wear_table import life_sentence
from semiwear.report.effects import effects_section
from semiwear.report.markup import figure_text
from semiwear.report.numbers import life_numbers
from semiwear.results.wearing import life_bodies
from semiwear.screen import ScreenedEffect, Screening
from tests.scenes import TINY

LIFE = TINY | {"wear.until.meshes": 1e8, "numerics.wear_steps": 1}


@pytest.fixture
def asked(monkeypatch):
    """What `sw.screen` was asked for, in place of a screening."""
    calls = []

    def screen(scene, threshold, *, progress):
        calls.append((scene, threshold))
        progress.step(1, 1, "friction")
        row = ScreenedEffect("friction", False, {"pressure": 0.1}, 1.5, "at 1000 rpm")
        base = {"pressure": 900.0, "transmission error mean": -10.0, "transmission error amplitude": 2.0}
        return Screening(scene, threshold, base, 0.5, (row,))

    monkeypatch.setattr(sw, "screen", screen)
    return calls


def test_screen_prints_the_table(asked, capsys):
    done = main(["screen", "face_gear_25x160", "--threshold", "0.05", "--set", "operation.pinion_torque_Nm=800"])
    assert done == 0
    ((scene, threshold),) = asked
    assert scene.operation.pinion_torque_Nm == 800 and threshold == 0.05
    out, err = capsys.readouterr()
    assert "called for at 5 %: friction" in out and "+10.0" in out
    assert "friction" in err


def test_screen_of_an_unknown_scene_is_an_error(asked, capsys):
    assert main(["screen", "no_such_scene"]) == 2
    assert "no_such_scene" in capsys.readouterr().err and not asked


def test_plan_shows_shares_of_an_earlier_run(tmp_path, capsys):
    scene = sw.load_scene("face_gear_25x160").replace(
        LIFE | {"effects.run_life.depth_limit_um": 2.0, "operation.pinion_speed_rpm": 100.0}
    )
    tree = sw.simulate(scene)
    sw.save(tree, tmp_path / "worn.nc")
    last = ["--last", str(tmp_path / "worn.nc")]
    assert main(["plan", "face_gear_25x160", "--set", "effects.run_life={}", *last]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "% of the time of the last" in out
    section = effects_section(sw.open_results(tmp_path / "worn.nc"))
    assert "Life until 2 µm of wear" in section and section.count("<img") == 0


def test_plan_with_a_missing_result_is_an_error(tmp_path, capsys):
    assert main(["plan", "face_gear_25x160", "--last", str(tmp_path / "none.nc")]) == 2
    assert "none.nc" in capsys.readouterr().err


def test_run_tells_the_life(tmp_path, capsys):
    settings = [word for key, value in LIFE.items() for word in ("--set", f"{key}={value}")]
    done = main(["run", "face_gear_25x160", *settings, "--set", "effects.run_life={depth_limit_um = 2.0}"])
    assert done == 0
    said = capsys.readouterr().out
    assert "life until 2 um on the gear: " in said and "wears deeper" not in said


def test_a_life_that_leaves_the_deeper_wear_out_says_so():
    wear = np.zeros((2, 2, 3, 4))
    wear[1] = np.array([5.9, 2.2])[:, None, None]
    flank = xr.Dataset({"wear_depth": (("wear_step", "body", "profile", "face"), wear)}, {"body": ["pinion", "gear"]})
    life = dict.fromkeys(("meshes_to_limit", "sensitivity_to_wear_coefficient", "sensitivity_to_torque"), 1.0)
    parts = {"/flank": flank, "/life": xr.Dataset(life | {"depth_limit": 50.0})}
    for asked, other in (("gear", "pinion"), ("pinion", "")):
        tree = xr.DataTree.from_dict(parts)
        tree.attrs["scene_toml"] = f'[wear]\nworn_bodies = ["pinion", "gear"]\n[effects.run_life]\nbody = "{asked}"\n'
        assert life_bodies(tree) == (asked, other)
        assert f"um on the {asked}: " in life_sentence(tree)
        assert (
            'the pinion wears deeper: limit it by effects.run_life.body = "pinion"' in life_sentence(tree)
        ) == bool(other)
        ((title, _, meaning),) = life_numbers(tree)
        assert title == f"Life until 50 µm of wear, {asked}" and ("pinion wears deeper" in meaning) == bool(other)


def test_a_page_shows_what_effects_add():
    changes = {"effects.friction": {}, "operation.pinion_speed_rpm": 100.0}
    plain, rubbing = (sw.simulate(sw.load_scene("face_gear_25x160").replace(LIFE | more)) for more in ({}, changes))
    assert effects_section(plain) == ""
    section = effects_section(rubbing)
    assert section.count("<img") == 2
    loss = float(rubbing["history"]["friction_power_loss_mean"][-1])
    assert "Efficiency of the mesh" in section and f"{figure_text(loss)} W" in section
