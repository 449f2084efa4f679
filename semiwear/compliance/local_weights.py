"""Compliance between points with non-zero weights on a few neighbouring load heights, sections and splines only."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.compliance.cubics import CUBIC
from semiwear.kernel_cache import njit


class LocalWeights(NamedTuple):
    """Weights of points on neighbouring nodes; P points, w neighbours.

    Attributes
    ----------
    first : (P,) int array
        First node of each point.
    values : (P, w) array
        Weights of that node and the next ones.
    slopes : (P, w) array
        Their derivatives by the driven flank's profile coordinate [1/mm].
    """

    first: IntArray
    values: FloatArray
    slopes: FloatArray

    @classmethod
    def of(cls, weights: FloatArray, slopes: FloatArray | None = None) -> LocalWeights:
        """From weights (..., nodes) with at most four neighbouring non-zero entries; slopes default to zero."""
        count = weights.shape[-1]
        span = min(CUBIC, count)
        flat = weights.reshape(-1, count)
        slope = np.zeros_like(flat) if slopes is None else slopes.reshape(-1, count)
        first = np.minimum(np.argmax((flat != 0.0) | (slope != 0.0), axis=1), count - span)
        nodes = first[:, None] + np.arange(span)
        return cls(first, np.take_along_axis(flat, nodes, axis=1), np.take_along_axis(slope, nodes, axis=1))

    def at(self, points: IntArray) -> LocalWeights:
        """Weights of some points."""
        return LocalWeights(self.first[points], self.values[points], self.slopes[points])


@njit(cache=True, error_model="numpy", nogil=True)
def seen_by_points(table, heights, sections, cosine):  # type: ignore[no-untyped-def]
    """Deflection at points by unit loads at every height and harmonic, and below its derivative: (2 n, N H) array.

    Parameters
    ----------
    table : (B, H, N H) array
        [section, observer's height, harmonic and load height].
    heights, sections : LocalWeights
        Of n points.
    cosine : (n, N) array
    """
    count, width = heights.first.size, table.shape[2]
    harmonics = cosine.shape[1]
    loads = width // harmonics
    out = np.zeros((2 * count, width))
    for i in range(count):
        value, slope = out[i], out[count + i]
        for b in range(sections.values.shape[1]):
            for h in range(heights.values.shape[1]):
                row = table[sections.first[i] + b, heights.first[i] + h]
                w = sections.values[i, b] * heights.values[i, h]
                w_slope = sections.values[i, b] * heights.slopes[i, h]
                for c in range(width):
                    value[c] += w * row[c]
                    slope[c] += w_slope * row[c]
        for n in range(harmonics):
            for c in range(n * loads, (n + 1) * loads):
                value[c] *= cosine[i, n]
                slope[c] *= cosine[i, n]
    return out


@njit(cache=True, error_model="numpy", nogil=True)
def between_points(table, count, heights, splines, observers, loads):  # type: ignore[no-untyped-def]
    """Compliance between points by a table on heights and splines, and below its derivative: (2 n, m) array.

    Parameters
    ----------
    table : (H S, H S) array
        [load, observer], both height after height.
    count : int
        Number S of splines.
    heights, splines : LocalWeights
        Of all points.
    observers, loads : (n,), (m,) int arrays
        Points.
    """
    n, size = observers.size, table.shape[1]
    out = np.zeros((2 * n, loads.size))
    answer = np.empty(size)  # of every observer to one point's load
    for j in range(loads.size):
        load = loads[j]
        answer[:] = 0.0
        for h in range(heights.values.shape[1]):
            for s in range(splines.values.shape[1]):
                w = heights.values[load, h] * splines.values[load, s]
                row = table[(heights.first[load] + h) * count + splines.first[load] + s]
                for c in range(size):
                    answer[c] += w * row[c]
        for i in range(n):
            point = observers[i]
            value, slope = 0.0, 0.0
            for h in range(heights.values.shape[1]):
                at = (heights.first[point] + h) * count + splines.first[point]
                along = 0.0
                for s in range(splines.values.shape[1]):
                    along += splines.values[point, s] * answer[at + s]
                value += heights.values[point, h] * along
                slope += heights.slopes[point, h] * along
            out[i, j], out[n + i, j] = value, slope
    return out
