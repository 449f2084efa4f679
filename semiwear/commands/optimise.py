"""The command `optimise`: the best design of a study file."""

from __future__ import annotations

import argparse
import time

from semiwear.commands.progress_bar import ProgressBar
from semiwear.commands.summary import print_summary
from semiwear.errors import Problem
from semiwear.optimise.command import run_optimise
from semiwear.untyped import Table


def optimise(options: argparse.Namespace, problems: list[Problem]) -> Table:
    """Find the best design of a study file."""
    begin = time.perf_counter()
    with ProgressBar("reading the study ...", "design", "search") as bar:
        searched = run_optimise(
            options.study, options.output, workers=options.workers, designs=options.designs,
            report=options.report, progress=bar, problems=problems,
        )  # fmt: skip
    spent = print_summary(searched.text, begin)
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
