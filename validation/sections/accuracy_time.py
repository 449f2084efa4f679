"""Accuracy against time: what an error costs, by fidelity, and when an accuracy is asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.errors import SemiwearError
from semiwear.report.markup import figure_text, table
from validation import finite_elements as store
from validation.accuracy_time import Asked, Point, asked_for, cold_seconds, cost_of_a_digit, points_of
from validation.charts import COLOURS, MARKERS, Draw, card, cards, legend_above, pareto, plain_log
from validation.error_time import BEFORE, stored
from validation.problems import Figure, Problems, wear_problem
from validation.progress import Progress
from validation.section import Section
from validation.sections.finite_elements import summary
from validation.tables import dataset, failures_note, listed, percent, with_unit

TITLE = "Accuracy against time"
ACCURACIES = (0.1, 0.03, 0.01, 0.003)
_LEAST = 1e-5  # errors below are drawn here: references are no better
_OUT_OF_REACH = 1000.0  # times the time: a slope that says no more than that there is none


@dataclass(frozen=True)
class FiniteElementCost:
    """What stored finite elements took.

    Attributes
    ----------
    seconds : float
        Of one wear state: a mesh cycle on the worn flank of the shipped scene; not a number where none is stored.
    positions : int
        Mesh positions of that cycle.
    errors : dict of str to float
        Of figures at their greatest, against the stored case with more elements; empty without it.
    note : str
        What is stored and what is not.
    """

    seconds: float
    positions: int
    errors: dict[str, float]
    note: str


def build(problems: Problems, quick: bool, progress: Progress) -> Section:
    """Solve the wear problems by all methods at all settings."""
    points: list[Point] = []
    failures: list[str] = []
    references: dict[str, xr.DataTree] = {}
    for problem in problems.wear:
        for method in problems.methods:
            if method.name.endswith("marched") and not problem.marches:
                continue
            found, reference, not_solved = points_of(problem, method, problems.figures, quick, progress)
            points += found
            failures += not_solved
            if method.name == "line" and reference is not None:
                references[problem.name] = reference
    asked: list[Asked] = []
    with_reference = [problem for problem in problems.wear if problem.name in references]
    for problem in with_reference[:1] if quick else with_reference:
        accuracies = ACCURACIES[:1] if quick else ACCURACIES
        if problem is not with_reference[0]:
            accuracies = accuracies[:-1]  # the last digit takes minutes
        for accuracy in accuracies:
            progress.note(f"{problem.name}, accuracy {accuracy:g} asked for")
            try:
                asked.append(asked_for(problem, references[problem.name], accuracy))
            except SemiwearError as error:
                failures.append(f"{problem.name}, accuracy {accuracy:g} asked for: {error}")
    progress.note("a new process")
    cold = {"kernels cached": cold_seconds(empty=False)}
    if not quick:
        cold["kernels compiled"] = cold_seconds(empty=True)
    elements = finite_element_cost()

    drawn = [
        card(
            f"time-{problem.name}-{figure.name.replace(' ', '-')}",
            f"{figure.name.capitalize()}: {problem.title}",
            "Error against the converged run of the same method. Broad: no other point is better in both. Dashed: "
            "the best of lines before wear steps were made faster, timed on another day.",
            _error_over_time([p for p in points if p.problem == problem.name], figure, elements, problem.name),
        )
        for problem in problems.wear
        for figure in problems.figures
    ]
    html = (
        _intro(quick, elements)
        + failures_note(failures)
        + cards(drawn)
        + _digits(points, problems)
        + _points_table(points, problems.figures)
        + _asked_html(asked)
        + _cold_html(cold)
    )
    data = {"points": _points_data(points, problems.figures), "asked": _asked_data(asked)}
    data["cold"] = dataset(
        {"process": list(cold)},
        {
            "import": ([one[0] for one in cold.values()], "s", "import of semiwear"),
            "simulate": ([one[1] for one in cold.values()], "s", "main job of the shipped scene"),
        },
    )
    return Section(_found(points, asked), html, data)


# ---- words


def _found(points: Sequence[Point], asked: Sequence[Asked]) -> tuple[str, ...]:
    texts = []
    for method in dict.fromkeys(point.method for point in points):
        own = [point for point in points if point.method == method and not point.converged]
        fast = [point.seconds for point in own if point.worst <= 0.05]
        missed = len({point.problem for point in own}) - len({p.problem for p in own if p.worst <= 0.05})
        if fast:
            text = f"{method} has every figure within 5 % of its converged value in {with_unit(min(fast), 's', 2)}"
            text += f" at best ({missed} of the problems not at the settings tried)" if missed else " at best"
            texts.append(text)
        else:
            texts.append(f"{method} has no setting here with every figure within 5 %")
    kept = [one for one in asked if one.claimed]
    good = [one for one in kept if one.found <= one.asked]
    second = f"Runs that asked for an accuracy: {len(asked)}; that claim it: {len(kept)}"
    if kept:
        ratio = max(one.found / one.asked for one in kept)
        second += f"; that keep it: {len(good)}, the error found being at most {figure_text(ratio, 2)} of the asked"
    return f"Warm and on one core: {'; '.join(texts)}.", second + "."


def _intro(quick: bool, elements: FiniteElementCost) -> str:
    return (
        "<p>Each problem is worn for a fixed number of meshes. An error is that of the greatest wear, the greatest "
        "pressure clear of edges, the greatest root stress or the mean transmission error, all after the last wear "
        "step, against the converged run of the same fidelity: a finer setting than all that are swept"
        + (", in this quick report not by much" if quick else "")
        + f": see the table of all runs. {elements.note}</p>"
    )


def _next_digit(factor: float | None) -> str:
    if factor is None or factor > _OUT_OF_REACH:
        return "more time brings hardly less error here."
    return f"the next digit, a tenth of the error, would cost {figure_text(factor, 2)} times the time."


def _digits(points: Sequence[Point], problems: Problems) -> str:
    words = []
    for problem in problems.wear:
        for method in problems.methods:
            own = [point for point in points if (point.problem, point.method) == (problem.name, method.name)]
            if len(own) < 3:
                continue
            factor = cost_of_a_digit(own)
            best = min((point for point in own if not point.converged), key=lambda point: point.worst)
            words.append(
                f"<li>{problem.title}, {method.name}: the best setting is within {percent(best.worst)} in "
                f"{with_unit(best.seconds, 's', 2)}; " + _next_digit(factor) + "</li>"
            )
    return (
        "<h3>What the next digit costs</h3><p>From a straight line through the logarithms of time and of the worst "
        f"of the four errors, over the settings that no other beats.</p><ul>{''.join(words)}</ul>"
    )


# ---- charts and tables


def _error_over_time(points: Sequence[Point], figure: Figure, elements: FiniteElementCost, problem: str) -> Draw:
    swept = [point for point in points if not point.converged]
    before = stored(BEFORE, problem)

    def draw(ax: Any) -> None:
        seconds = np.array([point.seconds for point in swept])
        error = np.maximum([point.errors[figure.name] for point in swept], _LEAST)
        front = pareto(seconds, error)
        ax.step(seconds[front], error[front], where="post", color="#BBBBBB", linewidth=5.0, zorder=0)
        took, left = np.array([(one.seconds, max(one.errors[figure.name], _LEAST)) for one in before]).T
        best = pareto(took, left)
        ax.plot(took[best], left[best], "--", marker=".", color="#777777", linewidth=1.0, label="line, before")
        for k, method in enumerate(dict.fromkeys(point.method for point in swept)):
            own = np.array([point.method == method for point in swept])
            ax.plot(seconds[own], error[own], marker=MARKERS[k], color=COLOURS[k], linewidth=1.0, label=method)
        if problem == "face_gear" and np.isfinite(elements.seconds):
            if figure.name in elements.errors:
                ax.plot(elements.seconds, max(elements.errors[figure.name], _LEAST), "X", color=COLOURS[6],
                        markersize=9, label="finite elements, one state")  # fmt: skip
            else:
                ax.axvline(elements.seconds, color=COLOURS[6], linestyle=":", label="finite elements, one state")
        ax.set_xscale("log")
        ax.set_yscale("log")
        plain_log(ax.xaxis)
        plain_log(ax.yaxis, percent=True)
        ax.set_xlabel("Processor time, warm (s)")
        ax.set_ylabel(f"Error of {figure.name}")
        legend_above(ax)

    return draw


def _points_table(points: Sequence[Point], figures: Sequence[Figure]) -> str:
    head = ("problem", "method", "roll positions x slices, wear steps", "time [s]",
            *(f"{f.name} [{f.units}]" for f in figures),
            *(f"error, {f.name}" for f in figures))  # fmt: skip
    rows = [
        (
            point.problem.replace("_", " "),
            point.method,
            point.setting.label.removesuffix(" steps") + (" (converged)" if point.converged else ""),
            figure_text(point.seconds, 2),
            *(figure_text(point.values[figure.name]) for figure in figures),
            *("–" if point.converged else percent(point.errors[figure.name]) for figure in figures),
        )
        for point in points
    ]
    return table("All runs", head, rows)


def _asked_html(asked: Sequence[Asked]) -> str:
    rows = [
        (
            wear_problem(one.problem).title,
            percent(one.asked),
            percent(one.found),
            percent(one.estimated),
            figure_text(one.seconds, 3),
            "yes" if one.claimed else "no",
            one.quantity.replace("_", " "),
            "kept" if one.found <= one.asked else f"{figure_text(one.found / one.asked, 2)} times",
        )
        for one in asked
    ]
    marks = ["agree" if one.found <= one.asked else "disagree" if one.claimed else "not-compared" for one in asked]
    head = (
        "problem",
        "asked for",
        "found",
        "estimated",
        "processor time [s]",
        "claimed",
        "worst quantity",
        "outcome",
    )
    text = (
        "<h3>Error asked for, error found</h3><p><code>numerics.accuracy</code> chooses every number; the error "
        "found is the greatest of all reported quantities at the last wear step, over the greatest value of its "
        "kind, against the converged run at fidelity <code>line</code>, which errs itself. A run that cannot reach "
        "what was asked says so.</p>"
    )
    return text + table("Accuracy asked for", head, rows, marks)


def _cold_html(cold: Mapping[str, tuple[float, float]]) -> str:
    rows = [(name, figure_text(first, 2), figure_text(second, 3)) for name, (first, second) in cold.items()]
    text = (
        "<h3>Cold</h3><p>A new process, in seconds of the processor: the import, then the main job of the shipped "
        "scene, tooth compliance included. With an empty cache the kernels are compiled first, once after an "
        "installation.</p>"
    )
    return text + table("A new process", ("process", "import [s]", "main job [s]"), rows)


# ---- finite elements


def finite_element_cost() -> FiniteElementCost:
    """Seconds and discretisation error of the stored finite elements of the shipped scene."""
    scene = sw.load_scene(store.SCENE)
    try:
        worn = store.read("worn", scene)
    except (FileNotFoundError, SemiwearError) as reason:
        return FiniteElementCost(np.nan, 0, {}, f"No finite-element time: {reason}.")
    positions = worn["mesh_cycle"].sizes["mesh_position"]
    seconds = float(worn.attrs.get("seconds", np.nan))
    text = f"Finite elements took {with_unit(seconds, 's')} for one wear state of the shipped scene at {positions} "
    text += "mesh positions (stored)"
    try:
        finer = store.read("finer", scene)
    except (FileNotFoundError, SemiwearError):
        none = "; none with more elements is stored, so that their own error is unknown: a line marks the time."
        return FiniteElementCost(seconds, positions, {}, text + none)
    rows = summary(store.contact_rows(worn, finer))
    errors = {}
    for name, variable in (("peak pressure", "contact_pressure_max"), ("root stress", "root_stress"),
                           ("transmission error", "transmission_error_loaded")):  # fmt: skip
        own = [one.greatest for key, one in rows.items() if key.startswith(variable) and not key.endswith("edge")]
        if own:
            errors[name] = abs(max(own, key=lambda row: abs(row.reference)).difference)
    known = listed([f"{name} {percent(error)}" for name, error in errors.items()])
    return FiniteElementCost(
        seconds, positions, errors, f"{text}; at the greatest values more elements change {known}."
    )


# ---- data


def _points_data(points: Sequence[Point], figures: Sequence[Figure]) -> xr.Dataset:
    columns: dict[str, Any] = {
        "problem": ([point.problem for point in points], "1", "problem"),
        "method": ([point.method for point in points], "1", "method"),
        "converged": ([point.converged for point in points], "1", "whether it counts as converged"),
        "seconds": ([point.seconds for point in points], "s", "processor time, warm"),
    }
    for name in (
        "roll_positions",
        "face_slices",
        "profile_points",
        "harmonics",
        "wear_steps",
        "cells_per_half_width",
    ):
        columns[name] = ([getattr(point.setting, name) for point in points], "1", name.replace("_", " "))
    for figure in figures:
        name = figure.name.replace(" ", "_")
        columns[name] = ([point.values[figure.name] for point in points], figure.units, figure.name)
        columns[f"{name}_error"] = ([point.errors[figure.name] for point in points], "1", f"error of {figure.name}")
    return dataset({"run": np.arange(len(points))}, columns)


def _asked_data(asked: Sequence[Asked]) -> xr.Dataset:
    return dataset(
        {"run": np.arange(len(asked))},
        {
            "problem": ([one.problem for one in asked], "1", "problem"),
            "asked": ([one.asked for one in asked], "1", "accuracy asked for"),
            "found": ([one.found for one in asked], "1", "error found"),
            "estimated": ([one.estimated for one in asked], "1", "error as the result says"),
            "seconds": ([one.seconds for one in asked], "s", "processor time"),
            "claimed": ([one.claimed for one in asked], "1", "whether the result claims it"),
            "quantity": ([one.quantity for one in asked], "1", "quantity with the greatest error"),
        },
    )
