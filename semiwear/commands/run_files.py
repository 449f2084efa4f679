"""Options and files of a run, checked before anything is computed."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import semiwear as sw
from semiwear.accuracy.run import ROUNDS, round_checkpoint
from semiwear.errors import SceneError
from semiwear.results.checkpoint import peek
from semiwear.scene import scene_files
from semiwear.targets import PAGES, RESULTS, file_target, require_apart


def checkpoint_of(output: str) -> Path:
    """Folder in which a run with this result saves its finished wear steps."""
    return Path(f"{output}.partial")


def kept_steps(output: str) -> str:
    """Sentence on the wear steps that a stopped run with this result has saved; empty if there are none."""
    path = checkpoint_of(output)
    checkpoint = peek(path)
    if checkpoint is None or not checkpoint.finished:
        return ""
    return f"; {checkpoint.finished} finished wear steps are kept in {path}, --resume continues from them"


def require_options(options: argparse.Namespace) -> None:
    """Refuse options that have no effect without others."""
    if options.against and not options.report:
        raise SceneError.of("--against", options.against, "a result beside --report FILE", "add --report FILE")
    if options.resume and not options.output:
        raise SceneError.of(
            "--resume", True, "a flag beside -o FILE", "add -o FILE: finished steps are in FILE.partial"
        )


def require_outputs(options: argparse.Namespace, scene: sw.Scene) -> None:
    """Refuse outputs that cannot be written, or would overwrite an input or one another.

    A report over hours needs a speed, too.
    """
    if options.report and options.over == "hours" and scene.operation.pinion_speed_rpm is None:
        raise SceneError.of("--over", "hours", "a scene with a speed", "give operation.pinion_speed_rpm")
    outputs: dict[str, str | Path] = {}
    for name, path, endings in (("-o", options.output, RESULTS), ("--report", options.report, PAGES)):
        if path is None:
            continue
        folder = file_target(name, path, endings).parent
        if not folder.is_dir():
            raise SceneError.of(name, path, "a file in a folder that exists", f"make the folder {folder}")
        if not os.access(folder, os.W_OK):
            raise SceneError.of(name, path, "a file in a folder that can be written", "choose another folder")
        outputs[name] = path
    if options.output:
        checkpoint = checkpoint_of(options.output)
        outputs["the checkpoint of -o"] = checkpoint
        outputs |= {f"checkpoint {k + 1} of -o": round_checkpoint(checkpoint, k) for k in range(1, ROUNDS)}
    inputs: dict[str, str | Path] = {name: file for name, file in scene_files(scene).items()}
    if options.scene not in sw.shipped_scenes():
        inputs["the scene"] = options.scene
    if options.against:
        inputs["--against"] = options.against
    require_apart(outputs, inputs)
