"""The command `sweep`: the scenes of a study file."""

from __future__ import annotations

import argparse
import time

from semiwear.commands.progress_bar import ProgressBar
from semiwear.commands.summary import print_summary
from semiwear.errors import Problem
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
    spent = print_summary(swept.text, begin)
    return {"dataset": options.output, "report": options.report, "scenes": swept.scenes, "seconds": spent}
