"""Error against time of fidelity `line`, of this version and of a stored one, on the wear problems of the report.

    python -m validation.error_time [--against COMMIT] [--table FOUND.csv]
    python -m validation.error_time --draw PICTURE.svg  # of what is stored

Every problem is solved at `GRIDS` with `STEPS` wear steps, by both versions in turn on one thread; what counts as
converged is each version's own finest setting. `validation/data/error_time.csv` is one such table.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr

from semiwear.plot.style import styled
from validation.bench_cases import BenchCase
from validation.bench_main import ROOT, Worker, checked_out, workers
from validation.charts import COLOURS, pareto, plain_log
from validation.problems import FIGURES, METHODS, WEAR_PROBLEMS, Setting, WearProblem

STORED = Path(__file__).parent / "data" / "error_time.csv"
NOW, BEFORE = "now", "before"
_LINE = next(method for method in METHODS if method.name == "line")
GRIDS = _LINE.settings
STEPS = (1, 2, 4, 6, 8, 12)
LIMITS = (0.03, 0.01, 0.004)
"""Errors of which it is told what they take."""


@dataclass(frozen=True)
class TimedError:
    """A run of a version, and how far it is from the converged one.

    Attributes
    ----------
    version, problem, setting : str
    seconds : float
        Of the processor.
    errors : dict of str to float
        Of every figure, relative.
    """

    version: str
    problem: str
    setting: str
    seconds: float
    errors: Mapping[str, float]

    @property
    def worst(self) -> float:
        """Greatest error of any figure."""
        return max(self.errors.values())


def _solved(worker: Worker, problem: WearProblem, setting: Setting) -> tuple[xr.DataTree, float] | None:
    """What figures are read from, and seconds; None where it cannot be solved."""
    case = BenchCase(
        problem.name, problem.title, problem.base, {**problem.changes, **_LINE.changes, **setting.changes}
    )
    answer = worker.run(case.request() | {"history": True})
    if "error" in answer:
        return None
    last = {name: (("wear_step", f"of {name}"), [values]) for name, values in answer["history"].items()}
    return xr.DataTree.from_dict({"/history": xr.Dataset(last)}), answer["processor"]


def measured(problem: WearProblem, running: Mapping[str, Worker]) -> Iterator[TimedError]:
    """Runs of a problem by every version, the converged ones first and told of only through the errors."""
    exact: dict[str, xr.DataTree] = {}
    for version, worker in running.items():
        found = _solved(worker, problem, _LINE.reference)
        if found is None:
            raise RuntimeError(f"{problem.name}: the converged run of the version {version} cannot be solved")
        exact[version] = found[0]
    for grid in GRIDS:
        for steps in STEPS:
            setting = replace(grid, wear_steps=steps)
            for version, worker in running.items():
                found = _solved(worker, problem, setting)
                if found is None:
                    continue
                tree, seconds = found
                errors = {figure.name: figure.error(tree, exact[version]) for figure in FIGURES}
                yield TimedError(version, problem.name, setting.label, seconds, errors)


def fastest_within(points: Sequence[TimedError], limit: float) -> TimedError | None:
    """The fastest run with every figure within an error; None where none is."""
    good = [point for point in points if point.worst <= limit]
    return min(good, key=lambda point: point.seconds) if good else None


def stored(version: str, problem: str) -> list[TimedError]:
    """Stored runs of a version on a problem."""
    with STORED.open(encoding="utf-8", newline="") as stream:
        points = [_of_row(row) for row in csv.DictReader(stream)]
    return [point for point in points if (point.version, point.problem) == (version, problem)]


def _of_row(row: Mapping[str, str]) -> TimedError:
    errors = {figure.name: float(row[figure.name]) for figure in FIGURES}
    return TimedError(row["version"], row["problem"], row["setting"], float(row["seconds"]), errors)


def _row(point: TimedError) -> dict[str, Any]:
    told = {"version": point.version, "problem": point.problem, "setting": point.setting}
    return told | {"seconds": f"{point.seconds:.3f}"} | {name: f"{error:.6f}" for name, error in point.errors.items()}


def _compared(points: Sequence[TimedError], problem: str) -> Iterator[str]:
    """What every error of `LIMITS` takes."""
    for limit in LIMITS:
        took = {}
        for version in dict.fromkeys(point.version for point in points):
            own = [point for point in points if (point.version, point.problem) == (version, problem)]
            took[version] = fastest_within(own, limit)
        told = [
            f"{version} {'nothing' if one is None else f'{one.seconds:.2f} s ({one.setting})'}"
            for version, one in took.items()
        ]
        before, now = took.get(BEFORE), took.get(NOW)
        ratio = f": {before.seconds / now.seconds:.1f}x" if before is not None and now is not None else ""
        yield f"{problem}, every figure within {limit:.1%}: {', '.join(told)}{ratio}"


def draw(path: Path) -> None:
    """Worst error of any figure over time, a panel a problem: now in colour, before in grey."""
    with styled():
        from matplotlib.figure import Figure as Drawing

        picture = Drawing(figsize=(10.0, 3.6), layout="constrained")
        panels = picture.subplots(1, len(WEAR_PROBLEMS), sharey=True)
        for axis, problem in zip(panels, WEAR_PROBLEMS, strict=True):
            for version, colour in ((BEFORE, "#999999"), (NOW, COLOURS[0])):
                points = stored(version, problem.name)
                seconds, errors = np.array([(point.seconds, point.worst) for point in points]).T
                best = pareto(seconds, errors)
                axis.loglog(seconds, errors, ".", color=colour, markersize=3.0, alpha=0.6)
                axis.loglog(seconds[best], errors[best], "o-", color=colour, label=version)
            plain_log(axis.xaxis)
            plain_log(axis.yaxis, percent=True)
            axis.set_title(fill(problem.title, 34), fontsize="medium")
            axis.set_xlabel("Processor time, warm (s)")
        panels[0].set_ylabel("Greatest error of any figure")
        panels[0].legend(frameon=False)
        picture.savefig(path, metadata={"Date": None, "Creator": None})


def main(arguments: Sequence[str] | None = None) -> None:
    """Solve the problems and tell what errors take."""
    parser = argparse.ArgumentParser(prog="python -m validation.error_time")
    parser.add_argument("--against", metavar="COMMIT", help="a stored commit, too")
    parser.add_argument("--table", type=Path, help="CSV of all runs")
    parser.add_argument("--draw", metavar="PICTURE", type=Path, help="draw what is stored instead (extra plot)")
    options = parser.parse_args(arguments)
    if options.draw:
        draw(options.draw)
        return
    points: list[TimedError] = []
    with ExitStack() as held:
        trees = {NOW: ROOT}
        if options.against:
            trees[BEFORE] = held.enter_context(checked_out(options.against))
        for problem in WEAR_PROBLEMS:
            with workers(list(trees.values())) as started:
                for point in measured(problem, dict(zip(trees, started, strict=True))):
                    points.append(point)
                    print(f"{point.problem}, {point.version}, {point.setting}: {point.seconds:.2f} s, "
                          f"{point.worst:.2%}", flush=True)  # fmt: skip
                    if options.table:
                        with options.table.open("w", encoding="utf-8", newline="") as stream:
                            writer = csv.DictWriter(stream, _row(point), lineterminator="\n")
                            writer.writeheader()
                            writer.writerows(map(_row, points))
            for line in _compared(points, problem.name):
                print(line, flush=True)


if __name__ == "__main__":
    main()
