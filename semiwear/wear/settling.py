"""The fixed point of many elements at once that each change the more the more they are.

More load makes more wear and so less load: a factor on the wear coefficient that goes by the load falls where it was
too great. Changes of all elements are mixed first (Anderson 1965, J. ACM 12, 547-560, depth one), which takes a few
iterations. Where a factor goes steeply by the load, that ends in a cycle: then every element is held between a value
that was too small for it and one that was too great.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from semiwear.arrays import FloatArray

__all__ = ["Settling"]

_FREELY = 12  # changes that are mixed alone; laws that settle so hardly ever take more
_CLOSE = 1e-3  # of a value: bounds so near hold it no longer


@dataclass
class Settling:
    """An iteration x, f(x) - x -> next x for values that are not negative, by what it has seen so far."""

    _last: tuple[FloatArray, FloatArray] | None = field(default=None, init=False)
    _bounds: tuple[FloatArray, FloatArray] | None = field(default=None, init=False)
    _number: int = field(default=0, init=False)

    def after(self, value: FloatArray, change: FloatArray, least: float) -> FloatArray:
        """Next values.

        Parameters
        ----------
        value, change : array
            The last values, and by how much what they lead to differs from them.
        least : float
            Changes that count as none.
        """
        found = _mixed((value, change), self._last)
        if self._number >= _FREELY:
            low, high = self._bounds or (np.zeros_like(value), np.full_like(value, np.inf))
            low, high = self._bounds = _closer(value, change, low, high, least)
            found = np.where((found >= low) & (found <= high), found, _between(value + 0.5 * change, low, high))
        self._last = value, change
        self._number += 1
        return found


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


def _closer(
    value: FloatArray, change: FloatArray, low: FloatArray, high: FloatArray, least: float
) -> tuple[FloatArray, FloatArray]:
    """Bounds after these values: those that rise were too small, those that fall too great.

    Elements are not quite by themselves: where bounds have come together and the value goes on, one was not right.
    """
    low, high = np.where(change > 0.0, value, low), np.where(change < 0.0, value, high)
    wrong = (high - low < _CLOSE * low) & (np.abs(change) > least)
    return np.where(wrong & (change < 0.0), 0.0, low), np.where(wrong & (change > 0.0), np.inf, high)


def _between(half: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """The middle between bounds that may be orders apart; without an upper one, a half of the change."""
    bounded = np.isfinite(high)
    top = np.where(bounded, high, 0.0)
    return np.where(bounded, np.where(low > 0.0, np.sqrt(low * top), 0.5 * top), half)
