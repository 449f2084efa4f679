"""Permissible stress over load cycles (S-N curve), linear between its points on logarithmic axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import FloatArray


@dataclass(frozen=True)
class LifeCurve:
    """Permissible stress over load cycles.

    Left of the first point lies static strength, right of the last one the endurance limit.

    Attributes
    ----------
    cycles : tuple of float
        Increasing.
    stress : tuple of float [MPa]
        Not increasing.

    Source
    ------
    ISO 6336-2:2019, table 2 and ISO 6336-3:2019, table 3 (life factors); ISO 6336-6:2019, figure 1 (their use).
    """

    cycles: tuple[float, ...]
    stress: tuple[float, ...]

    @classmethod
    def below_static(cls, cycles: ArrayLike, stress: ArrayLike) -> LifeCurve:
        """The curve through points, limited to static strength, the stress of the first point.

        Influences on the endurance limit alone, such as that of a film, may raise later points above it.

        Parameters
        ----------
        cycles, stress : (point,) arrays [1], [MPa]
        """
        x, y = np.asarray(cycles, float), np.asarray(stress, float)
        above = np.flatnonzero(y > y[0])
        if above.size > 0:
            last = above[-1]
            after = slice(last, last + 2)  # with the next point, if there is one
            crossing = np.interp(-np.log(y[0]), -np.log(y[after]), np.log(x[after]))
            x, y = np.append([x[0], np.exp(crossing)], x[last + 1 :]), np.append([y[0], y[0]], y[last + 1 :])
        return cls(tuple(x.tolist()), tuple(y.tolist()))

    @classmethod
    def of_factors(cls, points: ArrayLike, stress: float, influence: float) -> LifeCurve:
        """The curve through life factors, limited as in `below_static`.

        Parameters
        ----------
        points : (point, 2) array
            Load cycles and life factors; the last point but one is at the reference number of cycles.
        stress : float [MPa]
            For a life factor of 1.
        influence : float
            Factor on the stress from the reference number of cycles on; it has no effect on static strength.
        """
        cycles, factors = np.array(points).T
        share = np.clip(np.log(cycles / cycles[0]) / np.log(cycles[-2] / cycles[0]), 0.0, 1.0)
        return cls.below_static(cycles, stress * factors * influence**share)

    @property
    def static(self) -> float:
        """Static strength: stress above which a single cycle is a failure [MPa]."""
        return self.stress[0]

    @property
    def endured(self) -> float:
        """Endurance limit [MPa]."""
        return self.stress[-1]

    def permissible(self, cycles: ArrayLike) -> FloatArray:
        """Permissible stress [MPa] for numbers of load cycles."""
        log_cycles = np.log(np.maximum(np.asarray(cycles, float), self.cycles[0]))
        return np.asarray(np.exp(np.interp(log_cycles, np.log(self.cycles), np.log(self.stress))))

    def damage_per_cycle(self, log_stress: FloatArray) -> FloatArray:
        """Inverse of the life at a stress given by its natural logarithm, ln(stress in MPa).

        0 below the endurance limit, infinite above static strength, NaN for NaN.
        """
        # where the curve is horizontal at its end, the life is that at the corner
        corner = max(i for i in range(len(self.stress)) if i == 0 or self.stress[i] < self.stress[i - 1])
        stress = np.log(self.stress[corner::-1])
        log_life = np.interp(log_stress, stress, np.log(self.cycles[corner::-1]))
        damage = np.where(log_stress < stress[0], 0.0, np.exp(-log_life))
        return np.asarray(np.where(log_stress > stress[-1] + 1e-12, np.inf, damage))
