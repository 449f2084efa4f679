"""Commands of the command line as functions of its options; each prints its end and gives it to machines."""

from __future__ import annotations

import argparse
import logging
import os
import time
import uuid
from glob import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.accuracy.run import ROUNDS, round_checkpoint
from semiwear.errors import ConvergenceError, SceneError
from semiwear.inference.command import run_inference
from semiwear.optimise.command import run_optimise
from semiwear.plot.geometry import geometry_figure
from semiwear.results.checkpoint import peek, remove_checkpoint
from semiwear.results.life_axis import hours_of
from semiwear.results.missing import missing_notes
from semiwear.results.pressing_tips import pressing_tips
from semiwear.results.wearing import control_place, main_body, worn_bodies
from semiwear.scatter.command import SCATTER, prepare_study
from semiwear.scene import scene_files
from semiwear.scene.guide import EXAMPLES, new_scene
from semiwear.sweep.command import run_study, store_of
from semiwear.sweep.store import kept_scenes
from semiwear.targets import PAGES, RESULTS, file_target, naming, replacing, require_apart
from semiwear.untyped import Table

if TYPE_CHECKING:
    from tqdm import tqdm

__all__ = [
    "calibrate",
    "export",
    "geometry",
    "infer",
    "kept",
    "new",
    "optimise",
    "report",
    "rexs",
    "run",
    "screen",
    "sweep",
]

_LOG = logging.getLogger(__name__)

_COLUMNS = (
    ("meshes", "meshes", "{:.3e}"),
    ("control {} [um]", "wear_depth_control_point", "{:.1f}"),
    ("load share", "load_share_max", "{:.3f}"),
    ("p root [MPa]", "contact_pressure_root", "{:.0f}"),
    ("p pitch [MPa]", "contact_pressure_pitch", "{:.0f}"),
    ("root stress p/g [MPa]", "root_stress_max", "{:.1f}"),
    ("TE mean [arcsec]", "transmission_error_mean", "{:.2f}"),
    ("TE ampl. [arcsec]", "transmission_error_amplitude", "{:.2f}"),
)

_AFTER_A_STOP = (
    "{steps} finished wear step{s} kept in {path}: --resume goes on from there, {depths}at fidelity line with more "
    "numerics.max_iterations; any other change of the scene starts from the beginning"
)


def kept(options: argparse.Namespace) -> str:
    """State that a stopped run leaves behind, if any."""
    if options.command == "sweep":
        count = kept_scenes(store_of(options.output))
        told = f"; {count} solved scenes are kept in {store_of(options.output)}, --resume goes on from them"
        return told if count else ""
    path = Path(f"{getattr(options, 'output', None)}.partial")
    found = peek(path)
    if found is None or not found.finished:
        return ""
    return f"; {found.finished} finished wear steps are kept in {path}, --resume goes on from them"


def run(options: argparse.Namespace, scene: sw.Scene) -> Table:
    """Simulate a scene, save and report the result."""
    _require_options(options)
    _require_outputs(options, scene)
    against = sw.open_results(options.against) if options.against else None
    begin = time.perf_counter()
    checkpoint = _checkpoint(options)
    stopped = None
    with _Bar() as bar:
        try:
            tree = sw.simulate(scene, progress=bar, checkpoint=checkpoint, resume=options.resume)
        except ConvergenceError as error:
            if error.result is None:
                raise
            tree, stopped = error.result, error
    spent = time.perf_counter() - begin
    if options.output:  # before anything else can fail
        try:
            sw.save(tree, options.output)
        except OSError as error:
            raise OSError(f"{error}{kept(options)}") from error
    try:
        _tell(tree, spent, options, against)
    except BaseException:
        _LOG.warning("semiwear: %s", _kept_result(tree, options))
        raise
    if stopped is not None:
        if checkpoint is not None:
            _tell_what_is_kept(checkpoint, tree["history"].sizes["wear_step"] - 1, scene)
        raise stopped
    if checkpoint is not None:
        _clear_away(checkpoint, options.output)
    return _end_of_run(tree, options, spent)


def _end_of_run(tree: xr.DataTree, options: argparse.Namespace, spent: float) -> Table:
    """Files, seconds, and the last wear step's quantities in the units of the result."""
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


