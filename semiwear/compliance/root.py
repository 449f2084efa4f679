"""Points of the tooth root at which stress is computed, and the loads at the load heights."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import make_interp_spline

from semiwear.arrays import FloatArray
from semiwear.compliance.cubics import CUBIC, cubic_at
from semiwear.compliance.prism import PrismSection
from semiwear.kernel_cache import inner_njit

ROOT_FROM = 0.3
"""Fraction of the fillet's length, from the flank's end, that is left out of the root stress: a load beside the
fillet causes local contact stress there, while the greatest stress of the notch lies lower for every load."""

ROOT_POINTS = 17
"""Points of the root at which stress is computed."""

ROOT_STATIONS = 33
"""Stations along the width, in the middles of as many equal parts."""

# the maximum is sought between the stations as well: on a wide tooth the peak under a short load lies between two
_BETWEEN_STATIONS = make_interp_spline(np.arange(ROOT_STATIONS), np.eye(ROOT_STATIONS), k=3)(
    np.linspace(0.0, ROOT_STATIONS - 1.0, 4 * ROOT_STATIONS - 3)
)


def at_root(section: PrismSection, stress: FloatArray) -> FloatArray:
    """Stress (..., fillet point, load) of a prism at points of the root, by cubic splines along the fillet."""
    at = np.linspace(ROOT_FROM, 1.0, ROOT_POINTS)
    between = make_interp_spline(section.fillet_share, np.eye(len(section.fillet_share)), k=3)(at)
    return np.asarray(between @ stress)


@inner_njit(cache=True, error_model="numpy")
def _share_out(force, moved, place, place_slope, heights, local, loads):  # type: ignore[no-untyped-def]
    """Add forces (roll, face, places) to loads (roll, face, height); `local`: memory of `cubic_at`."""
    for r in range(force.shape[0]):
        for i in range(force.shape[1]):
            for k in range(force.shape[2]):
                if force[r, i, k] != 0.0:
                    at = place[r, i] + place_slope[r, i] * moved[r, i, k]
                    first = cubic_at(at, heights, local[0], local[1])
                    for a in range(local.shape[1]):
                        loads[r, i, first + a] += force[r, i, k] * local[0, a]


def loads_by_height(
    force: FloatArray, moved: FloatArray, place: FloatArray, place_slope: FloatArray, heights: FloatArray
) -> FloatArray:
    """Forces at points across contact lines, distributed to load heights.

    Parameters
    ----------
    force : (roll, face) or (roll, face, places) array [N]
    moved : array [mm]
        Distance of each force from the line, in the driven flank's profile coordinate; shaped like `force`.
    place, place_slope : (roll, face) arrays
        Height of the line as a share of the flank, and its derivative by the driven profile [1/mm].
    heights : (H,) array
        Load heights as shares of the flank, growing.

    Returns
    -------
    (roll, face, H) array [N]
    """
    loads, shape = np.zeros((*place.shape, len(heights))), (*place.shape, -1)
    local = np.empty((2, min(CUBIC, len(heights))))
    _share_out(force.reshape(shape), moved.reshape(shape), place, place_slope, heights, local, loads)
    return loads


def greatest_along_root(stress: FloatArray) -> FloatArray:
    """Greatest tensile stress (roll,) of stresses (roll, station, point) [MPa], sought between stations as well."""
    return np.asarray(np.maximum((stress.max(axis=2) @ _BETWEEN_STATIONS.T).max(axis=1), 0.0))


def add_later(total: FloatArray, seen: FloatArray, rolls: int) -> None:
    """Add what is seen at each roll to a sum so many rolls later, earlier if negative; nothing beyond its ends."""
    if rolls < 0:
        total[:rolls] += seen[-rolls:]
    else:
        total[rolls:] += seen[: max(len(seen) - rolls, 0)]
