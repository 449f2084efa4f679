"""Pictures of the worn flanks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.meshing.flank_pair import BODIES
from semiwear.plot.style import SIZE_PAIR, axes_for, colour_bar, label, legend_above, need, step_name, styled
from semiwear.results.missing import away_from_edges
from semiwear.results.schema import Zone
from semiwear.results.wearing import control_place, main_body, pitch_name, pitch_surface
from semiwear.untyped import Options

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh

__all__ = [
    "along_tooth",
    "chosen_body",
    "contact_pattern",
    "flank_axes",
    "height_label",
    "label_along",
    "mark_pitch_band",
    "on_flank",
    "wear_map",
    "wear_profiles",
]

WEAR_COLOURS = "magma_r"


def wear_map(tree: xr.DataTree, wear_step: int = -1, ax: Axes | None = None, *, body: str | None = None) -> Axes:
    """Wear of a flank along the tooth and over its height, with the band of the pitch surface.

    Marked are the place of the greatest wear and, where it lies on this body, the control point.

    Parameters
    ----------
    tree : DataTree
        A result with `/flank`.
    wear_step : int
        Index of the wear step; the last unless given.
    ax : Axes, optional
        Where to draw; a new figure unless given.
    body : str, optional
        ``"pinion"`` or ``"gear"``. Default: the gear, unless the pinion alone wears.

    Returns
    -------
    Axes
    """
    with styled():
        body = chosen_body(tree, body)
        along, height, wear = on_flank(tree, body, wear_step)
        (ax,) = axes_for(ax)
        greatest = float(wear.max())
        mesh = flank_axes(ax, tree, wear, WEAR_COLOURS, 0.0, greatest if greatest > 0 else 1.0, body)
        mark_pitch_band(ax, tree, body=body)
        marker: Options = {"ls": "none", "mec": "black", "mfc": "white", "mew": 1.2, "clip_on": False, "zorder": 5}
        if greatest > 0:
            place = np.unravel_index(int(wear.argmax()), wear.shape)
            ax.plot(along[place], height[place], "o", ms=7, label="greatest wear", **marker)
        point = control_place(tree)
        if point is not None and point.body == body:
            ax.plot(_along_at(tree, body, point.along), point.height, "D", ms=6, label="control point", **marker)
        name = step_name(need(tree, "flank", "wear_depth"), wear_step)
        colour_bar(ax, mesh, label(need(tree, "flank", "wear_depth"), f"Wear depth, {body}"))
        legend_above(ax, 3)
        ax.set_title(f"{body.capitalize()}, {name}: greatest {greatest:.3g} µm", pad=22.0)
    return ax


def contact_pattern(tree: xr.DataTree, wear_step: int = -1, ax: Axes | None = None) -> Axes:
    """Contact pattern: greatest pressure that each point of the gear's flank feels in a mesh; fidelity ``patch``.

    Colours end at the greatest pressure away from borders over all wear steps, so that pictures of one result can
    be compared; rounded edges lie beyond. Parameters and return value as in `wear_map`.
    """
    with styled():
        pattern = need(tree, "flank", "contact_pattern")
        need(tree, "engagement", "contact_pressure_max")
        inside = away_from_edges(tree["engagement"].to_dataset())
        (ax,) = axes_for(ax)
        values = pattern.isel(wear_step=wear_step).values
        scale = float(np.fmax.reduce(inside.values, axis=None, initial=0.0)) or 1.0
        mesh = flank_axes(ax, tree, values, "viridis", 0.0, scale)
        mark_pitch_band(ax, tree, "white")
        ax.set_title(f"{step_name(pattern, wear_step)}: greatest {values.max():.0f} MPa")
        beyond = "max" if pattern.values.max() > scale else "neither"
        colour_bar(ax, mesh, label(pattern, "Greatest pressure in a mesh"), {"extend": beyond})
        ax.legend(loc="upper right", labelcolor="white")
    return ax


def wear_profiles(
    tree: xr.DataTree,
    wear_step: int = -1,
    count: int = 4,
    ax: Sequence[Axes] | None = None,
    *,
    body: str | None = None,
) -> tuple[Axes, Axes]:
    """Wear of a flank along the height at a few places, and along the width at a few heights.

    Parameters
    ----------
    tree : DataTree
        A result with `/flank`.
    wear_step : int
        Index of the wear step; the last unless given.
    count : int
        Curves a panel.
    ax : two Axes, optional
        Where to draw; a new figure unless given.
    body : str, optional
        As in `wear_map`.

    Returns
    -------
    tuple of Axes
        The panel along the height and the panel along the width.
    """
    with styled():
        body = chosen_body(tree, body)
        along, height, wear = on_flank(tree, body, wear_step)
        along_height, along_width = axes_for(ax, 2, SIZE_PAIR)
        colours = _line_colours(count)
        faces = wear.shape[1]
        stations = np.unique(np.linspace(0.08 * faces, 0.92 * faces - 1, count).round().astype(int))
        for colour, station in zip(colours, stations, strict=False):
            order = np.argsort(height[:, station])
            along_height.plot(
                height[order, station],
                wear[order, station],
                color=colour,
                label=f"{along_tooth(tree, body)[1]} {along[:, station].mean():.0f} mm".replace("-", "−"),
            )
        low, high = float(height.min(axis=0).max()), float(height.max(axis=0).min())
        margin = 0.06 * (high - low)
        for colour, level in zip(colours, np.linspace(low + margin, high - margin, count), strict=True):
            along_width.plot(
                *_along_width(along, height, wear, float(level)),
                color=colour,
                label=f"height {level:+.1f} mm".replace("-", "−"),
            )
        depth = label(need(tree, "flank", "wear_depth"), "Wear depth")
        along_height.set(
            xlabel=height_label(tree, body), ylabel=depth, title=f"{body.capitalize()}: along the tooth height"
        )
        along_width.set(xlabel=label_along(tree, body), ylabel=depth, title="Along the face width")
        for panel in (along_height, along_width):
            panel.set_ylim(bottom=0.0)
            legend_above(panel, 2)
            panel.set_title(panel.get_title(loc="left"), pad=34.0)
    return along_height, along_width


def chosen_body(tree: xr.DataTree, body: str | None) -> str:
    """The body to draw: the one named, else the gear unless the pinion alone wears."""
    if body is None:
        return main_body(tree)
    if body not in BODIES:
        raise SemiwearError(f'body: {body!r}; it is "pinion" or "gear"')
    return body


def _along_width(
    along: np.ndarray, height: np.ndarray, wear: np.ndarray, level: float
) -> tuple[np.ndarray, np.ndarray]:
    """Place along the tooth and wear at one height, station by station."""
    at_place, at_level = np.empty(wear.shape[1]), np.empty(wear.shape[1])
    for station in range(wear.shape[1]):
        order = np.argsort(height[:, station])
        at_place[station] = np.interp(level, height[order, station], along[order, station])
        at_level[station] = np.interp(level, height[order, station], wear[order, station])
    return at_place, at_level


def along_tooth(tree: xr.DataTree, body: str = "gear") -> tuple[xr.DataArray, str]:
    """Coordinate of places along a tooth, over (profile, face), and its name.

    The radius where it grows along the tooth, as on a face gear; the face coordinate where the radius grows with the
    height.
    """
    radius = need(tree, "flank", "flank_radius").sel(body=body)
    if np.ptp(radius.mean("profile").values) > np.ptp(radius.mean("face").values):
        return radius, "radius"
    return radius["face"].broadcast_like(radius).transpose(*radius.dims), "face"


def _along_at(tree: xr.DataTree, body: str, face: float) -> float:
    """Place along the tooth of a face coordinate."""
    along, _ = along_tooth(tree, body)
    return float(np.interp(face, along["face"].values, along.values.mean(axis=0)))


def label_along(tree: xr.DataTree, body: str) -> str:
    """Label of the axis along the tooth."""
    along, name = along_tooth(tree, body)
    return label(along, f"{body.capitalize()} radius" if name == "radius" else "Along the face")


def height_label(tree: xr.DataTree, body: str) -> str:
    """Label of the axis over the tooth height."""
    return label(need(tree, "flank", "flank_height"), f"Height above the {pitch_surface(tree, body)}")


def on_flank(tree: xr.DataTree, body: str, wear_step: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Place along the tooth, height and wear of a body at one wear step, over (profile, face)."""
    wear = need(tree, "flank", "wear_depth").sel(body=body)
    along, _ = along_tooth(tree, body)
    height = need(tree, "flank", "flank_height").sel(body=body).values
    return along.values, height, wear.isel(wear_step=wear_step).values


