"""Wear of both flanks where they bear."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from semiwear.ratings.contact import RatedContact

__all__ = ["worn_depth"]

FloatArray = NDArray[np.float64]


def worn_depth(contact: RatedContact) -> FloatArray:
    """Depth that wear has taken off each body where its pressure is greatest, (body, roll, face) [mm]."""
    state, profile, places = contact.state, contact.flanks.profile, contact.places
    found = np.zeros(places.shape)
    for body, wear in enumerate((state.driving_wear, state.wear)):
        if wear is None:
            continue
        for i in range(places.shape[2]):
            found[body, :, i] = np.interp(places[body, :, i], profile[body, i], wear[i])
    return found
