"""Local cubic interpolation on uneven nodes."""

from __future__ import annotations

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.kernel_cache import inner_njit

CUBIC = 4
"""Neighbouring nodes of a cubic, where there are as many nodes."""


@inner_njit(cache=True, error_model="numpy")
def cubic_at(place, nodes, weights, slopes):  # type: ignore[no-untyped-def]
    """Index of the first neighbouring node of a point; writes the weights of the neighbours and their derivatives.

    Parameters
    ----------
    place : float
    nodes : (count,) array
    weights, slopes : (neighbours,) arrays, changed
    """
    count, width = nodes.shape[0], weights.shape[0]
    inside, first = min(max(place, nodes[0]), nodes[count - 1]), 0
    while first < count - width and nodes[first + width // 2] <= inside:
        first += 1
    for a in range(width):
        value, slope = 1.0, 0.0
        for b in range(width):
            if b != a:
                scale = 1.0 / (nodes[first + a] - nodes[first + b])
                slope = (slope * (inside - nodes[first + b]) + value) * scale
                value = value * (inside - nodes[first + b]) * scale
        weights[a], slopes[a] = value, slope
    return first


@inner_njit(cache=True, error_model="numpy")
def _at_all(places, nodes, local, weights, slopes):  # type: ignore[no-untyped-def]
    for i in range(places.shape[0]):
        first = cubic_at(places[i], nodes, local[0], local[1])
        for a in range(local.shape[1]):
            weights[i, first + a], slopes[i, first + a] = local[0, a], local[1, a]


def cubic_weights(place: FloatArray, nodes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Weights of local cubic interpolation on growing nodes, and their derivatives by `place`.

    Between two inner nodes the cubic interpolates the four around them, at the ends the last four;
    points beyond the ends count as the ends, with their slopes.
    """
    places, own = np.ascontiguousarray(place, float).reshape(-1), np.ascontiguousarray(nodes, float)
    weights, slopes = np.zeros((2, places.size, own.size))
    _at_all(places, own, np.empty((2, min(CUBIC, own.size))), weights, slopes)
    return weights.reshape(*place.shape, -1), slopes.reshape(*place.shape, -1)
