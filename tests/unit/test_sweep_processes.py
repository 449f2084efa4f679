"""Worker processes of a sweep: those that die are replaced, and scenes that kill them lost; solving is made up."""

import os
import pickle
import sys
import time
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import semiwear as sw
from semiwear.errors import SemiwearError
from semiwear.sweep.measure import Measured, measure_of
from semiwear.sweep.outcome import Outcome, Status
from semiwear.sweep.pipe import READY
from semiwear.sweep.scenes import Task
from tests.scenes import SHIPPED, TINY

processes = import_module("semiwear.sweep.processes")
SCENE = SHIPPED.replace({**TINY, "wear.until.control_depths_um": [2, 4]})
TORQUE = "operation.pinion_torque_Nm"
BLANK = "0" * 32
MEASURED = Measured({"/history/load_share_max": np.ones(3), "/history/meshes": np.arange(3.0)})
ANSWER = pickle.dumps(Outcome(BLANK, Status.DONE, "", 1.0, MEASURED), protocol=5)
# answers each task with the same numbers and its own key; loads nothing of semiwear, so that it starts at once
WORKER = f"""
import os, re, signal, struct, sys, time
from pathlib import Path
folder, answers = Path(sys.argv[1]), os.fdopen(os.dup(1), "wb")
def send(content):
    answers.write(struct.pack(">Q", len(content)) + content)
    answers.flush()
(folder / f"process-{{os.getpid()}}").touch()
until = time.monotonic() + 60.0
while (folder / "together").exists() and len(list(folder.glob("process-*"))) < 2 and time.monotonic() < until:
    time.sleep(0.01)
send({pickle.dumps(READY, protocol=5)!r})
while head := sys.stdin.buffer.read(8):
    content = sys.stdin.buffer.read(struct.unpack(">Q", head)[0])
    torque = struct.unpack(">d", re.search(rb"pinion_torque_Nm.{{0,3}}G(.{{8}})", content, re.DOTALL).group(1))[0]
    deaths = folder / f"deaths-{{torque:g}}"
    if deaths.exists() and (left := int(deaths.read_text())):
        deaths.write_text(str(left - 1))
        os.kill(os.getpid(), signal.SIGKILL)
    key = re.search(rb"[0-9a-f]{{32}}", content).group()
    send({ANSWER!r}.replace({BLANK.encode()!r}, key))
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where made-up workers note that they began, and are told how often a torque is to kill them.

    Where a file `together` is, the first of them waits for a second one, which may be late on a machine at work.
    """
    monkeypatch.setattr(processes, "COMMAND", [sys.executable, "-c", WORKER, str(tmp_path)])
    return tmp_path


@pytest.mark.parametrize(("workers", "asked"), [(2, [("both", 2), ("line", 2)]), (1, [])])
def test_kernels_are_compiled_once_while_several_processes_start(folder, monkeypatch, workers, asked):
    compiled = []

    def compile_ahead(*call: object) -> None:
        until = time.monotonic() + 60.0
        while len(began(folder)) < workers:
            assert time.monotonic() < until
            time.sleep(0.01)
        compiled.append(call)

    monkeypatch.setattr(import_module("semiwear.sweep.run"), "compile_ahead", compile_ahead)
    vary = {TORQUE: [800, 900], "wear.worn_bodies": [["gear"], ["pinion", "gear"]]}
    sw.sweep(SCENE, vary, workers=workers)
    assert sorted(compiled) == asked


def began(folder: Path) -> list[int]:
    return [int(file.name.partition("-")[2]) for file in folder.glob("process-*")]


def test_scenes_are_shared_out_among_processes(folder):
    (folder / "together").touch()
    found = sw.sweep(SCENE, {TORQUE: [800, 900, 1000, 1100]}, workers=2)
    assert (found["status"] == 0).all() and (found["load_share_max"] == 1.0).all()
    assert len(began(folder)) == 2
    for process in began(folder):
        with pytest.raises(OSError):
            os.kill(process, 0)  # none is left


