"""A run that is stopped and resumed gives the result of one that was not, bit for bit."""

import errno
import os
import re
import shutil
import subprocess
import sys
import time
from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest

import semiwear as sw
from semiwear.cli import main
from semiwear.contact import line_contact
from semiwear.errors import ConvergenceError, ResultFileError, SceneError
from semiwear.plan import plan
from semiwear.results import checkpoint
from semiwear.results import run_identity as run_identity_module
from semiwear.results.checkpoint import KeptStep, open_checkpoint, peek
from semiwear.results.run_identity import differences, run_identity
from semiwear.wear.kept_state import restored_state, state_arrays
from semiwear.wear.stepping import WearStepper
from tests.same_result import different_variables
from tests.scenes import SMALL

TWO_DEPTHS = SMALL | {"wear.until.control_depths_um": [4.0, 9.0]}
PATCH = {"numerics.fidelity": "patch"}
RIGID = {"numerics.tooth_compliance": "rigid"}  # where a step is one like any other
UNTIL_MESHES = {"wear.until.control_depths_um": None, "wear.until.meshes": 4e8, "wear.control_point": None}
SCENES = {
    # deep enough that candidates are searched farther on the way: forgotten, the last bits differ
    "line": {"wear.until.control_depths_um": [30.0, 60.0, 80.0]},
    "patch": PATCH,
    "patch, marched": PATCH | {"numerics.wear_mapping": "marched"},
    "two stages": {"wear.until.control_depths_um": [30.0, 60.0, 80.0], "numerics.wear_scheme": "two-stage"},
    "both bodies": {"wear.worn_bodies": ["pinion", "gear"]},
    "spectrum": {"effects.load_spectrum": {"torques_Nm": [800.0, 1600.0, 2200.0], "shares": [0.3, 0.5, 0.2]}},
    "friction": {"effects.friction": {}},
    "automatic steps": UNTIL_MESHES,
    "explicit": UNTIL_MESHES
    | {"numerics.wear_scheme": "explicit", "numerics.wear_steps": 2, "wear.until.meshes": 2e6},
}


@pytest.fixture(scope="module")
def small(shipped):
    return shipped.replace(TWO_DEPTHS)


class Stop(Exception):
    pass


class StopAfterOne:
    """Raises when the first wear step of a session is finished."""

    def step(self, done, total, text):
        self.heard = done, total
        raise Stop


@pytest.mark.slow
@pytest.mark.parametrize("kind", SCENES)
def test_stopped_after_every_step_and_resumed(small, tmp_path, kind):
    scene = small.replace(SCENES[kind])
    path = tmp_path / "worn.nc.partial"
    whole = sw.simulate(scene)
    steps = whole["history"].sizes["wear_step"] - 1
    for k in range(steps):
        stop = StopAfterOne()
        with pytest.raises(Stop):
            sw.simulate(scene, checkpoint=path, resume=True, progress=stop)
        assert stop.heard == (k + 1, steps)
    # all steps are there: none is taken again
    assert different_variables(sw.simulate(scene, checkpoint=path, resume=True, progress=stop), whole) == []
    assert peek(path).finished == steps
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_a_state_comes_back_bit_for_bit(small):
    """Also what is not kept but found again."""
    # a pinion at a slope presses with its edge: gaps there depend on the loads on the way
    physics = plan(small.replace(RIGID | SCENES["both bodies"] | {"effects.misalignment.pinion_slope_mrad": 2.0}))
    stepper = physics.wear_stepper(physics.loaded_teeth())
    start = stepper.start()
    state = replace(stepper.step(start, 1e8), error=0.1, stride=(0.2, 0.3), law_residual=0.4)
    plain = stepper.teeth.touch_solved(*state.worn)
    assert not np.array_equal(plain.gap, state.contact.coarse.gap), "no edge is pressed: the test shows nothing"
    back = restored_state(stepper, state_arrays(state))
    for name in ("meshes", "pace", "error", "stride", "law_residual"):
        assert getattr(back, name) == getattr(state, name)
    assert (state.volume.driven > 0.0).all()
    for name in ("driven", "on_edges"):
        assert getattr(back.volume, name).tobytes() == getattr(state.volume, name).tobytes()
    assert back.contact.edge_residual == state.contact.edge_residual > 0.0
    for part in ("touched", "coarse", "loads"):
        one, other = getattr(state.contact, part), getattr(back.contact, part)
        for entry in fields(one):
            if entry.name not in ("removed", "nearer"):  # nearer: of the trials of a wear law alone
                assert getattr(one, entry.name).tobytes() == getattr(other, entry.name).tobytes(), entry.name
    assert back.contact.driving_wear.tobytes() == state.contact.driving_wear.tobytes()


