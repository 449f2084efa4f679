"""Study files whose fields scatter: the table ``[scatter]`` of `semiwear sweep`.

samples = 256
sensitivity = true
emulate = 0.1                           # solve few samples and emulate the others, as `scatter` does
before_meshes = [1e8, 1e9]              # how likely is the end of the life, or of the run, before these?

[scatter]
wear.coefficient_mm2_per_N = {distribution = "lognormal"}     # about the scene's, by its usual variation
operation.pinion_torque_Nm = {distribution = "normal", mean = 1600, deviation = 80, low = 0.1}

[[correlation]]
fields = ["operation.pinion_torque_Nm", "effects.misalignment.offset_mm"]
rank = 0.5
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields
from html import escape
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.errors import Collected, Problem, SceneError
from semiwear.plain_text import unit_text
from semiwear.plot.style import SIZE, step_colours, styled
from semiwear.report.markup import card, figure_text, table
from semiwear.report.pictures import figure_uri
from semiwear.scatter.run import Sampling, read_scatter
from semiwear.scatter.statistics import SHARES, Scatter, end_text, varies
from semiwear.scene.values import is_number, shown
from semiwear.sweep.command import Ended, Prepared, prepare_sweep
from semiwear.sweep.page import QUANTITIES
from semiwear.sweep.run import Job
from semiwear.sweep.study_file import Study, table_of_fields
from semiwear.untyped import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCATTER = ("scatter", *(argument.name for argument in fields(Sampling)), "before_meshes")
"""Entries of a study file whose fields scatter."""

_MOST_PICTURES = 6
_MOST_SETTLING = 3


def prepare_study(study: Study, workers: int | str | None) -> Prepared:
    """A study that varies fields, or one whose fields scatter.

    Raises
    ------
    SceneError
        With all faults of the fields.
    """
    given, problems = study.tables, list[Problem]()
    if "scatter" not in given:
        allowed, varied = "beside a table [scatter]", None
        problems += [Problem(name, shown(value), allowed, "add it") for name, value in given.items()]
        with Collected(problems):
            varied = prepare_sweep(study, workers)
        if problems or varied is None:
            raise SceneError(problems, str(study.path))
        return varied
    if study.vary:
        problems.append(Problem("vary", "beside [scatter]", "one of the two", "make two studies of it"))
    for name in ("wear_states", "combine"):
        if name in study.options:
            fix = "remove it: samples stand side by side, and of each the end of its run counts"
            problems.append(Problem(name, shown(study.options[name]), "left out beside [scatter]", fix))
    distributions = table_of_fields(given["scatter"])
    numbers = {argument.name: given[argument.name] for argument in fields(Sampling) if argument.name in given}
    sampling = Sampling(**{**numbers, "correlation": _correlation(given, problems)})
    before = _before(given, problems)
    ready = None
    with Collected(problems):
        measure = study.options.get("measure")
        ready = read_scatter(
            study.scene, distributions, sampling, measure=measure, crew=(workers, None), argument="scatter"
        )
    if problems or ready is None:
        raise SceneError(problems, str(study.path))

    def ended(solve: Callable[[Job], xr.Dataset]) -> Ended:
        found = ready.statistics(solve)
        reached = found.reached_before(before)
        lines = [_in_words(reached, k) for k in range(len(before))]
        return Ended(found.samples, _whole(found, reached), "\n".join([str(found), *lines]), _sections(found, lines))

    return Prepared(ready.job, ended)


def _before(given: Table, problems: list[Problem]) -> list[float]:
    value = given.get("before_meshes", [])
    found = value if isinstance(value, list) else [value]
    wrong = [meshes for meshes in found if not is_number(meshes) or not meshes > 0.0]
    problems += [
        Problem("before_meshes", shown(meshes), "numbers above 0", "give e.g. [1e8, 1e9]") for meshes in wrong
    ]
    return [] if wrong else [float(meshes) for meshes in found]


def _in_words(reached: xr.Dataset, k: int) -> str:
    entry = reached.isel(before_meshes=k)
    share, low, high = (100.0 * float(entry[name]) for name in ("probability", "probability_low", "probability_high"))
    ends, meshes = reached.attrs["ends"], float(entry["before_meshes"])
    return f"{ends} before {meshes:.4g} meshes: {share:.3g} % ({low:.3g} to {high:.3g} %)"


def _correlation(given: Table, problems: list[Problem]) -> dict[tuple[str, str], float]:
    found: dict[tuple[str, str], float] = {}
    entries = given.get("correlation", [])
    for entry in entries if isinstance(entries, list) else [entries]:
        fields = entry.get("fields") if isinstance(entry, Mapping) else None
        if not isinstance(fields, list) or len(fields) != 2 or set(entry) != {"fields", "rank"}:
            allowed = "tables [[correlation]] with fields = [two fields] and rank = a number"
            problems.append(Problem("correlation", shown(entry), allowed, "see docs/studies.md"))
        else:
            found[str(fields[0]), str(fields[1])] = entry["rank"]
    return found


def _whole(scatter: Scatter, reached: xr.Dataset) -> xr.Dataset:
    """The samples with their statistics."""
    quantiles = scatter.quantiles().rename({name: f"quantile_{name}" for name in ("value", "low", "high", "units")})
    drawn = scatter.convergence().rename({name: f"convergence_{name}" for name in ("value", "low", "high")})
    if scatter.errors:
        quantiles["stated_error"] = ("quantity", [scatter.errors[name] for name in scatter.quantities])
    parts = [scatter.samples, quantiles, drawn, *([scatter.indices()] if scatter.paired else []), reached]
    whole = xr.merge(parts, compat="override", combine_attrs="drop")
    whole.attrs = {
        **scatter.samples.attrs,
        "confidence": scatter.confidence,
        "independent_samples": scatter.independent,
    }
    return whole


def _sections(scatter: Scatter, probabilities: list[str]) -> list[tuple[str, str]]:
    listed = "".join(f"<li>{escape(line)}</li>" for line in probabilities)
    sections = [("Quantiles", _quantiles(scatter) + (f"<ul>{listed}</ul>" if listed else "") + _histograms(scatter))]
    settled = _convergence(scatter) + (_settling_indices(scatter) if scatter.paired else "")
    sections.append(("Have the samples settled?", settled))
    if scatter.paired:
        sections.append(("Sensitivities", _tornado(scatter)))
    return sections


def _varying(scatter: Scatter) -> list[str]:
    names = [name for name in scatter.quantities if varies(scatter.values(name), 1e-9)]
    main = list(QUANTITIES)
    return sorted(names, key=lambda name: main.index(name.split()[0]) if name.split()[0] in main else len(main))


def _quantiles(scatter: Scatter) -> str:
    rows = []
    for name in _varying(scatter):
        found = [scatter.quantile(name, share) for share in SHARES]
        units = unit_text(str(scatter.samples[name.partition(" ")[0]].attrs.get("units", "")))
        words = [
            [
                end_text(end, scatter.values(name), figure_text)
                for end in (estimate.value, estimate.low, estimate.high)
            ]
            for estimate in found
        ]
        cells = [f"{value} ({low} to {high})" for value, low, high in words]
        errors = [figure_text(scatter.errors[name])] if scatter.errors else []
        rows.append([name, units or "–", *cells, *errors])
    heads = ["quantity", "unit", *(f"{100 * share:.0f} % fall short of" for share in SHARES)]
    heads += ["stated error of the emulator"] if scatter.errors else []
    caption = (
        f"Quantiles of {scatter.independent} samples, in brackets with {100 * scatter.confidence:g} % confidence"
    )
    solved = f"<p>{escape(text)}.</p>" if (text := scatter.emulation) else ""
    return solved + table(caption, heads, rows)


def _histograms(scatter: Scatter) -> str:
    figures = []
    for name in _varying(scatter)[:_MOST_PICTURES]:
        values = scatter.values(name)
        values = values[np.isfinite(values)]
        units = unit_text(str(scatter.samples[name.partition(" ")[0]].attrs.get("units", "")))

        def draw_on(ax, values=values, name=name, units=units):  # type: ignore[no-untyped-def]
            ax.hist(values, bins="auto", color="#0B5394", alpha=0.8)
            for share in SHARES:
                if np.isfinite(value := scatter.quantile(name, share).value):
                    ax.axvline(value, color="#A63C00", lw=1.0)
            ax.set(xlabel=f"{name} ({units})" if units else name, ylabel="Samples")

        figures.append(_figure(draw_on, f"Distribution of {name}", "Lines: 10, 50 and 90 % fall short of it."))
    return _cards(figures)


def _convergence(scatter: Scatter) -> str:
    """The least quantile of the main quantities from ever more samples, which settles last."""
    found, figures = scatter.convergence(), []
    for name in _varying(scatter)[:_MOST_SETTLING]:
        course = found.sel(quantity=name).isel(share=0)

        def draw_on(ax, course=course, name=name):  # type: ignore[no-untyped-def]
            drawn = course["samples_drawn"].values
            low, high = (
                np.where(np.isfinite(course[end].values), course[end].values, np.nan) for end in ("low", "high")
            )
            ax.fill_between(drawn, low, high, color="#0B5394", alpha=0.2)
            ax.plot(drawn, course["value"].values, "o-", color="#0B5394")
            ax.set_xscale("log", base=2)
            ax.set(xlabel="Samples drawn", ylabel=name)

        caption = f"{100 * SHARES[0]:.0f} % fall short of it, with its interval."
        figures.append(_figure(draw_on, f"Quantile of {name}", caption))
    return _cards(figures)


def _settling_indices(scatter: Scatter) -> str:
    """Total Sobol' indices of the main quantities from ever more samples of each set."""
    figures = []
    every = [scatter.indices(count) for count in scatter.drawn]
    for name in _varying(scatter)[:_MOST_SETTLING]:

        def draw_on(ax, name=name):  # type: ignore[no-untyped-def]
            for field, colour in zip(scatter.fields, step_colours(len(scatter.fields)), strict=False):
                by_count = [found.sel(quantity=name, field=field) for found in every]
                value, low, high = ([float(o[key]) for o in by_count] for key in ("total", "total_low", "total_high"))
                ax.fill_between(scatter.drawn, low, high, color=colour, alpha=0.15, lw=0)
                ax.plot(scatter.drawn, value, "o-", color=colour, label=field.rpartition(".")[2])
            ax.set_xscale("log", base=2)
            ax.set(xlabel="Samples drawn of each set", ylabel="Share of the variance")
            ax.legend()

        caption = "Total Sobol' indices with their intervals."
        figures.append(_figure(draw_on, f"What {name} depends on, from ever more samples", caption))
    return _cards(figures)


