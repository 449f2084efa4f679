"""What is written: refused before computing where it would destroy or lie, kept whatever fails afterwards."""

import os
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import semiwear as sw
from semiwear import cli
from semiwear.commands import simulation
from semiwear.errors import ConvergenceError, SceneError, SemiwearError
from semiwear.geometry.point_grid import read_point_grid
from semiwear.meshing.deviation_grid import write_deviation_grid
from semiwear.report.evidence import Evidence, NotComparable
from semiwear.targets import RESULTS, file_target, target_problems
from tests.strategies.results import synthetic_tree

TREE = synthetic_tree(2)
SCENE = "face_gear_25x160"


@pytest.fixture
def quick(monkeypatch):
    """Runs that take no time, and a note of whether one began."""
    began = []

    def simulate(scene, **_):
        began.append(scene)
        return TREE

    monkeypatch.setattr(sw, "simulate", simulate)
    return began


def run(capsys, *arguments) -> tuple[int, str, str]:
    status = cli.main([str(word) for word in arguments])
    told = capsys.readouterr()
    return status, told.out, told.err


# ---------------------------------------------------------------------- refused before computing


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a scene, links and what is no plain file; the present one."""
    monkeypatch.chdir(tmp_path)
    Path("scene.toml").write_text(sw.load_scene(SCENE).to_toml(), encoding="utf-8")
    Path("scene.nc").write_bytes(Path("scene.toml").read_bytes())
    Path("link.nc").symlink_to("scene.nc")
    Path("hard.nc").hardlink_to("scene.nc")
    Path("hose.nc").symlink_to("pipe.nc")
    Path("folder.nc").mkdir()
    os.mkfifo("pipe.nc")
    Path("page.html").symlink_to("worn.nc")
    Path("steps.nc.partial").write_bytes(Path("scene.toml").read_bytes())
    return tmp_path


REFUSED = {
    "the scene": (["run", "scene.nc", "-o", "scene.nc"], "the scene is that file"),
    "the scene by another path": (["run", "scene.nc", "-o", "../{name}/scene.nc"], "the scene is that file"),
    "a link to the scene": (["run", "scene.nc", "-o", "link.nc"], "the scene is that file"),
    "the scene by another name": (["run", "scene.nc", "-o", "hard.nc"], "the scene is that file"),
    "a scene in the checkpoint's place": (["run", "steps.nc.partial", "-o", "steps.nc"], "the scene is that file"),
    "the report": (["run", SCENE, "-o", "worn.nc", "--report", "page.html"], "-o is that file"),
    "a link to a pipe": (["run", SCENE, "-o", "hose.nc"], "a device or a pipe"),
    "a pipe": (["run", SCENE, "-o", "pipe.nc"], "a device or a pipe"),
    "a folder": (["run", SCENE, "-o", "folder.nc"], "it is a folder"),
    "no name": (["run", SCENE, "-o", ""], "the name of a file"),
    "another kind of file": (["run", SCENE, "-o", "worn.csv"], "call it worn.nc"),
    "a report of another kind": (["run", SCENE, "--report", "worn.pdf"], "call it worn.html"),
    "what a report reads": (["report", "worn.html", "-o", "worn.html"], "FILE is that file"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_an_output_that_would_destroy_is_refused_before_computing(name, folder, capsys, quick):
    arguments, words = REFUSED[name]
    before = {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    status, _, error = run(capsys, *(word.format(name=folder.name) for word in arguments))
    assert (status, quick) == (2, [])
    assert words in error
    assert {path: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before


def test_a_file_that_the_scene_reads_is_no_output(tmp_path, capsys, quick):
    flank = tmp_path / "gear.nc"
    even = np.linspace(0.0, 1.0, 5)
    write_deviation_grid(flank, even, even, np.zeros((5, 5)))
    change = f"effects.modification.gear.file={flank}"
    status, _, error = run(capsys, "run", SCENE, "--set", change, "-o", flank)
    assert (status, quick) == (2, [])
    assert "effects.modification.gear.file is that file" in error


@pytest.mark.parametrize("path", ["/dev/null", "/dev/stdout", "/dev/full"])
def test_a_device_is_no_file(path):
    with pytest.raises(SceneError, match=r"a device or a pipe|call it"):
        file_target("-o", path, RESULTS)


@pytest.mark.skipif(not Path("/dev/fd").exists(), reason="open files have no names here")
def test_a_pipe_without_a_name_is_no_file():
    reading, writing = os.pipe()
    with pytest.raises(SceneError, match="a device or a pipe: give a plain file"):
        file_target("-o", f"/dev/fd/{writing}", RESULTS)
    os.close(reading)
    os.close(writing)


def test_what_a_stopped_run_keeps_is_told_only_where_it_keeps_something(tmp_path, capsys, monkeypatch):
    def stops(scene, **_):
        raise ConvergenceError("no convergence", synthetic_tree(steps))

    monkeypatch.setattr(sw, "simulate", stops)
    steps = 1
    assert run(capsys, "run", "spur_fzg_c", "-o", tmp_path / "a.nc")[0] == 2
    assert "--resume" not in run(capsys, "run", "spur_fzg_c", "-o", tmp_path / "a.nc")[2]
    steps = 3
    told = run(capsys, "run", "spur_fzg_c", "-o", tmp_path / "a.nc")[2]
    assert "2 finished wear steps are kept in" in told
    assert "control_depths_um" not in told
    assert "control_depths_um" in run(capsys, "run", SCENE, "-o", tmp_path / "a.nc")[2]


@pytest.mark.parametrize("name", ["x.csv", "x.zarr", "x", "x.html"])
def test_results_are_saved_under_true_names(name, tmp_path):
    with pytest.raises(SemiwearError, match=r"netCDF"):
        sw.save(TREE, tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["x.pdf", "x.nc", "x"])
def test_reports_are_written_under_true_names(name, tmp_path):
    with pytest.raises(SemiwearError, match="HTML"):
        sw.report(TREE, tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_may_not_be_written_is_told_before_anything_runs(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)
    (problem,) = target_problems("-o", tmp_path / "a.nc", lambda field, path: file_target(field, path, RESULTS))
    assert "can be written" in problem.allowed and "give another" in problem.fix


def test_of_a_link_what_it_points_to_is_replaced(tmp_path):
    (tmp_path / "disk").mkdir()
    link = tmp_path / "worn.nc"
    link.symlink_to(tmp_path / "disk" / "result.nc")
    sw.save(TREE, link)
    assert link.is_symlink()
    assert sw.open_results(tmp_path / "disk" / "result.nc").identical(TREE)


# ---------------------------------------------------------------------- nothing is lost


def test_a_result_is_on_disk_whatever_its_table_or_report_does(tmp_path, capsys, quick, monkeypatch):
    def fails(*_, **__):
        raise ZeroDivisionError

    monkeypatch.setattr(sw, "report", fails)
    path = tmp_path / "worn.nc"
    with pytest.raises(ZeroDivisionError):
        run(capsys, "run", SCENE, "-o", path, "--report", tmp_path / "worn.html")
    assert sw.open_results(path).identical(TREE)
    path.unlink()
    with pytest.raises(ZeroDivisionError):
        run(capsys, "run", SCENE, "--report", tmp_path / "worn.html")
    assert sw.open_results(path).identical(TREE)
    monkeypatch.setattr(simulation, "wear_table", fails)
    path.unlink()
    with pytest.raises(ZeroDivisionError):
        run(capsys, "run", SCENE, "-o", path)
    assert sw.open_results(path).identical(TREE)


QUICK = """
import sys
import semiwear as sw
from matplotlib import figure
from semiwear import cli
from semiwear.report import pictures
from tests.strategies.results import synthetic_tree
def simulate(scene, progress=None, **_):
    for k in range(200):
        progress.step(k + 1, 200, "a step")
    return synthetic_tree(2)
