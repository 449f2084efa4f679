"""Options and files of a run, checked before anything is computed."""

from __future__ import annotations

import argparse
from pathlib import Path

import semiwear as sw
from semiwear.accuracy.run import ROUNDS, round_checkpoint
from semiwear.errors import Collected, Problem, SceneError
from semiwear.results.checkpoint import peek
from semiwear.scene import scene_files
from semiwear.targets import require_apart


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


def require_outputs(options: argparse.Namespace, scene: sw.Scene) -> None:
    """Refuse outputs that would overwrite an input or one another, and a report over hours without a speed."""
    problems: list[Problem] = []
    if options.report and options.over == "hours" and scene.operation.pinion_speed_rpm is None:
        fix = "give operation.pinion_speed_rpm"
        problems.append(Problem("--over", "hours", "a scene with a speed", fix))
    given = {"-o": options.output, "--report": options.report}
    outputs: dict[str, str | Path] = {name: path for name, path in given.items() if path is not None}
    if options.output:
        checkpoint = checkpoint_of(options.output)
        outputs["the checkpoint of -o"] = checkpoint
        outputs |= {f"checkpoint {k + 1} of -o": round_checkpoint(checkpoint, k) for k in range(1, ROUNDS)}
    inputs: dict[str, str | Path] = {name: file for name, file in scene_files(scene).items()}
    if options.scene not in sw.shipped_scenes():
        inputs["the scene"] = options.scene
    if options.against:
        inputs["--against"] = options.against
    with Collected(problems):
        require_apart(outputs, inputs)
    if problems:
        raise SceneError(problems, "command line")
