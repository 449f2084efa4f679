"""Kernels of a first run are compiled ahead, each by one of several processes, as the list of kernels tells."""

import ast
import inspect
import os
import subprocess
import sys
import threading
from collections import Counter
from importlib import import_module
from pathlib import Path

import pytest
import xarray as xr
from numba import types
from numba.core import event
from numba.core.dispatcher import Dispatcher

import semiwear as sw
from semiwear import compile_ahead as module
from semiwear.compile_ahead import called_by, compile_ahead
from semiwear.kernel_cache import njit
from semiwear.kernel_list import ListedKernel, kernel_list, lines
from semiwear.plan.choices import kernels_of
from tests.same_result import different_variables
from tests.scenes import SHIPPED, TINY, scene_of

ROOT = Path(__file__).parents[2]
BOTH = {"wear.worn_bodies": ("pinion", "gear")}
PATCH = {"numerics.fidelity": "patch"}

# whole numbers and others are searched in one way; what is known when it is compiled costs transforms nothing
FOR_SEVERAL_TYPES = {"first_from", "closed_between", "_join", "_split", "_scale_and_swap"}


def name_of(listed):
    return f"{listed.kernel.py_func.__module__}:{listed.kernel.py_func.__name__}"


def test_every_line_names_a_kernel_with_the_types_that_it_takes():
    kernels = [words for words in lines() if words[0] not in ("structure", "tuple")]
    assert len(kernels) == len(kernel_list())
    for listed in kernel_list():
        assert len(listed.types) == len(inspect.signature(listed.kernel.py_func).parameters), name_of(listed)


def test_no_kernel_stands_before_one_that_it_calls():
    every = kernel_list()
    later = {listed.kernel for listed in every}
    for listed in every:
        later -= {listed.kernel}
        assert not called_by(listed.kernel) & later, name_of(listed)


def test_no_kernel_is_compiled_for_two_types_of_one_thing():
    """Each would be waited for in a first run."""
    counts = Counter(name_of(listed) for listed in kernel_list())
    assert {name.rpartition(":")[2] for name, count in counts.items() if count > 1} <= FOR_SEVERAL_TYPES


@pytest.mark.parametrize(
    ("changes", "run"),
    [({}, "line"), (BOTH, "both"), (PATCH, "patch"), (PATCH | BOTH, "patch"), ({"wear": None}, "contact")],
)
def test_the_list_holds_kernels_of_every_kind_of_run(changes, run):
    assert kernels_of(SHIPPED.replace(changes)) == run
    assert kernels_of(SHIPPED.replace(changes), wears=False) == ("patch" if run == "patch" else "contact")
    assert kernels_of(SHIPPED.replace(changes), wears=True) == ("line" if run == "contact" else run)
    assert any(run in listed.runs for listed in kernel_list())


def listed_pair():
    """A kernel, and one that calls it; they are kept nowhere."""
    one = njit(lambda x: x + 1.0)
    two = njit(lambda x: one(x) + 1.0)
    return [ListedKernel(("line",), True, kernel, (types.float64,)) for kernel in (one, two)]


def is_compiled(listed):
    return bool(listed.kernel.signatures)


@pytest.fixture
def pair(monkeypatch):
    """Two kernels in place of those of a run, of which this process knows nothing yet."""
    kernels = listed_pair()
    monkeypatch.setattr(module, "_ready", set())
    monkeypatch.setattr(module, "kernel_list", lambda run: kernels)
    return kernels


class Helper:
    """In place of a process that has nothing to do."""

    def __init__(self, command, **streams):
        Helper.commands.append(command)

    commands: list[list[str]]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def poll(self):
        return None

    def wait(self):
        pass

    def terminate(self):
        pass


@pytest.fixture
def helpers(monkeypatch):
    Helper.commands = []
    monkeypatch.setattr(subprocess, "Popen", Helper)
    return Helper.commands


@pytest.mark.parametrize(("threads", "count"), [(1, 0), (2, 1), (64, 5)])
def test_a_process_a_thread_but_no_more_than_are_of_use(pair, helpers, threads, count):
    compile_ahead("line", threads)
    assert all(map(is_compiled, pair))
    begin = [sys.executable, "-P", "-m", "semiwear.compile_ahead", "line"]
    assert [command[:5] for command in helpers] == count * [begin]