@pytest.mark.slow
def test_three_kills(small, tmp_path):
    """The command line, ended by SIGKILL; `python -m validation.kills` does so many times."""
    depths = [2.0 * k for k in range(1, 16)]
    scene = small.replace({"wear.until.control_depths_um": depths})
    (tmp_path / "scene.toml").write_text(scene.to_toml(), encoding="utf-8")
    output, partial = tmp_path / "worn.nc", tmp_path / "worn.nc.partial"
    command = [sys.executable, "-m", "semiwear", "run", tmp_path / "scene.toml", "-o", output, "--resume"]
    for steps in (0, 1, 6):
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            # the unworn state is kept as well; counting files takes no time from the run
            while process.poll() is None and len(list(partial.glob("*.npz"))) <= steps:
                time.sleep(0.002)
            process.kill()
    done = subprocess.run(command, capture_output=True, text=True, timeout=200, check=False)
    assert done.returncode == 0, done.stderr
    assert different_variables(sw.open_results(output), sw.simulate(scene)) == []
    assert not partial.exists()


# ---------------------------------------------------------------------- the folder


IDENTITY = {"scene": 'title = "t"', "semiwear": "1"}


def kept_step(k):
    cells = np.zeros((3, 4))
    cells[1, 2], cells[0, 0] = k + 0.1, -0.0
    return KeptStep(5, {"contact and wear": 0.5 * k}, {"cells": cells, "wear": np.full(3, k)})


def written(path, steps=4):
    with open_checkpoint(path, IDENTITY, resume=False) as kept:
        for k in range(steps):
            kept.add(kept_step(k))
    return path


def test_every_bit_of_a_step_comes_back(tmp_path):
    path = written(tmp_path / "partial")
    with open_checkpoint(path, IDENTITY, resume=True) as kept:
        assert len(kept.steps) == 4
        for k, step in enumerate(kept.steps):
            assert (step.total, step.seconds) == (5, {"contact and wear": 0.5 * k})
            assert step.arrays["cells"].tobytes() == kept_step(k).arrays["cells"].tobytes()
            assert step.arrays["wear"].dtype == kept_step(k).arrays["wear"].dtype
    assert peek(path) == checkpoint.Peek(3, False)


def test_resumed_before_any_step_it_is_still_of_its_run(tmp_path):
    path = written(tmp_path / "partial", 0)
    with open_checkpoint(path, IDENTITY, resume=True) as kept:
        kept.add(kept_step(0))
        kept.add(kept_step(1))
    assert peek(path) == checkpoint.Peek(1, False)


def content(path):
    return {entry.name: entry.read_bytes() for entry in path.iterdir()}


def test_cut_anywhere_a_step_is_computed_again(tmp_path):
    path = written(tmp_path / "partial")
    last, whole = path / "0003.npz", content(path)
    for cut in [*range(0, len(whole[last.name]), 23), len(whole[last.name]) - 1]:
        last.write_bytes(whole[last.name][:cut])
        assert peek(path) == checkpoint.Peek(2, True)
        with open_checkpoint(path, IDENTITY, resume=True) as kept:
            assert len(kept.steps) == 3
            kept.add(kept_step(3))
        # but for the times that an archive holds
        assert set(content(path)) == set(whole)
        assert peek(path) == checkpoint.Peek(3, False)


def test_every_bit_of_a_step_is_guarded(tmp_path):
    """A step is read as it was written, or not at all."""
    path = written(tmp_path / "partial", 2)
    last = path / "0001.npz"
    whole, found = last.read_bytes(), set()
    for place in range(0, len(whole), 7):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << place % 8
        last.write_bytes(damaged)
        steps = checkpoint._steps(path)
        found.add(len(steps))
        if len(steps) == 2:
            for name, values in kept_step(1).arrays.items():
                assert steps[1].arrays[name].tobytes() == values.tobytes(), place
    assert found == {1, 2}  # some bits are those of times and attributes


