"""Wear of a driven flank swept by loaded contact lines.

Archard's law at a point of the flank, integrated over the passage of a contact with the pressure profile w:

    dh = k p |v_s| dt,    p = q w(x)

(Archard 1953; sliding distances after Andersson and Eriksson 1990). Where a line moves over the flank with speed v_n,
the pressure profile drops out, which gives the swept-line identity

    h per mesh = k q |v_s| / v_n.

A line that stands still on a worn ridge, or turns back with the tip of the driving body, leaves a finite depth as
well. So does a line of finite width 2b at the pitch line, where the sliding at its middle vanishes:
k q (4 b/(3 pi)) |dv_s/ds| / v_n. Sliding is evaluated at every point of the footprint and never averaged, so that the
cusp of the wear at the pitch line is as sharp as the contact is narrow.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.contact.edge_share import closed_alone
from semiwear.contact.footprint import Footprints
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.kernel_cache import njit
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.driving_flank import DrivingFlank
from semiwear.meshing.flank_grid import FlankGrid
from semiwear.meshing.flank_pair import DRIVEN, DRIVING, FlankPair
from semiwear.meshing.removed import Removed
from semiwear.meshing.surface_speed import line_speed
from semiwear.wear.deposit import Spread, spread_over_flank
from semiwear.wear.driving_deposit import spread_over_both_flanks
from semiwear.wear.footprint_rows import FootprintRows

_FARTHEST = 0.075  # of the flank's height: slices farther apart come into contact in no step
_STANDSTILL = (
    7.5e-8  # of the flank's height per roll: least speed, since far from contact a line may rest at a border
)


@dataclass(frozen=True)
class Sweep:
    """Motion of the contact lines over the driven flank, in (roll, face) arrays.

    Attributes
    ----------
    place : array [mm]
        Profile coordinate of the line.
    speed : array [mm per unit time]
        Speed v_n of the line on the driven flank.
    direction : array
        -1 where the line moves towards the root, +1 towards the tip.
    sliding : (roll, face, 2) array [mm per unit time]
        Sliding velocity normal to the line, towards the tip, and along it.
    sliding_slope : (roll, face, 2) array
        Derivative of the sliding velocity by the profile coordinate.
    time : (roll,) array
        Duration of each roll position.
    """

    place: FloatArray
    speed: FloatArray
    direction: FloatArray
    sliding: FloatArray
    sliding_slope: FloatArray
    time: FloatArray

    @property
    def specific_sliding(self) -> FloatArray:
        """|v_s| / v_n of the driven body."""
        return np.hypot(self.sliding[..., 0], self.sliding[..., 1]) / self.speed

    @property
    def driving_specific_sliding(self) -> FloatArray:
        """|v_s| / v_n of the driving body, whose v_n is that of the driven body less the sliding."""
        own = np.abs(self.direction * self.speed - self.sliding[..., 0])
        return np.hypot(self.sliding[..., 0], self.sliding[..., 1]) / np.maximum(own, 1e-3 * self.speed)


def _flank_height(lines: ContactLines) -> float:
    """Height of the active driven flank in its profile coordinate [mm]."""
    return float((lines.high - lines.low).max())


def _node_speed(place: FloatArray, lines: ContactLines) -> FloatArray:
    """Mean of the speeds before and after each roll position [mm per roll]."""
    between = np.abs(np.diff(place, axis=0)) / np.diff(lines.roll)[:, None]
    padded = np.concatenate([between[:1], between, between[-1:]])
    return np.asarray(np.maximum(0.5 * (padded[:-1] + padded[1:]), _STANDSTILL * _flank_height(lines)))


def sweep(lines: ContactLines, place: FloatArray, roll_per_time: float) -> Sweep:
    """Motion of contact lines on worn flanks.

    Parameters
    ----------
    lines : ContactLines
        On fresh flanks.
    place : (roll, face) array [mm]
        Profile coordinate of the lines on the worn flanks.
    roll_per_time : float
        Roll positions per unit time.
    """
    return Sweep(
        place=place,
        speed=_node_speed(place, lines) * lines.spacing * roll_per_time,
        direction=np.sign(np.gradient(place, axis=0)),
        sliding=lines.sliding + lines.sliding_slope * (place - lines.profile)[..., None],
        sliding_slope=lines.sliding_slope,
        time=np.gradient(lines.roll) / roll_per_time,
    )


def worn_sweep(teeth: LoadedTeeth, state: LoadedState) -> Sweep:
    """Motion of the contact lines of a state on its worn flanks, on the fine roll grid."""
    places = teeth.fine_places(state.wear, state.driving_wear, state.touched)
    return sweep(teeth.fine, places, teeth.pair.roll_per_time)


@lru_cache(maxsize=4)
def fresh_sweep(pair: FlankPair, lines: ContactLines) -> Sweep:
    """Motion of contact lines on fresh flanks at any roll positions; cached, so the arrays must not be changed."""
    speed, direction = line_speed(pair, lines)
    return Sweep(
        place=lines.profile,
        speed=np.maximum(speed, _STANDSTILL * _flank_height(lines) * lines.spacing) * pair.roll_per_time,
        direction=direction,
        sliding=lines.sliding,
        sliding_slope=lines.sliding_slope,
        time=np.gradient(lines.roll) / pair.roll_per_time if lines.roll.size > 1 else np.ones(1),
    )


class EdgeShares(NamedTuple):
    """Load shares of edges in the previous cycle, updated from cycle to cycle of a step.

    Attributes
    ----------
    edges : (roll, face, 4) array, changed
        As in `share_of_edge`.
    most : (face,) array [mm]
        Greatest wear in the previous cycle.
    """

    edges: FloatArray
    most: FloatArray

    @classmethod
    def unknown(cls, shape: tuple[int, ...]) -> EdgeShares:
        """Shares before the first cycle."""
        return cls(np.zeros((*shape, 4)), np.zeros(shape[1]))

    def after(self, wear: FloatArray) -> EdgeShares:
        """The same shares after wear, (face,) [mm]."""
        return self._replace(most=wear)


def _spread_of(motion: Sweep, line_load: FloatArray, modulus: float, edges: EdgeShares | None) -> Spread:
    rate, closes = line_load * motion.time[:, None], closed_alone(line_load, modulus)
    known = edges or EdgeShares.unknown(line_load.shape)
    return Spread(motion.place, rate, motion.sliding, motion.sliding_slope, closes, *known)


def wear_of_mesh(
    lines: ContactLines,
    grid: FlankGrid,
    removed: Removed,
    motion: Sweep,
    line_load: FloatArray,
    half_width: float,
    modulus: float,
    slices: IntArray | None = None,
    taken: FloatArray | None = None,
    edges: EdgeShares | None = None,
    rows: FootprintRows | None = None,
) -> FloatArray:
    """Sum of p |v_s| dt over one mesh, on the nodes of the flank [N/mm].

    Parameters
    ----------
    lines : ContactLines
    grid : FlankGrid
    removed : Removed
        Material removed from the flanks, which determines the footprints.
    motion : Sweep
    line_load : (roll, face) array [N/mm]
    half_width : float [mm]
        Reference half-width of the footprints.
    modulus : float [MPa]
        Effective modulus E*, for the load shares of pressed edges.
    slices : int array, optional
        Slices to evaluate; the others stay zero.
    taken : (2,) array, changed, optional
        Force times sliding distance of one mesh is added to the first element, the part of it on the roundings of tip
        and ends to the second [N mm].
    edges : EdgeShares, optional
        Of the previous cycle; changed.
    rows : FootprintRows, changed, optional
        Every footprint is added to its row.

    Returns
    -------
    (face, profile) array [N/mm]
        Times the wear coefficient it is the wear of one mesh.
    """
    spread = _spread_of(motion, line_load, modulus, edges)
    if slices is None:
        slices = np.arange(grid.face.size)
    return spread_over_flank(lines, grid, removed, half_width, spread, slices, taken, rows)


def wear_of_both_flanks(
    lines: ContactLines,
    grid: FlankGrid,
    driving: DrivingFlank,
    removed: Removed,
    motion: Sweep,
    line_load: FloatArray,
    half_width: float,
    modulus: float,
    slices: IntArray,
    taken: FloatArray | None = None,
    edges: EdgeShares | None = None,
    rows: tuple[FootprintRows, FootprintRows] | None = None,
) -> tuple[FloatArray, FloatArray]:
    """As `wear_of_mesh` for the driving and the driven flank, each over one mesh of one of its teeth [N/mm].

    `taken`, (2, 2), and `rows` are those of the driving and of the driven flank.
    """
    spread = _spread_of(motion, line_load, modulus, edges)
    return spread_over_both_flanks(lines, grid, driving, removed, half_width, spread, slices, taken, rows)


@njit(cache=True, error_model="numpy")
def _own_wear(place, distance, growth, fades, farthest, weight, sliding, time, width, out):  # type: ignore[no-untyped-def]
    rolls, faces = place.shape
    for i in range(faces):
        for k in range(rolls):
            if distance[k, i] > farthest:
                continue
            # between roll positions the line moves: a narrower footprint does not overlap more positions
            step = 0.5 * abs(place[min(k + 1, rolls - 1), i] - place[max(k - 1, 0), i])
            own = max(width[k, i], 0.5 * step)
            total = 0.0
            for j in range(rolls):
                late = distance[j, i] - max(distance[k, i], growth)
                if late > fades:
                    continue
                d = (place[k, i] - place[j, i]) / (2.0 * own)
                if abs(d) < 1.0:
                    # overlap of two pressure profiles: close to the autocorrelation of the semi-ellipse, of area 1
                    overlap = 35.0 / 64.0 / own * (1.0 - d * d) ** 3 * time[j] * sliding[j, i]
                    if late > 0.0:
                        overlap *= (1.0 + 2.0 * late / fades) * (1.0 - late / fades) ** 2
                    total += overlap
            out[k, i] = total * weight[k, i]


def own_wear(
    lines: ContactLines,
    motion: Sweep,
    worn: Footprints,
    distance: FloatArray,
    growth: float,
    body: int = DRIVEN,
    fades: float = 0.0,
) -> FloatArray:
    """Implicit wear compliance: gap worn by one mesh, per unit force on a slice and wear coefficient [1/mm].

    |v_s| / v_n over the length of the slice where a line moves. Roll positions at which the slice comes into contact
    within the step, or no later than at the present one, are assumed to carry the same load.

    Parameters
    ----------
    lines : ContactLines
    motion : Sweep
    worn : Footprints
    distance : (roll, face) array [mm]
        Gap less approach: negative in contact. Open slices have a compliance as well, since a long step may bring
        them into contact.
    growth : float [mm]
        Approximate growth of the approach by the end of the step.
    body : int
        Body whose flank wears.
    fades : float [mm]
        Roll positions that come into contact later by up to this distance count in part, so that the result is a
        smooth function of the distances.
    """
    out = np.zeros(distance.shape)
    sliding = np.hypot(motion.sliding[..., 0], motion.sliding[..., 1])
    place, spacing = motion.place, lines.spacing
    if body == DRIVING:
        place = lines.on_driving(place)
        spacing = spacing / np.abs(lines.driving_slope)
    _own_wear(
        place, distance, growth, fades, _FARTHEST * _flank_height(lines), 1.0 / (spacing * lines.length), sliding,
        motion.time, worn.half_width / spacing, out,
    )  # fmt: skip
    return out
