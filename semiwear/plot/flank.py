"""Pictures of the worn flanks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.meshing.flank_pair import BODIES
from semiwear.plot.curve_names import name_curves, name_place
from semiwear.plot.style import SIZE_PAIR, axes_for, colour_bar, label, need, step_name, styled
from semiwear.results.missing import away_from_edges
from semiwear.results.schema import Zone
from semiwear.results.wearing import control_place, main_body, pitch_name, pitch_surface
from semiwear.untyped import Options

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh

WEAR_COLOURS = "magma_r"


@styled()
def wear_map(tree: xr.DataTree, wear_step: int = -1, ax: Axes | None = None, *, body: str | None = None) -> Axes:
    """Wear of a flank along the tooth and over its height, with the band of the pitch surface.

    The greatest wear and, if it lies on this body, the control point are marked.

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
    body = chosen_body(tree, body)
    along, height, wear = on_flank(tree, body, wear_step)
    (ax,) = axes_for(ax)
    greatest = float(wear.max())
    mesh = flank_axes(ax, tree, wear, WEAR_COLOURS, 0.0, greatest if greatest > 0 else 1.0, body)
    mark_pitch_band(ax, tree, body=body)
    marker: Options = {"ls": "none", "mec": "black", "mfc": "white", "mew": 1.2, "clip_on": False, "zorder": 5}
    if greatest > 0:
        place = np.unravel_index(int(wear.argmax()), wear.shape)
        ax.plot(along[place], height[place], "o", ms=7, **marker)
        name_place(ax, float(along[place]), float(height[place]), "greatest wear")
    point = control_place(tree)
    if point is not None and point.body == body:
        at = _along_at(tree, body, point.along)
        ax.plot(at, point.height, "D", ms=6, **marker)
        name_place(ax, at, point.height, "control point")
    name = step_name(need(tree, "flank", "wear_depth"), wear_step)
    colour_bar(ax, mesh, label(need(tree, "flank", "wear_depth"), f"Wear depth, {body}"))
    ax.set_title(f"{body.capitalize()}, {name}: greatest {greatest:.3g} µm")
    return ax


@styled()
def contact_pattern(tree: xr.DataTree, wear_step: int = -1, ax: Axes | None = None) -> Axes:
    """Contact pattern: greatest pressure at each point of the gear's flank in a mesh; fidelity ``patch``.

    The colour scale ends at the greatest pressure away from borders over all wear steps, so that pictures of a result
    can be compared; pressures on rounded edges are above it. Parameters and return value as in `wear_map`.
    """
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
    return ax


@styled()
def wear_profiles(
    tree: xr.DataTree,
    wear_step: int = -1,
    count: int = 4,
    ax: Sequence[Axes] | None = None,
    *,
    body: str | None = None,
) -> tuple[Axes, Axes]:
    """Sections through the wear of a flank, at its deepest place and a few others, along height and width.

    Parameters
    ----------
    tree : DataTree
        A result with `/flank`.
    wear_step : int
        Index of the wear step; the last unless given.
    count : int
        Curves per panel: one through the deepest place (thick), the others evenly spaced over the flank.
    ax : two Axes, optional
        Where to draw; a new figure unless given.
    body : str, optional
        As in `wear_map`.

    Returns
    -------
    tuple of Axes
        The panel along the height and the panel along the width.
    """
    body = chosen_body(tree, body)
    along, height, wear = on_flank(tree, body, wear_step)
    along_height, along_width = axes_for(ax, 2, SIZE_PAIR)
    deepest = np.unravel_index(int(wear.argmax()), wear.shape)
    faces = wear.shape[1]
    stations = np.linspace(0.08 * faces, 0.92 * faces - 1, max(count - 1, 0)).round().astype(int)
    for place, style in _section_styles(stations, int(deepest[1])):
        station = int(place)
        order = np.argsort(height[:, station])
        name = f"{along_tooth(tree, body)[1]} {along[:, station].mean():.0f} mm".replace("-", "−")
        along_height.plot(height[order, station], wear[order, station], label=name, **style)
    low, high = float(height.min(axis=0).max()), float(height.max(axis=0).min())
    margin = 0.06 * (high - low)
    levels = np.linspace(low + margin, high - margin, max(count - 1, 0))
    for level, style in _section_styles(levels, float(height[deepest])):
        name = f"height {level:+.1f} mm".replace("-", "−")
        along_width.plot(*_along_width(along, height, wear, float(level)), label=name, **style)
    depth = label(need(tree, "flank", "wear_depth"), "Wear depth")
    along_height.set(
        xlabel=height_label(tree, body), ylabel=depth, title=f"{body.capitalize()}: along the tooth height"
    )
    along_width.set(
        xlabel=label_along(tree, body), ylabel=depth, title="Along the face width (thick: the deepest place)"
    )
    for panel in (along_height, along_width):
        panel.set_ylim(bottom=0.0)
        name_curves(panel)
    return along_height, along_width