def _tell_what_is_kept(checkpoint: Path, steps: int, scene: sw.Scene) -> None:
    """Say how a stopped run can go on, where it has come so far."""
    if not steps:
        return
    by_depth = scene.wear is not None and scene.wear.until.control_depths_um is not None
    depths = "with other wear.until.control_depths_um after those that were reached, or " if by_depth else ""
    told = _AFTER_A_STOP.format(steps=steps, s="s are" if steps > 1 else " is", path=checkpoint, depths=depths)
    _LOG.warning(told)


def _require_options(options: argparse.Namespace) -> None:
    """Refuse options that mean nothing without others."""
    if options.against and not options.report:
        raise SceneError.of("--against", options.against, "a result beside --report FILE", "add --report FILE")
    if options.resume and not options.output:
        raise SceneError.of(
            "--resume", True, "a flag beside -o FILE", "add -o FILE: finished steps lie in FILE.partial"
        )


def _tell(tree: xr.DataTree, spent: float, options: argparse.Namespace, against: xr.DataTree | None) -> None:
    """Print a result, and write its report."""
    print(_table(tree))
    for text in pressing_tips(tree):
        print(f"\n{text}")
    if "life" in tree.children:
        print(f"\n{_life(tree)}")
    print(f"\n{spent:.1f} s (a first run after an installation compiles for a while)")
    if options.output:
        print(f"result: {options.output}")
    if options.report:
        print(f"report: {sw.report(tree, options.report, against, over=options.over)}")


def _clear_away(checkpoint: Path, written: str) -> None:
    """Remove what a finished run no longer needs."""
    output = Path(os.path.realpath(written))
    for left in output.parent.glob(f".{escape(output.name)}.*.part"):  # by a run that was killed as it saved
        left.unlink(missing_ok=True)
    for round_ in range(ROUNDS):
        remove_checkpoint(round_checkpoint(checkpoint, round_))


def _require_outputs(options: argparse.Namespace, scene: sw.Scene) -> None:
    """Refuse outputs that cannot be written, or would take the place of what is read or of one another."""
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
        checkpoint = Path(f"{options.output}.partial")
        outputs["the checkpoint of -o"] = checkpoint
        outputs |= {f"checkpoint {k + 1} of -o": round_checkpoint(checkpoint, k) for k in range(1, ROUNDS)}
    inputs: dict[str, str | Path] = {name: file for name, file in scene_files(scene).items()}
    if options.scene not in sw.shipped_scenes():
        inputs["the scene"] = options.scene
    if options.against:
        inputs["--against"] = options.against
    require_apart(outputs, inputs)


def _kept_result(tree: xr.DataTree, options: argparse.Namespace) -> str:
    """Where the result of a run is whose table or report failed; without -o it is saved beside the report."""
    if options.output:
        return f"the result is saved in {options.output}"
    if not options.report:
        return "the result was not to be saved: give -o FILE"
    path = Path(options.report).with_suffix(".nc")
    if path.exists():
        path = path.with_stem(f"{path.stem}_{uuid.uuid4().hex[:8]}")
    sw.save(tree, path)
    return f"the report failed; the result is saved in {path}"


def _checkpoint(options: argparse.Namespace) -> Path | None:
    """Where the run keeps its finished wear steps; says what lies there already."""
    if not options.output:
        return None
    path = Path(f"{options.output}.partial")
    found = peek(path)
    if found is not None and found.finished:
        told = f"{path}: {found.finished} finished wear steps"
        if found.damaged:
            told += "; what follows them is damaged and computed again"
        if not options.resume:
            told += " of an earlier run, for --resume to go on from; this run starts anew and will replace them"
        _LOG.warning(told)
    elif options.resume and (found is not None or not path.exists()):
        _LOG.warning("no steps in %s: starting from the beginning", path)
    return path


def screen(options: argparse.Namespace, scene: sw.Scene) -> Table:
    """Print which effects a scene calls for."""
    with _Bar("computing one mesh cycle of the scene as it is ...", "effect", "screening") as bar:
        screening = sw.screen(scene, options.threshold, progress=bar)
    print(screening)
    rows = [
        {
            "effect": row.effect,
            "present": row.present,
            "changes": dict(row.changes),
            "time": row.time,
            "note": row.note,
        }
        for row in screening.rows
    ]
    base = dict(screening.base)
    return {"called_for": screening.called_for, "could_go": screening.could_go, "base": base, "effects": rows}


