"""Report of a sweep as a single, self-contained HTML file (extra ``plot``)."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.html_text import folded_html
from semiwear.plain_text import unit_text
from semiwear.plot.style import SIZE, styled
from semiwear.plot.sweeps import scene_values, sweep_curves, sweep_map, sweep_samples
from semiwear.report.markup import NONE, element, figure, figure_text, folded_toml, table, tiles
from semiwear.report.pictures import figure_uri
from semiwear.report.writing import page_of, page_target, write_page

if TYPE_CHECKING:
    from matplotlib.axes import Axes

QUANTITIES = (
    "meshes_to_limit",
    "meshes",
    "wear_depth_max",
    "root_stress_max",
    "contact_pressure_pitch",
    "contact_pressure_root",
    "load_share_max",
    "transmission_error_mean",
    "transmission_error_amplitude",
    "contact_temperature_max",
    "mesh_efficiency",
    "lambda_ratio_min",
)
"""Quantities in the pictures of the page, if a sweep has them and they vary."""

_MOST_FAILURES, _MOST_REASONS = 200, 50
_MOST_ROWS = 400
_SAME = 1e-9  # relative


def write_sweep_report(
    found: xr.Dataset, path: str | os.PathLike[str], first: Sequence[tuple[str, str]] = ()
) -> Path:
    """Write a sweep as one self-contained HTML page: maps and curves of its quantities, and what failed.

    Parameters
    ----------
    found : Dataset
        Of `sweep`.
    path : path
        The HTML file; an existing one is replaced once the page is complete.
    first : sequence of (str, str), optional
        Headings and HTML of sections that come before the quantities.

    Raises
    ------
    MissingExtraError
        matplotlib is missing; install the extra ``plot``.
    SemiwearError
        The dataset is not that of a sweep, or the path not that of an HTML file.
    OSError
        The file cannot be written.
    """
    if "status" not in found or "varied" not in found.attrs:
        raise SemiwearError("report: the dataset has no status, so it is none of `sweep`")
    target = page_target(path)
    title = str(found.attrs.get("title", "Sweep"))
    write_page(
        target, page_of(title, _subtitle(found), _sections(found, first), {str(k): v for k, v in found.attrs.items()})
    )
    return Path(path)


def _subtitle(found: xr.Dataset) -> str:
    return f"{found['status'].size} scenes; varied: {found.attrs['varied']}"


def _sections(found: xr.Dataset, first: Sequence[tuple[str, str]] = ()) -> list[tuple[str, str]]:
    """Headings and HTML of a sweep's page."""
    return [
        ("Scenes", _tiles(found)),
        ("Varied fields", _fields(found)),
        ("Scenes that failed", _failures(found)),
        *first,
        ("Quantities at the end of each run", _cards(found)),
        ("Numbers", _numbers(found)),
        ("The scene that was varied", folded_toml(str(found.attrs.get("scene_toml", "")))),
    ]


def _tiles(found: xr.Dataset) -> str:
    status = found["status"].values
    meanings = str(found["status"].attrs["flag_meanings"]).split()
    numbers = [("Scenes", str(status.size), " x ".join(map(str, status.shape)))]
    numbers += [
        (meaning.capitalize(), str(int((status == value).sum())), "")
        for value, meaning in enumerate(meanings)
        if value == 0 or (status == value).any()
    ]
    seconds = found["seconds"].values[status == 0]
    if "emulated" in found:
        count = int(found["emulated"].sum())
        numbers.append(("Solved", str(status.size - count), f"{count} are emulated"))
        seconds = seconds[np.isfinite(seconds)]
    if seconds.size:
        longest = f"longest {seconds.max():.3g} s"
        numbers.append(("Median time of a scene", f"{np.median(seconds):.3g} s", longest))
    return tiles(numbers)


def _varied(found: xr.Dataset) -> list[xr.DataArray]:
    return [array for array in found.coords.values() if "field" in array.attrs]


def _fields(found: xr.Dataset) -> str:
    rows = []
    for array in _varied(found):
        values = np.atleast_1d(array.values)
        if array.dtype.kind == "U":
            texts = list(dict.fromkeys(map(str, values)))
            extent = ", ".join(texts[:8]) + (", ..." if len(texts) > 8 else "")
        else:
            extent = f"{values.min():.4g} to {values.max():.4g}"
        count = str(np.unique(values).size)
        rows.append([array.attrs["field"], count, extent, unit_text(str(array.attrs.get("units", ""))) or NONE])
    return table("Varied fields", ["field", "values", "from, to", "unit"], rows)