def _section_styles(others: np.ndarray, deepest: float) -> list[tuple[float, Options]]:
    """Places of sections with the styles of their curves: the deepest one thick; others close to it are left out."""
    spacing = float(np.ptp(others)) / max(others.size - 1, 1)
    shown = [other for other in dict.fromkeys(others.tolist()) if abs(other - deepest) > 0.25 * spacing]
    styles: list[tuple[float, Options]] = [
        (other, {"color": colour, "lw": 1.2}) for other, colour in zip(shown, _line_colours(len(shown)), strict=True)
    ]
    return [*styles, (deepest, {"color": "#C1272D", "lw": 2.6, "zorder": 3})]


def chosen_body(tree: xr.DataTree, body: str | None) -> str:
    """The body to draw: `body`, by default the gear unless only the pinion wears."""
    if body is None:
        return main_body(tree)
    if body not in BODIES:
        raise SemiwearError(f'body: {body!r}; it is "pinion" or "gear"')
    return body


def _along_width(
    along: np.ndarray, height: np.ndarray, wear: np.ndarray, level: float
) -> tuple[np.ndarray, np.ndarray]:
    """Coordinate along the tooth and wear at one height for each station; NaN where the flank does not reach it."""
    at_place, at_level = np.empty(wear.shape[1]), np.empty(wear.shape[1])
    for station in range(wear.shape[1]):
        order = np.argsort(height[:, station])
        at_place[station] = np.interp(level, height[order, station], along[order, station])
        at_level[station] = np.interp(level, height[order, station], wear[order, station], left=np.nan, right=np.nan)
    return at_place, at_level


def along_tooth(tree: xr.DataTree, body: str = "gear") -> tuple[xr.DataArray, str]:
    """Coordinate along a tooth, over (profile, face), and its name.

    The radius if it varies along the tooth, as on a face gear; the face coordinate if the radius varies with the
    height.
    """
    radius = need(tree, "flank", "flank_radius").sel(body=body)
    if np.ptp(radius.mean("profile").values) > np.ptp(radius.mean("face").values):
        return radius, "radius"
    return radius["face"].broadcast_like(radius).transpose(*radius.dims), "face"


def _along_at(tree: xr.DataTree, body: str, face: float) -> float:
    """Coordinate along the tooth of a face coordinate."""
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
    """Coordinate along the tooth, height and wear of a body at one wear step, over (profile, face)."""
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

    With `smooth` colours the values must be finite everywhere.
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
    ax.plot(stations, below, color=colour, lw=1.0, ls="--")
    ax.plot(stations, above, color=colour, lw=1.0, ls="--")
    first = int(np.argmin(stations))
    name_place(
        ax, float(stations[first]), float(above[first]), f"{pitch_name(tree)}'s band", colour=colour, above=True
    )


def _line_colours(count: int) -> list[tuple[float, ...]]:
    import matplotlib

    return [tuple(colour) for colour in matplotlib.colormaps["cividis"](np.linspace(0.0, 0.7, count))]
