"""Files with a grid of flank deviations, measured or specified.

Sign: a deviation counts positive for material in excess of the nominal flank, as on the charts of ISO 1328-1. The
flank is set so that its highest material keeps the nominal place: removed depth = greatest deviation - deviation.

Coordinates count from the root to the tip (`profile`) and from the lower to the upper end of the face (`face`),
either as fractions of the flank, 0 to 1 (unit "1"), or as distances from the root end and the lower end (unit "mm").

netCDF (.nc): a variable `deviation` over `profile` and `face` with attribute `units` "um"; coordinates `profile` and
`face`, each with its own `units`, "1" (or none) or "mm".

CSV (.csv), separated by commas, semicolons or tabs; lines that begin with # are skipped:

    um,   0.0, 0.25, 0.5, ...      unit of the deviations, then the face coordinates
    0.0,  1.2, 0.8,  0.3, ...      profile coordinate, then the deviations there
    0.2,  1.0, 0.5,  0.1, ...

The first cell is "um" for fractions, or "um" and the units of profile and face: "um mm mm".
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scipy.interpolate import RectBivariateSpline

from semiwear.arrays import FloatArray
from semiwear.errors import SceneError
from semiwear.plain_text import rows_of
from semiwear.sources import MOST_VALUES, is_netcdf, oversized, read_dataset
from semiwear.targets import file_target, replacing

_LEAST_POINTS = 4  # each way, for a cubic spline
_GREATEST = 5000.0  # um: larger ones come from wrong units
_UM = 1e-3  # mm
_UNITS = ("1", "mm")
_FINER = 8  # points to a cell of the grid in the search for the highest material
_ALLOWED = "a .nc or .csv file with a grid of deviations in um"


@dataclass(frozen=True)
class DeviationGrid:
    """Deviations of a flank on a grid.

    Between grid points a bicubic spline runs through all of them (degree 3 both ways, continuous curvature); beyond
    the measured area the deviation of its border is continued.

    Attributes
    ----------
    profile, face : (P,), (F,) arrays
        Rising coordinates: fractions or distances [mm], see the module.
    deviation : (P, F) array [mm]
        Positive: material in excess.
    profile_unit, face_unit : str
        ``"1"`` or ``"mm"``.
    """

    profile: FloatArray
    face: FloatArray
    deviation: FloatArray
    profile_unit: str = "1"
    face_unit: str = "1"

    @cached_property
    def _spline(self) -> RectBivariateSpline:
        return RectBivariateSpline(self.profile, self.face, self.deviation, kx=3, ky=3, s=0)

    @cached_property
    def highest(self) -> float:
        """Greatest deviation of the measured area [mm]."""
        fine = [
            np.interp(np.arange(_FINER * (c.size - 1) + 1) / _FINER, np.arange(c.size), c)
            for c in (self.profile, self.face)
        ]
        return float(self._spline(*fine).max())

    @property
    def span(self) -> float:
        """Highest less lowest of the given deviations [mm]."""
        return float(np.ptp(self.deviation))

    def removed(
        self, from_root: ArrayLike, profile_length: ArrayLike, from_lower: ArrayLike, face_length: ArrayLike
    ) -> FloatArray:
        """Material removed [mm], at least zero.

        Parameters
        ----------
        from_root, from_lower : arrays that broadcast [mm]
            Distances from the root end and from the lower end of the flank.
        profile_length, face_length : floats or arrays that broadcast with them [mm]
            Extent of the flank there.
        """
        x, x_length, y, y_length = (
            np.asarray(entry, float) for entry in (from_root, profile_length, from_lower, face_length)
        )
        x = x if self.profile_unit == "mm" else x / x_length
        y = y if self.face_unit == "mm" else y / y_length
        x, y = np.broadcast_arrays(x, y)
        inside = np.clip(x, self.profile[0], self.profile[-1]), np.clip(y, self.face[0], self.face[-1])
        return np.asarray(np.maximum(self.highest - self._spline.ev(*inside), 0.0))


def _checked(
    field: str, path: Path, profile: FloatArray, face: FloatArray, deviation: FloatArray, units: tuple[str, str]
) -> DeviationGrid:
    """The grid, after every check; `deviation` in um."""
    name = str(path)
    if profile.ndim != 1 or face.ndim != 1 or deviation.shape != (profile.size, face.size):
        found = f"{deviation.shape} deviations for {profile.size} profile and {face.size} face coordinates"
        raise SceneError.of(
            field, f"{name}: {found}", "one deviation for each pair of coordinates", "complete the grid"
        )
    if min(deviation.shape) < _LEAST_POINTS:
        found = f"{name}: {profile.size} x {face.size} points"
        raise SceneError.of(field, found, f"{_LEAST_POINTS} x {_LEAST_POINTS} points or more", "give a finer grid")
    for axis, values in (("profile", profile), ("face", face), ("deviation", deviation)):
        if not np.all(np.isfinite(values)):
            where = tuple(int(k) for k in np.argwhere(~np.isfinite(values))[0])
            found = f"{name}: {axis} {where} is {float(values[where])}"
            raise SceneError.of(field, found, "finite numbers", "fill the gaps of the grid or cut them off")
    for axis, values, unit in (("profile", profile, units[0]), ("face", face, units[1])):
        if unit not in _UNITS:
            found = f"{name}: {axis} in {unit!r}"
            raise SceneError.of(field, found, '"1" (fractions of the flank) or "mm"', "convert the coordinates")
        if np.any(np.diff(values) <= 0.0):
            fix = "sort the grid, and give each coordinate once"
            raise SceneError.of(field, f"{name}: {axis} coordinates do not grow", "strictly growing coordinates", fix)
        if unit == "1" and (values[0] < -1e-9 or values[-1] > 1.0 + 1e-9):
            found = f"{name}: {axis} from {values[0]:g} to {values[-1]:g}"
            raise SceneError.of(field, found, "fractions of the flank, 0 to 1", 'say "mm" if these are millimetres')
    if np.abs(deviation).max() > _GREATEST:
        found = f"{name}: a deviation of {np.abs(deviation).max():g} um"
        raise SceneError.of(field, found, f"at most {_GREATEST:g} um", "check the units: micrometres are expected")
    return DeviationGrid(profile, face, _UM * deviation, *units)


def read_deviation_grid(path: str | os.PathLike[str], field: str = "deviations") -> DeviationGrid:
    """Read a file of deviations.

    Parameters
    ----------
    path : path
        A .nc or .csv file in the layout of this module.
    field : str
        Key of the scene that names the file, for the error.

    Raises
    ------
    SceneError
        Naming the file, its fault and the remedy.
    """
    file = Path(path)
    _suffix(field, file)
    if not file.is_file():
        raise SceneError.of(field, str(file), _ALLOWED, "no such file; write_deviation_grid makes one")
    return _read_csv(field, file) if file.suffix.casefold() == ".csv" else _read_netcdf(field, file)


def write_deviation_grid(
    path: str | os.PathLike[str],
    profile: ArrayLike,
    face: ArrayLike,
    deviation: ArrayLike,
    *,
    profile_unit: str = "1",
    face_unit: str = "1",
) -> None:
    """Write a file that `read_deviation_grid` reads: .nc or .csv by its name.

    Parameters
    ----------
    path : path
        An existing file is replaced.
    profile, face : (P,), (F,) arrays
        Rising coordinates in their units, ``"1"`` (fractions) or ``"mm"``.
    deviation : (P, F) array [um]
        Positive: material in excess.

    Raises
    ------
    SceneError
        For a grid that could not be read back, or another kind of file.
    """
    file = file_target("path", path, (".nc", ".csv"))
    x, y, z = (np.asarray(entry, float) for entry in (profile, face, deviation))
    _checked("deviations", file, x, y, z, (profile_unit, face_unit))
    with replacing(file) as part:
        if Path(path).suffix.casefold() == ".csv":
            rows = [[f"um {profile_unit} {face_unit}", *map(repr, y.tolist())]]
            rows += [list(map(repr, row)) for row in np.column_stack([x, z]).tolist()]
            part.write_text("".join(",".join(row) + "\n" for row in rows), encoding="utf-8")
        else:
            attrs = {"units": "um", "long_name": "deviation of the flank, positive for material in excess"}
            data = xr.Dataset({"deviation": (("profile", "face"), z, attrs)})
            data = data.assign_coords(
                profile=("profile", x, {"units": profile_unit, "long_name": "from root to tip"}),
                face=("face", y, {"units": face_unit, "long_name": "from the lower to the upper end"}),
            )
            data.to_netcdf(part, engine="netcdf4")


def _suffix(field: str, file: Path) -> None:
    if file.suffix.casefold() not in (".csv", ".nc"):
        raise SceneError.of(field, str(file), _ALLOWED, "name it .nc (netCDF) or .csv, whichever it is")


def _read_netcdf(field: str, file: Path) -> DeviationGrid:
    if not is_netcdf(file):
        raise SceneError.of(field, str(file), _ALLOWED, "it is no netCDF file")
    if found := oversized(file):
        raise SceneError.of(field, f"{file}: {found}", f"at most {MOST_VALUES:.0e} values", "give one flank's grid")
    try:
        data = read_dataset(file)
    except (OSError, ValueError) as error:
        raise SceneError.of(field, str(file), _ALLOWED, f"it cannot be read as netCDF ({error})") from error
    layout = "a variable deviation over profile and face, with both coordinates"
    if "deviation" not in data or set(data["deviation"].dims) != {"profile", "face"}:
        raise SceneError.of(field, f"{file}: no such grid", layout, "write_deviation_grid makes such a file")
    missing = [name for name in ("profile", "face") if name not in data.coords]
    if missing:
        raise SceneError.of(field, f"{file}: no coordinate {missing[0]}", layout, "add the coordinate")
    grid = data["deviation"].transpose("profile", "face")
    unit = str(grid.attrs.get("units", "none"))
    if unit not in ("um", "µm", "μm"):
        raise SceneError.of(field, f"{file}: deviation in units {unit!r}", '"um"', "convert it and set its units")
    try:
        values = [np.asarray(entry.values, dtype=float) for entry in (data["profile"], data["face"], grid)]
    except (TypeError, ValueError) as error:
        raise SceneError.of(field, f"{file}: {error}", "numbers", "write numbers") from error
    units = str(data["profile"].attrs.get("units", "1")), str(data["face"].attrs.get("units", "1"))
    return _checked(field, file, values[0], values[1], values[2], units)


def _read_csv(field: str, file: Path) -> DeviationGrid:
    layout = "first row: um and the face coordinates; other rows: profile coordinate and deviations"
    try:
        text = file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError.of(field, str(file), layout, "it is no UTF-8 text") from error
    try:
        rows = rows_of(text)
    except ValueError as error:
        raise SceneError.of(field, f"{file}: no table ({error})", layout, "write_deviation_grid makes one") from error
    if len(rows) < 2:
        raise SceneError.of(field, f"{file}: {len(rows)} rows", layout, "give a header row and one row per profile")
    words = rows[0][0].split()
    if len(words) not in (1, 3) or words[0] not in ("um", "µm", "μm"):
        fix = 'begin with "um", or "um mm mm" for coordinates in mm'
        raise SceneError.of(field, f"{file}: first cell {rows[0][0]!r}", layout, fix)
    for number, row in enumerate(rows[1:], start=2):
        if len(row) != len(rows[0]):
            found = f"{file}: row {number} has {len(row)} cells, the first {len(rows[0])}"
            raise SceneError.of(field, found, layout, "complete the grid")
    try:
        table = np.array([[float(cell) for cell in row] for row in (["0", *rows[0][1:]], *rows[1:])])
    except ValueError as error:
        raise SceneError.of(field, f"{file}: {error}", "numbers with a decimal point", "correct the cell") from error
    units = (words[1], words[2]) if len(words) == 3 else ("1", "1")
    return _checked(field, file, table[1:, 0], table[0, 1:], table[1:, 1:], units)
