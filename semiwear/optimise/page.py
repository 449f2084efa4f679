"""The report of a best design: one self-contained HTML file (extra ``plot``)."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.html_text import folded_html
from semiwear.optimise.designs import COARSE, RESOLUTIONS
from semiwear.optimise.optimum import Optimum, columns_of
from semiwear.optimise.quantity import Quantity
from semiwear.plain_text import unit_text
from semiwear.plot import wear_map
from semiwear.plot.style import SIZE, styled
from semiwear.report.markup import NONE, element, figure, figure_text, folded_toml, table
from semiwear.report.pictures import figure_uri
from semiwear.report.writing import page_of, page_target, write_page
from semiwear.results.wearing import worn_bodies
from semiwear.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST_ROWS = 200
_BEST, _OTHER, _REFUSED = "#c1272d", "#4c72b0", "#bbbbbb"


def write_optimum_report(
    best: Optimum, before: Scene, path: str | os.PathLike[str], simulate: Callable[[Scene], xr.DataTree]
) -> Path:
    """Write a best design as a page: its fields, its quantities before and after, all designs, and worn flanks.

    Parameters
    ----------
    best : Optimum
    before : Scene
        The scene as it was.
    path : path
        The HTML file.
    simulate : callable
        From a scene to its result; called for both scenes, to draw their worn flanks.

    Raises
    ------
    MissingExtraError
        matplotlib is missing; install the extra ``plot``.
    OSError
        The file cannot be written.
    """
    with styled():  # fails here if the extra is missing, before anything is simulated
        flanks = _flanks(simulate(before), simulate(best.scene))
        sections = [
            ("Best design", _summary(best)),
            ("Worn flanks, before and best", flanks),
            ("Designs that were tried", _pictures(best)),
            ("Front of both aims", _front(best)),
            ("Numbers", _numbers(best)),
            ("The best design as a scene", folded_toml(best.scene.to_toml())),
        ]
    attrs = {"source": best.designs.attrs["source"], "scene_sha256": best.scene.sha256}
    page = page_of(f"Best design: {before.title or 'a scene'}", best.verdict, sections, attrs)
    target = page_target(path)
    write_page(target, page)
    return target


def _summary(best: Optimum) -> str:
    rows = [
        [key, figure_text(value) if isinstance(value, float) else str(value)] for key, value in best.changes.items()
    ]
    fields = table("Fields", ["field", "best"], rows)
    lines = []
    for change in best.told:
        known = change.before and np.isfinite([change.before, change.best]).all()
        relative = f"{change.best / change.before - 1.0:+.1%}" if known else NONE
        name, units = change.quantity.text, unit_text(change.quantity.units) or NONE
        cells = [
            name,
            units,
            figure_text(change.before),
            figure_text(change.best),
            relative,
            f"{change.error:.1%}" if np.isfinite(change.error) else NONE,
            NONE if change.limit is None else change.limit.condition,
        ]
        lines.append(cells)
    heads = ["quantity", "unit", "before", "best", "change", "error", "limit"]
    note = element("p", escape("Error: the change from the resolution of the scene to twice that."))
    return fields + table("Quantities", heads, lines) + note


def _flanks(before: xr.DataTree, best: xr.DataTree) -> str:
    rows = []
    for body in worn_bodies(best):
        pair = [
            _figure(partial(wear_map, tree, body=body), f"Wear of the {body}, {label}.")
            for tree, label in ((before, "before"), (best, "best"))
        ]
        rows.append(element("div", "".join(pair), class_="side-by-side"))
    return "".join(rows)


def _figure(draw: Callable[..., Axes], caption: str) -> str:
    uri = figure_uri(SIZE, 1, lambda axes: draw(ax=axes[0]))
    return figure(uri, caption, caption, SIZE)


def _pictures(best: Optimum) -> str:
    figures = []
    for aim in best.aims:
        text = f"{aim.quantity.text} of every design on the coarse grid, in the order in which they were tried."
        figures.append(_figure(partial(draw_path, best, aim.quantity), text))
    for name in _field_names(best.designs):
        text = f"Over {name}; grey designs break a limit."
        figures.append(_figure(partial(draw_designs, best, name), text))
    rows = ("".join(figures[k : k + 2]) for k in range(0, len(figures), 2))
    return "".join(element("div", row, class_="side-by-side") for row in rows)


def _front(best: Optimum) -> str:
    if len(best.aims) < 2:
        return ""
    return _figure(partial(draw_front, best), "The front, among all designs that were tried.")


def _field_names(designs: xr.Dataset) -> list[str]:
    return [str(array.name) for array in designs.coords.values() if "field" in array.attrs]


def _on_coarse(best: Optimum) -> xr.Dataset:
    return best.designs.isel(sample=np.flatnonzero(best.designs["resolution"] == RESOLUTIONS.index(COARSE)))


def _label(quantity: Quantity) -> str:
    units = unit_text(quantity.units)
    return f"{quantity.text} ({units})" if units else quantity.text


def draw_path(best: Optimum, quantity: Quantity, ax: Axes) -> Axes:
    """Draw a quantity of every design on the coarse grid, and the best so far that keeps all limits."""
    tried = _on_coarse(best)
    values, feasible = tried[quantity.text].values, tried["feasible"].values
    number = np.arange(1, values.size + 1)
    ax.plot(number[feasible], values[feasible], "o", ms=4, color=_OTHER, label="keeps all limits")
    ax.plot(number[~feasible], values[~feasible], "o", ms=4, color=_REFUSED, label="breaks a limit")
    minimise = next((aim.minimise for aim in best.aims if aim.quantity.text == quantity.text), True)
    kept = np.where(feasible, values, np.inf if minimise else -np.inf)
    so_far = np.minimum.accumulate(kept) if minimise else np.maximum.accumulate(kept)
    ax.step(number, np.where(np.isfinite(so_far), so_far, np.nan), where="post", color=_BEST, label="best so far")
    ax.set(xlabel="Design", ylabel=_label(quantity))
    ax.legend()
    return ax


def draw_designs(best: Optimum, field: str, ax: Axes) -> Axes:
    """Draw the first aim over a field, of every design on the coarse grid."""
    tried, aim = _on_coarse(best), best.aims[0].quantity.text
    feasible = tried["feasible"].values
    for chosen, colour in ((~feasible, _REFUSED), (feasible, _OTHER)):
        ax.plot(tried[field].values[chosen], tried[aim].values[chosen], "o", ms=4, color=colour)
    if tried[field].dtype.kind in "if":
        ax.axvline(float(best.changes[tried[field].attrs["field"]]), color=_BEST, lw=1.2)
    ax.set(xlabel=field, ylabel=_label(best.aims[0].quantity))
    return ax


def draw_front(best: Optimum, ax: Axes) -> Axes:
    """Draw the front of two aims, with the designs on the coarse grid that keep all limits."""
    tried, (x, y) = _on_coarse(best), (aim.quantity.text for aim in best.aims)
    good = tried.isel(sample=np.flatnonzero(tried["feasible"]))
    ax.plot(good[x].values, good[y].values, "o", ms=3, color=_OTHER, alpha=0.5, label="tried")
    front = best.front.sortby(x)
    ax.plot(front[x].values, front[y].values, "o-", color=_BEST, label="front")
    ax.set(xlabel=_label(best.aims[0].quantity), ylabel=_label(best.aims[1].quantity))
    ax.legend()
    return ax


def _numbers(best: Optimum) -> str:
    limits = [change.limit for change in best.told if change.limit is not None]
    names = [*_field_names(best.designs), *columns_of(best.aims, limits)]
    rows = []
    for k in range(min(best.designs.sizes["sample"], _MOST_ROWS)):
        design = best.designs.isel(sample=k)
        values = [design[name] for name in names]
        cells = [str(value.values) if value.dtype.kind == "U" else figure_text(float(value)) for value in values]
        resolution, message = RESOLUTIONS[int(design["resolution"])], str(design["message"].values)
        rows.append([*cells, resolution, "yes" if bool(design["feasible"]) else message or "no"])
    return folded_html("Table", table("All designs", [*map(escape, names), "grid", "keeps all limits"], rows))
