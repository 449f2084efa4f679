"""Sections of a report that are numbers and text."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from html import escape

import numpy as np
import xarray as xr

from semiwear.report.markup import NONE, element, figure_text, table, tiles, unit_text, with_unit
from semiwear.results.missing import group_of, missing_notes
from semiwear.results.pressing_tips import pressing_tips
from semiwear.results.schema import VARIABLES
from semiwear.results.wearing import control_place, main_body, pitch_surface, worn_bodies
from semiwear.untyped import Value

__all__ = [
    "diagnostics",
    "inputs",
    "key_numbers",
    "physics",
    "references",
    "residual_note",
    "tips_that_press",
    "wear_steps",
]


_OF_GEAR = tuple(f"wear_depth_max_{zone}" for zone in ("root", "addendum", "pitch"))


def key_numbers(tree: xr.DataTree) -> str:
    """Tiles with the main numbers of the last wear step, the first beside them."""
    return tiles(_key_numbers(tree))


def _key_numbers(tree: xr.DataTree) -> Iterator[tuple[str, str, str]]:
    if "flank" in tree.children:
        flank = tree["flank"].to_dataset().isel(wear_step=-1)
        for body in worn_bodies(tree) or (main_body(tree),):
            own = flank.sel(body=body)
            values = own["wear_depth"].values
            place = np.unravel_index(int(values.argmax()), values.shape)
            height = float(own["flank_height"].values[place])
            where = f"{abs(height):.2f} mm {'above' if height >= 0.0 else 'below'} the {pitch_surface(tree, body)}"
            note = where if values.any() else "at the last wear step"
            yield f"Greatest wear, {body}", f"{values.max():.3g} µm", note
    if "history" not in tree.children:
        return
    history = tree["history"].to_dataset()
    meshes = history["meshes"].values
    yield "Meshes of a gear tooth", figure_text(meshes[-1], 4), f"in {meshes.size - 1} wear steps"
    shown = {
        "wear_depth_control_point": "Wear at the control point",
        "load_share_max": "Greatest load share",
        "transmission_error_mean": "Transmission error, mean",
        "transmission_error_amplitude": "Transmission error, amplitude",
    }
    for name, title in shown.items():
        if name in history:
            point = control_place(tree) if name == "wear_depth_control_point" else None
            yield _first_and_last(f"{title}, {point.body}" if point else title, history[name])
    if "subsurface_stress_max" in history:
        title, value, note = _first_and_last("Stress below the surface", history["subsurface_stress_max"])
        if "subsurface_stress_depth" in history:
            depth = figure_text(float(history["subsurface_stress_depth"][-1]), 3)
            note = f"{depth} mm deep" + (f"; {note}" if note else "")
        yield title, value, note
    if "root_stress_max" in history:
        for body in history["body"].values:
            yield _first_and_last(f"Root stress, {body}", history["root_stress_max"].sel(body=body))


def _first_and_last(title: str, series: xr.DataArray) -> tuple[str, str, str]:
    first, last = (with_unit(float(series[step]), series.attrs["units"]) for step in (0, -1))
    return title, last, f"{first} unworn" if series.size > 1 else ""


def inputs(scene: Mapping[str, Value], scene_toml: str) -> str:
    """The scene as tables, and its text."""
    tables = "".join(
        table(f"[{name}]" if name else "scene", ("field", "value"), rows)
        for name, rows in _scene_tables(scene)
        if rows
    )
    raw = f"<details><summary>Scene as TOML</summary><pre>{escape(scene_toml)}</pre></details>"
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
    return f"{facts}<pre>{escape(attrs.get('physics', 'not stated'))}</pre>"


def tips_that_press(tree: xr.DataTree) -> str:
    """Section on tips that press, where, and the relief that frees them; empty where none does."""
    return "".join(f"<p>{escape(text).replace(' um ', ' µm ')}</p>" for text in pressing_tips(tree))


def wear_steps(tree: xr.DataTree) -> str:
    """One row a wear step with everything that `/history` holds."""
    history = tree["history"].to_dataset()
    head, columns = ["wear step", "meshes"], [history["wear_step"].values, history["meshes"].values]
    worn = worn_bodies(tree) or (main_body(tree),)
    for name, array in history.data_vars.items():
        if str(name) in _OF_GEAR and "gear" not in worn:
            continue
        if str(name) == "wear_depth_max_pinion" and "wear_depth_max" in history:
            continue  # it is there among both bodies'
        for body in history["body"].values if "body" in array.dims else ("",):
            head.append(_head(str(name), array, str(body)))
            columns.append((array.sel(body=body) if body else array).values)
    rows = [[figure_text(value) for value in row] for row in zip(*columns, strict=True)]
    notes = "".join(
        f"<p>{NONE} {escape(name.replace('_', ' '))}: {escape(why)}.</p>"
        for name, why in missing_notes(history).items()
    )
    return table("Every wear step", head, rows) + notes


def _head(name: str, array: xr.DataArray, body: str = "") -> str:
    words = name.replace("_", " ") + (f" {body}" if body else " gear" if name in _OF_GEAR else "")
    units = unit_text(array.attrs["units"])
    shown = escape(words) + (f"<br><small>{escape(units)}</small>" if units else "")
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
        seconds.append(("together", f"{float(found['seconds'].sum()):.2f}"))
        parts.append(table("Time", ("stage", "s"), seconds))
    if "error_estimate" in found:
        errors = zip(found["quantity"].values, found["error_estimate"].values, strict=True)
        rows = [[str(name).replace("_", " "), f"{float(error):.2%}"] for name, error in errors]
        parts.append(table("Estimated relative error", ("quantity", "error"), rows))
    return element("div", "".join(parts), class_="side-by-side")


def references(tree: xr.DataTree) -> str:
    """Published sources of the physics that ran, then those of the quantities; each work once, as fully as known.

    What only says how well a result was computed has no part in them.
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
    """Name of a work: the number of a standard, else authors and year."""
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
