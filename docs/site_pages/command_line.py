"""Page of the command line, from its parsers."""

from __future__ import annotations

import argparse

from semiwear.cli import _parser

_INTRODUCTION = """\
# Command line

What `semiwear COMMAND --help` prints, from the same parsers. Errors that a user can mend go to standard error and end
with status 2; Ctrl-C ends with 130, and what was finished is kept.
"""


def command_line_page() -> str:
    """Help of the program and of every command."""
    parser = _parser()
    lines = [_INTRODUCTION, "```text", parser.format_help().rstrip(), "```", ""]
    for name, command in commands(parser).items():
        lines += [f"## semiwear {name}", "", "```text", command.format_help().rstrip(), "```", ""]
    return "\n".join(lines)


def commands(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """Parsers of the commands by name."""
    found: dict[str, argparse.ArgumentParser] = {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            found |= action.choices
    return found
