"""Grid of the driven flank for its wear depth.

Each slice carries `profile_points` nodes from the root end of its flank to the tip end. Where
the pitch surface crosses the slice, a node lies on it and the spacing may change there, so that the cusp of the wear
at vanishing sliding falls on a grid line and is not smeared.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.kernel_cache import inner_njit
from semiwear.meshing.flank_pair import FlankPair


@dataclass(frozen=True)
class FlankGrid:
    """Nodes of the driven flank; arrays are (face, profile) or (face,).

    Attributes
    ----------
    face : (S,) array [mm]
    profile : (S, P) array [mm]
        Profile coordinate of the nodes, rising from root to tip.
    split : (S,) int array
        Index of the node on the pitch surface; P - 1 where the slice does not cross it.
    """

    face: FloatArray
    profile: FloatArray
    split: IntArray

    def interpolate(self, values: FloatArray, face: float, profile_of_face: FloatArray) -> float:
        """Value at a face coordinate, linear between slices and nodes.

        Parameters
        ----------
        values : (S, P) array
        face : float [mm]
        profile_of_face : (S,) array [mm]
            Profile coordinate in each slice.
        """
        low, weight = self.bracket(face)
        pair = [
            np.interp(profile_of_face[i], self.profile[i], values[i]) for i in (low, min(low + 1, self.face.size - 1))
        ]
        return float((1.0 - weight) * pair[0] + weight * pair[1])

    def bracket(self, face: float) -> tuple[int, float]:
        """Slice below a face coordinate, and the weight of the next one."""
        low, weight = between_stations(self.face, np.array(face))
        return int(low), float(weight)


def between_stations(stations: FloatArray, face: FloatArray) -> tuple[IntArray, FloatArray]:
    """Station below each face coordinate, and the weight of the next one; the end stations apply beyond them.

    Parameters
    ----------
    stations : (S,) array [mm]
        Rising.
    face : array [mm]

    Returns
    -------
    low, weight : arrays like `face`
    """
    place = np.interp(face, stations, np.arange(stations.size, dtype=float))
    low = np.minimum(place.astype(np.int64), max(stations.size - 2, 0))
    return low, place - low


def at_places(nodes: FloatArray, values: FloatArray, places: FloatArray) -> FloatArray:
    """Values on the nodes of every slice, (face, node) both, at places of its lines, (roll, face); linear between."""
    return np.stack([np.interp(places[:, i], nodes[i], values[i]) for i in range(nodes.shape[0])], axis=1)


def at_points(
    stations: FloatArray, nodes: FloatArray, values: FloatArray, face: FloatArray, places: FloatArray
) -> FloatArray:
    """Values at any points of a flank from its nodes; linear between nodes and stations, constant beyond them.

    Parameters
    ----------
    stations : (S,) array [mm]
        Rising; two or more.
    nodes, values : (S, P) arrays
        Profile coordinate [mm] and values of the nodes.
    face, places : arrays of one shape [mm]
        Face and profile coordinates of the points.

    Returns
    -------
    array like `face`
    """
    low, weight = between_stations(stations, face)
    found = np.empty(face.shape)
    for i in np.unique(low):
        on = low == i
        before, after = (np.interp(places[on], nodes[k], values[k]) for k in (i, i + 1))
        found[on] = (1.0 - weight[on]) * before + weight[on] * after
    return found


def flank_grid(pair: FlankPair, face: FloatArray, points: int) -> FlankGrid:
    """Grid with `points` nodes in each slice at the face stations [mm]."""
    borders = pair.borders(face)
    root, tip = borders.root, borders.tip
    pitch = pair.pitch_profile(face)
    fraction = (pitch - root) / (tip - root)
    split = np.clip(np.rint(fraction * (points - 1)), 0, points - 1).astype(np.int64)
    # a slice whose pitch point lies off the flank, or nearer to its end than two nodes, is uniform
    split = np.where((split < 2) | (split > points - 3), points - 1, split)
    index = np.arange(points)
    middle = np.where(split == points - 1, tip, pitch)[:, None]
    k = split[:, None]
    below = root[:, None] + (middle - root[:, None]) * index / k
    above = middle + (tip[:, None] - middle) * (index - k) / np.maximum(points - 1 - k, 1)
    return FlankGrid(face, np.where(index <= k, below, above), split)


@inner_njit(cache=True, error_model="numpy")
def locate(profile, split, place):  # type: ignore[no-untyped-def]
    """Cell and fraction of a place in one slice's nodes; places beyond the nodes count as the ends."""
    last = profile.shape[0] - 1
    if place <= profile[0]:
        return 0, 0.0
    if place >= profile[last]:
        return last - 1, 1.0
    if place < profile[split]:
        x = (place - profile[0]) / (profile[split] - profile[0]) * split
        k = min(int(x), split - 1)
        return k, x - k
    x = (place - profile[split]) / (profile[last] - profile[split]) * (last - split)
    k = min(int(x), last - split - 1)
    return split + k, x - k


@inner_njit(cache=True, error_model="numpy")
def locate_all(profile, split, places, cells):  # type: ignore[no-untyped-def]
    """Cells of several places, which are replaced by their fractions: as `locate`, without branches."""
    last = profile.shape[0] - 1
    low, middle, high = profile[0], profile[split], profile[last]
    for p in range(places.shape[0]):
        place = min(max(places[p], low), high)
        below = place < middle or split == last
        begin, end = (low if below else middle), (middle if below else high)
        count = split if below else last - split
        x = (place - begin) / (end - begin) * count
        k = min(int(x), count - 1)
        cells[p] = k if below else split + k
        places[p] = x - k


