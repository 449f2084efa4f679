"""A life in hours: as the end of a run, and as the axis of pictures, beside kilometres of sliding."""

import sys

import numpy as np
import pytest
from scipy.integrate import trapezoid

import semiwear as sw
from semiwear.commands.wear_table import wear_table
from semiwear.results.life_axis import hours_of
from semiwear.scene import parse_scene
from tests.strategies.results import SCENE, synthetic_tree

SPEED = 1000.0


@pytest.fixture(scope="module")
def tree():
    found = synthetic_tree()
    found.attrs["scene_toml"] = SCENE.replace("[operation]", f"[operation]\npinion_speed_rpm = {SPEED}")
    return found


def test_hours_make_meshes_at_the_speed_of_the_scene():
    scene = sw.load_scene("spur_fzg_c").replace({"operation.pinion_speed_rpm": 1500.0, "wear.until.hours": 2000.0})
    assert scene.wear.until.meshes == pytest.approx(2000.0 * 60.0 * 1500.0 * 16 / 24)
    assert parse_scene(scene.to_toml()) == scene
    assert "meshes" not in scene.to_dict()["wear"]["until"]
    faster = scene.replace({"operation.pinion_speed_rpm": 3000.0})
    assert faster.wear.until.meshes == pytest.approx(2.0 * scene.wear.until.meshes)
    other = scene.replace({"wear.until.meshes": 1e6})
    assert other.wear.until.hours is None and other.wear.until.meshes == 1e6
    assert "2000 h" in str(sw.plan(scene))


def test_an_internal_gear_turns_as_often_as_its_teeth_say():
    changes = {"teeth": -60, "profile_shift": 0.0}
    scene = sw.load_scene("spur_fzg_c").replace(
        {f"gear_pair.gear_{name}": value for name, value in changes.items()}
        | {"gear_pair.pinion_teeth": 20, "gear_pair.pinion_profile_shift": 0.0, "gear_pair.centre_distance_mm": None}
        | {"operation.pinion_speed_rpm": 60.0, "wear.until.hours": 1.0}
    )
    assert scene.wear.until.meshes == pytest.approx(3600.0 * 20 / 60)


def test_hours_need_a_speed_and_are_the_only_end():
    spur = sw.load_scene("spur_fzg_c")
    with pytest.raises(sw.SceneError, match=r"operation.pinion_speed_rpm: missing.*wear.until.hours"):
        spur.replace({"wear.until.hours": 10.0})
    text = spur.to_toml().replace("[wear.until]", "[wear.until]\nhours = 10.0")
    with pytest.raises(sw.SceneError, match="exactly one of meshes, hours and control_depths_um"):
        parse_scene(text)


def test_wear_steps_are_told_in_hours(tree):
    told = sw.life_in(tree, "hours")
    meshes = tree["history"]["meshes"].values
    expected = meshes * 160 / 25 / (60.0 * SPEED)
    assert np.allclose(told["history"]["meshes"].values, expected)
    assert np.allclose(hours_of(tree), expected)
    assert np.array_equal(tree["history"]["meshes"].values, meshes)  # the result itself is as it was
    for draw in (sw.plot.wear_history, sw.plot.root_stress_history, sw.plot.contact_stress_history):
        ax = draw(told)
        assert ax.get_xlabel() == "Running time (h)"
        assert ax.get_lines()[0].get_xdata()[-1] == pytest.approx(expected[-1])
    assert "meshes" in sw.plot.wear_history(tree).get_xlabel()


def test_wear_steps_are_told_in_kilometres_of_sliding(tree):
    told = sw.life_in(tree, "km")
    sliding = tree["engagement"].sliding_distance.sel(body="gear").max("roll_position").values
    meshes = tree["history"]["meshes"].values
    expected = 1e-6 * trapezoid(sliding, meshes)
    assert told["history"]["meshes"].values[-1] == pytest.approx(expected)
    assert sw.plot.wear_history(told).get_xlabel() == "Sliding of the gear's flank (km)"


def test_a_report_counts_in_what_is_asked_for(tree, tmp_path, monkeypatch):
    seen, _ = [], sw.report
    monkeypatch.setattr(sys.modules["semiwear.report.contents"], "draw_all", lambda drawn: seen.append(drawn) or [])
    monkeypatch.setattr(sys.modules["semiwear.report.page"], "_sections", lambda data: data.pictures)
    sw.report(tree, tmp_path / "a.html", over="hours")
    sw.report(tree, tmp_path / "a.html")
    assert seen[0]["history"]["meshes"].attrs["units"] == "h"
    assert seen[1] is tree


def test_units_that_cannot_be_told_are_refused(tree, tmp_path):
    with pytest.raises(sw.SceneError, match=r"unit: found 'days'; allowed: .*meshes"):
        sw.life_in(tree, "days")
    with pytest.raises(sw.SceneError, match=r"unit: found 'hours'; .*pinion_speed_rpm"):
        sw.life_in(synthetic_tree(), "hours")
    with pytest.raises(sw.SceneError, match=r"over: found 'days'; allowed: .*meshes"):
        sw.report(tree, tmp_path / "a.html", over="days")


def test_the_table_of_a_run_has_hours_where_there_is_a_speed(tree):
    head, *rows = wear_table(tree).splitlines()
    assert head.split()[:2] == ["meshes", "hours"]
    assert rows[-1].split()[1] == f"{hours_of(tree)[-1]:.4g}"
    assert "hours" not in wear_table(synthetic_tree())
