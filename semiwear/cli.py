"""Command line: from a new scene to a report; `semiwear --help` lists the commands."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import semiwear as sw
from semiwear.check import geometric_problems
from semiwear.cli_values import assignment, number_within, require_readable
from semiwear.completion import PrintCompletion
from semiwear.console import as_json, error_as_json, hidden_output, notes_on_standard_error, tolerant_streams
from semiwear.errors import SceneError, SemiwearError
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


_WORKERS = number_within(between(whole, 0, 1024, "leave it out for one process a core"))
_ABOVE_ZERO = number_within(positive("give a number above 0", ""))
_SHARE = number_within(Rule(number, "above 0 and below 1", lambda value: 0.0 < value < 1.0, "0.95 for 95 %"))
_MEASURED = (
    "Measured CSV files hold points: a header profile,face,x_mm,y_mm,z_mm, then one line a point, profile and face "
    "counted from 0 (root to tip, end to end of the tooth), z the body's axis; or deviations: a first line "
    "um,FACE,FACE,..., then lines PROFILE,DEVIATION,DEVIATION,... in um, positive for excess material, PROFILE and "
    "FACE as fractions of the flank from 0 to 1 (first cell 'um mm mm': in mm from root end and lower end). Without "
    "--before the flanks are taken to have been nominal, with the modifications that the scene gives them."
)
_SET_HELP = "change a field of the scene, remove it (KEY=none), or add an effect (effects.friction={})"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status.

    That is 0, or 1 where `check` finds a limit broken, or 2 for an error that the user can mend, or 130 after Ctrl-C.
    """
    with tolerant_streams() as streams:
        status = _main(arguments)
    return status or (2 if streams.failed else 0)


def _main(arguments: Sequence[str] | None) -> int:
    try:
        options = _parser().parse_args(arguments)
    except SemiwearError as error:  # an extra that an option needs
        print(f"semiwear: {error}", file=sys.stderr)
        return 2
    with notes_on_standard_error(options.quiet):
        try:
            require_readable(options)
            if "set" in options:
                options.changes = dict(options.set)
            # help, a scene's errors, its fields and its plan need nothing that the other commands compute with
            checked = "scene" in options and options.command != "check"
            given = (options, _scene(options)) if checked else (options,)
            command = _LIGHT.get(options.command) or _heavy(_MODULES[options.command], options.command)
            with hidden_output(options.json):
                end: Table | tuple[int, Table] = command(*given)
            status, told = end if isinstance(end, tuple) else (0, end)
        except (SemiwearError, OSError) as error:
            print(error_as_json(error) if options.json else f"semiwear: {error}", file=sys.stderr)
            return 2
        except KeyboardInterrupt:
            print(f"semiwear: stopped{_heavy('stopped', 'kept')(options)}", file=sys.stderr)
            return 130
    if options.json:
        print(as_json({"command": options.command} | told))
    return status


def _plan(options: argparse.Namespace, scene: sw.Scene) -> Table:
    found = sw.plan(scene, sw.open_results(options.last) if options.last else None)
    print(found)
    physics = [{"slot": c.slot, "runs": c.runs, "chosen": c.chosen, "why": c.why} for c in found.choices]
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
    found = sw.citations(sw.open_results(options.of) if is_result else sw.load_scene(options.of))
    print(found)
    return {"bibtex": found}


def _check(options: argparse.Namespace) -> tuple[int, Table]:
    """Every limit of a scene's teeth, also of one that breaks them; 1 where it does."""
    scene = load_scene(options.scene)
    checked = sw.check_geometry(scene.replace(options.changes) if options.changes else scene)
    print(checked)
    return (0 if checked.holds else 1), checked.to_dict()


_LIGHT: dict[str, Callable[..., Table | tuple[int, Table]]] = {
    "plan": _plan,
    "fields": _fields,
    "materials": _materials,
    "cite": _cite,
    "check": _check,
}


_MODULES = {
    "run": "simulation",
    **dict.fromkeys(("screen", "geometry", "calibrate"), "one_scene"),
    **dict.fromkeys(("sweep", "optimise", "infer"), "studies"),
    **dict.fromkeys(("new", "rexs", "export", "report"), "exchange"),
}