def test_a_damaged_step_and_those_behind_it_are_computed_again(tmp_path):
    path = written(tmp_path / "partial")
    damaged = path / "0002.npz"
    whole = bytearray(damaged.read_bytes())
    whole[len(whole) // 2] ^= 1
    damaged.write_bytes(whole)
    assert peek(path) == checkpoint.Peek(1, True)
    with open_checkpoint(path, IDENTITY, resume=True) as kept:
        assert len(kept.steps) == 2
        assert sorted(content(path)) == ["0000.npz", "0001.npz", "run.json"]


def test_an_unworn_state_of_another_run_is_nothing_that_is_lost(tmp_path):
    path, other = written(tmp_path / "partial", 1), IDENTITY | {"semiwear": "2"}
    with open_checkpoint(path, other, resume=True) as kept:
        assert kept.steps == ()
        kept.add(kept_step(0))
        kept.add(kept_step(1))
    assert peek(path) == checkpoint.Peek(1, False) and checkpoint._identity(path) == other


def test_more_than_ten_thousand_states_are_removed_with_the_others(tmp_path):
    """As many steps as a scene may ask for, and the unworn state: the last file has five digits."""
    path = written(tmp_path / "partial", 2)
    last = path / "10000.npz"
    last.write_bytes((path / "0001.npz").read_bytes())
    with open_checkpoint(path, IDENTITY, resume=True):
        assert sorted(content(path)) == ["0000.npz", "0001.npz", "run.json"]
    last.write_bytes(b"")
    checkpoint.remove_checkpoint(path)
    assert not path.exists()


def test_an_earlier_run_is_replaced_by_a_finished_step_only(tmp_path):
    path = written(tmp_path / "partial")
    before = content(path)
    with open_checkpoint(path, IDENTITY, resume=False) as kept:
        kept.add(kept_step(0))
        assert content(path) == before
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]
    written(path, 2)
    assert peek(path) == checkpoint.Peek(1, False)


@pytest.mark.parametrize("call", ["replace", "fsync", "unlink"])
def test_killed_anywhere_states_are_never_of_two_runs(tmp_path, monkeypatch, call):
    """Each system call in turn is the last one of a run that replaces another."""
    other = IDENTITY | {"semiwear": "2"}
    real, found = getattr(os, call), set()
    for last in range(12):
        path, left = written(tmp_path / f"partial {last}"), last

        def die(*arguments, **options):
            nonlocal left
            left -= 1
            if left < 0:
                raise KeyboardInterrupt
            return real(*arguments, **options)

        monkeypatch.setattr(os, call, die)
        try:
            with open_checkpoint(path, other, resume=False) as kept:
                for k in range(3):
                    kept.add(replace(kept_step(k), total=99))
        except KeyboardInterrupt:
            pass
        monkeypatch.undo()
        identity = checkpoint._identity(path) if (path / "run.json").exists() else None
        totals = {step.total for step in checkpoint._steps(path)}
        assert identity == (other if totals == {99} else IDENTITY if totals else identity)
        assert len(totals) <= 1
        found |= totals
        with open_checkpoint(path, other, resume=False) as kept:  # and nothing stands in the way of the next
            kept.add(kept_step(0))
    assert 99 in found


def test_two_runs_do_not_share_a_checkpoint(tmp_path):
    pytest.importorskip("fcntl")
    path = written(tmp_path / "partial")
    with open_checkpoint(path, IDENTITY, resume=True):
        for resume in (True, False):
            with pytest.raises(ResultFileError, match="another run is writing"):
                open_checkpoint(path, IDENTITY, resume=resume)
    open_checkpoint(path, IDENTITY, resume=True).close()


def test_a_full_disk_leaves_the_steps_before(tmp_path, monkeypatch):
    path = tmp_path / "partial"
    with open_checkpoint(path, IDENTITY, resume=False) as kept:
        kept.add(kept_step(0))
        kept.add(kept_step(1))

        def full(_):
            raise OSError(errno.ENOSPC, "No space left on device")

        monkeypatch.setattr(os, "fsync", full)
        with pytest.raises(ResultFileError, match=r"No space left.* 1 wear steps, is kept: make room, .*--resume"):
            kept.add(kept_step(2))
    monkeypatch.undo()
    assert peek(path).finished >= 1


# ---------------------------------------------------------------------- of which run


