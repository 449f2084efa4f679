"""Pictures of failure modes: safeties over the life, and over the worn flanks."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.meshing.flank_pair import BODIES
from semiwear.plot.curve_names import name_curves
from semiwear.plot.flank import flank_axes, mark_pitch_band
from semiwear.plot.style import (
    SIZE_WIDE,
    axes_for,
    colour_bar,
    label,
    meshes_axis,
    need,
    step_name,
    styled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["mode_words", "safety_history", "safety_map"]

# Okabe and Ito, without the blue and the vermilion of the bodies.
_COLOURS = ("#CC79A7", "#009E73", "#E69F00", "#56B4E9", "#000000", "#B07D00", "#882255")
_DASHES = {"pinion": "-", "gear": "--"}
_FINE = 2001  # points between which the governing mode may change
_SHADE = 0.18


@styled()
def safety_history(tree: xr.DataTree, ax: Axes | None = None) -> Axes:
    """Safeties of all failure modes over what each requires, over hours or meshes, the mode that governs shaded.

    Parameters
    ----------
    tree : DataTree
        A result with `/ratings`.
    ax : Axes, optional
        Where to draw; a new figure unless given.

    Returns
    -------
    Axes
    """
    safety = need(tree, "ratings", "safety")
    relative = safety / need(tree, "ratings", "required_safety")
    (ax,) = axes_for(ax)
    at, name = _life_axis(tree)
    modes = [str(mode) for mode in safety["mode"].values]
    colours = {mode: _COLOURS[k % len(_COLOURS)] for k, mode in enumerate(modes)}
    for mode in modes:
        for body, dashes in _DASHES.items():
            values = relative.sel(mode=mode, body=body).values
            if np.isfinite(values).any():
                text = f"{mode_words(mode)}, {body}"
                ax.plot(at, values, dashes, marker=".", color=colours[mode], label=text)
    _shade_governing(ax, at, relative, colours)
    ax.axhline(1.0, color="#333333", lw=1.0)
    _scale(ax, relative.values)
    ax.set(xlabel=name, ylabel="Safety over required safety")
    ax.margins(x=0.0)
    name_curves(ax)
    return ax


@styled()
def safety_map(tree: xr.DataTree, ax: Sequence[Axes] | None = None, *, mode: str | None = None) -> tuple[Axes, Axes]:
    """Safety of one failure mode on both worn flanks, at the last wear step.

    Parameters
    ----------
    tree : DataTree
        A result with `/ratings`.
    ax : two Axes, optional
        Where to draw; a new figure unless given.
    mode : str, optional
        Failure mode; the first of the result unless given.

    Returns
    -------
    tuple of Axes
        The pinion's and the gear's.
    """
    flanks = need(tree, "ratings", "safety_on_flank")
    modes = [str(name) for name in flanks["mode"].values]
    mode = modes[0] if mode is None else mode
    if mode not in modes:
        raise SemiwearError(f"mode: {mode!r}; this result has {', '.join(modes)}")
    required = float(need(tree, "ratings", "required_safety").sel(mode=mode))
    safety = flanks.sel(mode=mode)
    panels = axes_for(ax, 2, SIZE_WIDE, side_by_side=True)
    least = float(np.nanmin(safety.values)) if np.isfinite(safety.values).any() else required
    for panel, body in zip(panels, BODIES, strict=True):
        _one_flank(tree, panel, body, safety.sel(body=body), (least, mode, required))
    return panels[0], panels[1]


def mode_words(mode: str) -> str:
    """Name of a failure mode as a reader writes it."""
    return mode.replace("_", " ")


def _one_flank(tree: xr.DataTree, ax: Axes, body: str, safety: xr.DataArray, told: tuple[float, str, float]) -> None:
    least, mode, required = told
    values = np.ma.masked_invalid(safety.values)
    mesh = flank_axes(ax, tree, values, "magma", least, 2.5 * least, body, smooth=False)
    mark_pitch_band(ax, tree, body=body)
    own = f"least {values.min():.3g}" if values.count() else "nothing rated"
    name = step_name(need(tree, "ratings", "safety"), -1)
    ax.set_title(f"{body.capitalize()}, {name}: {own}, required {required:g}")
    colour_bar(ax, mesh, label(safety, f"Safety, {mode_words(mode)}"), {"extend": "max"})


def _life_axis(tree: xr.DataTree) -> tuple[np.ndarray, str]:
    """Place of every wear step on the axis of the life, and the axis's label."""
    ratings = tree["ratings"].to_dataset()
    if "hours" in ratings:
        return ratings["hours"].values, "Running time (h)"
    return meshes_axis(ratings["safety"])


def _shade_governing(ax: Axes, at: np.ndarray, relative: xr.DataArray, colours: dict[str, str]) -> None:
    """Shade the stretches of the life in the colour of the mode whose safety is least."""
    least = relative.min("body").values  # NaN is left out
    if at.size < 2:
        return
    fine = np.linspace(at[0], at[-1], _FINE)
    curves = np.array([np.interp(fine, at, np.where(np.isnan(row), np.inf, row)) for row in least])
    governs = curves.argmin(axis=0)
    modes = list(colours)
    for mode, stretch in groupby(range(_FINE), key=lambda k: int(governs[k])):
        ends = list(stretch)
        ax.axvspan(fine[ends[0]], fine[min(ends[-1] + 1, _FINE - 1)], color=colours[modes[mode]], alpha=_SHADE, lw=0)


def _scale(ax: Axes, values: np.ndarray) -> None:
    """A logarithmic scale with plain numbers, that holds the limit."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    ax.set_yscale("log")
    ax.set_ylim(0.9 * min(1.0, np.nanmin(values)), 1.1 * max(1.2, np.nanmax(values)))
    ax.yaxis.set_major_locator(LogLocator(10.0, (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.yaxis.set_minor_formatter(NullFormatter())
