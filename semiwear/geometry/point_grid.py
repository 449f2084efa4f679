"""A flank as a grid of points, and the files that hold one.

The points [mm] stand in the body's own frame: its axis is z; x is any direction across it. Rows (`profile`) run from
the root end of the flank to its tip edge, columns (`face`) along the tooth from end to end; the outermost ones lie on
the nominal (sharp) borders of the flank. Neighbours need not be equally far apart.

netCDF (.nc): a variable `points` over (profile, face, xyz) with `units` "mm". Optional: `normals` (profile, face,
xyz), unit normals out of the material; `face` (face), a rising coordinate along the tooth [mm] that both bodies
share (mating points have about the same), for the face stations; `profile_length` (face) [mm], how
much a coordinate across the tooth, if not its arc length, rises from root to tip, uniformly from row to row; `counts`
(profile, face), 0 for points that fill the grid and were not measured; attribute `teeth`. Optional tooth
sections for the compliance, each normal to the tooth (`semiwear.geometry.section`): `section_face` (section) [mm],
`section_flank` (section, flank_point, xy) and `section_fillet` (section, fillet_point, xy) [mm], `section_row`
(section, flank_point), the fractional row of the grid, counted from 0, in which a section's flank point lies; and
either `section_pitch` and `section_back_height` (section) [mm] of a rack, or `section_teeth` and
`section_bore_radius` (section) [mm] of a ring.

CSV (.csv): a header with the columns profile, face (whole numbers that count rows and columns from 0), x_mm, y_mm,
z_mm and, if known, nx, ny, nz; a line per point in any order; lines that begin with # are skipped. Commas, semicolons
or tabs separate cells; with semicolons or tabs, numbers may have decimal commas.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from semiwear.arrays import BoolArray, FloatArray
from semiwear.errors import Problem, SceneError
from semiwear.geometry.section import RackRim, RingRim, ToothSection
from semiwear.plain_text import rows_of
from semiwear.sources import MOST_VALUES, is_netcdf, oversized, read_dataset
from semiwear.targets import file_target, replacing
from semiwear.untyped import Options, Value

if TYPE_CHECKING:
    from xarray import Dataset

_LAYOUT = "a variable points over (profile, face, xyz) in mm"
_COLUMNS = ("profile", "face", "x_mm", "y_mm", "z_mm")
_NORMALS = ("nx", "ny", "nz")
_FILE = "a .nc or .csv file with the points of a flank in mm"


@dataclass(frozen=True)
class PlacedSection:
    """A tooth section and its face coordinate.

    Attributes
    ----------
    face : float [mm]
        Face coordinate of the file.
    section : ToothSection
        Its `flank_profile` holds fractional rows of the grid, counted from 0.
    """

    face: float
    section: ToothSection


@dataclass(frozen=True)
class PointGrid:
    """Points of a flank, as a file holds them.

    Attributes
    ----------
    points : (P, F, 3) array [mm]
        In the body's own frame, rows from root to tip.
    normals : (P, F, 3) array or None
        Out of the material, unit length.
    face : (F,) array [mm] or None
        Coordinate of the columns along the tooth.
    profile_length : (F,) array [mm] or None
        Uniform rise of the coordinate across the tooth from the first row to the last. None: the arc length.
    sections : tuple of PlacedSection
    attributes : mapping
        Other attributes of a file: `teeth`, and those that `export_flank` writes for information.
    counts : (P, F) bool array or None
        Points that were measured; others only fill the grid. None: all.
    """

    points: FloatArray
    normals: FloatArray | None = None
    face: FloatArray | None = None
    profile_length: FloatArray | None = None
    sections: tuple[PlacedSection, ...] = ()
    attributes: Mapping[str, Value] = field(default_factory=dict)
    counts: BoolArray | None = None


# ---- writing


def write_point_grid(path: str | os.PathLike[str], grid: PointGrid) -> None:
    """Write points to a .nc or .csv file, by its name; CSV holds points and normals only.

    A grid with points that were not measured needs netCDF: in CSV all points count as measured.

    An existing file is replaced as a whole.

    Raises
    ------
    SceneError
        For another kind of file, or one that cannot hold the grid.
    """
    file = file_target("path", path, (".nc", ".csv"))
    suffix = Path(path).suffix.casefold()
    if suffix == ".csv" and grid.counts is not None and not grid.counts.all():
        raise SceneError.of("path", str(path), "a .nc file for points of which not all were measured", "call it .nc")
    with replacing(file) as part:
        if suffix == ".csv":
            part.write_text(_as_csv(grid), encoding="utf-8")
        else:
            _as_dataset(grid).to_netcdf(part, engine="netcdf4")


def _as_csv(grid: PointGrid) -> str:
    rows, columns = grid.points.shape[:2]
    table = [grid.points] if grid.normals is None else [grid.points, grid.normals]
    values = np.concatenate(table, axis=2)
    lines = [",".join(_COLUMNS if grid.normals is None else (*_COLUMNS, *_NORMALS))]
    lines += [f"{i},{j}," + ",".join(map(repr, values[i, j].tolist())) for i in range(rows) for j in range(columns)]
    return "\n".join(lines) + "\n"


def _as_dataset(grid: PointGrid) -> Dataset:
    import xarray as xr  # only where points are written

    on_flank = ("profile", "face", "xyz")
    variables: Options = {
        "points": (on_flank, grid.points, {"units": "mm", "long_name": "points of the flank, own axis along z"})
    }
    if grid.normals is not None:
        variables["normals"] = (on_flank, grid.normals, {"units": "1", "long_name": "normals out of the material"})
    if grid.profile_length is not None:
        text = {"units": "mm", "long_name": "coordinate across the tooth, from root to tip"}
        variables["profile_length"] = ("face", grid.profile_length, text)
    if grid.counts is not None:
        text = {"units": "1", "long_name": "1: measured; 0: fills the grid"}
        variables["counts"] = (on_flank[:2], grid.counts.astype(np.int8), text)
    if grid.sections:
        variables |= _section_variables(grid.sections)
    data = xr.Dataset(variables, attrs={"title": "flank as points", **grid.attributes})
    if grid.face is not None:
        data = data.assign_coords(face=("face", grid.face, {"units": "mm", "long_name": "along the tooth"}))
    return data


def _section_variables(placed: tuple[PlacedSection, ...]) -> Options:
    sections = [entry.section for entry in placed]
    mm = {"units": "mm"}
    found: Options = {
        "section_face": ("section", [entry.face for entry in placed], mm),
        "section_flank": (("section", "flank_point", "xy"), np.stack([section.flank for section in sections]), mm),
        "section_row": (("section", "flank_point"), np.stack([section.flank_profile for section in sections])),
        "section_fillet": (("section", "fillet_point", "xy"), np.stack([section.fillet for section in sections]), mm),
    }
    rims = [section.rim for section in sections]
    if all(isinstance(rim, RackRim) for rim in rims):
        found["section_pitch"] = ("section", [rim.pitch for rim in rims], mm)  # type: ignore[union-attr]
        found["section_back_height"] = ("section", [rim.back_height for rim in rims], mm)  # type: ignore[union-attr]
    else:
        found["section_teeth"] = ("section", [rim.teeth for rim in rims])  # type: ignore[union-attr]
        found["section_bore_radius"] = ("section", [rim.bore_radius for rim in rims], mm)  # type: ignore[union-attr]
    return found


# ---- reading


class _Unfit(Exception):
    """A file that cannot be read as points: what was found, what is allowed, what to do."""

    def __init__(self, found: str, allowed: str, fix: str) -> None:
        super().__init__(found)
        self.found, self.allowed, self.fix = found, allowed, fix


def read_point_grid(path: str | os.PathLike[str], key: str = "path") -> PointGrid | Problem:
    """Points from a file, or the problem with reading it; whether they form a flank is not checked.

    Parameters
    ----------
    path : path
        A .nc or .csv file in the layout of this module.
    key : str
        The scene's field, for the problem.
    """
    file = Path(path)
    try:
        if not file.is_file():
            raise _Unfit("no such file", _FILE, "check the path; export_flank makes such a file")
        return _read_csv(file) if file.suffix.casefold() == ".csv" else _read_netcdf(file)
    except _Unfit as unfit:
        return Problem(key, f"{file}: {unfit.found}", unfit.allowed, unfit.fix)


def _read_netcdf(file: Path) -> PointGrid:
    if not is_netcdf(file):
        raise _Unfit("no netCDF file", _FILE, "write it as netCDF, or call it .csv")
    if found := oversized(file):
        raise _Unfit(found, f"at most {MOST_VALUES:.0e} values", "write the points of one flank")
    try:
        data = read_dataset(file)
    except (OSError, ValueError) as error:
        raise _Unfit(f"it cannot be read ({error})", _FILE, "write it again") from None
    if "scene_toml" in data.attrs:
        raise _Unfit("a result of semiwear", "the points of one flank", "export_flank(..., worn=result) writes them")
    points = _on_flank(data, "points")
    unit = str(data["points"].attrs.get("units", "mm"))
    if unit != "mm":
        raise _Unfit(f"points in {unit!r}", 'units "mm"', "convert the points to millimetres and set their units")
    normals = _on_flank(data, "normals") if "normals" in data else None
    if normals is not None and normals.shape != points.shape:
        raise _Unfit(f"{normals.shape} normals for {points.shape} points", "one normal a point", "complete the grid")
    face = np.asarray(data["face"].values, float) if "face" in data.coords else None
    length = None
    if "profile_length" in data:
        length = np.asarray(data["profile_length"].values, float)
        if length.shape != points.shape[1:2] or not np.all(np.isfinite(length)) or length.min() <= 0.0:
            raise _Unfit(
                "a profile_length that is not positive", "one positive length a column", "correct it, or leave it out"
            )
    grid = PointGrid(points, normals, face, length, counts=_counts(data), attributes=dict(data.attrs))
    return replace(grid, sections=_sections(data)) if "section_flank" in data else grid


def _counts(data: Dataset) -> BoolArray | None:
    if "counts" not in data:
        return None
    if set(data["counts"].dims) != {"profile", "face"}:
        raise _Unfit(f"counts over {data['counts'].dims}", "one a point", "lay it out over (profile, face)")
    return np.asarray(data["counts"].transpose("profile", "face").values != 0, dtype=bool)


def _on_flank(data: Dataset, name: str) -> FloatArray:
    dims = ("profile", "face", "xyz")
    if name not in data or set(data[name].dims) != set(dims) or data[name].sizes["xyz"] != 3:
        found = f"no variable {name}" if name not in data else f"{name} over {dict(data[name].sizes)}"
        raise _Unfit(found, _LAYOUT, "lay the points out so; xyz has length 3")
    try:
        return np.ascontiguousarray(data[name].transpose(*dims).values, dtype=float)
    except (TypeError, ValueError) as error:
        raise _Unfit(f"{name}: {error}", "numbers", "write numbers") from None


def _sections(data: Dataset) -> tuple[PlacedSection, ...]:
    def values(name: str, *dims: str) -> FloatArray:
        if name not in data or data[name].dims != dims:
            found = f"sections without {name} over {dims}"
            raise _Unfit(found, "whole sections", "export_flank writes such sections; or leave all of them out")
        found_values = np.asarray(data[name].values, float)
        if not np.all(np.isfinite(found_values)):
            raise _Unfit(f"{name} is not finite", "finite numbers", "complete the sections, or leave all of them out")
        return found_values

    faces = values("section_face", "section")
    flank = values("section_flank", "section", "flank_point", "xy")
    rows = values("section_row", "section", "flank_point")
    fillet = values("section_fillet", "section", "fillet_point", "xy")
    rims: list[RackRim | RingRim]
    if "section_pitch" in data:
        pitch, back = values("section_pitch", "section"), values("section_back_height", "section")
        rims = [RackRim(float(p), float(b)) for p, b in zip(pitch, back, strict=True)]
    else:
        teeth, bore = values("section_teeth", "section"), values("section_bore_radius", "section")
        rims = [RingRim(round(float(n)), float(b)) for n, b in zip(teeth, bore, strict=True)]
    if faces.size == 0 or np.any(np.diff(faces) <= 0.0):
        raise _Unfit("sections out of order", "sections with growing section_face", "sort them")
    return tuple(
        PlacedSection(float(faces[k]), ToothSection(flank[k], rows[k], fillet[k], rims[k])) for k in range(faces.size)
    )


def _rows(file: Path) -> list[list[str]]:
    try:
        return rows_of(file.read_text(encoding="utf-8-sig"))
    except UnicodeDecodeError:
        raise _Unfit("no UTF-8 text", _FILE, "save it as UTF-8") from None
    except ValueError as error:
        raise _Unfit(f"no table ({error})", _FILE, "give one point a line") from None


def _read_csv(file: Path) -> PointGrid:
    rows = _rows(file)
    head = rows[0] if rows else []
    foreign = [name for name in head if name[:2] in ("x_", "y_", "z_") and not name.endswith("_mm")]
    if foreign:
        fix = "convert the points to millimetres, and name the columns x_mm, y_mm, z_mm"
        raise _Unfit(f"a column {foreign[0]!r}", "points in mm", fix)
    absent = [name for name in _COLUMNS if name not in head]
    if absent:
        fix = f"begin with the line {','.join(_COLUMNS)}; lines of remarks begin with #"
        raise _Unfit(f"no column {absent[0]}", "a header with the names of the columns", fix)
    short = next((k for k, row in enumerate(rows) if len(row) != len(head)), None)
    if short is not None:
        raise _Unfit(f"line {short + 1} has {len(rows[short])} cells, the first {len(head)}", "one point a line", "")
    try:
        table = np.array([[float(cell) for cell in row] for row in rows[1:]]).reshape(-1, len(head))
    except ValueError as error:
        raise _Unfit(str(error), "numbers with a decimal point", "correct the cell") from None
    column = {name: table[:, k] for k, name in enumerate(head)}
    index = np.column_stack([column["profile"], column["face"]])
    if index.size == 0 or not np.array_equal(index, np.round(index)) or index.min() < 0.0:
        fix = "number rows (profile) and columns (face) from 0"
        raise _Unfit("profile and face that do not count rows and columns", "whole numbers from 0", fix)
    if index.max() >= len(index):  # before any grid of that size is made
        found = f"a profile or face of {index.max():g} in a file of {len(index)} points"
        raise _Unfit(found, "each point of the grid once", "number rows (profile) and columns (face) from 0")
    at = index.astype(int)
    shape = tuple(int(count) for count in at.max(axis=0) + 1)
    places, counts = np.unique(at[:, 0] * shape[1] + at[:, 1], return_counts=True)
    if len(places) != shape[0] * shape[1] or np.any(counts != 1):
        missing = np.flatnonzero(places != np.arange(len(places)))
        first = int(missing[0]) if missing.size else len(places)
        twice = np.flatnonzero(counts[:first] != 1)
        place, fault = (int(twice[0]), f"there {counts[twice[0]]} times") if twice.size else (first, "missing")
        i, j = divmod(place, shape[1])
        fix = "leave the others out" if twice.size else "fill the gap, or leave out its row or column of the grid"
        raise _Unfit(f"point (profile {i}, face {j}) is {fault}", "each point of the grid once", fix)

    def vectors(names: tuple[str, ...]) -> FloatArray:
        values = np.empty((*shape, 3))
        values[at[:, 0], at[:, 1]] = np.column_stack([column[name] for name in names])
        return values

    normals = vectors(_NORMALS) if all(name in column for name in _NORMALS) else None
    return PointGrid(vectors(_COLUMNS[2:]), normals)
