"""Command line: from a new scene to a report; `semiwear --help` lists the commands."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import semiwear as sw
from semiwear.check import geometric_problems
from semiwear.cli_values import Parser, UsageError, assignment, number_within, option_problems
from semiwear.completion import PrintCompletion
from semiwear.console import as_json, error_as_json, hidden_output, notes_on_standard_error, tolerant_streams
from semiwear.errors import Collected, Problem, SceneError, SemiwearError
from semiwear.references.listing import KINDS, named_text
from semiwear.references.named_data import named_sets
from semiwear.scene import load_scene
from semiwear.scene.guide import fields_text, json_schema
from semiwear.scene.rule import Rule, at_least_zero, between, positive
from semiwear.scene.schema import SCHEMAS
from semiwear.scene.units import LIFE_UNITS
from semiwear.scene.values import number, whole
from semiwear.targets import RESULTS
from semiwear.untyped import Table, Value

if TYPE_CHECKING:
    Subparsers = argparse._SubParsersAction[argparse.ArgumentParser]


def _any(value: Value) -> bool:
    return True


_WORKERS = number_within(between(whole, 0, 1024, "leave it out for one process per core"))
_ABOVE_ZERO = number_within(positive("give a number above 0", ""))
_SHARE = number_within(Rule(number, "above 0 and below 1", lambda value: 0.0 < value < 1.0, "0.95 for 95 %"))
_MEASURED = (
    "Measured CSV files hold points: a header profile,face,x_mm,y_mm,z_mm, then one line per point, profile and face "
    "counted from 0 (root to tip, end to end of the tooth), z the body's axis; or deviations: a first line "
    "um,FACE,FACE,..., then lines PROFILE,DEVIATION,DEVIATION,... in um, positive for excess material, PROFILE and "
    "FACE as fractions of the flank from 0 to 1 (first cell 'um mm mm': in mm from root end and lower end). Without "
    "--before the unworn flanks are assumed to be nominal, with the modifications in the scene."
)
_SET_HELP = "change a field of the scene, remove it (KEY=none), or add an effect (effects.friction={})"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status.

    0: success; 1: `check` has found a broken limit; 2: an error that the user can correct; 130: stopped by Ctrl-C.
    """
    with tolerant_streams() as streams:
        status = _main(arguments)
    return status or (2 if streams.failed else 0)


def _main(arguments: Sequence[str] | None) -> int:
    try:
        options = _parser().parse_args(arguments)
    except SemiwearError as error:  # of the usage, or an extra that an option needs
        words = f"{error.usage}{error}" if isinstance(error, UsageError) else f"semiwear: {error}"
        in_json = "--json" in (sys.argv[1:] if arguments is None else arguments)
        print(error_as_json(error) if in_json else words, file=sys.stderr)
        if isinstance(error, UsageError):  # ends the process, as the help and the version do
            raise SystemExit(2) from None
        return 2
    with notes_on_standard_error(options.quiet):
        try:
            # help, errors, fields and plan of a scene do not import the solvers
            given = _read(options)
            command = _LIGHT.get(options.command) or _heavy(_MODULES[options.command], options.command)
            with hidden_output(options.json):
                end: Table | tuple[int, Table] = command(*given)
            status, output = end if isinstance(end, tuple) else (0, end)
        except (SemiwearError, OSError) as error:
            named = _with_the_files_name(error, options)
            print(error_as_json(named) if options.json else f"semiwear: {named}", file=sys.stderr)
            return 2
        except KeyboardInterrupt:
            print(f"semiwear: stopped{_heavy('stopped', 'kept')(options)}", file=sys.stderr)
            return 130
    if options.json:
        print(as_json({"command": options.command} | output))
    return status


def _with_the_files_name(error: Exception, options: argparse.Namespace) -> Exception:
    """Problems of a nameless scene under the name that the command line gives its file."""
    if not isinstance(error, SceneError) or error.scene_name != SceneError.NAMELESS:
        return error
    given = (getattr(options, name, None) for name in ("scene", "study", "file", "of"))
    return SceneError(error.problems, next((str(name) for name in given if name), error.scene_name))


def _read(options: argparse.Namespace) -> tuple[object, ...]:
    """The options, and the scene or, for studies, the problems of options, which are told with those of the file.

    Raises
    ------
    SceneError
        With all problems of the options and the scene.
    """
    problems = option_problems(options)
    if options.command in _STUDIES:
        return options, problems
    name, given = "command line" if problems else "", list[object]([options])
    if "set" in options:
        options.changes = dict(options.set)
    if "scene" in options and options.command != "check":
        with Collected(problems):
            given.append(_scene(options, problems))
    if problems:
        raise SceneError(problems, name or options.scene)
    return tuple(given)


