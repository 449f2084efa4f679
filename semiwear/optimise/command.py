"""The command `semiwear optimise`: a study file with aims and limits, searched, written and reported.

scene = "spur_fzg_c"
minimise = "wear_depth_max"             # or maximise; two in a list for a front

[set]                                   # changes of the scene, before anything is varied
wear.until.meshes = 2e7

[design]                                # ranges, or lists of choices
effects.modification.pinion.tip_relief_um = {from = 0, to = 60}
effects.modification.gear.tip_relief_um = {from = 0, to = 60}

[subject_to]
"transmission_error_amplitude[worst]" = "<= 30"
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from semiwear.accuracy import simulate
from semiwear.errors import Collected, Problem, SceneError
from semiwear.optimise.optimum import Optimum
from semiwear.optimise.page import write_optimum_report
from semiwear.optimise.run import optimise, plan_search
from semiwear.scene.values import shown
from semiwear.simulate import Progress
from semiwear.sweep.files import sweep_target, write_sweep
from semiwear.sweep.study_file import flat_fields, read_study
from semiwear.targets import PAGES, file_target, naming, require_apart, target_problems

_OPTIONS = ("minimise", "maximise", "most", "subject_to")
_DESIGN = "design"
_NAMES = (_DESIGN, *_OPTIONS)
_SCENES = (".toml",)


@dataclass(frozen=True)
class Searched:
    """Best design of a search, which was written as a scene, and its summary.

    Attributes
    ----------
    text : str
    best : Optimum
    """

    text: str
    best: Optimum


def run_optimise(
    study: str, output: str, *, workers: int | None, designs: str | None, report: str | None, progress: Progress,
    problems: Sequence[Problem] = (),
) -> Searched:  # fmt: skip
    """Search for the best design of a study file and write it as a scene.

    `problems` of options are reported with the others.

    Raises
    ------
    SceneError
        With all problems of the file, the scene and the options, before anything runs.
    MissingExtraError
        A report is requested, but matplotlib is missing.
    """
    problems = [*problems]
    for field, path, target in (
        ("-o", output, partial(file_target, endings=_SCENES)),
        ("--designs", designs, sweep_target),
        ("--report", report, partial(file_target, endings=PAGES)),
    ):
        problems += target_problems(field, path, target)
    read = read_study(study, _NAMES, problems, options=())
    if read is None:
        raise SceneError(problems, study)
    vary = _ranges(read.tables.get(_DESIGN), problems)
    if read.vary:
        fix = "name ranges and choices under [design]; [vary] is for semiwear sweep"
        problems.append(Problem("vary", ", ".join(read.vary), "no [vary] beside [design]", fix))
    options = {name: read.tables[name] for name in _OPTIONS if name in read.tables}
    try:
        plan_search(read.scene, vary, **options, workers=workers)
    except SceneError as error:
        problems += [problem for problem in _as_in_the_file(error) if vary or problem.field != _DESIGN]
    outputs = {"-o": output} | {
        name: path for name, path in (("--designs", designs), ("--report", report)) if path is not None
    }
    with Collected(problems):
        require_apart(outputs, read.inputs)
    if problems or read.scene is None:
        raise SceneError(problems, study)
    try:
        best = optimise(read.scene, vary, **options, workers=workers, progress=progress)
    except SceneError as error:
        raise SceneError(_as_in_the_file(error), study) from None
    scene = Path(output)
    with naming(scene):
        scene.write_text(best.scene.to_toml(), encoding="utf-8")
    lines = [str(best), "", f"scene of the best design: {output}"]
    if designs is not None:
        write_sweep(best.designs, designs)
        lines.append(f"all designs: {designs}")
    if report is not None:
        lines.append(f"report: {write_optimum_report(best, read.scene, report, simulate)}")
    return Searched("\n".join(lines), best)


def _as_in_the_file(error: SceneError) -> list[Problem]:
    """Problems of `optimise`, with the table's name in place of the argument `vary`."""
    return [replace(problem, field=_DESIGN) if problem.field == "vary" else problem for problem in error.problems]


def _ranges(design: object, problems: list[Problem]) -> dict[str, tuple[float, float] | list[object]]:
    """Ranges and choices of `[design]`, as arguments of `optimise`."""
    ranges: dict[str, tuple[float, float] | list[object]] = {}
    if not isinstance(design, Mapping) or not design:
        fix = "name fields with {from = ..., to = ...}, or with a list of choices"
        problems.append(Problem(_DESIGN, shown(design), "a table of fields", fix))
        return ranges
    for key, given in flat_fields(dict(design)):
        if isinstance(given, Mapping) and set(given) == {"from", "to"}:
            ranges[key] = given["from"], given["to"]
        elif isinstance(given, list):
            ranges[key] = given
        else:
            allowed = "{from = ..., to = ...}, or a list of choices"
            problems.append(Problem(f"{_DESIGN}.{key}", shown(given), allowed, "give both ends of the range"))
    return ranges
