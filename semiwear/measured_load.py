"""Measured torque over time, as load spectrum of a scene and as cycles (extra ``loads``).

Wear counts meshes: a second at twice the speed counts twice. A spectrum's torques are means over the meshes of each
level, so that the mean torque, to which wear is about proportional, is that of the measurement for any levels.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from semiwear.arrays import BoolArray, FloatArray
from semiwear.errors import MissingExtraError, Problem, SceneError
from semiwear.plain_text import separator_of
from semiwear.scene.closest import advised_name
from semiwear.scene.values import is_whole, shown
from semiwear.sources import no_pipe
from semiwear.untyped import Table, Value

if TYPE_CHECKING:
    from pandas import DataFrame

_COLUMNS = ("time_s", "torque_Nm", "speed_rpm")
_COLUMN_OF = {"time": "time_s", "speed": "speed_rpm"}
_MOST_LEVELS = 200
_FLANKS = ("drive", "coast")
_ASTM = "ASTM E1049-85(2017), Standard practices for cycle counting in fatigue analysis (rainflow)"


@dataclass(frozen=True)
class MeasuredLoad:
    """Torque over time.

    Attributes
    ----------
    time : array (sample,) [s]
    torque : array (sample,) [N m]
        On the pinion; positive on the drive flank.
    speed : array (sample,) [rev/min]
        Of the pinion; all 1 if it was not measured, so that meshes are proportional to time.
    weight : array (sample,)
        Share of each sample in all meshes, loaded or not.
    """

    time: FloatArray
    torque: FloatArray
    speed: FloatArray
    weight: FloatArray

    def loaded_share(self, flank: str = "drive") -> float:
        """Share of loaded meshes of a flank in all meshes: a life counted in those is this share of a life in all."""
        return float(self.weight[self._on(flank) > 0.0].sum())

    def spectrum(self, levels: int = 20, flank: str = "drive") -> Table:
        """Load spectrum of a flank: the table ``[effects.load_spectrum]``, with `torques_Nm` and `shares`.

        Parameters
        ----------
        levels : int
            Number of equal levels from 0 to the greatest torque; those without samples are left out.
        flank : str
            ``"drive"`` for positive torques, ``"coast"`` for negative ones, taken by magnitude.

        Raises
        ------
        SceneError
            Levels out of range, or no torque on that flank.
        """
        _require_levels(levels, 20)
        torque = self._on(flank)
        bears = (torque > 0.0) & (self.weight > 0.0)
        if not bears.any():
            raise SceneError.of(
                "torque_Nm", f"none on the {flank} flank", "torques of its sign", "exchange the signs?"
            )
        torque, weight = torque[bears], self.weight[bears]
        level = np.minimum((torque / torque.max() * levels).astype(int), levels - 1)
        level_weight = np.bincount(level, weight, levels)
        work = np.bincount(level, weight * torque, levels)
        kept = level_weight > 0.0
        shares = level_weight[kept] / level_weight.sum()
        return {"torques_Nm": (work[kept] / level_weight[kept]).tolist(), "shares": shares.tolist()}

    def cycles(self, levels: int = 64) -> xr.Dataset:
        """Cycles of the torque by rainflow counting, for stress that follows the torque.

        Root stress also goes from zero to its peak in every mesh: those cycles are the meshes of `spectrum`.

        Parameters
        ----------
        levels : int
            Number of equal levels of the range, from 0 to the greatest.

        Returns
        -------
        Dataset
            `count`, mean `range` and mean `mean` [N m] of the cycles of each level that occurs, over `level`.

        Raises
        ------
        SceneError
            Levels out of range.
        MissingExtraError
            rainflow is missing; install the extra ``loads``.
        """
        _require_levels(levels, 64)
        try:
            import rainflow
        except ImportError as error:
            raise MissingExtraError("rainflow", "loads", "counting of cycles") from error
        turns = self.torque[_turning(self.torque)]
        counted = [(rng, mean, count) for rng, mean, count, *_ in rainflow.extract_cycles(turns)]
        if turns.size == 2:  # half a cycle, of a torque that only rises or falls: the package needs a turn
            counted = [(abs(turns[1] - turns[0]), 0.5 * (turns[0] + turns[1]), 0.5)]
        found = np.array(counted).reshape(-1, 3)
        greatest = found[:, 0].max(initial=0.0)
        level = np.clip(np.ceil(found[:, 0] / (greatest or 1.0) * levels).astype(int) - 1, 0, levels - 1)
        count = np.bincount(level, found[:, 2], levels)
        kept = count > 0.0
        means = [np.bincount(level, found[:, 2] * found[:, k], levels)[kept] / count[kept] for k in (0, 1)]
        attrs = {"units": "N m", "references": _ASTM}
        return xr.Dataset(
            {
                "count": ("level", count[kept], {"units": "1", "long_name": "cycles", "references": _ASTM}),
                "range": ("level", means[0], {**attrs, "long_name": "range of the torque, from least to greatest"}),
                "mean": ("level", means[1], {**attrs, "long_name": "mean torque of a cycle"}),
            }
        )

    def _on(self, flank: str) -> FloatArray:
        if flank not in _FLANKS:
            raise SceneError.of("flank", shown(flank), '"drive" or "coast"')
        return self.torque if flank == "drive" else -self.torque


def measured_load(
    torque: str | os.PathLike[str] | DataFrame | Mapping[str, ArrayLike] | ArrayLike,
    *,
    time: ArrayLike | None = None,
    speed: ArrayLike | None = None,
) -> MeasuredLoad:
    """Torque over time, checked.

    Parameters
    ----------
    torque : path, DataFrame, mapping or array_like (sample,)
        A CSV file or a table with the columns `torque_Nm` and, as far as measured, `time_s` and `speed_rpm`; or the
        torque on the pinion [N m].
    time : array_like (sample,), optional
        With an array of torques: rising times [s]. Default: evenly spaced.
    speed : array_like (sample,), optional
        With an array of torques: pinion speed [rev/min], of either sign. Default: constant.

    Returns
    -------
    MeasuredLoad
        Its `spectrum` is the table ``[effects.load_spectrum]`` of a scene.

    Raises
    ------
    SceneError
        With all faults: columns, lengths, missing values, times that do not rise.

    Examples
    --------
    >>> import semiwear as sw
    >>> load = sw.measured_load([100.0, 200.0, -50.0, 300.0])
    >>> [round(torque) for torque in load.spectrum(levels=3)["torques_Nm"]]
    [100, 233]
    """
    columns = _columns(torque, time, speed)
    problems: list[Problem] = []
    read = {name: _numbers(name, values, problems) for name, values in columns.items()}
    lengths = {name: values.size for name, values in read.items()}
    if len(set(lengths.values())) > 1:
        problems.append(Problem("torque_Nm", shown(lengths), "columns of one length", "cut them to the same samples"))
    if read["torque_Nm"].size < 2:
        problems.append(Problem("torque_Nm", read["torque_Nm"].size, "two or more samples", "give a series"))
    steps = np.diff(read["time_s"]) if "time_s" in read else np.ones(1)
    if not problems and steps.min() <= 0.0:
        k = int(np.argmin(steps > 0.0)) + 1
        problems.append(Problem("time_s", f"sample {k + 1} at {read['time_s'][k]:g} s", "rising times", "sort them"))
    if problems:
        raise SceneError(problems, "measured load")
    size = read["torque_Nm"].size
    at = read.get("time_s", np.arange(float(size)))
    turning = np.abs(read.get("speed_rpm", np.ones(size)))
    gaps = np.diff(at)
    # each sample counts for half the distance to its neighbours
    weight = turning * 0.5 * (np.concatenate([gaps, [0.0]]) + np.concatenate([[0.0], gaps]))
    if weight.sum() <= 0.0:
        raise SceneError.of("speed_rpm", "0 throughout", "a pinion that turns", "give its speed, or leave it out")
    return MeasuredLoad(at, read["torque_Nm"], turning, weight / weight.sum())


def _columns(torque: Value, time: ArrayLike | None, speed: ArrayLike | None) -> dict[str, Value]:
    table = isinstance(torque, Mapping | str | os.PathLike) or hasattr(torque, "columns")
    beside = [name for name, values in (("time", time), ("speed", speed)) if values is not None] if table else []
    if beside:
        fix = f"give it as a column {' or '.join(_COLUMN_OF[name] for name in beside)}"
        raise SceneError.of(", ".join(beside), "beside a table of torques", "beside an array of torques", fix)
    if torque is None:
        raise SceneError.of("torque", None, "a file, a table or an array of torques [N m]", "give the series")
    if isinstance(torque, str | os.PathLike):
        torque = _from_file(Path(torque))
    if not table:
        given = {"torque_Nm": torque, "time_s": time, "speed_rpm": speed}
        return {name: values for name, values in given.items() if values is not None}
    names = list(torque.keys())
    problems = [
        Problem(
            str(name), "a column", f"columns {', '.join(_COLUMNS)}", advised_name(str(name), _COLUMNS, "leave it out")
        )
        for name in names
        if name not in _COLUMNS
    ]
    if "torque_Nm" not in names:
        problems.append(Problem("torque_Nm", None, "a column of torques on the pinion in N m", "name it torque_Nm"))
    if problems:
        raise SceneError(problems, "measured load")
    return {str(name): torque[name] for name in names}


def _from_file(path: Path) -> dict[str, FloatArray]:
    try:
        with no_pipe(path).open(encoding="utf-8-sig") as opened:
            head = opened.readline()
            separator = separator_of(head)
            names = [name.strip().strip('"') for name in head.split(separator)]
            # with semicolons or tabs, commas are decimal ones
            numbers = opened if separator == "," else (line.replace(",", ".") for line in opened)
            rows = np.loadtxt(numbers, delimiter=separator, ndmin=2)
    except (OSError, ValueError, UnicodeDecodeError) as error:
        allowed = f"a CSV file: a line with names ({', '.join(_COLUMNS)}), then numbers between commas or semicolons"
        raise SceneError.of("torque", str(path), allowed, str(error)) from None
    if len(set(names)) < len(names):
        raise SceneError.of(
            "torque", f"{path}: {', '.join(names)}", "columns with names of their own", "leave one out"
        )
    if rows.shape[1] != len(names):
        raise SceneError.of("torque", f"{path}: {len(names)} names, {rows.shape[1]} columns", "a name a column")
    return {name: rows[:, k] for k, name in enumerate(names)}


def _numbers(name: str, values: ArrayLike, problems: list[Problem]) -> FloatArray:
    try:
        found: FloatArray = np.ma.filled(np.ma.asarray(values, dtype=float), np.nan)  # masked values are missing
    except (TypeError, ValueError) as error:
        problems.append(Problem(name, shown(values), "numbers", str(error)))
        return np.zeros(0)
    if found.ndim != 1:
        problems.append(Problem(name, f"an array of shape {found.shape}", "one value a sample", "give one series"))
    missing = np.flatnonzero(~np.isfinite(found))
    if missing.size:
        gaps = f"{missing.size} of {found.size} values are not finite, the first in sample {missing[0] + 1}"
        problems.append(Problem(name, gaps, "finite numbers", "fill the gaps, or drop those samples"))
    return found.ravel()


def _require_levels(levels: object, default: int) -> None:
    if not is_whole(levels) or not 1 <= levels <= _MOST_LEVELS:
        raise SceneError.of("levels", shown(levels), f"a whole number, 1 to {_MOST_LEVELS}", f"{default} is usual")


def _turning(values: FloatArray) -> BoolArray:
    """Turning points and ends of a series, of which cycles consist; of equal neighbours the first."""
    keep = np.concatenate([[True], np.diff(values) != 0.0])
    places = np.flatnonzero(keep)
    steps = np.sign(np.diff(values[places]))
    turns = np.ones(places.size, dtype=bool)
    turns[1:-1] = steps[1:] != steps[:-1]
    found = np.zeros(values.size, dtype=bool)
    found[places[turns]] = True
    return found
