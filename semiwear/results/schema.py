"""Table of result variables, `variables.toml`: group, name, dims, units, long name and published source.

No other module of semiwear writes a unit or a long name. A result is a tree of groups; a group is a set of
`VARIABLES`, and its dims take their labels from `COORDINATES`.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from importlib import resources
from types import MappingProxyType

SCHEMA_VERSION = "1"
"""Version of the result files; a file of another version is refused with a clear message."""


class Zone(IntEnum):
    """Part of a flank: the band of the pitch surface, and the parts on its two sides (`/flank zone`)."""

    ROOT = 0
    PITCH = 1
    ADDENDUM = 2


@dataclass(frozen=True)
class Variable:
    """One variable or coordinate of a result.

    Attributes
    ----------
    group : str
        Group of the tree; empty for a coordinate, which every group with its dim has.
    name : str
        Name in the dataset.
    dims : tuple of str
        Dimensions, in order; empty for a scalar.
    units : str
        Units as CF and UDUNITS write them; ``"1"`` for a pure number.
    long_name : str
        Description in words.
    references : str
        Published source of the quantity, or its means of measurement.
    dtype : str
        numpy dtype it is stored in; ``"str"`` for labels.
    optional : bool
        Whether a result may leave it out; a variable that could not be computed is absent.
    absent : str
        Reason why single values may be NaN, which the variable's attribute ``missing_because`` then states.
        Empty where every value must be a number.
    infinite : str
        Reason why values may be infinite, which the attribute ``infinite_because`` then states; empty likewise.
    flags : tuple of str
        Meanings of the integer values 0, 1, ... of a flag variable.
    needs : mapping
        What a scene must have for its result to hold it, by dotted key: a value, one of a list, or True for whatever
        value. Of `/history` and `/life`.
    comment : str
        What to beware of.
    labels : tuple of str
        The only labels a coordinate can have (``("pinion", "gear")``).
    """

    group: str
    name: str
    dims: tuple[str, ...]
    units: str
    long_name: str
    references: str
    dtype: str = "float64"
    optional: bool = False
    absent: str = ""
    infinite: str = ""
    flags: tuple[str, ...] = ()
    labels: tuple[str, ...] = ()
    needs: Mapping[str, bool | str] = field(default_factory=dict)
    comment: str = ""

    @property
    def attrs(self) -> dict[str, str]:
        """Attributes in every dataset: units, description, source, and a comment where there is one."""
        attrs = {"units": self.units, "long_name": self.long_name, "references": self.references}
        return attrs | ({"comment": self.comment} if self.comment else {})

    @property
    def path(self) -> str:
        """Path in the tree, e.g. ``"/history/load_share_max"``."""
        return f"/{self.group}/{self.name}"


def _entries() -> Iterator[Variable]:
    """Entries of the table; coordinates belong to no group."""
    text = resources.files("semiwear.results").joinpath("variables.toml").read_text(encoding="utf-8")
    tables = tomllib.loads(text)
    sources, reasons = tables.pop("sources"), tables.pop("reasons")
    for group, lines in tables.items():
        for name, line in lines.items():
            yield Variable(
                group="" if group == "coordinates" else group,
                name=name,
                dims=tuple(line["dims"]),
                units=line["units"],
                long_name=line["is"],
                references=sources[line["source"]],
                dtype=line.get("dtype", "float64"),
                optional=line.get("optional", False),
                absent=reasons[line["absent"]] if "absent" in line else "",
                infinite=reasons[line["infinite"]] if "infinite" in line else "",
                flags=tuple(line.get("flags", ())),
                labels=tuple(line.get("labels", ())),
                needs=line.get("needs", {}),
                comment=line.get("comment", ""),
            )


_TABLE = tuple(_entries())

COORDINATES: Mapping[str, Variable] = MappingProxyType({v.name: v for v in _TABLE if not v.group})
"""Coordinates by name."""

VARIABLES: Mapping[tuple[str, str], Variable] = MappingProxyType({(v.group, v.name): v for v in _TABLE if v.group})
"""Every variable of every group, by (group, name)."""

GROUPS: tuple[str, ...] = tuple(dict.fromkeys(v.group for v in VARIABLES.values()))
"""Groups in the order of the tree."""


def variable(group: str, name: str) -> Variable | None:
    """Entry of a variable, or of a coordinate that the group can carry; None where there is none."""
    return VARIABLES.get((group, name)) or (COORDINATES[name] if name in coordinates_of(group) else None)


def variables_of(group: str) -> tuple[Variable, ...]:
    """Variables of a group, in order."""
    return tuple(v for v in VARIABLES.values() if v.group == group)


def coordinates_of(group: str) -> tuple[str, ...]:
    """Names of the coordinates that a group can carry: those of its dims, and `meshes` on `wear_step`."""
    dims = {dim for v in variables_of(group) for dim in v.dims}
    return tuple(name for name, entry in COORDINATES.items() if set(entry.dims) <= dims)
