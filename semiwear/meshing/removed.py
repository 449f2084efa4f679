"""Material that is gone from two flanks, as the slices of a roll position meet it.

Wear of the driven flank is the same at every roll position. What is gone from the driving flank is met elsewhere at
each of them, so that it has a row of its own for every roll position.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Removed"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class Removed:
    """What the separation has grown by, at the nodes of the driven flank.

    Attributes
    ----------
    depth : (rows, face, profile) array [mm]
        Along the common normal, >= 0.
    row : (roll,) int array
        Which row each roll position meets.
    """

    depth: FloatArray
    row: IntArray

    @classmethod
    def alike(cls, depth: FloatArray, rolls: int) -> Removed:
        """The same at every roll position: `depth` is (face, profile) [mm]."""
        return cls(depth[None], np.zeros(rolls, dtype=np.int64))

    def every(self, step: int) -> Removed:
        """That of every `step`-th roll position."""
        return Removed(self.depth, self.row[::step])

    @property
    def varies(self) -> NDArray[np.bool_]:
        """Whether a slice has another shape than the nominal flanks give it, (roll, face)."""
        return (np.ptp(self.depth, axis=2) > 0.0)[self.row]
