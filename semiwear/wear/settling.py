"""Fixed-point iteration for the factor of a wear law, which depends on the loads that it determines.

More load means more wear and so less load: a load-dependent factor on the wear coefficient decreases where it was too
great. Anderson mixing of all elements (Anderson 1965, J. ACM 12, 547-560) converges in a few iterations. Where the
factor depends steeply on the load, mixing ends in a cycle, from which Newton's method finds out unless the law has a
kink near by; every element is then kept between a value that was too small and one that was too great.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray

_MEMORY = 5  # differences that are mixed; more save no iteration
_RANK_TOLERANCE = 1e-8  # of the greatest singular value of the differences
_UNBOUNDED = 12  # iterations without bounds in which changes need not fall to a tenth
_SAME_SIGN = 2  # further changes of the same sign after which a bound was wrong
_WIDENING = 4.0  # of the distance between the bounds, by which a wrong bound is moved


@dataclass
class Settling:
    """Iteration from x and f(x) - x to the next x, for values that are not negative; keeps its history."""

    _history: list[tuple[FloatArray, FloatArray]] = field(default_factory=list, init=False)  # values, their changes
    _low: FloatArray | float = field(default=0.0, init=False)
    _high: FloatArray | float = field(default=np.inf, init=False)
    _number: int = field(default=0, init=False)  # of iterations since the changes last fell to a tenth
    _tenth: float = field(default=np.inf, init=False)  # square of a tenth of the change counted from
    _stalls: int = field(default=0, init=False)
    _same_sign: IntArray | int = field(default=0, init=False)  # earlier changes in a row of the sign of the last one

    def after(
        self, value: FloatArray, change: FloatArray, least: float, tangent: Callable[[], FloatArray] | None = None
    ) -> FloatArray:
        """Next values.

        Parameters
        ----------
        value, change : array
            The last values x, and f(x) - x.
        least : float
            Changes that count as none.
        tangent : callable, optional
            Next values by Newton's method, which are taken once mixing stalls; where they stall, too, values are
            bounded.
        """
        last = self._history[-1][1] if self._history else None
        mixed, stalls = self._mixed(value, change), self._stalls_of(float(np.vdot(change, change)))
        if stalls == 1 and tangent is not None:
            return tangent()
        if stalls == 0 or last is None:
            return mixed
        self._same_sign = np.where(change * last > 0.0, self._same_sign + 1, 0)
        goes_on = (self._same_sign >= _SAME_SIGN) & (np.abs(change) > least)
        low, high = np.where(change > 0.0, value, self._low), np.where(change < 0.0, value, self._high)
        low, high = self._low, self._high = _wider(change, low, high, goes_on, least)
        return np.where((mixed >= low) & (mixed <= high), mixed, _between(value + 0.5 * change, low, high))

    def _stalls_of(self, square: float) -> int:
        """How often changes, given by the sum of their squares, have for some iterations not fallen to a tenth."""
        ends = self._number >= _UNBOUNDED and square > self._tenth
        if ends or square <= self._tenth:
            self._number, self._tenth, self._stalls = 0, 0.01 * square, self._stalls + ends
        self._number += 1
        return self._stalls

    def _mixed(self, value: FloatArray, change: FloatArray) -> FloatArray:
        """Next values by Anderson mixing of the last few.

        In the first iteration, and where changes grow or a value would become negative, only half of the change is
        applied, which overshoots least.
        """
        history, half = self._history, value + 0.5 * change
        if history and np.vdot(change, change) > np.vdot(history[-1][1], history[-1][1]):
            history.clear()
        history.append((value, change))
        del history[: -_MEMORY - 1]
        if len(history) == 1:
            return half
        values, changes = (np.array([pair[part].ravel() for pair in history]) for part in (0, 1))
        value_steps, change_steps = np.diff(values, axis=0), np.diff(changes, axis=0)
        sizes = np.linalg.norm(change_steps, axis=1)
        if not sizes.all():
            return half
        scaled = (change_steps / sizes[:, None]).T
        shares = np.linalg.lstsq(scaled, change.ravel(), rcond=_RANK_TOLERANCE)[0] / sizes
        mixed = half - (shares @ (value_steps + 0.5 * change_steps)).reshape(value.shape)
        return np.where(mixed >= 0.0, mixed, half)


def _wider(
    change: FloatArray, low: FloatArray, high: FloatArray, goes_on: BoolArray, least: float
) -> tuple[FloatArray, FloatArray]:
    """Bounds, the one ahead moved where a value keeps changing in its direction, since elements are coupled.

    It moves by a multiple of the distance between both bounds, or of `least` where that is more.
    """
    more = np.where(goes_on, _WIDENING * np.maximum(high - low, least), 0.0)
    return np.maximum(low - np.where(change < 0.0, more, 0.0), 0.0), high + np.where(change > 0.0, more, 0.0)


def _between(half: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Geometric mean of the bounds, half of the upper one if the lower is zero, `half` without an upper bound."""
    bounded = np.isfinite(high)
    top = np.where(bounded, high, 0.0)
    return np.where(bounded, np.where(low > 0.0, np.sqrt(low * top), 0.5 * top), half)
