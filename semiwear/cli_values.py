"""Values on the command line: numbers of options within their ranges, and ``--set KEY=VALUE``, told all at once."""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Callable
from dataclasses import dataclass

from semiwear.errors import Problem, SceneError
from semiwear.scene.rule import Rule
from semiwear.scene.values import meant_number
from semiwear.untyped import Value


@dataclass(frozen=True)
class _Unread:
    """A value that cannot be taken, until the option is known that it was given to.

    Attributes
    ----------
    found, allowed, fix : str
        As of a `Problem`.
    """

    found: str
    allowed: str
    fix: str = ""


def number_within(rule: Rule) -> Callable[[str], Value]:
    """How an option's number is read, as `argparse` wants it."""

    def read(text: str) -> Value:
        for kind in (int, float):
            try:
                value = kind(text)
            except ValueError:
                continue
            told, problem = rule.apply("", value)
            return told if problem is None else _Unread(text, rule.allowed, problem.fix)
        meant = meant_number(text)
        return _Unread(text, rule.allowed, "give a number" if meant is None else f"did you mean {meant}?")

    return read


def assignment(text: str) -> tuple[str, Value] | _Unread:
    """`key=value`, the value as in TOML; none removes a field or table; what is no TOML value is taken as text."""
    key, separator, value = text.partition("=")
    if not separator or not key.strip():
        return _Unread(text, "KEY=VALUE", "e.g. --set operation.pinion_torque_Nm=800")
    try:
        return key.strip(), tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key.strip(), None if value.strip().casefold() == "none" else value.strip()


def require_readable(options: argparse.Namespace) -> None:
    """Refuse options with values that could not be read.

    Raises
    ------
    SceneError
        With all of them.
    """
    given = [
        (f"--{name.replace('_', '-')}", one)
        for name, value in vars(options).items()
        for one in (value if isinstance(value, list) else [value])
    ]
    problems = [Problem(name, one.found, one.allowed, one.fix) for name, one in given if isinstance(one, _Unread)]
    if problems:
        raise SceneError(problems, "command line")
