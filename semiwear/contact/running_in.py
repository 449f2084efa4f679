"""Roughness of flanks during running in: it approaches its final value with growing wear depth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import FloatArray
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.worn_depth import worn_depth


@dataclass(frozen=True)
class RunningIn:
    """First-order law: a wear depth dh removes the fraction dh/h_0 of the excess, dR/dh = -(R - R_end)/h_0.

    R/R_0 = 1 - s (1 - exp(-h/h_0)), with the fraction s removed in the end. The exponential transient of wear and the
    approach to an equilibrium roughness are those of Queener, Smith and Mitchell (1965, Wear 8, 391-400) and of Hu,
    Li and Tonder (1991, J. Tribology 113, 499-505), as Khonsari, Ghatrehsamani and Akbarzadeh (2021, Wear 474-475,
    203871) review them; with wear depth in place of time, since both measure the sliding of a point.

    Attributes
    ----------
    share : float
        s, below 1.
    depth : float [mm]
        h_0.
    """

    share: float
    depth: float

    def remaining(self, worn: ArrayLike) -> FloatArray:
        """Roughness over that when new, of flanks worn to a depth [mm]."""
        return np.asarray(1.0 + self.share * np.expm1(-np.asarray(worn, float) / self.depth))

    def of_both(self, teeth: LoadedTeeth, state: LoadedState, touched: FloatArray) -> FloatArray:
        """Mean roughness ratio of both flanks, which are equally rough when new, (roll, face).

        Parameters
        ----------
        teeth : LoadedTeeth
        state : LoadedState
        touched : (roll, face) array [mm]
            Profile coordinate at which the driven flank is touched in every slice.
        """
        return np.asarray(self.remaining(worn_depth(teeth, state, touched)).mean(axis=0))
