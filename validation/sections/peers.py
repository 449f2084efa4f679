"""Peers: the contact benchmark, run in a process of its own, since it wants the machine as it finds it."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from semiwear.report.markup import figure_text, table
from validation.charts import COLOURS, MARKERS, card, cards, legend_above
from validation.problems import Problems
from validation.progress import Progress
from validation.section import Section
from validation.tables import dataset, listed, power

TITLE = "Peers: contact on a half-space"
BENCHMARK = Path(__file__).parents[1] / "bench_contact.py"
SIZES = ("64", "128", "256")


def build(problems: Problems, quick: bool, progress: Progress) -> Section:
    """Run the contact benchmark, and tell its ratios."""
    progress.note("contact benchmark")
    options = ["--quick"] if quick else ["--sizes", *SIZES, "--repeats", "5"]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "contact.json"
        command = [sys.executable, str(BENCHMARK), *options, "--json", str(path)]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        if run.returncode or not path.is_file():
            raise RuntimeError(f"the contact benchmark ended with status {run.returncode}: {run.stderr[-600:]}")
        report = json.loads(path.read_text(encoding="utf-8"))
    return from_report(report)


def from_report(report: Mapping[str, Any]) -> Section:
    """The section from the benchmark's report."""
    rows = [{**row, "label": f"{row['case']} {row['points'][0]} x {row['points'][1]}"} for row in report["rows"]]
    html = _intro(report) + cards([_chart(rows)]) + _table(rows)
    return Section(_found(report, rows), html, {"contact": _data(rows)})


def _found(report: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    peers = [row for row in rows if row["ratio"] is not None]
    missing = list(report["missing"])
    ours = [row["ms"] for row in rows if row["code"] == "semiwear"]
    first = (
        f"At the same error of the pressure, {report['target_field_error']:.0e}, our solver takes "
        f"{figure_text(min(ours), 2)} to {figure_text(max(ours), 2)} ms on the {len(ours)} problems of this run."
    )
    if peers:
        texts = []
        for code in dict.fromkeys(row["code"] for row in peers):
            ratios = [row["ratio"] for row in peers if row["code"] == code]
            texts.append(f"{code} takes {figure_text(min(ratios), 2)} to {figure_text(max(ratios), 2)} times as long")
        second = listed(texts) + "."
    else:
        second = "No other code is installed here, so that there is nothing to compare with."
    third = f"Not installed, and so not compared: {listed(missing)}." if missing else "All codes are installed."
    return first, second, third


def _intro(report: Mapping[str, Any]) -> str:
    versions = ", ".join(f"{name} {version}" for name, version in report["versions"].items())
    return (
        "<p>Each code runs at its loosest tolerance at which the pressure is within the target of the discrete "
        "solution that all of them share, in its fastest variant, in turn with the others, on one core. Times are "
        f"medians; those of sweeps are for one roll position. Versions: {versions}.</p>"
    )


def _chart(rows: Sequence[Mapping[str, Any]]) -> str:
    def draw(ax: Any) -> None:
        labels = list(dict.fromkeys(row["label"] for row in rows))
        for k, code in enumerate(dict.fromkeys(row["code"] for row in rows)):
            own = {row["label"]: row["ms"] for row in rows if row["code"] == code}
            at = [labels.index(label) for label in own]
            ax.semilogy(at, list(own.values()), MARKERS[k], color=COLOURS[k], markersize=8, label=code)
        ax.set_xticks(range(len(labels)), [label.replace(" ", "\n", 1) for label in labels])
        ax.set_xlim(-0.5, len(labels) - 0.5)
        ax.set_ylabel("Time (ms)")
        legend_above(ax)

    return card("peers", "Time to the same error", "Lower is faster; a step of the grid is a factor of ten.", draw)


def _table(rows: Sequence[Mapping[str, Any]]) -> str:
    head = ("problem", "code", "variant", "time [ms]", "error of the pressure", "times ours")
    cells = [
        (
            row["label"],
            row["code"],
            row["variant"],
            figure_text(row["ms"], 3),
            power(row["field_error"]),
            "1" if row["ratio"] is None else figure_text(row["ratio"], 3),
        )
        for row in rows
    ]
    return table("Codes on the same problem, at the same error", head, cells)


def _data(rows: Sequence[Mapping[str, Any]]) -> xr.Dataset:
    return dataset(
        {"row": np.arange(len(rows))},
        {
            "problem": ([row["label"] for row in rows], "1", "problem and grid"),
            "code": ([row["code"] for row in rows], "1", "code"),
            "variant": ([row["variant"] for row in rows], "1", "variant of the code"),
            "time": ([row["ms"] for row in rows], "ms", "median time"),
            "field_error": ([row["field_error"] for row in rows], "1", "relative L2 error of the pressure"),
            "ratio": ([row["ratio"] or 1.0 for row in rows], "1", "time over ours"),
        },
    )