def flank_axes(
    ax: Axes,
    tree: xr.DataTree,
    values: np.ndarray,
    colours: str,
    low: float,
    high: float,
    body: str = "gear",
    *,
    smooth: bool = True,
) -> QuadMesh:
    """Draw values over (profile, face) as colours along the tooth and over the height of a flank.

    `smooth` colours need a value everywhere.
    """
    along, height, _ = on_flank(tree, body, 0)
    scale: Options = {"cmap": colours, "vmin": low, "vmax": high, "shading": "gouraud" if smooth else "nearest"}
    mesh = ax.pcolormesh(along, height, values, rasterized=True, **scale)
    ax.set(
        xlabel=label_along(tree, body),
        ylabel=height_label(tree, body),
        xlim=(along.min(), along.max()),
        ylim=(height.min(), height.max()),
    )
    ax.grid(False)
    return mesh


def mark_pitch_band(ax: Axes, tree: xr.DataTree, colour: str = "#0072B2", *, body: str = "gear") -> None:
    """Mark the borders of the pitch band: half-way between a point of the band and its neighbour outside."""
    along, height, _ = on_flank(tree, body, 0)
    zone = need(tree, "flank", "zone").sel(body=body).values
    stations, borders = [], []
    for station in range(zone.shape[1]):
        order = np.argsort(height[:, station])
        heights = height[order, station]
        inside = np.flatnonzero(zone[order, station] == Zone.PITCH)
        if inside.size:
            lower, upper = inside[0], inside[-1]
            stations.append(float(np.interp(heights[lower], heights, along[order, station])))
            borders.append(
                (
                    (heights[lower] + heights[max(lower - 1, 0)]) / 2,
                    (heights[upper] + heights[min(upper + 1, heights.size - 1)]) / 2,
                )
            )
    if not stations:
        return
    below, above = np.array(borders).T
    ax.plot(stations, below, color=colour, lw=1.0, ls="--", label=f"{pitch_name(tree)}'s band")
    ax.plot(stations, above, color=colour, lw=1.0, ls="--")


def _line_colours(count: int) -> list[tuple[float, ...]]:
    import matplotlib

    return [tuple(colour) for colour in matplotlib.colormaps["cividis"](np.linspace(0.0, 0.88, count))]
