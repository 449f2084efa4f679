"""Pictures over the life: quantities with one value per wear step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.plot.curve_names import name_curves, name_place
from semiwear.plot.style import (
    BODY_COLOUR,
    SIZE_PAIR,
    ZONE_COLOUR,
    ZONE_MARKER,
    axes_for,
    label,
    meshes_axis,
    need,
    styled,
)
from semiwear.results.missing import group_of, why_missing
from semiwear.results.wearing import pitch_name, shown_bodies

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ZONE_DASHES = {"root": "--", "addendum": "-.", "pitch": ":"}


@styled()
def wear_history(tree: xr.DataTree, ax: Axes | None = None) -> Axes:
    """Greatest wear of every body that wears, over the meshes, and that of the zones of its flank.

    Parameters and return value as in `root_stress_history`.
    """
    wear = need(tree, "flank", "wear_depth")
    (ax,) = axes_for(ax)
    meshes = _label_over_meshes(ax, wear, "Greatest wear depth")
    history = group_of(tree, "history")
    for body in shown_bodies(tree):
        colour = BODY_COLOUR[body]
        ax.plot(meshes, wear.sel(body=body).max(("profile", "face")).values, "o-", color=colour, label=body)
        stem = "wear_depth_max_pinion" if body == "pinion" else "wear_depth_max"
        for zone, dashes in _ZONE_DASHES.items():
            if (name := f"{stem}_{zone}") in history:
                ax.plot(meshes, history[name].values, dashes, color=colour, lw=1.0, label=f"{body}, {zone}")
    ax.set_ylim(bottom=0.0)
    name_curves(ax)
    return ax


@styled()
def root_stress_history(tree: xr.DataTree, ax: Axes | None = None) -> Axes:
    """Greatest root stress of both bodies over the meshes.

    Parameters
    ----------
    tree : DataTree
        A result with `/history`.
    ax : Axes, optional
        Where to draw; a new figure unless given.

    Returns
    -------
    Axes
    """
    stress = need(tree, "history", "root_stress_max")
    (ax,) = axes_for(ax)
    meshes = _label_over_meshes(ax, stress, "Greatest root stress")
    for (body, colour), marker in zip(BODY_COLOUR.items(), "os", strict=True):
        ax.plot(meshes, stress.sel(body=body).values, marker=marker, color=colour, label=body)
    name_curves(ax)
    return ax


@styled()
def contact_stress_history(tree: xr.DataTree, ax: Axes | None = None) -> Axes:
    """Greatest contact pressure at root, addendum and pitch surface of the gear over the meshes.

    Parameters and return value as in `root_stress_history`.
    """
    (ax,) = axes_for(ax)
    names = {"pitch": pitch_name(tree)}
    for zone, colour in ZONE_COLOUR.items():
        pressure = need(tree, "history", f"contact_pressure_{zone}")
        meshes = _label_over_meshes(ax, pressure, "Greatest contact pressure")
        name = names.get(zone, zone)
        if why_missing(pressure):
            name += " (none clear of edges)" if np.isnan(pressure.values).all() else " (not at every step)"
        ax.plot(meshes, pressure.values, marker=ZONE_MARKER[zone], color=colour, label=name)
    name_curves(ax)
    return ax


@styled()
def transmission_error_history(tree: xr.DataTree, ax: Sequence[Axes] | None = None) -> tuple[Axes, Axes]:
    """Mean and amplitude (peak to peak) of the loaded transmission error over the meshes.

    Parameters
    ----------
    tree : DataTree
        A result with `/history`.
    ax : two Axes, optional
        Where to draw; a new figure unless given.

    Returns
    -------
    tuple of Axes
        The panel of the mean and the panel of the amplitude.
    """
    mean = need(tree, "history", "transmission_error_mean")
    amplitude = need(tree, "history", "transmission_error_amplitude")
    upper, lower = axes_for(ax, 2, SIZE_PAIR)
    draw_over_meshes(upper, mean, "Mean")
    draw_over_meshes(lower, amplitude, "Amplitude")
    upper.set_title("Mean, gear side (negative: it lags)")
    lower.set_title("Amplitude, peak to peak")
    return upper, lower


@styled()
def meshes_against_depth(tree: xr.DataTree, ax: Axes | None = None) -> Axes:
    """Meshes until the control point reaches a wear depth.

    Parameters and return value as in `root_stress_history`.
    """
    depth = need(tree, "history", "wear_depth_control_point")
    (ax,) = axes_for(ax)
    meshes, meshes_label = meshes_axis(depth)
    ax.plot(depth.values, meshes, "o-", color="#333333")
    ax.set(xlabel=label(depth, "Wear depth at the control point"), ylabel=meshes_label)
    if meshes[-1] > 0:
        middle = 0.5 * depth.values[-1], 0.5 * meshes[-1]
        ax.plot([0.0, depth.values[-1]], [0.0, meshes[-1]], color="#888888", lw=1.0, ls="--")
        higher = float(np.interp(middle[0], depth.values, meshes)) > middle[1]
        name_place(ax, *middle, "constant rate", colour="#555555", left=not higher)  # away from the curve
    return ax


def draw_over_meshes(ax: Axes, series: xr.DataArray, text: str) -> None:
    """Draw a quantity with one value per wear step over the meshes; `text` names it in its label."""
    ax.plot(_label_over_meshes(ax, series, text), series.values, "o-", color="#333333")


def _label_over_meshes(ax: Axes, series: xr.DataArray, text: str) -> np.ndarray:
    """Label the axes for a quantity over the meshes; returns the meshes in the unit of the axis."""
    meshes, meshes_label = meshes_axis(series)
    ax.set(xlabel=meshes_label, ylabel=label(series, text))
    return meshes
