"""Weights of least squares for a datum that does not follow the wear.

Wear only removes material: worn points lie below the nominal flank, and a plain best fit would follow them and give
too little wear. One-sided weights exclude the points below:

    weight 1 for -2.5 s < r < 2.5 s;  below, (1 - x^2)^2 with x = (-r/s - 2.5)/2.5, and 0 from -5 s;  above, 2.5 s/r

with s the standard deviation of the points above, from the median of their distances (times 1.4826); the fit is
repeated until the weights converge. Below, this is the biweight of Beaton and Tukey (1974, Technometrics 16,
147-185), above the weight of Huber, against dust. A fit through all points would be a stationary point of this
iteration. Therefore s is first reduced in steps from the scatter of that fit to the noise from point to point
(graduated non-convexity: Blake and Zisserman 1987, Visual Reconstruction). The method needs unworn zones: if the
whole flank has worn evenly, wear cannot be distinguished from a rotation of the tooth.
"""

from __future__ import annotations

import numpy as np

from semiwear.arrays import BoolArray, FloatArray

_WHOLE, _NONE = 2.5, 5.0  # standard deviations below the fit: end of weight 1, and begin of weight 0
_MEDIAN = 1.4826  # from the median distance to the standard deviation of a normal distribution
_PASSES = 60
_CHANGE = 1e-6
_LEAST = 1e-9  # mm: a scatter below this is rounding
_SHRINK = 0.7
_HUBER = 1.345


def local_noise(deviation: FloatArray, inside: BoolArray) -> float:
    """Standard deviation of the noise from point to point, from second differences [mm].

    Parameters
    ----------
    deviation, inside : (P, F) arrays
    """
    found = []
    for axis in (0, 1):
        second = np.diff(deviation, 2, axis=axis)
        low, middle, high = (np.take(inside, range(k, inside.shape[axis] - 2 + k), axis=axis) for k in range(3))
        values = np.abs(second[low & middle & high])
        if values.size:
            found.append(_MEDIAN * float(np.median(values)) / np.sqrt(6.0))
    return max(min(found, default=0.0), _LEAST)


def weighted_fit(modes: FloatArray, values: FloatArray, weights: FloatArray) -> FloatArray:
    """Amounts of modes (points, motions) that fit values by weighted least squares, (motions,)."""
    root = np.sqrt(weights)
    return np.asarray(np.linalg.lstsq(root[:, None] * modes, root * values, rcond=None)[0], float)


def one_sided_fit(
    deviation: FloatArray, modes: FloatArray, counts: BoolArray, noise: float
) -> tuple[FloatArray, FloatArray]:
    """Amounts of modes from a one-sided fit to the deviations, and the weights of the points.

    Parameters
    ----------
    deviation : (points,) array [mm]
    modes : (points, motions) array
    counts : (points,) bool array
        Points of the fit.
    noise : float [mm]
        `local_noise`, lower limit of the scatter s.
    """
    weights = counts.astype(float)
    amounts = weighted_fit(modes, deviation, weights)
    scatter = float(np.std((deviation - modes @ amounts)[counts]))
    while scatter > noise:
        scatter *= _SHRINK
        weights = _weights(deviation - modes @ amounts, counts, scatter)
        amounts = weighted_fit(modes, deviation, weights)
    for _ in range(_PASSES):
        rest = deviation - modes @ amounts
        above = rest[counts & (rest > 0.0)]
        scatter = max(_MEDIAN * float(np.median(above)) if above.size else 0.0, noise)
        found = _weights(rest, counts, scatter)
        # damped, so that the weights do not alternate between two sets of points
        changed = float(np.abs(found - weights).max())
        weights = 0.5 * (weights + found)
        amounts = weighted_fit(modes, deviation, weights)
        if changed < _CHANGE:
            break
    return amounts, np.where(weights > _CHANGE, weights, 0.0)


def _weights(rest: FloatArray, counts: BoolArray, scatter: float) -> FloatArray:
    x = np.clip((-rest / scatter - _WHOLE) / (_NONE - _WHOLE), 0.0, 1.0)
    above = np.minimum(1.0, _WHOLE * scatter / np.maximum(rest, _LEAST))
    return np.where(counts, np.where(rest > 0.0, above, (1.0 - x**2) ** 2), 0.0)


def huber_weights(residual: FloatArray, inside: BoolArray, scatter: float | None = None) -> FloatArray:
    """Weights of Huber (1964, Ann. Math. Stat. 35, 73-101), tuned at 1.345 standard deviations; 0 outside.

    The default of the standard deviation is that of the residuals, from their median absolute value.
    """
    size = np.abs(residual)
    deviation = _MEDIAN * float(np.median(size[inside])) if scatter is None else scatter
    weights = np.minimum(1.0, _HUBER * max(deviation, _LEAST) / np.maximum(size, 1e-300))
    return np.where(inside, weights, 0.0)


def huber_loss(residual: FloatArray, scatter: float) -> float:
    """Huber's loss: half the square of the residual over the scatter up to 1.345, linear beyond."""
    x = np.abs(residual) / max(scatter, _LEAST)
    return float(np.sum(np.where(x < _HUBER, 0.5 * x**2, _HUBER * (x - 0.5 * _HUBER))))
