"""Space of the designs of a search: ranges of numbers, whole numbers, and choices from a list."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.errors import Collected, Problem, SceneError
from semiwear.scene import Scene
from semiwear.scene.values import is_number, shown
from semiwear.sweep.variation import read_variation
from semiwear.untyped import Table, Value

_ROUNDING = 1e-9  # of a range


@dataclass(frozen=True)
class DesignField:
    """A field that is varied.

    Attributes
    ----------
    key : str
        Dotted key.
    name : str
        Name in tables: the shortest that is unique.
    values : tuple
        The two ends of a range, or all choices.
    continuous : bool
        Whether every number of the range is allowed.
    """

    key: str
    name: str
    values: tuple[Value, ...]
    continuous: bool

    def value(self, coordinate: float) -> Value:
        """Value of the field at a coordinate in [0, 1]."""
        if self.continuous:
            low, high = float(self.values[0]), float(self.values[1])
            return low + min(max(coordinate, 0.0), 1.0) * (high - low)
        return self.values[int(self.index(np.float64(coordinate)))]

    def index(self, coordinates: FloatArray | np.float64) -> IntArray:
        """Indices of the choices at coordinates in [0, 1]."""
        count = len(self.values)
        return np.asarray(np.minimum((coordinates * count).astype(int), count - 1))

    def coordinate(self, value: Value) -> float | None:
        """Coordinate of a value, None if the field cannot have it."""
        if not self.continuous:
            return (self.values.index(value) + 0.5) / len(self.values) if value in self.values else None
        low, high = float(self.values[0]), float(self.values[1])
        if not is_number(value) or high <= low:
            return None
        fraction = (float(value) - low) / (high - low)
        return min(max(fraction, 0.0), 1.0) if -_ROUNDING <= fraction <= 1.0 + _ROUNDING else None


@dataclass(frozen=True)
class Space:
    """Space of all designs.

    Attributes
    ----------
    fields : tuple of DesignField
    """

    fields: tuple[DesignField, ...]

    @property
    def continuous(self) -> IntArray:
        """Indices of the continuous fields."""
        return np.flatnonzero([field.continuous for field in self.fields])

    def changes(self, design: FloatArray) -> Table:
        """Fields of the scene for a design, (fields,) in [0, 1]."""
        return {field.key: field.value(float(x)) for field, x in zip(self.fields, design, strict=True)}

    def snapped(self, designs: FloatArray) -> FloatArray:
        """The same designs (..., fields), with every choice moved to the middle of its interval."""
        snapped = np.clip(designs, 0.0, 1.0)
        for k, field in enumerate(self.fields):
            if not field.continuous:
                snapped[..., k] = (field.index(snapped[..., k]) + 0.5) / len(field.values)
        return snapped

    def start(self, scene: Scene) -> FloatArray:
        """The scene itself as a design; 0.5 for fields that it does not give."""
        coordinates = []
        for field in self.fields:
            value = scene_value(scene, field.key)
            coordinate = None if value is None else field.coordinate(value)
            coordinates.append(0.5 if coordinate is None else coordinate)
        return np.array(coordinates)


def scene_value(scene: Scene, key: str) -> Value:
    """Value of a scene's field, None if it is not given."""
    data: Value = scene.to_dict()
    for name in key.split("."):
        if not isinstance(data, Mapping) or name not in data:
            return None
        data = data[name]
    return data


def space_of(scene: Scene | None, vary: object) -> Space:
    """Space of the designs that vary fields over ranges ``(low, high)`` or lists of choices, by dotted key.

    A range of a field that takes whole numbers, such as a number of teeth, becomes the list of all of them. Without a
    scene, fields and values are checked for a scene of any kind of gear pair.

    Raises
    ------
    SceneError
        With all problems.
    """
    problems: list[Problem] = []
    if not isinstance(vary, Mapping) or not vary:
        allowed = "a mapping from fields to (low, high), or to a list of choices"
        fix = 'such as {"effects.modification.pinion.tip_relief_um": (0, 60)}'
        raise SceneError([Problem("vary", shown(vary), allowed, fix)], "optimise")
    lists: dict[str, Sequence[object]] = {}
    for key, given in vary.items():
        if isinstance(given, tuple) and not (len(given) == 2 and all(is_number(end) for end in given)):
            problems.append(Problem(str(key), shown(given), "(low, high), two numbers", "give a list for choices"))
        elif isinstance(given, tuple) and not given[0] < given[1]:
            fix = "exchange the two" if given[0] > given[1] else "give ends that differ, or change the scene"
            problems.append(Problem(str(key), shown(given), "low below high", fix))
        lists[key] = given
    variation = None
    with Collected(problems):
        variation = read_variation(scene, lists, "grid")
    if problems or variation is None:
        raise SceneError(problems, "optimise")
    fields = []
    for axis in variation.axes:
        values, ranged = axis.values, isinstance(vary[axis.key], tuple)
        whole = ranged and all(isinstance(value, int) for value in values)
        if whole:
            values = tuple(range(int(values[0]), int(values[1]) + 1))
        fields.append(DesignField(axis.key, axis.name, values, ranged and not whole))
    return Space(tuple(fields))
