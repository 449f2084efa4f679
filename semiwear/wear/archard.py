"""Archard's law of sliding wear, dh = k p v_s dt, v_s: sliding speed (Archard 1953, J. Appl. Phys. 24, 981)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from semiwear.argument_ranges import require_range
from semiwear.arrays import FloatArray


def wear_depth(coefficient: float, pressure_distance: ArrayLike) -> FloatArray:
    """Wear depth h = k * integral of p v_s dt [mm], v_s the sliding speed (Archard 1953, eq. 4, for each point).

    Valid for a coefficient that depends neither on depth nor on pressure.

    Parameters
    ----------
    coefficient : float [mm^2/N]
        k, or k times the number of meshes over which the pressures hold.
    pressure_distance : array [N/mm]
        Pressure times sliding distance at points of the flank, summed over a mesh; at least 0.

    Returns
    -------
    array [mm]
        Like `pressure_distance`.

    Raises
    ------
    ValueError
        A number is negative.

    Examples
    --------
    >>> from semiwear.wear import wear_depth
    >>> print(f"{wear_depth(1e-13 * 1e8, 50.0):.4f}")  # 1e8 meshes
    0.0005
    """
    require_range("the wear coefficient", coefficient, "mm^2/N", least=0.0)
    require_range("pressure times sliding distance", pressure_distance, "N/mm", least=0.0, missing=True)
    return np.multiply(coefficient, pressure_distance)


def wear_per_mesh(line_load: ArrayLike, specific_sliding: ArrayLike, wear_coefficient: float) -> FloatArray:
    """Wear depth of one mesh where a contact line passes [mm], independent of the pressure profile across the line.

    A pressure p = q w(x) that moves over the flank with speed v_n wears it by k q v_s/v_n (Andersson and Eriksson
    1990; v_s is the sliding speed), since the profile w has an area of one. Valid for narrow contacts, so that load
    and sliding do not change while the contact passes over a point.

    Parameters
    ----------
    line_load : array [N/mm]
    specific_sliding : array [1]
        Sliding speed over the speed at which the contact line moves over the body's flank, v_s/v_n, without sign; it
        broadcasts with `line_load`.
    wear_coefficient : float [mm^2/N]

    Returns
    -------
    array [mm]

    Raises
    ------
    ValueError
        A number is negative.

    Examples
    --------
    >>> from semiwear.wear import wear_per_mesh
    >>> print(f"{1e8 * wear_per_mesh(300.0, 0.5, 1e-13):.6f}")
    0.001500
    """
    require_range("the line load", line_load, "N/mm", least=0.0, missing=True)
    require_range("the specific sliding", specific_sliding, least=0.0, missing=True)
    return wear_depth(wear_coefficient, np.multiply(line_load, specific_sliding))
