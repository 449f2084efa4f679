"""Commands that solve many scenes of a study file: `sweep`, `optimise` and `infer`."""

from __future__ import annotations

import argparse
import time

from semiwear.commands.progress_bar import ProgressBar
from semiwear.errors import Problem
from semiwear.inference.command import run_inference
from semiwear.optimise.command import run_optimise
from semiwear.scatter.command import SCATTER, prepare_study
from semiwear.sweep.command import run_study
from semiwear.untyped import Table


def sweep(options: argparse.Namespace, problems: list[Problem]) -> Table:
    """Solve the scenes of a study file."""
    begin = time.perf_counter()
    with ProgressBar("reading the study ...", "scene", "sweep") as bar:
        swept = run_study(
            options.study, options.output, workers=options.workers, scheduler=options.scheduler,
            resume=options.resume, report=options.report, progress=bar, further=SCATTER, prepare=prepare_study,
            problems=problems,
        )  # fmt: skip
    spent = _print_summary(swept.text, begin)
    return {"dataset": options.output, "report": options.report, "scenes": swept.scenes, "seconds": spent}


def optimise(options: argparse.Namespace, problems: list[Problem]) -> Table:
    """Find the best design of a study file."""
    begin = time.perf_counter()
    with ProgressBar("reading the study ...", "design", "search") as bar:
        searched = run_optimise(
            options.study, options.output, workers=options.workers, designs=options.designs,
            report=options.report, progress=bar, problems=problems,
        )  # fmt: skip
    spent = _print_summary(searched.text, begin)
    best = searched.best
    quantities = [
        {
            "quantity": change.quantity.text,
            "units": change.quantity.units,
            "before": change.before,
            "best": change.best,
            "error": change.error,
            "limit": None if change.limit is None else str(change.limit),
        }
        for change in best.told
    ]
    optimum: Table = {"changes": best.changes, "aims": list(map(str, best.aims)), "quantities": quantities}
    optimum |= {"limits_kept": best.kept, "unsolved": best.unsolved or None}
    files = {"best": options.output, "designs": options.designs, "report": options.report}
    return {**files, **optimum, "seconds": spent}


def infer(options: argparse.Namespace, problems: list[Problem]) -> Table:
    """Infer the unknown fields of a study file."""
    begin = time.perf_counter()
    with ProgressBar("reading the study ...", "step", "inference") as bar:
        summary = run_inference(
            options.study, options.output, workers=options.workers, store=options.store, report=options.report,
            progress=bar, problems=problems,
        )  # fmt: skip
    spent = _print_summary(summary, begin)
    return {"output": options.output, "report": options.report, "seconds": spent}


def _print_summary(summary: str, begin: float) -> float:
    """Print the summary of a study and the seconds since it began, which are returned."""
    spent = time.perf_counter() - begin
    print(summary)
    print(f"\n{spent:.1f} s")
    return spent