def _plan(options: argparse.Namespace, scene: sw.Scene) -> Table:
    plan = sw.plan(scene, sw.open_results(options.last) if options.last else None)
    print(plan)
    physics = [{"slot": c.slot, "runs": c.runs, "chosen": c.chosen, "why": c.why} for c in plan.choices]
    return {"physics": physics, "effects": [name for name, _ in scene.effects.present()]}


def _fields(options: argparse.Namespace) -> Table:
    if options.json_schema:
        print(json.dumps(json_schema(), indent=1))
    else:
        print(fields_text(options.kind, options.table))
    return {"schema": json_schema()} if options.json else {}


def _materials(options: argparse.Namespace) -> Table:
    kinds = (options.kind,) if options.kind else KINDS
    print(named_text(kinds))
    return {kind: named_sets(kind) for kind in kinds}


def _cite(options: argparse.Namespace) -> Table:
    is_result = options.of not in sw.shipped_scenes() and Path(options.of).suffix.casefold() in RESULTS
    bibtex = sw.citations(sw.open_results(options.of) if is_result else sw.load_scene(options.of))
    print(bibtex)
    return {"bibtex": bibtex}


def _check(options: argparse.Namespace) -> tuple[int, Table]:
    """Every limit of a scene's teeth, also if the scene breaks them; then status 1."""
    checked = sw.check_geometry(load_scene(options.scene, changes=options.changes))
    print(checked)
    return (0 if checked.holds else 1), checked.to_dict()


_LIGHT: dict[str, Callable[..., Table | tuple[int, Table]]] = {
    "plan": _plan,
    "fields": _fields,
    "materials": _materials,
    "cite": _cite,
    "check": _check,
}


_STUDIES = ("sweep", "optimise", "infer")
_MODULES = {
    "run": "simulation",
    **dict.fromkeys(("screen", "geometry", "calibrate"), "one_scene"),
    **{name: name for name in _STUDIES},
    **dict.fromkeys(("new", "rexs", "export", "report"), "exchange"),
}


def _heavy(module: str, name: str) -> Callable[..., Value]:
    """Function of a module that is imported only here, so that other commands start fast."""
    function: Callable[..., Value] = getattr(import_module(f"semiwear.commands.{module}"), name)
    return function


