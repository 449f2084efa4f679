"""Command `run`: simulates a scene, saves and reports the result."""

from __future__ import annotations

import argparse
import logging
import os
import time
import uuid
from glob import escape
from pathlib import Path

import xarray as xr

import semiwear as sw
from semiwear.accuracy.run import ROUNDS, round_checkpoint
from semiwear.commands.progress_bar import ProgressBar
from semiwear.commands.run_files import checkpoint_of, kept_steps, require_outputs
from semiwear.commands.wear_table import life_sentence, wear_table
from semiwear.errors import ConvergenceError
from semiwear.results.checkpoint import peek, remove_checkpoint
from semiwear.results.deep_steps import deep_steps
from semiwear.results.pressing_tips import pressing_tips
from semiwear.untyped import Table

_LOG = logging.getLogger(__name__)

_AFTER_A_STOP = (
    "{steps} finished wear step{s} kept in {path}: --resume continues from there, {depths}at fidelity line with more "
    "numerics.max_iterations; after any other change of the scene leave --resume out, and the run starts anew"
)


def run(options: argparse.Namespace, scene: sw.Scene) -> Table:
    """Simulate a scene, save and report the result."""
    require_outputs(options, scene)
    against = sw.open_results(options.against) if options.against else None
    begin = time.perf_counter()
    checkpoint = _checkpoint(options)
    stopped = None
    with ProgressBar() as bar:
        try:
            tree = sw.simulate(scene, progress=bar, checkpoint=checkpoint, resume=options.resume)
        except ConvergenceError as error:
            if error.result is None:
                raise
            tree, stopped = error.result, error
    spent = time.perf_counter() - begin
    if options.output:  # first, so that a later failure loses nothing
        try:
            sw.save(tree, options.output)
        except OSError as error:
            raise OSError(f"{error}{kept_steps(options.output)}") from error
    try:
        _print_result(tree, spent, options, against)
    except BaseException:
        _LOG.warning("semiwear: %s", _kept_result(tree, options))
        raise
    if stopped is not None:
        if checkpoint is not None:
            _log_kept_steps(checkpoint, tree["history"].sizes["wear_step"] - 1, scene)
        raise stopped
    if checkpoint is not None:
        _remove_temporary_files(checkpoint, options.output)
    return _end_of_run(tree, options, spent)


def _end_of_run(tree: xr.DataTree, options: argparse.Namespace, spent: float) -> Table:
    """Files, seconds, and quantities of the last wear step in the units of the result, for JSON."""
    last = tree["history"].to_dataset().isel(wear_step=-1)
    history = {"meshes": last["meshes"].item()} if "meshes" in last.coords else {}
    for name, array in last.data_vars.items():
        bodies = array["body"].values if "body" in array.dims else [None]
        history |= {
            str(name) if body is None else f"{name}[{body}]": (array if body is None else array.sel(body=body)).item()
            for body in bodies
        }
    life = (
        {str(name): array.item() for name, array in tree["life"].data_vars.items()}
        if "life" in tree.children
        else None
    )
    steps = tree["history"].sizes["wear_step"] - 1
    return {"result": options.output, "report": options.report, "seconds": spent, "wear_steps": steps,
            "history": history, "life": life}  # fmt: skip


def _print_result(tree: xr.DataTree, spent: float, options: argparse.Namespace, against: xr.DataTree | None) -> None:
    """Print a result, and write its report."""
    print(wear_table(tree))
    for text in [*deep_steps(tree), *pressing_tips(tree)]:
        print(f"\n{text}")
    if "life" in tree.children:
        print(f"\n{life_sentence(tree)}")
    print(f"\n{spent:.1f} s")
    if options.output:
        print(f"result: {options.output}")
    if options.report:
        print(f"report: {sw.report(tree, options.report, against, over=options.over)}")


def _kept_result(tree: xr.DataTree, options: argparse.Namespace) -> str:
    """Sentence on the place of a result whose table or report failed; without -o it is saved beside the report."""
    if options.output:
        return f"the result is saved in {options.output}"
    if not options.report:
        return "the result is not saved: give -o FILE"
    path = Path(options.report).with_suffix(".nc")
    if path.exists():
        path = path.with_stem(f"{path.stem}_{uuid.uuid4().hex[:8]}")
    sw.save(tree, path)
    return f"the report failed; the result is saved in {path}"


def _checkpoint(options: argparse.Namespace) -> Path | None:
    """Folder in which the run saves its finished wear steps; logs a message on steps that are there already."""
    if not options.output:
        return None
    path = checkpoint_of(options.output)
    earlier = peek(path)
    if earlier is not None and earlier.finished:
        message = f"{path}: {earlier.finished} finished wear steps"
        if earlier.damaged:
            message += "; the steps after them are damaged and computed again"
        if not options.resume:
            message += " of an earlier run, from which --resume continues; this run starts anew and will replace them"
        _LOG.warning(message)
    elif options.resume and (earlier is not None or not path.exists()):
        _LOG.warning("no steps in %s: starting from the beginning", path)
    return path


def _log_kept_steps(checkpoint: Path, steps: int, scene: sw.Scene) -> None:
    """Log a message on how to continue a stopped run, if it has finished a step."""
    if not steps:
        return
    by_depth = scene.wear is not None and scene.wear.until.control_depths_um is not None
    depths = "with other wear.until.control_depths_um after those that were reached, or " if by_depth else ""
    message = _AFTER_A_STOP.format(steps=steps, s="s are" if steps > 1 else " is", path=checkpoint, depths=depths)
    _LOG.warning(message)


def _remove_temporary_files(checkpoint: Path, written: str) -> None:
    """Remove the checkpoints of a finished run, and parts of files that earlier runs have left."""
    output = Path(os.path.realpath(written))
    for part in output.parent.glob(f".{escape(output.name)}.*.part"):  # of a run that was killed while saving
        part.unlink(missing_ok=True)
    for round_ in range(ROUNDS):
        remove_checkpoint(round_checkpoint(checkpoint, round_))
