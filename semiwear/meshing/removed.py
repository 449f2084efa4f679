"""Material removed from two flanks, as the slices of a roll position meet it.

Wear of the driven flank is the same at every roll position. What the driving flank lacks is met elsewhere at
each of them, so that it has a row of its own for every roll position; and that flank goes on beyond the tip of the
driven one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.meshing.flank_grid import FlankGrid

__all__ = ["Removed"]


@dataclass(frozen=True)
class Removed:
    """Depth by which the separation has grown, in the slices of the driven flank.

    Attributes
    ----------
    grid : FlankGrid
        Where it is known: at nodes of the driven flank, closer ones and some beyond the tip where both flanks wear.
    depth : (rows, face, profile) array [mm]
        Along the common normal, >= 0.
    row : (roll,) int array
        Which row each roll position meets.
    windows : (roll, face, 2) int array or None
        First node and the one behind the last between which the depth is known; None: everywhere.
    """

    grid: FlankGrid
    depth: FloatArray
    row: IntArray
    windows: IntArray | None = None

    @classmethod
    def met(cls, grid: FlankGrid, depth: FloatArray, rolls: int) -> Removed:
        """From `depth` [mm] of one row, (1, face, profile), or of one for every roll position."""
        return cls(grid, depth, np.arange(rolls) if depth.shape[0] > 1 else np.zeros(rolls, dtype=np.int64))

    def every(self, step: int) -> Removed:
        """That of every `step`-th roll position."""
        windows = None if self.windows is None else self.windows[::step]
        return Removed(self.grid, self.depth, self.row[::step], windows)

    @property
    def known(self) -> IntArray:
        """Windows, (roll, face, 2); all nodes where there are none."""
        if self.windows is not None:
            return self.windows
        return np.tile(np.array([0, self.depth.shape[-1]]), (self.row.size, self.depth.shape[1], 1))

    @property
    def varies(self) -> BoolArray:
        """Whether a slice has another shape than the nominal flanks give it, (roll, face)."""
        return np.asarray((np.ptp(self.depth, axis=2) > 0.0)[self.row])
