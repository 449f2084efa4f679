"""A fold near a design: the greater of two planes, as the worst of two places or bodies makes it.

Quantities of a best design are often greatest values. Where the least of one lies two places are often as bad, and no
smooth function sees the floor of the fold there; two planes through the designs around do. Each of these belongs to
the plane that is the greater one there, by turns until none changes (Magnani and Boyd 2009, Optim. Eng. 10, 1-17).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import BoolArray, FloatArray

_POINTS = 4  # designs for each number of a plane, as far as there are
_TURNS = 20
_STARTS = 12  # directions in which the designs are parted at first
_SEED = 20011


@dataclass(frozen=True)
class Fold:
    """The greater of two planes.

    Attributes
    ----------
    planes : (2, 1 + inputs) array
        Value at the origin and slopes.
    """

    planes: FloatArray

    def at(self, inputs: FloatArray) -> FloatArray:
        """Values at inputs (n, inputs): (n,)."""
        return np.asarray((_with_one(inputs) @ self.planes.T).max(axis=1))


def fold_near(centre: FloatArray, inputs: FloatArray, values: FloatArray) -> Fold | None:
    """The fold through values (n,) at inputs (n, inputs) around a centre; None where these are too few, or one plane.

    What is as far away as half of the designs around counts half as much.
    """
    numbers = 1 + inputs.shape[1]
    away = np.linalg.norm(inputs - centre, axis=1)
    near = np.argsort(away)[: _POINTS * numbers]
    if near.size <= 2 * numbers:
        return None
    scale = float(np.median(away[near])) or 1.0
    weights = 1.0 / (1.0 + (away[near] / scale) ** 2)
    best, least = None, np.inf
    for direction in np.random.default_rng(_SEED).normal(size=(_STARTS, numbers - 1)):
        first = (inputs[near] - centre) @ direction > 0.0
        fold = _fitted(_with_one(inputs[near]), values[near], weights, first)
        missed = np.inf if fold is None else float((weights * (fold.at(inputs[near]) - values[near]) ** 2).sum())
        if missed < least:
            best, least = fold, missed
    return best


def _fitted(rows: FloatArray, values: FloatArray, weights: FloatArray, first: BoolArray) -> Fold | None:
    """The fold whose planes go through those that belong to the first one, and the others; None where one has few."""
    planes, roots = np.zeros((2, rows.shape[1])), np.sqrt(weights)
    for _ in range(_TURNS):
        for plane, mine in zip(planes, (first, ~first), strict=True):
            if mine.sum() < rows.shape[1]:
                return None
            plane[:] = np.linalg.lstsq(roots[mine, None] * rows[mine], roots[mine] * values[mine], rcond=None)[0]
        greater = np.diff(rows @ planes.T, axis=1)[:, 0] <= 0.0
        if np.array_equal(greater, first):
            break
        first = greater
    return Fold(planes)


def _with_one(inputs: FloatArray) -> FloatArray:
    return np.hstack([np.ones((len(inputs), 1)), inputs])