sw.simulate = simulate
figure.Figure.savefig = lambda *_, **__: None
pictures.PICTURES = pictures.PICTURES[:2]
sys.exit(cli.main(sys.argv[1:]))
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="pipes and devices of POSIX")
@pytest.mark.parametrize("stream", ["pipe", "/dev/full"])
def test_a_broken_pipe_and_a_full_standard_output_lose_nothing(stream, tmp_path):
    path, page = tmp_path / "worn.nc", tmp_path / "worn.html"
    if stream == "pipe":
        reading, writing = os.pipe()
        os.close(reading)
    else:
        writing = os.open(stream, os.O_WRONLY)
    command = [sys.executable, "-c", QUICK, "run", SCENE, "-o", str(path), "--report", str(page)]
    done = subprocess.run(command, stdout=writing, stderr=writing, check=False)
    os.close(writing)
    assert done.returncode == (0 if stream == "pipe" else 2)
    sw.open_results(path)
    assert page.stat().st_size > 1000


@pytest.mark.slow
def test_a_full_disk_names_the_file(tmp_path, unseen):
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2000, limit[1]))
    try:
        with pytest.raises(OSError, match=r"worn\.nc: cannot be written"):
            sw.save(TREE, tmp_path / "worn.nc")
        with pytest.raises(OSError, match=r"worn\.html: cannot be written"):
            sw.report(TREE, tmp_path / "worn.html")
        with pytest.raises(OSError, match=r"flank\.nc: cannot be written"):
            sw.export_flank(sw.load_scene(SCENE), "gear", tmp_path / "flank.nc", points=(9, 9))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
    assert not list(tmp_path.iterdir())


