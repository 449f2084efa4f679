"""Linear interpolation between two objects of the same structure, number by number."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import TypeVar, cast

import numpy as np

T = TypeVar("T")


class UnlikeError(ValueError):
    """Two objects differ in more than the values of their numbers and cannot be interpolated."""


def on_line(first: T, second: T, share: float) -> T:
    """The object at a share of the way from the first to the second, number by number.

    Parameters
    ----------
    first, second : dataclass, tuple, array or number
        Nested in any way; attributes of other types must be equal.
    share : float
        0 at the first, 1 at the second; other numbers extrapolate.

    Raises
    ------
    UnlikeError
        Shapes, integers, texts or types differ.
    """
    return cast(T, _between(first, second, share))


def _between(first: object, second: object, share: float) -> object:
    if first is second:
        return first
    if type(first) is not type(second):
        raise UnlikeError(f"{type(first).__name__} and {type(second).__name__}")
    if is_dataclass(first) and not isinstance(first, type):
        named = {
            entry.name: _between(getattr(first, entry.name), getattr(second, entry.name), share)
            for entry in fields(first)
        }
        return type(first)(**named)
    if isinstance(first, tuple) and isinstance(second, tuple) and len(first) == len(second):
        values = [_between(a, b, share) for a, b in zip(first, second, strict=True)]
        return getattr(type(first), "_make", tuple)(values)  # named tuples need their own constructor
    if isinstance(first, float) and isinstance(second, float):
        return first + share * (second - first)
    if isinstance(first, np.ndarray) and isinstance(second, np.ndarray):
        if first.shape == second.shape and first.dtype.kind == "f":
            return np.where(first == second, first, first + share * (second - first))
        if np.array_equal(first, second):
            return first
    elif first == second:
        return first
    raise UnlikeError(f"{first!s:.50} and {second!s:.50}")
