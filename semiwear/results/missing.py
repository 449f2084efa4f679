"""Groups and values that a result does not hold, and pressures on edges."""

from __future__ import annotations

import numpy as np
import xarray as xr

_LEAST_SHARE = 1e-6  # of the load; less is rounding


def group_of(tree: xr.DataTree, name: str) -> xr.Dataset:
    """A group of a result; empty if there is none of that name."""
    return tree[name].to_dataset() if name in tree.children else xr.Dataset()


def why_missing(array: xr.DataArray) -> str:
    """Reason why values of a variable are NaN; empty if none is."""
    if not np.isnan(np.asarray(array.values, dtype=float)).any():
        return ""
    return str(array.attrs.get("missing_because", "not known"))


def missing_notes(dataset: xr.Dataset) -> dict[str, str]:
    """Reasons for missing values by the names of the variables that have some."""
    numbers = {str(name): array for name, array in dataset.data_vars.items() if array.dtype.kind == "f"}
    return {name: why_missing(array) for name, array in numbers.items() if why_missing(array)}


def away_from_edges(engagement: xr.Dataset) -> xr.DataArray:
    """`contact_pressure_max` off the borders only: NaN where a pair bears load on edges only.

    Results of earlier versions hold 0 there, without `contact_pressure_on_edge`.
    """
    pressure = engagement["contact_pressure_max"]
    if "contact_pressure_on_edge" in engagement:
        return pressure.where(engagement["contact_pressure_on_edge"] == 0)
    if "load_share" not in engagement:
        return pressure
    return pressure.where((pressure > 0.0) | (engagement["load_share"] <= _LEAST_SHARE))
