"""Wear of both flanks where they bear."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from semiwear.contact.loaded_teeth import LoadedState
from semiwear.meshing.flank_grid import at_places

__all__ = ["worn_depth"]

FloatArray = NDArray[np.float64]


def worn_depth(state: LoadedState, profile: FloatArray, places: FloatArray) -> FloatArray:
    """Depth that wear has taken off each body where they touch, (body, roll, face) [mm].

    Parameters
    ----------
    state : LoadedState
    profile : (body, face, node) array [mm]
        Profile coordinate of the nodes that carry wear, on the body's own flank.
    places : (body, roll, face) array [mm]
        Where each flank is touched.
    """
    found = np.zeros(places.shape)
    for body, wear in enumerate((state.driving_wear, state.wear)):
        if wear is not None:
            found[body] = at_places(profile[body], wear, places[body])
    return found
