"""What commands leave: exit codes, errors on standard error, one JSON document, silence, completion."""

import json
import logging
import os
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import semiwear as sw
from fem_reference.solvers import SlowSolverWarning
from semiwear.cli import main
from semiwear.console import notes_on_standard_error
from semiwear.scene import load_scene
from tests.scenes import TINY

SMALL = [f"--set={key}={value}" for key, value in (TINY | {"numerics.wear_steps": 1}).items()]


def test_a_run_ends_in_one_json_document(tmp_path, capsys):
    out = tmp_path / "worn.nc"
    assert main(["run", "spur_fzg_c", *SMALL, "-o", str(out), "--json"]) == 0
    told = capsys.readouterr()
    end = json.loads(told.out)
    history = sw.open_results(out)["history"].isel(wear_step=-1)
    assert end["command"] == "run" and end["result"] == str(out) and end["wear_steps"] == 1 and end["life"] is None
    assert end["history"]["root_stress_max[gear]"] == float(history.root_stress_max.sel(body="gear"))
    assert end["history"]["meshes"] == float(history.meshes)
    assert "computing the unworn teeth" in told.err


@pytest.mark.parametrize("change", ["wear=none", "operation.pinion_torque_Nm=1e9"])
def test_problems_found_in_a_run_are_told_under_the_scenes_name(change, capsys):
    assert main(["run", "spur_fzg_c", *SMALL, f"--set={change}"]) == 2
    assert "semiwear: spur_fzg_c: 1 problem" in capsys.readouterr().err


def test_problems_found_in_a_result_are_told_under_its_files_name(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["run", "spur_fzg_c", *SMALL, "-o", "worn.nc"]) == 0
    assert main(["export", "worn.nc", "--wear-step=9", "-o", "worn.vtu"]) == 2
    assert "semiwear: worn.nc: 1 problem\n  1. wear_step: found 9" in capsys.readouterr().err


def test_a_quiet_run_says_nothing_but_its_end(capsys):
    assert main(["run", "spur_fzg_c", *SMALL, "--quiet"]) == 0
    told = capsys.readouterr()
    assert told.err == "" and "load share" in told.out


def test_a_warning_of_ours_is_a_note_without_a_place_in_the_code():
    with notes_on_standard_error(quiet=False):
        assert warnings.formatwarning("slow", SlowSolverWarning, "some.py", 7) == "semiwear: slow\n"
        assert "some.py:7" in warnings.formatwarning("overflow", RuntimeWarning, "some.py", 7)
    assert "some.py:7" in warnings.formatwarning("slow", SlowSolverWarning, "some.py", 7)


