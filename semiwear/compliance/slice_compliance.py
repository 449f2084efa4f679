"""Compliance between slices of contact lines that comes on top of teeth and half-space."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["SliceCompliance"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class SliceCompliance(Protocol):
    """What forces on slices add to the separation of slices."""

    def matrix(self, at: tuple[IntArray, IntArray], starts: IntArray) -> FloatArray:
        """Separation per force [mm/N], symmetric and positive semidefinite with the rest: (n, n) array.

        Parameters
        ----------
        at : two (n,) int arrays
            Roll and face index of the slices.
        starts : (lines + 1,) int array
            First slice of each contact line.
        """
