"""Writes the list of kernels that first runs compile, in a few minutes: ``python -m validation.kernel_list``.

Every kind of run is made twice in new processes, with a folder of kernels that is empty at first. The first run tells
which kernels are compiled, for what types, and how long each takes, the second which are loaded: Python calls them.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from numba import types
from numba.core import event
from numba.core.dispatcher import Dispatcher

import semiwear as sw
from semiwear.compile_ahead import called_by
from semiwear.kernel_list import NUMBERS, named

ROOT = Path(__file__).parents[1]
LISTED = ROOT / "semiwear" / "kernel_list.txt"
RUNS: dict[str, tuple[Callable[[sw.Scene], object], dict[str, Any]]] = {
    "contact": (sw.loaded_contact, {}),
    "line": (sw.simulate, {}),
    "patch": (sw.simulate, {"numerics.fidelity": "patch"}),
    "both": (sw.simulate, {"wear.worn_bodies": ["pinion", "gear"]}),
}
"""Kinds of run, as `plan.choices.kernels_of` names them: what does it, and changes of the shipped face gear."""


@dataclass
class Compiled:
    """A kernel that was compiled.

    Attributes
    ----------
    kernel : dispatcher of numba
    arguments : tuple of types.Type
    seconds : float
        What it took, without the kernels that it calls.
    """

    kernel: Any
    arguments: tuple[types.Type, ...]
    seconds: float


@dataclass
class Compilations(event.Listener):
    """Hears of every kernel of semiwear that is compiled; what numba compiles of its own counts for its caller."""

    found: list[Compiled] = field(default_factory=list)
    _running: list[list[float]] = field(default_factory=list)

    def on_start(self, event: event.Event) -> None:
        """Note the start of a compilation."""
        self._running.append([time.perf_counter(), 0.0])

    def on_end(self, event: event.Event) -> None:
        """Keep the kernel and its seconds, without those of kernels compiled within."""
        start, within = self._running.pop()
        kernel, seconds = event.data["dispatcher"], time.perf_counter() - start
        function = kernel.py_func
        if not function.__module__.startswith("semiwear.") or "<" in function.__qualname__:
            return
        self.found.append(Compiled(kernel, tuple(event.data["args"]), seconds - within))
        if self._running:
            self._running[-1][1] += seconds


def name_of(thing: Any) -> str:
    """Module within semiwear, and name."""
    return f"{thing.__module__.removeprefix('semiwear.')}:{thing.__qualname__}"


def type_name(kind: types.Type) -> str:
    """Name of a type in the list; `KeyError` where it has none."""
    numbers = {number: name for name, number in NUMBERS.items()}
    if isinstance(kind, types.BaseNamedTuple):
        return name_of(kind.instance_class)
    if isinstance(kind, types.BaseTuple):
        return f"({','.join(type_name(part) for part in kind)})"
    if isinstance(kind, types.Array):
        order = {"C": "::1", "A": ":"}[kind.layout]
        return f"{'' if kind.mutable else 'const_'}{numbers[kind.dtype]}[{':,' * (kind.ndim - 1)}{order}]"
    if isinstance(kind, types.Literal):
        return str(kind.literal_value)
    return "none" if kind == types.none else numbers[kind]


def structures_in(kind: types.Type) -> dict[str, list[str]]:
    """Structures and tuples that a type is made of, inner ones first, with the types of their parts."""
    if not isinstance(kind, types.BaseTuple):
        return {}
    found = {name: parts for part in kind for name, parts in structures_in(part).items()}
    return found | {type_name(kind): [type_name(part) for part in kind]}


def kernels_of_semiwear() -> dict[str, Any]:
    """Every kernel of the modules that are imported, by name."""
    modules = [module for name, module in sys.modules.items() if name.startswith("semiwear.")]
    found = [thing for module in modules for thing in vars(module).values() if isinstance(thing, Dispatcher)]
    return {name_of(kernel.py_func): kernel for kernel in found}


def told_by(run: str) -> dict[str, Any]:
    """What a run compiles, and which kernels it loads, in this process."""
    heard = Compilations()
    event.register("numba:compile", heard)
    act, changes = RUNS[run]
    act(sw.load_scene("face_gear_25x160").replace(changes | {"numerics.threads": 1}))
    compiled, structures = [], {}
    for one in heard.found:
        try:
            arguments = [type_name(kind) for kind in one.arguments]
        except KeyError:  # a type that the list has no name for
            continue
        for kind in one.arguments:
            structures |= structures_in(kind)
        compiled.append({"name": name_of(one.kernel.py_func), "arguments": arguments, "seconds": one.seconds})
    loaded = [name for name, kernel in kernels_of_semiwear().items() if kernel.stats.cache_hits]
    return {"compiled": compiled, "structures": structures, "loaded": loaded}


def told_in_a_process(run: str, folder: str) -> dict[str, Any]:
    """`told_by` in a new process, with kernels in this folder."""
    command = [sys.executable, "-m", "validation.kernel_list", "--tell", run]
    environment = os.environ | {"NUMBA_CACHE_DIR": folder, "SEMIWEAR_CACHE_DIR": "off"}
    done = subprocess.run(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, check=True)
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def list_kernels() -> str:
    """The text of the list."""
    LISTED.write_text("", encoding="utf-8")  # nothing is compiled ahead
    compiled, structures, called = [], {}, {}
    with tempfile.TemporaryDirectory() as folder:
        for run in RUNS:
            first = told_in_a_process(run, folder)
            compiled += [one | {"run": run} for one in first["compiled"]]
            structures |= first["structures"]
            called[run] = told_in_a_process(run, folder)["loaded"]
            print(f"{run}: {len(first['compiled'])} kernels compiled, {len(called[run])} called", flush=True)
    return text_of(compiled, structures, called)


def text_of(compiled: list[dict[str, Any]], structures: dict[str, list[str]], called: dict[str, list[str]]) -> str:
    """Lines of structures, then of kernels, first those on whose compilation most of the time waits."""
    by_python = set().union(*called.values())
    names = {one["name"] for one in compiled} | by_python
    below = {name: {name_of(one.py_func) for one in called_by(named(name))} for name in names}
    needed = {run: set(found).union(*(below[name] for name in found)) for run, found in called.items()}

    @cache
    def waiting(name: str) -> float:
        """Seconds from the begin of its compilation to that of all that calls it."""
        own = max((one["seconds"] for one in compiled if one["name"] == name), default=0.0)
        return own + max((waiting(other) for other in names if name in below[other]), default=0.0)

    lines = [["tuple" if name[0] == "(" else "structure", name, *parts] for name, parts in structures.items()]
    for one in sorted(compiled, key=lambda one: -waiting(one["name"])):
        name, order = one["name"], list(RUNS)
        # earlier runs than the one that compiles it do without, though they may need it for other types
        runs = ",".join(run for run in order[order.index(one["run"]) :] if name in needed[run])
        lines.append([runs, "called" if name in by_python else "inner", name, *one["arguments"]])
    return "".join(" ".join(line) + "\n" for line in lines)


def main() -> None:
    """Write the list."""
    if sys.argv[1:2] == ["--tell"]:
        json.dump(told_by(sys.argv[2]), sys.stdout)
    else:
        LISTED.write_text(list_kernels(), encoding="utf-8")


if __name__ == "__main__":
    main()
