"""Samples of a scene of which few are solved and the rest emulated, as far as the emulator is good enough."""

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

__all__ = ["emulated_samples", "first_solved"]

_RUNS_A_FIELD = 8
_WIDE = 3.0  # greatest over least value of a quantity whose logarithm is emulated
_MOST_TOLD = 8
_SAME = 1e-9  # relative: a quantity that varies by less is one number


def first_solved(fields: int, most: int) -> int:
    """Number of samples that are solved before the first emulator, a power of two; at most `most`."""
    return min(1 << (max(LEAST_RUNS, _RUNS_A_FIELD * (fields + 1)) - 1).bit_length(), most)


def emulated_samples(
    solve: Callable[[int], xr.Dataset],
    values: FloatArray,
    distributions: Mapping[str, Distribution],
    asked: float,
    most: int,
) -> tuple[xr.Dataset, dict[str, float]]:
    """All samples, of which some are solved, ever more until every quantity is emulated as well as asked.

    Parameters
    ----------
    solve : callable
        From a number to the dataset of so many first samples, solved.
    values : array (sample, field)
    distributions : mapping
        Of the fields.
    asked : float
        Stated error over the standard deviation of a quantity.
    most : int
        Samples that are solved at most.

    Returns
    -------
    samples : Dataset
        With `emulated` saying which are.
    errors : dict of str to float
        Stated error of each quantity, in its unit; empty where all samples were solved.

    Raises
    ------
    SemiwearError
        The error of a quantity stays above what was asked, or a life has no end.
    """
    columns = [
        np.log(values[:, k]) if isinstance(one, LogNormal) else values[:, k]
        for k, one in enumerate(distributions.values())
    ]
    inputs = np.stack([(one - one.mean()) / max(float(one.std()), 1e-300) for one in columns], axis=1) / 2.0
    count = first_solved(inputs.shape[1], most)
    while True:
        found = solve(count)
        good = found["status"].values == Status.DONE
        _require_ends(found)
        told, errors, shares = _emulated(found, inputs, good)
        far = {name: share for name, share in shares.items() if not share <= asked}
        if not far:
            whole = _whole(found, told, values, distributions)
            return whole, errors if count < len(values) else {}
        if 2 * count > most:
            raise SemiwearError(_refusal(far, asked, count))
        count *= 2


def _require_ends(found: xr.Dataset) -> None:
    """Refuse lives without end: no emulator of the others tells where they lie."""
    endless = found["status"].values == Status.ENDLESS
    for _, values in quantities_of(found):  # also of lives that another failure ends
        endless |= np.isinf(values)
    count = int(endless.sum())
    if count:
        raise SemiwearError(
            f"emulate: {count} of {found.sizes['sample']} solved samples wear no further, and their lives have no "
            "end, which no emulator tells: leave emulate out, or a life out of measure"
        )


def _emulated(
    found: xr.Dataset, inputs: FloatArray, good: BoolArray
) -> tuple[dict[str, FloatArray], dict[str, float], dict[str, float]]:
    """Quantities at all inputs, the solved ones as they are; stated errors, and those over standard deviations."""
    count, told, errors, shares = good.size, dict[str, FloatArray](), dict[str, float](), dict[str, float]()
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
        told[name] = np.concatenate([own, np.exp(at) if wide else at])
    return told, errors, shares


def _refusal(far: Mapping[str, float], asked: float, count: int) -> str:
    worst = sorted(far, key=lambda name: -far[name])
    listed = ", ".join(f"{name} {far[name]:.2g}" for name in worst[:_MOST_TOLD])
    more = f" and {len(worst) - _MOST_TOLD} more" if len(worst) > _MOST_TOLD else ""
    return (
        f"emulate: after {count} solved samples errors are above {asked:g} of a standard deviation: {listed}{more}; "
        "measure only what you need, ask for more samples (as many may be solved), allow more, or leave emulate out"
    )


def _whole(
    found: xr.Dataset, told: Mapping[str, FloatArray], values: FloatArray, distributions: Mapping[str, Distribution]
) -> xr.Dataset:
    """The samples as `sweep` would give them, but for quantities that have more than a value a scene."""
    count, every = found.sizes["sample"], values.shape[0]
    data: dict[str, xr.Variable] = {}
    for name, array in found.data_vars.items():
        columns = _columns(str(name), array, told)
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
    if any("body" in one.dims for one in data.values()):
        coords["body"] = ("body", found["body"].values, found["body"].attrs)
    return xr.Dataset(data, {"sample": np.arange(every), **coords}, found.attrs)


def _columns(name: str, array: xr.DataArray, told: Mapping[str, FloatArray]) -> Sequence[FloatArray]:
    """All samples of a quantity, one column a body."""
    if array.dims == ("sample",):
        return [told[name]] if name in told else []
    if set(array.dims) != {"sample", "body"}:
        return []
    bodies = [f"{name} {body}" for body in map(str, array["body"].values)]
    size = next((told[one].size for one in bodies if one in told), 0)
    return [told.get(one, np.full(size, np.nan)) for one in bodies] if size else []
