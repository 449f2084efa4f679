"""Rules for the allowed values of a field, and rules common to many fields."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import degrees

from semiwear.errors import Problem
from semiwear.plain_text import one_of
from semiwear.scene.closest import advised_name
from semiwear.scene.values import Reader, Unreadable, number, shown, text, whole
from semiwear.untyped import Value


@dataclass(frozen=True)
class Rule:
    """The allowed values of one field.

    Attributes
    ----------
    read : callable
        Converts the raw value to the stored one; raises `Unreadable` for a wrong type.
    allowed : str
        The allowed range in words.
    holds : callable
        Whether a converted value is in that range.
    fix : str or callable
        Probable correction of a value out of range, as text or as a function of the value.
    names_file : callable
        Whether a value in range is the path of an input file.
    """

    read: Reader
    allowed: str
    holds: Callable[[Value], bool]
    fix: str | Callable[[Value], str]
    names_file: Callable[[Value], bool] = lambda value: False

    def apply(self, key: str, raw: object) -> tuple[Value, Problem | None]:
        """The stored value, None if there is a problem, and the problem, None if there is none."""
        try:
            value = self.read(raw)
        except Unreadable as reason:
            return None, Problem(key, shown(raw), self.allowed, str(reason))
        if self.holds(value):
            return value, None
        fix = self.fix if isinstance(self.fix, str) else self.fix(value)
        return None, Problem(key, shown(raw), self.allowed, fix)


def positive(fix: str, unit: str = "mm") -> Rule:
    """A number above 0."""
    return Rule(number, f"greater than 0 {unit}".rstrip(), lambda value: value > 0.0, fix)


def at_least_zero(fix: str, unit: str = "mm") -> Rule:
    """A number that is not negative."""
    return Rule(number, f"0 {unit} or more", lambda value: value >= 0.0, fix)


def between(read: Reader, low: float, high: float, fix: str, unit: str = "") -> Rule:
    """A number in a closed range."""
    allowed = f"{'whole number, ' if read is whole else ''}{low:g} to {high:g} {unit}".rstrip()
    return Rule(read, allowed, lambda value: low <= value <= high, fix)


def above(limit: float, high: float, fix: str, unit: str = "") -> Rule:
    """A number greater than one limit, up to another."""
    allowed = f"above {limit:g}, up to {high:g} {unit}".rstrip()
    return Rule(number, allowed, lambda value: limit < value <= high, fix)


def angle(low: float, high: float, fix: str) -> Rule:
    """An angle in a closed range of degrees; the fix recognises a value in radians."""

    def unit_fix(value: float) -> str:
        meant = degrees(value)
        return f"in degrees: this looks like radians, give {meant:.3g}" if value < low <= meant <= high else fix

    return Rule(number, f"{low:g} to {high:g} degrees", lambda value: low <= value <= high, unit_fix)


def any_number(fix: str) -> Rule:
    """A length of any sign and size."""
    return Rule(number, "a number of mm", lambda value: True, fix)


def or_auto(rule: Rule, allowed: str) -> Rule:
    """The word ``auto``, or a number that another rule allows."""

    def read(raw: object) -> Value:
        if not isinstance(raw, str):
            return rule.read(raw)
        if raw != "auto":
            kind = "whole number" if rule.read is whole else "number"
            raise Unreadable(f'give "auto", or a {kind} without quotes')
        return raw

    return Rule(read, allowed, lambda value: value == "auto" or rule.holds(value), rule.fix)


def choice(*options: str, otherwise: str = "") -> Rule:
    """One of a few words."""
    allowed = one_of(options)

    def fix(value: str) -> str:
        return advised_name(value, options, otherwise or f'give "{options[0]}"', quoted=True)

    return Rule(text, allowed, lambda value: value in options, fix)


def grid_file(allowed: str, fix: str) -> Rule:
    """The path of a CSV or netCDF file, which is an input of the scene."""

    def is_grid(path: str) -> bool:
        return path.casefold().endswith((".csv", ".nc"))

    return Rule(text, allowed, is_grid, fix, is_grid)


def anything() -> Rule:
    """Any text."""
    return Rule(text, "text", lambda value: True, "")
