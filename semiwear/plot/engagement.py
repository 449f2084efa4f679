"""Pictures over the engagement of one tooth pair, and over one mesh cycle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.plot.curve_names import name_curves
from semiwear.plot.history import draw_over_meshes
from semiwear.plot.style import (
    BODY_COLOUR,
    ROLL_LABEL,
    SIZE_PAIR,
    axes_for,
    chosen_steps,
    label,
    need,
    pressure_scale,
    step_colours,
    step_name,
    styled,
)
from semiwear.results.missing import away_from_edges

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@styled()
def sliding_along_path(tree: xr.DataTree, wear_step: int = -1, ax: Axes | None = None) -> Axes:
    """Sliding distance of each body in one mesh over the roll position, unworn and at one wear step.

    Parameters
    ----------
    tree : DataTree
        A result with `/engagement`.
    wear_step : int
        Index of the wear step; the last unless given.
    ax : Axes, optional
        Where to draw; a new figure unless given.

    Returns
    -------
    Axes
    """
    sliding = need(tree, "engagement", "sliding_distance")
    (ax,) = axes_for(ax)
    shown = wear_step % sliding.sizes["wear_step"]
    where = _loaded(tree)
    for body, colour in BODY_COLOUR.items():
        curves = sliding.sel(body=body)
        if shown:
            ax.plot(*_curve(curves, 0, where), color=colour, lw=1.1, ls="--", label=f"{body}, unworn")
        name = f"{body}, {step_name(sliding, shown)}"
        ax.plot(*_curve(curves, shown, where), color=colour, label=name)
    ax.set(xlabel=ROLL_LABEL, ylabel=label(sliding, "Sliding distance per mesh"))
    ax.set_ylim(bottom=0.0)
    name_curves(ax)
    return ax


@styled()
def load_share(tree: xr.DataTree, ax: Sequence[Axes] | None = None) -> tuple[Axes, Axes]:
    """Load share of a tooth pair over its engagement, and its maximum over the meshes.

    Parameters
    ----------
    tree : DataTree
        A result with `/engagement` and `/history`.
    ax : two Axes, optional
        Where to draw; a new figure unless given.

    Returns
    -------
    tuple of Axes
        The panel over the engagement and the panel over the meshes.
    """
    share = need(tree, "engagement", "load_share")
    greatest = need(tree, "history", "load_share_max")
    over_roll, over_meshes = axes_for(ax, 2, SIZE_PAIR)
    _step_curves(over_roll, share, _loaded(tree))
    over_roll.set(xlabel=ROLL_LABEL, ylabel=label(share, "Load share"), ylim=(0.0, 1.05))
    name_curves(over_roll)
    draw_over_meshes(over_meshes, greatest, "Greatest load share")
    return over_roll, over_meshes


@styled()
def contact_pressure_over_engagement(tree: xr.DataTree, ax: Axes | None = None) -> Axes:
    """Greatest contact pressure over the engagement at the first, middle and last wear step.

    Thick lines: away from borders. Dotted lines: at an edge, where its pressure is higher than on the flank; that
    value depends on the edge's rounding and on the mesh. Hatched: roll positions where only edges carry load at a
    wear step that is drawn. Parameters and return value as in `root_stress_history`, of a result with `/engagement`.
    """
    pressure = need(tree, "engagement", "contact_pressure_max")
    (ax,) = axes_for(ax)
    engagement, where = tree["engagement"].to_dataset(), _loaded(tree)
    clear = away_from_edges(engagement)
    _step_curves(ax, clear, where, named_by=pressure)
    greatest = np.fmax.reduce(clear.values[:, where], axis=None, initial=0.0)
    pressure_scale(ax, greatest, _edge_curves(ax, engagement, clear, where))
    ax.set(xlabel=ROLL_LABEL, ylabel=label(pressure, "Greatest contact pressure"))
    name_curves(ax)
    return ax


def _edge_curves(ax: Axes, engagement: xr.Dataset, clear: xr.DataArray, where: np.ndarray) -> float:
    """Draw the pressure at edges and hatch where only edges carry load; returns the greatest pressure drawn."""
    if "contact_pressure_max_edge" not in engagement:
        return 0.0
    edge = engagement["contact_pressure_max_edge"]
    colours = step_colours(edge.sizes["wear_step"])
    edges_only, highest, named = np.zeros(where.size, dtype=bool), 0.0, False
    for step in chosen_steps(edge):
        roll, at_edge = _curve(edge, step, where)
        on_flank = clear.isel(wear_step=step).values[where]
        edges_only |= np.isnan(on_flank)
        shown = np.where(at_edge > np.nan_to_num(on_flank), at_edge, np.nan)
        if np.isnan(shown).all():
            continue
        name = None if named else "dotted: higher\nat an edge"
        ax.plot(roll, shown, color=colours[step], lw=1.0, ls=":", marker=".", ms=4.0, label=name)
        highest, named = float(np.fmax.reduce(shown, initial=highest)), True
    _hatch(ax, engagement["roll_position"].values[where], edges_only)
    return highest


def _hatch(ax: Axes, roll: np.ndarray, edges_only: np.ndarray) -> None:
    """Hatch the roll positions where only edges carry load, half a step wider on each side."""
    if not edges_only.any():
        return
    ends = np.concatenate([roll[:1], 0.5 * (roll[1:] + roll[:-1]), roll[-1:]])
    turns = np.flatnonzero(np.diff(np.concatenate([[False], edges_only, [False]]).astype(int)))
    for start, stop in turns.reshape(-1, 2):
        ax.axvspan(ends[start], ends[stop], fc="none", ec="#999999", hatch="////", lw=0.0)
    start, stop = max(turns.reshape(-1, 2), key=lambda turn: ends[turn[1]] - ends[turn[0]])
    ax.text(
        0.5 * (ends[start] + ends[stop]), 0.03, "only edges carry load", rotation=90, fontsize=9.0, ha="center",
        va="bottom", transform=ax.get_xaxis_transform(), bbox={"fc": "white", "ec": "none", "pad": 1.0},
    )  # fmt: skip


@styled()
def transmission_error_curves(tree: xr.DataTree, ax: Axes | None = None) -> Axes:
    """Loaded transmission error over one mesh cycle, one curve per wear step.

    Parameters and return value as in `root_stress_history`, of a result with `/mesh_cycle`.
    """
    error = need(tree, "mesh_cycle", "transmission_error_loaded")
    (ax,) = axes_for(ax)
    steps = error.sizes["wear_step"]
    named = chosen_steps(error)
    position = np.append(error["mesh_position"].values, 1.0 + error["mesh_position"].values[0])
    for step, colour in zip(range(steps), step_colours(steps), strict=False):
        values = error.isel(wear_step=step).values
        ax.plot(
            position,
            np.append(values, values[0]),
            color=colour,
            lw=1.8 if step in named else 0.9,
            label=step_name(error, step) if step in named else None,
        )
    ax.set(xlabel="Mesh position (base pitches)", ylabel=label(error, "Loaded transmission error"))
    name_curves(ax)
    return ax


def _step_curves(ax: Axes, array: xr.DataArray, where: np.ndarray, named_by: xr.DataArray | None = None) -> None:
    """Curves of the first, middle and last wear step over the roll position, with the step names of `named_by`."""
    colours = step_colours(array.sizes["wear_step"])
    for step in chosen_steps(array):
        name = step_name(array if named_by is None else named_by, step)
        ax.plot(*_curve(array, step, where), color=colours[step], label=name)


def _curve(array: xr.DataArray, step: int, where: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return array["roll_position"].values[where], array.isel(wear_step=step).values[where]


def _loaded(tree: xr.DataTree) -> np.ndarray:
    """Roll positions that carry load at any wear step, with a neighbour on each side."""
    share = need(tree, "engagement", "load_share").values
    loaded = np.flatnonzero((share > 1e-6).any(axis=0))
    if not loaded.size:
        return np.arange(share.shape[1])
    return np.arange(max(loaded[0] - 1, 0), min(loaded[-1] + 2, share.shape[1]))