def torques(*values: float) -> list[Task]:
    measure = measure_of(None, "all")
    return [Task(f"{value:032.0f}", SCENE.replace({TORQUE: value}), measure) for value in values]


def test_a_crew_keeps_its_processes_from_one_piece_of_work_to_the_next(folder):
    (folder / "together").touch()
    with processes.Crew(2) as crew:
        crew.call()
        for tasks in (torques(800, 900, 1000), torques(1100, 1200)):
            assert {one.key for one in crew.solve(tasks)} == {task.key for task in tasks}
        assert len(began(folder)) == 2
    with pytest.raises(OSError):
        os.kill(began(folder)[0], 0)


def test_a_crew_that_is_helped_has_a_process_less(folder, monkeypatch):
    here = []

    def solve(task: Task) -> Outcome:
        here.append(task.key)
        return Outcome(task.key, Status.DONE, "", 1.0, MEASURED)

    monkeypatch.setattr(processes, "solve_on_one_thread", solve)
    tasks = torques(800, 900, 1000, 1100)
    keys = {task.key for task in tasks}
    for workers in (2, 1):
        here.clear()
        with processes.Crew(workers, helped=True) as crew:
            assert {one.key for one in crew.solve(tasks)} == keys
            assert list(crew.solve([])) == []
        assert len(began(folder)) == 1  # of the first crew alone
        assert here and (workers > 1 or set(here) == keys)


def test_a_crew_that_is_left_midway_works_again(folder):
    with processes.Crew(1) as crew:
        work = crew.solve(torques(800, 900, 1000))
        next(work)
        work.close()
        assert len(list(crew.solve(torques(1100)))) == 1
    assert len(began(folder)) == 2


def test_no_more_processes_than_scenes(folder):
    sw.sweep(SCENE, {TORQUE: [800]}, workers=8)
    assert len(began(folder)) == 1


def test_a_process_that_dies_is_replaced_and_its_scene_tried_again(folder):
    (folder / "deaths-900").write_text("1")
    found = sw.sweep(SCENE, {TORQUE: [800, 900, 1000]}, workers=1)
    assert (found["status"] == 0).all() and (found["message"] == "").all()
    assert len(began(folder)) == 2


def test_a_scene_that_kills_every_process_is_lost_and_stops_nothing(folder):
    (folder / "deaths-900").write_text("99")
    store = folder / "kept"
    found = sw.sweep(SCENE, {TORQUE: [800, 900, 1000]}, workers=1, store=store)
    assert list(found["status"].values) == [Status.DONE, Status.LOST, Status.DONE]
    assert str(found["message"].values[1]).count("SIGKILL") == 2
    assert (folder / "deaths-900").read_text() == "97"
    (folder / "deaths-900").write_text("0")
    again = sw.sweep(SCENE, {TORQUE: [800, 900, 1000]}, workers=1, store=store)
    assert (again["status"] == 0).all()
    assert len(began(folder)) == 4  # of the second sweep, one for the scene that was lost


def test_processes_that_cannot_start_are_an_error(folder, monkeypatch):
    monkeypatch.setattr(processes, "COMMAND", [sys.executable, "-c", "raise SystemExit(3)"])
    with pytest.raises(SemiwearError, match=r"exit status 3.*workers=0"):
        sw.sweep(SCENE, {TORQUE: [800, 900]}, workers=2)


def test_a_sweep_that_is_stopped_leaves_no_process_and_goes_on_from_its_store(folder):
    class Stop:
        def step(self, done, total, text):
            if done == 2:
                raise KeyboardInterrupt

    vary = {TORQUE: [800, 900, 1000, 1100]}
    with pytest.raises(KeyboardInterrupt):
        sw.sweep(SCENE, vary, workers=1, store=folder / "kept", progress=Stop())
    for process in began(folder):
        with pytest.raises(OSError):
            os.kill(process, 0)
    assert 2 <= len(list((folder / "kept").glob("*.npz"))) <= 4
    found = sw.sweep(SCENE, vary, workers=1, store=folder / "kept")
    whole = sw.sweep(SCENE, vary, workers=2)
    assert found.drop_vars("seconds").identical(whole.drop_vars("seconds"))
