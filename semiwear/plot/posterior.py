"""Picture of a posterior: histograms of each unknown field and of each pair of fields."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.plain_text import power_of_ten, unit_text
from semiwear.plot.style import axes_for, styled
from semiwear.scene.units import UNITS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PANEL = 2.3  # inch
_BINS = 24
_SHARES = (0.95, 0.5)  # of the draws, inside the contour lines
_QUANTILES = (0.025, 0.5, 0.975)
_COLOUR, _LINE = "#0B5394", "#A63C00"


def corner_size(fields: int) -> tuple[float, float]:
    """Width and height of a corner picture for a number of fields [inch]."""
    side = max(_PANEL * fields, 4.0)
    return side, side


def posterior_corner(found: xr.Dataset, ax: Sequence[Axes] | None = None) -> list[Axes]:
    """Draws of a posterior: histograms of all fields, and of all pairs with contours of 50 and 95 % of the draws.

    Parameters
    ----------
    found : Dataset
        Of `Posterior.to_dataset`.
    ax : fields times fields Axes, optional
        Where to draw; a new figure unless given.

    Returns
    -------
    list of Axes
        Row by row; those above the diagonal are hidden.
    """
    fields = [name for name in map(str, found.data_vars) if "field" in found[name].attrs]
    if not fields:
        raise SemiwearError("the picture needs draws of a posterior: give what Posterior.to_dataset returns")
    count = len(fields)
    with styled():
        axes = axes_for(ax, count * count, corner_size(count), columns=count)
        shown = [_scaled(found[name]) for name in fields]
        for i in range(count):
            for j in range(count):
                panel = axes[i * count + j]
                panel.grid(False)
                if j > i:
                    panel.set_visible(False)
                    continue
                if i == j:
                    _histogram(panel, shown[i][0])
                else:
                    _pair_histogram(panel, shown[j][0], shown[i][0])
                _label(panel, (i, j, count), shown[j][1], shown[i][1])
    return axes


def _scaled(array: xr.DataArray) -> tuple[np.ndarray, str]:
    """Values over a suitable power of ten, and the label with that power."""
    values = np.asarray(array.values, float)
    size = np.abs(values).max()
    exponent = int(np.floor(np.log10(size))) if size > 0.0 else 0
    exponent = exponent if exponent < -3 or exponent > 4 else 0
    units = unit_text(str(array.attrs.get("units", "1")))
    scale = " ".join(part for part in (power_of_ten(exponent) if exponent else "", units) if part)
    name = textwrap.fill(with_spaces(str(array.name)), 22)
    return values / 10.0**exponent, f"{name}{f' ({scale})' if scale else ''}"


def with_spaces(name: str) -> str:
    """Name of a field with spaces, without the unit at its end."""
    end = next((end for end in UNITS if name.endswith(f"_{end}")), "")
    return name.removesuffix(f"_{end}").replace("_", " ")


def _histogram(panel: Axes, values: np.ndarray) -> None:
    panel.hist(values, bins=_BINS, color=_COLOUR, alpha=0.8)
    quantiles = np.quantile(values, _QUANTILES)
    low, median, high = quantiles
    for quantile, style in zip(quantiles, (":", "-", ":"), strict=True):
        panel.axvline(quantile, color=_LINE, lw=1.2, ls=style)
    panel.set_title(f"{median:.4g}\n{low:.4g} to {high:.4g}", fontsize=8.5, fontweight="normal")
    panel.set_yticks([])


def _pair_histogram(panel: Axes, x: np.ndarray, y: np.ndarray) -> None:
    counts, across, along = np.histogram2d(x, y, bins=_BINS)
    panel.pcolormesh(across, along, np.ma.masked_equal(counts.T, 0.0), cmap="Blues")
    ordered = np.sort(counts.ravel())[::-1]
    within = np.cumsum(ordered) / ordered.sum()
    levels = sorted({float(ordered[int(np.searchsorted(within, share))]) for share in _SHARES})
    middles = [0.5 * (ends[1:] + ends[:-1]) for ends in (across, along)]
    if levels[-1] < counts.max():
        panel.contour(*middles, counts.T, levels=levels, colors=_LINE, linewidths=1.0)


def _label(panel: Axes, place: tuple[int, int, int], x: str, y: str) -> None:
    i, j, count = place
    panel.tick_params(labelsize=8)
    if i == count - 1:
        panel.set_xlabel(x, fontsize=8.5)
    else:
        panel.set_xticklabels([])
    if j == 0 and i > 0:
        panel.set_ylabel(y, fontsize=8.5)
    elif i != j:
        panel.set_yticklabels([])
