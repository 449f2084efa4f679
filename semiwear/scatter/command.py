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

from semiwear.errors import Problem, SceneError
from semiwear.plot.style import SIZE, step_colours, styled
from semiwear.report.markup import figure_text, table, unit_text
from semiwear.report.pictures import figure_uri
from semiwear.scatter.run import Sampling, read_scatter
from semiwear.scatter.statistics import SHARES, Scatter, end_text, varies
from semiwear.scene.values import is_number, shown
from semiwear.sweep.command import Ended, Prepared, prepare_sweep
from semiwear.sweep.page import QUANTITIES
from semiwear.sweep.run import Job
from semiwear.sweep.study_file import Study, flat_fields
from semiwear.untyped import Table, Value

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["SCATTER", "prepare_study"]

SCATTER = ("scatter", *(one.name for one in fields(Sampling)), "before_meshes")
"""Names that stand in a study file whose fields scatter."""

_MOST_PICTURES = 6
_MOST_SETTLING = 3


def prepare_study(study: Study, workers: int | str | None) -> Prepared:
    """A study that varies fields, or one whose fields scatter.

    Raises
    ------
    SceneError
        With all that is wrong with the fields.
    """
    given = study.tables
    if "scatter" not in given:
        lost = [Problem(name, shown(value), "beside a table [scatter]", "add it") for name, value in given.items()]
        if lost:
            raise SceneError(lost, str(study.path))
        return prepare_sweep(study, workers)
    problems: list[Problem] = []
    if study.vary:
        problems.append(Problem("vary", "beside [scatter]", "one of the two", "make two studies of it"))
    for name in ("wear_states", "combine"):
        if name in study.options:
            fix = "remove it: samples stand side by side, and of each the end of its run counts"
            problems.append(Problem(name, shown(study.options[name]), "left out beside [scatter]", fix))
    distributions = _fields(given["scatter"], problems)
    numbers = {one.name: given[one.name] for one in fields(Sampling) if one.name in given}
    sampling = Sampling(**{**numbers, "correlation": _correlation(given, problems)})
    before = _before(given, problems)
    ready = None
    try:
        measure = study.options.get("measure")
        ready = read_scatter(study.scene, distributions, sampling, measure=measure, crew=(workers, None))
    except SceneError as error:
        problems += error.problems
    if problems or ready is None:
        raise SceneError(problems, str(study.path))

    def ended(solve: Callable[[Job], xr.Dataset]) -> Ended:
        told = ready.told(solve)
        reached = told.reached_before(before)
        lines = [_in_words(reached, k) for k in range(len(before))]
        return Ended(told.samples, _whole(told, reached), "\n".join([str(told), *lines]), _sections(told, lines))

    return Prepared(study, ready.job, ended)


def _fields(raw: Value, problems: list[Problem]) -> Table:
    if not isinstance(raw, Mapping):
        problems.append(Problem("scatter", shown(raw), "a table", "write the header [scatter] above its fields"))
        return {}
    return dict(flat_fields(raw))


def _before(given: Table, problems: list[Problem]) -> list[float]:
    value = given.get("before_meshes", [])
    found = value if isinstance(value, list) else [value]
    wrong = [one for one in found if not is_number(one) or not one > 0.0]
    problems += [Problem("before_meshes", shown(one), "numbers above 0", "give e.g. [1e8, 1e9]") for one in wrong]
    return [] if wrong else [float(one) for one in found]


def _in_words(reached: xr.Dataset, k: int) -> str:
    one = reached.isel(before_meshes=k)
    share, low, high = (100.0 * float(one[name]) for name in ("probability", "probability_low", "probability_high"))
    ends, meshes = reached.attrs["ends"], float(one["before_meshes"])
    return f"{ends} before {meshes:.4g} meshes: {share:.3g} % ({low:.3g} to {high:.3g} %)"