def test_a_result_in_the_place_of_a_scene_is_called_one(tmp_path, capsys):
    path = tmp_path / "worn.nc"
    sw.save(TREE, path)
    for command in ("plan", "run", "screen"):
        status, _, error = run(capsys, command, path)
        assert status == 2
        assert "this is a result of semiwear" in error and "scene_toml" in error


# ---------------------------------------------------------------------- references


def test_a_reference_of_another_kind_of_pair_is_refused_at_load():
    with pytest.raises(SceneError, match=r"reference: found 'seed_paper'.*gear_pair.type = \"face_gear\""):
        sw.load_scene("spur_fzg_c").replace({"reference": "seed_paper"})


def test_figures_are_not_compared_with_those_of_other_teeth():
    paper = {"gear_pair": {"pinion_teeth": 25, "module_mm": 6.35}, "wear": {"control_depth_um": [60]}}
    Evidence(synthetic_tree(3), paper, {"gear_pair": {"pinion_teeth": 25}}).get("flank", "wear_depth")
    other = Evidence(TREE, paper, {"gear_pair": {"pinion_teeth": 30, "module_mm": 6.35}})
    with pytest.raises(NotComparable, match="pinion_teeth = 30, not 25"):
        other.get("flank", "wear_depth")


# ---------------------------------------------------------------------- exported flanks


@pytest.mark.slow
def test_worn_flanks_are_exported_with_their_normals(tmp_path, worn):
    scene = sw.load_scene(SCENE)
    sw.export_flank(scene, "gear", tmp_path / "gear.nc", points=(41, 41), worn=worn)
    grid = read_point_grid(tmp_path / "gear.nc")
    assert grid.normals is not None
    np.testing.assert_allclose(np.linalg.norm(grid.normals, axis=-1), 1.0, rtol=1e-12)
    along, across = np.gradient(grid.points, axis=1), np.gradient(grid.points, axis=0)
    for tangent in (along, across):
        size = np.linalg.norm(tangent, axis=-1)
        assert np.abs(np.sum(tangent * grid.normals, axis=-1) / size)[1:-1, 1:-1].max() < 3e-3
    sw.export_flank(scene, "gear", tmp_path / "new.nc", points=(41, 41))
    fresh = read_point_grid(tmp_path / "new.nc").normals
    assert (np.sum(fresh * grid.normals, axis=-1) > 0.99).all()
    assert np.abs(grid.normals - fresh).max() > 1e-4


def test_a_result_is_no_measured_flank(tmp_path):
    sw.save(TREE, tmp_path / "worn.nc")
    found = read_point_grid(tmp_path / "worn.nc")
    assert "a result of semiwear" in str(found) and "export_flank" in str(found)
