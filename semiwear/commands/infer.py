"""The command `infer`: the unknown fields of a study file."""

from __future__ import annotations

import argparse
import time

from semiwear.commands.progress_bar import ProgressBar
from semiwear.commands.summary import print_summary
from semiwear.errors import Problem
from semiwear.inference.command import run_inference
from semiwear.untyped import Table


def infer(options: argparse.Namespace, problems: list[Problem]) -> Table:
    """Infer the unknown fields of a study file."""
    begin = time.perf_counter()
    with ProgressBar("reading the study ...", "step", "inference") as bar:
        summary = run_inference(
            options.study, options.output, workers=options.workers, store=options.store, report=options.report,
            progress=bar, problems=problems,
        )  # fmt: skip
    spent = print_summary(summary, begin)
    return {"output": options.output, "report": options.report, "seconds": spent}
