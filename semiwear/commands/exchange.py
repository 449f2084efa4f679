"""Commands that write files from or for other programs: `new`, `rexs`, `export` and `report`."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import semiwear as sw
from semiwear.errors import Collected, Problem, SceneError
from semiwear.scene.guide import EXAMPLES, new_scene
from semiwear.targets import PAGES, file_target, naming, replacing, require_apart
from semiwear.untyped import Table


def new(options: argparse.Namespace) -> Table:
    """Write a commented scene to start from; for flanks given as points also the two files that it names."""
    target = file_target("-o", options.output or f"my_{options.kind}.toml", (".toml",))
    flanks = {}
    if options.kind == "flank_points":
        flanks = {body: target.parent / f"{body}.nc" for body in ("pinion", "gear")}
    for path in (target, *flanks.values()):
        if path.exists():
            allowed = "a file that does not exist yet"
            raise SceneError.of("-o", str(path), allowed, "give another name, or remove it first")
    example = sw.load_scene(EXAMPLES["cylindrical"])
    for body, path in flanks.items():
        sw.export_flank(example, body, path)
    with naming(target):
        target.write_text(new_scene(options.kind, os.path.dirname(options.output or "")), encoding="utf-8")
    print(f"{target}: a scene to change; `semiwear check {target.name}` lists the limits of its teeth")
    for body, path in flanks.items():
        print(f"{path}: the {body}'s flank of {EXAMPLES['cylindrical']}, to be replaced by your own points")
    return {"scene": target, "flanks": flanks}


def rexs(options: argparse.Namespace) -> Table:
    """Write the scene of a gear stage in a REXS file."""
    problems: list[Problem] = []
    with Collected(problems):
        target = file_target("-o", options.output, (".toml",))
        require_apart({"-o": target}, {"FILE": options.file})
    with Collected(problems):
        stage = sw.read_rexs(
            options.file, stage=options.stage, pinion_torque_Nm=options.torque, changes=options.changes
        )
    if problems:
        raise SceneError(problems, options.file)
    with replacing(target) as part:
        part.write_text(stage.scene.to_toml(), encoding="utf-8")
    print(f"{stage}\n\nscene: {options.output}")
    taken = [{"field": name, "value": value, "from": source} for name, value, source in stage.taken]
    return {"scene": options.output, "taken": taken, "left_out": stage.left_out}


def export(options: argparse.Namespace) -> Table:
    """Write a saved result for another tool."""
    require_apart({"-o": options.output}, {"FILE": options.file})
    sw.export(
        sw.open_results(options.file), options.output, body=options.body, wear_step=options.wear_step,
        part=options.part, exaggeration=options.exaggeration, table=options.table,
        roll_position=options.roll_position, teeth=options.teeth,
    )  # fmt: skip
    print(f"export: {options.output}")
    return {"export": options.output}


def report(options: argparse.Namespace) -> Table:
    """Write the page of a saved result."""
    source = Path(options.file)
    target = options.output or (source.with_suffix(".html") if source.name else source / "report.html")
    file_target("-o", target, PAGES)
    require_apart(
        {"-o": target}, {"FILE": options.file} | ({"--against": options.against} if options.against else {})
    )
    against = sw.open_results(options.against) if options.against else None
    written = sw.report(sw.open_results(options.file), target, against, over=options.over)
    print(f"report: {written}")
    return {"report": written}