def test_no_process_where_all_is_kept(pair, helpers):
    for listed in pair:
        listed.kernel(1.0)
    compile_ahead("line", 2)
    assert helpers == []


def test_one_kernel_from_the_end_tells_that_some_are_missing(pair, helpers, monkeypatch):
    """The others wait for the processes that are about to begin: it is one on which little waits."""
    known = []
    monkeypatch.setattr(module, "_compile_in_processes", lambda *_: known.extend(map(is_compiled, pair)))
    pair.append(listed_pair()[0])
    compile_ahead("line", 2)
    assert known == [False, False, True]


def test_nothing_is_looked_for_twice(pair, helpers, monkeypatch):
    compile_ahead("line", 2)
    monkeypatch.setattr(module, "kernel_list", None)
    compile_ahead("line", 2)
    assert len(helpers) == 1


def test_a_process_that_cannot_start_stops_nothing(pair, monkeypatch):
    def fails(*_, **__):
        raise OSError("no more processes")

    monkeypatch.setattr(subprocess, "Popen", fails)
    compile_ahead("line", 2)
    assert pair[1].kernel(1.0) == 3.0


def test_types_that_are_not_so_any_more_stop_nothing(pair):
    other = ListedKernel(("line",), True, pair[0].kernel, (types.none,))
    pair.insert(0, other)
    compile_ahead("line", 1)
    assert [is_compiled(listed) for listed in pair[1:]] == [True, True]


def test_lines_that_are_not_so_any_more_are_left_out(monkeypatch):
    told = [
        "line inner contact.footprint:depth_of f8",
        "line inner contact.footprint:gone f8 f8",
        "line inner gone:depth_of f8 f8",
        "line inner wear.deposit:factor_in wear.deposit:Spread i8 i8",  # of fewer parts than it has
        "structure wear.deposit:Spread f8[:,:] f8[:,:]",
        "line inner contact.footprint:depth_of f8 f8",
    ]
    monkeypatch.setattr(import_module("semiwear.kernel_list"), "lines", lambda: [line.split() for line in told])
    assert [listed.types for listed in kernel_list("line")] == [(types.float64, types.float64)]


def test_a_kernel_waits_for_those_that_another_process_compiles(tmp_path):
    one, two = listed_pair()
    (tmp_path / "0.claimed").touch()
    ends = threading.Event()
    worker = threading.Thread(target=module._compile_shared, args=([one, two], tmp_path, lambda: not ends.is_set()))
    worker.start()
    try:
        worker.join(0.2)
        assert worker.is_alive() and not is_compiled(two) and not (tmp_path / "1.claimed").exists()
        (tmp_path / "0.done").touch()
        worker.join(60.0)
        assert is_compiled(two) and (tmp_path / "1.done").exists()
    finally:
        ends.set()
        worker.join()


def test_kernels_that_wait_for_a_process_that_is_gone_are_left(tmp_path):
    one, two = listed_pair()
    (tmp_path / "0.claimed").touch()
    assert not module._compile_shared([one, two], tmp_path, lambda: False)
    assert not is_compiled(two)


def test_a_program_that_python_is_built_into_is_not_started_again(pair, helpers, monkeypatch):
    for executable in ("/opt/modeller/modeller", "", None):
        monkeypatch.setattr(module, "_ready", set())
        monkeypatch.setattr(sys, "executable", executable)
        compile_ahead("line", 2)
    assert helpers == [] and all(map(is_compiled, pair))


def test_what_another_process_has_claimed_is_left_to_it(tmp_path):
    one, two = listed_pair()
    (tmp_path / "0.claimed").touch()
    (tmp_path / "1.claimed").touch()
    (tmp_path / "0.done").touch()
    assert module._compile_shared([one, two], tmp_path, lambda: True)
    assert not is_compiled(one) and not is_compiled(two)


class Heard(event.Listener):
    """Keeps the names of the kernels of semiwear that are compiled."""

    def __init__(self):
        self.names = []

    def on_start(self, event):
        function = event.data["dispatcher"].py_func
        if function.__module__.startswith("semiwear."):
            self.names.append(function.__qualname__)

    def on_end(self, event):
        pass


