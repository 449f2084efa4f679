"""Conversion of values from a TOML file or a caller to those stored in a scene, or the reason why not."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from numbers import Real
from typing import TypeGuard

from semiwear.untyped import Value

Reader = Callable[[object], Value]
"""Converts a raw value or raises `Unreadable`."""

_LONGEST_SHOWN = 200


class Unreadable(Exception):
    """A value of the wrong type; the message is the fix to suggest."""


def shown(raw: object) -> object:
    """The value itself if it can be printed in an error message, else a short text about it."""
    try:
        printed = repr(raw)
    except (ValueError, RecursionError):  # integers of thousands of digits, bottomless nesting
        return f"an unprintable {type(raw).__name__}"
    return raw if len(printed) <= _LONGEST_SHOWN else printed[: _LONGEST_SHOWN - 3] + "..."


def is_number(value: object) -> bool:
    """Whether a value is a number; true and false are not."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def is_whole(value: object) -> TypeGuard[int]:
    """Whether a value is a whole number; true and false are not."""
    return isinstance(value, int) and not isinstance(value, bool)


def number(raw: object) -> float:
    """A finite real number."""
    if isinstance(raw, bool):
        raise Unreadable("give a number, not true or false")
    if isinstance(raw, str):
        raise Unreadable(_number_in_text(raw))
    if not isinstance(raw, Real):
        raise Unreadable(f"give one number, not {_kind(raw)}")
    try:
        value = float(raw)
    except OverflowError:
        value = math.inf
    if not math.isfinite(value):
        raise Unreadable("give a finite number")
    return value + 0.0  # turns -0.0 into 0.0, so that equal scenes give equal text


_NUMBER_AND_UNIT = re.compile(r"\s*([-+]?\d*[.,]?\d+(?:[eE][-+]?\d+)?)\s*([^\d\s.,].{0,20})?\s*", re.ASCII)


def meant_number(raw: str) -> str | None:
    """The number in a text, with a decimal point and without its unit; None if there is none."""
    found = _NUMBER_AND_UNIT.fullmatch(raw[:_LONGEST_SHOWN])
    return None if found is None else found[1].replace(",", ".")


def _number_in_text(raw: str) -> str:
    """Advice for a text given instead of a number."""
    if not raw.strip():
        return "it is empty: give a number"
    found = _NUMBER_AND_UNIT.fullmatch(raw[:_LONGEST_SHOWN])
    if found is None:
        return "give a number, without quotes"
    digits, unit = found[1], found[2]
    if "," in digits:
        return f"give a number with a decimal point: {digits.replace(',', '.')}, without quotes"
    if unit:
        return f"give {digits}, without the unit {unit.strip()!r}: the unit is in the field's name"
    return f"give {digits}, without quotes"


def whole(raw: object) -> int:
    """A whole number; 25.0 counts as 25."""
    value = number(raw)
    if not value.is_integer():
        raise Unreadable(f"give a whole number, e.g. {round(value)}")
    return int(value)


def text(raw: object) -> str:
    """Text that a UTF-8 file can hold."""
    if not isinstance(raw, str):
        raise Unreadable(f"give text in quotes, not {_kind(raw)}")
    try:
        raw.encode()
    except UnicodeEncodeError:
        raise Unreadable("remove the characters that UTF-8 cannot hold") from None
    return str(raw)


def numbers(raw: object) -> tuple[float, ...]:
    """A list of finite numbers."""
    return tuple(number(item) for item in _items(raw, "numbers, e.g. [5, 10, 15]"))


def texts(raw: object) -> tuple[str, ...]:
    """A list of texts."""
    return tuple(text(item) for item in _items(raw, 'texts, e.g. ["gear"]'))


def _items(raw: object, example: str) -> list[object] | tuple[object, ...]:
    if hasattr(raw, "tolist"):  # an array, as passed to `Scene.replace` by sweeps
        raw = raw.tolist()
    if not isinstance(raw, list | tuple):
        raise Unreadable(f"give a list of {example}")
    return raw


def _kind(raw: object) -> str:
    if isinstance(raw, dict):
        return "a table"
    if isinstance(raw, list | tuple):
        return "a list"
    return f"a {type(raw).__name__}"
