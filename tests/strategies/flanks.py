"""Parts of a flank that tests of wear look at."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray


def away_from_borders(flank: xr.DataTree) -> NDArray[np.bool_]:
    """Nodes two half-widths, 11 nodes, from the ends of the active flank and three slices from those of the face."""
    active = flank.active.sel(body="gear").values.astype(bool)
    inside = np.zeros(active.shape, dtype=bool)
    for i in range(3, active.shape[1] - 3):
        on = np.flatnonzero(active[:, i])
        if on.size:
            inside[on[0] + 11 : on[-1] - 10, i] = True
    return inside
