"""Area of a flank for each node of its grid."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.meshing.flank_grid import FlankGrid
from semiwear.meshing.flank_pair import DRIVEN, FlankPair
from semiwear.meshing.own_flanks import own_flank

_STEP = 1e-4  # of the flank's height, for its tangents


def flank_area(pair: FlankPair, body: int, grid: FlankGrid) -> FloatArray:
    """Area for each node of a flank's grid [mm^2]: (face, profile).

    Half of the cells on either side along the profile, the whole slice along the face; their sum is the area between
    the outermost nodes and the ends of the outermost slices.

    Parameters
    ----------
    pair : FlankPair
    body : int
        Body whose flank it is.
    grid : FlankGrid
        Of that flank, in even slices.
    """
    return _area(pair, body, grid.face.tobytes(), grid.profile.tobytes())


@lru_cache(maxsize=16)
def _area(pair: FlankPair, body: int, faces: bytes, profiles: bytes) -> FloatArray:
    """Computed once for equal grids, which all wear states of a run and runs of equal geometry share."""
    face = np.frombuffer(faces)[:, None]
    profile = np.frombuffer(profiles).reshape(face.size, -1)
    step = _STEP * float(np.ptp(profile))

    def points(df: float, dp: float) -> FloatArray:
        if body == DRIVEN:
            return pair.meeting(face + df * step, profile + dp * step, np.zeros((1, 1))).position
        return own_flank(pair, body, face + df * step, profile + dp * step)[0]

    along, across = points(1.0, 0.0) - points(-1.0, 0.0), points(0.0, 1.0) - points(0.0, -1.0)
    each = np.linalg.norm(np.cross(along, across), axis=-1) / (2.0 * step) ** 2
    cells = 0.5 * np.diff(profile, axis=1)
    width = np.pad(cells, ((0, 0), (0, 1))) + np.pad(cells, ((0, 0), (1, 0)))
    area = np.asarray(each * width * (face[1, 0] - face[0, 0]))
    area.setflags(write=False)
    return area
