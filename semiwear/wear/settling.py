"""The fixed point of many elements at once that each change the more the more they are.

More load makes more wear and so less load: a factor on the wear coefficient that goes by the load falls where it was
too great. Changes of all elements are mixed (Anderson 1965, J. ACM 12, 547-560), which takes a few iterations. Where
a factor goes steeply by the load, that ends in a cycle: then every element is held between a value that was too small
for it and one that was too great.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Settling"]

_MEMORY = 5  # differences that are mixed; more save no iteration
_ALIKE_AS = 1e-8  # of the greatest of them that are independent: what is left of others says nothing
_FREELY = 12  # changes that are mixed alone while they do not fall to a tenth
_ALIKE = 2  # changes more of one sign, one after another: the bound ahead was not right
_WIDER = 4.0  # times as far as it is from the other one that bound moves on


@dataclass
class Settling:
    """An iteration x, f(x) - x -> next x for values that are not negative, by what it has seen so far."""

    _seen: list[tuple[FloatArray, FloatArray]] = field(default_factory=list, init=False)  # values, their changes
    _low: FloatArray | float = field(default=0.0, init=False)
    _high: FloatArray | float = field(default=np.inf, init=False)
    _number: int = field(default=0, init=False)  # of changes since they last fell to a tenth
    _tenth: float = field(default=np.inf, init=False)  # of the change that they are counted from, squared
    _bounded: bool = field(default=False, init=False)
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
        last = self._seen[-1][1] if self._seen else None
        found = self._mixed(value, change)
        if not self._is_bounded(float(np.vdot(change, change))) or last is None:
            return found
        self._alike = np.where(change * last > 0.0, self._alike + 1, 0)
        goes_on = (self._alike >= _ALIKE) & (np.abs(change) > least)
        low, high = np.where(change > 0.0, value, self._low), np.where(change < 0.0, value, self._high)
        low, high = self._low, self._high = _wider(change, low, high, goes_on, least)
        return np.where((found >= low) & (found <= high), found, _between(value + 0.5 * change, low, high))

    def _is_bounded(self, square: float) -> bool:
        """True from where changes, told by the sum of their squares, have not fallen to a tenth for long."""
        if square <= self._tenth:
            self._number, self._tenth = 0, 0.01 * square
        self._number += 1
        self._bounded = self._bounded or self._number > _FREELY
        return self._bounded

    def _mixed(self, value: FloatArray, change: FloatArray) -> FloatArray:
        """Next values from the last few and their changes.

        At first, and where changes grow or a value would fall below zero, a half of the change alone, which
        overshoots least.
        """
        seen, half = self._seen, value + 0.5 * change
        if seen and np.vdot(change, change) > np.vdot(seen[-1][1], seen[-1][1]):
            seen.clear()
        seen.append((value, change))
        del seen[: -_MEMORY - 1]
        if len(seen) == 1:
            return half
        values, changes = (np.array([pair[part].ravel() for pair in seen]) for part in (0, 1))
        moved, bends = np.diff(values, axis=0), np.diff(changes, axis=0)
        sizes = np.linalg.norm(bends, axis=1)
        if not sizes.all():
            return half
        shares = np.linalg.lstsq((bends / sizes[:, None]).T, change.ravel(), rcond=_ALIKE_AS)[0] / sizes
        mixed = half - (shares @ (moved + 0.5 * bends)).reshape(value.shape)
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
