"""Study files, the command line and the page of a sweep; solving is made up."""

import json
import re
from html.parser import HTMLParser
from importlib import import_module
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import semiwear as sw
from semiwear.cli import main
from semiwear.errors import ConvergenceError, Problem, ResultFileError, SemiwearError
from semiwear.scatter.command import SCATTER, prepare_study
from semiwear.sweep.files import open_sweep
from semiwear.sweep.page import write_sweep_report
from semiwear.sweep.study_file import Study, read_study
from tests.scenes import SHIPPED
from tests.strategies.results import synthetic_tree

outcome, page_module = import_module("semiwear.sweep.outcome"), import_module("semiwear.sweep.page")
TORQUE, OFFSET = "operation.pinion_torque_Nm", "effects.misalignment.offset_mm"
STUDY = """
scene = "face_gear_25x160"
measure = "history"

[set]
wear.until.control_depths_um = [2, 4]
"effects.flash_temperature" = {}
effects.friction = {law = "constant"}
operation.pinion_speed_rpm = 1000

[vary]
operation.pinion_torque_Nm = {from = 800, to = 1600, count = 3}
effects.misalignment.offset_mm = [-0.1, 0, 0.1]
effects.modification.pinion = ["none", {tip_relief_um = 20}]
"""


@pytest.fixture
def solved(monkeypatch):
    scenes = []
    whole = synthetic_tree(3, profiles=4, faces=3, mesh_positions=3)
    made_up = {name: whole[name].to_dataset() for name in ("history", "life")}

    def simulate(scene):
        scenes.append(scene)
        torque, misaligned = scene.operation.pinion_torque_Nm, scene.effects.misalignment
        if torque == 1600 and misaligned is not None and misaligned.offset_mm == 0.1:
            raise ConvergenceError("load <sharing> stopped")
        shift = 1.0 + (misaligned.offset_mm if misaligned else 0.0)
        return xr.DataTree.from_dict(made_up | {"history": made_up["history"] * torque * shift})

    monkeypatch.setattr(outcome, "simulate", simulate)
    monkeypatch.setattr(outcome, "simulate_as_given", lambda scene, **_: outcome.simulate(scene))
    monkeypatch.setattr(page_module, "QUANTITIES", ("meshes", "root_stress_max"))  # a page draws for seconds
    return scenes


