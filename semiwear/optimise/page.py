"""The report of a best design: one HTML file that needs nothing but itself (extra ``plot``)."""

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
    """Write a best design as a page: what it is, what it gains, the way to it, and its worn flanks beside the first.

    Parameters
    ----------
    best : Optimum
    before : Scene
        As it was.
    path : path
        The HTML file.
    simulate : callable
        From a scene to its result; both scenes are worn for their pictures.

    Raises
    ------
    MissingExtraError
        matplotlib is missing; install the extra ``plot``.
    OSError
        The file cannot be written.
    """
    with styled():  # asks for the extra before anything is worn
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
    for one in best.told:
        limit = "" if one.limit is None else f"{'<=' if one.limit.at_most else '>='} {one.limit.bound:g}"
        known = one.before and np.isfinite([one.before, one.best]).all()
        change = f"{one.best / one.before - 1.0:+.1%}" if known else NONE
        name, units = one.quantity.text, unit_text(one.quantity.units) or NONE
        cells = [
            name,
            units,
            figure_text(one.before),
            figure_text(one.best),
            change,
            f"{one.error:.1%}" if np.isfinite(one.error) else NONE,
            limit or NONE,
        ]
        lines.append(cells)
    heads = ["quantity", "unit", "before", "best", "change", "error", "limit"]
    note = element("p", escape("Error: the change from the resolution of the scene to twice that."))
    return fields + table("Quantities", heads, lines) + note


def _flanks(before: xr.DataTree, best: xr.DataTree) -> str:
    rows = []
    for body in worn_bodies(best):
        pair = [
            _figure(partial(wear_map, tree, body=body), f"Wear of the {body}, {told}.")
            for tree, told in ((before, "before"), (best, "best"))
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
    values, good = tried[quantity.text].values, tried["feasible"].values
    number = np.arange(1, values.size + 1)
    ax.plot(number[good], values[good], "o", ms=4, color=_OTHER, label="keeps all limits")
    ax.plot(number[~good], values[~good], "o", ms=4, color=_REFUSED, label="breaks a limit")
    minimise = next((aim.minimise for aim in best.aims if aim.quantity.text == quantity.text), True)
    kept = np.where(good, values, np.inf if minimise else -np.inf)
    so_far = np.minimum.accumulate(kept) if minimise else np.maximum.accumulate(kept)
    ax.step(number, np.where(np.isfinite(so_far), so_far, np.nan), where="post", color=_BEST, label="best so far")
    ax.set(xlabel="Design", ylabel=_label(quantity))
    ax.legend()
    return ax


def draw_designs(best: Optimum, field: str, ax: Axes) -> Axes:
    """Draw the first aim over a field, of every design on the coarse grid."""
    tried, aim = _on_coarse(best), best.aims[0].quantity.text
    good = tried["feasible"].values
    for chosen, colour in ((~good, _REFUSED), (good, _OTHER)):
        ax.plot(tried[field].values[chosen], tried[aim].values[chosen], "o", ms=4, color=colour)
    if tried[field].dtype.kind in "if":
        ax.axvline(float(best.changes[tried[field].attrs["field"]]), color=_BEST, lw=1.2)
    ax.set(xlabel=field, ylabel=_label(best.aims[0].quantity))
    return ax


def draw_front(best: Optimum, ax: Axes) -> Axes:
    """Draw the front of two aims, with the designs on the coarse grid that keep all limits."""
    tried, (x, y) = _on_coarse(best), (aim.quantity.text for aim in best.aims)
    good = tried["feasible"].values
    ax.plot(tried[x].values[good], tried[y].values[good], "o", ms=3, color=_OTHER, alpha=0.5, label="tried")
    front = best.front.sortby(x)
    ax.plot(front[x].values, front[y].values, "o-", color=_BEST, label="front")
    ax.set(xlabel=_label(best.aims[0].quantity), ylabel=_label(best.aims[1].quantity))
    ax.legend()
    return ax


def _numbers(best: Optimum) -> str:
    limits = [one.limit for one in best.told if one.limit is not None]
    names = [*_field_names(best.designs), *columns_of(best.aims, limits)]
    rows = []
    for k in range(min(best.designs.sizes["sample"], _MOST_ROWS)):
        one = best.designs.isel(sample=k)
        cells = [str(one[n].values) if one[n].dtype.kind == "U" else figure_text(float(one[n])) for n in names]
        resolution, message = RESOLUTIONS[int(one["resolution"])], str(one["message"].values)
        rows.append([*cells, resolution, "yes" if bool(one["feasible"]) else message or "no"])
    whole = table("All designs", [*map(escape, names), "grid", "keeps all limits"], rows)
    return folded_html("Table", whole)
