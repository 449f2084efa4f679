"""Linear wear of slow gears after Plewe: the wear rate of a test, scaled by pressure, curvature and sliding.

Source: Plewe 1980, dissertation, TU Munich, as commonly quoted (Niemann and Winter 1989).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from semiwear.argument_ranges import require_range
from semiwear.arrays import FloatArray

_PRESSURE_EXPONENT = 1.4


def slow_speed_wear(
    wear_rate: ArrayLike,
    cycles: ArrayLike,
    *,
    pressure: ArrayLike,
    radius: ArrayLike,
    specific_sliding: ArrayLike,
    test_pressure: float,
    test_radius: float,
    test_specific_sliding: float,
) -> FloatArray:
    """Linear wear W_l = c_lT (p/p_T)^1.4 (R/R_T) (zeta/zeta_T) N [mm].

    Parameters
    ----------
    wear_rate : array [mm]
        c_lT: wear of the test for each mesh at the same film thickness (Plewe's diagram).
    cycles : array
        Meshes N.
    pressure, test_pressure : [MPa]
        Hertz pressure at the pitch point, here and in the test.
    radius, test_radius : [mm]
        Relative radius of curvature at the pitch point.
    specific_sliding, test_specific_sliding :
        Mean specific sliding over the flank, of either sign; that of the test not zero.

    Raises
    ------
    ValueError
        A number is out of its range.
    """
    require_range("wear rate and cycles", np.append(wear_rate, cycles), least=0.0, missing=True)
    require_range("pressure and radius", np.append(pressure, radius), least=0.0, missing=True)
    test = test_pressure, test_radius, abs(test_specific_sliding)
    require_range("pressure, radius and specific sliding of the test", test, above=0.0)
    ratios = (np.asarray(pressure, float) / test_pressure) ** _PRESSURE_EXPONENT
    ratios = ratios * (np.asarray(radius, float) / test_radius)
    ratios = ratios * np.abs(np.asarray(specific_sliding, float) / test_specific_sliding)
    return np.asarray(np.asarray(wear_rate, float) * ratios * np.asarray(cycles, float))
