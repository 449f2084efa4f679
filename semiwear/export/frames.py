"""Results as tidy tables: one row for each wear step, or each of its positions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.errors import SceneError
from semiwear.plain_text import one_of
from semiwear.results.missing import group_of

if TYPE_CHECKING:
    import pandas as pd

TABLES: dict[str, tuple[str, tuple[str, ...]]] = {
    "history": ("history", ("wear_step",)),
    "engagement": ("engagement", ("wear_step", "roll_position")),
    "mesh_cycle": ("mesh_cycle", ("wear_step", "mesh_position")),
    "line_loads": ("engagement", ("wear_step", "roll_position", "face")),
    "flank": ("flank", ("wear_step", "body", "profile", "face")),
    "diagnostics": ("diagnostics", ("wear_step",)),
    "life": ("life", ()),
}
"""Tables by name: group of the result, and dimensions of the rows."""


def tables_of(tree: xr.DataTree) -> tuple[str, ...]:
    """Names of the tables that a result has."""
    return tuple(name for name in TABLES if _variables(tree, name))


def to_frame(tree: xr.DataTree, table: str = "history") -> pd.DataFrame:
    """A table of a result as a pandas data frame, one row for each wear step or each of its positions.

    Parameters
    ----------
    tree : DataTree
        A result of `simulate` or `loaded_contact`.
    table : str
        ``"history"`` (default), ``"engagement"``, ``"mesh_cycle"``, ``"line_loads"`` (a row for each slice of a
        contact line), ``"flank"`` (a row for each node of either flank), ``"diagnostics"`` or ``"life"``.

    Returns
    -------
    DataFrame
        Columns are the dimensions, `meshes` if the result has them, and the variables; a variable of both bodies
        gives two columns, such as ``root_stress_max[gear]``. Units by column are in ``frame.attrs["units"]``, long
        names in ``frame.attrs["long_name"]``.

    Raises
    ------
    SceneError
        For a table that the result does not have.
    """
    names = _variables(tree, table) if table in TABLES else []
    if not names:
        raise SceneError.of("table", table, one_of(tables_of(tree)), "take one that this result has")
    import pandas as pd

    group, dims = TABLES[table]
    data = group_of(tree, group)
    sizes = tuple(int(data.sizes[dim]) for dim in dims)
    columns: dict[str, np.ndarray] = {}
    sources: dict[str, xr.DataArray] = {}
    for k, dim in enumerate(dims):
        values = data[dim].values if dim in data.coords else np.arange(sizes[k])
        columns[dim] = _spread(values, (dim,), dims, sizes)
        sources[dim] = data[dim]
    if "meshes" in data.coords and "wear_step" in dims:
        columns["meshes"] = _spread(data["meshes"].values, data["meshes"].dims, dims, sizes)
        sources["meshes"] = data["meshes"]
    for name in names:
        array = data[name]
        bodies = [None] if "body" in dims or "body" not in array.dims else list(array["body"].values)
        for body in bodies:
            part = array if body is None else array.sel(body=body)
            column = name if body is None else f"{name}[{body}]"
            columns[column], sources[column] = _spread(part.values, part.dims, dims, sizes), array
    frame = pd.DataFrame(columns)
    for text in ("units", "long_name"):
        frame.attrs[text] = {column: str(array.attrs.get(text, "")) for column, array in sources.items()}
    return frame


def _variables(tree: xr.DataTree, table: str) -> list[str]:
    """Variables whose dims are among those of a table's rows and include the last; `body` may give columns."""
    group, dims = TABLES[table]
    found = []
    for name, array in group_of(tree, group).data_vars.items():
        row_dims = set(map(str, array.dims)) - (set() if "body" in dims else {"body"})
        if row_dims <= set(dims) and (row_dims & set(dims[-1:]) or not dims):
            found.append(str(name))
    return found


def _spread(values: np.ndarray, present: Sequence[object], dims: Sequence[str], sizes: Sequence[int]) -> np.ndarray:
    """Values over the present dims, repeated for every row of the table."""
    order = [list(present).index(dim) for dim in dims if dim in present]
    shape = [size if dim in present else 1 for dim, size in zip(dims, sizes, strict=True)]
    return np.broadcast_to(np.transpose(values, order).reshape(shape), sizes).reshape(-1)
