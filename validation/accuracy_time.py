"""Error against time: every wear problem by every method at several settings, and what an asked accuracy brings."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.errors import SemiwearError
from semiwear.results.kinds import difference, history, worst
from validation.accuracy import solved
from validation.charts import pareto
from validation.problems import Figure, Method, Setting, WearProblem
from validation.progress import Progress

_COLD = """
import time
start = time.process_time()
import semiwear as sw
imported = time.process_time()
sw.simulate(sw.load_scene("face_gear_25x160"))
print(imported - start, time.process_time() - imported)
"""


@dataclass(frozen=True)
class Point:
    """A problem solved by a method at a setting.

    Attributes
    ----------
    problem, method : str
    setting : Setting
    seconds : float
        Of the processor, with kernels compiled and tooth compliance at hand.
    values, errors : dict of str to float
        Of every figure; errors relative to the method's converged value.
    converged : bool
        Whether this is the converged run itself.
    """

    problem: str
    method: str
    setting: Setting
    seconds: float
    values: dict[str, float]
    errors: dict[str, float]
    converged: bool = False

    @property
    def worst(self) -> float:
        """Greatest error of any figure."""
        return max(self.errors.values())


def timed(scene: sw.Scene) -> tuple[xr.DataTree, float]:
    """A wear run, and its warm seconds of the processor."""
    sw.plan(scene).loaded_teeth()  # compiles, and leaves the tooth compliance where the run finds it
    started = time.process_time()
    tree = sw.simulate(scene)
    return tree, time.process_time() - started


def points_of(
    problem: WearProblem,
    method: Method,
    figures: Sequence[Figure],
    quick: bool,
    progress: Progress,
    solve: Callable[[sw.Scene], tuple[xr.DataTree, float]] = timed,
) -> tuple[list[Point], xr.DataTree | None, list[str]]:
    """Every setting of a method, the converged one first.

    Returns
    -------
    points : list of Point
    reference : DataTree or None
        The converged result; without it there are no points.
    failures : list of str
        Settings that could not be solved, and why.
    """
    points: list[Point] = []
    failures: list[str] = []
    reference = None
    for setting in (method.converged(quick), *method.swept(quick)):
        progress.note(f"{problem.name}, {method.name}, {setting.label}")
        try:
            tree, seconds = solve(problem.scene(method.changes, setting.changes))
        except SemiwearError as error:
            failures.append(f"{problem.name}, {method.name}, {setting.label}: {error}")
            if reference is None:
                break  # nothing to compare with
            continue
        reference = tree if reference is None else reference
        values = {figure.name: figure.greatest(tree) for figure in figures}
        errors = {figure.name: figure.error(tree, reference) for figure in figures}
        points.append(Point(problem.name, method.name, setting, seconds, values, errors, not points))
    return points, reference, failures


def cost_of_a_digit(points: Sequence[Point]) -> float | None:
    """By how much time grows for a tenth of the worst error; None where more time brings no less error.

    From a straight line through the logarithms of time and worst error over the points that no other beats.
    """
    swept = [point for point in points if not point.converged]
    seconds, error = (np.array([getattr(point, name) for point in swept]) for name in ("seconds", "worst"))
    front = pareto(seconds, error)
    if front.size < 2:
        return None
    slope = np.polyfit(np.log(seconds[front]), np.log(np.maximum(error[front], 1e-12)), 1)[0]
    return float(10.0 ** (-1.0 / slope)) if slope < 0.0 else None


# ---- accuracy asked for


@dataclass(frozen=True)
class Asked:
    """An accuracy that was asked for.

    Attributes
    ----------
    problem : str
    asked, found, estimated : float
        Greatest error of any reported quantity over the greatest value of its kind: wanted, against the converged
        run of the report, and as the result itself says.
    seconds : float
        Of the processor.
    claimed : bool
        Whether the run says that it has reached it.
    quantity : str
        The one with the greatest error.
    """

    problem: str
    asked: float
    found: float
    estimated: float
    seconds: float
    claimed: bool
    quantity: str


def asked_for(problem: WearProblem, reference: xr.DataTree, accuracy: float) -> Asked:
    """Solve a problem to an accuracy, and compare with its converged run."""
    tree, seconds, claimed = solved(problem.scene(), accuracy)
    errors = difference(history(tree), history(reference))
    estimate = float(tree["diagnostics"]["error_estimate"].max())
    name = max(errors, key=lambda key: errors[key])
    return Asked(problem.name, accuracy, worst(errors), estimate, seconds, claimed, name)


# ---- cold


def cold_seconds(*, empty: bool) -> tuple[float, float]:
    """Seconds of the processor of the import and of the shipped job in a new process.

    Parameters
    ----------
    empty : bool
        Whether kernels must be compiled: the process then gets an empty cache.
    """
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | ({"NUMBA_CACHE_DIR": cache} if empty else {})
        run = subprocess.run(
            [sys.executable, "-c", _COLD], env=environment, capture_output=True, text=True, check=True
        )
    imported, simulated = run.stdout.split()
    return float(imported), float(simulated)
