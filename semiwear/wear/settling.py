"""The fixed point of many elements at once that each change the more the more they are.

More load makes more wear and so less load: a factor on the wear coefficient that goes by the load falls where it was
too great. Changes of all elements are mixed first (Anderson 1965, J. ACM 12, 547-560, depth one), which takes a few
iterations. Where a factor goes steeply by the load, that ends in a cycle: then every element is held between a value
that was too small for it and one that was too great.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Settling"]

_FREELY = 12  # changes that are mixed alone; laws that settle so hardly ever take more
_ALIKE = 2  # changes more of one sign, one after another: the bound ahead was not right
_WIDER = 4.0  # times as far as it is from the other one that bound moves on


@dataclass
class Settling:
    """An iteration x, f(x) - x -> next x for values that are not negative, by what it has seen so far."""

    _last: tuple[FloatArray, FloatArray] | None = field(default=None, init=False)
    _low: FloatArray | float = field(default=0.0, init=False)
    _high: FloatArray | float = field(default=np.inf, init=False)
    _number: int = field(default=0, init=False)
    _alike: IntArray | int = field(default=0, init=False)  # changes of the sign of the last one, but for it

    def after(self, value: FloatArray, change: FloatArray, least: float) -> FloatArray:
        """Next values.

        Parameters
        ----------
        value, change : array
            The last values, and by how much what they lead to differs from them.
        least : float
            Changes that count as none.
        """
        found, last = _mixed((value, change), self._last), self._last
        self._last = value, change
        self._number += 1
        if self._number <= _FREELY or last is None:
            return found
        self._alike = np.where(change * last[1] > 0.0, self._alike + 1, 0)
        goes_on = (self._alike >= _ALIKE) & (np.abs(change) > least)
        low, high = np.where(change > 0.0, value, self._low), np.where(change < 0.0, value, self._high)
        low, high = self._low, self._high = _wider(change, low, high, goes_on, least)
        return np.where((found >= low) & (found <= high), found, _between(value + 0.5 * change, low, high))


def _mixed(now: tuple[FloatArray, FloatArray], before: tuple[FloatArray, FloatArray] | None) -> FloatArray:
    """Next values from the last two and their changes.

    At first, and where changes grow or a value would fall below zero, a half of the change alone, which overshoots
    least.
    """
    value, change = now
    half = value + 0.5 * change
    if before is None:
        return half
    last, last_change = before
    bend = change - last_change
    square, size = float(np.vdot(bend, bend)), float(np.vdot(change, change))
    if not square > 0.0 or size > float(np.vdot(last_change, last_change)):
        return half
    share = min(max(float(np.vdot(change, bend)) / square, -1.0), 1.0)
    mixed = half - share * (value - last + 0.5 * bend)
    return np.where(mixed >= 0.0, mixed, half)


def _wider(
    change: FloatArray, low: FloatArray, high: FloatArray, goes_on: BoolArray, least: float
) -> tuple[FloatArray, FloatArray]:
    """Bounds of which the one ahead has moved on where a value goes on: elements are not quite by themselves.

    By some times the distance between both, and of `least` at least.
    """
    more = np.where(goes_on, _WIDER * np.maximum(high - low, least), 0.0)
    return np.maximum(low - np.where(change < 0.0, more, 0.0), 0.0), high + np.where(change > 0.0, more, 0.0)


def _between(half: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """The middle between bounds that may be orders apart; without an upper one, a half of the change."""
    bounded = np.isfinite(high)
    top = np.where(bounded, high, 0.0)
    return np.where(bounded, np.where(low > 0.0, np.sqrt(low * top), 0.5 * top), half)
