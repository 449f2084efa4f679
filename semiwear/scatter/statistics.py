"""Statistics of samples of a scene: quantiles, probabilities, sensitivities, and their convergence."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, field
from functools import cached_property

import numpy as np
import xarray as xr

from semiwear.emulator import CONFIDENCE
from semiwear.errors import SceneError, SemiwearError
from semiwear.plot.sweeps import scene_values
from semiwear.scatter.estimates import Estimate, indices, probability, quantile
from semiwear.scene.closest import advised_name
from semiwear.scene.values import shown
from semiwear.sweep.outcome import Status, has_numbers

SHARES = (0.1, 0.5, 0.9)
"""Probabilities of the quantiles; for a life these are B10, B50, B90."""

_ENDS = {"meshes_to_end": "the life ends", "meshes_to_limit": "the depth that ends the life is reached"}
_LEAST = 8  # samples in the shortest part of a sequence whose quantiles are reported
_SAME = 1e-12  # relative
_REF = "samples of this study"


@dataclass(frozen=True)
class Scatter:
    """Samples of a scene whose fields scatter, solved; made by `scatter`, printed as a table.

    Attributes
    ----------
    samples : Dataset
        Of `sweep`, along `sample`: independent samples first, then those for sensitivities only.
    fields : tuple of str
        Dotted keys of the fields that scatter.
    count : int
        Samples in one set.
    paired : bool
        Whether there are samples for Sobol' indices: a second set, and a further one for each field.
    confidence : float
        Confidence level of all intervals.
    errors : mapping of str to float
        Stated error of every quantity whose samples are emulated in part; intervals are wider by it.
    """

    samples: xr.Dataset
    fields: tuple[str, ...]
    count: int
    paired: bool
    confidence: float
    errors: Mapping[str, float] = field(default_factory=dict)

    @property
    def independent(self) -> int:
        """Number of samples that follow the distributions, independent of each other."""
        return self.count * (2 if self.paired else 1)

    @cached_property
    def quantities(self) -> dict[str, np.ndarray]:
        """Values of every quantity, one per sample; of both bodies as ``"root_stress_max pinion"``."""
        return {name: values for name, values in quantities_of(self.samples) if not np.isnan(values).all()}

    def values(self, name: str) -> np.ndarray:
        """Values of a quantity in the independent samples that were solved; infinite for lives without end.

        Raises
        ------
        SemiwearError
            There is no such quantity, or no sample has it.
        """
        if name not in self.quantities:
            hint = advised_name(name, self.quantities, f"there are {', '.join(self.quantities)}", quoted=True)
            raise SemiwearError(f"no quantity {name!r} in the samples: {hint}")
        found = self.quantities[name][: self.independent]
        return np.asarray(found[~np.isnan(found)])

    def quantile(self, name: str, share: float) -> Estimate:
        """The value below which a fraction of all lies; 0.1 for the life B10.

        Raises
        ------
        SceneError
            For a fraction not between 0 and 1.
        SemiwearError
            As of `values`.
        """
        if not 0.0 < share < 1.0:
            raise SceneError.of("share", shown(share), "above 0 and below 1", "0.1 for the life B10")
        return self._widened(name, quantile(self.values(name), share, self.confidence))

    def _widened(self, name: str, found: Estimate) -> Estimate:
        """An estimate whose interval includes the emulator's error."""
        error = self.errors.get(name, 0.0)
        return Estimate(found.value, found.low - error, found.high + error)

    def probability(self, name: str, *, below: float) -> Estimate:
        """Probability that a quantity is below a value.

        For `meshes_to_limit` it is the probability of reaching the depth of ``[effects.run_life]`` before this number
        of meshes; for `meshes` in a run to control depths that of the last depth.

        Raises
        ------
        SemiwearError
            As of `values`.
        """
        values, error = self.values(name), self.errors.get(name, 0.0)
        ends = [probability(values < bound, self.confidence) for bound in (below - error, below, below + error)]
        return Estimate(ends[1].value, ends[0].low, ends[2].high)

    def reached_before(self, meshes: Sequence[float]) -> xr.Dataset:
        """Probability that the life, or else the run, ends before numbers of meshes.

        `probability`, `probability_low` and `probability_high` over `before_meshes`. The end is the first failure if
        lives end at it, the depth of ``[effects.run_life]`` if other lives were measured, else the run's end; NaN if
        every sample failed.
        """
        name = next((name for name in _ENDS if name in self.quantities), "meshes")
        missing = Estimate(np.nan, np.nan, np.nan)  # if every sample failed
        found = [self.probability(name, below=bound) if self.quantities else missing for bound in meshes]
        columns = np.reshape([astuple(estimate) for estimate in found], (len(found), len(_PARTS))).T
        names = ("probability", "probability_low", "probability_high")
        data = {name: ("before_meshes", column) for name, column in zip(names, columns, strict=True)}
        ends = _ENDS.get(name, "the run ends")
        return xr.Dataset(data, {"before_meshes": np.array(meshes, dtype=float)}, {"ends": ends})

    def quantiles(self, shares: Sequence[float] = SHARES) -> xr.Dataset:
        """Quantiles of every quantity with their intervals: `value`, `low` and `high` over quantity and share.

        `shares` are the fractions below the quantiles, as of `quantile`.
        """
        names = list(self.quantities)
        every = [[astuple(self.quantile(name, share)) for share in shares] for name in names]
        found = np.reshape(every, (len(names), len(shares), len(_PARTS)))
        data = xr.Dataset(
            {part: (("quantity", "share"), found[..., k]) for k, part in enumerate(_PARTS)},
            {
                "quantity": np.array(names, dtype=np.str_),
                "share": list(shares),
                "units": ("quantity", np.array(self._units(names), dtype=np.str_)),
            },
        )
        return data.assign_attrs(confidence=self.confidence, references=_REF)

    @property
    def drawn(self) -> list[int]:
        """Numbers of first samples of a set, for convergence: 8, 16, ... all."""
        return [n for k in range(self.count.bit_length()) if (n := self.count >> k) >= _LEAST][::-1] or [self.count]

    def convergence(self, shares: Sequence[float] = SHARES) -> xr.Dataset:
        """Quantiles from ever more samples: `value`, `low` and `high` over quantity, share and `samples_drawn`."""
        drawn = self.drawn
        names = list(self.quantities)
        found = np.full((len(names), len(shares), len(drawn), len(_PARTS)), np.nan)
        for i, name in enumerate(names):
            for k, count in enumerate(drawn):
                values = self.quantities[name][:count]
                values = values[~np.isnan(values)]
                for j, share in enumerate(shares):
                    if values.size:
                        estimate = self._widened(name, quantile(values, share, self.confidence))
                        found[i, j, k] = astuple(estimate)
        dims = ("quantity", "share", "samples_drawn")
        parts = {part: (dims, found[..., k]) for k, part in enumerate(_PARTS)}
        return xr.Dataset(parts, {"quantity": names, "share": list(shares), "samples_drawn": drawn})

    def indices(self, drawn: int | None = None) -> xr.Dataset:
        """Sobol' indices: fractions of a quantity's variance due to fields, over quantity and field.

        `first_order` by a field alone, `total` with the others, each with `_low` and `_high`; NaN for a quantity that
        does not vary.

        Parameters
        ----------
        drawn : int, optional
            Number of samples of a set, for convergence. Default: all.

        Raises
        ------
        SemiwearError
            The study was made without ``sensitivity=True``.
        """
        if not self.paired:
            raise SemiwearError("no Sobol' indices: set sensitivity=True")
        count, names, fields = self.count, list(self.quantities), list(self.fields)
        rows = slice(0, drawn)
        found = []
        for name in names:
            parts = self.quantities[name].reshape(2 + len(fields), count)[:, rows]
            found.append(indices(parts[0], parts[1], parts[2:], self.confidence))
        dims = ("quantity", "field")
        arrays = {"first_order": [own.first_order for own in found], "total": [own.total for own in found]}
        for k, end in enumerate(("low", "high")):
            arrays[f"first_order_{end}"] = [own.first_order_interval[:, k] for own in found]
            arrays[f"total_{end}"] = [own.total_interval[:, k] for own in found]
        shape = len(names), len(fields)
        data = {name: (dims, np.reshape(values, shape)) for name, values in arrays.items()}
        return xr.Dataset(data, {"quantity": names, "field": fields}).assign_attrs(
            confidence=self.confidence, missing_because="the quantity does not vary from sample to sample"
        )

    def _units(self, names: Sequence[str]) -> list[str]:
        return [str(self.samples[name.partition(" ")[0]].attrs.get("units", "1")) for name in names]

    @property
    def emulation(self) -> str:
        """Numbers of solved and emulated samples, and the meaning of stated errors; empty if all were solved."""
        if not self.errors:
            return ""
        count, within = int(self.samples["emulated"].sum()), f"{100 * CONFIDENCE:.0f} %"
        solved = self.samples.sizes["sample"] - count
        return (
            f"{solved} scenes were solved and {count} emulated; {within} of new ones are within stated errors, and "
            "intervals are wider by these"
        )

    def __str__(self) -> str:
        status = self.samples["status"].values[: self.independent]
        endless = int((status == Status.ENDLESS).sum())
        failed = int((status != Status.DONE).sum()) - endless
        lines = [
            f"{self.independent} samples of {', '.join(self.fields)}"
            + (f"; {failed} failed and do not count" if failed else "")
            + (f"; {endless} wear no further, their lives are longer than all others" if endless else "")
        ]
        share = f"{100.0 * self.confidence:g} %"
        for name, units in zip(self.quantities, self._units(list(self.quantities)), strict=True):
            values = self.values(name)
            if not varies(values, _SAME):
                continue
            quantiles = []
            for level in SHARES:
                found = self.quantile(name, level)
                label = f"B{100 * level:.0f}" if name.startswith(("meshes", "hours")) else f"{100 * level:.0f} %"
                low, high = (end_text(end, values, "{:.4g}".format) for end in (found.low, found.high))
                quantiles.append(f"{label} {end_text(found.value, values, '{:.4g}'.format)} ({low} to {high})")
            unit = "" if units == "1" else f" [{units}]"
            if self.errors:
                quantiles.append(f"emulated within {self.errors[name]:.2g}")
            lines.append(f"{name}{unit}: {', '.join(quantiles)}")
        lines.append(f"in brackets: {share} intervals")
        lines += filter(None, [self.emulation])
        return "\n".join(textwrap.fill(line, 118, subsequent_indent="    ") for line in lines)


