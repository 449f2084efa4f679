"""Varied fields of a scene: all combinations of lists, lists side by side, or a table of samples.

Every list is checked before anything runs, and all faults are reported at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import TYPE_CHECKING

import numpy as np

from semiwear.errors import Problem, SceneError
from semiwear.scene import Scene
from semiwear.scene.closest import advised_name
from semiwear.scene.edit import edited, unknown_field
from semiwear.scene.reading import read_fields
from semiwear.scene.schema import SCHEMAS, Schema, schemas_of_scene, to_dict
from semiwear.scene.toml_io import write_toml
from semiwear.scene.values import is_number, shown
from semiwear.sweep.names import short_names
from semiwear.untyped import Table, Value

if TYPE_CHECKING:
    from pandas import DataFrame

COMBINATIONS = ("grid", "zip")
SAMPLE = "sample"

_MOST_SHOWN = 20
_GIVE_LIST = "a list of one or more values"
_GIVE_FIELDS = (
    'give e.g. {"operation.pinion_torque_Nm": [800, 1600]}; in a study file operation.pinion_torque_Nm = [800, 1600] '
    "under the header [vary], or distributions under [scatter]"
)


@dataclass(frozen=True)
class Axis:
    """One varied field.

    Attributes
    ----------
    key : str
        Dotted key of the field, or of a table.
    name : str
        Name in the dataset.
    values : tuple
        Values of the scene; None removes the field.
    labels : array
        Numbers, or text.
    """

    key: str
    name: str
    values: tuple[Value, ...]
    labels: np.ndarray


@dataclass(frozen=True)
class Variation:
    """Scenes that differ in some fields.

    Attributes
    ----------
    axes : tuple of Axis
    grid : bool
        Whether all combinations are solved, so that every axis is a dimension; otherwise values are side by side.
    samples : array
        Labels of the dimension `sample`; unused for a grid.
    """

    axes: tuple[Axis, ...]
    grid: bool
    samples: np.ndarray

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of the scenes."""
        return tuple(axis.name for axis in self.axes) if self.grid else (SAMPLE,)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of scenes along each dimension."""
        return tuple(len(axis.values) for axis in self.axes) if self.grid else (self.samples.size,)

    @property
    def count(self) -> int:
        """Number of scenes."""
        return prod(self.shape)

    def changes(self) -> Iterator[Table]:
        """Fields of each scene, in the order of arrays."""
        for index in np.ndindex(self.shape):
            places = index if self.grid else index * len(self.axes)
            yield {axis.key: axis.values[k] for axis, k in zip(self.axes, places, strict=True)}


def combine_problems(combine: object) -> list[Problem]:
    """The problem of an argument `combine` that is none of `COMBINATIONS`."""
    if combine in COMBINATIONS:
        return []
    otherwise = '"grid" for all combinations, "zip" for lists side by side'
    fix = advised_name(str(combine), COMBINATIONS, otherwise, quoted=True)
    return [Problem("combine", shown(combine), '"grid" or "zip"', fix)]


def read_variation(scene: Scene | None, vary: Mapping[str, Sequence[object]] | DataFrame, combine: str) -> Variation:
    """Varied fields, checked.

    Parameters
    ----------
    scene : Scene or None
        The scene that is varied; without it, fields and values are checked for a scene of any kind of gear pair.
    vary : mapping or DataFrame
        From dotted key to values; a table is taken row by row.
    combine : str
        ``"grid"`` or ``"zip"``, for a mapping.

    Raises
    ------
    SceneError
        With all faults.
    """
    problems: list[Problem] = []
    lists, labels = _lists(vary, problems)
    schemas = _schemas(scene, lists)
    read = {key: _read(scene, schemas, key, values, problems) for key, values in lists.items()}
    grid = labels is None and combine == "grid"
    _require_apart(lists, problems)
    if grid:
        _require_no_repeats(lists, read, problems)
    elif combine == "zip" or labels is not None:
        _require_equal_lengths(lists, problems)
    if problems:
        raise SceneError(_first(problems), "sweep")
    names = short_names(read)
    axes = tuple(Axis(key, names[key], tuple(values), _labels(values)) for key, values in read.items())
    samples = np.arange(len(axes[0].values)) if labels is None else labels
    return Variation(axes, grid, samples)


def _lists(vary: object, problems: list[Problem]) -> tuple[dict[str, list[Value]], np.ndarray | None]:
    """Values by key, and the labels of a table's rows; None for a mapping."""
    if hasattr(vary, "columns") and hasattr(vary, "index"):
        columns = list(vary.columns)
        if len(set(columns)) < len(columns):
            fix = "name every column after a field of its own"
            problems.append(Problem("vary", shown(columns), "columns with names of their own", fix))
        found = {str(name): _column(vary, k, str(name), problems) for k, name in enumerate(columns)}
        index = vary.index
        labels = np.asarray(index) if index.is_unique and index.nlevels == 1 else np.arange(len(index))
        labels = labels.astype(np.str_) if labels.dtype.kind not in "iuf" else labels
    elif isinstance(vary, Mapping):
        found, labels = {str(key): _values(str(key), raw, problems) for key, raw in vary.items()}, None
    else:
        allowed = "a mapping from dotted keys to lists, or a DataFrame with a column a field"
        raise SceneError.of("vary", shown(vary), allowed, 'give e.g. {"operation.pinion_torque_Nm": [800, 1600]}')
    if not found:
        allowed = "one or more fields with their values"
        problems.append(Problem("vary", "nothing", allowed, _GIVE_FIELDS))
    return found, labels


