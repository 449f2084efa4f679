"""Wear of a driven flank that loaded contact lines sweep over.

Archard's law at a point of the flank, summed while a contact of Hertz pressure passes:

    dh = k p |v_s| dt,    p = q 2/(pi b) sqrt(1 - x^2/b^2)

(Archard 1953; sliding distances after Andersson and Eriksson 1990). Where a line moves on with speed v_n over the
flank the width b drops out and this is the swept-line identity

    h per mesh = k q |v_s| / v_n.

A line that stands still on a worn ridge, or turns back with the tip of the driving body, leaves a finite depth as
well. |v_s| is taken as the line passes the point, so that the zero of sliding at the pitch line stays a cusp.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from semiwear.contact.worn_lines import WornLines
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import FlankGrid

__all__ = ["Sweep", "deposit", "own_wear", "sweep", "wear_per_mesh"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_SUBSTEPS = 4  # between roll positions, whose lines lie about a third of a Hertz width apart
_STANDSTILL = 1e-6  # mm per roll; far from any contact a line may stand still at a border


def wear_per_mesh(line_load: FloatArray, specific_sliding: FloatArray, wear_coefficient: float) -> FloatArray:
    """Wear depth that one mesh leaves where the line passes.

    Parameters
    ----------
    line_load : array [N/mm]
    specific_sliding : array
        |v_s| / v_n of the body.
    wear_coefficient : float [mm^2/N]

    Returns
    -------
    array [mm]
    """
    return wear_coefficient * line_load * specific_sliding


@dataclass(frozen=True)
class Sweep:
    """Motion of the contact lines over the driven flank; arrays are (roll, face).

    Attributes
    ----------
    place : array [mm]
        Profile coordinate of the line.
    free : array [mm]
        Where it would lie if slices had no ends.
    speed : array [mm per unit time]
        v_n of the driven body.
    sliding : (roll, face, 2) array [mm per unit time]
        Sliding velocity normal to the line and along it.
    sliding_on_path : (roll, face, 2) array
        Its change per profile coordinate while the line moves on.
    time : (roll,) array
        Time that a roll position stands for.
    """

    place: FloatArray
    free: FloatArray
    speed: FloatArray
    sliding: FloatArray
    sliding_on_path: FloatArray
    time: FloatArray

    @property
    def specific_sliding(self) -> FloatArray:
        """|v_s| / v_n of the driven body."""
        return np.hypot(self.sliding[..., 0], self.sliding[..., 1]) / self.speed

    @property
    def partner_specific_sliding(self) -> FloatArray:
        """|v_s| / v_n of the driving body: its line moves like the driven body's less the sliding."""
        direction = np.sign(np.gradient(self.place, axis=0))
        own = np.abs(direction * self.speed - self.sliding[..., 0])
        return np.hypot(self.sliding[..., 0], self.sliding[..., 1]) / np.maximum(own, 1e-3 * self.speed)


def _node_speed(locus: FloatArray, roll: FloatArray) -> FloatArray:
    """Mean of the speeds before and after each roll position [mm per roll]."""
    between = np.abs(np.diff(locus, axis=0)) / np.diff(roll)[:, None]
    padded = np.concatenate([between[:1], between, between[-1:]])
    return np.maximum(0.5 * (padded[:-1] + padded[1:]), _STANDSTILL)


def _sliding_along_path(lines: ContactLines) -> FloatArray:
    """Change of the sliding velocity per profile coordinate while the fresh line moves on: (roll, face, 2)."""
    inside = (lines.profile > lines.low) & (lines.profile < lines.high)
    step = np.zeros_like(lines.profile)
    change = np.zeros_like(lines.sliding)
    step[1:-1] = lines.profile[2:] - lines.profile[:-2]
    change[1:-1] = lines.sliding[2:] - lines.sliding[:-2]
    moving = np.zeros_like(inside)
    moving[1:-1] = inside[2:] & inside[1:-1] & inside[:-2]
    safe = np.where(moving, step, 1.0)
    return np.where(moving[..., None], change / safe[..., None], lines.sliding_slope)


def sweep(lines: ContactLines, worn: WornLines, roll_per_time: float) -> Sweep:
    """Motion of worn contact lines; `roll_per_time` is roll positions per unit time."""
    return Sweep(
        place=worn.profile,
        free=worn.free,
        speed=_node_speed(worn.locus, lines.roll) * lines.spacing * roll_per_time,
        sliding=lines.sliding + lines.sliding_slope * (worn.profile - lines.profile)[..., None],
        sliding_on_path=_sliding_along_path(lines),
        time=np.gradient(lines.roll) / roll_per_time,
    )


