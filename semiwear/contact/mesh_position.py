"""A mesh position of the contact lines: slices that may touch there, and how they yield to one another's forces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semiwear.contact.footprint import Footprints

__all__ = ["MeshPosition"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class MeshPosition:
    """What a mesh position needs at every wear state: its candidates and what does not change about them.

    Attributes
    ----------
    cap : float [mm]
        Fresh separation below which a slice is a candidate.
    index : (n,) int array
        Flat indices of the candidates in (roll, face) arrays.
    starts : (lines + 1,) int array
        First candidate of each contact line.
    usual : float [mm]
        Half-width of a usual load.
    smooth : (n, n) array [mm/N]
        What slices feel of one another as a whole: tooth compliance less the half-space at the mid-surface.
    static : (n, n) array [mm/N]
        The same and the far field of the stripe kernel.
    slope : (n, n) array [mm/N/mm]
        Change of row i when point i moves.
    profile, lever, length, arc : (n,) arrays [mm]
    farthest_move : float [mm]
        Of a worn line, up to which tooth compliance follows it linearly.
    """

    cap: float
    index: IntArray
    starts: IntArray
    usual: float
    smooth: FloatArray
    static: FloatArray
    slope: FloatArray
    profile: FloatArray
    lever: FloatArray
    length: FloatArray
    arc: FloatArray
    farthest_move: float

    def compliance(
        self, matrix: FloatArray, chosen: IntArray, worn: Footprints, wear_compliance: FloatArray | None
    ) -> FloatArray:
        """`matrix` between chosen candidates, where they lie on the worn flank, and the wear that a force causes."""
        index, pick = self.index[chosen], np.ix_(chosen, chosen)
        picked = matrix[pick]
        moved = np.clip(worn.profile.ravel()[index] - self.profile[chosen], -self.farthest_move, self.farthest_move)
        if moved.any():
            change = self.slope[pick] * moved[:, None]
            picked += change
            picked += change.T
        if wear_compliance is not None:
            picked.ravel()[:: chosen.size + 1] += wear_compliance.ravel()[index]
        return picked
