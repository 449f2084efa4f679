"""Local cubic interpolation on uneven nodes."""

from __future__ import annotations

import numpy as np

from semiwear.arrays import FloatArray

__all__ = ["cubic_weights"]


def cubic_weights(place: FloatArray, nodes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Weights of local cubic interpolation on growing nodes, and their derivatives by `place`.

    Between two inner nodes the cubic runs through the four around them; at the ends through the last four, and
    places beyond the ends count as the ends.
    """
    count = len(nodes)
    width = min(4, count)
    inside = np.clip(place, nodes[0], nodes[-1])
    first = np.clip(np.searchsorted(nodes, inside, side="right") - width // 2, 0, count - width)
    local = nodes[first[..., None] + np.arange(width)]
    weights = np.zeros((*place.shape, count))
    slopes = np.zeros((*place.shape, count))
    for a in range(width):
        value = np.ones_like(inside)
        slope = np.zeros_like(inside)
        for b in range(width):
            if b != a:
                scale = 1.0 / (local[..., a] - local[..., b])
                slope = (slope * (inside - local[..., b]) + value) * scale
                value = value * (inside - local[..., b]) * scale
        np.put_along_axis(weights, (first + a)[..., None], value[..., None], axis=-1)
        np.put_along_axis(slopes, (first + a)[..., None], slope[..., None], axis=-1)
    return weights, slopes
