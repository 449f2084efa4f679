"""Roughness of flanks that run in: it approaches its final value with the depth that wear has taken off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import FloatArray
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.worn_depth import worn_depth

__all__ = ["RunningIn"]


@dataclass(frozen=True)
class RunningIn:
    """Law of first order: a wear depth dh takes the share dh/h_0 of what is left to go, dR/dh = -(R - R_end)/h_0.

    R/R_0 = 1 - s (1 - exp(-h/h_0)), with the share s that goes in the end. The exponential transient of wear and the
    approach to an equilibrium roughness are those of Queener, Smith and Mitchell (1965, Wear 8, 391-400) and of Hu,
    Li and Tonder (1991, J. Tribology 113, 499-505), as Khonsari, Ghatrehsamani and Akbarzadeh (2021, Wear 474-475,
    203871) review them; with wear depth in place of time, since both measure the sliding that a point has seen.

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
        """Roughness over that when new, of flanks from which wear has taken a depth [mm]."""
        return np.asarray(1.0 + self.share * np.expm1(-np.asarray(worn, float) / self.depth))

    def of_both(self, teeth: LoadedTeeth, state: LoadedState, touched: FloatArray) -> FloatArray:
        """Mean of what remains on both flanks, which are equally rough when new, (roll, face).

        Parameters
        ----------
        teeth : LoadedTeeth
        state : LoadedState
        touched : (roll, face) array [mm]
            Profile coordinate at which the driven flank is touched in every slice.
        """
        return np.asarray(self.remaining(worn_depth(teeth, state, touched)).mean(axis=0))
