"""Grid of the driving flank, and its mating points with the slices of the driven flank."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.kernel_cache import inner_njit, njit
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.finer_grid import FinerGrid, finer_grid
from semiwear.meshing.flank_grid import (
    FlankGrid,
    between_stations,
    change_above,
    cubic,
    locate,
    locate_all,
    slopes_between,
)
from semiwear.meshing.flank_pair import DRIVING, FlankPair
from semiwear.threads import in_loose_shares

_MOST_PARTS = 4  # of a cell of the driven flank
_FOR_SLOPES = 2  # nodes to either side that contribute to the slope at a node
_SAMPLES = 2001  # of the flank's height, to find where it crosses the pitch surface


def driving_grid(pair: FlankPair, face: FloatArray, points: int) -> FlankGrid:
    """Grid of the driving flank with `points` nodes in each slice, one of them on its pitch surface."""
    borders = pair.borders(face)
    root, tip = borders.driving_root, borders.driving_tip
    samples = np.linspace(root, tip, _SAMPLES)
    height, _ = pair.flank_place(DRIVING, np.full(_SAMPLES, face.mean()), samples)
    pitch = float(np.interp(0.0, height, samples))
    split = round((pitch - root) / (tip - root) * (points - 1))
    if 2 <= split <= points - 3:
        nodes = np.append(np.linspace(root, pitch, split, endpoint=False), np.linspace(pitch, tip, points - split))
    else:
        split, nodes = points - 1, np.linspace(root, tip, points)
    shape = (face.size, points)
    return FlankGrid(face, np.ascontiguousarray(np.broadcast_to(nodes, shape)), np.full(face.size, split))


@inner_njit(cache=True, error_model="numpy")
def station_of(face, first, step, stations):  # type: ignore[no-untyped-def]
    """Station below a face coordinate and the weight of the next one; below 0 or above 1 beyond the stations."""
    x = (face - first) / step
    low = min(max(int(np.floor(x)), 0), stations - 2)
    return low, x - low


@inner_njit(cache=True, error_model="numpy")
def _at_station(depth, low, weight, own, split, first, end, here, slope):  # type: ignore[no-untyped-def]
    """Fill in depths between two stations and their slopes at nodes from `first` up to `end`."""
    for n in range(max(first - _FOR_SLOPES, 0), min(end + _FOR_SLOPES, own.shape[0])):
        here[n] = depth[low, n] + weight * (depth[low + 1, n] - depth[low, n])
    slopes_between(here, own, split, first, end, slope)


@inner_njit(cache=True, error_model="numpy")
def _read_depth(here, slope, above_split, split, cells, places):  # type: ignore[no-untyped-def]
    """Replace fractions of cells by depths there, as `smooth_value`; `above_split` is the slope above the split."""
    here_above, slope_above = here[1:], slope[1:]
    for p in range(places.shape[0]):
        cell = np.uint64(cells[p])  # no index from the end: see `slopes_between`
        before = above_split if cells[p] == split else slope[cell]
        places[p] = max(cubic(here[cell], here_above[cell], before, slope_above[cell], places[p]), 0.0)


@njit(cache=True, error_model="numpy", nogil=True)
def _meet(lines, windows, nodes, driven, unworn, faces, own, split, depth, slices, everywhere, out):  # type: ignore[no-untyped-def]
    """Depth of both flanks at nodes in windows; elsewhere that of the driven one alone, if `everywhere`."""
    profile, driving_profile, driving_slope, driving_face = lines
    step = faces[1] - faces[0]
    here, slope, memory = np.empty(own.shape[0]), np.empty(own.shape[0]), np.empty(nodes.shape[1], dtype=np.int64)
    for i in slices:
        before_low, before_weight, known, known_end = -1, 0.0, 0, 0
        for k in range(profile.shape[0]):
            first, end = windows[k, i]
            fresh = unworn[k if unworn.shape[0] > 1 else 0, i]
            if first == end:
                for p in range(driven.shape[1] if everywhere else 0):
                    out[k, i, p] = fresh[p] + driven[i, p]
                continue
            low, weight = station_of(driving_face[k, i], faces[0], step, faces.shape[0])
            weight = min(max(weight, 0.0), 1.0)
            on_line, turns = driving_profile[k, i], driving_slope[k, i]
            start = on_line + turns * (nodes[i, first] - profile[k, i])
            stop = on_line + turns * (nodes[i, end - 1] - profile[k, i])
            lowest, highest = locate(own, split, min(start, stop))[0], locate(own, split, max(start, stop))[0] + 2
            if low != before_low or weight != before_weight or lowest > known_end or highest < known:
                before_low, before_weight, known, known_end = low, weight, lowest, lowest
            # on a spur gear a slice always mates with the same station
            if lowest < known:
                _at_station(depth, low, weight, own, split, lowest, known, here, slope)
                known = lowest
            if highest > known_end:
                _at_station(depth, low, weight, own, split, known_end, highest, here, slope)
                known_end = highest
            at, found, cells = nodes[i, first:end], out[k, i, first:end], memory[first:end]
            for p in range(found.shape[0]):
                found[p] = on_line + turns * (at[p] - profile[k, i])
            locate_all(own, split, found, cells)
            _read_depth(here, slope, change_above(slope[split], own, split, split), split, cells, found)
            both, theirs = fresh[first:end], driven[i, first:end]
            for p in range(found.shape[0]):
                found[p] += both[p] + theirs[p]


@dataclass(frozen=True)
class DrivingFlank:
    """Grid of the driving flank, and the mating points of the slices of all roll positions on it.

    Attributes
    ----------
    grid : FlankGrid
        Nodes of the driving flank; the same in every slice.
    driven : FinerGrid
        Nodes of the driven flank at which the driving one's wear is interpolated.
    lines : ContactLines
    near : (roll, face) bool array
        Slices that can touch.
    """

    grid: FlankGrid
    driven: FinerGrid
    lines: ContactLines
    near: BoolArray

    def met(
        self,
        depth: FloatArray,
        driven: FloatArray,
        unworn: FloatArray,
        slices: IntArray | None = None,
        windows: IntArray | None = None,
        into: FloatArray | None = None,
    ) -> FloatArray:
        """Depth of both flanks at the nodes of `driven` and their mating points, (roll, face, profile) [mm].

        Parameters
        ----------
        depth : (face, profile) array [mm]
            Of the driving flank on `grid`.
        driven : (face, profile) array [mm]
            Wear of the driven flank at the nodes of `driven`.
        unworn : (rows, face, profile) array [mm]
            Material removed from unworn flanks there; one row, or one per roll position.
        slices : int array, optional
            To compute; the others are not filled.
        windows : (roll, face, 2) int array, optional
            First node to compute and the one behind the last; the rest is not filled. By default all nodes, where
            slices that cannot touch have no wear of the driving flank.
        into : array, changed, optional
            Array to reuse for the result.
        """
        lines, shape = self.lines, (*self.lines.profile.shape, self.driven.profile.shape[1])
        out = np.empty(shape) if into is None else into
        everywhere = windows is None
        if windows is None:
            windows = np.stack([np.zeros_like(self.near, dtype=np.int64), np.where(self.near, shape[-1], 0)], axis=-1)
        places = lines.profile, lines.driving_profile, lines.driving_slope, np.ascontiguousarray(lines.driving_face)
        own = self.grid.face, self.grid.profile[0], self.grid.split[0]

        def meet(part: IntArray) -> None:
            _meet(places, windows, self.driven.profile, driven, unworn, *own, depth, part, everywhere, out)

        in_loose_shares(meet, np.arange(shape[1]) if slices is None else slices)
        return out

    def beside(self, slices: IntArray) -> IntArray:
        """Slices whose contacts share stations of the driving flank with some slices, or reach their stations.

        Parameters
        ----------
        slices : int array
            Slices of the driven flank, and stations of the driving one.
        """
        face, stations = self.grid.face, self.grid.face.size
        place = np.clip((self.lines.driving_face - face[0]) / (face[1] - face[0]), 0.0, stations - 1.0)
        below, above = np.floor(place).astype(np.int64), np.ceil(place).astype(np.int64)
        reached = np.zeros(stations, dtype=bool)
        reached[slices] = True
        touching = self.near[:, slices]
        reached[below[:, slices][touching]] = reached[above[:, slices][touching]] = True
        sharing = self.near & (reached[below] | reached[above])
        return np.union1d(slices, np.flatnonzero(sharing.any(axis=0)))


@dataclass(frozen=True, eq=False)
class PassedStations:
    """Interpolation from slices of contact lines to stations of the driving flank; arrays are (roll, station).

    Values in the slices of contact lines belong to face coordinates of the driving flank that differ from its
    stations on a face gear, and where the pinion is displaced along its axis.

    Attributes
    ----------
    lower, upper : int arrays
        Slices whose mating points lie on either side of the station.
    weight : array
        Weight of the upper one; 0 and 1 beyond the first and the last slice.
    passed : bool array
        Whether the station lies within a slice, which reaches half-way to the next one.
    """

    lower: IntArray
    upper: IntArray
    weight: FloatArray
    passed: BoolArray

    @classmethod
    def of(cls, driving_face: FloatArray, stations: FloatArray) -> PassedStations:
        """Position of stations among slices.

        Parameters
        ----------
        driving_face : (roll, face) array [mm]
            Face coordinate of each slice's mating point on the driving flank.
        stations : (station,) array [mm]
            Rising.
        """
        shape, slices = (driving_face.shape[0], stations.size), driving_face.shape[1]
        lower, upper = np.empty(shape, dtype=np.int64), np.empty(shape, dtype=np.int64)
        weight, passed = np.empty(shape), np.empty(shape, dtype=bool)
        for k, unordered in enumerate(driving_face):
            order = np.argsort(unordered, kind="stable")
            met = unordered[order]
            low, weight[k] = between_stations(met, stations)
            lower[k], upper[k] = order[low], order[np.minimum(low + 1, slices - 1)]
            ends = 1.5 * met[0] - 0.5 * met[1], 1.5 * met[-1] - 0.5 * met[-2]
            passed[k] = (ends[0] <= stations) & (stations <= ends[1])
        return cls(lower, upper, weight, passed)

    def read(self, values: FloatArray) -> FloatArray:
        """Values of slices, (roll, face), at the stations; linear between slices."""
        before, after = (np.take_along_axis(values, at, axis=1) for at in (self.lower, self.upper))
        return np.asarray((1.0 - self.weight) * before + self.weight * after)

    def within(self, chosen: BoolArray) -> BoolArray:
        """Stations that lie within chosen slices, (roll, face)."""
        return np.asarray(self.passed & np.take_along_axis(chosen, self._nearest, axis=1))

    def read_within(self, values: FloatArray, chosen: BoolArray) -> FloatArray:
        """As `read`, from chosen slices: linear between two of them, else that of the slice around the station."""
        both = np.take_along_axis(chosen, self.lower, axis=1) & np.take_along_axis(chosen, self.upper, axis=1)
        with np.errstate(invalid="ignore"):  # values that are infinite, or not filled in other slices
            between = self.read(values)
        own = np.take_along_axis(values, self._nearest, axis=1)
        return np.where(both & np.isfinite(between), between, own)

    @property
    def _nearest(self) -> IntArray:
        return np.where(self.weight > 0.5, self.upper, self.lower)


def driving_flank(own: FlankGrid, lines: ContactLines, grid: FlankGrid, near: BoolArray) -> DrivingFlank:
    """The driving flank, and its mating points.

    Parameters
    ----------
    own : FlankGrid
        Of the driving flank, as of `driving_grid`.
    lines : ContactLines
    grid : FlankGrid
        Of the driven flank.
    near : (roll, face) bool array
        Slices that can touch.
    """
    passed = np.abs(lines.driving_slope[near]).max(initial=1.0) * float(np.diff(grid.profile).max())
    parts = int(np.clip(np.rint(passed / float(np.diff(own.profile[0]).min())), 1, _MOST_PARTS))
    rounding = float((lines.high_edge_radius[near] / lines.spacing[near]).max(initial=0.0))
    return DrivingFlank(own, finer_grid(grid, parts, rounding), lines, near)
