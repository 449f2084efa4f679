"""Common style of all pictures: axes, labels, colours, and access to the variables of a result."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from semiwear.errors import MissingExtraError, SemiwearError
from semiwear.plain_text import power_of_ten, unit_text
from semiwear.results.missing import group_of
from semiwear.untyped import Options

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.colorbar import Colorbar

# Okabe and Ito for the bodies, Paul Tol's muted scheme for the zones: distinguishable for colour-blind readers.
BODY_COLOUR = {"pinion": "#0072B2", "gear": "#D55E00"}
ZONE_COLOUR = {"root": "#882255", "pitch": "#B07D00", "addendum": "#117733"}
ZONE_MARKER = {"root": "v", "pitch": "o", "addendum": "^"}

ROLL_LABEL = "Roll position (base pitches, 0 at the pitch point)"

SIZE = (5.8, 3.7)
SIZE_PAIR = (5.8, 6.0)
SIZE_WIDE = (11.6, 3.7)

# Any: the type that matplotlib gives to its settings differs from version to version
_STYLE: Any = {
    "font.size": 10.0,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 10.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#555555",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E3E3E3",
    "grid.linewidth": 0.8,
    "lines.linewidth": 1.8,
    "lines.markersize": 4.5,
    "legend.frameon": False,
    "legend.fontsize": 9.0,
    "xtick.color": "#333333",
    "ytick.color": "#333333",
    "axes.formatter.useoffset": False,
    "axes.xmargin": 0.02,
    "figure.constrained_layout.h_pad": 0.07,
}

_LOG_FROM = 4.0  # times the pressure away from borders: edges higher than this need a logarithmic axis


@contextmanager
def styled() -> Iterator[None]:
    """Run with the settings of semiwear's pictures; the user's own settings come back afterwards."""
    try:
        import matplotlib
    except ImportError as error:
        raise MissingExtraError("matplotlib", "plot", "a picture") from error
    with matplotlib.rc_context(_STYLE):
        yield


def axes_for(
    ax: Axes | Sequence[Axes] | None,
    panels: int = 1,
    size: tuple[float, float] = SIZE,
    *,
    columns: int = 1,
    options: Options | None = None,
) -> list[Axes]:
    """Axes to draw on: those of the caller, or new ones in `columns` columns."""
    if ax is not None:
        given = list(ax) if isinstance(ax, Sequence | np.ndarray) else [ax]
        if len(given) != panels:
            raise SemiwearError(f"ax: {len(given)} axes, this picture has {panels} panels")
        return given
    import matplotlib.pyplot as plt

    settings: Options = {"figsize": size, "squeeze": False, "layout": "constrained"} | (options or {})
    _, created = plt.subplots(panels // columns, columns, **settings)
    return list(created.flat)


def need(tree: xr.DataTree, group: str, name: str) -> xr.DataArray:
    """A variable of a result; the error names it if it is missing."""
    variables = group_of(tree, group)
    if name not in variables:
        raise SemiwearError(f"the picture needs /{group}/{name}, which this result does not have")
    return variables[name]


def label(array: xr.DataArray, text: str = "") -> str:
    """Axis label: long name (or `text`) and unit."""
    name = text or str(array.attrs.get("long_name", array.name))
    shown = unit_text(str(array.attrs.get("units", "1")))
    name = name[:1].upper() + name[1:]
    return f"{name} ({shown})" if shown else name


def colour_bar(
    ax: Axes | Sequence[Axes], mesh: ScalarMappable, text: str, options: Options | None = None
) -> Colorbar:
    """Colour scale of a picture, beside its axes."""
    settings: Options = {"pad": 0.02} | (options or {})
    first = ax[0] if isinstance(ax, Sequence) else ax
    bar = first.figure.colorbar(mesh, ax=ax, **settings)
    bar.set_label(text)
    bar.ax.spines["outline"].set_visible(False)
    return bar


def pressure_scale(ax: Axes, greatest: float, on_edges: float) -> None:
    """Set a pressure scale from zero, or a logarithmic one if the pressure at edges is far higher than elsewhere."""
    if on_edges > _LOG_FROM * greatest > 0.0:
        plain_log_scale(ax, (1.0, 2.0, 5.0))
    else:
        ax.set_ylim(bottom=0.0)


def plain_log_scale(ax: Axes, ticks: tuple[float, ...]) -> None:
    """Set a logarithmic vertical scale with plain numbers, at these multiples of powers of ten."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    ax.set_yscale("log")
    ax.yaxis.set_major_locator(LogLocator(10.0, ticks))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.yaxis.set_minor_formatter(NullFormatter())


def meshes_axis(array: xr.DataArray) -> tuple[np.ndarray, str]:
    """Meshes of each wear step over a power of ten, and the label with that power; or the unit of `life_in`."""
    meshes = np.asarray(array["meshes"].values, dtype=float)
    if array["meshes"].attrs.get("units", "1") != "1":
        return meshes, label(array["meshes"])
    exponent = _exponent(meshes.max(initial=0.0))
    power = f"{power_of_ten(exponent)} " if exponent else ""
    return meshes / 10.0**exponent, f"Engagements of a gear tooth ({power}meshes)"


def step_name(array: xr.DataArray, step: int) -> str:
    """Name of a wear step for a legend: its meshes, if they are known."""
    if "meshes" not in array.coords:
        return f"wear step {int(array['wear_step'].values[step])}"
    meshes = float(array["meshes"].values[step])
    if meshes == 0:
        return "unworn"
    if (units := array["meshes"].attrs.get("units", "1")) != "1":
        return f"{meshes:.4g} {units}"
    exponent = int(f"{meshes:.2e}".partition("e")[2])  # of the rounded number: 9.999 may become 10
    return f"{meshes / 10.0**exponent:.2f}·{power_of_ten(exponent)} meshes"


def chosen_steps(array: xr.DataArray) -> list[int]:
    """First, middle and last wear step, without repeats."""
    last = array.sizes["wear_step"] - 1
    return sorted({0, last // 2 + last % 2, last})


def step_colours(count: int) -> list[tuple[float, ...]]:
    """One colour per wear step, from dark to light."""
    import matplotlib

    return [tuple(colour) for colour in matplotlib.colormaps["viridis"](np.linspace(0.0, 0.75, max(count, 2)))]


def _exponent(value: float) -> int:
    return 3 * int(np.floor(np.log10(value) / 3)) if value >= 1e4 else 0
