"""Variables of a result that a sweep keeps, and their extraction."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from semiwear.errors import Problem, SceneError
from semiwear.results import COORDINATES, GROUPS, VARIABLES
from semiwear.scene.closest import advised_name
from semiwear.scene.values import shown

STATES = ("all", "last")
MESHES = "/history/meshes"
"""Engagements of a gear tooth at every wear state: a coordinate of a result, a variable of a sweep."""

_DEFAULT = ("history", "life")
_OTHER = "tooth_contact"  # of another analysis
_STEPS = "wear_step"


@dataclass(frozen=True)
class Measure:
    """Variables of a result that a sweep keeps.

    Attributes
    ----------
    variables : tuple of str
        Paths, e.g. ``"/history/load_share_max"``, in the order of the schema.
    last : bool
        Whether only the last wear state of every variable is kept.
    peaks : tuple of int, optional
        Wear states, -1 for the last, in which peaks of the transmission error between roll positions are found; its
        amplitude in the others is that of the roll positions. Default: all.
    """

    variables: tuple[str, ...]
    last: bool = False
    peaks: tuple[int, ...] | None = None

    @property
    def groups(self) -> frozenset[str]:
        """Groups of a result that the variables are in."""
        return frozenset(path.split("/")[1] for path in self.variables)

    @property
    def life_alone(self) -> bool:
        """Whether only a life is measured, which needs no wear run."""
        return all(path.startswith("/life/") for path in self.variables)


@dataclass(frozen=True)
class Measured:
    """Arrays of one scene.

    Attributes
    ----------
    variables : dict of str to array
        By path.
    coords : dict of str to array
        Coordinates of their dimensions.
    """

    variables: dict[str, np.ndarray] = field(default_factory=dict)
    coords: dict[str, np.ndarray] = field(default_factory=dict)


def measure_of(names: str | Sequence[str] | None, wear_states: str) -> Measure:
    """Variables by names of groups and variables; by default those of `/history` and `/life`.

    Raises
    ------
    SceneError
        With every name that no result has.
    """
    problems: list[Problem] = []
    if wear_states not in STATES:
        fix = '"all" for every wear state, "last" for the end of the run'
        problems.append(Problem("wear_states", shown(wear_states), '"all" or "last"', fix))
    requested = _requested(names, problems)
    groups = [group for group in GROUPS if group != _OTHER]
    known = {name: f"/{group}/{name}" for group, name in VARIABLES if group != _OTHER}
    paths: set[str] = set()
    for name in requested:
        plain = str(name).strip("/").rpartition("/")[2] if isinstance(name, str) else ""
        if plain in groups:
            paths |= {path for path in known.values() if path.startswith(f"/{plain}/")}
        elif plain in known:
            paths.add(known[plain])
        else:
            fix = advised_name(plain, [*groups, *known], "see semiwear/results/schema.py, or sw.results.VARIABLES")
            allowed = f"a group ({', '.join(groups)}) or a variable of a result"
            problems.append(Problem("measure", shown(name), allowed, fix))
    if not requested and not problems:
        fix = "leave it out for the quantities of /history and the life"
        problems.append(Problem("measure", "nothing", "one or more names", fix))
    if problems:
        raise SceneError(problems, "sweep")
    return Measure(tuple(path for path in known.values() if path in paths), wear_states == "last")


def _requested(names: object, problems: list[Problem]) -> tuple[object, ...]:
    if names is None or isinstance(names, str):
        return _DEFAULT if names is None else (names,)
    if not isinstance(names, Iterable) or isinstance(names, bytes | Mapping):
        fix = f'give e.g. ["{_DEFAULT[0]}", "wear_depth"]'
        problems.append(Problem("measure", shown(names), "the name of a group or variable, or a list of names", fix))
        return ()
    return tuple(names)


def read_off(tree: xr.DataTree, measure: Measure) -> Measured:
    """Variables of a result that are numbers; those that it does not have are left out."""
    found, coords = dict[str, np.ndarray](), dict[str, np.ndarray]()
    datasets = {group: node.dataset for group, node in tree.children.items()}
    for path in measure.variables:
        group, name = path[1:].split("/")
        if group not in datasets or name not in datasets[group].data_vars:
            continue
        array = datasets[group][name]
        if not is_numeric(array.values):
            continue
        for dim in map(str, array.dims):
            if dim != _STEPS and dim in array.coords:
                coords[dim] = np.asarray(array[dim].values)
        found[path] = _kept(array.values, tuple(map(str, array.dims)), measure)
    if "history" in datasets:
        found[MESHES] = _kept(datasets["history"]["meshes"].values, COORDINATES["meshes"].dims, measure)
    return Measured(found, coords)


def is_numeric(values: np.ndarray) -> bool:
    """Whether an array holds numbers, not text such as the position of a least safety: a table has only numbers."""
    return values.dtype.kind in "fiub"


def _kept(values: np.ndarray, dims: tuple[str, ...], measure: Measure) -> np.ndarray:
    if measure.last and _STEPS in dims:
        return np.asarray(values.take(-1, axis=dims.index(_STEPS)))
    return np.asarray(values)