def _failures(found: xr.Dataset) -> str:
    """Reasons of failures, each with its scenes."""
    status = found["status"]
    meanings, fields = str(status.attrs["flag_meanings"]).split(), _varied(found)
    reasons: dict[tuple[str, str], list[str]] = {}
    for index in np.argwhere(status.values != 0):
        position = {str(dim): int(k) for dim, k in zip(status.dims, index, strict=True)}
        where = ", ".join(
            f"{array.name} = {_cell(array.isel({dim: position[str(dim)] for dim in array.dims}))}" for array in fields
        )
        key = meanings[int(status.values[tuple(index)])], str(found["message"].isel(position).values)
        reasons.setdefault(key, []).append(where)
    parts = []
    for (meaning, reason), scenes in list(reasons.items())[:_MOST_REASONS]:
        listed = "".join(f"<li>{escape(where)}</li>" for where in scenes[:_MOST_FAILURES])
        more = len(scenes) - _MOST_FAILURES
        listed += f"<li>and {more} more</li>" if more > 0 else ""
        count = f"{len(scenes)} scene{'s' if len(scenes) > 1 else ''}"
        parts.append(
            f"<details><summary>{count} {escape(meaning)}: {escape(reason)}</summary><ul>{listed}</ul></details>"
        )
    more = len(reasons) - len(parts)
    return "".join(parts) + (f"<p>and {more} more reasons</p>" if more > 0 else "")


def _cell(value: xr.DataArray) -> str:
    return str(value.values) if value.dtype.kind == "U" else f"{float(value):.4g}"


def _shown(found: xr.Dataset) -> Iterator[tuple[str, str, xr.DataArray]]:
    """Quantities that vary from scene to scene, of each body."""
    for name in QUANTITIES:
        if name not in found.data_vars:
            continue
        bodies = [str(body) for body in found["body"].values] if "body" in found[name].dims else [""]
        for body in bodies:
            values = scene_values(found, name, body or "gear")
            finite = values.values[np.isfinite(values.values)]
            if finite.size and np.ptp(finite) > _SAME * np.abs(finite).max():
                yield name, body, values


def _cards(found: xr.Dataset) -> str:
    cards = []
    for name, body, values in _shown(found):
        title = str(values.attrs.get("long_name", name))
        title = title[:1].upper() + title[1:]
        pictures = "".join(
            figure(uri, alt, caption, SIZE) for uri, alt, caption in _pictures(found, name, body or "gear", values)
        )
        content = element("h3", escape(title)) + element("div", pictures, class_="side-by-side")
        cards.append(element("article", content, class_="card full"))
    return "".join(cards)


def _pictures(found: xr.Dataset, name: str, body: str, values: xr.DataArray) -> Iterator[tuple[str, str, str]]:
    finite = values.values[np.isfinite(values.values)]
    units = unit_text(str(values.attrs.get("units", "")))
    alt = f"{name}: {figure_text(finite.min())} to {figure_text(finite.max())} {units}".strip()
    if values.dims == ("sample",):
        for array in _varied(found):
            yield _drawn(partial(sweep_samples, found, name, str(array.name), body=body)), alt, f"Over {array.name}."
        return
    many = [dim for dim in values.dims if values.sizes[dim] > 1]
    held = "; further fields have the values above the picture" if len(many) > 2 else ""
    yield _drawn(partial(sweep_curves, found, name, body=body)), alt, f"As curves{held}."
    if len(many) > 1:
        yield _drawn(partial(sweep_map, found, name, body=body)), alt, f"As a map{held}."
    for dim in many[2:]:
        curves = partial(sweep_curves, found, name, over=str(dim), body=body)
        yield _drawn(curves), alt, f"Over {dim}{held}."


def _drawn(draw: Callable[..., Axes]) -> str:
    with styled():
        return figure_uri(SIZE, 1, lambda axes: draw(ax=axes[0]))


def _numbers(found: xr.Dataset) -> str:
    """Table with a row for each scene, in the order of the dataset."""
    shown = list(_shown(found))
    if not shown:
        return "<p>No quantity varies from scene to scene.</p>"
    status, fields = found["status"], _varied(found)
    heads = [*(escape(str(array.name)) for array in fields)]
    heads += [escape(f"{name} {body}".strip()) for name, body, _ in shown]
    rows = []
    for index in list(np.ndindex(status.shape))[:_MOST_ROWS]:
        position = dict(zip(map(str, status.dims), index, strict=True))
        cells = [_cell(array.isel({d: position[str(d)] for d in array.dims})) for array in fields]
        rows.append([*cells, *(figure_text(float(values.values[index])) for _, _, values in shown)])
    more = status.size - len(rows)
    note = f"<p>The first {len(rows)} of {status.size} scenes.</p>" if more > 0 else ""
    whole = table("Scenes, at the end of each run", heads, rows)
    return folded_html("Table", note + whole)
