"""Explicit against implicit wear steps on the shipped scene: the error of a life, over solutions and over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from semiwear.errors import ConvergenceError
from semiwear.report.markup import figure_text, table
from validation.charts import COLOURS, MARKERS, Draw, card, cards, legend_above, plain_log
from validation.problems import Problems, wear_problem
from validation.progress import Progress
from validation.section import Section
from validation.tables import dataset, failures_note, percent, with_unit
from validation.wear_schemes import SCHEMES, SOLVES_A_STEP, SchemeRun, life_of, solves_for

TITLE = "Explicit and implicit wear steps"
WANTED = {"error": 0.01, "flank_error": 0.02}
OF = {"error": "greatest wear", "flank_error": "wear over the whole flank"}
COUNTS = {
    "explicit": (8, 16, 20, 24, 28, 32, 40, 48),
    "implicit": (1, 2, 3, 4, 8, 16),
    "two-stage": (1, 2, 3, 4, 8),
}
GRIDS = {31: {"numerics.roll_positions": 12, "numerics.profile_points": 101},
         241: {"numerics.roll_positions": 48, "numerics.profile_points": 201}}  # fmt: skip
"""By slice count; the second in a full run only."""

QUICK_COUNTS = {"explicit": (8, 16, 20, 24, 32), "implicit": (1, 2, 4, 8, 16), "two-stage": (1, 2, 4)}
CONVERGED = 128
"""Explicit steps of the life that counts as converged."""


def build(_: Problems, quick: bool, progress: Progress) -> Section:
    """Lives in many numbers of steps, on one grid or on two."""
    runs: dict[int, list[SchemeRun]] = {}
    failures: list[str] = []
    for slices in (31,) if quick else tuple(GRIDS):
        runs[slices] = _lives(slices, quick, progress, failures)
    needed = {
        slices: {
            of: {scheme: solves_for(own, scheme, error, of) for scheme in SCHEMES} for of, error in WANTED.items()
        }
        for slices, own in runs.items()
    }
    drawn = []
    for slices, own in runs.items():
        for of, over, text in (
            ("error", "solves", "Solutions of the loaded contact"),
            ("flank_error", "solves", "Solutions of the loaded contact"),
            ("flank_error", "seconds", "Processor time (s)"),
        ):
            drawn.append(
                card(
                    f"schemes-{slices}-{of}-{over}",
                    f"Wear schemes, {slices} slices: {OF[of]}",
                    f"Error of the {OF[of]} after a whole life, against the converged life on the same grid.",
                    _chart(own, of, over, text),
                )
            )
    html = _text(needed) + failures_note(failures) + cards(drawn) + _table(runs)
    shrinks = [run for own in runs.values() for run in own if run.shrinks]
    finest = max(needed)
    words = "; ".join(
        f"for {percent(error)} in {OF[of]} at {finest} slices: " + _listed(needed[finest][of])
        for of, error in WANTED.items()
    )
    found = (
        f"Solutions of the loaded contact needed {words}. Wear shrinks "
        f"{'nowhere' if not shrinks else f'in {len(shrinks)} of the lives'}.",
    )
    return Section(found, html, {"schemes": _data(runs)})


def _lives(slices: int, quick: bool, progress: Progress, failures: list[str]) -> list[SchemeRun]:
    counts = QUICK_COUNTS if quick else COUNTS
    changes = GRIDS[slices] | {"numerics.face_slices": slices, "numerics.harmonics": 9}
    life = life_of(wear_problem("face_gear").scene(changes))
    progress.note(f"converged life, {slices} slices")
    converged = life.states("explicit", CONVERGED)[-1]
    runs = []
    for scheme in SCHEMES:
        for count in counts[scheme]:
            progress.note(f"{scheme} wear steps, {count} of them, {slices} slices")
            try:
                runs.append(life.run(scheme, count, converged))
            except ConvergenceError as error:
                failures.append(f"{count} {scheme} steps, {slices} slices: {error}")
    return runs


def _listed(counts: dict[str, int | None]) -> str:
    """What each scheme needs, and how many times fewer than explicit steps."""
    explicit, parts = counts["explicit"], []
    for scheme, count in counts.items():
        known = "more than were tried" if count is None else str(count)
        if scheme != "explicit" and count is not None and explicit is not None:
            known += f" (explicit over it: {figure_text(explicit / count, 2)})"
        parts.append(f"{scheme} {known}")
    return ", ".join(parts)


def _text(needed: dict[int, dict[str, dict[str, int | None]]]) -> str:
    lines = [
        f"<li>{slices} slices, {percent(WANTED[of])} in {OF[of]}: {_listed(counts)}.</li>"
        for slices, by_error in needed.items()
        for of, counts in by_error.items()
    ]
    return (
        "<p>The same life of the shipped scene on the same grid. An "
        "explicit step takes one solution of the loaded contact, an implicit one "
        f"{SOLVES_A_STEP['implicit']} (prediction, step, contact after it), one in two stages "
        f"{SOLVES_A_STEP['two-stage']} (prediction, both stages, contact after each). A number of steps keeps an "
        "error if it and every larger one tried do. The greatest wear is a single place, where the "
        "pinion's tip digs in at coarse steps; the error over the flank is the norm of the difference over that of "
        f"the wear. Converged: {CONVERGED} explicit steps. Solutions needed:</p><ul>{''.join(lines)}</ul>"
    )


def _chart(runs: Sequence[SchemeRun], of: str, over: str, label: str) -> Draw:
    def draw(ax: Any) -> None:
        for k, scheme in enumerate(SCHEMES):
            own = [run for run in runs if run.scheme == scheme]
            cost = [getattr(run, over) for run in own]
            error = [max(getattr(run, of), 1e-5) for run in own]
            ax.loglog(cost, error, marker=MARKERS[k], color=COLOURS[k], label=scheme)
        ax.axhline(WANTED[of], color="#555555", linewidth=1.0, linestyle=":")
        plain_log(ax.xaxis)
        plain_log(ax.yaxis, percent=True)
        ax.set_xlabel(label)
        ax.set_ylabel(f"Error of {OF[of]}")
        legend_above(ax, 3)

    return draw


def _table(runs: dict[int, list[SchemeRun]]) -> str:
    head = (
        "slices",
        "scheme",
        "steps",
        "solutions",
        "greatest wear",
        "its error",
        "error over the flank",
        "processor time [s]",
    )
    rows = [
        (
            str(slices),
            run.scheme,
            str(run.steps),
            str(run.solves),
            with_unit(run.greatest, "um"),
            percent(run.error),
            percent(run.flank_error),
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
            "flank_error": ([run.flank_error for _, run in flat], "1", "error of the wear over the flank"),
            "seconds": ([run.seconds for _, run in flat], "s", "processor time"),
        },
    )
