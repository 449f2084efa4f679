"""Errors of a coarse grid, between designs that were solved finely."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import RBFInterpolator

from semiwear.arrays import FloatArray
from semiwear.optimise.space import Space
from semiwear.optimise.surrogate import inputs_of


@dataclass(frozen=True)
class Correction:
    """Differences of aims and limited quantities from a coarse grid to finer ones.

    Linear radial basis functions about a constant go through them: with one design the difference is the same
    everywhere, far from all it stays within what is known.

    Attributes
    ----------
    space : Space
    places : (known, fields) array
        Designs that were solved finely, no two of them the same.
    differences : (known, values) array
    """

    space: Space
    places: FloatArray
    differences: FloatArray

    def at(self, places: FloatArray) -> FloatArray:
        """To be added to coarse values at places (n, fields): (n, values)."""
        return np.asarray(self._functions(inputs_of(self.space, places)))

    @cached_property
    def _functions(self) -> RBFInterpolator:
        return RBFInterpolator(inputs_of(self.space, self.places), self.differences, kernel="linear", degree=0)
