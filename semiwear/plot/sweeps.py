"""Pictures of a sweep: one value per scene, as curves, as a map, or over a field of samples."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.plot.posterior import with_spaces
from semiwear.plot.style import axes_for, label, step_colours, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SAMPLE = "sample"
_MOST_CURVES = 7
_MOST_COLUMNS = 9
_MOST_WRITTEN = 64  # cells of a map whose numbers are written
_BODY = "gear"
_COMPLETE = (0, 4)  # status: done, or endless (infinite life)


def scene_values(found: xr.Dataset, name: str, body: str = _BODY) -> xr.DataArray:
    """One value per scene of a variable of a sweep: at the end of each run, of one body; NaN if the scene failed.

    Raises
    ------
    SemiwearError
        The sweep has no such variable, or the variable has more than one value per scene.
    """
    if "status" not in found or name not in found.data_vars:
        raise SemiwearError(f"the picture needs a sweep with {name}; this one has {', '.join(map(str, found))}")
    array = found[name]
    if "body" in array.dims:
        array = array.sel(body=body)
    if "wear_step" in array.dims:
        last = found["last_wear_step"] if "last_wear_step" in found else array.sizes["wear_step"] - 1
        array = array.isel(wear_step=last).drop_vars("wear_step", errors="ignore")
    if array.dims != found["status"].dims:
        raise SemiwearError(f"{name} has more than one value per scene: {', '.join(map(str, array.dims))}")
    array = array.where(found["status"].isin(_COMPLETE))  # an interrupted run has no last value
    array.attrs = dict(found[name].attrs)
    if "body" in found[name].dims:
        array.attrs["long_name"] = f"{array.attrs.get('long_name', name)} ({body})"
    return array


@dataclass(frozen=True)
class _View:
    """Values over one or two fields, at fixed values of the others.

    Attributes
    ----------
    values : DataArray
    failed : array
        Whether the scene failed.
    held : str
        Values of the other fields as text.
    """

    values: xr.DataArray
    failed: np.ndarray
    held: str


def _view(found: xr.Dataset, name: str, body: str, requested: tuple[str | None, str | None]) -> _View:
    fields = [field for field in requested if field is not None]
    values = scene_values(found, name, body)
    dims = [str(dim) for dim in values.dims]
    if dims == [_SAMPLE]:
        raise SemiwearError("the picture needs a grid of values; for samples use sweep_samples")
    for field in fields:
        if field not in dims:
            raise SemiwearError(f"{field} is not varied along a dimension of its own; these are: {', '.join(dims)}")
    order = sorted(dims, key=lambda dim: (values[dim].dtype.kind == "U", -values.sizes[dim]))
    chosen = [*fields, *(dim for dim in order if dim not in fields and values.sizes[dim] > 1)][:2]
    chosen = chosen or order[:1]
    rest = _held(values, [dim for dim in dims if dim not in chosen])
    held = ", ".join(f"{dim} {_text(values[dim].values[k], values[dim])}" for dim, k in rest.items())
    failed = (~found["status"].isin(_COMPLETE)).isel(rest).transpose(*chosen)
    return _View(values.isel(rest).transpose(*chosen), failed.values, held)


def _held(values: xr.DataArray, dims: list[str]) -> dict[str, int]:
    """Indices of the fields that a picture does not show: those with most scenes done, nearest to the middle."""
    if not dims:
        return {}
    done = values.notnull().sum([dim for dim in values.dims if dim not in dims]).transpose(*dims).values
    places = np.argwhere(done == done.max())
    distance = np.abs(places - np.array(done.shape) // 2).sum(axis=1)
    return dict(zip(dims, map(int, places[int(np.argmin(distance))]), strict=True))


def _text(value: object, array: xr.DataArray) -> str:
    number = f"{value:.4g}" if isinstance(value, int | float | np.number) else str(value)
    units = str(array.attrs.get("units", "1"))
    return number if units == "1" else f"{number} {units}"


def _places(array: xr.DataArray) -> np.ndarray:
    """Positions along an axis: the values, or their indices if they are text."""
    return np.arange(array.size) if array.dtype.kind == "U" else np.asarray(array.values, float)


def _ticks(ax: Axes, array: xr.DataArray, which: str) -> None:
    if array.dtype.kind == "U":
        getattr(ax, f"set_{which}ticks")(np.arange(array.size), [str(text) for text in array.values])


def _axis_label(array: xr.DataArray) -> str:
    return label(array, with_spaces(str(array.name)))


@styled()
def sweep_curves(
    found: xr.Dataset,
    name: str,
    over: str | None = None,
    by: str | None = None,
    *,
    body: str = _BODY,
    ax: Axes | None = None,
) -> Axes:
    """A quantity at the end of each run over a varied field, a curve for each value of another one.

    Further fields are fixed where most scenes are done, near the middle; crosses mark scenes that failed.

    Parameters
    ----------
    found : Dataset
        Of `sweep`, on a grid.
    name : str
        Variable, e.g. ``"root_stress_max"``.
    over, by : str, optional
        Dimensions; by default the longest and the next one.
    body : str
        Of a quantity of both bodies.
    ax : Axes, optional
        Where to draw; a new figure unless given.

    Returns
    -------
    Axes
    """
    view = _view(found, name, body, (over, by))
    (ax,) = axes_for(ax)
    values = view.values if view.values.ndim == 2 else view.values.expand_dims("curve", 1)
    x = values[str(values.dims[0])]
    places, order = _places(x), np.argsort(_places(x))
    columns = np.unique(np.linspace(0, values.shape[1] - 1, min(values.shape[1], _MOST_CURVES)).round().astype(int))
    other = view.values[str(view.values.dims[1])] if view.values.ndim == 2 else None
    for colour, k in zip(step_colours(columns.size), columns, strict=False):
        curve_name = "" if other is None else _text(other.values[k], other)
        ax.plot(places[order], values.values[order, k], "o-", color=colour, ms=3.5, label=curve_name)
    failed = view.failed.reshape(values.shape).any(axis=1)
    if failed.any():
        ax.plot(
            places[failed], np.full(failed.sum(), 0.02), "x", color="#A63C00", transform=ax.get_xaxis_transform(),
            label="failed", clip_on=False,
        )  # fmt: skip
    _ticks(ax, x, "x")
    ax.set(xlabel=_axis_label(x), ylabel=_short(view.values), title=view.held)
    if other is not None:
        ax.legend(title=_axis_label(other), fontsize=8)
    return ax


def _short(array: xr.DataArray) -> str:
    """Label of a quantity, in several lines if it is long."""
    return textwrap.fill(label(array), 42)


@styled()
def sweep_map(
    found: xr.Dataset,
    name: str,
    over: str | None = None,
    by: str | None = None,
    *,
    body: str = _BODY,
    ax: Axes | None = None,
) -> Axes:
    """A quantity at the end of each run over two varied fields, as a map; scenes that failed are hatched.

    Parameters and return value as in `sweep_curves`.

    Raises
    ------
    SemiwearError
        Fewer than two fields are varied on a grid.
    """
    view = _view(found, name, body, (over, by))
    if view.values.ndim != 2:
        raise SemiwearError("a map needs two varied fields")
    (ax,) = axes_for(ax)
    x, y = (view.values[str(dim)] for dim in view.values.dims)
    order = np.argsort(_places(x)), np.argsort(_places(y))
    values = view.values.values[np.ix_(*order)].T
    borders = [_borders(_places(axis)[k]) for axis, k in zip((x, y), order, strict=True)]
    ax.set_facecolor("#D8DCE1")
    ax.grid(False)
    shown = ax.pcolormesh(*borders, np.ma.masked_invalid(values), cmap="viridis")
    ax.figure.colorbar(shown, ax=ax, label=_short(view.values))
    if values.size <= _MOST_WRITTEN or np.isnan(values).any():
        middles = [0.5 * (ends[1:] + ends[:-1]) for ends in borders]
        _write_numbers(ax, middles, values)
    _ticks(ax, x[order[0]], "x")
    _ticks(ax, y[order[1]], "y")
    ax.set(xlabel=_axis_label(x), ylabel=_axis_label(y), title=view.held)
    return ax


def _borders(places: np.ndarray) -> np.ndarray:
    """Borders of cells around sorted positions: half-way between neighbours."""
    if places.size == 1:
        return np.array([places[0] - 0.5, places[0] + 0.5])
    middle = 0.5 * (places[1:] + places[:-1])
    return np.concatenate([[2 * places[0] - middle[0]], middle, [2 * places[-1] - middle[-1]]])


def _write_numbers(ax: Axes, middles: list[np.ndarray], values: np.ndarray) -> None:
    finite = values[np.isfinite(values)]
    written = (
        values.size <= _MOST_WRITTEN and values.shape[1] <= _MOST_COLUMNS and np.abs(finite).max(initial=0.0) < 1e4
    )
    dark = finite.min() + 0.55 * np.ptp(finite) if finite.size else 0.0
    for j, row in enumerate(values):
        for i, value in enumerate(row):
            colour = "#A63C00" if np.isnan(value) else "white" if value < dark else "black"
            number = f"{float(f'{value:.3g}'):g}"  # 1410, not 1.41e+03
            text = "failed" if np.isnan(value) else number if written else ""
            ax.text(middles[0][i], middles[1][j], text, ha="center", va="center", fontsize=7, color=colour)


@styled()
def sweep_samples(found: xr.Dataset, name: str, field: str, *, body: str = _BODY, ax: Axes | None = None) -> Axes:
    """A quantity at the end of each run of a table of samples, against one of the varied fields.

    Parameters
    ----------
    found : Dataset
        Of `sweep`, with the dimension `sample`.
    name : str
        Variable.
    field : str
        Coordinate along `sample`.
    body : str
        Of a quantity of both bodies.
    ax : Axes, optional
        Where to draw; a new figure unless given.

    Returns
    -------
    Axes
    """
    values = scene_values(found, name, body)
    if values.dims != (_SAMPLE,) or field not in found.coords:
        raise SemiwearError(f"the picture needs samples of {field}; grids are for sweep_curves and sweep_map")
    (ax,) = axes_for(ax)
    x = found[field]
    if x.dtype.kind == "U":
        kinds, places = np.unique(x.values, return_inverse=True)
        ax.set_xticks(np.arange(kinds.size), list(map(str, kinds)))
    else:
        places = np.asarray(x.values, float)
    ax.plot(places, values.values, "o", ms=3.5, color="#0B5394", alpha=0.6)
    ax.set(xlabel=_axis_label(x), ylabel=_short(values))
    return ax
