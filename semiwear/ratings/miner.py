"""Miner's sum over wear steps and a load spectrum, and the safety that follows from it (ISO 6336-6).

The safety after some wear steps is the factor on all stresses so far at which the damage sum would be 1. The damage
of a cycle changes linearly over a wear step.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.ratings.life_curve import LifeCurve

_HALVINGS = 40  # bisections of a bracket that spans a factor of about 3, for the least safety
_MAP_HALVINGS = 14  # bisections to 1e-4, for the safeties of all points
_FIRST_POINTS = 64  # with the greatest stresses, rated first
_TINY = 1e-9  # relative margin


@dataclass(frozen=True, eq=False)
class StressHistory:
    """Stresses at many points over the wear steps.

    Attributes
    ----------
    cycles : (wear_step,) array
        Load cycles up to each wear step, from 0.
    shares : (load,) array
        Shares of the cycles under each load.
    stress : (wear_step, load, point) array [MPa]
        NaN or 0 where there is none.
    curve : LifeCurve
    """

    cycles: FloatArray
    shares: FloatArray
    stress: FloatArray
    curve: LifeCurve

    def damages(self, safety: float) -> FloatArray:
        """Greatest Miner's sum of all points after every wear step, with stresses times a safety."""
        logs, log_safety = self._logs, float(np.log(safety))
        return np.array([self._damage(logs, step, log_safety).max(initial=0.0) for step in range(self.cycles.size)])

    def life(self, safety: float) -> float:
        """Load cycles until Miner's sum of some point is 1 with stresses times a safety; NaN if it stays below.

        The life also ends where the stress, linear within the wear step, reaches static strength.
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
            by_sum = _cycles_until(1.0 - sums[k, first], safe[k, first], rate, np.maximum(static, _TINY))
            ends += (self.cycles[k] + np.concatenate([until, np.minimum(by_sum, static)])).tolist()
        return float(np.fmin.reduce(ends))

    def least_safeties(self) -> tuple[FloatArray, IntArray]:
        """Least safety of all points after every wear step, and the index of its point; NaN and -1 if none."""
        found = [self._least(step) for step in range(self.cycles.size)]
        return np.array([safety for safety, _ in found]), np.array([point for _, point in found])

    def safeties(self) -> FloatArray:
        """Safety of every point after the last wear step; NaN for unstressed points."""
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
        """Mean damage of a cycle over the spectrum, (wear_step, point)."""
        damage = self.curve.damage_per_cycle(logs + log_safety)
        return np.asarray(np.tensordot(damage.transpose(0, 2, 1), self.shares, axes=1))

    def _at_static(self, stress: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Fraction of a wear step at which stresses (2, load, point) reach static strength, and the damage there."""
        # the load that reaches it first need not be the greatest at the start of the step
        beyond = stress[1] > self.curve.static
        rise = np.where(beyond, stress[1] - stress[0], 1.0)
        share = np.where(beyond, (self.curve.static - stress[0]) / rise, np.inf).min(axis=0)
        reached = stress[0] + share * (stress[1] - stress[0])
        with np.errstate(divide="ignore"):
            # just below static strength, so that the damage is finite; it is 0 where the curve is horizontal
            return share, self._rates(np.log(reached)[None], -_TINY)[0]

    def _damage(self, logs: FloatArray, step: int, log_safety: FloatArray | float) -> FloatArray:
        """Miner's sum of every point after a wear step."""
        rates = self._rates(logs[: step + 1], log_safety)
        length = np.diff(self.cycles[: step + 1])
        weight = 0.5 * (np.append(length, 0.0) + np.append(0.0, length))
        broken = np.isinf(rates)
        return np.where(broken.any(axis=0), np.inf, weight @ np.where(broken, 0.0, rates))

    def _solved(self, logs: FloatArray, step: int, halvings: int, *, together: bool) -> FloatArray:
        """Logarithm of the safety of every point after a wear step; `together`: of the least of them."""
        greatest = logs[: step + 1].max(axis=(0, 1), initial=-np.inf)
        if together:
            greatest = greatest.max(keepdims=True)
        low = np.log(self.curve.endured) - greatest - _TINY
        high = np.log(self.curve.static) - greatest + _TINY
        for _ in range(halvings):
            middle = 0.5 * (low + high)
            damage = self._damage(logs, step, middle)
            safe = (damage.max(keepdims=True) if together else damage) <= 1.0
            low, high = np.where(safe, middle, low), np.where(safe, high, middle)
        return np.asarray(0.5 * (low + high))

    def _least(self, step: int) -> tuple[float, int]:
        """Least safety after a wear step and its point: the greatest damage is 1. Few points need to be rated."""
        logs = self._logs[: step + 1]
        greatest = logs.max(axis=(0, 1))
        order = np.argsort(greatest)[::-1]
        order = order[np.isfinite(greatest[order])]
        if order.size == 0:
            return float("nan"), -1
        chosen = order[:_FIRST_POINTS]
        while True:
            safety = self._solved(logs[:, :, chosen], step, _HALVINGS, together=True)
            # upper bound of a point's damage: its greatest stress in all cycles
            permissible = np.log(self.curve.permissible(self.cycles[step]))
            possible = order[greatest[order] + safety > permissible - _TINY]
            worse = possible[self._damage(logs[:, :, possible], step, safety - _TINY) > 1.0 + _TINY]
            further = np.setdiff1d(worse, chosen)
            if further.size == 0:
                damage = self._damage(logs[:, :, chosen], step, safety + 2.0 * _TINY)
                return float(np.exp(safety[0])), int(chosen[damage.argmax()])
            chosen = np.concatenate([chosen, further])


def _cycles_until(left: FloatArray, begin: FloatArray, end: FloatArray, length: FloatArray | float) -> FloatArray:
    """Cycles until damage `left` has accumulated at a rate that is linear from `begin` to `end` over a length.

    Infinite at a rate of zero.
    """
    root = np.sqrt(np.maximum(begin**2 + 2.0 * (end - begin) * left / length, 0.0))
    with np.errstate(divide="ignore"):
        return np.asarray(2.0 * left / (begin + root))


def _mean(rates: FloatArray) -> FloatArray:
    return 0.5 * (rates[1:] + rates[:-1])
