"""Pictures of the worn flank of the gear."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from semiwear.plot.style import SIZE_PAIR, axes_for, label, need, step_name, styled
from semiwear.results.schema import Zone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh

__all__ = ["contact_pattern", "flank_axes", "mark_pitch_cone", "wear_map", "wear_profiles", "wear_surface"]

_WEAR_COLOURS = "magma_r"


def wear_map(tree: xr.DataTree, wear_step: int = -1, ax: Axes | None = None) -> Axes:
    """Wear of the gear along the tooth and over its height, with the band of the pitch cone.

    Parameters
    ----------
    tree : DataTree
        A result with `/flank`.
    wear_step : int
        Index of the wear step; the last unless given.
    ax : Axes, optional
        Where to draw; a new figure unless given.

    Returns
    -------
    Axes
    """
    with styled():
        along, height, wear = _gear(tree, wear_step)
        (ax,) = axes_for(ax)
        greatest = float(wear.max())
        mesh = flank_axes(ax, tree, wear, _WEAR_COLOURS, 0.0, greatest if greatest > 0 else 1.0)
        mark_pitch_cone(ax, tree)
        if greatest > 0:
            place = np.unravel_index(int(wear.argmax()), wear.shape)
            ax.plot(along[place], height[place], "o", mfc="none", mec="white", mew=1.5, ms=7, clip_on=False)
        name = step_name(need(tree, "flank", "wear_depth"), wear_step)
        ax.set_title(f"{name}: greatest {greatest:.3g} µm")
        bar = ax.figure.colorbar(mesh, ax=ax, pad=0.02)
        bar.set_label(label(need(tree, "flank", "wear_depth"), "Wear depth"))
        bar.ax.spines["outline"].set_visible(False)
        ax.legend(loc="upper right")
    return ax


def contact_pattern(tree: xr.DataTree, wear_step: int = -1, ax: Axes | None = None) -> Axes:
    """Contact pattern: greatest pressure that each point of the gear's flank feels in a mesh; fidelity ``patch``.

    Colours end at the greatest pressure away from borders over all wear steps, so that pictures of one result can
    be compared; rounded edges lie beyond. Parameters and return value as in `wear_map`.
    """
    with styled():
        pattern = need(tree, "flank", "contact_pattern")
        inside = need(tree, "engagement", "contact_pressure_max")
        (ax,) = axes_for(ax)
        values = pattern.isel(wear_step=wear_step).values
        scale = float(inside.values.max()) or 1.0
        mesh = flank_axes(ax, tree, values, "viridis", 0.0, scale)
        mark_pitch_cone(ax, tree, "white")
        ax.set_title(f"{step_name(pattern, wear_step)}: greatest {values.max():.0f} MPa")
        bar = ax.figure.colorbar(mesh, ax=ax, pad=0.02, extend="max" if pattern.values.max() > scale else "neither")
        bar.set_label(label(pattern, "Greatest pressure in a mesh"))
        bar.ax.spines["outline"].set_visible(False)
        ax.legend(loc="upper right", labelcolor="white")
    return ax


def wear_surface(tree: xr.DataTree, wear_step: int = -1, ax: Axes | None = None) -> Axes:
    """Wear of the gear as a surface along the tooth and over its height; parameters as `wear_map`, `ax` a 3-D one."""
    with styled():
        along, height, wear = _gear(tree, wear_step)
        (drawn,) = axes_for(ax, size=(5.8, 4.0), projection="3d")
        surface: Any = drawn
        scale = float(wear.max()) or 1.0
        surface.plot_surface(
            along,
            height,
            wear,
            cmap=_WEAR_COLOURS,
            vmin=0.0,
            vmax=scale,
            rcount=120,
            ccount=120,
            linewidth=0,
        )
        surface.set(
            xlabel=_label_along(tree),
            ylabel=label(need(tree, "flank", "flank_height"), "Height"),
            zlabel=label(need(tree, "flank", "wear_depth"), "Wear depth"),
            title=step_name(need(tree, "flank", "wear_depth"), wear_step),
        )
        surface.set_zlim(0.0, scale)
        surface.view_init(elev=28, azim=-58)
        surface.set_box_aspect((1.5, 1.0, 0.75), zoom=1.08)
    return drawn


def wear_profiles(
    tree: xr.DataTree, wear_step: int = -1, count: int = 4, ax: Sequence[Axes] | None = None
) -> tuple[Axes, Axes]:
    """Wear of the gear along the height at a few places, and along the width at a few heights.

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

    Returns
    -------
    tuple of Axes
        The panel along the height and the panel along the width.
    """
    with styled():
        along, height, wear = _gear(tree, wear_step)
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
                label=f"{along_tooth(tree)[1]} {along[:, station].mean():.0f} mm",
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
            xlabel=label(need(tree, "flank", "flank_height"), "Height above the pitch plane"),
            ylabel=depth,
            title="Along the tooth height",
        )
        along_width.set(
            xlabel=_label_along(tree),
            ylabel=depth,
            title="Along the face width",
        )
        for panel in (along_height, along_width):
            panel.set_ylim(bottom=0.0)
            panel.legend()
    return along_height, along_width


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


def along_tooth(tree: xr.DataTree) -> tuple[xr.DataArray, str]:
    """What tells places along the gear's tooth, over (profile, face), and its name.

    The radius where it grows along the tooth, as on a face gear; the face coordinate where the radius grows with the
    height.
    """
    radius = need(tree, "flank", "flank_radius").sel(body="gear")
    if np.ptp(radius.mean("profile").values) > np.ptp(radius.mean("face").values):
        return radius, "radius"
    return radius["face"].broadcast_like(radius).transpose(*radius.dims), "face"


def _label_along(tree: xr.DataTree) -> str:
    along, name = along_tooth(tree)
    return label(along, "Gear radius" if name == "radius" else "Along the face")


def _gear(tree: xr.DataTree, wear_step: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Place along the tooth, height and wear of the gear at one wear step, over (profile, face)."""
    wear = need(tree, "flank", "wear_depth").sel(body="gear")
    along, _ = along_tooth(tree)
    height = need(tree, "flank", "flank_height").sel(body="gear").values
    return along.values, height, wear.isel(wear_step=wear_step).values


def flank_axes(ax: Axes, tree: xr.DataTree, values: np.ndarray, colours: str, low: float, high: float) -> QuadMesh:
    """Draw values over (profile, face) as colours along the tooth and over the height of the gear's flank."""
    along, height, _ = _gear(tree, 0)
    mesh = ax.pcolormesh(along, height, values, cmap=colours, vmin=low, vmax=high, shading="gouraud", rasterized=True)
    ax.set(
        xlabel=_label_along(tree),
        ylabel=label(need(tree, "flank", "flank_height"), "Height above the pitch plane"),
        xlim=(along.min(), along.max()),
        ylim=(height.min(), height.max()),
    )
    ax.grid(False)
    return mesh


def mark_pitch_cone(ax: Axes, tree: xr.DataTree, colour: str = "#0072B2") -> None:
    """Mark the borders of the pitch band: half-way between a point of the band and its neighbour outside."""
    along, height, _ = _gear(tree, 0)
    zone = need(tree, "flank", "zone").sel(body="gear").values
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
    ax.plot(stations, below, color=colour, lw=1.0, ls="--", label="pitch cone's band")
    ax.plot(stations, above, color=colour, lw=1.0, ls="--")


def _line_colours(count: int) -> list[tuple[float, ...]]:
    import matplotlib

    return [tuple(colour) for colour in matplotlib.colormaps["cividis"](np.linspace(0.0, 0.88, count))]
