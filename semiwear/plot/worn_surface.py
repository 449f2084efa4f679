"""The worn flank as a surface in three dimensions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.plot.flank import WEAR_COLOURS, chosen_body, label_along, on_flank
from semiwear.plot.style import axes_for, colour_bar, label, need, step_name, styled
from semiwear.untyped import Options

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from mpl_toolkits.mplot3d import Axes3D

_COLUMNS = 97  # least number along the tooth: with fewer the colours have visible steps
_BELOW = 0.35  # of the greatest wear: depth of the drawn piece of the tooth below its deepest place


@styled()
def wear_surface(tree: xr.DataTree, wear_step: int = -1, ax: Axes | None = None, *, body: str | None = None) -> Axes:
    """The worn flank as a surface below the unworn one, coloured by the wear depth.

    The unworn flank is drawn as a plane with its outline. The depth is drawn some hundred to thousand times as great;
    the title gives the factor. Parameters and return value as in `wear_map`; the axes have three dimensions.
    """
    body = chosen_body(tree, body)
    along, height, wear = (_finer(values) for values in on_flank(tree, body, wear_step))
    (drawn,) = axes_for(ax, size=(5.8, 4.0), options={"subplot_kw": {"projection": "3d"}})
    surface: Axes3D = drawn
    scale = float(wear.max()) or 1.0
    bottom = -(1.0 + _BELOW) * scale
    _body_of_tooth(surface, along, height, wear, bottom, scale)
    box = (1.5, 1.0, 0.55)
    surface.set(xlabel=label_along(tree, body), ylabel=label(need(tree, "flank", "flank_height"), "Height"))
    surface.set_zlim(bottom, 0.0)
    surface.set_zticks([])  # the colours show the depth
    surface.view_init(elev=34, azim=-62)
    surface.set_box_aspect(box, zoom=0.98)
    # millimetres per length of the box across the flank, over micrometres per length of it into the tooth
    enlargement = (float(np.ptp(height)) / box[1]) / (1e-3 * (1.0 + _BELOW) * scale / box[2])
    name = step_name(need(tree, "flank", "wear_depth"), wear_step)
    drawn.set_title(f"{body.capitalize()}, {name}: depth drawn {float(f'{enlargement:.2g}'):g} times as great")
    if wear.any():
        import matplotlib

        mapped = matplotlib.cm.ScalarMappable(matplotlib.colors.Normalize(0.0, scale), WEAR_COLOURS)
        depth = label(need(tree, "flank", "wear_depth"), "Wear depth")
        colour_bar(drawn, mapped, depth, {"shrink": 0.7, "pad": 0.12}).ax.invert_yaxis()
    return drawn


def _finer(values: np.ndarray) -> np.ndarray:
    """Values over (profile, face), interpolated linearly at more places along the face."""
    stations = values.shape[1]
    parts = max(1, -(-_COLUMNS // max(stations - 1, 1)))
    places = np.linspace(0.0, stations - 1, parts * (stations - 1) + 1)
    return np.stack([np.interp(places, np.arange(stations), row) for row in values])


def _body_of_tooth(
    surface: Axes3D, along: np.ndarray, height: np.ndarray, wear: np.ndarray, bottom: float, scale: float
) -> None:
    """The worn flank with the cut faces of the piece below it, and the outline of the unworn flank."""
    import matplotlib
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    colours = matplotlib.colormaps[WEAR_COLOURS](matplotlib.colors.Normalize(0.0, scale)(wear))
    # every node is drawn: otherwise narrow crests would appear and disappear along the face
    full: Options = {"rstride": 1, "cstride": 1, "linewidth": 0, "antialiased": False, "shade": False}
    surface.plot_surface(along, height, -wear, facecolors=colours, zorder=1, **full)
    # visible cut faces: at the root and at one end
    for edge in (np.s_[0, :], np.s_[:, -1]):
        x, y, z = along[edge], height[edge], -wear[edge]
        upper = list(zip(x, y, z, strict=True))
        lower = [(x[-1], y[-1], bottom), (x[0], y[0], bottom)]
        face = Poly3DCollection([upper + lower], facecolor="#C9D2DB", edgecolor="#77828E", linewidth=0.6, zorder=2)
        surface.add_collection3d(face)
    for edge in (np.s_[0, :], np.s_[:, -1], np.s_[-1, :], np.s_[:, 0]):
        surface.plot(
            along[edge], height[edge], np.zeros(along[edge].shape), color="#333333", lw=0.8, ls="--", zorder=3
        )
