"""From plain arrays to labelled datasets, once, at the end of a computation."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.results.rating_errors import safety_and_life_errors
from semiwear.results.schema import (
    COORDINATES,
    GROUPS,
    SCHEMA_VERSION,
    VARIABLES,
    Variable,
    coordinates_of,
    variable,
    variables_of,
)


def build_tree(
    groups: Mapping[str, Mapping[str, np.ndarray]],
    coords: Mapping[str, np.ndarray],
    attrs: Mapping[str, str],
    group_attrs: Mapping[str, Mapping[str, str]] | None = None,
) -> xr.DataTree:
    """Wrap the arrays of a computation into a result tree.

    Parameters
    ----------
    groups : mapping of str to mapping of str to array
        Arrays by group and name, e.g. ``{"history": {"load_share_max": ...}}``. Names, dims and units are
        those of `semiwear.results.schema`; groups may be left out, and so may optional variables.
    coords : mapping of str to array
        Coordinate values, shared by all groups; each group takes those of its own dims. `body`, `axis`,
        `direction`, `wear_step` and `profile` have defaults. `meshes` goes with `wear_step` and is needed
        by `/history`.
    attrs : mapping of str to str
        Attributes of the root (see `semiwear.results.provenance`); `schema_version` is added.
    group_attrs : mapping of str to mapping of str to str, optional
        Attributes of groups.

    Returns
    -------
    DataTree
        One child for each group; the root has attributes only.

    Raises
    ------
    SemiwearError
        A name is unknown, a required variable or coordinate is missing, a shape is wrong or a value is not
        finite where the schema has no reason for it; the message names the variable.
    """
    for group in groups:
        if group not in GROUPS:
            raise SemiwearError(f"/{group}: not a group of a result; groups: {', '.join(GROUPS)}")
    attrs_of_groups = group_attrs or {}
    nodes = {"/": xr.Dataset(attrs=_strings({**attrs, "schema_version": SCHEMA_VERSION}, "/"))}
    nodes |= {
        f"/{group}": build_dataset(group, groups[group], coords, attrs_of_groups.get(group))
        for group in GROUPS
        if group in groups
    }
    return xr.DataTree.from_dict(nodes)


def with_rating_errors(tree: xr.DataTree) -> xr.DataTree:
    """The tree with the errors of safeties and lives, from its error estimates, in `/ratings`."""
    ratings = tree["ratings"].to_dataset()
    errors = safety_and_life_errors(ratings, tree["diagnostics"].to_dataset())
    for name, values in errors.items():
        entry = VARIABLES["ratings", name]
        ratings[name] = _labelled(entry, _array(values, entry, entry.path))
    tree["ratings"].dataset = ratings
    return tree


def build_dataset(
    group: str,
    variables: Mapping[str, np.ndarray],
    coords: Mapping[str, np.ndarray],
    attrs: Mapping[str, str] | None = None,
) -> xr.Dataset:
    """Wrap the arrays of one group; parameters and errors as in `build_tree`.

    `variables` may hold plain floats for scalars (``contact_ratio``).
    """
    entries = variables_of(group)
    if not entries:
        raise SemiwearError(f"/{group}: not a group of a result; groups: {', '.join(GROUPS)}")
    for name in variables:
        if (group, name) not in VARIABLES:
            hint = "; give it as a coordinate" if name in COORDINATES else ""
            raise SemiwearError(f"/{group}/{name}: not in the schema of results{hint}")
    for name in coords:
        if name not in COORDINATES:
            raise SemiwearError(f"coordinate {name}: not in the schema of results")
    missing = [entry.name for entry in entries if not entry.optional and entry.name not in variables]
    if missing:
        raise SemiwearError(f"/{group}: {', '.join(missing)} missing")

    arrays = {
        entry.name: _array(variables[entry.name], entry, entry.path) for entry in entries if entry.name in variables
    }
    labels = _labels(group, arrays, coords)
    sizes = {dim: len(labels[dim]) for dim in labels if COORDINATES[dim].dims == (dim,)}
    for name, array in arrays.items():
        entry = VARIABLES[group, name]
        expected = tuple(sizes[dim] for dim in entry.dims)
        if array.shape != expected:
            raise SemiwearError(f"{entry.path}: shape {array.shape}, but ({', '.join(entry.dims)}) is {expected}")
    labelled = {name: _labelled(VARIABLES[group, name], array) for name, array in arrays.items()}
    axes = {name: _labelled(COORDINATES[name], values) for name, values in labels.items()}
    return xr.Dataset(labelled, axes, _strings(attrs or {}, f"/{group}"))


def check_tree(tree: xr.DataTree) -> None:
    """Check that the variables of a tree are complete: required ones present, dims and units as in the schema,
    finite except for values that may be missing or infinite.

    Variables that are not in the schema are not checked, so that a user can add some.

    Raises
    ------
    SemiwearError
        The first variable that differs from the schema.
    """
    for group in tree.children:
        dataset = tree[group].to_dataset()
        for entry in variables_of(group):
            _check_dims(dataset, entry)
        for name in map(str, dataset.variables):
            entry_or_none = variable(group, name)
            if entry_or_none is not None:
                _array(dataset[name].values, entry_or_none, f"/{group}/{name}")
                _check_units(dataset[name].attrs.get("units"), entry_or_none.units, f"/{group}/{name}")
        if group == "history" and "meshes" not in dataset.coords:
            raise SemiwearError("/history/meshes: missing")


def _check_dims(dataset: xr.Dataset, entry: Variable) -> None:
    if entry.name not in dataset:
        if not entry.optional:
            raise SemiwearError(f"{entry.path}: missing")
        return
    if dataset[entry.name].dims != entry.dims:
        raise SemiwearError(f"{entry.path}: dims {dataset[entry.name].dims}, expected {entry.dims}")
    for dim in entry.dims:
        if dim not in dataset.coords:
            raise SemiwearError(f"/{entry.group}/{dim}: missing, needed by {entry.path}")


def _check_units(found: object, expected: str, path: str) -> None:
    if found != expected:
        stated = "no units" if found is None else f"units {found!r}"
        raise SemiwearError(f"{path}: {stated}, expected {expected!r}")


def _labels(group: str, arrays: Mapping[str, np.ndarray], coords: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Coordinate values of a group by name."""
    used: dict[str, tuple[str, int]] = {}
    for name, array in arrays.items():
        entry = VARIABLES[group, name]
        if array.ndim != len(entry.dims):
            raise SemiwearError(f"{entry.path}: shape {array.shape}, but dims ({', '.join(entry.dims)})")
        for dim, size in zip(entry.dims, array.shape, strict=True):
            used.setdefault(dim, (entry.path, size))
    labels: dict[str, np.ndarray] = {}
    for name in coordinates_of(group):
        entry = COORDINATES[name]
        if entry.dims[0] not in used:
            continue
        if name == "meshes" and group != "history" and name not in coords:
            continue
        labels[name] = _label(entry, coords, *used[entry.dims[0]])
    if "meshes" in labels and len(labels["meshes"]) != len(labels["wear_step"]):
        raise SemiwearError(
            f"coordinate meshes: {len(labels['meshes'])} values for {len(labels['wear_step'])} wear steps"
        )
    return labels


