"""Completion of the command line by the shell: ``semiwear --print-completion bash`` (extra ``completion``)."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from semiwear.errors import MissingExtraError

_FILES = ("FILE", "scene", "study", "file", "measured")


class PrintCompletion(argparse.Action):
    """Option that prints a completion script for a shell, and ends."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[object] | None,
        option_string: str | None = None,
    ) -> None:
        """Print the script.

        Raises
        ------
        MissingExtraError
            Without shtab.
        """
        try:
            import shtab
        except ImportError as error:
            raise MissingExtraError("shtab", "completion", "completion by the shell") from error
        for action in _actions(parser):
            if (action.metavar or action.dest) in _FILES:
                action.complete = shtab.FILE  # type: ignore[attr-defined]
        print(shtab.complete(parser, shell=str(values)))
        parser.exit()


def _actions(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """All actions of a parser and of its commands."""
    found = []
    for action in parser._actions:
        found.append(action)
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                found += _actions(command)
    return found
