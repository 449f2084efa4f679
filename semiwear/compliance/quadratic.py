"""Quadratic elements along a line: corner and middle nodes in turn."""

from __future__ import annotations

import numpy as np

from semiwear.arrays import FloatArray


def quadratic_values(at: FloatArray) -> FloatArray:
    """Quadratic shape functions on -1 to 1."""
    return np.stack([at * (at - 1.0) / 2.0, 1.0 - at**2, at * (at + 1.0) / 2.0])


def quadratic_slopes(at: FloatArray) -> FloatArray:
    """Their derivatives."""
    return np.stack([at - 0.5, -2.0 * at, at + 0.5])


def quadratic_weights(z: FloatArray, places: FloatArray) -> FloatArray:
    """Weights (places, S) of the nodes z, corners and middles of elements in turn, at given positions."""
    element = np.clip(np.searchsorted(z[::2], places, side="right") - 1, 0, z.size // 2 - 1)
    low, high = z[2 * element], z[2 * element + 2]
    weights = np.zeros((places.size, z.size))
    for k, share in enumerate(quadratic_values(2.0 * (places - low) / (high - low) - 1.0)):
        weights[np.arange(places.size), 2 * element + k] += share
    return weights
