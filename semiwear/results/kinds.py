"""Kinds of reported quantities, and the difference of two results.

A difference is relative to the greatest value of its kind over the whole run: a wear depth to the greatest wear
depth, a pressure to the greatest pressure, a transmission error to the greatest transmission error.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from xarray import DataTree

from semiwear.arrays import FloatArray
from semiwear.results.rating_errors import safeties_of

History = dict[str, FloatArray]
"""Reported quantities by name, each with the wear states as first axis."""
Errors = dict[str, float]
"""Relative errors of reported quantities by name."""

_NOT_COMPARED = ("tip_relief_to_free",)  # advice, for which no accuracy is requested
# kinds with several members
_FAMILIES = ("wear_depth", "wear_volume", "contact_pressure", "transmission_error", "subsurface_stress")


def kind_of(name: str) -> str:
    """Kind of a reported quantity, to whose greatest value it is compared."""
    # a depth below the surface is no stress
    if name.endswith("stress_depth"):
        return name
    return next((kind for kind in _FAMILIES if name.startswith(kind)), name)


def history(tree: DataTree, states: Sequence[int] | None = None) -> History:
    """Quantities of `/history` and the safeties of `/ratings` at all wear states or at some; the meshes count where
    depths were prescribed.

    Parameters
    ----------
    tree : DataTree
        A result.
    states : sequence of int, optional
        Indices of wear states.
    """
    data = tree["history"].to_dataset()
    found = {
        str(name): np.asarray(values.values, float)
        for name, values in data.data_vars.items()
        if name not in _NOT_COMPARED
    }
    if "ratings" in tree.children:
        ratings = tree["ratings"].to_dataset()
        found |= safeties_of(ratings["mode"].values, ratings["safety"].values)
    found["meshes"] = np.asarray(data["meshes"].values, float)
    return found if states is None else {name: values[list(states)] for name, values in found.items()}


def greatest(values: History) -> dict[str, float]:
    """Greatest magnitude of each kind over all wear states."""
    scale: dict[str, float] = {}
    for name, array in values.items():
        kind = kind_of(name)
        scale[kind] = max(scale.get(kind, 0.0), _greatest_size(array))
    return scale


def difference(values: History, reference: History) -> Errors:
    """Difference of a history from another, over the greatest value of each kind in the other.

    Where the two have other numbers of states, only their last ones are compared. States in which either value is
    missing are not; a quantity that has none left has no error.
    """
    scale = greatest(reference)
    errors: Errors = {}
    for name, there in reference.items():
        if name not in values:
            continue
        here, unit = values[name], scale[kind_of(name)]
        if here.shape[0] != there.shape[0]:
            here, there = here[-1:], there[-1:]
        if np.isfinite(here - there).any():
            errors[name] = _greatest_size(here - there) / unit if unit > 0.0 else 0.0
    return errors


def _greatest_size(array: FloatArray) -> float:
    """Greatest magnitude of the values that are not missing."""
    return float(np.max(np.abs(array), where=np.isfinite(array), initial=0.0))


def worst(errors: Mapping[str, float]) -> float:
    """The greatest of some errors."""
    return max(errors.values(), default=0.0)


def step_errors(wear_error: float, values: Mapping[str, FloatArray]) -> Errors:
    """Errors of all reported quantities that follow from an error of the wear.

    The change of a quantity by wear is taken to have the same relative error as the wear.

    Parameters
    ----------
    wear_error : float
        Error of the wear depths, over the depths at the end.
    values : mapping of str to array
        Reported quantities, each with the wear states as first axis.
    """
    arrays = {name: np.asarray(array, float) for name, array in values.items() if name not in _NOT_COMPARED}
    scale = greatest(arrays)
    errors: Errors = {}
    for name, array in arrays.items():
        unit, change = scale[kind_of(name)], array - array[:1]
        if np.isfinite(change).any():
            errors[name] = wear_error * _greatest_size(change) / unit if unit > 0.0 else 0.0
    return errors
