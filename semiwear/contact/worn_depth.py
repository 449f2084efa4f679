"""Wear depth of both flanks where they are in contact."""

from __future__ import annotations

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.meshing.flank_grid import at_places, at_points
from semiwear.meshing.flank_pair import BODIES, DRIVEN, DRIVING


def worn_depth(teeth: LoadedTeeth, state: LoadedState, touched: FloatArray) -> FloatArray:
    """Wear depth of each body where they touch, (body, roll, face) [mm].

    The driving flank is met beside the station of the driven one: its wear is read where the gap reads it.

    Parameters
    ----------
    teeth : LoadedTeeth
    state : LoadedState
    touched : (roll, face) array [mm]
        Profile coordinate at which the driven flank is touched in every slice.
    """
    found, lines = np.zeros((len(BODIES), *touched.shape)), teeth.lines
    found[DRIVEN] = at_places(teeth.grid.profile, state.wear, touched)
    if state.driving_wear is not None:
        found[DRIVING] = at_points(
            teeth.grid.face, teeth.driving_profile, state.driving_wear, lines.driving_face, lines.on_driving(touched)
        )
    return found