def _correlation(given: Table, problems: list[Problem]) -> dict[tuple[str, str], float]:
    found: dict[tuple[str, str], float] = {}
    entries = given.get("correlation", [])
    for one in entries if isinstance(entries, list) else [entries]:
        fields = one.get("fields") if isinstance(one, Mapping) else None
        if not isinstance(fields, list) or len(fields) != 2 or set(one) != {"fields", "rank"}:
            allowed = "tables [[correlation]] with fields = [two fields] and rank = a number"
            problems.append(Problem("correlation", shown(one), allowed, "see docs/studies.md"))
        else:
            found[str(fields[0]), str(fields[1])] = one["rank"]
    return found


def _whole(told: Scatter, reached: xr.Dataset) -> xr.Dataset:
    """The samples with their statistics."""
    quantiles = told.quantiles().rename({name: f"quantile_{name}" for name in ("value", "low", "high", "units")})
    drawn = told.convergence().rename({name: f"convergence_{name}" for name in ("value", "low", "high")})
    if told.errors:
        quantiles["stated_error"] = ("quantity", [told.errors[name] for name in told.quantities])
    parts = [told.samples, quantiles, drawn, *([told.indices()] if told.paired else []), reached]
    whole = xr.merge(parts, compat="override", combine_attrs="drop")
    whole.attrs = {**told.samples.attrs, "confidence": told.confidence, "independent_samples": told.independent}
    return whole


def _sections(told: Scatter, probabilities: list[str]) -> list[tuple[str, str]]:
    listed = "".join(f"<li>{escape(line)}</li>" for line in probabilities)
    sections = [("Quantiles", _quantiles(told) + (f"<ul>{listed}</ul>" if listed else "") + _histograms(told))]
    settled = _convergence(told) + (_settling_indices(told) if told.paired else "")
    sections.append(("Have the samples settled?", settled))
    if told.paired:
        sections.append(("What matters", _tornado(told)))
    return sections


def _varying(told: Scatter) -> list[str]:
    names = []
    for name in told.quantities:
        values = told.values(name)
        if varies(values, 1e-9):
            names.append(name)
    main = list(QUANTITIES)
    return sorted(names, key=lambda name: main.index(name.split()[0]) if name.split()[0] in main else len(main))


def _quantiles(told: Scatter) -> str:
    rows = []
    for name in _varying(told):
        found = [told.quantile(name, share) for share in SHARES]
        units = unit_text(str(told.samples[name.partition(" ")[0]].attrs.get("units", "")))
        words = [
            [end_text(end, told.values(name), figure_text) for end in (one.value, one.low, one.high)] for one in found
        ]
        cells = [f"{value} ({low} to {high})" for value, low, high in words]
        errors = [figure_text(told.errors[name])] if told.errors else []
        rows.append([name, units or "–", *cells, *errors])
    heads = ["quantity", "unit", *(f"{100 * share:.0f} % fall short of" for share in SHARES)]
    heads += ["stated error of the emulator"] if told.errors else []
    caption = f"Quantiles of {told.independent} samples, in brackets with {100 * told.confidence:g} % confidence"
    solved = f"<p>{escape(said)}.</p>" if (said := told.emulation) else ""
    return solved + table(caption, heads, rows)


def _histograms(told: Scatter) -> str:
    figures = []
    for name in _varying(told)[:_MOST_PICTURES]:
        values = told.values(name)
        values = values[np.isfinite(values)]
        units = unit_text(str(told.samples[name.partition(" ")[0]].attrs.get("units", "")))

        def draw_on(ax, values=values, name=name, units=units):  # type: ignore[no-untyped-def]
            ax.hist(values, bins="auto", color="#0B5394", alpha=0.8)
            for share in SHARES:
                if np.isfinite(value := told.quantile(name, share).value):
                    ax.axvline(value, color="#A63C00", lw=1.0)
            ax.set(xlabel=f"{name} ({units})" if units else name, ylabel="Samples")

        figures.append(_figure(draw_on, f"Distribution of {name}", "Lines: 10, 50 and 90 % fall short of it."))
    return f'<div class="cards small">{"".join(figures)}</div>'


