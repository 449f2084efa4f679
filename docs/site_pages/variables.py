"""Page of result variables and coordinates, from their one table."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import starmap

from semiwear.results import COORDINATES, GROUPS, Variable
from semiwear.results.schema import variables_of

_INTRODUCTION = """\
# Variables of a result

A result is an xarray `DataTree`; every variable stands in one group and carries its unit (`units`), what it is
(`long_name`) and its source (`references`) as attributes. This page is made of the table from which the package
writes those attributes.
"""


def variables_page() -> str:
    """Every group with its variables, and the coordinates."""
    lines = [_INTRODUCTION, "## Coordinates", ""]
    for entry in COORDINATES.values():
        lines += _entry(entry)
    for group in GROUPS:
        lines += [f"## `/{group}`", ""]
        for entry in variables_of(group):
            lines += _entry(entry)
    return "\n".join(lines) + "\n"


def _entry(entry: Variable) -> Iterator[str]:
    dims = f"({', '.join(entry.dims)})" if entry.dims else "(a single value)"
    unit = "pure number or text" if entry.units == "1" else entry.units
    yield f"`{entry.name}` {dims} · {unit}"
    said = [f"{entry.long_name[:1].upper()}{entry.long_name[1:]}."]
    if entry.flags:
        said.append("Values: " + ", ".join(f"{k} {name}" for k, name in enumerate(entry.flags)) + ".")
    if entry.labels:
        said.append("Labels: " + ", ".join(f"`{label}`" for label in entry.labels) + ".")
    if entry.absent:
        said.append(f"NaN where {entry.absent}.")
    if entry.infinite:
        said.append(f"Infinite where {entry.infinite}.")
    if entry.comment:
        said.append(f"{entry.comment[:1].upper()}{entry.comment[1:]}.")
    if entry.needs:
        said.append(f"In results of scenes with {' and '.join(starmap(_need, entry.needs.items()))}.")
    elif entry.optional:
        said.append("Not in every result.")
    yield f": {' '.join(said)} Source: {entry.references}."
    yield ""


def _need(key: str, value: bool | str) -> str:
    """A field that a scene must give, or the value that it must have."""
    return f"`{key}`" if value is True else f'`{key}` "{value}"'
