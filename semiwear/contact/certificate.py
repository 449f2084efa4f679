"""Residuals of the contact conditions: p >= 0, separation >= 0, and one of them zero."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import BoolArray, FloatArray
from semiwear.kernel_cache import njit


@dataclass(frozen=True)
class ContactCertificate:
    """Residuals of the contact conditions, from one application of the compliance to the final pressure.

    Attributes
    ----------
    penetration : float
        Largest overlap of the surfaces where there is no pressure, over the largest displacement.
    gap_spread : float
        Largest deformed separation where there is pressure, over the largest displacement.
    load_error : float
        Sum of the pressures against the load, relative (0 when the approach was given).
    field_error : float
        Estimated L2 error of the pressure, relative: what is compared with the tolerance.
    """

    penetration: float
    gap_spread: float
    load_error: float
    field_error: float


@dataclass(frozen=True)
class Residuals:
    """Separations that a pressure leaves, in the unit of the gap.

    Attributes
    ----------
    least : float
        Least separation of cells without pressure that may touch; infinite if there are none.
    spread : float
        Greatest separation, without its sign, of cells with pressure.
    displacement, pressure : float
        Greatest ones.
    """

    least: float
    spread: float
    displacement: float
    pressure: float


@njit(cache=True, error_model="numpy")
def _residuals(gap, displacement, approach, allowed, pressure):  # type: ignore[no-untyped-def]
    least, spread, deepest, highest = np.inf, 0.0, 0.0, 0.0
    for i in range(gap.shape[0]):
        for j in range(gap.shape[1]):
            separation = gap[i, j] + displacement[i, j] - approach[i]
            if displacement[i, j] > deepest:
                deepest = displacement[i, j]
            if pressure[i, j] > 0.0:
                spread = max(spread, abs(separation))
                highest = max(highest, pressure[i, j])
            elif separation < least and allowed[i, j]:
                least = separation
    return least, spread, deepest, highest


def residuals_of(
    gap: FloatArray, displacement: FloatArray, approach: FloatArray | float, allowed: BoolArray, pressure: FloatArray
) -> Residuals:
    """Separations of cells (nx, ny) under a common approach, or one for each row (nx,)."""
    rows = np.broadcast_to(np.asarray(approach, float), gap.shape[:1])
    return Residuals(*_residuals(gap, displacement, rows, allowed, pressure))