def _column(frame: Value, k: int, name: str, problems: list[Problem]) -> list[Value]:
    column = frame.iloc[:, k]
    missing = np.flatnonzero(column.isna().to_numpy())
    if missing.size:
        rows = ", ".join(str(frame.index[row]) for row in missing[:5]) + (", ..." if missing.size > 5 else "")
        fix = f"row {rows}: give a value, or drop the row (dropna)"
        problems.append(Problem(name, "NaN", "a value in every row", fix))
    values = [value.item() if isinstance(value, np.generic) else value for value in column]
    if not values:
        problems.append(Problem(name, "no rows", _GIVE_LIST, "give one row or more"))
    return [value for row, value in enumerate(values) if row not in set(missing.tolist())]


def _values(key: str, raw: object, problems: list[Problem]) -> list[Value]:
    """The values of a list; none, and a problem, if there is no list."""
    if isinstance(raw, np.ndarray) or hasattr(raw, "to_numpy"):
        array = np.asarray(raw)
        raw = array.tolist() if array.ndim else array.item()
    if not isinstance(raw, Sequence) or isinstance(raw, str | bytes):
        fix = "give a list" if isinstance(raw, Mapping | set | frozenset) else f"give [{raw!r}]"
        problems.append(Problem(key, shown(raw), _GIVE_LIST, fix))
        return []
    if not raw:
        problems.append(Problem(key, "an empty list", _GIVE_LIST, "give a value, or leave the field out"))
    return [value.item() if isinstance(value, np.generic) else value for value in raw]


def _schemas(scene: Scene | None, lists: Mapping[str, list[Value]]) -> list[Schema]:
    """Schemas of the scene's kind of gear pair, and of varied kinds; those of all kinds without a scene."""
    kinds = [kind for kind in lists.get("gear_pair.type", ()) if isinstance(kind, str) and kind in SCHEMAS]
    return list(dict.fromkeys([*schemas_of_scene(scene), *(SCHEMAS[kind] for kind in kinds)]))


def _read(
    scene: Scene | None, schemas: Sequence[Schema], key: str, values: list[Value], problems: list[Problem]
) -> list[Value]:
    """Checked values of a field, each by itself; those of tables unchanged."""
    if not _having(schemas, key):
        problems += unknown_field(scene, key, values[0] if values else "")
        return []
    found = []
    for k, raw in enumerate(values):
        value, wrong = _read_by_kinds(scene, schemas, key, raw)
        entry = f"entry {k + 1} of {len(values)}"
        problems += [replace(p, fix=f"{entry}: {p.fix}" if p.fix else entry) for p in wrong]
        found.append(value)
    return found


def problems_without_scene(changes: Mapping[str, Value]) -> list[Problem]:
    """Problems of changes to a scene that cannot be read: keys and values that no kind of gear pair takes."""
    problems = []
    schemas = schemas_of_scene(None)
    for key, raw in changes.items():
        known = _having(schemas, key)
        problems += _read_by_kinds(None, schemas, key, raw)[1] if known else unknown_field(None, key, raw)
    return problems