@inner_njit(cache=True, error_model="numpy")
def first_from(rising, value):  # type: ignore[no-untyped-def]
    """Index of the first of rising numbers that is not less than a value; their count if all are less.

    By bisection, as `numpy.searchsorted`, whose compilation takes half a second.
    """
    low, high = 0, rising.shape[0]
    while low < high:
        middle = (low + high) // 2
        if rising[middle] < value:
            low = middle + 1
        else:
            high = middle
    return low


@inner_njit(cache=True, error_model="numpy")
def _minmod(a, b):  # type: ignore[no-untyped-def]
    """The smaller of two numbers of one sign; zero if they differ in sign."""
    if a * b <= 0.0:
        return 0.0
    return a if abs(a) < abs(b) else b


@inner_njit(cache=True, error_model="numpy")
def _limited(before, lower, upper, after, upper_weight):  # type: ignore[no-untyped-def]
    """The slope of `slope_at` from the changes over the two cells to either side of a node."""
    bend = upper - lower
    tangent = _minmod(lower + 0.5 * _minmod(lower - before, bend), upper - 0.5 * _minmod(bend, after - upper))
    most = max(3.0 * min(abs(lower), abs(upper)), 1.5 * abs(tangent))
    return min(max(lower + upper_weight * bend, -most), most)


@inner_njit(cache=True, error_model="numpy")
def slope_at(values, nodes, split, node):  # type: ignore[no-untyped-def]
    """Change per cell at a node: that of the parabola through its neighbours, limited so that no new crest arises.

    Per cell below the node; at the first node, per cell above. Zero beside the wall of a groove, the parabola's at
    the smooth top of a ridge: Huynh (1993), monotone cubics accurate at extrema. Three times the smaller change to
    either side is allowed at a top as it is on a slope, where Huynh has the bends beside it alone: a ridge
    of a few cells keeps its slopes, and so does the gap between two worn flanks.
    """
    last = values.shape[0] - 1
    # beyond its ends a row continues straight
    lower = values[node] - values[node - 1] if node > 0 else values[1] - values[0]
    upper = values[node + 1] - values[node] if node < last else lower
    before = values[node - 1] - values[node - 2] if node > 1 else lower
    after = values[node + 2] - values[node + 1] if node < last - 1 else upper
    upper_weight = 0.5
    if split - 1 <= node <= split + 1 and split < last:
        # cells above the split have a width of their own
        wider = (nodes[split + 1] - nodes[split]) / (nodes[split] - nodes[split - 1])
        if node <= split:
            after /= wider
        if node == split:
            upper /= wider
            upper_weight = 1.0 / (1.0 + wider)
        if node > split:
            before *= wider
    return _limited(before, lower, upper, after, upper_weight)


@inner_njit(cache=True, error_model="numpy")
def slopes_between(values, nodes, split, first, end, out):  # type: ignore[no-untyped-def]
    """Fill in `slope_at` of the nodes from `first` up to `end`."""
    last = values.shape[0] - 1
    inner = min(max(first, 2), end)
    stop = max(min(end, last - 1), inner)
    for n in range(first, inner):
        out[n] = slope_at(values, nodes, split, n)
    if inner < stop:
        # parts of arrays: indices that might be negative, from the end, keep the processor from several nodes at once
        near, found = values[inner - 2 : stop + 2], out[inner:stop]
        for n in range(found.shape[0]):
            lower, upper = near[n + 2] - near[n + 1], near[n + 3] - near[n + 2]
            found[n] = _limited(near[n + 1] - near[n], lower, upper, near[n + 4] - near[n + 3], 0.5)
    for n in range(stop, end):
        out[n] = slope_at(values, nodes, split, n)
    if split < last:
        for n in range(max(first, split - 1), min(end, split + 2)):
            out[n] = slope_at(values, nodes, split, n)


@inner_njit(cache=True, error_model="numpy")
def change_above(slope, nodes, split, node):  # type: ignore[no-untyped-def]
    """The change per cell below a node, converted to that per cell above."""
    if node != split or split == nodes.shape[0] - 1:
        return slope
    return slope * (nodes[split + 1] - nodes[split]) / (nodes[split] - nodes[split - 1])


@inner_njit(cache=True, error_model="numpy")
def slopes_of_cell(values, nodes, split, cell):  # type: ignore[no-untyped-def]
    """Changes per cell, of this cell, at both of its nodes."""
    return change_above(slope_at(values, nodes, split, cell), nodes, split, cell), slope_at(
        values, nodes, split, cell + 1
    )


@inner_njit(cache=True, error_model="numpy")
def cubic(a, b, slope_a, slope_b, x):  # type: ignore[no-untyped-def]
    """Value at fraction `x` of a cell whose nodes have values a, b and changes per cell there."""
    y = 1.0 - x
    # a uniform depth is reproduced exactly: a uniformly worn flank has the shape of a fresh one
    return a + (b - a) * x * x * (3.0 - 2.0 * x) + (slope_a * y - slope_b * x) * x * y


@inner_njit(cache=True, error_model="numpy")
def smooth_value(values, nodes, split, cell, x):  # type: ignore[no-untyped-def]
    """Value at fraction `x` of a cell by the cubic with the slopes of its nodes: material removed between nodes.

    Footprints, pressures and patches all use it. Pressure depends on the slope of a gap: between straight pieces
    it would have a peak at every node. With the mean slope everywhere (Catmull and Rom 1974) a crest would rise
    beside a groove by 2/27 of the groove's depth.
    """
    slope_a, slope_b = slopes_of_cell(values, nodes, split, cell)
    return cubic(values[cell], values[cell + 1], slope_a, slope_b, x)
