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
    plain_log_scale,
    step_name,
    styled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Okabe and Ito, without the blue and the vermilion of the bodies.
_COLOURS = ("#CC79A7", "#009E73", "#E69F00", "#56B4E9", "#000000", "#B07D00", "#882255")
_DASHES = {"pinion": "-", "gear": "--"}
_FINE = 2001  # points between which the governing mode may change
_SHADE = 0.18
_FAILURE = 9.0  # size of the mark of a failure [points]


@styled()
def safety_history(tree: xr.DataTree, ax: Axes | None = None) -> Axes:
    """Safety over required safety of all failure modes, over hours or meshes, with the governing mode shaded.

    A cross marks where a safety falls below the required one. Between wear steps, safeties from accumulated damage
    are straight lines between logarithms, like life curves.

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
    at, name, ends = _life_axis(tree)
    modes = [str(mode) for mode in safety["mode"].values]
    colours = {mode: _COLOURS[k % len(_COLOURS)] for k, mode in enumerate(modes)}
    places = np.unique(np.concatenate([np.linspace(at[0], at[-1], _FINE), at, ends[ends <= at[-1]]]))
    curves = np.full((len(modes), len(_DASHES), places.size), np.nan)
    for k, mode in enumerate(modes):
        for i, (body, dashes) in enumerate(_DASHES.items()):
            values, end = relative.sel(mode=mode, body=body).values, ends[k, i]
            if not np.isfinite(values).any():
                continue
            curves[k, i] = _course(places, at, values, end, summed=_adds_up(tree, mode))
            ax.plot(places, curves[k, i], dashes, color=colours[mode], label=f"{mode_words(mode)}, {body}")
            ax.plot(at, values, ".", color=colours[mode])
            ax.plot(end, 1.0, "X", color=colours[mode], mec="white", ms=_FAILURE, zorder=4, clip_on=False)
    _shade_governing(ax, places, curves, list(colours.values()))
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
    panels = axes_for(ax, 2, SIZE_WIDE, columns=2)
    least = float(np.nanmin(safety.values)) if np.isfinite(safety.values).any() else required
    name = step_name(need(tree, "ratings", "safety"), -1)
    for panel, body in zip(panels, BODIES, strict=True):
        values = np.ma.masked_invalid(safety.sel(body=body).values)
        mesh = flank_axes(panel, tree, values, "magma", least, 2.5 * least, body, smooth=False)
        mark_pitch_band(panel, tree, body=body)
        own = f"least {values.min():.3g}" if values.count() else "nothing rated"
        panel.set_title(f"{body.capitalize()}, {name}: {own}, required {required:g}")
        colour_bar(panel, mesh, label(safety, f"Safety, {mode_words(mode)}"), {"extend": "max"})
    return panels[0], panels[1]


def mode_words(mode: str) -> str:
    """Name of a failure mode with spaces."""
    return mode.replace("_", " ")


def _life_axis(tree: xr.DataTree) -> tuple[np.ndarray, str, np.ndarray]:
    """Wear steps on the axis of the life, the label of that axis, and the failures, (mode, body), on it."""
    ratings = tree["ratings"].to_dataset()
    if "hours" in ratings:
        return ratings["hours"].values, "Running time (h)", need(tree, "ratings", "hours_to_failure").values
    at, name = meshes_axis(ratings["safety"])
    ends = need(tree, "ratings", "meshes_to_failure").values
    meshes = ratings["meshes"]
    if meshes.attrs.get("units", "1") != "1":  # km of sliding: unknown at the failures
        return at, name, np.full(ends.shape, np.nan)
    return at, name, ends * (at[-1] / meshes.values[-1] if meshes.values[-1] > 0.0 else 1.0)


def _adds_up(tree: xr.DataTree, mode: str) -> bool:
    """Whether a mode's safety follows from accumulated damage, so that it falls along a life curve."""
    ratings = tree["ratings"].to_dataset()
    return "damage_sum" in ratings and bool(np.isfinite(ratings["damage_sum"].sel(mode=mode)).any())


def _course(places: np.ndarray, at: np.ndarray, values: np.ndarray, end: float, *, summed: bool) -> np.ndarray:
    """Safety over the required one along the life, through the wear steps and the failure, where it is 1.

    Linear between wear steps. If damage accumulates, linear between logarithms, like a life curve; before the first
    known cycles this line is extended, up to the static strength at wear step 0.
    """
    known = np.isfinite(values)
    if summed:
        known[0] = False
    x, y = at[known], values[known]
    if np.isfinite(end) and end not in x:
        k = int(np.searchsorted(x, end))
        x, y = np.insert(x, k, end), np.insert(y, k, 1.0)
    if not summed or x.size == 0 or x[0] <= 0.0:
        return np.asarray(np.interp(places, x, y, left=np.nan, right=np.nan)) if x.size else 0.0 * places + values[0]
    logs = np.log(x), np.log(y)
    slope = min((logs[1][1] - logs[1][0]) / (logs[0][1] - logs[0][0]), 0.0) if x.size > 1 else 0.0
    after, before = places >= x[0], places < x[0]
    course = np.full(places.shape, np.nan)
    course[after] = np.exp(np.interp(np.log(places[after]), *logs, right=np.nan))
    early = places[before]
    with np.errstate(divide="ignore"):
        course[before] = np.fmin(y[0] * (early / x[0]) ** slope, values[0])
    course[places <= 0.0] = values[0]
    return course


def _shade_governing(ax: Axes, places: np.ndarray, curves: np.ndarray, colours: list[str]) -> None:
    """Shade the stretches of the life in the colour of the mode whose safety, (mode, body, place), is least."""
    if places[-1] <= places[0]:
        return
    least = np.where(np.isnan(curves), np.inf, curves).min(axis=1)
    governs, last = least.argmin(axis=0), places.size - 1
    for mode, stretch in groupby(range(places.size), key=lambda k: int(governs[k])):
        ends = list(stretch)
        ax.axvspan(places[ends[0]], places[min(ends[-1] + 1, last)], color=colours[mode], alpha=_SHADE, lw=0)


def _scale(ax: Axes, values: np.ndarray) -> None:
    """Set a logarithmic scale with plain numbers that includes the limit 1."""
    plain_log_scale(ax, (1.0, 1.5, 2.0, 3.0, 5.0, 7.0))
    ax.set_ylim(0.9 * min(1.0, np.nanmin(values)), 1.1 * max(1.2, np.nanmax(values)))
