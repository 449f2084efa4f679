"""Unknown fields of a scene: their priors, cut off at both ends, and their coordinates in samplers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import ndtr

from semiwear.arrays import FloatArray
from semiwear.scatter.distributions import Distribution, LogNormal
from semiwear.sweep.names import short_names

COEFFICIENT = "wear.coefficient_mm2_per_N"
CUT = 0.002
"""Fraction of a prior that is cut off at either end: emulators do not reach farther."""


@dataclass(frozen=True)
class Unknown:
    """One unknown field.

    Attributes
    ----------
    key : str
    prior : Distribution
    short : str
        Its name in the inference, if that is more than the last part of its key.
    """

    key: str
    prior: Distribution
    short: str = ""

    @property
    def name(self) -> str:
        """Part of its key that distinguishes it from others."""
        return self.short or self.key.rpartition(".")[2]

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Least and greatest value."""
        low, high = self.prior.quantile(np.array([CUT, 1.0 - CUT]))
        return float(low), float(high)

    @property
    def ratio(self) -> bool:
        """Whether its values are compared by ratios rather than by differences."""
        return isinstance(self.prior, LogNormal) or self.ends[0] > 0.0

    def values(self, normal: FloatArray) -> FloatArray:
        """Values from numbers that are standard normal under the prior."""
        return self.prior.quantile(CUT + (1.0 - 2.0 * CUT) * ndtr(normal))

    def places(self, values: FloatArray) -> FloatArray:
        """Places within the range, -1 to 1; of ratios for a log-normal prior."""
        low, high = self._scale(np.array(self.ends))
        return np.asarray(2.0 * (self._scale(values) - low) / (high - low) - 1.0)

    def at(self, places: FloatArray) -> FloatArray:
        """Values at places: the inverse of `places`."""
        low, high = self._scale(np.array(self.ends))
        found = low + 0.5 * (places + 1.0) * (high - low)
        return np.asarray(np.clip(np.exp(found) if isinstance(self.prior, LogNormal) else found, *self.ends))

    def _scale(self, values: FloatArray) -> FloatArray:
        return np.asarray(np.log(values) if isinstance(self.prior, LogNormal) else values, float)


@dataclass(frozen=True)
class Unknowns:
    """All unknown fields of an inference.

    Attributes
    ----------
    every : tuple of Unknown
    coefficient : float
        Wear coefficient of the scene [mm2/N]: that of runs.
    """

    every: tuple[Unknown, ...]
    coefficient: float

    @property
    def keys(self) -> tuple[str, ...]:
        """Dotted keys."""
        return tuple(unknown.key for unknown in self.every)

    @property
    def solved(self) -> tuple[int, ...]:
        """Indices of those on which a run depends: all but the wear coefficient."""
        return tuple(k for k, unknown in enumerate(self.every) if unknown.key != COEFFICIENT)

    def values(self, normal: FloatArray) -> FloatArray:
        """Values (point, field) from numbers that are standard normal under the priors."""
        return np.stack([unknown.values(normal[:, k]) for k, unknown in enumerate(self.every)], axis=1)

    def inputs(self, values: FloatArray) -> FloatArray:
        """Inputs of a model (point, field) at values (point, unknown)."""
        found = [self.every[k].places(values[:, k]) for k in self.solved]
        return np.stack(found, axis=1) if found else np.zeros((values.shape[0], 0))

    def stretch(self, values: FloatArray) -> FloatArray:
        """Wear coefficient over that of runs, (point,)."""
        for k, unknown in enumerate(self.every):
            if unknown.key == COEFFICIENT:
                return np.asarray(values[:, k] / self.coefficient)
        return np.ones(values.shape[0])

    @property
    def greatest_stretch(self) -> float:
        """Greatest wear coefficient over that of runs."""
        return max((own.ends[1] / self.coefficient for own in self.every if own.key == COEFFICIENT), default=1.0)


def unknowns_of(priors: Mapping[str, Distribution], coefficient: float) -> Unknowns:
    """Unknown fields with valid priors."""
    names = short_names(priors)
    return Unknowns(tuple(Unknown(key, prior, names[key]) for key, prior in priors.items()), coefficient)