@pytest.fixture
def study(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path


def read(path: str | Path, further: tuple[str, ...] = ()) -> Study:
    problems: list[Problem] = []
    found = read_study(path, further, problems)
    assert found is not None and not problems
    return found


def test_a_study_file_says_what_a_call_would(study):
    found = read("study.toml")
    assert found.scene.operation.pinion_speed_rpm == 1000 and found.scene.effects.friction.law == "constant"
    assert found.scene.effects.flash_temperature is not None
    assert found.vary == {
        TORQUE: [800.0, 1200.0, 1600.0],
        OFFSET: [-0.1, 0, 0.1],
        "effects.modification.pinion": [None, {"tip_relief_um": 20}],
    }
    assert found.options == {"measure": "history"}


def test_a_scene_lies_beside_its_study(study):
    (study / "inner").mkdir()
    (study / "inner" / "mine.toml").write_text(SHIPPED.replace({TORQUE: 777.0}).to_toml())
    (study / "inner" / "study.toml").write_text(f'scene = "mine.toml"\n[vary]\n{OFFSET} = [0.1]\n')
    assert read("inner/study.toml").scene.operation.pinion_torque_Nm == 777.0


@pytest.mark.parametrize(
    "text, parts",
    [
        (
            'sceen = "a"\nscene = "spur_fzg_d"\n[vary]\na = {from = 1}',
            ("did you mean scene?", "spur_fzg_c", "vary.a"),
        ),
        ("[vary]\n", ('write scene = "face_gear',)),
        ('scene = "spur_fzg_c"\n[sweep]\na = [1]\n[ste]\nb = 2', ("did you mean [vary]?", "did you mean [set]?")),
        ('scene = "spur_fzg_c"\nvary = 3\n[set]\nnumerics.threads = 0', ("[vary]", "numerics.threads")),
        ("scene = ", ("line 1",)),
    ],
)
def test_what_is_wrong_with_a_file_is_told_at_once(study, text, parts):
    (study / "bad.toml").write_text(text)
    problems: list[Problem] = []
    read_study("bad.toml", (), problems)
    for part in parts:
        assert part in "; ".join(map(str, problems))


def test_a_study_without_fields_says_what_to_write_in_it(study, solved, capsys):
    (study / "bare.toml").write_text('scene = "spur_fzg_c"\n')
    assert main(["sweep", "bare.toml", "-o", "x.nc"]) == 2
    assert "= [800, 1600] under the header [vary]" in capsys.readouterr().err and not solved


@pytest.mark.parametrize("command", ["sweep", "optimise", "infer"])
def test_a_scene_in_place_of_a_study_is_one_problem(study, solved, capsys, command):
    (study / "mine.toml").write_text(sw.load_scene("spur_fzg_c").to_toml())
    ending = "toml" if command == "optimise" else "nc"
    assert main([command, "mine.toml", "-o", f"x.{ending}"]) == 2
    told = capsys.readouterr().err
    assert "1 problem\n" in told and 'scene = "mine.toml"' in told and not solved


@pytest.mark.parametrize(("table", "command"), [("vary", "sweep"), ("design", "optimise"), ("unknown", "infer")])
def test_a_study_in_place_of_a_scene_is_one_problem(study, capsys, table, command):
    (study / "mine.toml").write_text(f'scene = "spur_fzg_c"\n[{table}]\n{TORQUE} = [1, 2]\n')
    assert main(["check", "mine.toml"]) == 2
    told = capsys.readouterr().err
    assert "1 problem\n" in told and f"semiwear {command} mine.toml" in told


def test_nothing_varied_is_told_in_one_place(study, solved, capsys):
    with pytest.raises(sw.SceneError) as raised:
        sw.sweep(sw.load_scene("spur_fzg_c"), {})
    (problem,) = raised.value.problems
    assert f"1 problem\n  1. {problem}" in problems_in(study, 'scene = "spur_fzg_c"\n', capsys)
    told = problems_in(study, 'scene = "spur_fzg_c"\nvary = 3\n', capsys)
    assert "1 problem\n  1. vary: found 3" in told and not solved


def test_problems_of_file_fields_and_options_come_together(study, solved, capsys):
    (study / "bad.toml").write_text(
        "sampels = 3\n" + STUDY.replace("[-0.1, 0, 0.1]", "[-9]").replace('"history"', '"hystory"')
    )
    assert main(["sweep", "bad.toml", "-o", "x.txt", "--report", "y.pdf", "--workers", "-3"]) == 2
    told = capsys.readouterr().err
    for part in (
        "6 problems",
        "did you mean samples?",
        "call it x.nc",
        "call it y.html",
        "entry 1 of 1",
        "history?",
        "workers: found '-3'",
    ):
        assert part in told
    assert not solved and not list(study.glob("x*"))


def run(*more):
    return main(["sweep", "study.toml", "-o", "study.nc", "--workers", "0", *more])


def test_the_command_writes_a_dataset_and_a_page(study, solved, unseen, capsys):
    assert run("--report", "study.html") == 0
    told = capsys.readouterr().out
    assert "18 scenes: 16 done, 2 failed" in told and "offset_mm = 0.1" in told and "load <sharing> stopped" in told
    found = open_sweep("study.nc")
    assert found["status"].shape == (3, 3, 2)
    page = (study / "study.html").read_text()
    assert "load &lt;sharing&gt; stopped" in page and page.count("<img") == 6


def test_solved_scenes_are_only_replaced_when_asked(study, solved, capsys):
    small = STUDY.replace("[-0.1, 0, 0.1]", "[0.1]")
    (study / "study.toml").write_text(small)
    assert run() == 0
    count = len(solved)
    assert run() == 2
    assert "study.nc.scenes holds 6 solved scenes" in capsys.readouterr().err
    (study / "study.toml").write_text(small.replace("count = 3", "count = 5"))
    assert run("--resume") == 0
    assert len(solved) == count + 4
    assert main(["sweep", "study.toml", "-o", "study.zarr", "--workers", "0"]) == 0
    one, other = open_sweep("study.nc"), open_sweep("study.zarr")
    np.testing.assert_array_equal(one["meshes"], other["meshes"])


def test_a_scheduler_that_does_not_answer_is_told(study, solved, capsys, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(import_module("semiwear.sweep.command"), "_ANSWER", 0.5)
    assert main(["sweep", "study.toml", "-o", "a.nc", "--scheduler", "tcp://127.0.0.1:9"]) == 2
    assert "no Dask scheduler answers" in capsys.readouterr().err
    assert main(["sweep", "study.toml", "-o", "a.nc", "--scheduler", "x", "--workers", "2"]) == 2
    assert "leave one of them out" in capsys.readouterr().err


@pytest.mark.parametrize("output", ["study.toml", "nowhere/study.nc"])
def test_outputs_take_no_ones_place(study, solved, output, capsys):
    assert main(["sweep", "study.toml", "-o", output, "--workers", "0"]) == 2
    assert not solved and (study / "study.toml").read_text() == STUDY


def test_a_result_of_one_scene_is_no_sweep(study):
    sw.save(synthetic_tree(2), "one.nc")
    with pytest.raises(ResultFileError, match="no sweep"):
        open_sweep("one.nc")


# ---------------------------------------------------------------------- pictures and pages


class Checker(HTMLParser):
    """Tags that are open, and what is loaded from elsewhere."""

    def __init__(self):
        super().__init__()
        self.open, self.foreign = [], []

    def handle_starttag(self, tag, attrs):
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)
        self.foreign += [v for name, v in attrs if name in ("src", "href") and not v.startswith(("data:", "#"))]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


VARIED = {
    "one field": {TORQUE: [800, 1200, 1600]},
    "text": {"operation.loaded_flank": ["drive", "coast"], TORQUE: [800, 1600]},
    "three fields": {TORQUE: [800, 1600], OFFSET: [0.0, 0.1], "effects.friction": [None, {}]},
    "samples": pd.DataFrame({TORQUE: [800, 1200, 1600], "operation.loaded_flank": ["drive", "coast", "drive"]}),
    "one scene": {TORQUE: [800]},
    "none": {TORQUE: [1600], OFFSET: [0.1]},
}


@pytest.mark.parametrize("name", VARIED)
def test_a_page_is_whole_and_stands_alone(solved, tmp_path, name, request):
    if name != "one field":  # pixels of one page will do
        request.getfixturevalue("unseen")
    found = sw.sweep(SHIPPED, VARIED[name], workers=0)
    checker = Checker()
    checker.feed(write_sweep_report(found, tmp_path / "page.html").read_text())
    assert checker.open == [] and checker.foreign == []


def test_pictures_hold_the_values_at_the_end_of_each_run(solved):
    found = sw.sweep(SHIPPED, {TORQUE: [1600, 800], OFFSET: [-0.1, 0.0, 0.1]}, workers=0)
    ax = sw.plot.sweep_curves(found, "root_stress_max", over="offset_mm", body="pinion")
    lines = [line for line in ax.lines if line.get_label() != "failed"]
    last = found["root_stress_max"].isel(wear_step=-1).sel(body="pinion")
    for line, torque in zip(lines, (1600, 800), strict=True):
        np.testing.assert_array_equal(line.get_ydata(), last.sel(pinion_torque_Nm=torque))
    assert [line.get_label() for line in ax.lines][-1] == "failed" and ax.get_xlabel() == "Offset (mm)"
    drawn = sw.plot.sweep_map(found, "root_stress_max", body="pinion")
    assert np.ma.count_masked(drawn.collections[0].get_array()) == 1
    # thousands are written out: 1410, not 1.41e+03
    thousands = found.assign(root_stress_max=4000.0 / last.max() * found["root_stress_max"])
    written = [text.get_text() for text in sw.plot.sweep_map(thousands, "root_stress_max", body="pinion").texts]
    assert written.count("failed") == 1 and not any("e+" in text for text in written)
    told = sorted(float(text) for text in written if text != "failed")
    values = 4000.0 / float(last.max()) * last.values
    assert told == pytest.approx(np.sort(values[np.isfinite(values)]), rel=5e-3)
    with pytest.raises(SemiwearError, match="not varied"):
        sw.plot.sweep_curves(found, "root_stress_max", over="torque")
    with pytest.raises(SemiwearError, match="needs a sweep with"):
        sw.plot.sweep_map(found, "root_stress")
    with pytest.raises(SemiwearError, match="samples"):
        sw.plot.sweep_samples(found, "root_stress_max", "offset_mm")


# ---------------------------------------------------------------------- the guide

GUIDE = (Path(sw.__file__).parents[1] / "docs" / "studies.md").read_text(encoding="utf-8")


def blocks(kind: str) -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", GUIDE, re.DOTALL)


def test_the_study_files_of_the_guide_can_run(tmp_path):
    whole, rest = blocks("toml")
    (tmp_path / "vary.toml").write_text(whole)
    varied = prepare_study(read(tmp_path / "vary.toml", SCATTER), 0)
    assert varied.job.variation.shape == (9, 3, 2) and "/life/meshes_to_limit" in varied.job.measure.variables
    assert "samples = 128\n" in rest
    fewer = rest.replace("samples = 128", "samples = 8")
    (tmp_path / "scatter.toml").write_text('scene = "face_gear_25x160"\n' + fewer)
    drawn = prepare_study(read(tmp_path / "scatter.toml", SCATTER), 0)
    assert drawn.job.variation.count == 8 * 5


def test_the_code_of_the_guide_uses_names_that_there_are():
    names = {name for block in blocks("python") for name in re.findall(r"\bsw\.(\w+)", block)}
    assert {"sweep", "scatter", "measured_load", "usual_wear_coefficient"} <= names
    assert all(hasattr(sw, name) for name in names)


@pytest.mark.slow
def test_the_first_code_of_the_guide_runs(solved, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code = blocks("python")
    real = sw.sweep
    monkeypatch.setattr(sw, "sweep", lambda *given, **options: real(*given, **options, workers=0))
    space: dict = {}
    exec(code[0], space)
    assert space["found"]["status"].shape == (30, 3)
    assert sum(line != "" for line in code[0].splitlines()) == 5


# ---------------------------------------------------------------------- what is wrong with a file, once and well


def problems_in(folder: Path, text: str, capsys, *options: str) -> str:
    (folder / "bad.toml").write_text(text)
    assert main(["sweep", "bad.toml", "-o", "bad.nc", *options]) == 2
    return str(capsys.readouterr().err)


@pytest.mark.parametrize(
    "text, parts",
    [
        ("[vary]\noperation.pinion_torqe_Nm = [1, 2]", ("did you mean pinion_torque_Nm?",)),
        ("[vary.operation]\npinion_torqe_Nm = {from = 1, to = 2, count = 2}", ("did you mean pinion_torque_Nm?",)),
        (f"[set]\noperation.pinion_torqe_Nm = 5\n[vary]\n{TORQUE} = [1]", ("did you mean pinion_torque_Nm?",)),
        (
            '[scatter]\noperation.pinion_torqe_Nm = {distribution = "normal", mean = 1, deviation = 1}',
            ("did you mean pinion_torque_Nm?",),
        ),
        (f"[vary]\n{TORQUE} = {{from = 1, to = {'9' * 401}, count = 3}}", ("vary.operation.pinion_torque_Nm",)),
        (f"[vary]\n{TORQUE} = {{from = 1, cuont = 3}}", ("vary.operation.pinion_torque_Nm",)),
        (f"measure = 5\n[vary]\n{TORQUE} = [1]", ("measure: found 5", "or a list of names")),
        ('[vary]\nwear = ["none"]', ("a table [wear]",)),
        (
            f'[scatter]\n{TORQUE} = {{distribution = "normal", mean = {"9" * 401}, deviation = 1}}',
            ("mean", "a finite number"),
        ),
    ],
)
def test_what_is_wrong_with_fields_is_one_problem(study, solved, capsys, text, parts):
    told = problems_in(study, f'scene = "face_gear_25x160"\n{text}\n', capsys)
    assert "1 problem\n" in told and not solved
    for part in parts:
        assert part in told


def test_fields_are_told_beside_a_scene_that_cannot_be_read(study, solved, capsys):
    """What no kind of gear pair has or allows is; the rest waits for the scene."""
    head = 'scene = "no_such_scene"\n'
    vary = f"[vary]\noperation.pinion_torqe_Nm = [1]\n{TORQUE} = [-1, 5]\neffects.friction = [{{coeficient = 3}}]\n"
    only_some = "gear_pair.helix_angle_deg = [10]\ngear_pair.gear_teeth = [-60]\ngear_pair.pinion_teeth = [3.5]\n"
    told = problems_in(study, head + vary + only_some, capsys)
    assert "6 problems" in told and "helix" not in told and "gear_teeth" not in told and not solved
    for part in (
        "did you mean pinion_torque_Nm?", f"{TORQUE}: found -1", "effects.friction.coefficient: found 3",
        "did you mean coefficient?", "12 to 1000 or ",
    ):  # fmt: skip
        assert part in told
    coefficient = 'wear.coefficient_mm2_per_N = {distribution = "lognormal", low = 1e-14, high = 1e-12}\n'
    scatter = (
        '[scatter]\noperation.pinion_torqe_Nm = {distribution = "norml"}\n'
        f'{TORQUE} = {{distribution = "normal", mean = 5}}\n'
    )
    told = problems_in(study, head + scatter + coefficient, capsys)
    assert "4 problems" in told
    for part in ("did you mean pinion_torque_Nm?", 'did you mean "normal"?', f"{TORQUE}, deviation: missing"):
        assert part in told
    wide = f'[scatter]\n{TORQUE} = {{distribution = "normal", mean = 5, deviation = 50}}\n'
    told = problems_in(study, head + wide + coefficient, capsys)
    assert "2 problems" in told and "cut the distribution off" in told
    told = problems_in(study, head + wide + coefficient.replace("1e-14", "1e-11"), capsys)
    assert "2 problems" in told and "greater than low = 1e-11" in told


@pytest.mark.parametrize("scene", ['scene = "no_such_scene"', "", 'scene = "broken.toml"'])
def test_set_is_told_beside_a_scene_that_cannot_be_read(study, solved, tmp_path, capsys, scene):
    (tmp_path / "broken.toml").write_text("[gear_pair\n")
    fields = f"[set]\noperation.pinion_torqe_Nm = 1\n{TORQUE} = -1\neffects.friction = 'none'\n"
    fields += "effects.misalignment = 5\n"
    told = problems_in(study, f"{scene}\n{fields}gear_pair.gear_teeth = -60\n[vary]\n{OFFSET} = [0, 1]\n", capsys)
    assert "4 problems" in told and not solved
    for part in ("did you mean pinion_torque_Nm?", f"{TORQUE}: found -1", "effects.misalignment: found 5"):
        assert part in told


@pytest.mark.parametrize("scene", ['scene = "no_such_scene"', "", 'scene = "spur_fzg_c"\nset.operation.torqe = 1'])
def test_what_needs_no_scene_is_told_beside_one_that_cannot_be_read(study, solved, capsys, scene):
    head = f'{scene}\nmeasure = "hystory"\n'
    vary = f'combine = "gird"\nwear_states = "lsat"\n[vary]\n{TORQUE} = [1]\n'
    told = problems_in(study, head + vary, capsys, "--workers", "-3")
    assert "5 problems" in told and not solved
    for part in ("history?", '"grid"?', "wear_states", "workers: found '-3'"):
        assert part in told
    scatter = f"samples = 3\nbefore_meshes = -1\n[scatter]\n{TORQUE} = 1\n"
    told = problems_in(study, head + scatter, capsys, "--workers", "-3")
    assert "6 problems" in told
    for part in ("history?", "samples: found 3", "before_meshes", "workers: found '-3'", f"{TORQUE}: found 1"):
        assert part in told
    told = problems_in(study, head + "samples = 3\n", capsys)
    assert "4 problems" in told
    for part in ("history?", "beside a table [scatter]", "under the header [vary]"):
        assert part in told


def test_options_of_a_sweep_are_not_ignored_elsewhere(study, solved, capsys):
    scatter = f'[scatter]\n{TORQUE} = {{distribution = "normal", mean = 1600, deviation = 1}}\n'
    head = 'scene = "face_gear_25x160"\nwear_states = "last"\ncombine = 5\n'
    told = problems_in(study, head + scatter, capsys)
    assert "2 problems" in told and "wear_states" in told and "combine" in told and "beside [scatter]" in told
    (study / "best.toml").write_text(head + f'minimise = "wear_depth_max"\n[design]\n{TORQUE} = [1, 2]\n')
    assert main(["optimise", "best.toml", "-o", "found.toml"]) == 2
    told = capsys.readouterr().err
    assert "2 problems" in told and "wear_states" in told and "combine" in told


@pytest.mark.parametrize("workers", ["\u00b2", "9" * 5000])
def test_odd_numbers_of_processes_are_refused(study, solved, capsys, workers):
    assert "workers" in problems_in(study, STUDY, capsys, "--workers", workers)


@pytest.mark.parametrize("output", [".", "/"])
def test_a_folder_is_no_dataset(study, solved, capsys, output):
    assert main(["sweep", "study.toml", "-o", output]) == 2
    assert main(["report", output]) != 0
    assert "it is a folder" in capsys.readouterr().err and not solved


def test_the_numbers_of_scenes_by_their_ends_are_for_machines_too(study, solved, capsys):
    assert main(["sweep", "study.toml", "-o", "study.nc", "--workers", "0", "--json", "-q"]) == 0
    assert json.loads(capsys.readouterr().out)["scenes"] == {"done": 16, "failed": 2}
