"""Sentences on the results that a stopped command has saved."""

from __future__ import annotations

import argparse
import os

from semiwear.commands.run_files import kept_steps
from semiwear.sweep.command import store_of
from semiwear.sweep.store import kept_scenes


def kept(options: argparse.Namespace) -> str:
    """Sentence on the wear steps or scenes from which the command can continue; empty if there are none."""
    output = getattr(options, "output", None)
    if output is None:
        return ""
    if options.command == "infer":
        return _kept_scenes(options.store, "the same command continues from them")
    if options.command == "sweep":
        return _kept_scenes(store_of(output), "--resume continues from them")
    return kept_steps(output)


def _kept_scenes(store: str | os.PathLike[str] | None, advice: str) -> str:
    count = kept_scenes(store) if store else 0
    return f"; {count} solved scenes are kept in {store}, {advice}" if count else ""
