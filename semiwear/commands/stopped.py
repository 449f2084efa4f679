"""State that a stopped command leaves behind, in words."""

from __future__ import annotations

import argparse

from semiwear.commands.run_files import kept_steps
from semiwear.sweep.command import store_of
from semiwear.sweep.store import kept_scenes

__all__ = ["kept"]


def kept(options: argparse.Namespace) -> str:
    """Wear steps or scenes from which the command can go on; nothing if there are none."""
    output = getattr(options, "output", None)
    if output is None:
        return ""
    if options.command != "sweep":
        return kept_steps(output)
    count = kept_scenes(store_of(output))
    told = f"; {count} solved scenes are kept in {store_of(output)}, --resume goes on from them"
    return told if count else ""
