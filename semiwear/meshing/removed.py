"""Material removed from both flanks in the slices of each roll position.

Wear of the driven flank is the same at every roll position. The driving flank has other mating points at each of
them, so that its material removed needs a row for every roll position; and that flank extends beyond the tip of the
driven one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.meshing.flank_grid import FlankGrid


@dataclass(frozen=True)
class Removed:
    """Depth by which the separation has grown, in the slices of the driven flank.

    Attributes
    ----------
    grid : FlankGrid
        Nodes of the driven flank; closer ones, with some beyond the tip, where both flanks wear.
    depth : (rows, face, profile) array [mm]
        Along the common normal, >= 0.
    row : (roll,) int array
        Row of `depth` for each roll position.
    windows : (roll, face, 2) int array or None
        First node with a depth and the one behind the last; None: all nodes.
    """

    grid: FlankGrid
    depth: FloatArray
    row: IntArray
    windows: IntArray | None = None

    @classmethod
    def met(cls, grid: FlankGrid, depth: FloatArray, rolls: int) -> Removed:
        """Material removed from `depth` [mm] of one row, (1, face, profile), or of one row per roll position."""
        return cls(grid, depth, np.arange(rolls) if depth.shape[0] > 1 else np.zeros(rolls, dtype=np.int64))

    def every(self, step: int) -> Removed:
        """Material removed at every `step`-th roll position."""
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
        """Whether the gap of a slice differs in shape from that of the nominal flanks, (roll, face)."""
        return np.asarray((np.ptp(self.depth, axis=2) > 0.0)[self.row])
