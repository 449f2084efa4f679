"""Permissible stress over load cycles (S-N curve), straight between its points on logarithmic axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import FloatArray


@dataclass(frozen=True)
class LifeCurve:
    """Permissible stress over load cycles.

    Before the first point the stress is that of static strength, beyond the last one it is borne for ever.

    Attributes
    ----------
    cycles : tuple of float
        Growing.
    stress : tuple of float [MPa]
        Not growing.

    Source
    ------
    ISO 6336-2:2019, table 2 and ISO 6336-3:2019, table 3 (life factors); ISO 6336-6:2019, figure 1 (their use).
    """

    cycles: tuple[float, ...]
    stress: tuple[float, ...]

    @classmethod
    def below_static(cls, cycles: ArrayLike, stress: ArrayLike) -> LifeCurve:
        """The curve through points, held down to static strength, the first of them, where it would rise above.

        Influences that count on endured stresses alone, such as that of a film, may raise these so far.

        Parameters
        ----------
        cycles, stress : (point,) arrays [1], [MPa]
        """
        x, y = np.asarray(cycles, float), np.asarray(stress, float)
        above = np.flatnonzero(y > y[0])
        if above.size > 0:
            last = above[-1]
            after = slice(last, last + 2)  # the point behind it, if there is one
            falls = np.interp(-np.log(y[0]), -np.log(y[after]), np.log(x[after]))
            x, y = np.append([x[0], np.exp(falls)], x[last + 1 :]), np.append([y[0], y[0]], y[last + 1 :])
        return cls(tuple(x.tolist()), tuple(y.tolist()))

    @classmethod
    def of_factors(cls, points: ArrayLike, stress: float, influence: float) -> LifeCurve:
        """The curve through life factors, `below_static`.

        Parameters
        ----------
        points : (point, 2) array
            Load cycles and life factors; the last point but one is at the reference number of cycles.
        stress : float [MPa]
            For a life factor of 1.
        influence : float
            Counts in full from the reference number of cycles on and not at all in static strength.
        """
        cycles, factors = np.array(points).T
        share = np.clip(np.log(cycles / cycles[0]) / np.log(cycles[-2] / cycles[0]), 0.0, 1.0)
        return cls.below_static(cycles, stress * factors * influence**share)

    @property
    def static(self) -> float:
        """Stress above which one cycle breaks [MPa]."""
        return self.stress[0]

    @property
    def endured(self) -> float:
        """Stress that is borne for ever [MPa]."""
        return self.stress[-1]

    def permissible(self, cycles: ArrayLike) -> FloatArray:
        """Permissible stress [MPa] for numbers of load cycles."""
        log_cycles = np.log(np.maximum(np.asarray(cycles, float), self.cycles[0]))
        return np.asarray(np.exp(np.interp(log_cycles, np.log(self.cycles), np.log(self.stress))))

    def damage_per_cycle(self, log_stress: FloatArray) -> FloatArray:
        """Inverse of the life under a stress, whose logarithm [log MPa] is given.

        0 where it is borne for ever, infinite above static strength; of NaN it is NaN.
        """
        # where the curve is flat at its end, the life is that of the flat's beginning
        corner = max(i for i in range(len(self.stress)) if i == 0 or self.stress[i] < self.stress[i - 1])
        stress = np.log(self.stress[corner::-1])
        log_life = np.interp(log_stress, stress, np.log(self.cycles[corner::-1]))
        damage = np.where(log_stress < stress[0], 0.0, np.exp(-log_life))
        return np.asarray(np.where(log_stress > stress[-1] + 1e-12, np.inf, damage))
