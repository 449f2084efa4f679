"""Sections of a report that consist of tables and text."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from html import escape

import numpy as np
import xarray as xr

from semiwear.plain_text import unit_text
from semiwear.report.markup import NONE, element, figure_text, table
from semiwear.results.missing import group_of, missing_notes
from semiwear.results.schema import VARIABLES
from semiwear.results.wearing import shown_bodies
from semiwear.untyped import Value

_MOST_COLUMNS = 7  # wear steps in one table

_OF_GEAR = tuple(f"wear_depth_max_{zone}" for zone in ("root", "addendum", "pitch"))


def inputs(scene: Mapping[str, Value], scene_toml: str) -> str:
    """The scene as tables, and its text."""
    tables = "".join(
        table(f"[{name}]" if name else "scene", ("field", "value"), rows)
        for name, rows in _scene_tables(scene)
        if rows
    )
    raw = f"<details><summary>Scene as TOML</summary>{_text('Scene as TOML', scene_toml)}</details>"
    return element("div", tables, class_="scene") + raw


def _scene_tables(scene: Mapping[str, Value], prefix: str = "") -> Iterator[tuple[str, list[tuple[str, str]]]]:
    yield prefix, [(key, _value(value)) for key, value in scene.items() if not isinstance(value, Mapping)]
    for key, value in scene.items():
        if isinstance(value, Mapping):
            yield from _scene_tables(value, f"{prefix}.{key}" if prefix else key)


def _value(value: Value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return ", ".join(map(_value, value))
    return str(value)


def physics(attrs: Mapping[str, str]) -> str:
    """Section on the physics that ran and why, at which fidelity and accuracy."""
    facts = f"<p>Fidelity: <b>{escape(attrs.get('fidelity', 'not stated'))}</b>; "
    facts += f"accuracy: {escape(attrs.get('accuracy', 'not asked for'))}.</p>"
    return facts + _text("Physics", attrs.get("physics", "not stated"))


def _text(name: str, text: str) -> str:
    """Preformatted text that scrolls sideways by itself."""
    return element("pre", escape(text), tabindex="0", role="region", aria_label=name)


def wear_steps(tree: xr.DataTree) -> str:
    """Tables of `/history`: one row per quantity, one column per wear step."""
    if "history" not in tree.children:
        return ""
    history = tree["history"].to_dataset()
    head, columns = ["wear step", "meshes"], [history["wear_step"].values, history["meshes"].values]
    worn = shown_bodies(tree)
    for name, array in history.data_vars.items():
        if str(name) in _OF_GEAR and "gear" not in worn:
            continue
        if str(name) == "wear_depth_max_pinion" and "wear_depth_max" in history:
            continue  # part of wear_depth_max
        for body in history["body"].values if "body" in array.dims else ("",):
            head.append(_row_name(str(name), array, str(body)))
            columns.append((array.sel(body=body) if body else array).values)
    notes = "".join(
        f"<p>{NONE} {escape(name.replace('_', ' '))}: {escape(why)}.</p>"
        for name, why in missing_notes(history).items()
    )
    return "".join(_steps(head, columns, first) for first in range(0, len(columns[0]), _MOST_COLUMNS)) + notes


def _steps(head: list[str], columns: list[np.ndarray], first: int) -> str:
    """Table of a few wear steps, one column each, that fits on paper."""
    last = min(first + _MOST_COLUMNS, len(columns[0])) - 1
    texts = [[figure_text(value) for value in column[first : last + 1]] for column in columns]
    rows = [[name, *values] for name, values in zip(head[1:], texts[1:], strict=True)]
    steps = f"{first} to {last}" if last > first else str(first)
    return table(f"Every wear step: {steps}", ("wear step", *texts[0]), rows)


def _row_name(name: str, array: xr.DataArray, body: str) -> str:
    title = name.replace("_", " ") + (f" {body}" if body else " gear" if name in _OF_GEAR else "")
    units = unit_text(array.attrs["units"])
    return f"{title} ({units})" if units else title


def _head(name: str, array: xr.DataArray) -> str:
    units = unit_text(array.attrs["units"])
    shown = escape(name.replace("_", " ")) + (f"<br><small>{escape(units)}</small>" if units else "")
    return f'<span title="{escape(array.attrs["long_name"])}">{shown}</span>'


def diagnostics(tree: xr.DataTree) -> str:
    """Residuals, iterations, error estimates and times."""
    if "diagnostics" not in tree.children:
        return "<p>The result holds no diagnostics.</p>"
    found = tree["diagnostics"].to_dataset()
    parts = []
    per_step = [str(name) for name, array in found.data_vars.items() if array.dims == ("wear_step",)]
    if per_step:
        columns = [found["wear_step"].values, *(found[name].values for name in per_step)]
        rows = [[figure_text(value, 3) for value in row] for row in zip(*columns, strict=True)]
        parts.append(table("Solver", ["wear step", *(_head(name, found[name]) for name in per_step)], rows))
    if "seconds" in found:
        stages = zip(found["stage"].values, found["seconds"].values, strict=True)
        seconds = [(str(stage), f"{float(spent):.2f}") for stage, spent in stages]
        seconds.append(("total", f"{float(found['seconds'].sum()):.2f}"))
        parts.append(table("Time", ("stage", "s"), seconds))
    if "error_estimate" in found:
        errors = zip(found["quantity"].values, found["error_estimate"].values, strict=True)
        rows = [[str(name).replace("_", " "), f"{float(error):.2%}"] for name, error in errors]
        parts.append(table("Estimated relative error", ("quantity", "error"), rows))
    return element("div", "".join(parts), class_="side-by-side")


def references(tree: xr.DataTree) -> str:
    """Published sources of the physics that ran, then those of the quantities; each work once, in its longest form.

    Quantities of the diagnostics are not included.
    """
    ran = [line.strip() for line in tree.attrs.get("references", "").splitlines() if line.strip()]
    quantities: list[str] = []
    for group in (name for name in tree.children if name != "diagnostics"):
        for name in tree[group].to_dataset().data_vars:
            entry = VARIABLES.get((group, str(name)))
            if entry is not None and " of this run" not in entry.references:
                quantities.extend(entry.references.split("; "))
    works: dict[str, str] = {}
    for line in (*ran, *quantities):
        work = _work(line)
        works[work] = max(works.get(work, ""), line, key=len)
    listed = "".join(f"<li>{escape(line)}</li>" for line in works.values())
    return f"<ol>{listed}</ol>" if listed else "<p>None.</p>"


def _work(line: str) -> str:
    """Key of a work: the number of a standard, otherwise authors and year."""
    named = re.match(r"ISO\S* [\d-]+|.*?\b(1[6-9]|20)\d\d\b", line)
    return named[0] if named else line


def residual_note(tree: xr.DataTree) -> str:
    """The greatest residuals in one sentence."""
    found = group_of(tree, "diagnostics")
    parts = [
        f"{found[name].attrs['long_name']} {figure_text(float(np.max(found[name].values)), 3)}"
        for name in ("load_balance_residual", "complementarity_residual", "edge_residual", "wear_law_residual")
        if name in found
    ]
    return f"<p>Greatest residuals: {escape('; '.join(parts))}.</p>" if parts else ""
