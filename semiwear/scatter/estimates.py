"""Estimates from samples, each with its interval: quantiles, probabilities, Sobol' indices.

Quantiles: an order statistic; the interval is between order statistics that enclose the quantile with at least the
given confidence for any distribution (binomial; David and Nagaraja 2003, Order Statistics, 7.1). Probabilities:
the exact interval of Clopper and Pearson (1934, Biometrika 26, 404-413). Both hold for independent samples; scrambled
Sobol' samples fill their space more evenly, so that the intervals are wider than necessary.

Sobol' indices (Sobol' 2001, Math. Comput. Simul. 55, 271-280): with f(A), f(B) for two independent sets of samples,
f(AB_i) for the first one with field i's values from the second,

    S_i = mean(f(B) (f(AB_i) - f(A))) / V,    S_Ti = mean((f(A) - f(AB_i))^2) / (2 V)

(Saltelli et al. 2010, Comput. Phys. Commun. 181, 259-270; Jansen 1999, ibid. 117, 35-43), V being the variance of
f(A) and f(B) together. Intervals are percentiles of a bootstrap over samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from semiwear.arrays import BoolArray, FloatArray

_RESAMPLES = 500


@dataclass(frozen=True)
class Estimate:
    """A number with its interval.

    Attributes
    ----------
    value, low, high : float
        An end is infinite if the samples are too few for it, and if lives have no end.
    """

    value: float
    low: float
    high: float


def quantile(values: FloatArray, share: float, confidence: float) -> Estimate:
    """The value below which a fraction of all lies.

    Parameters
    ----------
    values : array (sample,)
        One or more, none missing. Infinite ones, of lives without end, count as longer than all others.
    share, confidence : float
        Each above 0 and below 1.
    """
    ordered = np.sort(np.asarray(values, float))
    n, miss = ordered.size, 0.5 * (1.0 - confidence)
    # the k-th least is above the quantile if fewer than k samples are below it: binomial
    low = int(scipy.stats.binom.ppf(miss, n, share))
    high = int(scipy.stats.binom.ppf(1.0 - miss, n, share)) + 1
    # no interpolation between a life and one without end
    method: Literal["median_unbiased", "inverted_cdf"] = (
        "median_unbiased" if np.isfinite(ordered).all() else "inverted_cdf"
    )
    value = float(np.quantile(ordered, share, method=method))
    return Estimate(
        value,
        float(ordered[low - 1]) if low >= 1 else -np.inf,
        float(ordered[high - 1]) if high <= n else np.inf,
    )


def probability(hits: BoolArray, confidence: float) -> Estimate:
    """The probability of a condition, from samples that meet it or not."""
    n, count, miss = hits.size, int(hits.sum()), 0.5 * (1.0 - confidence)
    low = float(scipy.stats.beta.ppf(miss, count, n - count + 1)) if count else 0.0
    high = float(scipy.stats.beta.ppf(1.0 - miss, count + 1, n - count)) if count < n else 1.0
    return Estimate(count / n, low, high)


@dataclass(frozen=True)
class Indices:
    """Fractions of the variance of a quantity.

    Attributes
    ----------
    first_order, total : array (field,)
        Due to a field alone, and to it together with the others.
    first_order_interval, total_interval : array (field, 2)
    """

    first_order: FloatArray
    total: FloatArray
    first_order_interval: FloatArray
    total_interval: FloatArray


def indices(first: FloatArray, second: FloatArray, mixed: FloatArray, confidence: float, seed: int = 0) -> Indices:
    """Sobol' indices of a quantity.

    Parameters
    ----------
    first, second : array (sample,)
        The quantity for two independent sets of samples; rows with a missing or infinite value do
        not count.
    mixed : array (field, sample)
        For the first set with one field's values from the second one.
    confidence : float
    seed : int
        Of the bootstrap.
    """
    whole = np.isfinite(first) & np.isfinite(second) & np.isfinite(mixed).all(axis=0)
    a, b, ab = first[whole], second[whole], mixed[:, whole]
    fields = ab.shape[0]
    none = np.full(fields, np.nan), np.full((fields, 2), np.nan)
    spread = np.ptp(np.concatenate([a, b])) if a.size else 0.0
    if a.size < 4 or spread <= 1e-12 * np.abs(a).max():
        return Indices(none[0], none[0], none[1], none[1])
    # about their middle, since the estimators multiply values that may differ in the last digits only
    middle = 0.5 * (a.mean() + b.mean())
    a, b, ab = (a - middle) / spread, (b - middle) / spread, (ab - middle) / spread
    drawn = np.random.default_rng(seed).integers(0, a.size, (_RESAMPLES, a.size))
    again = np.array([_estimators(a[rows], b[rows], ab[:, rows]) for rows in drawn])
    miss = 0.5 * (1.0 - confidence)
    low, high = np.quantile(again, [miss, 1.0 - miss], axis=0)
    value = _estimators(a, b, ab)
    ends = np.stack([low, high], axis=-1)
    return Indices(value[0], value[1], ends[0], ends[1])


def _estimators(a: FloatArray, b: FloatArray, ab: FloatArray) -> FloatArray:
    """First-order and total indices: (2, field)."""
    variance = np.var(np.concatenate([a, b]))
    if variance == 0.0:  # a bootstrap may draw a single sample only
        return np.zeros((2, ab.shape[0]))
    both = np.stack([np.mean(b * (ab - a), axis=1), 0.5 * np.mean((a - ab) ** 2, axis=1)])
    return np.asarray(both / variance)
