"""Picture of predicted and measured wear."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.plot.style import axes_for, colour_bar, label, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SIZE = (13.2, 3.9)
_LEAST_SCALE = 1e-3  # least range of the colours [um]


def measured_wear(comparison: xr.Dataset, ax: Sequence[Axes] | None = None) -> tuple[Axes, Axes, Axes]:
    """Predicted wear, measured wear and their difference over the flank, side by side.

    The first two share a colour scale, from the least to the greatest value of both without the outermost
    thousandths; in the third, white is no difference. Points outside the comparison are white.

    Parameters
    ----------
    comparison : Dataset
        Of `compare_wear`, or of a `Calibration`'s `comparison`.
    ax : three Axes, optional
        Where to draw; a new figure unless given.

    Returns
    -------
    tuple of Axes
    """
    missing = [name for name in ("predicted", "wear_depth", "difference", "inside") if name not in comparison]
    if missing:
        raise SemiwearError(f"the picture needs {missing[0]}: give what compare_wear returns")
    with styled():
        axes = axes_for(ax, 3, _SIZE, columns=3, options={"sharex": True, "sharey": True})
        inside = comparison["inside"].values.astype(bool)
        along, name = _along(comparison)
        height = comparison["flank_height"]
        shown = {
            name: np.ma.masked_where(~inside, comparison[name].values)
            for name in ("predicted", "wear_depth", "difference")
        }
        both = np.concatenate([shown[name].compressed() for name in ("predicted", "wear_depth")])
        low, high = (float(value) for value in np.percentile(both, (0.1, 99.9)))
        low, high = min(low, 0.0), max(high, low + _LEAST_SCALE)
        largest = max(float(np.abs(shown["difference"]).max()), _LEAST_SCALE)
        titles = (
            "Predicted",
            "Measured",
            f"Difference: rms {float(comparison['difference_rms']):.2g} µm, "
            f"greatest {float(comparison['difference_max']):+.2g} µm".replace("-", "−"),
        )
        scales = (("magma_r", low, high), ("magma_r", low, high), ("RdBu_r", -largest, largest))
        drawn = []
        for panel, title, values, (colours, least, most) in zip(axes, titles, shown.values(), scales, strict=True):
            drawn.append(
                panel.pcolormesh(
                    along.values, height.values, values, cmap=colours, vmin=least, vmax=most, shading="nearest",
                    rasterized=True,
                )
            )  # fmt: skip
            panel.set_title(title)
            panel.grid(False)
            panel.set_xlabel(label(along, name))
        axes[0].set_ylabel(label(height, "Height above the pitch surface"))
        for panels, mesh, text in ((axes[:2], drawn[1], "Wear depth"), (axes[2:], drawn[2], "Predicted − measured")):
            colour_bar(panels, mesh, f"{text} (µm)")
    return axes[0], axes[1], axes[2]


def _along(comparison: xr.Dataset) -> tuple[xr.DataArray, str]:
    """Coordinate along the tooth: the radius if it varies along it, otherwise the face coordinate."""
    radius, face = comparison["flank_radius"], comparison["flank_face"]
    across_face = np.ptp(radius.values.mean(axis=0))
    if across_face > np.ptp(radius.values.mean(axis=1)) and np.ptp(face.values.mean(axis=0)) > 0.0:
        return radius, "Radius"
    return face, "Along the face"