def _having(schemas: Sequence[Schema], key: str) -> list[Schema]:
    """Schemas that have the field or the table."""
    return [kind for kind in schemas if key and (key in kind.rules or key in kind.tables)]


def _read_by_kinds(
    scene: Scene | None, schemas: Sequence[Schema], key: str, raw: Value
) -> tuple[Value, list[Problem]]:
    """A value as the kind of gear pair with the fewest problems reads it, of those that have the field."""
    read = [_read_one(scene, kind, key, raw) for kind in _having(schemas, key)]
    value, wrong = min(read, key=lambda one: len(one[1]))
    problems = []
    for p in wrong:
        told = (own.allowed for _, every in read for own in every if own.field == p.field)
        problems.append(replace(p, allowed=" or ".join(dict.fromkeys(told))))
    return value, problems


def _read_one(scene: Scene | None, schema: Schema, key: str, raw: Value) -> tuple[Value, list[Problem]]:
    if raw is None:
        needed = key in schema.required and not key.startswith(("wear.", "effects."))
        wrong = [Problem(key, None, schema.rules[key].allowed, "every scene needs a value")] if needed else []
        return None, wrong
    if key in schema.rules:
        value, problem = schema.rules[key].apply(key, raw)
        return value, [] if problem is None else [problem]
    base = {} if scene is None else to_dict(scene, without_derived=True)
    reading = read_fields(edited(base, {key: raw})[0], schema)
    return raw, [p for p in reading.problems if p.field == key or p.field.startswith(f"{key}.")]


def _require_apart(lists: Mapping[str, object], problems: list[Problem]) -> None:
    """Refuse a field of a table that is varied, too."""
    for key in lists:
        outer = next((other for other in lists if key.startswith(f"{other}.")), None)
        if outer is not None:
            fix = f"give it in the tables of {outer}, or vary its fields one by one"
            problems.append(Problem(key, "varied together with its table", f"a field outside {outer}", fix))


def _require_no_repeats(
    lists: Mapping[str, Sequence[Value]], read: Mapping[str, Sequence[Value]], problems: list[Problem]
) -> None:
    for key, values in read.items():
        first: dict[str, int] = {}
        for k, (raw, value) in enumerate(zip(lists[key], values, strict=bool(values))):
            if value is None and raw is not None:  # refused already
                continue
            earlier = first.setdefault(_label(value), k)
            if earlier < k:
                fix = f"entry {k + 1} repeats entry {earlier + 1}: remove it"
                problems.append(Problem(key, shown(raw), "values that differ", fix))


def _require_equal_lengths(lists: Mapping[str, Sequence[object]], problems: list[Problem]) -> None:
    lengths = {key: len(values) for key, values in lists.items() if values}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{key}: {length}" for key, length in lengths.items())
        fix = 'give as many values of each, or combine="grid" for all combinations'
        problems.append(Problem("vary", listed, "lists of one length, taken side by side", fix))


def _first(problems: list[Problem]) -> list[Problem]:
    more = len(problems) - _MOST_SHOWN
    if more <= 0:
        return problems
    rest = Problem("vary", f"{more} more problems", "values in their ranges", "mend those above first")
    return [*problems[:_MOST_SHOWN], rest]


def _labels(values: Sequence[Value]) -> np.ndarray:
    """Coordinate of a dimension: numbers if all values are, else text."""
    if all(is_number(value) for value in values):
        return np.array(values)
    return np.array([_label(value) for value in values], dtype=np.str_)


def _label(value: Value) -> str:
    """A value as in a scene file, text without quotes."""
    if value is None:
        return "none"
    if isinstance(value, str):
        return value
    if hasattr(value, "__dataclass_fields__"):
        value = {name: own for name in value.__dataclass_fields__ if (own := getattr(value, name)) is not None}
    return write_toml({"value": _plain(value)}, inline=("value",)).strip().removeprefix("value = ")


def _plain(value: Value) -> Value:
    if isinstance(value, Mapping):
        return {name: _plain(own) for name, own in value.items() if own is not None}
    return value
