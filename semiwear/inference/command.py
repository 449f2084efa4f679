"""The command `semiwear infer`: a study file with priors and measurements, inferred, written and reported.

scene = "face_gear_25x160"
life_um = [60]                          # lives until these depths of wear, of the body life_body
k_scatter = 0.5                         # of the wear coefficient from part to part, for these lives

[set]                                   # changes of the scene, before anything is inferred
wear.until.meshes = 4e7

[unknown]                               # prior distributions, as in [scatter]
wear.coefficient_mm2_per_N = {distribution = "lognormal"}
operation.pinion_torque_Nm = {distribution = "normal", mean = 1600, deviation = 200, low = 1}

[[worn_flank]]
measured = "worn.nc"                    # beside this file; before, meshes, body and datum if need be

[[wear_at_points]]                      # or in a file with these columns: file = "points.csv"
face_mm = [500, 510]
height_mm = [-4, -4]
depth_um = [12.1, 13.0]
error_um = 0.5

[[transmission_error]]                  # or in a file with these columns
mesh_position = [0, 0.25, 0.5, 0.75]
error_arcsec = [1.0, 1.4, 0.3, -0.2]
uncertainty_arcsec = 0.1

[[reading]]
quantity = "transmission_error_amplitude"
value = 2.1
error = 0.1
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, fields, replace
from functools import partial
from math import isfinite
from pathlib import Path

import numpy as np

from semiwear.accuracy import simulate
from semiwear.errors import Collected, Problem, SceneError, SemiwearError
from semiwear.inference.lives import PosteriorLife, scatter_problems
from semiwear.inference.observations import (
    Observation,
    Reading,
    TransmissionErrorCurve,
    WearAtPoints,
    WornFlank,
)
from semiwear.inference.page import write_posterior_report
from semiwear.inference.posterior import Posterior
from semiwear.inference.run import infer, plan_inference
from semiwear.plain_text import rows_of
from semiwear.plot.style import styled
from semiwear.scene.closest import advised_name
from semiwear.scene.values import shown
from semiwear.simulate import Progress
from semiwear.sweep.files import sweep_target, write_sweep
from semiwear.sweep.study_file import Study, read_study, table_of_fields
from semiwear.targets import PAGES, file_target, require_apart, target_problems
from semiwear.untyped import Table, Value

_KINDS: dict[str, type[Observation]] = {
    "worn_flank": WornFlank,
    "wear_at_points": WearAtPoints,
    "transmission_error": TransmissionErrorCurve,
    "reading": Reading,
}
_TABLED = ("wear_at_points", "transmission_error")
_FILES = ("measured", "before")
_OPTIONS = ("runs", "emulator_share", "seed")
_NAMES = ("unknown", "life_um", "life_body", "k_scatter", *_OPTIONS, *_KINDS)


def run_inference(
    study: str, output: str, *, workers: int | None, store: str | None, report: str | None, progress: Progress,
    problems: Sequence[Problem] = (),
) -> str:  # fmt: skip
    """Infer the unknown fields of a study file, write the draws and the page if requested; returns the summary.

    `problems` of options are reported with the others.

    Raises
    ------
    SceneError
        With all faults of the file, the scene and the options, before anything runs.
    MissingExtraError
        emcee or scikit-learn is missing, or matplotlib if a report is requested.
    """
    problems = [*problems, *target_problems("-o", output, sweep_target)]
    problems += target_problems("--report", report, partial(file_target, endings=PAGES))
    read = read_study(study, _NAMES, problems, options=())
    if read is None:
        raise SceneError(problems, study)
    given, lives = _observations(read, problems), _lives(read, problems)
    unknown = table_of_fields(read.tables.get("unknown", {}))
    observed = list(given.values())
    if read.vary:
        fix = "name priors under [unknown]; [vary] is for semiwear sweep"
        problems.append(Problem("vary", ", ".join(read.vary), "no [vary] beside [unknown]", fix))
    options = {name: read.tables[name] for name in _OPTIONS if name in read.tables}
    with Collected(problems):
        _require_apart(read, {"-o": output} | ({"--report": report} if report else {}), observed)
    if problems or read.scene is None:
        problems += _further_problems(read, unknown, given, options)
        raise SceneError(problems, study)
    if report is not None:
        with styled():  # requires the extra before anything runs
            pass
    try:
        found = infer(read.scene, unknown, observed, crew=workers, store=store, progress=progress, **options)
    except SceneError as error:
        raise SceneError(_named(error.problems, list(given)), study) from None
    write_sweep(found.to_dataset(), output)  # before the lives, which may fail
    try:
        solved = [found.life(depth, crew=workers, store=store, progress=progress, **lives) for depth in _depths(read)]
    except SemiwearError as error:
        raise SemiwearError(f"{error}; the draws are in {output}") from error
    return "\n".join(_lines(found, observed, solved, output, report))


def _lines(
    found: Posterior, observed: Sequence[Observation], lives: Sequence[PosteriorLife], output: str, report: str | None
) -> list[str]:
    lines = [str(found), *([""] if lives else []), *map(str, lives), "", f"draws: {output}"]
    if report is not None:
        lines.append(f"report: {write_posterior_report(found, observed, report, simulate, lives)}")
    return lines


def _further_problems(
    read: Study, unknown: Value, given: dict[str, Observation], options: Table
) -> Sequence[Problem]:
    """Problems that an inference finds in the readable part of the file."""
    try:
        plan_inference(read.scene, unknown, list(given.values()), **options)
    except SceneError as error:
        found = [problem for problem in error.problems if given or problem.field != "observed"]
        return _named(found, list(given))
    return []


def _named(problems: Sequence[Problem], entries: Sequence[str]) -> list[Problem]:
    """Problems with observations, by their names in the study file."""
    found = []
    for problem in problems:
        head, _, rest = problem.field.partition(".")
        number = re.fullmatch(r"observed(?:\[(\d+)\])?", head)
        if number is not None and entries:
            head = entries[int(number[1] or 0)]
        found.append(replace(problem, field=f"{head}.{rest}" if rest else head))
    return found


def _depths(read: Study) -> list[float]:
    return _listed(read.tables.get("life_um", []))


def _listed(given: Value) -> list[Value]:
    return list(given) if isinstance(given, list) else [given]


def _lives(read: Study, problems: list[Problem]) -> Table:
    """Options of `Posterior.life`; adds problems with the file's entries on lives."""
    found = {
        name: read.tables[key]
        for name, key in (("body", "life_body"), ("k_scatter", "k_scatter"))
        if key in read.tables
    }
    wrong = [fault for depth in _depths(read) for fault in _life_problems(read, depth, found.get("body", "gear"))]
    problems += [fault for k, fault in enumerate(wrong) if fault not in wrong[:k]]
    problems += scatter_problems(found.get("k_scatter", 0.0))
    return found


