"""Explicit against implicit wear steps on the shipped scene: a part of the section on accuracy and time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from semiwear.errors import ConvergenceError
from semiwear.report.markup import figure_text, table
from validation.charts import COLOURS, MARKERS, Draw, card, cards, plain_log
from validation.problems import wear_problem
from validation.progress import Progress
from validation.section import Section
from validation.tables import dataset, failures_note, percent, with_unit
from validation.wear_schemes import SCHEMES, SchemeRun, life_of, solves_for

__all__ = ["schemes_part"]

WANTED = 0.01
COUNTS = {
    "explicit": (8, 16, 32, 64, 128, 256),
    "implicit": (1, 2, 4, 8, 16, 32, 64),
    "extrapolated": (1, 2, 4, 8, 16),
}
QUICK_COUNTS = {"explicit": (8, 16, 32, 64), "implicit": (1, 2, 4, 8, 16, 32), "extrapolated": (1, 2, 4, 8)}
CONVERGED = 24
"""Extrapolated steps of the life that counts as converged."""


def schemes_part(quick: bool, progress: Progress) -> Section:
    """Lives in many numbers of steps, at one slice count or at three."""
    runs: dict[int, list[SchemeRun]] = {}
    failures: list[str] = []
    for slices in (31,) if quick else (31, 61, 91):
        runs[slices] = _lives(slices, QUICK_COUNTS if quick else COUNTS, progress, failures)
    needed = {slices: {scheme: solves_for(own, scheme, WANTED) for scheme in SCHEMES} for slices, own in runs.items()}
    drawn = []
    for slices, own in runs.items():
        for over, text in (("seconds", "Processor time (s)"), ("solves", "Solutions of the loaded contact")):
            drawn.append(
                card(
                    f"schemes-{slices}-{over}",
                    f"Wear schemes, {slices} slices",
                    "Error of the greatest wear after a whole life, against the converged life on the same grid.",
                    _chart(own, over, text),
                )
            )
    html = _text(needed, runs) + failures_note(failures) + cards(drawn) + _table(runs)
    shrinks = [run for own in runs.values() for run in own if run.shrinks]
    first = next(iter(needed))
    words = ", ".join(
        f"{scheme} {'more than were tried' if count is None else count}" for scheme, count in needed[first].items()
    )
    found = (
        f"For {percent(WANTED)} in greatest wear at {first} slices the solutions needed are: {words}; wear shrinks "
        f"{'nowhere' if not shrinks else f'in {len(shrinks)} of the lives'}.",
    )
    return Section("Explicit and implicit wear steps", found, html, {"schemes": _data(runs)})


def _lives(
    slices: int, counts: dict[str, tuple[int, ...]], progress: Progress, failures: list[str]
) -> list[SchemeRun]:
    changes = {
        "numerics.face_slices": slices,
        "numerics.roll_positions": 12,
        "numerics.profile_points": 101,
        "numerics.harmonics": 9,
    }
    life = life_of(wear_problem("face_gear").scene(changes))
    progress.note(f"converged life, {slices} slices")
    converged = float(life.states("extrapolated", CONVERGED)[-1].max())
    runs = []
    for scheme in SCHEMES:
        for count in counts[scheme]:
            progress.note(f"{scheme} wear steps, {count} of them, {slices} slices")
            try:
                runs.append(life.run(scheme, count, converged))
            except ConvergenceError as error:
                failures.append(f"{count} {scheme} steps, {slices} slices: {error}")
    return runs


def _text(needed: dict[int, dict[str, int | None]], runs: dict[int, list[SchemeRun]]) -> str:
    lines = []
    for slices, counts in needed.items():
        explicit = counts["explicit"]
        parts = []
        for scheme in ("implicit", "extrapolated"):
            count = counts[scheme]
            if count is None:
                parts.append(f"{scheme} does not keep {percent(WANTED)} at the numbers tried")
            elif explicit is None:
                parts.append(f"{scheme} needs {count}")
            else:
                parts.append(f"{scheme} needs {count}, {figure_text(explicit / count, 2)} times fewer")
        known = "more than were tried" if explicit is None else f"{explicit} solutions"
        last = max((run for run in runs[slices] if run.scheme == "explicit"), key=lambda run: run.steps)
        check = f"{last.steps} explicit steps are {percent(last.error)} off what counts as converged"
        lines.append(f"<li>{slices} slices: explicit steps need {known}; {'; '.join(parts)}. {check}.</li>")
    return (
        "<h3>Explicit and implicit wear steps</h3><p>The same life of the shipped scene on the same grid. An "
        "explicit or an implicit step takes one solution of the loaded contact, an extrapolated one three (whole "
        "and two halves). A number of steps keeps an error if it and every larger one tried do. Converged: "
        f"{CONVERGED} extrapolated steps. For {percent(WANTED)} in greatest wear:</p><ul>{''.join(lines)}</ul>"
    )


def _chart(runs: Sequence[SchemeRun], over: str, label: str) -> Draw:
    def draw(ax: Any) -> None:
        for k, scheme in enumerate(SCHEMES):
            own = [run for run in runs if run.scheme == scheme]
            cost = [getattr(run, over) for run in own]
            error = [max(run.error, 1e-5) for run in own]
            ax.loglog(cost, error, marker=MARKERS[k], color=COLOURS[k], label=scheme)
        ax.axhline(WANTED, color="#555555", linewidth=1.0, linestyle=":")
        plain_log(ax.xaxis)
        plain_log(ax.yaxis, percent=True)
        ax.set_xlabel(label)
        ax.set_ylabel("Error of greatest wear")
        ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.2)

    return draw


def _table(runs: dict[int, list[SchemeRun]]) -> str:
    head = ("slices", "scheme", "steps", "solutions", "greatest wear", "error", "processor time [s]")
    rows = [
        (
            str(slices),
            run.scheme,
            str(run.steps),
            str(run.solves),
            with_unit(run.greatest, "um"),
            percent(run.error),
            figure_text(run.seconds, 2),
        )
        for slices, own in runs.items()
        for run in own
    ]
    return table("Lives in different numbers of steps", head, rows)


def _data(runs: dict[int, list[SchemeRun]]) -> xr.Dataset:
    flat = [(slices, run) for slices, own in runs.items() for run in own]
    return dataset(
        {"run": np.arange(len(flat))},
        {
            "slices": ([slices for slices, _ in flat], "1", "slices along the face"),
            "scheme": ([run.scheme for _, run in flat], "1", "wear scheme"),
            "steps": ([run.steps for _, run in flat], "1", "wear steps"),
            "solves": ([run.solves for _, run in flat], "1", "solutions of the loaded contact"),
            "greatest_wear": ([run.greatest for _, run in flat], "um", "greatest wear"),
            "error": ([run.error for _, run in flat], "1", "error of the greatest wear"),
            "seconds": ([run.seconds for _, run in flat], "s", "processor time"),
        },
    )