def sweep(options: argparse.Namespace) -> Table:
    """Solve the scenes of a study file."""
    begin = time.perf_counter()
    with _Bar("reading the study ...", "scene", "sweep") as bar:
        told = run_study(
            options.study, options.output, workers=options.workers, scheduler=options.scheduler,
            resume=options.resume, report=options.report, progress=bar, further=SCATTER, prepare=prepare_study,
        )  # fmt: skip
    spent = time.perf_counter() - begin
    print(told)
    print(f"\n{spent:.1f} s")
    return {"dataset": options.output, "report": options.report, "seconds": spent}


def new(options: argparse.Namespace) -> Table:
    """Write a commented scene to start from; beside flanks as points, the two files that it names."""
    target = file_target("-o", options.output or f"my_{options.kind}.toml", (".toml",))
    flanks = {}
    if options.kind == "flank_points":
        flanks = {body: target.parent / f"{body}.nc" for body in ("pinion", "gear")}
    for path in (target, *flanks.values()):
        if path.exists():
            allowed = "a file that is not there yet"
            raise SceneError.of("-o", str(path), allowed, "give another name, or remove it first")
    example = sw.load_scene(EXAMPLES["cylindrical"])
    for body, path in flanks.items():
        sw.export_flank(example, body, path)
    with naming(target):
        target.write_text(new_scene(options.kind, os.path.dirname(options.output or "")), encoding="utf-8")
    print(f"{target}: a scene to change; `semiwear check {target.name}` tells the limits of its teeth")
    for body, path in flanks.items():
        print(f"{path}: the {body}'s flank of {EXAMPLES['cylindrical']}, to be replaced by your own points")
    return {"scene": target, "flanks": flanks}


def geometry(options: argparse.Namespace, scene: sw.Scene) -> Table:
    """Draw a scene's teeth and the path of contact."""
    target = file_target("-o", options.output, (".png", ".svg", ".pdf"))
    figure = geometry_figure(scene)
    with replacing(target) as temporary:
        figure.savefig(temporary, format=target.suffix[1:], dpi=150)
    print(f"teeth: {options.output}")
    return {"teeth": options.output}


def optimise(options: argparse.Namespace) -> Table:
    """Find the best design of a study file."""
    begin = time.perf_counter()
    with _Bar("reading the study ...", "design", "search") as bar:
        told = run_optimise(
            options.study, options.output, workers=options.workers, designs=options.designs,
            report=options.report, progress=bar,
        )  # fmt: skip
    spent = time.perf_counter() - begin
    print(told)
    print(f"\n{spent:.1f} s")
    return {"best": options.output, "designs": options.designs, "report": options.report, "seconds": spent}


def infer(options: argparse.Namespace) -> Table:
    """Infer the unknown fields of a study file."""
    begin = time.perf_counter()
    with _Bar("reading the study ...", "step", "inference") as bar:
        told = run_inference(
            options.study, options.output, workers=options.workers, store=options.store, report=options.report,
            progress=bar,
        )  # fmt: skip
    spent = time.perf_counter() - begin
    print(told)
    print(f"\n{spent:.1f} s")
    return {"output": options.output, "report": options.report, "seconds": spent}


def calibrate(options: argparse.Namespace, scene: sw.Scene) -> Table:
    """Print the wear coefficient that measured flanks tell."""
    with _Bar(unit="step") as bar:
        found = sw.calibrate(
            scene, options.measured, before=options.before, body=options.body, meshes=options.meshes,
            robust=options.robust, confidence=options.confidence, progress=bar,
        )  # fmt: skip
    print(found)
    life = None if options.life is None else found.life(options.life, k_scatter=options.k_scatter)
    if life is not None:
        print(f"\n{life}")
    return {
        "body": found.body,
        "coefficient_mm2_per_N": found.coefficient,
        "coefficients_mm2_per_N": found.coefficients,
        "interval_mm2_per_N": found.interval,
        "confidence": found.confidence,
        "life": None if life is None else str(life),
    }


def rexs(options: argparse.Namespace) -> Table:
    """Write the scene of a stage in a REXS file."""
    target = file_target("-o", options.output, (".toml",))
    require_apart({"-o": target}, {"FILE": options.file})
    found = sw.read_rexs(options.file, stage=options.stage, pinion_torque_Nm=options.torque, changes=options.changes)
    with replacing(target) as part:
        part.write_text(found.scene.to_toml(), encoding="utf-8")
    print(f"{found}\n\nscene: {options.output}")
    taken = [{"field": name, "value": value, "from": where} for name, value, where in found.taken]
    return {"scene": options.output, "taken": taken, "left_out": found.left_out}


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
    target = options.output or Path(options.file).with_suffix(".html")
    file_target("-o", target, PAGES)
    require_apart(
        {"-o": target}, {"FILE": options.file} | ({"--against": options.against} if options.against else {})
    )
    against = sw.open_results(options.against) if options.against else None
    written = sw.report(sw.open_results(options.file), target, against, over=options.over)
    print(f"report: {written}")
    return {"report": written}