def _life_problems(read: Study, depth: Value, body: Value) -> list[Problem]:
    """Problems with a life until a depth [um] of a body, by the rules of [effects.run_life]."""
    table = "effects.run_life"
    if read.scene is None or read.scene.wear is None:
        return []  # reported with the scene
    try:
        read.scene.replace({table: {"depth_limit_um": depth, "body": body}, "numerics.accuracy": None}).to_dict()
    except SceneError as error:
        names = {f"{table}.depth_limit_um": "life_um", f"{table}.body": "life_body"}
        return [replace(fault, field=names.get(fault.field, fault.field)) for fault in error.problems]
    return []


def _observations(read: Study, problems: list[Problem]) -> dict[str, Observation]:
    """Observations by the names of their entries in the file."""
    tables = [
        (kind, table, (name, k))
        for name, kind in _KINDS.items()
        for k, table in enumerate(_listed(read.tables.get(name, [])))
    ]
    found = {f"{at[0]}[{at[1]}]": _observation(read, kind, table, at, problems) for kind, table, at in tables}
    return {name: observed for name, observed in found.items() if observed is not None}


def _observation(
    read: Study, kind: type[Observation], table: Value, position: tuple[str, int], problems: list[Problem]
) -> Observation | None:
    name, field = position[0], f"{position[0]}[{position[1]}]"
    if not isinstance(table, Mapping):
        problems.append(Problem(field, shown(table), "a table", f"write the header [[{name}]] above its fields"))
        return None
    given = _with_files(read.path.parent, dict(table), name in _TABLED, field, problems)
    if given is None:
        return None
    names = [entry.name for entry in fields(kind)]
    wrong = []
    for key in given:
        if key not in names:
            where, value = (key, shown(given[key])) if key in table else ("file", f"column {key!r}")
            fix = advised_name(key, names, "remove it")
            wrong.append(Problem(f"{field}.{where}", value, ", ".join(names), fix))
    needed = [entry.name for entry in fields(kind) if entry.default is MISSING and entry.name not in given]
    wrong += [Problem(f"{field}.{key}", None, "given", "see docs/inference.md") for key in needed]
    problems += wrong
    return None if wrong else kind(**given)


