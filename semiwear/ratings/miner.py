"""Miner's sum over wear and a load spectrum, and the safety that it leaves (ISO 6336-6).

The safety after some wear steps is the factor on all stresses so far with which the damage would be 1. Within a wear
step the damage of a cycle passes linearly from its beginning to its end.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.ratings.life_curve import LifeCurve

_HALVINGS = 40  # of a bracket that spans a factor of about 3, for one safety
_MAP_HALVINGS = 14  # to 1e-4, for the safeties of all points
_MANY = 64  # points that are looked at first
_JUST = 1e-9


@dataclass(frozen=True, eq=False)
class StressHistory:
    """Stresses at many points over the wear steps.

    Attributes
    ----------
    cycles : (wear_step,) array
        Load cycles up to each wear step; the first is 0.
    shares : (load,) array
        Shares of the cycles under each load.
    stress : (wear_step, load, point) array [MPa]
        NaN or 0 where none acts.
    curve : LifeCurve
    """

    cycles: FloatArray
    shares: FloatArray
    stress: FloatArray
    curve: LifeCurve

    def damages(self, safety: float) -> FloatArray:
        """Greatest Miner's sum of all points with stresses raised by a safety, after every wear step."""
        logs, log_safety = self._logs, float(np.log(safety))
        return np.array([self._damage(logs, step, log_safety).max(initial=0.0) for step in range(self.cycles.size)])

    def life(self, safety: float) -> float:
        """Load cycles until Miner's sum of some point is 1 with stresses raised by a safety; NaN where none is.

        At the latest where the stress, linear within the wear step, reaches static strength.
        """
        logs = self._logs + np.log(safety)
        rates, length = self._rates(logs, 0.0), np.diff(self.cycles)
        broken = np.isinf(rates)
        if broken[0].any():
            return 0.0
        safe = np.where(broken, 0.0, rates)
        sums = np.concatenate([np.zeros((1, rates.shape[1])), np.cumsum(_mean(safe) * length[:, None], axis=0)])
        ends = [float("nan")]
        for k in range(length.size):
            whole = (sums[k] < 1.0) & ~broken[: k + 1].any(axis=0)
            full = np.flatnonzero(whole & (sums[k + 1] >= 1.0) & ~broken[k + 1])
            until = _cycles_until(1.0 - sums[k, full], safe[k, full], safe[k + 1, full], length[k])
            first = np.flatnonzero(whole & broken[k + 1])
            share, rate = self._at_static(np.exp(logs[k : k + 2, :, first]))
            static = share * length[k]
            sooner = _cycles_until(1.0 - sums[k, first], safe[k, first], rate, np.maximum(static, _JUST))
            ends += (self.cycles[k] + np.concatenate([until, np.minimum(sooner, static)])).tolist()
        return float(np.fmin.reduce(ends))

    def least_safeties(self) -> tuple[FloatArray, IntArray]:
        """Least safety of all points after every wear step, and which has it; NaN and -1 of none."""
        found = [self._least(step) for step in range(self.cycles.size)]
        return np.array([safety for safety, _ in found]), np.array([point for _, point in found])

    def safeties(self) -> FloatArray:
        """Safety of every point after the last wear step; NaN where it is never stressed."""
        logs = self._logs
        stressed = np.isfinite(logs).any(axis=(0, 1))
        found = np.full(stressed.size, np.nan)
        last = self.cycles.size - 1
        found[stressed] = np.exp(self._solved(logs[:, :, stressed], last, _MAP_HALVINGS, together=False))
        return found

    @cached_property
    def _logs(self) -> FloatArray:
        with np.errstate(divide="ignore"):
            return np.log(np.where(self.stress > 0.0, self.stress, 0.0))

    def _rates(self, logs: FloatArray, log_safety: FloatArray | float) -> FloatArray:
        """Damage of a mean cycle, (wear_step, point)."""
        damage = self.curve.damage_per_cycle(logs + log_safety)
        return np.asarray(np.tensordot(damage.transpose(0, 2, 1), self.shares, axes=1))

    def _at_static(self, stress: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Share of a wear step where stresses (2, load, point) reach static strength, and the damage of a cycle."""
        # the load that comes there first need not be the greatest before
        beyond = stress[1] > self.curve.static
        rise = np.where(beyond, stress[1] - stress[0], 1.0)
        share = np.where(beyond, (self.curve.static - stress[0]) / rise, np.inf).min(axis=0)
        there = stress[0] + share * (stress[1] - stress[0])
        with np.errstate(divide="ignore"):
            # just below: where static strength is borne for ever nothing adds up on the way
            return share, self._rates(np.log(there)[None], -_JUST)[0]

    def _damage(self, logs: FloatArray, step: int, log_safety: FloatArray | float) -> FloatArray:
        """Miner's sum of every point after a wear step."""
        rates = self._rates(logs[: step + 1], log_safety)
        length = np.diff(self.cycles[: step + 1])
        weight = 0.5 * (np.append(length, 0.0) + np.append(0.0, length))
        broken = np.isinf(rates)
        return np.where(broken.any(axis=0), np.inf, weight @ np.where(broken, 0.0, rates))

    def _solved(self, logs: FloatArray, step: int, halvings: int, *, together: bool) -> FloatArray:
        """Logarithm of the safety of every point after a wear step, or of their least."""
        greatest = logs[: step + 1].max(axis=(0, 1), initial=-np.inf)
        if together:
            greatest = greatest.max(keepdims=True)
        low = np.log(self.curve.endured) - greatest - _JUST
        high = np.log(self.curve.static) - greatest + _JUST
        for _ in range(halvings):
            middle = 0.5 * (low + high)
            damage = self._damage(logs, step, middle)
            holds = (damage.max(keepdims=True) if together else damage) <= 1.0
            low, high = np.where(holds, middle, low), np.where(holds, high, middle)
        return np.asarray(0.5 * (low + high))

    def _least(self, step: int) -> tuple[float, int]:
        """The least safety is that with which the greatest damage of all points is 1: found from a few of them."""
        logs = self._logs[: step + 1]
        greatest = logs.max(axis=(0, 1))
        order = np.argsort(greatest)[::-1]
        order = order[np.isfinite(greatest[order])]
        if order.size == 0:
            return float("nan"), -1
        chosen = order[:_MANY]
        while True:
            safety = self._solved(logs[:, :, chosen], step, _HALVINGS, together=True)
            # no other has more damage than with its greatest stress all the time
            bearable = np.log(self.curve.permissible(self.cycles[step]))
            near = order[greatest[order] + safety > bearable - _JUST]
            worse = near[self._damage(logs[:, :, near], step, safety - _JUST) > 1.0 + _JUST]
            further = np.setdiff1d(worse, chosen)
            if further.size == 0:
                damage = self._damage(logs[:, :, chosen], step, safety + 2.0 * _JUST)
                return float(np.exp(safety[0])), int(chosen[damage.argmax()])
            chosen = np.concatenate([chosen, further])


def _cycles_until(left: FloatArray, begin: FloatArray, end: FloatArray, length: FloatArray | float) -> FloatArray:
    """Cycles until what is left of a sum is full, whose rate passes linearly from begin to end of a length.

    Infinite where nothing is added.
    """
    root = np.sqrt(np.maximum(begin**2 + 2.0 * (end - begin) * left / length, 0.0))
    with np.errstate(divide="ignore"):
        return np.asarray(2.0 * left / (begin + root))


def _mean(rates: FloatArray) -> FloatArray:
    return 0.5 * (rates[1:] + rates[:-1])
