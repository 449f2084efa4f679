"""Errors of a coarse grid, interpolated between designs that were also solved on a fine one."""

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
    """Differences of aims and limited quantities between a coarse grid and a finer one.

    They are interpolated by linear radial basis functions about a constant: with one design the difference is the
    same everywhere, and far from all designs it stays within the range of the known differences.

    Attributes
    ----------
    space : Space
    points : (known, fields) array
        Designs solved on the fine grid, no two of them the same.
    differences : (known, values) array
    """

    space: Space
    points: FloatArray
    differences: FloatArray

    def at(self, points: FloatArray) -> FloatArray:
        """Corrections of coarse values at points (n, fields), to be added: (n, values)."""
        return np.asarray(self._functions(inputs_of(self.space, points)))

    @cached_property
    def _functions(self) -> RBFInterpolator:
        return RBFInterpolator(inputs_of(self.space, self.points), self.differences, kernel="linear", degree=0)
