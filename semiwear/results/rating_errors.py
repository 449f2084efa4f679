"""Errors of safeties and of lives until failure, from the error estimates of a run."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from semiwear.arrays import FloatArray

_PREFIX = "safety_"


def safeties_of(modes: NDArray[np.str_], safety: FloatArray) -> dict[str, FloatArray]:
    """Safeties as reported quantities by name, each (wear_step, body), for which accuracy is requested and reported.

    Parameters
    ----------
    modes : (mode,) array of str
    safety : (mode, wear_step, body) array
    """
    return {f"{_PREFIX}{mode}": np.asarray(own, float) for mode, own in zip(modes, safety, strict=True)}


def safety_and_life_errors(ratings: xr.Dataset, diagnostics: xr.Dataset) -> dict[str, FloatArray]:
    """Errors of the safeties and of the meshes until failure, as variables of `/ratings`.

    The relative error of a life is that of the safety times the sensitivity of the life to the safety.

    Parameters
    ----------
    ratings, diagnostics : Dataset
        Of a result; the estimates of the latter are over the greatest safety of each mode.

    Returns
    -------
    dict
        `safety_error` (mode,), absolute, and `meshes_to_failure_error` (mode, body), NaN where nothing fails; empty
        without estimates.
    """
    if "error_estimate" not in diagnostics:
        return {}
    estimates = dict(zip(diagnostics["quantity"].values, diagnostics["error_estimate"].values, strict=True))
    relative = np.array([estimates.get(f"{_PREFIX}{mode}", np.nan) for mode in ratings["mode"].values])
    error = relative * np.nanmax(ratings["safety"].values, axis=(1, 2), initial=0.0)
    lives, exponent = ratings["meshes_to_failure"].values, ratings["meshes_to_failure_exponent"].values
    of_required = error / ratings["required_safety"].values
    return {"safety_error": error, "meshes_to_failure_error": np.abs(exponent) * lives * of_required[:, None]}