@pytest.mark.parametrize(
    ("command", "key"),
    [
        (["plan", "spur_fzg_c"], "physics"),
        (["fields"], "schema"),
        (["new", "cylindrical", "-o", "my.toml"], "scene"),
    ],
)
def test_light_commands_end_in_json(command, key, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*command, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[key]


def test_screening_ends_in_json(capsys):
    assert main(["screen", "spur_fzg_c", *SMALL, "--json", "-q"]) == 0
    told = capsys.readouterr()
    end = json.loads(told.out)
    friction = next(row for row in end["effects"] if row["effect"] == "friction")
    assert ("friction" in end["called_for"]) == (max(map(abs, friction["changes"].values())) >= 0.02)
    assert end["near_limits"] == []  # the scene rates no failure mode
    assert told.err == ""


def test_errors_are_on_standard_error_and_told_one_by_one(capsys):
    wrong = ["run", "spur_fzg_c", "--set", "operation.pinion_torque_Nm=-3", "--set", "gear_pair.pinion_teeth=2"]
    assert main([*wrong, "--json"]) == 2
    told = capsys.readouterr()
    error = json.loads(told.err)
    assert told.out == "" and error["error"] == "SceneError"
    assert {one["field"] for one in error["problems"]} >= {"operation.pinion_torque_Nm", "gear_pair.pinion_teeth"}
    assert main([*wrong, "--quiet"]) == 2
    told = capsys.readouterr()
    assert told.out == "" and "operation.pinion_torque_Nm" in told.err


def test_wrong_options_end_with_two(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["run"])
    assert ended.value.code == 2 and "usage:" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("no_such_command --json", "semiwear: argument COMMAND: invalid choice: 'no_such_command'"),
        ("--json", "semiwear: the following arguments are required: COMMAND"),
        ("run --json", "semiwear run: the following arguments are required: scene"),
        ("plan spur_fzg_c --json --colour", "semiwear: unrecognized arguments: --colour"),
        ("new worm --json", "semiwear new: argument kind: invalid choice: 'worm'"),
    ],
)
def test_wrong_commands_and_options_are_told_as_json(words, message, capsys, monkeypatch):
    monkeypatch.setattr("sys.argv", ["semiwear", *words.split()])
    for given in (words.split(), None):
        with pytest.raises(SystemExit) as ended:
            main(given)
        told = capsys.readouterr()
        error = json.loads(told.err)
        assert ended.value.code == 2 and told.out == ""
        assert error["error"] == "UsageError" and error["message"].startswith(message)
    with pytest.raises(SystemExit):
        main([word for word in words.split() if word != "--json"])
    told = capsys.readouterr()
    assert told.err.startswith("usage: semiwear") and message in told.err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (
            "rexs x.rexs -o x.toml --torque 300,5",
            "--torque: found '300,5'; allowed: greater than 0 -> did you mean 300.5?",
        ),
        ("rexs x.rexs -o x.toml --torque=-3", "--torque: found '-3'; allowed: greater than 0"),
        ("screen spur_fzg_c --threshold 2%", "--threshold: found '2%'; allowed: greater than 0 -> did you mean 2?"),
        (
            "calibrate spur_fzg_c x.nc --confidence 95",
            "--confidence: found '95'; allowed: above 0 and below 1 -> 0.95",
        ),
        ("calibrate spur_fzg_c x.nc --meshes 4e7x", "--meshes: found '4e7x'"),
        ("optimise x.toml -o y.toml --workers 1.5", "--workers: found '1.5'; allowed: whole number, 0 to 1024"),
        ("export x.nc -o x.csv --wear-step last", "--wear-step: found 'last'; allowed: a whole number"),
        ("plan spur_fzg_c --set torque", "--set: found 'torque'; allowed: KEY=VALUE -> e.g. --set operation."),
    ],
)
def test_numbers_of_options_tell_what_is_allowed(words, told, capsys):
    assert main(words.split()) == 2
    assert told in capsys.readouterr().err


def test_options_that_are_wrong_are_told_at_once(capsys):
    wrong = "--meshes 4,5e7 --life 60um --set a --confidence nan --json"
    assert main(["calibrate", "spur_fzg_c", "x.nc", *wrong.split()]) == 2
    error = json.loads(capsys.readouterr().err)
    told = {one["field"]: one["fix"] for one in error["problems"]}
    assert told["--meshes"] == "did you mean 4.5e7?" and told["--life"] == "did you mean 60?"
    assert set(told) == {"--meshes", "--life", "--set", "--confidence"}