def _heavy(module: str, name: str) -> Callable[..., Value]:
    """A function of a module that is loaded only for it: none waits for what others compute with."""
    found: Callable[..., Value] = getattr(import_module(f"semiwear.commands.{module}"), name)
    return found


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="semiwear", description="Gear tooth wear, from a scene to a worn flank.")
    parser.add_argument("--version", action="version", version=f"semiwear {sw.__version__}")
    parser.add_argument(
        "--print-completion", action=PrintCompletion, choices=("bash", "zsh", "tcsh"), metavar="SHELL",
        help="print what makes a shell (bash, zsh, tcsh) complete commands, and end",
    )  # fmt: skip
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("-q", "--quiet", action="store_true", help="neither progress nor notes, errors alone")
    common.add_argument("--json", action="store_true", help="one JSON document on standard output, for machines")
    commands = _Commands(
        parser.add_subparsers(title="commands", dest="command", required=True, metavar="COMMAND"), common
    )
    of_scene = argparse.ArgumentParser(add_help=False)
    of_scene.add_argument("scene", help="a shipped scene's name, or a TOML file")
    of_scene.add_argument("--set", metavar="KEY=VALUE", type=assignment, action="append", default=[], help=_SET_HELP)

    of_page = argparse.ArgumentParser(add_help=False)
    what = "count the life in pictures of the report in: meshes (default), hours, or km of sliding"
    of_page.add_argument("--over", choices=LIFE_UNITS, default="meshes", help=what)

    new = commands.add_parser("new", help="write a commented scene to start from")
    new.add_argument("kind", choices=tuple(SCHEMAS), help="kind of gear pair")
    new.add_argument("-o", "--output", metavar="FILE", help="the scene, *.toml; default: my_KIND.toml")

    fields = commands.add_parser("fields", help="list the fields of a scene: units, defaults, allowed values")
    fields.add_argument("table", nargs="?", help="of this table alone, such as operation or effects.friction")
    fields.add_argument("--kind", choices=tuple(SCHEMAS), default="cylindrical", help="kind of gear pair")
    fields.add_argument("--json-schema", action="store_true", help="print the JSON schema of scenes, for editors")

    what = "list named materials, wear coefficients and oils, with their sources"
    materials = commands.add_parser("materials", help=what)
    materials.add_argument("kind", nargs="?", choices=KINDS, help="of this kind alone")

    what = "tell every limit of a scene's teeth, what it has, and what would be legal"
    commands.add_parser("check", help=what, parents=[of_scene], epilog="exit status 1: a limit is broken")

    what = "draw a scene's teeth and the path of contact"
    geometry = commands.add_parser("geometry", help=what, parents=[of_scene])
    what = "the picture: *.png, *.svg or *.pdf; default: teeth.png"
    geometry.add_argument("-o", "--output", metavar="FILE", default="teeth.png", help=what)

    run = commands.add_parser("run", help="simulate a scene", parents=[of_scene, of_page])
    run.add_argument("-o", "--output", metavar="FILE", help="write the result as netCDF")
    run.add_argument("--resume", action="store_true", help="go on from the wear steps in FILE.partial (see -o)")
    run.add_argument("--report", metavar="FILE", help="write the result as a self-contained HTML page")
    run.add_argument("--against", metavar="FILE", help="set the report beside another result of the same flank grid")
    run.add_argument("--fidelity", metavar="NAME", help="short for --set numerics.fidelity=NAME: line or patch")

    plan = commands.add_parser("plan", help="show what would run for a scene, and why", parents=[of_scene])
    plan.add_argument(
        "--last", metavar="FILE", help="an earlier result, for the share of its time that each effect took"
    )

    what = "show which effects a scene calls for, and what each would cost"
    screen = commands.add_parser("screen", help=what, parents=[of_scene])
    screen.add_argument(
        "--threshold",
        metavar="SHARE",
        type=number_within(positive("0.02 for 2 %", "")),
        default=0.02,
        help="relative change that counts; default 0.02",
    )

    sweep = commands.add_parser("sweep", help="solve the scenes of a study file")
    sweep.add_argument("study", help="a TOML file that names a scene and the fields to vary (docs/studies.md)")
    sweep.add_argument("-o", "--output", metavar="FILE", required=True, help="the dataset: *.nc or *.zarr")
    sweep.add_argument("--workers", metavar="N", help="processes here, 0 for this one; default: one a core")
    sweep.add_argument("--scheduler", metavar="ADDRESS", help="run on the Dask cluster of this scheduler instead")
    sweep.add_argument("--resume", action="store_true", help="go on from the solved scenes in FILE.scenes")
    sweep.add_argument("--report", metavar="FILE", help="write the sweep as a self-contained HTML page")

    optimise = commands.add_parser("optimise", help="find the best design of a study file")
    optimise.add_argument("study", help="a TOML file with aims, limits and ranges of fields (docs/best_designs.md)")
    optimise.add_argument("-o", "--output", metavar="FILE", required=True, help="the best design: a scene, *.toml")
    optimise.add_argument("--designs", metavar="FILE", help="all designs that were tried: *.nc or *.zarr")
    optimise.add_argument("--workers", metavar="N", type=_WORKERS, help="processes of the scan; default: one a core")
    optimise.add_argument("--report", metavar="FILE", help="write the search as a self-contained HTML page")

    what = "find unknown fields of a scene from what was measured on worn gears"
    infer = commands.add_parser("infer", help=what)
    infer.add_argument("study", help="a TOML file with priors and measurements (docs/inference.md)")
    infer.add_argument("-o", "--output", metavar="FILE", required=True, help="draws of the posterior: *.nc or *.zarr")
    infer.add_argument("--workers", metavar="N", type=_WORKERS, help="processes of the runs; default: one a core")
    infer.add_argument("--store", metavar="FOLDER", help="keep solved runs there, and go on from them")
    infer.add_argument("--report", metavar="FILE", help="write the inference as a self-contained HTML page")

    what = "find the wear coefficient from measured flanks"
    calibrate = commands.add_parser("calibrate", help=what, parents=[of_scene], epilog=_MEASURED)
    calibrate.add_argument("measured", nargs="+", help="worn flanks, one a part: .nc or .csv, points or deviations")
    calibrate.add_argument("--before", metavar="FILE", nargs="+", help="the same flanks before, in the same order")
    calibrate.add_argument("--body", metavar="NAME", default="gear", help="whose flanks: gear (default) or pinion")
    calibrate.add_argument(
        "--meshes",
        metavar="N",
        type=_ABOVE_ZERO,
        help="engagements of a gear tooth that they have run; default: of the scene",
    )
    calibrate.add_argument(
        "--confidence", metavar="P", type=_SHARE, default=0.95, help="of the intervals; default 0.95"
    )
    calibrate.add_argument("--robust", action="store_true", help="fit with Huber's weights, for outliers")
    calibrate.add_argument(
        "--life", metavar="UM", type=_ABOVE_ZERO, help="tell the life until this greatest depth of wear"
    )
    calibrate.add_argument(
        "--k-scatter", metavar="V", type=number_within(at_least_zero("0.5 for 50 %", "")), default=0.5,
        help="coefficient of variation of k from part to part, for the life; default 0.5",
    )  # fmt: skip

    rexs = commands.add_parser("rexs", help="make a scene of a cylindrical stage in a REXS file")
    rexs.add_argument("file", help="a REXS file: *.rexs, *.rexsj or *.rexsz")
    rexs.add_argument("-o", "--output", metavar="FILE", required=True, help="the scene, *.toml")
    rexs.add_argument("--stage", metavar="ID", help="the stage, where the file has several")
    rexs.add_argument(
        "--torque", metavar="NM", type=_ABOVE_ZERO, help="torque on the pinion [N m], where the file does not give it"
    )
    rexs.add_argument("--set", metavar="KEY=VALUE", type=assignment, action="append", default=[], help=_SET_HELP)

    what = "write a result for other tools: surfaces, tables, input decks of finite elements"
    export = commands.add_parser("export", help=what)
    export.add_argument("file", help="a netCDF file that semiwear wrote")
    export.add_argument(
        "-o", "--output", metavar="FILE", required=True, help="*.vtu, .stl, .pvd, .csv, .xlsx or .inp"
    )
    export.add_argument(
        "--body", metavar="NAME", default="gear", help="of surfaces and decks: gear (default) or pinion"
    )
    export.add_argument(
        "--wear-step",
        metavar="K",
        type=number_within(Rule(whole, "a whole number", _any, "")),
        default=-1,
        help="whose shape; default: the last",
    )
    export.add_argument("--part", metavar="NAME", default="flank", help="of surfaces: flank (default) or tooth")
    export.add_argument(
        "--exaggeration", metavar="X", type=_ABOVE_ZERO, default=1.0, help="of the wear in a shape; default 1"
    )
    export.add_argument("--table", metavar="NAME", help="of .csv and .xlsx: history, engagement, mesh_stiffness ...")
    export.add_argument(
        "--roll-position",
        metavar="R",
        type=number_within(Rule(number, "a number", _any, "")),
        help="of decks; default: of greatest root stress",
    )
    export.add_argument(
        "--teeth",
        metavar="N",
        type=number_within(between(whole, 1, 99, "leave it out for the usual number")),
        help="of decks: teeth in the mesh",
    )

    report = commands.add_parser("report", help="make the HTML page of a result", parents=[of_page])
    report.add_argument("file", help="a netCDF file that semiwear wrote")
    report.add_argument("-o", "--output", metavar="FILE", help="default: the file's name with .html")
    report.add_argument(
        "--against", metavar="FILE", help="another result of the same flank grid, e.g. of fidelity patch"
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
        """A command."""
        return self._commands.add_parser(name, help=help, parents=[self._common, *parents], epilog=epilog)


def _scene(options: argparse.Namespace) -> sw.Scene:
    changes = options.changes
    fidelity = getattr(options, "fidelity", None)
    if fidelity is not None and changes.setdefault("numerics.fidelity", fidelity) != fidelity:
        allowed = f"what --set numerics.fidelity={changes['numerics.fidelity']} says, or only one of the two"
        raise SceneError.of("--fidelity", fidelity, allowed, "leave one of them out")
    if not changes:
        return sw.load_scene(options.scene)
    # the geometry of the teeth is looked at once, as changed
    return replace(load_scene(options.scene), _check=geometric_problems).replace(changes)


if __name__ == "__main__":
    raise SystemExit(main())
