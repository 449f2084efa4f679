"""A fold near a design: the greater of two planes, as where a maximum passes from one point or body to another.

Quantities of a best design are often maxima. At the minimum of a maximum two points of a flank often have the same
value, and a smooth function misses the kink there; two planes fitted to the designs around represent it. Each design
is assigned to the plane that is greater there, and the planes are fitted anew until no design changes its plane
(Magnani and Boyd 2009, Optim. Eng. 10, 1-17).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import BoolArray, FloatArray

_POINTS = 4  # designs for each coefficient of a plane, if there are so many
_ITERATIONS = 20
_STARTS = 12  # directions in which the designs are divided at first
_SEED = 20011


@dataclass(frozen=True)
class Fold:
    """The greater of two planes.

    Attributes
    ----------
    planes : (2, 1 + inputs) array
        Value at the origin, then slopes.
    """

    planes: FloatArray

    def at(self, inputs: FloatArray) -> FloatArray:
        """Values at inputs (n, inputs): (n,)."""
        return np.asarray((_with_one(inputs) @ self.planes.T).max(axis=1))


def fold_near(centre: FloatArray, inputs: FloatArray, values: FloatArray) -> Fold | None:
    """Fold fitted to values (n,) at inputs (n, inputs) around a centre; None if they are too few or on one plane.

    Only the nearest designs count; the weight falls to a half at their median distance.
    """
    coefficients = 1 + inputs.shape[1]
    distances = np.linalg.norm(inputs - centre, axis=1)
    nearest = np.argsort(distances)[: _POINTS * coefficients]
    if nearest.size <= 2 * coefficients:
        return None
    scale = float(np.median(distances[nearest])) or 1.0
    weights = 1.0 / (1.0 + (distances[nearest] / scale) ** 2)
    best, least = None, np.inf
    for direction in np.random.default_rng(_SEED).normal(size=(_STARTS, coefficients - 1)):
        first = (inputs[nearest] - centre) @ direction > 0.0
        fold = _fitted(_with_one(inputs[nearest]), values[nearest], weights, first)
        if fold is None:
            continue
        residual = float((weights * (fold.at(inputs[nearest]) - values[nearest]) ** 2).sum())
        if residual < least:
            best, least = fold, residual
    return best


def _fitted(rows: FloatArray, values: FloatArray, weights: FloatArray, first: BoolArray) -> Fold | None:
    """Fold by least squares, begun with a division into `first` and the rest; None if a plane has too few designs."""
    planes, roots = np.zeros((2, rows.shape[1])), np.sqrt(weights)
    for _ in range(_ITERATIONS):
        for plane, own in zip(planes, (first, ~first), strict=True):
            if own.sum() < rows.shape[1]:
                return None
            plane[:] = np.linalg.lstsq(roots[own, None] * rows[own], roots[own] * values[own], rcond=None)[0]
        greater = np.diff(rows @ planes.T, axis=1)[:, 0] <= 0.0
        if np.array_equal(greater, first):
            break
        first = greater
    return Fold(planes)


def _with_one(inputs: FloatArray) -> FloatArray:
    return np.hstack([np.ones((len(inputs), 1)), inputs])
