"""From the outcomes of all scenes to one labelled dataset."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from semiwear.results import COORDINATES, VARIABLES
from semiwear.results.provenance import provenance
from semiwear.results.schema import Variable
from semiwear.scene import Scene
from semiwear.scene.declare import meaning_of
from semiwear.scene.schema import SCHEMAS, parent
from semiwear.scene.units import unit_of
from semiwear.sweep.measure import MESHES, Measure, Measured, is_numeric
from semiwear.sweep.outcome import Outcome, Status, has_numbers
from semiwear.sweep.scenes import Member
from semiwear.sweep.store import Store
from semiwear.sweep.variation import SAMPLE, Axis, Variation

INVERSE_TO_COEFFICIENT = (MESHES, "/life/meshes_to_limit", "/life/hours_to_limit")
"""Variables that are inverse to the wear coefficient if all others do not depend on it (`shared_solution`)."""

_STEPS = "wear_step"
_STATUS = "end of the scene"
_THIS_RUN = "this sweep"


@dataclass(frozen=True)
class _Layout:
    """Dimensions large enough for all scenes.

    Attributes
    ----------
    sizes : dict
        By dimension.
    labels : dict
        Coordinates common to all scenes; of names, those of any scene.
    own : set
        Dimensions whose coordinates differ from scene to scene.
    paths : list
        Variables of any scene, in the order of the schema.
    """

    sizes: dict[str, int]
    labels: dict[str, np.ndarray]
    own: set[str]
    paths: list[str]


def assembled(
    scene: Scene, variation: Variation, measure: Measure, members: Sequence[Member], store: Store
) -> xr.Dataset:
    """The dataset of a sweep whose outcomes are all in the store."""
    places: dict[str, list[int]] = {}
    for k, member in enumerate(members):
        places.setdefault(member.key, []).append(k)
    keys = [key for key in places if key]
    layout = _layout_of(measure, _outcomes(store, keys))
    table = _Table(layout, measure, variation.count)
    for k in places.get("", ()):
        table.refuse(k, members[k].refused)
    for outcome in _outcomes(store, keys):
        for k in places[outcome.key]:
            table.fill(k, outcome, members[k].stretch)
    return _dataset(scene, variation, measure, layout, table)


def _outcomes(store: Store, keys: Sequence[str]) -> Iterator[Outcome]:
    """Outcomes one after the other, so that only one is in memory."""
    for key in keys:
        outcome = store.get(key)
        assert outcome is not None
        yield outcome


def _variable(path: str) -> Variable:
    group, name = path[1:].split("/")
    return COORDINATES["meshes"] if path == MESHES else VARIABLES[group, name]


def _dims(path: str, measure: Measure) -> tuple[str, ...]:
    dims = _variable(path).dims
    return tuple(dim for dim in dims if dim != _STEPS) if measure.last else dims


def _layout_of(measure: Measure, outcomes: Iterator[Outcome]) -> _Layout:
    sizes, labels, own, seen = dict[str, int](), dict[str, np.ndarray](), set[str](), set[str]()
    for outcome in outcomes:
        found = outcome.measured
        for path, array in found.variables.items():
            if not is_numeric(array):  # text in a store of earlier sweeps
                continue
            seen.add(path)
            for dim, size in zip(_dims(path, measure), array.shape, strict=True):
                sizes[dim] = max(sizes.get(dim, 0), size)
        for dim, values in found.coords.items():
            _add_labels(dim, values, labels, own)
    named = {dim for dim, values in labels.items() if values.dtype.kind == "U"}
    sizes |= {dim: labels[dim].size for dim in named if dim in sizes}
    paths = [path for path in (MESHES, *measure.variables) if path in seen]
    return _Layout(sizes, {dim: values for dim, values in labels.items() if dim not in own}, own, paths)


def _add_labels(dim: str, values: np.ndarray, labels: dict[str, np.ndarray], own: set[str]) -> None:
    known = labels.setdefault(dim, values)
    if values.dtype.kind == "U":
        labels[dim] = np.array([*known, *(name for name in values if name not in known)])
    elif not np.array_equal(known, values):
        own.add(dim)


class _Table:
    """Arrays with a row for each scene, filled one by one."""

    def __init__(self, layout: _Layout, measure: Measure, count: int) -> None:
        self._layout, self._measure = layout, measure
        self.status = np.zeros(count, dtype=np.int8)
        self.seconds = np.full(count, np.nan)
        self.messages = [""] * count
        self.last_step = np.full(count, -1)
        self.arrays = {path: np.full((count, *self._shape(_dims(path, measure))), np.nan) for path in layout.paths}
        self.coords = {dim: np.full((count, layout.sizes[dim]), np.nan) for dim in sorted(layout.own)}
        self.short = np.zeros(count, dtype=bool)

    def _shape(self, dims: Sequence[str]) -> tuple[int, ...]:
        return tuple(self._layout.sizes[dim] for dim in dims)

    def refuse(self, k: int, reason: str) -> None:
        """Record that the combination of the k-th scene is illegal."""
        self.status[k], self.messages[k], self.seconds[k] = Status.REFUSED, reason, 0.0

    def fill(self, k: int, outcome: Outcome, stretch: float) -> None:
        """Record the outcome of the k-th scene, whose meshes are `stretch` times those of the outcome."""
        self.status[k], self.messages[k], self.seconds[k] = outcome.status, outcome.message, outcome.seconds
        found = outcome.measured
        for path, values in found.variables.items():
            if path not in self.arrays or not is_numeric(values):
                continue
            factor = stretch if path in INVERSE_TO_COEFFICIENT else 1.0
            places = [self._places(dim, values.shape[i], found) for i, dim in enumerate(_dims(path, self._measure))]
            self.arrays[path][k, ...][np.ix_(*places) if places else ()] = values * factor
        for dim, array in self.coords.items():
            if dim in found.coords:
                array[k, : found.coords[dim].size] = found.coords[dim]
        if MESHES in found.variables and not self._measure.last:
            self.last_step[k] = found.variables[MESHES].size - 1

    def _places(self, dim: str, size: int, found: Measured) -> np.ndarray:
        labels = self._layout.labels.get(dim)
        if labels is None or labels.dtype.kind != "U" or dim not in found.coords:
            return np.arange(size)
        index = {str(name): k for k, name in enumerate(labels)}
        return np.array([index[str(name)] for name in found.coords[dim]])


def _dataset(scene: Scene, variation: Variation, measure: Measure, layout: _Layout, table: _Table) -> xr.Dataset:
    dims, shape = variation.dims, variation.shape

    def array(values: np.ndarray, inner: Sequence[str], attrs: Mapping[str, object]) -> xr.Variable:
        return xr.Variable((*dims, *inner), values.reshape(*shape, *values.shape[1:]), dict(attrs))

    data: dict[str, xr.Variable] = {}
    for path in layout.paths:
        entry, inner = _variable(path), _dims(path, measure)
        data[entry.name] = array(table.arrays[path], inner, _attributes(entry, table, path))
    for dim, values in table.coords.items():
        entry = COORDINATES[dim]
        attrs = entry.attrs | {"long_name": f"{entry.long_name}, of each scene"}
        data[f"{dim}_of_scene"] = array(values, (dim,), attrs)
    if MESHES in layout.paths and not measure.last:
        attrs = {"units": "1", "long_name": "last wear step of the scene's run, -1 for none", "references": _THIS_RUN}
        data["last_wear_step"] = array(table.last_step, (), attrs)
    flags: dict[str, object] = {"flag_values": np.arange(len(Status), dtype=np.int8)}
    flags |= {"flag_meanings": " ".join(status.name.lower() for status in Status)}
    units = {"units": "1", "references": _THIS_RUN}
    data["status"] = array(table.status, (), {**units, "long_name": _STATUS, **flags})
    messages = np.array(table.messages, dtype=np.str_)
    data["message"] = array(messages, (), {**units, "long_name": "why the scene failed; empty where it is done"})
    clock = {"units": "s", "long_name": "time of the solution of the scene", "references": "wall clock"}
    data["seconds"] = array(table.seconds, (), clock)
    return xr.Dataset(data, _coordinates(variation, layout), _root(scene, variation, measure))


def _attributes(entry: Variable, table: _Table, path: str) -> dict[str, object]:
    """Units and long name of a variable, and the reason for missing values, if any."""
    attrs: dict[str, object] = {**entry.attrs}
    missing = np.isnan(table.arrays[path])
    if not missing.any():
        return attrs
    done = has_numbers(table.status)
    reasons = [] if done.all() else ["the scene failed (status, message)"]
    within = missing[done]
    if within.size and within.any():
        whole = within.reshape(within.shape[0], -1).all(axis=1).any()
        if whole:
            reasons.append(entry.absent or "the scene does not give it")
        elif entry.absent:
            reasons.append(entry.absent)
        if np.ptp(table.last_step[done]) or table.coords:
            reasons.append("other scenes have more wear steps or a finer grid")
    return {**attrs, "missing_because": "; or ".join(dict.fromkeys(reasons)) or "the scene does not give it"}


def _coordinates(variation: Variation, layout: _Layout) -> dict[str, xr.Variable]:
    coords: dict[str, xr.Variable] = {}
    if not variation.grid:
        attrs = {"units": "1", "long_name": "sample", "references": _THIS_RUN}
        coords[SAMPLE] = xr.Variable((SAMPLE,), variation.samples, attrs)
    for axis in variation.axes:
        dim = axis.name if variation.grid else SAMPLE
        coords[axis.name] = xr.Variable((dim,), axis.labels, _attributes_of(axis))
    for dim, values in layout.labels.items():
        if dim in layout.sizes and values.size == layout.sizes[dim]:
            coords[dim] = _own_coordinate(dim, values)
    if _STEPS in layout.sizes:
        coords[_STEPS] = _own_coordinate(_STEPS, np.arange(layout.sizes[_STEPS]))
    return coords


def _own_coordinate(dim: str, values: np.ndarray) -> xr.Variable:
    return xr.Variable((dim,), values, COORDINATES[dim].attrs)


def _attributes_of(axis: Axis) -> dict[str, str]:
    """Field, unit and meaning of a coordinate."""
    attrs = {"field": axis.key}
    if axis.labels.dtype.kind in "if":
        attrs["units"] = unit_of(axis.key)
    table, _, name = axis.key.rpartition(".")
    owners = (schema.tables[table] for schema in SCHEMAS.values() if table in schema.tables)
    meanings = (meaning_of(owner, name) for owner in owners)
    meaning_text = next((meaning for meaning in meanings if meaning), "").rstrip(".")
    attrs["long_name"] = meaning_text or f"table {axis.key}" if parent(axis.key) or meaning_text else axis.key
    return attrs


def _root(scene: Scene, variation: Variation, measure: Measure) -> dict[str, str]:
    """Attributes of the dataset, none of which depends on the time of computation, so that equal sweeps are equal."""
    whole = provenance(
        title=f"Sweep: {scene.title}" if scene.title else "Sweep",
        scene_toml=scene.to_toml(),
        physics="",
        fidelity=scene.numerics.fidelity,
        references="",
    )
    kept = ("title", "source", "scene_toml", "scene_sha256", "input_files", "libraries")
    return {name: whole[name] for name in kept} | {
        "platform": f"Python {platform.python_version()}",
        "varied": ", ".join(axis.key for axis in variation.axes),
        "measured": ", ".join(measure.variables),
        "wear_states": "last" if measure.last else "all",
    }
