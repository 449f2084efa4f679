"""Values on the command line: numbers of options, and ``--set KEY=VALUE``; all errors are reported at once."""

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
    """A wrong value, kept until the name of its option is known.

    Attributes
    ----------
    found, allowed, fix : str
        As in a `Problem`.
    """

    found: str
    allowed: str
    fix: str = ""


def number_within(rule: Rule) -> Callable[[str], Value]:
    """Function that reads an option's number, for `argparse`."""

    def read(text: str) -> Value:
        for kind in (int, float):
            try:
                value = kind(text)
            except ValueError:
                continue
            accepted, problem = rule.apply("", value)
            return accepted if problem is None else _Unread(text, rule.allowed, problem.fix)
        meant = meant_number(text)
        return _Unread(text, rule.allowed, "give a number" if meant is None else f"did you mean {meant}?")

    return read


def assignment(text: str) -> tuple[str, Value] | _Unread:
    """Key and value of `key=value`: a TOML value, None for none (removes a field or table), else text."""
    key, separator, value = text.partition("=")
    if not separator or not key.strip():
        return _Unread(text, "KEY=VALUE", "e.g. --set operation.pinion_torque_Nm=800")
    try:
        return key.strip(), tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key.strip(), None if value.strip().casefold() == "none" else value.strip()


def require_readable(options: argparse.Namespace) -> None:
    """Refuse options with wrong values.

    Raises
    ------
    SceneError
        With all of them.
    """
    given = [
        (f"--{name.replace('_', '-')}", item)
        for name, value in vars(options).items()
        for item in (value if isinstance(value, list) else [value])
    ]
    unread = [(name, item) for name, item in given if isinstance(item, _Unread)]
    problems = [Problem(name, item.found, item.allowed, item.fix) for name, item in unread]
    if problems:
        raise SceneError(problems, "command line")
