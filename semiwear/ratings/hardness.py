"""Hardness of a case-hardened tooth over depth, and its residual stress.

Lang's (1979) text was not at hand. His coefficients of the hardness are confirmed by a report of a commercial program
on ISO DTR 19042-1; those of the residual stress are as commonly quoted.
"""

from __future__ import annotations

from collections.abc import Callable
from math import log10, sqrt

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import FloatArray

HardnessProfile = Callable[[ArrayLike], FloatArray]

CASE_HARDNESS_HV = 550.0  # at the case-hardening depth (ISO 18203)

_LINEAR, _SQUARE = 0.0381, 0.2662  # of Lang's exponent
_SLOPES = (-1.25, 0.2857, -460.0)  # MPa/HV, MPa/HV, MPa of Lang's residual stress


def hardness_of_case(surface: float, core: float, case_depth: float) -> HardnessProfile:
    """Hardness over depth from surface, core and case-hardening depth: Lang's curve with 550 HV at that depth.

    HV(y) = core + (surface - core) 10^-(0.0381 x + 0.2662 x^2). With Lang's (1979) x = y/CHD the hardness at CHD is
    550 HV only where this is the mean of surface and core (750 and 350 HV); here x is scaled so that HV(CHD) = 550 HV
    always, the definition of the case-hardening depth in ISO 18203.

    Parameters
    ----------
    surface : float [HV]
        Above 550.
    core : float [HV]
        Below 550.
    case_depth : float [mm]
        CHD.
    """
    fall = log10((surface - core) / (CASE_HARDNESS_HV - core))
    scale = (sqrt(_LINEAR**2 + 4.0 * _SQUARE * fall) - _LINEAR) / (2.0 * _SQUARE)

    def hardness(depth: ArrayLike) -> FloatArray:
        x = scale * np.asarray(depth, float) / case_depth
        return np.asarray(core + (surface - core) * 10.0 ** -(_LINEAR * x + _SQUARE * x**2))

    return hardness


def hardness_of_table(depth: ArrayLike, hardness: ArrayLike) -> HardnessProfile:
    """Hardness over depth from measured points, linear between them and constant beyond the last.

    Parameters
    ----------
    depth : (n,) array [mm]
        Increasing.
    hardness : (n,) array [HV]
    """
    depths, values = np.array(depth, float), np.array(hardness, float)
    return lambda at: np.interp(np.asarray(at, float), depths, values)


def residual_stress(hardness: ArrayLike, core: float) -> FloatArray:
    """Residual stress along the surface [MPa] from the hardness; compression is negative.

    -1.25 (HV - core) up to 300 HV above the core and 0.2857 (HV - core) - 460 beyond (Lang 1979, as used by Witzig
    2012). The small tension in the core, which balances the case, is neglected.
    """
    above = np.maximum(np.asarray(hardness, float) - core, 0.0)
    steep, flat, offset = _SLOPES
    return np.where(above <= 300.0, steep * above, np.minimum(flat * above + offset, 0.0))