def _parser() -> argparse.ArgumentParser:
    text = "Gear tooth wear, from a scene to a worn flank."
    parser: argparse.ArgumentParser = Parser(prog="semiwear", description=text)
    parser.add_argument("--version", action="version", version=f"semiwear {sw.__version__}")
    parser.add_argument(
        "--print-completion", action=PrintCompletion, choices=("bash", "zsh", "tcsh"), metavar="SHELL",
        help="print a script by which a shell (bash, zsh, tcsh) completes commands, and end",
    )  # fmt: skip
    common = argparse.ArgumentParser(add_help=False)
    text = "no progress and no notes; errors, warnings and the result stay"
    common.add_argument("-q", "--quiet", action="store_true", help=text)
    common.add_argument("--json", action="store_true", help="one JSON document on standard output, for machines")
    commands = _Commands(
        parser.add_subparsers(title="commands", dest="command", required=True, metavar="COMMAND"), common
    )
    of_scene = argparse.ArgumentParser(add_help=False)
    of_scene.add_argument("scene", help="a shipped scene's name, or a TOML file")
    of_scene.add_argument("--set", metavar="KEY=VALUE", type=assignment, action="append", default=[], help=_SET_HELP)

    of_page = argparse.ArgumentParser(add_help=False)
    text = "unit of the life in the figures of the report: meshes (default), hours, or km of sliding"
    of_page.add_argument("--over", choices=LIFE_UNITS, default="meshes", help=text)

    new = commands.add_parser("new", help="write a commented scene to start from")
    new.add_argument("kind", choices=tuple(SCHEMAS), help="kind of gear pair")
    new.add_argument("-o", "--output", metavar="FILE", help="the scene, *.toml; default: my_KIND.toml")

    fields = commands.add_parser("fields", help="list the fields of a scene: units, defaults, allowed values")
    fields.add_argument("table", nargs="?", help="only of this table, such as operation or effects.friction")
    fields.add_argument("--kind", choices=tuple(SCHEMAS), default="cylindrical", help="kind of gear pair")
    fields.add_argument("--json-schema", action="store_true", help="print the JSON schema of scenes, for editors")

    text = "list named materials, wear coefficients and oils, with their sources"
    materials = commands.add_parser("materials", help=text)
    materials.add_argument("kind", nargs="?", choices=KINDS, help="only of this kind")

    text = "list every limit of a scene's teeth, with the value of the scene and the values allowed"
    commands.add_parser("check", help=text, parents=[of_scene], epilog="exit status 1: a limit is broken")

    text = "draw a scene's teeth and the path of contact"
    geometry = commands.add_parser("geometry", help=text, parents=[of_scene])
    text = "the figure: *.png, *.svg or *.pdf; default: teeth.png"
    geometry.add_argument("-o", "--output", metavar="FILE", default="teeth.png", help=text)

    run = commands.add_parser("run", help="simulate a scene", parents=[of_scene, of_page])
    run.add_argument("-o", "--output", metavar="FILE", help="write the result as netCDF")
    run.add_argument("--resume", action="store_true", help="continue from the wear steps in FILE.partial (see -o)")
    run.add_argument("--report", metavar="FILE", help="write the result as a self-contained HTML page")
    run.add_argument("--against", metavar="FILE", help="compare the report with a result on the same flank grid")
    run.add_argument("--fidelity", metavar="NAME", help="short for --set numerics.fidelity=NAME: line or patch")

    plan = commands.add_parser("plan", help="show what would run for a scene, and why", parents=[of_scene])
    plan.add_argument(
        "--last", metavar="FILE", help="an earlier result, to list the share of its time that each effect took"
    )

    text = "show which effects change the results of a scene, and the time that each takes"
    screen = commands.add_parser("screen", help=text, parents=[of_scene])
    screen.add_argument(
        "--threshold",
        metavar="SHARE",
        type=number_within(positive("0.02 for 2 %", "")),
        default=0.02,
        help="relative change from which an effect counts; default 0.02",
    )

    sweep = commands.add_parser("sweep", help="solve the scenes of a study file")
    sweep.add_argument("study", help="a TOML file that names a scene and the fields to vary (docs/studies.md)")
    sweep.add_argument("-o", "--output", metavar="FILE", required=True, help="the dataset: *.nc or *.zarr")
    sweep.add_argument("--workers", metavar="N", help="processes here, 0 for this one; default: one per core")
    sweep.add_argument("--scheduler", metavar="ADDRESS", help="run on the Dask cluster of this scheduler instead")
    sweep.add_argument("--resume", action="store_true", help="continue from the solved scenes in FILE.scenes")
    sweep.add_argument("--report", metavar="FILE", help="write the sweep as a self-contained HTML page")

    optimise = commands.add_parser("optimise", help="find the best design of a study file")
    optimise.add_argument("study", help="a TOML file with aims, limits and ranges of fields (docs/best_designs.md)")
    optimise.add_argument("-o", "--output", metavar="FILE", required=True, help="the best design: a scene, *.toml")
    optimise.add_argument("--designs", metavar="FILE", help="all designs that were tried: *.nc or *.zarr")
    text = "processes of the scan; default: one per core"
    optimise.add_argument("--workers", metavar="N", type=_WORKERS, help=text)
    optimise.add_argument("--report", metavar="FILE", help="write the search as a self-contained HTML page")

    text = "infer unknown fields of a scene from measurements on worn gears"
    infer = commands.add_parser("infer", help=text)
    infer.add_argument("study", help="a TOML file with priors and measurements (docs/inference.md)")
    infer.add_argument("-o", "--output", metavar="FILE", required=True, help="draws of the posterior: *.nc or *.zarr")
    infer.add_argument("--workers", metavar="N", type=_WORKERS, help="processes of the runs; default: one per core")
    infer.add_argument("--store", metavar="FOLDER", help="save solved runs there, and continue from them")
    infer.add_argument("--report", metavar="FILE", help="write the inference as a self-contained HTML page")

    text = "find the wear coefficient from measured flanks"
    calibrate = commands.add_parser("calibrate", help=text, parents=[of_scene], epilog=_MEASURED)
    calibrate.add_argument("measured", nargs="+", help="worn flanks, one per part: .nc or .csv, points or deviations")
    calibrate.add_argument("--before", metavar="FILE", nargs="+", help="the same flanks unworn, in the same order")
    calibrate.add_argument("--body", metavar="NAME", default="gear", help="whose flanks: gear (default) or pinion")
    calibrate.add_argument(
        "--meshes",
        metavar="N",
        type=_ABOVE_ZERO,
        help="engagements of a gear tooth before the measurement; default: those of the scene",
    )
    calibrate.add_argument(
        "--confidence", metavar="P", type=_SHARE, default=0.95, help="confidence of the intervals; default 0.95"
    )
    calibrate.add_argument("--robust", action="store_true", help="fit with Huber's weights, for outliers")
    calibrate.add_argument(
        "--life", metavar="UM", type=_ABOVE_ZERO, help="print the life until this greatest wear depth"
    )
    calibrate.add_argument(
        "--k-scatter", metavar="V", type=number_within(at_least_zero("0.5 for 50 %", "")), default=0.5,
        help="coefficient of variation of k from part to part, for the life; default 0.5",
    )  # fmt: skip

    rexs = commands.add_parser("rexs", help="make a scene of a cylindrical stage in a REXS file")
    rexs.add_argument("file", help="a REXS file: *.rexs, *.rexsj or *.rexsz")
    rexs.add_argument("-o", "--output", metavar="FILE", required=True, help="the scene, *.toml")
    rexs.add_argument("--stage", metavar="ID", help="the stage, if the file has several")
    rexs.add_argument(
        "--torque", metavar="NM", type=_ABOVE_ZERO, help="torque on the pinion [N m], if the file does not give it"
    )
    rexs.add_argument("--set", metavar="KEY=VALUE", type=assignment, action="append", default=[], help=_SET_HELP)

    text = "write a result for other tools: surfaces, tables, finite element input decks"
    export = commands.add_parser("export", help=text)
    export.add_argument("file", help="a netCDF file that semiwear wrote")
    export.add_argument(
        "-o", "--output", metavar="FILE", required=True, help="*.vtu, .stl, .pvd, .csv, .xlsx or .inp"
    )
    export.add_argument(
        "--body", metavar="NAME", default="gear", help="body of surfaces and decks: gear (default) or pinion"
    )
    export.add_argument(
        "--wear-step",
        metavar="K",
        type=number_within(Rule(whole, "a whole number", _any, "")),
        default=-1,
        help="wear step of the shape; default: the last",
    )
    export.add_argument("--part", metavar="NAME", default="flank", help="for surfaces: flank (default) or tooth")
    export.add_argument(
        "--exaggeration", metavar="X", type=_ABOVE_ZERO, default=1.0, help="factor on the wear in a shape; default 1"
    )
    export.add_argument("--table", metavar="NAME", help="for .csv and .xlsx: history, engagement, mesh_stiffness ...")
    export.add_argument(
        "--roll-position",
        metavar="R",
        type=number_within(Rule(number, "a number", _any, "")),
        help="roll position of decks; default: that of greatest root stress",
    )
    export.add_argument(
        "--teeth",
        metavar="N",
        type=number_within(between(whole, 1, 99, "leave it out for the usual number")),
        help="teeth in the mesh of decks",
    )

    report = commands.add_parser("report", help="make the HTML page of a result", parents=[of_page])
    report.add_argument("file", help="a netCDF file that semiwear wrote")
    report.add_argument("-o", "--output", metavar="FILE", help="default: the file's name with .html")
    report.add_argument(
        "--against", metavar="FILE", help="another result on the same flank grid, e.g. of fidelity patch"
    )

    cite = commands.add_parser("cite", help="print what to cite for a result or a scene, as BibTeX")
    cite.add_argument("of", metavar="FILE", help="a result (netCDF), a scene file, or a shipped scene")
    return parser


class _Commands:
    """Commands that all have the common options."""

    def __init__(self, commands: Subparsers, common: argparse.ArgumentParser):
        self._commands, self._common = commands, common

    def add_parser(
        self,
        name: str,
        *,
        help: str,
        parents: Sequence[argparse.ArgumentParser] = (),
        epilog: str | None = None,
    ) -> argparse.ArgumentParser:
        """Parser of a new command."""
        return self._commands.add_parser(name, help=help, parents=[self._common, *parents], epilog=epilog)


def _scene(options: argparse.Namespace, problems: list[Problem]) -> sw.Scene:
    changes = options.changes
    fidelity = getattr(options, "fidelity", None)
    if fidelity is not None and changes.setdefault("numerics.fidelity", fidelity) != fidelity:
        allowed = f"the value of --set numerics.fidelity={changes['numerics.fidelity']}, or only one of the two"
        problems.append(Problem("--fidelity", fidelity, allowed, "leave one of them out"))
    return load_scene(options.scene, check=geometric_problems, changes=changes)


if __name__ == "__main__":
    raise SystemExit(main())