@cache
def identity_of(toml):
    return run_identity(toml)


def changed(scene, changes, finished=1):
    return differences(identity_of(scene.to_toml()), identity_of(scene.replace(changes).to_toml()), finished)


def test_what_differs_is_named(small):
    assert changed(small, {}) == []
    assert changed(small, {"numerics.face_slices": 17}) == ["numerics.face_slices: 15 in the checkpoint, 17 now"]
    assert changed(small, {"effects.free_edges": {}})
    assert len(changed(small, {"numerics.face_slices": 17, "operation.pinion_torque_Nm": 800.0})) == 2
    now = identity_of(small.to_toml())
    for name in ("numpy", "semiwear", "semiwear's code"):
        assert differences(now | {name: "0"}, now, 1) == [f"{name}: 0 in the checkpoint, {now[name]} now"]


def test_comments_of_the_code_may_change_and_what_divides_a_run_into_steps_may_not(tmp_path, small, monkeypatch):
    package = tmp_path / "semiwear"
    shutil.copytree(sw.__path__[0], package, ignore=shutil.ignore_patterns("__pycache__", "*.nbc", "*.nbi"))
    monkeypatch.setattr(run_identity_module, "_PACKAGE", package)
    scene = small.to_toml()
    before = run_identity(scene)

    def now(path, change):
        file = package / path
        text = file.read_text(encoding="utf-8")
        file.write_text(change(text), encoding="utf-8")
        try:
            return run_identity(scene)
        finally:
            file.write_text(text, encoding="utf-8")

    def without_comments(text):
        return re.sub(r"(?m)^ *#.*\n|  #[^'\"\n]*$", "", text)

    for path in ("wear/stepping.py", "contact/patch_system.py", "simulate.py"):
        assert now(path, lambda text: "# what follows is old\n" + text) == before
        assert now(path, without_comments) == before
        assert now(path, lambda text: text + "\n_MORE = 1\n") != before
    assert now("closed_forms/hertz.py", lambda text: text.replace("(4.0, line_load)", "(5.0, line_load)")) != before
    assert now("report/page.py", lambda text: text + "\n_MORE = 1\n") == before


def test_what_finished_steps_do_not_depend_on_may_change(small):
    assert changed(small, {"title": "other", "numerics.threads": 1}) == []
    assert changed(small, {"wear.until.control_depths_um": [4.0, 7.0, 8.0]}) == []
    assert changed(small, {"wear.until.control_depths_um": [4.0, 7.0, 8.0]}, finished=2)
    assert changed(small, {"wear.until.control_depths_um": [4.0]}, finished=2)
    assert changed(small, {"numerics.max_iterations": 99}) == []
    assert changed(small, {"numerics.max_iterations": 20})
    assert changed(small.replace(PATCH), {"numerics.max_iterations": 99})


def test_a_checkpoint_is_of_the_scene_under_which_its_last_step_was_added(tmp_path, small):
    first = run_identity(small.to_toml())
    farther = run_identity(small.replace({"wear.until.control_depths_um": [4.0, 12.0]}).to_toml())
    path = tmp_path / "partial"
    for identity, steps in ((first, (0, 1)), (farther, (2,))):
        with open_checkpoint(path, identity, resume=True) as kept:
            for k in steps:
                kept.add(kept_step(k))
    with pytest.raises(ResultFileError, match="control_depths_um"):
        open_checkpoint(path, first, resume=True)
    with open_checkpoint(path, farther, resume=True) as kept:
        assert len(kept.steps) == 3


def test_a_file_that_the_scene_names_belongs_to_the_run(tmp_path):
    grid = tmp_path / "grid.csv"
    scene = f'[effects.modification.gear]\nfile = "{grid.as_posix()}"\n'
    grid.write_text("1", encoding="utf-8")
    before = run_identity(scene)
    grid.write_text("2", encoding="utf-8")
    assert [line.split(":")[0] for line in differences(before, run_identity(scene), 1)] == [
        f"content of {grid.as_posix()}"
    ]


def test_another_run_is_refused_and_left_alone(small, tmp_path):
    small, path = small.replace(RIGID), tmp_path / "partial"
    with pytest.raises(Stop):
        sw.simulate(small, checkpoint=path, progress=StopAfterOne())
    before = content(path)
    with pytest.raises(ResultFileError) as caught:
        sw.simulate(small.replace({"numerics.max_iterations": 20}), checkpoint=path, resume=True)
    for words in ("partial", "1 finished wear steps are of another run", "max_iterations: 60 in", "20 now", "undo"):
        assert words in str(caught.value)
    assert "delete the folder, or run without --resume" in str(caught.value)
    assert content(path) == before