# sums over fewer slices stay in order, whatever is allowed
MANY_SLICES = {"numerics.face_slices": 49, "numerics.roll_positions": 12}
RUNS = {"contact": {}, "line": MANY_SLICES, "patch": PATCH, "both": BOTH}


def run_of(name: str) -> xr.DataTree:
    """A small run of a kind."""
    scene = scene_of(TINY, {"wear.until.control_depths_um": (6.0,)}, RUNS[name], wears=True)
    return sw.loaded_contact(scene) if name == "contact" else sw.simulate(scene)


def compile_and_run(file: str) -> None:
    """Keep what a contact run finds; print how many kernels are compiled ahead of it, and those that it compiles."""
    ahead, later = Heard(), Heard()
    with event.install_listener("numba:compile", ahead):
        compile_ahead("contact", 2)
    with event.install_listener("numba:compile", later):
        sw.save(run_of("contact"), file)
    print(len(ahead.names), *sorted(set(later.names)))


def types_called() -> set[ListedKernel]:
    """Kernels of semiwear that were compiled or loaded in this process, for every type, but for parts of others."""
    modules = [module for name, module in list(sys.modules.items()) if name.startswith("semiwear.")]
    found = {thing for module in modules for thing in vars(module).values() if isinstance(thing, Dispatcher)}
    called = found.difference(*map(called_by, found))
    return {ListedKernel((), True, kernel, types) for kernel in called for types in kernel.signatures}


def run_and_compare() -> None:
    """Print the kernels that runs of every kind call with other types than those that are listed for them."""
    known = types_called()
    for name in RUNS:
        run_of(name)
        listed = {ListedKernel((), True, one.kernel, one.types) for one in kernel_list(name)}
        print(name, *sorted(map(name_of, types_called() - known - listed)))
        known |= types_called()


def said(*arguments: str, **environment: str) -> str:
    """What this module prints as a program."""
    command = [sys.executable, "-m", "tests.unit.test_compile_ahead", *arguments]
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | environment
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_a_run_finds_compiled_what_two_processes_have_compiled(tmp_path):
    """And computes the same bits where all kernels are found compiled.

    Kernels with reordered sums that others call are compiled twice, and which copy is taken may differ.
    """
    kernels, told, kept = tmp_path / "kernels", [], []
    for process in ("first", "second"):
        told.append(said(str(tmp_path / f"{process}.nc"), NUMBA_CACHE_DIR=str(kernels)).split())
        kept.append(sorted(kernels.rglob("*.nbc")))
    # nothing was compiled before, and a part of it by the other process
    assert 0 < int(told[0][0]) < len(kernel_list("contact"))
    assert told[0][1:] == [] and told[1] == ["0"]
    assert kept[0] and kept[0] == kept[1]
    first, second = (sw.open_results(tmp_path / f"{process}.nc") for process in ("first", "second"))
    assert different_variables(first, second) == []


@pytest.mark.slow
def test_runs_call_kernels_for_the_types_that_are_listed():
    """Others would be compiled when they are called, by one process while the rest wait."""
    assert said().split() == list(RUNS)


def test_whatever_plans_teeth_and_loads_them_compiles_ahead():
    """But for what others call that have done so: screening, and runs of a life beside its own."""
    called = {}
    for path in (ROOT / "semiwear").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        if ".loaded_teeth(" not in text:  # the others need not be parsed
            continue
        calls = [node.func for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)]
        names = {call.id for call in calls if isinstance(call, ast.Name)}
        names |= {f".{call.attr}" for call in calls if isinstance(call, ast.Attribute)}
        called[path.stem] = names
    loading = {name for name, names in called.items() if {"plan", ".loaded_teeth"} <= names}
    ahead = {name for name in loading if "compile_ahead" in called[name]}
    assert loading - ahead == {"life", "screen_ratings"}
    assert {"simulate", "analyses", "screen", "outcome", "worn_contact", "predicted"} <= ahead


if __name__ == "__main__":
    import_module("semiwear.simulate")  # with which vectors are tried
    compile_and_run(sys.argv[1]) if sys.argv[1:] else run_and_compare()
