"""The interface of an addition to the compliance between the slices of contact lines."""

from __future__ import annotations

from typing import Protocol

from semiwear.arrays import FloatArray, IntArray


class SliceCompliance(Protocol):
    """A compliance under the contact forces in addition to half-space and teeth."""

    def matrix(self, at: tuple[IntArray, IntArray], starts: IntArray) -> FloatArray:
        """Compliance between slices.

        Parameters
        ----------
        at : (rolls, faces) of (n,) int arrays
            The slices: indices into the (roll, face) arrays of the contact lines.
        starts : (lines + 1,) int array
            First slice of each contact line.

        Returns
        -------
        (n, n) array [mm/N]
            Approach of the bodies at slice i per force on slice j; symmetric.
        """
