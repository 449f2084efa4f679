"""Results as tidy tables: one row for each wear step, or each of its positions."""

from __future__ import annotations

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
    columns: dict[str, xr.DataArray] = {dim: data[dim] for dim in dims}
    if "meshes" in data.coords and "wear_step" in dims:
        columns["meshes"] = data["meshes"]
    for name in names:
        array = data[name]
        if "body" in dims or "body" not in array.dims:
            columns[name] = array
        else:
            columns |= {f"{name}[{body}]": array.sel(body=body) for body in array["body"].values}
    rows = xr.DataArray(np.empty([data.sizes[dim] for dim in dims]), dims=dims)
    frame = pd.DataFrame(
        {column: array.broadcast_like(rows).transpose(*dims).values.ravel() for column, array in columns.items()}
    )
    for text in ("units", "long_name"):
        frame.attrs[text] = {column: str(array.attrs.get(text, "")) for column, array in columns.items()}
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