def _table(tree: xr.DataTree) -> str:
    """One row a wear step."""
    history = tree["history"].to_dataset()
    columns = [(heading, form, history[name].values) for heading, name, form in _COLUMNS if name in history.variables]
    columns[2 if "wear_depth_control_point" in history else 1 : 0] = _wear_columns(tree, history)
    if (hours := hours_of(tree)) is not None:
        columns.insert(1, ("hours", "{:.4g}", hours))
    point = control_place(tree)
    rows = [[heading.format(point.body if point else "point") for heading, *_ in columns]]
    for step in range(history.sizes["wear_step"]):
        row = []
        for _, form, values in columns:
            each = np.atleast_1d(values[step])
            row.append("/".join("-" if np.isnan(value) else form.format(value) for value in each))
        rows.append(row)
    wide = [max(len(row[k]) for row in rows) for k in range(len(columns))]
    lines = ["  ".join(text.rjust(width) for text, width in zip(row, wide, strict=True)) for row in rows]
    missing = missing_notes(history)
    lines += [f"- {heading}: {missing[name]}" for heading, name, _ in _COLUMNS if name in missing]
    return "\n".join(lines)


def _wear_columns(tree: xr.DataTree, history: xr.Dataset) -> list[tuple[str, str, np.ndarray]]:
    """Greatest wear of every body that wears: of its whole flank, its root and its addendum."""
    bodies = worn_bodies(tree) or (main_body(tree),)
    of = "{} p/g [um]" if len(bodies) > 1 else f"{bodies[0]} {{}} [um]"
    stems = ["wear_depth_max_pinion" if body == "pinion" else "wear_depth_max" for body in bodies]
    whole = tree["flank"].to_dataset()["wear_depth"].max(("profile", "face")).sel(body=list(bodies)).values
    columns = [(of.format("wear"), "{:.1f}", whole)]
    for zone in ("root", "addendum"):
        if all(f"{stem}_{zone}" in history for stem in stems):
            values = np.stack([history[f"{stem}_{zone}"].values for stem in stems], axis=-1)
            columns.append((of.format(zone), "{:.1f}", values))
    return columns


def _life(tree: xr.DataTree) -> str:
    """The life in one sentence."""
    found = tree["life"].to_dataset()
    hours = f" ({float(found['hours_to_limit']):.4g} h)" if "hours_to_limit" in found else ""
    return (
        f"life until {float(found['depth_limit']):g} um: {float(found['meshes_to_limit']):.4g} meshes{hours}; "
        f"it changes by {float(found['sensitivity_to_wear_coefficient']):.3g} % a per cent of wear coefficient, "
        f"{float(found['sensitivity_to_torque']):.3g} % a per cent of torque"
    )


class _Bar:
    """Progress bar on a terminal: tqdm's when it is installed (extra `progress`), else a line a step."""

    def __init__(self, begin: str = "computing the unworn teeth ...", unit: str = "step", what: str = "wear") -> None:
        self._begin, self._unit, self._what = begin, unit, what
        self._bar: tqdm | None = None

    def __enter__(self) -> _Bar:
        _LOG.info(self._begin)
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()

    def step(self, done: int, total: int, text: str) -> None:
        if not _LOG.isEnabledFor(logging.INFO):
            return
        try:
            from tqdm import tqdm
        except ImportError:
            _LOG.info("%s, %s %d of %d: %s", self._what, self._unit, done, total, text)
            return
        if self._bar is None:
            # what an earlier sweep has left is done, but not at the rate of this one
            first = done if self._what == "sweep" else 0
            self._bar = tqdm(total=total, unit=self._unit, desc=self._what, leave=True, initial=first)
        if done < self._bar.n:
            self._bar.reset(total)  # coarse runs for an accuracy are over
        self._bar.total = total
        self._bar.set_postfix_str(text)
        self._bar.update(done - self._bar.n)
