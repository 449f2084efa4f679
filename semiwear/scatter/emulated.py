"""Samples of a scene of which few are solved and the rest emulated, to a required error."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import xarray as xr

from semiwear.arrays import BoolArray, FloatArray
from semiwear.emulator import LEAST_RUNS, emulator_of, kept_by
from semiwear.errors import SemiwearError
from semiwear.scatter.distributions import Distribution, LogNormal
from semiwear.scatter.statistics import quantities_of
from semiwear.sweep.outcome import Status

_RUNS_A_FIELD = 8
_WIDE = 3.0  # greatest over least value of a quantity whose logarithm is emulated
_MOST_LISTED = 8
_SAME = 1e-9  # relative: a quantity that varies by less is constant


def first_solved(fields: int, most: int) -> int:
    """Number of samples that are solved before the first emulator, a power of two; at most `most`."""
    return min(1 << (max(LEAST_RUNS, _RUNS_A_FIELD * (fields + 1)) - 1).bit_length(), most)


def emulated_samples(
    solve: Callable[[int], xr.Dataset],
    values: FloatArray,
    distributions: Mapping[str, Distribution],
    limit: float,
    most: int,
) -> tuple[xr.Dataset, dict[str, float]]:
    """All samples; ever more are solved until the emulator's error of every quantity is within the limit.

    Parameters
    ----------
    solve : callable
        From a number to the dataset of that many first samples, solved.
    values : array (sample, field)
    distributions : mapping
        Of the fields.
    limit : float
        Greatest stated error over the standard deviation of a quantity.
    most : int
        Greatest number of samples to solve.

    Returns
    -------
    samples : Dataset
        With a flag `emulated`.
    errors : dict of str to float
        Stated error of each quantity, in its unit; empty if all samples were solved.

    Raises
    ------
    SemiwearError
        Not all samples may be solved, and the error of a quantity stays above the limit or a life has no end.
    """
    columns = [
        np.log(values[:, k]) if isinstance(distribution, LogNormal) else values[:, k]
        for k, distribution in enumerate(distributions.values())
    ]
    inputs = (
        np.stack([(column - column.mean()) / max(float(column.std()), 1e-300) for column in columns], axis=1) / 2.0
    )
    count = first_solved(inputs.shape[1], most)
    while True:
        found = solve(count)
        if count == len(values):
            return _whole(found, dict(quantities_of(found)), values, distributions), {}
        good = found["status"].values == Status.DONE
        _require_ends(found)
        quantities, errors, shares = _emulated(found, inputs, good)
        far = {name: share for name, share in shares.items() if not share <= limit}
        if not far:
            return _whole(found, quantities, values, distributions), errors
        if 2 * count > most:
            raise SemiwearError(_refusal(far, limit, count))
        count *= 2


def _require_ends(found: xr.Dataset) -> None:
    """Refuse lives without end, which an emulator of the others cannot predict."""
    endless = found["status"].values == Status.ENDLESS
    for _, values in quantities_of(found):  # also of lives that another failure ends
        endless |= np.isinf(values)
    count = int(endless.sum())
    if count:
        raise SemiwearError(
            f"emulate: {count} of {found.sizes['sample']} solved samples wear no further, and their lives have no "
            "end, which no emulator predicts: leave emulate out, or a life out of measure"
        )


def _emulated(
    found: xr.Dataset, inputs: FloatArray, good: BoolArray
) -> tuple[dict[str, FloatArray], dict[str, float], dict[str, float]]:
    """Quantities at all inputs, solved or emulated; stated errors, and their ratios to standard deviations."""
    count, quantities, errors, shares = good.size, dict[str, FloatArray](), dict[str, float](), dict[str, float]()
    for name, own in quantities_of(found):
        known = good & np.isfinite(own)
        if not known.any():
            continue
        y, x = own[known], inputs[:count][known]
        wide = y.min() > 0.0 and y.max() > _WIDE * y.min()
        emulator = emulator_of(x, np.log(y) if wide else y)
        left = y - np.exp(np.log(y) - emulator.left_out) if wide else emulator.left_out
        errors[name], deviation = kept_by(left), float(y.std())
        varies = float(np.ptp(y)) > _SAME * float(np.abs(y).max())
        shares[name] = errors[name] / deviation if varies else 0.0
        at = emulator.at(inputs[count:])
        quantities[name] = np.concatenate([own, np.exp(at) if wide else at])
    return quantities, errors, shares


def _refusal(far: Mapping[str, float], limit: float, count: int) -> str:
    worst = sorted(far, key=lambda name: -far[name])
    listed = ", ".join(f"{name} {far[name]:.2g}" for name in worst[:_MOST_LISTED])
    more = f" and {len(worst) - _MOST_LISTED} more" if len(worst) > _MOST_LISTED else ""
    return (
        f"emulate: after {count} solved samples errors are above {limit:g} of a standard deviation: {listed}{more}; "
        "measure fewer quantities, give more samples, a greater emulate, or leave it out"
    )


def _whole(
    found: xr.Dataset,
    quantities: Mapping[str, FloatArray],
    values: FloatArray,
    distributions: Mapping[str, Distribution],
) -> xr.Dataset:
    """The samples as from `sweep`, without quantities that have more than one value per scene."""
    count, every = found.sizes["sample"], values.shape[0]
    data: dict[str, xr.Variable] = {}
    for name, array in found.data_vars.items():
        columns = _columns(str(name), array, quantities)
        if columns:
            shown = np.stack(columns, axis=-1) if "body" in array.dims else columns[0]
            data[str(name)] = xr.Variable(("sample", "body")[: shown.ndim], shown, array.attrs)
    for name, beyond in (("status", Status.DONE), ("message", ""), ("seconds", np.nan)):
        own = found[name]
        rest = np.full(every - count, beyond, dtype=own.dtype if name != "message" else np.str_)
        data[name] = xr.Variable(("sample",), np.concatenate([own.values, rest]), own.attrs)
    flags = {"units": "1", "long_name": "whether the sample was emulated rather than solved"}
    data["emulated"] = xr.Variable(("sample",), (np.arange(every) >= count).astype(np.int8), flags)
    coords = {
        str(array.name): ("sample", values[:, list(distributions).index(str(array.attrs["field"]))], array.attrs)
        for array in found.coords.values()
        if "field" in array.attrs
    }
    if any("body" in variable.dims for variable in data.values()):
        coords["body"] = ("body", found["body"].values, found["body"].attrs)
    return xr.Dataset(data, {"sample": np.arange(every), **coords}, found.attrs)


def _columns(name: str, array: xr.DataArray, quantities: Mapping[str, FloatArray]) -> Sequence[FloatArray]:
    """All samples of a quantity, a column for each body."""
    if array.dims == ("sample",):
        return [quantities[name]] if name in quantities else []
    if set(array.dims) != {"sample", "body"}:
        return []
    bodies = [f"{name} {body}" for body in map(str, array["body"].values)]
    size = next((quantities[column].size for column in bodies if column in quantities), 0)
    return [quantities.get(column, np.full(size, np.nan)) for column in bodies] if size else []