def _with_files(folder: Path, table: Table, tabled: bool, field: str, problems: list[Problem]) -> Table | None:
    """An observation's table with paths beside the study, and its file's columns; None if these cannot be read."""
    named = [*_FILES, *(("file",) if tabled else ())]
    fix = "name one file, beside the study"
    wrong = [
        Problem(f"{field}.{key}", shown(table[key]), "a path in quotes", fix)
        for key in named
        if key in table and not isinstance(table[key], str)
    ]
    if wrong:
        problems += wrong
        return None
    given = {key: str(folder / value) if key in _FILES else value for key, value in table.items()}
    if not tabled or "file" not in given:
        return given
    path = folder / given.pop("file")
    try:
        columns = _columns(path)
    except (OSError, ValueError) as error:
        fix = "commas between columns, their names in the first line"
        problems.append(Problem(f"{field}.file", str(path), "a CSV file that can be read", f"{error}; {fix}"))
        return None
    twice = [key for key in given if key in columns]
    fix = "leave out the list, or the column"
    problems += [Problem(f"{field}.{key}", shown(given[key]), f"none beside that in {path}", fix) for key in twice]
    return None if twice else given | columns


def _columns(path: Path) -> dict[str, np.ndarray]:
    """Columns of a CSV file by the names in its first line.

    Raises
    ------
    OSError, ValueError
        With the fault.
    """
    rows = rows_of(path.read_text(encoding="utf-8-sig"))
    if len(rows) < 2:
        raise ValueError("no line of numbers below the names")
    head, cells = rows[0], rows[1:]
    if len(set(head)) < len(head):
        raise ValueError("two columns of one name")
    for k, row in enumerate(cells, start=1):
        if len(row) != len(head):
            raise ValueError(f"row {k} has {len(row)} cells, the first line {len(head)}")
        for name, cell in zip(head, row, strict=True):
            if not _is_finite(cell):
                raise ValueError(f"row {k} has {cell!r} for {name}, not a number")
    return {name: np.array([float(row[j]) for row in cells]) for j, name in enumerate(head)}


def _is_finite(cell: str) -> bool:
    try:
        return isfinite(float(cell))
    except ValueError:
        return False


def _require_apart(read: Study, outputs: dict[str, str], observed: Sequence[Observation]) -> None:
    inputs = read.inputs
    for k, observation in enumerate(observed):
        if isinstance(observation, WornFlank):
            inputs |= {
                f"{name} of worn_flank[{k}]": str(value)
                for name, value in (("measured", observation.measured), ("before", observation.before))
                if value is not None
            }
    require_apart(outputs, inputs)
