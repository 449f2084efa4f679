"""Values on the straight line through two objects that are made of numbers and arrays alike."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import TypeVar, cast

import numpy as np

__all__ = ["UnlikeError", "on_line"]

T = TypeVar("T")


class UnlikeError(ValueError):
    """Two objects differ in more than the values of their numbers: no line goes through them."""


def on_line(first: T, second: T, share: float) -> T:
    """The object at a share of the way from the first to the second, number by number.

    Parameters
    ----------
    first, second : dataclass, tuple, array or number
        Made of such; what is none of these has to be equal.
    share : float
        0 at the first, 1 at the second; any other number goes on along the line.

    Raises
    ------
    UnlikeError
        Shapes, whole numbers, texts or kinds differ.
    """
    return cast(T, _between(first, second, share))


def _between(first: object, second: object, share: float) -> object:
    if first is second:
        return first
    if type(first) is not type(second):
        raise UnlikeError(f"{type(first).__name__} and {type(second).__name__}")
    if is_dataclass(first) and not isinstance(first, type):
        named = {
            one.name: _between(getattr(first, one.name), getattr(second, one.name), share) for one in fields(first)
        }
        return type(first)(**named)
    if isinstance(first, tuple) and isinstance(second, tuple) and len(first) == len(second):
        values = [_between(one, other, share) for one, other in zip(first, second, strict=True)]
        return getattr(type(first), "_make", tuple)(values)  # a named tuple is made by a method of its own
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
