"""Values on the command line: numbers of options, ``--set KEY=VALUE``, and what cannot be parsed."""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NoReturn

from semiwear.errors import Problem, SemiwearError
from semiwear.scene.rule import Rule
from semiwear.scene.values import meant_number
from semiwear.targets import PAGES, RESULTS, file_target, target_problems
from semiwear.untyped import Value


class UsageError(SemiwearError):
    """There is no such command or option, or one is missing.

    Attributes
    ----------
    usage : str
        Usage of the command.
    """

    def __init__(self, message: str, usage: str):
        super().__init__(message)
        self.usage = usage


class Parser(argparse.ArgumentParser):
    """A parser whose errors can be caught, such as to be written as JSON."""

    def error(self, message: str) -> NoReturn:
        """Raise the error instead of ending the process."""
        raise UsageError(f"{self.prog}: {message}", self.format_usage())


def number_within(rule: Rule) -> Callable[[str], Value]:
    """Function that reads an option's number, for `argparse`; a wrong one gives its problem, without the option."""

    def read(text: str) -> Value:
        for kind in (int, float):
            try:
                value = kind(text)
            except ValueError:
                continue
            accepted, problem = rule.apply("", value)
            return accepted if problem is None else replace(problem, value=text)
        meant = meant_number(text)
        return Problem("", text, rule.allowed, "give a number" if meant is None else f"did you mean {meant}?")

    return read


def assignment(text: str) -> tuple[str, Value] | Problem:
    """Key and value of `key=value`: a TOML value, None for none (removes a field or table), else text.

    Another text gives its problem, without the option.
    """
    key, separator, value = text.partition("=")
    if not separator or not key.strip():
        return Problem("", text, "KEY=VALUE", "e.g. --set operation.pinion_torque_Nm=800")
    try:
        return key.strip(), tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key.strip(), None if value.strip().casefold() == "none" else value.strip()


def option_problems(options: argparse.Namespace) -> list[Problem]:
    """Problems of options that need no scene; those that cannot be read are None or, in lists, left out after it."""
    problems: list[Problem] = []
    for name, value in vars(options).items():
        items = value if isinstance(value, list) else [value]
        wrong = [item for item in items if isinstance(item, Problem)]
        problems += [replace(item, field=f"--{name.replace('_', '-')}") for item in wrong]
        if isinstance(value, list):
            setattr(options, name, [item for item in value if not isinstance(item, Problem)])
        elif wrong:
            setattr(options, name, None)
    if options.command == "geometry":
        problems += target_problems("-o", options.output, partial(file_target, endings=(".png", ".svg", ".pdf")))
    return problems + (_problems_of_run(options) if options.command == "run" else [])


def _problems_of_run(options: argparse.Namespace) -> list[Problem]:
    """Outputs that cannot be written, and options that have no effect without others."""
    problems = target_problems("-o", options.output, partial(file_target, endings=RESULTS))
    problems += target_problems("--report", options.report, partial(file_target, endings=PAGES))
    if options.against and not options.report:
        problems.append(Problem("--against", options.against, "a result beside --report FILE", "add --report FILE"))
    if options.resume and not options.output:
        fix = "add -o FILE: finished steps are in FILE.partial"
        problems.append(Problem("--resume", True, "a flag beside -o FILE", fix))
    return problems