@pytest.fixture
def wrong_scene(tmp_path):
    text = sw.load_scene("spur_fzg_c").to_toml().replace("pinion_torque_Nm = 302.0", "pinion_torque_Nm = -3")
    (tmp_path / "wrong.toml").write_text(text, encoding="utf-8")
    return tmp_path / "wrong.toml"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (
            "run {scene} --set x --set wear.until.meshes=-1 --fidelity line --set numerics.fidelity=patch "
            "--resume --report {scene}/a.nc",
            "--set wear.until.meshes --fidelity --resume --report",
        ),
        ("run {scene} -o no/folder.nc --against a.nc --set gear=3", "-o --against gear"),
        ("geometry {scene} -o a.doc --set gear=3", "-o gear"),
        ("screen {scene} --threshold 2% --set gear=3", "--threshold gear"),
        ("calibrate {scene} x.nc --life 60um", "--life"),
        ("optimise {study} -o best.nc --workers 1.5", "-o --workers gear"),
        ("infer {study} -o best.toml --workers 1.5", "-o --workers gear"),
        ("sweep {study} -o best.toml --workers 1.5 --scheduler x", "-o --workers gear"),
    ],
)
def test_problems_of_scene_and_options_are_told_at_once(words, told, wrong_scene, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(f'scene = "{wrong_scene}"\nset.gear = 3\n', encoding="utf-8")
    places = {"scene": wrong_scene, "study": tmp_path / "study.toml"}
    assert main([word.format(**places) for word in words.split()] + ["--json", "-q"]) == 2
    fields = {one["field"] for one in json.loads(capsys.readouterr().err)["problems"]}
    assert fields >= {*told.split(), "operation.pinion_torque_Nm"}


def test_a_change_mends_what_the_file_has_wrong(wrong_scene, capsys):
    assert main(["plan", str(wrong_scene), "--set", "operation.pinion_torque_Nm=302.0"]) == 0
    changed = load_scene(wrong_scene, changes={"operation.pinion_torque_Nm": 302.0, "effects.friction": {}})
    assert changed == sw.load_scene("spur_fzg_c").replace({"effects.friction": {}})


def test_a_page_over_hours_and_files_in_the_way_are_told_at_once(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = sw.load_scene("spur_fzg_c").replace({"operation.pinion_speed_rpm": None}).to_toml()
    Path("a.html").write_text(text, encoding="utf-8")
    assert main(["run", "a.html", "--report", "a.html", "--over", "hours"]) == 2
    told = capsys.readouterr().err
    assert "--over: found 'hours'" in told and "the scene is that file" in told


def test_arguments_that_are_wrong_are_told_at_once():
    spur = sw.load_scene("spur_fzg_c").replace({"wear": None})

    def fields(call, **arguments):
        with pytest.raises(sw.SceneError) as error:
            call(spur, **arguments)
        return {problem.field for problem in error.value.problems}

    assert fields(sw.simulate, fidelity="coarse", resume=True) == {"numerics.fidelity", "wear", "resume"}
    assert fields(sw.scatter, distributions={"x": 1}, crew=-1) == {"x", "workers", "wear"}
    assert fields(sw.infer, unknown={}, observed=[], crew=-1, runs=1) >= {"workers", "runs", "wear"}


def test_missing_values_are_null(capsys):
    rigid = ["--set", "numerics.tooth_compliance=rigid", "--set", "operation.pinion_torque_Nm=0.01"]
    assert main(["run", "spur_fzg_c", *SMALL, *rigid, "--json", "-q"]) == 0
    text = capsys.readouterr().out
    assert "NaN" not in text and json.loads(text)["history"]


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_shells_complete_commands(shell, capsys):
    pytest.importorskip("shtab", reason="extra completion: scripts are made by shtab")
    with pytest.raises(SystemExit) as ended:
        main(["--print-completion", shell])
    script = capsys.readouterr().out
    assert ended.value.code == 0
    assert all(word in script for word in ("calibrate", "--wear-step", "optimise", "--quiet"))


@pytest.mark.skipif(not os.path.exists("/bin/bash"), reason="needs bash")
def test_bash_runs_the_completion():
    pytest.importorskip("shtab", reason="extra completion: scripts are made by shtab")
    script = subprocess.run(
        [sys.executable, "-m", "semiwear", "--print-completion", "bash"], capture_output=True, text=True, check=True
    ).stdout
    ask = "\nCOMP_WORDS=(semiwear exp)\nCOMP_CWORD=1\n$(complete -p semiwear | sed 's/.*-F \\([^ ]*\\).*/\\1/')\n"
    done = subprocess.run(
        ["/bin/bash", "-c", f'{script}{ask}echo "${{COMPREPLY[@]}}"'], capture_output=True, text=True, check=False
    )
    assert done.stdout.split() == ["export"], done.stderr


def test_completion_without_its_package_names_the_extra(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert main(["--print-completion", "bash"]) == 2
    assert "semiwear[completion]" in capsys.readouterr().err


def test_loggers_are_left_as_they_were(caplog):
    logger = logging.getLogger("semiwear")
    before = logger.level, logger.propagate, list(logger.handlers)
    assert main(["plan", "spur_fzg_c", "--quiet"]) == 0
    assert (logger.level, logger.propagate, list(logger.handlers)) == before


def test_the_package_logs_its_wear_steps(caplog):
    scene = sw.load_scene("spur_fzg_c").replace(TINY | {"numerics.wear_steps": 2})
    with caplog.at_level(logging.INFO, logger="semiwear"):
        sw.simulate(scene)
    steps = [record.getMessage() for record in caplog.records if record.name == "semiwear.simulate"]
    assert len(steps) == 2 and steps[-1].startswith("wear step 2 of 2")


def test_a_page_over_hours_needs_a_speed_before_anything_runs(tmp_path, capsys):
    scene = tmp_path / "slow.toml"
    scene.write_text(
        sw.load_scene("face_gear_25x160").replace({"operation.pinion_speed_rpm": None}).to_toml(), encoding="utf-8"
    )
    assert (
        main(
            ["run", str(scene), "-o", str(tmp_path / "a.nc"), "--report", str(tmp_path / "a.html"), "--over", "hours"]
        )
        == 2
    )
    assert "--over: found 'hours'; allowed: a scene with a speed" in capsys.readouterr().err
    assert [entry.name for entry in tmp_path.iterdir()] == ["slow.toml"]