def _label(entry: Variable, coords: Mapping[str, np.ndarray], path: str, size: int) -> np.ndarray:
    """Values of a coordinate, given or by default, for a dim of some size that the variable at `path` has."""
    name = entry.name
    if name in coords:
        values = _array(coords[name], entry, f"coordinate {name}")
    elif entry.labels:
        values = np.array(entry.labels)
    elif name in ("wear_step", "profile"):
        values = np.arange(size)
    else:
        raise SemiwearError(f"coordinate {name}: missing, needed by {path}")
    if entry.labels and tuple(values) != entry.labels:
        raise SemiwearError(f"coordinate {name}: {tuple(values)}, must be {entry.labels}")
    if values.ndim != 1:
        raise SemiwearError(f"coordinate {name}: shape {values.shape}, must have one dimension")
    return values


def _array(values: object, entry: Variable, path: str) -> np.ndarray:
    """Array of the entry's dtype, checked to be finite or missing for a reason and, for flags, to be known."""
    if entry.dtype == "str":
        return np.asarray(values, dtype=np.str_)
    array = np.asarray(values)
    if array.dtype.kind not in "biuf":
        raise SemiwearError(f"{path}: values of type {array.dtype}, must be real numbers")
    finite = np.isfinite(array)
    if entry.absent and array.dtype.kind == "f":
        finite |= np.isnan(array)
    if entry.infinite:
        finite |= array == np.inf
    if not finite.all():
        index = tuple(int(i) for i in np.argwhere(~finite)[0])
        count = f"{int((~finite).sum())} of {array.size} values"
        raise SemiwearError(f"{path}: {count} are not finite, the first at index {index}")
    if entry.flags and not np.isin(array, np.arange(len(entry.flags))).all():
        raise SemiwearError(f"{path}: values must be {_flag_text(entry.flags)}")
    converted = array.astype(entry.dtype)
    if entry.dtype.startswith("int") and not np.array_equal(converted, array):
        raise SemiwearError(f"{path}: values must be whole numbers")
    return converted


def _labelled(entry: Variable, array: np.ndarray) -> xr.Variable:
    """The array with the dims and attributes of its entry in the schema."""
    attrs: dict[str, str | np.ndarray] = {**entry.attrs}
    if entry.absent and np.isnan(array).any():
        attrs["missing_because"] = entry.absent
    if entry.infinite and np.isinf(array).any():
        attrs["infinite_because"] = entry.infinite
    if entry.flags:
        attrs["flag_values"] = np.arange(len(entry.flags), dtype=entry.dtype)
        attrs["flag_meanings"] = " ".join(entry.flags)
    return xr.Variable(entry.dims, array, attrs)


def _flag_text(flags: Iterable[str]) -> str:
    return ", ".join(f"{value} ({meaning})" for value, meaning in enumerate(flags))


def _strings(attrs: Mapping[str, str], path: str) -> dict[str, str]:
    """Attributes, all of which must be strings (netCDF stores no bool, None or dict)."""
    for name, value in attrs.items():
        if not isinstance(value, str):
            raise SemiwearError(f"{path} attribute {name}: {type(value).__name__}, must be a string")
    return dict(attrs)