@njit(cache=True)
def _deposit(  # type: ignore[no-untyped-def]
    free, low, high, rate, sliding_0, sliding_1, path_0, path_1, time, nodes, width, slices, out
):
    rolls = free.shape[0]
    points = nodes.shape[1]
    for i in slices:
        w = width[i]
        first, last = nodes[i, 0], nodes[i, points - 1]
        for k in range(rolls - 1):
            if rate[k, i] == 0.0 and rate[k + 1, i] == 0.0:
                continue
            for sub in range(_SUBSTEPS):
                x = (sub + 0.5) / _SUBSTEPS
                y = 1.0 - x
                # the line and the borders each move evenly; the turn between them is sharp
                at = min(y * free[k, i] + x * free[k + 1, i], y * high[k, i] + x * high[k + 1, i])
                at = max(at, y * low[k, i] + x * low[k + 1, i])
                q = (y * rate[k, i] + x * rate[k + 1, i]) * (y * time[k] + x * time[k + 1]) / _SUBSTEPS
                s0 = y * sliding_0[k, i] + x * sliding_0[k + 1, i]
                s1 = y * sliding_1[k, i] + x * sliding_1[k + 1, i]
                t0 = y * path_0[k, i] + x * path_0[k + 1, i]
                t1 = y * path_1[k, i] + x * path_1[k + 1, i]
                # what would fall off either end is mirrored back, as the contact feels the flank there
                for image in range(3):
                    middle = at
                    if image == 1:
                        middle = 2.0 * first - at
                    elif image == 2:
                        middle = 2.0 * last - at
                    if middle + w <= first or middle - w >= last:
                        continue
                    p = np.searchsorted(nodes[i], middle - w)
                    while p < points and nodes[i, p] < middle + w:
                        d = (nodes[i, p] - middle) / w
                        share = 2.0 / (np.pi * w) * max(1.0 - d * d, 0.0) ** 0.5
                        away = nodes[i, p] - at
                        v0, v1 = s0 + t0 * away, s1 + t1 * away
                        out[i, p] += q * share * (v0 * v0 + v1 * v1) ** 0.5
                        p += 1


def deposit(
    grid: FlankGrid,
    lines: ContactLines,
    motion: Sweep,
    line_load: FloatArray,
    half_width: float,
    slices: IntArray | None = None,
) -> FloatArray:
    """Sum of p |v_s| dt over one mesh, on the nodes of the flank [N/mm].

    Parameters
    ----------
    grid : FlankGrid
    lines : ContactLines
    motion : Sweep
    line_load : (roll, face) array [N/mm]
    half_width : float [mm]
        Hertz half-width over which each line load is spread; the result depends on it only where lines stand
        still, turn, or change their load within it.
    slices : int array, optional
        Slices to do; the others stay zero.

    Returns
    -------
    (face, profile) array [N/mm]
        Times the wear coefficient it is the wear of one mesh.
    """
    out = np.zeros(grid.profile.shape)
    if slices is None:
        slices = np.arange(grid.face.size)
    _deposit(
        motion.free, lines.low, lines.high, line_load / lines.spacing,
        np.ascontiguousarray(motion.sliding[..., 0]), np.ascontiguousarray(motion.sliding[..., 1]),
        np.ascontiguousarray(motion.sliding_on_path[..., 0]), np.ascontiguousarray(motion.sliding_on_path[..., 1]),
        motion.time, grid.profile, half_width / np.mean(lines.spacing, axis=0), slices, out,
    )  # fmt: skip
    return out


@njit(cache=True)
def _own_wear(locus, loaded, weight, sliding, time, width, out):  # type: ignore[no-untyped-def]
    rolls, faces = locus.shape
    for i in range(faces):
        reach = 2.0 * width[i]
        for k in range(rolls):
            if not loaded[k, i]:
                continue
            total = 0.0
            for j in range(rolls):
                if not (loaded[j, i] or j == k):
                    continue
                d = (locus[k, i] - locus[j, i]) / reach
                if abs(d) < 1.0:
                    # pressure felt by pressure: close to the semi-ellipse correlated with itself, of area one
                    total += 35.0 / 64.0 / width[i] * (1.0 - d * d) ** 3 * time[j]
            out[k, i] = total * weight[k, i] * sliding[k, i]


def own_wear(
    lines: ContactLines, motion: Sweep, loaded: NDArray[np.bool_], half_width: float
) -> FloatArray:
    """Wear of one mesh, as the line itself will feel it, per force on a slice and wear coefficient [1/mm].

    |v_s| / v_n over the length of the slice where a line moves on: the implicit term of a wear step. Neighbouring
    roll positions are taken to carry the same load.

    Parameters
    ----------
    lines : ContactLines
    motion : Sweep
    loaded : (roll, face) bool array
        Slices that carry load now; only they wear what others feel.
    half_width : float [mm]
        As in `deposit`.
    """
    out = np.zeros(loaded.shape)
    sliding = np.hypot(motion.sliding[..., 0], motion.sliding[..., 1])
    _own_wear(
        motion.place, loaded, 1.0 / (lines.spacing * lines.length), sliding, motion.time,
        half_width / np.mean(lines.spacing, axis=0), out,
    )  # fmt: skip
    return out