def _convergence(told: Scatter) -> str:
    """The least quantile of the main quantities from ever more samples: the one that settles last."""
    found, figures = told.convergence(), []
    for name in _varying(told)[:_MOST_SETTLING]:
        one = found.sel(quantity=name).isel(share=0)

        def draw_on(ax, one=one, name=name):  # type: ignore[no-untyped-def]
            drawn = one["samples_drawn"].values
            low, high = (np.where(np.isfinite(one[end].values), one[end].values, np.nan) for end in ("low", "high"))
            ax.fill_between(drawn, low, high, color="#0B5394", alpha=0.2)
            ax.plot(drawn, one["value"].values, "o-", color="#0B5394")
            ax.set_xscale("log", base=2)
            ax.set(xlabel="Samples drawn", ylabel=name)

        caption = f"{100 * SHARES[0]:.0f} % fall short of it, with its interval."
        figures.append(_figure(draw_on, f"Quantile of {name}", caption))
    return f'<div class="cards small">{"".join(figures)}</div>'


def _settling_indices(told: Scatter) -> str:
    """Total Sobol' indices of the main quantities from ever more samples of each set."""
    figures = []
    every = [told.indices(count) for count in told.drawn]
    for name in _varying(told)[:_MOST_SETTLING]:

        def draw_on(ax, name=name):  # type: ignore[no-untyped-def]
            for field, colour in zip(told.fields, step_colours(len(told.fields)), strict=False):
                one = [found.sel(quantity=name, field=field) for found in every]
                value, low, high = ([float(o[key]) for o in one] for key in ("total", "total_low", "total_high"))
                ax.fill_between(told.drawn, low, high, color=colour, alpha=0.15, lw=0)
                ax.plot(told.drawn, value, "o-", color=colour, label=field.rpartition(".")[2])
            ax.set_xscale("log", base=2)
            ax.set(xlabel="Samples drawn of each set", ylabel="Share of the variance")
            ax.legend()

        caption = "Total Sobol' indices with their intervals."
        figures.append(_figure(draw_on, f"What {name} depends on, from ever more samples", caption))
    return f'<div class="cards small">{"".join(figures)}</div>'


def _tornado(told: Scatter) -> str:
    figures, found = [], told.indices()
    for name in _varying(told)[:_MOST_PICTURES]:
        one = found.sel(quantity=name)

        def draw_on(ax, one=one):  # type: ignore[no-untyped-def]
            order = np.argsort(one["total"].values)
            place, fields = np.arange(order.size), one["field"].values[order]
            for shift, kind, colour in ((0.18, "total", "#0B5394"), (-0.18, "first_order", "#B07D00")):
                values = one[kind].values[order]
                ends = [one[f"{kind}_{end}"].values[order] for end in ("low", "high")]
                bars = np.abs(np.array([values - ends[0], ends[1] - values]))
                words = {"total": "with the others", "first_order": "alone"}[kind]
                ax.barh(place + shift, values, 0.34, color=colour, xerr=bars, label=words, ecolor="#333333")
            ax.set_yticks(place, [field.rpartition(".")[2] for field in fields])
            ax.set(xlabel="Share of the variance")
            ax.legend()

        figures.append(_figure(draw_on, f"What {name} depends on", "Sobol' indices with their intervals."))
    return f'<div class="cards small">{"".join(figures)}</div>'


def _figure(draw_on: Callable[[Axes], None], title: str, caption: str) -> str:
    with styled():
        uri = figure_uri(SIZE, 1, lambda axes: draw_on(*axes))
    size = f'width="{SIZE[0] * 100:.0f}" height="{SIZE[1] * 100:.0f}"'
    return (
        f'<article class="card"><figure><h3>{escape(title)}</h3><img src="{uri}" alt="{escape(title)}" {size}>'
        f"<figcaption>{escape(caption)}</figcaption></figure></article>"
    )
