"""Seconds of the main job, cold and warm, stage by stage, and what more resolution would change.

    python validation/bench_main.py [--repeat N] [--cold] [--json FILE]

Run it on one core (`taskset -c 0`, OMP_NUM_THREADS=1) to compare. `--cold` clears the compiled kernels of a
subprocess by giving it an empty cache, which is what a new user's first run pays.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, os.fspath(Path(__file__).parents[1]))  # as a script it finds its own folder only

import semiwear as sw
from validation.problems import KINDS

COLD = """
import time; t0 = time.perf_counter()
import semiwear as sw; t1 = time.perf_counter()
sw.simulate(sw.load_scene("face_gear_25x160")); t2 = time.perf_counter()
print(t1 - t0, t2 - t1)
"""


def timed(action: Callable[[], Any]) -> tuple[Any, float]:
    """What an action returns, and its seconds."""
    begin = time.perf_counter()
    result = action()
    return result, time.perf_counter() - begin


def cold_run(cache: str) -> tuple[float, float]:
    """Seconds of import and of a first simulation in a new process with its own kernel cache."""
    environment = os.environ | {"NUMBA_CACHE_DIR": cache}
    output = subprocess.run([sys.executable, "-c", COLD], env=environment, capture_output=True, text=True, check=True)
    first, second = output.stdout.split()
    return float(first), float(second)


def doubling(scene: sw.Scene, tree: Any) -> dict[str, float]:
    """Greatest change of each kind of history when roll positions and slices double, over its greatest magnitude."""
    numerics = scene.numerics
    finer = sw.simulate(
        scene.replace(
            {
                "numerics.roll_positions": 2 * numerics.roll_positions,
                "numerics.face_slices": 2 * numerics.face_slices,
            }
        )
    )
    changes = {}
    for kind, names in KINDS.items():
        fine = [finer["history"][name].values for name in names]
        coarse = [tree["history"][name].values for name in names]
        greatest = max(float(np.abs(values).max()) for values in fine)
        worst = max(float(np.abs(a - b).max()) for a, b in zip(coarse, fine, strict=True))
        changes[kind] = worst / greatest
    return changes


def main() -> None:
    """Run the benchmark and print its tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=5, help="warm runs")
    parser.add_argument("--cold", action="store_true", help="time first runs in new processes as well")
    parser.add_argument("--json", metavar="FILE", help="write the figures")
    options = parser.parse_args()

    figures: dict[str, Any] = {}
    if options.cold:
        with tempfile.TemporaryDirectory() as cache:
            figures["new user, kernels compiled [s]"] = dict(
                zip(("import", "simulate"), cold_run(cache), strict=True)
            )
            figures["new process, kernels cached [s]"] = dict(
                zip(("import", "simulate"), cold_run(cache), strict=True)
            )

    scene = sw.load_scene("face_gear_25x160")
    sw.simulate(scene.replace({"numerics.face_slices": 21, "numerics.roll_positions": 8}))
    prisms = []
    for _ in range(2):
        importlib.import_module("semiwear.plan.teeth").toothed.cache_clear()
        _, seconds = timed(lambda: sw.plan(scene).loaded_teeth())
        _, again = timed(lambda: sw.plan(scene).loaded_teeth())
        prisms.append(seconds - again)
    figures["prism matrices of both bodies [s]"] = min(prisms)

    runs = []
    stages: dict[str, list[float]] = {}
    tree = None
    for _ in range(options.repeat):
        tree, seconds = timed(lambda: sw.simulate(scene))
        runs.append(seconds)
        taken = tree["diagnostics"]["seconds"]
        for stage, value in zip(taken["stage"].values, taken.values, strict=True):
            stages.setdefault(str(stage), []).append(float(value))
    figures["main job, warm, median [s]"] = statistics.median(runs)
    figures["main job, warm, least [s]"] = min(runs)
    figures["of it, median [s]"] = {stage: statistics.median(values) for stage, values in stages.items()}
    figures["change when roll positions and slices double"] = doubling(scene, tree)

    for name, value in figures.items():
        if isinstance(value, dict):
            print(name)
            for part, number in value.items():
                print(f"    {part:32s} {number:9.4f}")
        else:
            print(f"{name:36s} {value:9.4f}")
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump(figures, file, indent=1)


if __name__ == "__main__":
    main()
