"""What a result may hold: numbers, or nothing with a reason."""

from __future__ import annotations

import numpy as np
import xarray as xr

__all__ = ["assert_finite_or_explained"]


def assert_finite_or_explained(name: object, values: xr.DataArray) -> None:
    """No infinite number, and none that is missing without a reason."""
    if values.dtype.kind != "f":
        return
    assert not np.isinf(values.values).any(), name
    assert not np.isnan(values.values).any() or values.attrs.get("missing_because"), name