def varies(values: np.ndarray, share: float) -> bool:
    """Whether samples of a quantity differ by more than a fraction of the greatest, or are lives without end."""
    if not values.size:
        return False
    return not np.isfinite(values).all() or bool(np.ptp(values) > share * np.abs(values).max())


def end_text(value: float, values: np.ndarray, text: Callable[[float], str]) -> str:
    """A quantile of samples, or an end of its interval, in words if it is infinite."""
    if np.isfinite(value):
        return text(value)
    return "without end" if value > 0.0 and np.isinf(values).any() else "too few samples"


_PARTS = ("value", "low", "high")  # of an `Estimate`, in its order
_NO_QUANTITY = ("status", "message", "seconds", "last_wear_step")


def quantities_of(samples: xr.Dataset) -> Iterator[tuple[str, np.ndarray]]:
    """Quantities of a sweep along `sample` with one value per scene, or per body; NaN if a scene failed."""
    done = has_numbers(samples["status"].values)
    for name in map(str, samples.data_vars):
        array = samples[name]
        if name in _NO_QUANTITY or array.dtype.kind != "f":
            continue
        if array.dims == ("sample",):
            yield name, np.where(done, array.values, np.nan)
        elif set(array.dims) == {"sample", "body"}:
            for body in map(str, array["body"].values):
                yield f"{name} {body}", np.where(done, scene_values(samples, name, body).values, np.nan)
