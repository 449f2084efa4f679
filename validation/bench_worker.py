"""Runs what it is asked on standard input, and answers with what it took: of this version of semiwear or another.

A request is a line of JSON (`BenchCase.request`), an answer another one. Only public names that versions share are
used, so that a stored commit answers, too, when its folder stands first on the path.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import sys
import time
from pathlib import Path
from typing import Any


def scene_of(request: dict[str, Any]) -> Any:
    """The scene that a request asks for."""
    import semiwear as sw

    changes = dict(request["changes"])
    scene = sw.load_scene(request["scene"])
    with contextlib.suppress(sw.SceneError):  # older versions have no threads to set
        scene = scene.replace({"numerics.threads": request["threads"]})
    return scene.replace(changes)


def ready(action: str, scene: Any) -> Any:
    """A function that does it, with what is kept between runs in place: compliance but where it is what is timed."""
    import semiwear as sw

    if action == "simulate":
        sw.plan(scene).loaded_teeth()
        return lambda: sw.simulate(scene)
    if action == "loaded_contact":
        sw.plan(scene).loaded_teeth()
        return lambda: sw.loaded_contact(scene)
    if action == "screen":
        return lambda: sw.screen(scene)
    for kept in vars(importlib.import_module("semiwear.plan.teeth")).values():
        if hasattr(kept, "cache_clear"):
            kept.cache_clear()
    return lambda: sw.plan(scene).loaded_teeth()


def _peak() -> float | None:
    """Greatest memory of the process since it was last asked to forget it [MB]; only Linux tells."""
    try:
        lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
        return next(float(line.split()[1]) / 1024.0 for line in lines if line.startswith("VmHWM"))
    except (OSError, StopIteration):
        return None


def _forget_peak() -> None:
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")


def answer(request: dict[str, Any]) -> dict[str, Any]:
    """Run once.

    Returns
    -------
    dict
        `wall` and `processor` [s], `stages` [s by name], `peak` and `added` [MB: greatest memory of the process, and
        how much of it came with the run]; with a true `history` in the request also that: values of every variable
        of /history after the last wear step.
    """
    action = ready(request["action"], scene_of(request))
    _forget_peak()
    before, processor, wall = _peak(), time.process_time(), time.perf_counter()
    result = action()
    took: dict[str, Any] = {"wall": time.perf_counter() - wall, "processor": time.process_time() - processor}
    peak = _peak()
    stages = {}
    if request["action"] == "simulate":
        seconds = result["diagnostics"]["seconds"]
        stages = {
            str(name): float(value) for name, value in zip(seconds["stage"].values, seconds.values, strict=True)
        }
    if request.get("history"):
        last = result["history"].to_dataset().isel(wear_step=-1)
        took["history"] = {str(name): values.values.ravel().tolist() for name, values in last.data_vars.items()}
    return {
        **took,
        "stages": stages,
        "peak": peak,
        "added": None if peak is None or before is None else peak - before,
    }


def main() -> None:
    """Answer requests until there are none."""
    for line in sys.stdin:
        with contextlib.redirect_stdout(sys.stderr):
            try:
                answered = answer(json.loads(line))
            except Exception as error:
                answered = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(answered), flush=True)


if __name__ == "__main__":
    main()
