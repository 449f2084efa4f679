"""One function for all formats, chosen by the ending of the file's name."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.errors import Collected, MissingExtraError, Problem, SceneError
from semiwear.export.flank_surface import worn_flank
from semiwear.export.frames import TABLES, tables_of, to_frame
from semiwear.export.nodes import flank_nodes
from semiwear.export.stiffness import mesh_stiffness
from semiwear.export.surface import Surface, write_series, write_surface
from semiwear.export.whole_teeth import worn_tooth, write_input_deck
from semiwear.meshing.flank_pair import BODIES
from semiwear.plain_text import one_of
from semiwear.results.missing import group_of
from semiwear.targets import file_target, replacing

if TYPE_CHECKING:
    import pandas as pd

ENDINGS = (".vtu", ".stl", ".pvd", ".csv", ".xlsx", ".inp")
"""Endings of the names of exported files."""

STIFFNESS = "mesh_stiffness"
"""Table of `mesh_stiffness` over mesh position and wear step."""

_PARTS: dict[str, Callable[..., Surface]] = {"flank": worn_flank, "tooth": worn_tooth}
_LARGE = ("flank", "line_loads")  # tables that a workbook holds only on request


def export(
    tree: xr.DataTree,
    path: str | os.PathLike[str],
    *,
    body: str = "gear",
    wear_step: int = -1,
    part: str = "flank",
    exaggeration: float = 1.0,
    table: str | None = None,
    roll_position: float | None = None,
    teeth: int | None = None,
) -> None:
    """Write a result for another tool, in the format of the name's ending.

    * ``.vtu``: a worn flank or tooth with the wear of every step as fields, for ParaView and PyVista; ``.stl``: its
      facets only; ``.pvd``: every wear step in its own shape, over meshes (extra ``view``);
    * ``.csv``: one table; ``.xlsx``: a workbook with a sheet for each table (extra ``tables``). Headings hold units;
    * ``.inp``: the body with worn flanks in 20-node elements, held at its bore or back face, under the forces of its
      contact: a deck for CalculiX and Abaqus.

    Parameters
    ----------
    tree : DataTree
        A result of `simulate`; for tables also one of `loaded_contact`.
    path : path
        An existing file is replaced.
    body : str
        For surfaces and decks: ``"pinion"`` or ``"gear"``.
    wear_step : int
        Wear step of the shape of surfaces and decks. Default: the last.
    part : str
        For surfaces: ``"flank"`` (default) or ``"tooth"``, a whole tooth with its fillets and its rim.
    exaggeration : float
        For surfaces: factor on the wear in the shape, but not in the fields.
    table : str, optional
        A table of `to_frame`, or ``"mesh_stiffness"``. Default: ``"history"`` for CSV; all but the largest two, and
        no stiffness, for a workbook.
    roll_position : float, optional
        For decks: roll position of the middle tooth. Default: that of its greatest root stress.
    teeth : int, optional
        For decks: teeth in the mesh. Default: 5 for the bodies of a face gear pair, all for a cylindrical gear.

    Raises
    ------
    SceneError
        For another ending, an unknown body, part, table, wear step or roll position, or an exaggeration not above 0.
    MissingExtraError
        With the name of the extra to install.
    """
    problems = [
        Problem(name, value, one_of(allowed), "take one of these")
        for name, value, allowed in (("body", body, BODIES), ("part", part, tuple(_PARTS)))
        if value not in allowed
    ]
    if table is not None and table not in (*TABLES, STIFFNESS):
        problems.append(Problem("table", table, one_of((*tables_of(tree), STIFFNESS)), "take one of these"))
    if not exaggeration > 0.0:
        problems.append(Problem("exaggeration", exaggeration, "> 0", "1 is to scale"))
    with Collected(problems):
        target = file_target("path", path, ENDINGS)
    if problems:
        raise SceneError(problems, "export")
    ending = target.suffix.casefold()
    if ending == ".csv":
        frame = _headed(_frame(tree, table or "history"))
        with replacing(target) as written:
            frame.to_csv(written, index=False)
    elif ending == ".xlsx":
        _write_workbook(tree, target, table)
    elif ending == ".inp":
        write_input_deck(tree, target, body, wear_step, roll_position, teeth)
    elif ending == ".pvd":
        write_series(target, _series(tree, body, part, exaggeration))
    else:
        write_surface(target, _PARTS[part](tree, body, wear_step, exaggeration=exaggeration))


def _series(tree: xr.DataTree, body: str, part: str, exaggeration: float) -> dict[float, Surface]:
    steps = range(len(flank_nodes(tree, body).depth))
    flank = group_of(tree, "flank")
    meshes = flank["meshes"].values if "meshes" in flank.coords else np.arange(len(steps))
    return {float(meshes[k]): _PARTS[part](tree, body, k, exaggeration=exaggeration) for k in steps}


def _frame(tree: xr.DataTree, table: str) -> pd.DataFrame:
    """A table of the result, or that of the mesh stiffness."""
    if table != STIFFNESS:
        return to_frame(tree, table)
    found = mesh_stiffness(tree, local="flank" in tree.children)
    frame = found.to_dataframe().reset_index()
    for text in ("units", "long_name"):
        frame.attrs[text] = {column: str(found[column].attrs.get(text, "")) for column in frame.columns}
    return frame


def _headed(frame: pd.DataFrame) -> pd.DataFrame:
    """Table with units in its headings, such as ``wear_depth_max[gear] [um]``, except for dimensionless columns."""
    units = frame.attrs["units"]
    names = {name: f"{name} [{units[name]}]" for name in frame.columns if units.get(name, "1") not in ("", "1")}
    return frame.rename(columns=names)


def _write_workbook(tree: xr.DataTree, target: Path, table: str | None) -> None:
    try:
        import openpyxl as openpyxl
        import pandas as pd
    except ImportError as error:
        raise MissingExtraError("openpyxl", "tables", "a workbook") from error
    names = [name for name in tables_of(tree) if name not in _LARGE] if table is None else [table]
    frames = {name: _frame(tree, name) for name in names}
    about = [
        (name, column, frame.attrs["units"][column], frame.attrs["long_name"][column])
        for name, frame in frames.items()
        for column in frame.columns
    ]
    with replacing(target) as written, pd.ExcelWriter(written, engine="openpyxl") as book:
        for name, frame in frames.items():
            _headed(frame).to_excel(book, sheet_name=name, index=False)
        columns = ["table", "column", "units", "meaning"]
        pd.DataFrame(about, columns=columns).to_excel(book, sheet_name="about", index=False)
