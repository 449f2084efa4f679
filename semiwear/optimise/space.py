"""Designs that are searched: ranges of numbers, whole numbers, and choices from a list."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.errors import Problem, SceneError
from semiwear.scene import Scene
from semiwear.scene.values import is_number, shown
from semiwear.sweep.variation import read_variation
from semiwear.untyped import Table, Value

_SAME = 1e-9  # of a range


@dataclass(frozen=True)
class DesignField:
    """A field that is varied.

    Attributes
    ----------
    key : str
        Dotted key.
    name : str
        In tables: as short as can be told apart.
    values : tuple
        The two ends of a range, or all choices.
    continuous : bool
        Whether every number between the two may be taken.
    """

    key: str
    name: str
    values: tuple[Value, ...]
    continuous: bool

    def value(self, place: float) -> Value:
        """The field's value at a place in [0, 1]."""
        if self.continuous:
            low, high = float(self.values[0]), float(self.values[1])
            return low + min(max(place, 0.0), 1.0) * (high - low)
        return self.values[self.index(place)]

    def index(self, place: float) -> int:
        """Which of the choices a place in [0, 1] stands for."""
        return min(int(place * len(self.values)), len(self.values) - 1)

    def place(self, value: Value) -> float | None:
        """The place of a value, None where it is none of the field's."""
        if not self.continuous:
            return (self.values.index(value) + 0.5) / len(self.values) if value in self.values else None
        low, high = float(self.values[0]), float(self.values[1])
        if not is_number(value) or high <= low:
            return None
        share = (float(value) - low) / (high - low)
        return min(max(share, 0.0), 1.0) if -_SAME <= share <= 1.0 + _SAME else None


@dataclass(frozen=True)
class Space:
    """All designs.

    Attributes
    ----------
    fields : tuple of DesignField
    """

    fields: tuple[DesignField, ...]

    @property
    def continuous(self) -> IntArray:
        """Places in a design that may be any number."""
        return np.flatnonzero([field.continuous for field in self.fields])

    def changes(self, design: FloatArray) -> Table:
        """Fields of the scene for a design, (fields,) in [0, 1]."""
        return {field.key: field.value(float(place)) for field, place in zip(self.fields, design, strict=True)}

    def snapped(self, design: FloatArray) -> FloatArray:
        """The same design, with the one place of each choice that stands for it."""
        found = np.clip(design, 0.0, 1.0)
        for k, field in enumerate(self.fields):
            if not field.continuous:
                found[k] = (field.index(float(found[k])) + 0.5) / len(field.values)
        return found

    def start(self, scene: Scene) -> FloatArray:
        """The scene itself as a design, in the middle of what it does not give."""
        found = []
        for field in self.fields:
            value = scene_value(scene, field.key)
            place = None if value is None else field.place(value)
            found.append(0.5 if place is None else place)
        return np.array(found)


def scene_value(scene: Scene, key: str) -> Value:
    """A field of a scene, None where it is not given."""
    data: Value = scene.to_dict()
    for name in key.split("."):
        if not isinstance(data, Mapping) or name not in data:
            return None
        data = data[name]
    return data


def space_of(scene: Scene, vary: object) -> Space:
    """Ranges ``(low, high)`` and lists of choices, by dotted key.

    A range of a field that takes whole numbers, such as a number of teeth, becomes the list of all of them.

    Raises
    ------
    SceneError
        With everything that is wrong.
    """
    problems: list[Problem] = []
    if not isinstance(vary, Mapping) or not vary:
        allowed = "a mapping from fields to (low, high), or to a list of choices"
        fix = 'such as {"effects.modification.pinion.tip_relief_um": (0, 60)}'
        raise SceneError([Problem("vary", shown(vary), allowed, fix)], "optimise")
    lists: dict[str, Sequence[object]] = {}
    for key, told in vary.items():
        if isinstance(told, tuple) and not (len(told) == 2 and all(is_number(one) for one in told)):
            problems.append(Problem(str(key), shown(told), "(low, high), two numbers", "give a list for choices"))
        elif isinstance(told, tuple) and not told[0] < told[1]:
            fix = "exchange the two" if told[0] > told[1] else "give ends that differ, or change the scene"
            problems.append(Problem(str(key), shown(told), "low below high", fix))
        lists[key] = told
    variation = None
    try:
        variation = read_variation(scene, lists, "grid")
    except SceneError as error:
        problems += error.problems
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