@pytest.mark.slow
def test_a_run_goes_on_to_other_depths(small, tmp_path):
    path = tmp_path / "partial"
    sw.simulate(small, checkpoint=path)
    farther = small.replace({"wear.until.control_depths_um": [4.0, 9.0, 12.0], "title": "farther"})
    tree = sw.simulate(farther, checkpoint=path, resume=True)
    assert different_variables(tree, sw.simulate(farther)) == []
    with pytest.raises(ResultFileError, match="control_depths_um"):
        sw.simulate(small, checkpoint=path, resume=True)  # its third step is of the other scene now


def test_resume_needs_a_checkpoint(small):
    with pytest.raises(SceneError, match="give checkpoint=FOLDER"):
        sw.simulate(small, resume=True)


# ---------------------------------------------------------------------- command line


@pytest.mark.slow
def test_a_step_that_fails_leaves_the_steps_before(small, tmp_path, monkeypatch, capsys):
    scene, output = tmp_path / "scene.toml", tmp_path / "worn.nc"
    scene.write_text(small.to_toml(), encoding="utf-8")
    step = WearStepper.step_to_depth

    def fail(self, state, point, depth):
        if state.meshes > 0:
            raise ConvergenceError(
                "load sharing stopped at mesh position 3/8: raise numerics.max_iterations above 60"
            )
        return step(self, state, point, depth)

    monkeypatch.setattr(WearStepper, "step_to_depth", fail)
    assert main(["run", str(scene), "-o", str(output)]) == 2
    told = capsys.readouterr().err
    for words in (
        "mesh position 3/8",
        "raise numerics.max_iterations",
        "1 wear step was finished",
        "worn.nc.partial",
        "--resume",
    ):
        assert words in told
    assert sw.open_results(output)["history"].sizes["wear_step"] == 2
    monkeypatch.undo()
    assert main(["run", str(scene), "-o", str(output), "--resume", "--set", "numerics.max_iterations=20"]) == 2
    assert "numerics.max_iterations: 60 in the checkpoint, 20 now" in capsys.readouterr().err
    (tmp_path / ".worn.nc.0123.part").write_bytes(b"what a run killed as it saved leaves")
    assert main(["run", str(scene), "-o", str(output), "--resume", "--set", "numerics.max_iterations=90"]) == 0
    assert "worn.nc.partial: 1 finished wear steps" in capsys.readouterr().err
    more = small.replace({"numerics.max_iterations": 90})
    assert different_variables(sw.open_results(output), sw.simulate(more)) == []
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["scene.toml", "worn.nc"]


def test_the_command_line_tells_what_lies_there(small, tmp_path, monkeypatch, capsys):
    def stop(*_, **__):
        raise KeyboardInterrupt

    scene, output = tmp_path / "scene.toml", tmp_path / "worn.nc"
    scene.write_text(small.replace(RIGID).to_toml(), encoding="utf-8")
    monkeypatch.setattr(line_contact, "_solve_position", stop)
    assert main(["run", str(scene), "-o", str(output), "--resume"]) == 130
    told = capsys.readouterr().err
    assert "no steps in " in told and "worn.nc.partial: starting from the beginning" in told
    # no wear step was finished, so none is kept
    assert "kept in" not in told and "--resume continues" not in told
    monkeypatch.undo()
    finished = WearStepper.step_to_depth

    def stop_after_one(stepper, state, *arguments):
        if state.meshes > 0.0:
            raise KeyboardInterrupt
        return finished(stepper, state, *arguments)

    monkeypatch.setattr(WearStepper, "step_to_depth", stop_after_one)
    assert main(["run", str(scene), "-o", str(output)]) == 130
    assert "1 finished wear steps are kept in" in capsys.readouterr().err
    assert main(["run", str(scene), "-o", str(output)]) == 130
    assert "of an earlier run, from which --resume continues; this run starts anew" in capsys.readouterr().err
    assert main(["run", str(scene), "--resume"]) == 2
    assert "add -o FILE" in capsys.readouterr().err
