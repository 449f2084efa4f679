"""Inputs that no run can read are refused before anything waits for them or is computed."""

import os

import pytest

import semiwear as sw
from semiwear.cli import main
from semiwear.measured_load import measured_load
from tests.scenes import problems_of
from tests.strategies.results import synthetic_tree


@pytest.fixture
def pipe(tmp_path):
    path = tmp_path / "pipe.toml"
    os.mkfifo(path)
    return path


def test_a_pipe_without_a_writer_is_no_scene(pipe):
    with pytest.raises(sw.SceneError, match="a pipe or a socket"):
        sw.load_scene(pipe)


@pytest.mark.parametrize("command", [["plan"], ["run"], ["check"], ["geometry"], ["cite"]])
def test_commands_refuse_it(pipe, command, capsys):
    assert main([*command, str(pipe)]) == 2
    assert "a pipe or a socket" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["sweep", "optimise"])
def test_it_is_no_study(pipe, command, capsys):
    assert main([command, str(pipe), "-o", str(pipe.with_name("best.toml"))]) == 2
    assert "a pipe or a socket" in capsys.readouterr().err


def test_it_is_no_measured_load(pipe):
    with pytest.raises(sw.SemiwearError, match="a pipe or a socket"):
        measured_load(pipe)


def test_a_broken_file_of_deviations_is_told_with_the_scene(tmp_path):
    grid = tmp_path / "flank.csv"
    grid.write_text("um, 0, 1\n0, 1, x\n", encoding="utf-8")
    spur = sw.load_scene("spur_fzg_c")
    with pytest.raises(sw.SceneError, match=r"effects.modification.gear.file: found"):
        spur.replace({"effects.modification.gear.file": str(grid)})
    change = {"effects.modification.pinion.file": str(tmp_path / "no.nc"), "gear_pair.pinion_tip_diameter_mm": 87.0}
    assert set(problems_of(spur.replace, change)) == set(change)


def test_a_result_that_tells_no_times_is_no_last_run(tmp_path):
    spur = sw.load_scene("spur_fzg_c")
    tree = synthetic_tree()
    assert sw.plan(spur, tree).last[""] > 0.0
    del tree["diagnostics"]
    with pytest.raises(sw.SceneError, match="last"):
        sw.plan(spur, tree)
