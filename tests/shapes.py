"""Shapes that docstrings give to attributes, held against every instance that is made.

A line ``name, other : (S, P) array [mm]`` of a dataclass says that both have two axes, and that S is the same
wherever else the class names it. A number is that length, and `P H` the product of two. Where a class says that its
"arrays are (roll, face)", so are those that say nothing else.
"""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import is_dataclass
from inspect import cleandoc
from math import prod
from types import ModuleType

import numpy as np

Shape = tuple[str, ...]

_LINE = re.compile(
    r"^(?P<names>\w+(?:, \w+)*) : (?:\((?P<shape>[\w ]*(?:,[\w ]*)*)\) )?(?:bool |int )?arrays?"
    r"(?=$| \[|,? or None|, optional)"
)
_ALL = re.compile(r"arrays are \((?P<shape>[\w, ]+)\)")


def documented(owner: type) -> dict[str, Shape]:
    """Shapes of a class's attributes, as its docstring gives them."""
    text, found = cleandoc(owner.__doc__ or ""), {}
    common = _ALL.search(text)
    for line in text.splitlines():
        match = _LINE.match(line)
        if match and (said := match["shape"] or (common and common["shape"])):
            shape = tuple(axis.strip() for axis in said.split(",") if axis.strip())
            found |= dict.fromkeys(match["names"].split(", "), shape)
    return found


def misfit(shapes: Mapping[str, Shape], values: Mapping[str, object]) -> str:
    """What contradicts the shapes, or an empty text; values that are no arrays say nothing."""
    lengths: dict[str, int] = {}
    products = []
    for name, shape in shapes.items():
        array = values.get(name)
        if not isinstance(array, np.ndarray):
            continue
        if array.ndim != len(shape):
            return f"{name} has shape {array.shape}, not ({', '.join(shape)})"
        for axis, length in zip(shape, array.shape, strict=True):
            if " " in axis:
                products.append((name, axis, length))
            elif lengths.setdefault(axis, int(axis) if axis.isdecimal() else length) != length:
                return f"{name} has shape {array.shape}, not ({', '.join(shape)}) with {axis} = {lengths[axis]}"
    for name, axis, length in products:
        factors = [int(part) if part.isdecimal() else lengths.get(part) for part in axis.split()]
        if None not in factors and prod(factors) != length:
            return f"{name} has an axis of {length}, not {axis} = {' '.join(map(str, factors))}"
    return ""


@contextmanager
def held(modules: list[ModuleType], *tuples: type) -> Iterator[dict[type, int]]:
    """Hold every dataclass of some modules to its docstring; how many instances of each were looked at.

    Of named tuples those that are given: what kernels make for themselves cannot be watched.
    """
    seen: dict[type, int] = {}
    undo = []
    for owner in {kind for module in modules for kind in vars(module).values() if isinstance(kind, type)}:
        if not is_dataclass(owner) or owner.__module__ not in {module.__name__ for module in modules}:
            continue
        shapes = documented(owner)
        if shapes:
            undo.append((owner, owner.__init__))
            owner.__init__ = _watched(owner, shapes, seen)
    news = [(owner, owner.__new__) for owner in tuples]
    for owner, _ in news:
        owner.__new__ = _watched_tuple(owner, documented(owner), seen)
    try:
        yield seen
    finally:
        for owner, begin in undo:
            owner.__init__ = begin
        for owner, new in news:
            owner.__new__ = new


def _watched(owner, shapes, seen):
    begin = owner.__init__

    def watched(self, *arguments, **named):
        begin(self, *arguments, **named)
        _look_at(self, owner, shapes, seen)

    return watched


def _watched_tuple(owner, shapes, seen):
    new = owner.__new__

    def watched(kind, *arguments, **named):
        made = new(kind, *arguments, **named)
        _look_at(made, owner, shapes, seen)
        return made

    return watched


def _look_at(made, owner, shapes, seen):
    said = misfit(shapes, {name: getattr(made, name, None) for name in shapes})
    assert not said, f"{owner.__module__}.{owner.__qualname__}: {said}"
    seen[owner] = seen.get(owner, 0) + 1
