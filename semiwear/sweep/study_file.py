"""Study files: TOML that names a scene, its varied fields and what is measured.

scene = "face_gear_25x160"              # a shipped scene, or a file beside this one
measure = ["history", "life"]           # as of `sweep`, like the next two
wear_states = "last"
combine = "grid"

[set]                                   # changes of the scene, before anything is varied
effects.run_life.depth_limit_um = 50

[vary]
operation.pinion_torque_Nm = {from = 400, to = 2000, count = 9}
effects.misalignment.offset_mm = [-0.1, 0, 0.1]
effects.friction = ["none", {}]         # without the table, and with it
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from sys import float_info

import numpy as np

from semiwear.check import geometric_problems
from semiwear.errors import Collected, Problem, SceneError
from semiwear.scene import Scene, load_scene, scene_files, shipped_scenes
from semiwear.scene.closest import advised_name, closest
from semiwear.scene.schema import SCHEMAS
from semiwear.scene.toml_io import read_toml
from semiwear.scene.values import is_number, is_whole, shown
from semiwear.sources import no_pipe
from semiwear.sweep.variation import problems_without_scene
from semiwear.untyped import Table, Value

OPTIONS = ("measure", "wear_states", "combine")
"""Further arguments of `sweep`, which may stand in a study file."""

_OF_FIELDS = ("design", "unknown", "vary")  # tables of single commands, and of all
_RANGE = frozenset({"from", "to", "count"})
_DISTRIBUTION = "distribution"
_MOST_BYTES = 10_000_000
_MOST_VALUES = 100_000
_REMOVED = "none"


@dataclass(frozen=True)
class Study:
    """A study file.

    Attributes
    ----------
    path : Path
    scene : Scene or None
        With the changes of ``[set]``; None if it cannot be read.
    scene_name : str
        Name in the file; empty if it has none.
    vary : dict
        Lists of values by dotted key.
    options : dict
        Further arguments of `sweep`.
    tables : dict
        Tables requested by the caller, unchanged.
    """

    path: Path
    scene: Scene | None
    scene_name: str
    vary: dict[str, list[Value]]
    options: Table = field(default_factory=dict)
    tables: Table = field(default_factory=dict)

    @property
    def inputs(self) -> dict[str, str | Path]:
        """Files that the study reads, by what they are: outputs must not take their place."""
        found: dict[str, str | Path] = {"the study": self.path}
        if self.scene is not None:
            found |= scene_files(self.scene)
        if self.scene_name and self.scene_name not in shipped_scenes():
            found["the scene"] = self.path.parent / self.scene_name
        return found


def read_study(
    path: str | os.PathLike[str],
    further: tuple[str, ...],
    problems: list[Problem],
    options: tuple[str, ...] = OPTIONS,
) -> Study | None:
    """Read a study file.

    Parameters
    ----------
    path : path
    further : tuple of str
        Names of further tables and values at the top level, which the caller reads.
    problems : list of Problem
        Receives all faults of the file and of the scene that it names.
    options : tuple of str
        Permitted further arguments of `sweep`. Default: all.

    Returns
    -------
    Study or None
        The readable part, for further checks by the caller; None if the file is no TOML, or a scene.
    """
    source = Path(path)
    data = None
    with Collected(problems):
        data = read_toml(_text(source), str(source))
    if data is None:
        return None
    if "gear_pair" in data and "scene" not in data:
        fix = f'semiwear run {source.name} wears it; a study names it in its first line: scene = "{source.name}"'
        problems.append(Problem("study", f"a scene: {source.name}", "a study of a scene", fix))
        return None
    names = ("scene", *options, "set", "vary", *further)
    for name in data:
        if name not in names:
            fix = _advice(name, data[name], names)
            problems.append(Problem(name, shown(data[name]), f"a name of a study: {', '.join(names)}", fix))
    vary = _lists(_table(data, "vary", problems), problems)
    changes = {key: _or_none(key, value) for key, value in flat_fields(_table(data, "set", problems))}
    given = data.get("scene")
    scene = _scene(source, given, changes, problems)
    found = {name: data[name] for name in options if name in data}
    tables = {name: data[name] for name in further if name in data}
    return Study(source, scene, given if isinstance(given, str) else "", vary, found, tables)


def _advice(name: str, value: Value, names: Sequence[str]) -> str:
    """Advice on an unknown name of a study; an unknown table is taken to hold fields."""
    if not isinstance(value, Mapping):
        return advised_name(name, names, "remove it")
    tables = [table for table in _OF_FIELDS if table in names]
    return f"did you mean [{closest(name, (*tables, 'set', 'scatter')) or tables[0]}]?"


def _text(source: Path) -> str:
    try:
        with no_pipe(source).open("rb") as opened:
            content = opened.read(_MOST_BYTES + 1)
        if len(content) > _MOST_BYTES:
            raise SceneError.of("study", str(source), "a TOML file of a few thousand bytes", "is this a study file?")
        return content.decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError.of("study", str(source), "a TOML file in UTF-8 that can be read", str(error)) from None


def _table(data: Mapping[str, Value], name: str, problems: list[Problem]) -> Table:
    found = data.get(name, {})
    if isinstance(found, dict):
        return found
    problems.append(Problem(name, shown(found), "a table", f"write the header [{name}] above its fields"))
    return {}


def flat_fields(table: Mapping[str, Value], path: str = "") -> Iterator[tuple[str, Value]]:
    """Fields by dotted key, for any nesting in the file.

    A table that is empty, a range, a distribution, or the value of a field of a scene counts as a value.
    """
    for name, value in table.items():
        key = f"{path}.{name}" if path else name
        if isinstance(value, Mapping) and value and _nests(key, value):
            yield from flat_fields(value, key)
        else:
            yield key, value


def table_of_fields(raw: Value) -> Value:
    """A table of a study file with its fields by dotted key; what is no table as it is."""
    return dict(flat_fields(raw)) if isinstance(raw, Mapping) else raw


def _nests(key: str, value: Mapping[str, Value]) -> bool:
    """Whether a table holds fields or tables of a scene under its key, even misspelt ones."""
    is_field = any(key in schema.rules for schema in SCHEMAS.values())
    return not (is_field or set(value) <= _RANGE or _DISTRIBUTION in value)


def _lists(table: Mapping[str, Value], problems: list[Problem]) -> dict[str, list[Value]]:
    found = {}
    for key, value in flat_fields(table):
        if isinstance(value, Mapping) and set(value) & _RANGE:
            values = _range(key, value, problems)
            if values is not None:
                found[key] = values
        elif isinstance(value, list):
            found[key] = [_or_none(key, item) for item in value]
        else:
            found[key] = value  # reported with all other entries that are no list
    return found


def _range(key: str, value: Mapping[str, Value], problems: list[Problem]) -> list[Value] | None:
    allowed = "a list of values, or {from = ..., to = ..., count = ...}: numbers at equal distances"
    numbers: list[Value] = [value.get("from"), value.get("to")]
    plain = all(is_number(number) and abs(number) <= float_info.max for number in numbers)
    count = value.get("count")
    whole = is_whole(count) and 1 <= count <= _MOST_VALUES
    if set(value) != _RANGE or not plain or not whole:
        fix = f"give from, to and count (a whole number, 1 to {_MOST_VALUES})"
        problems.append(Problem(f"vary.{key}", shown(dict(value)), allowed, fix))
        return None
    return [float(number) for number in np.linspace(float(numbers[0]), float(numbers[1]), int(str(count)))]


def _or_none(key: str, value: Value) -> Value:
    """The value, or None for the word that removes a table or a field that takes no such text."""
    if value != _REMOVED:
        return value
    takes = any(key in schema.rules and schema.rules[key].apply(key, value)[1] is None for schema in SCHEMAS.values())
    return value if takes else None


def _scene(source: Path, name: object, changes: Table, problems: list[Problem]) -> Scene | None:
    if not isinstance(name, str) or not name:
        fix = f'write scene = "{shipped_scenes()[0]}", or the path of a scene file, in the first line'
        problems.append(
            Problem("scene", shown(name), "the name of a shipped scene, or the path of a scene file", fix)
        )
        problems += problems_without_scene(changes)
        return None
    beside = source.parent / name
    source_name = str(beside) if name not in shipped_scenes() and beside.exists() else name
    try:
        return load_scene(source_name, check=geometric_problems, changes=changes)
    except SceneError as error:
        problems += error.problems
        if all(_of_file(problem) for problem in error.problems):
            problems += problems_without_scene(changes)
    return None


def _of_file(problem: Problem) -> bool:
    """Whether a problem is one of the file of a scene, before any field of it was read."""
    return problem.field in ("scene", "file") or problem.field.startswith("line ")