def _tornado(scatter: Scatter) -> str:
    figures, found = [], scatter.indices()
    for name in _varying(scatter)[:_MOST_PICTURES]:
        indices = found.sel(quantity=name)

        def draw_on(ax, indices=indices):  # type: ignore[no-untyped-def]
            order = np.argsort(indices["total"].values)
            place, fields = np.arange(order.size), indices["field"].values[order]
            for shift, kind, colour in ((0.18, "total", "#0B5394"), (-0.18, "first_order", "#B07D00")):
                values = indices[kind].values[order]
                ends = [indices[f"{kind}_{end}"].values[order] for end in ("low", "high")]
                bars = np.abs(np.array([values - ends[0], ends[1] - values]))
                words = {"total": "with the others", "first_order": "alone"}[kind]
                ax.barh(place + shift, values, 0.34, color=colour, xerr=bars, label=words, ecolor="#333333")
            ax.set_yticks(place, [field.rpartition(".")[2] for field in fields])
            ax.set(xlabel="Share of the variance")
            ax.legend()

        figures.append(_figure(draw_on, f"What {name} depends on", "Sobol' indices with their intervals."))
    return _cards(figures)


def _cards(figures: list[str]) -> str:
    return f'<div class="cards small">{"".join(figures)}</div>'


def _figure(draw_on: Callable[[Axes], None], title: str, caption: str) -> str:
    with styled():
        uri = figure_uri(SIZE, 1, lambda axes: draw_on(*axes))
    return card(title, uri, title, caption, SIZE)
