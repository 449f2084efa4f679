"""Where rigid, possibly worn flanks come nearest, and a rough forecast of the load there: what the meshes follow.

On every cylinder of the gear the gap has one least value across the tooth; these valleys are the contact line. The
forecast only steers the refinement and the choice of nodes that may touch. It decides no result: where it is wrong,
the contact reaches the border of the chosen nodes, and that is reported.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from fem_reference.kinematics import PairKinematics
from fem_reference.wear import NoWear, WearDepth
from semiwear.errors import ConvergenceError, SceneError

__all__ = ["Forecast", "RigidFlank", "RigidLine", "forecast"]

FloatArray = NDArray[np.float64]

_WIDTH = 0.4  # mm to either side of the valley over which its curvature is taken
_APPROACH = 14.0  # approach of loaded gear teeth, tooth bending included, times pi E* over the line load: usual value
_FARTHEST = 3  # neighbours looked at on either side


@dataclass(frozen=True)
class RigidLine:
    """Valley of the gap of one tooth pair; arrays are (face,).

    Attributes
    ----------
    roll : float
        Roll position of the pair.
    face, profile : arrays [mm]
        Place on the gear.
    gap : array [mm]
        Roundings of the edges and wear included; infinite where nothing is opposite.
    curvature : array [1/mm]
        Of the gap across the line.
    position : (face, 3) array [mm]
        Fixed frame.
    pinion_profile, pinion_face : arrays [mm]
    """

    roll: float
    face: FloatArray
    profile: FloatArray
    gap: FloatArray
    curvature: FloatArray
    position: FloatArray
    pinion_profile: FloatArray
    pinion_face: FloatArray


@dataclass(frozen=True)
class RigidFlank:
    """The gear's flank on a fine grid, from which lines are read.

    Attributes
    ----------
    pair : PairKinematics
    wear : WearDepth
    stations, heights : int
        Points along and across the flank.
    """

    pair: PairKinematics
    wear: WearDepth = field(default_factory=NoWear)
    stations: int = 81
    heights: int = 161

    @cached_property
    def _grid(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Face stations (S, 1), profile (S, H) and wear (S, H) [mm]; the ends are just inside the edges."""
        low, high = self.pair.gear_face
        face = np.linspace(low, high, self.stations)[:, None]
        tip = self.pair.gear.tip_profile(face)
        profile = self.pair.gear.root_profile + (tip - self.pair.gear.root_profile) * np.linspace(0, 1, self.heights)
        return face, profile, self.wear.depth(np.broadcast_to(face, profile.shape), profile)

    def line(self, roll: float) -> RigidLine:
        """Valley at a roll position."""
        face, profile, worn = self._grid
        met = self.pair.meeting(face, profile, roll)
        smooth = met.gap + worn
        rounded = self.pair.rounding(face, profile, met)
        gap = smooth + rounded
        place = np.argmin(gap, axis=1)
        rows = np.arange(len(place))
        inner = np.clip(place, 1, self.heights - 2)
        left, middle, right = (smooth[rows, inner + k] for k in (-1, 0, 1))
        bend = left - 2.0 * middle + right
        # between grid points only where no edge is near: the parabola knows nothing of roundings
        free = (
            (place == inner) & (bend > 0.0) & (rounded[rows[:, None], inner[:, None] + [-1, 0, 1]] == 0.0).all(axis=1)
        )
        shift = np.where(free, 0.5 * (left - right) / np.where(free, bend, 1.0), 0.0)
        step = profile[:, 1] - profile[:, 0]
        best = profile[rows, place] + shift * step
        least = gap[rows, place] - np.where(free, 0.5 * bend * shift**2, 0.0)
        at = self.pair.meeting(face[:, 0], best, roll)
        reach = np.maximum(np.rint(_WIDTH / step).astype(int), 1)
        middles = np.clip(place, reach, self.heights - 1 - reach)
        curvature = (smooth[rows, middles - reach] - 2.0 * smooth[rows, middles] + smooth[rows, middles + reach]) / (
            reach * step
        ) ** 2
        curvature = np.maximum(curvature, 1e-3)
        return RigidLine(roll, face[:, 0], best, least, curvature, at.position, at.pinion_profile, at.pinion_face)

    def least_gap(self, mesh_position: float) -> float:
        """Least gap of all pairs at a mesh position [mm]: minus the unloaded lead of the gear."""
        least = min(float(line.gap.min()) for line in self.lines(mesh_position))
        if not np.isfinite(least):
            raise SceneError.of(
                "placement", self.pair.placement, "flanks that face each other",
                "no contact is possible: at no point of the gear's flank does the pinion lie opposite",
            )  # fmt: skip
        return least

    def lines(self, mesh_position: float) -> list[RigidLine]:
        """Valleys of all pairs that could matter."""
        return [self.line(mesh_position + j) for j in range(-_FARTHEST, _FARTHEST + 1)]


@dataclass(frozen=True)
class Forecast:
    """Expected loads of the pairs at a mesh position.

    Attributes
    ----------
    approach : float [mm]
        Beyond first touch.
    least : float [mm]
        Gap at first touch.
    lines : dict from pair to RigidLine
        Those that are expected to carry load.
    line_load, half_width : dicts from pair to (face,) array [N/mm], [mm]
    """

    approach: float
    least: float
    lines: dict[int, RigidLine]
    line_load: dict[int, FloatArray]
    half_width: dict[int, FloatArray]


def forecast(lines: Sequence[RigidLine], first: int, force: float, modulus: float) -> Forecast:
    """Winkler's bed along the lines, as stiff as gear teeth usually are.

    Parameters
    ----------
    lines : sequence of RigidLine
        Pairs first, first + 1, ...
    first : int
    force : float [N]
        Sum of the normal forces.
    modulus : float [MPa]
        Effective modulus E*.
    """
    least = min(float(line.gap.min()) for line in lines)
    stiffness = pi * modulus / _APPROACH
    length = [np.linalg.norm(np.gradient(line.position, axis=0), axis=1) for line in lines]

    def carried(approach: float) -> float:
        closed = [np.maximum(approach - (line.gap - least), 0.0) for line in lines]
        return stiffness * sum(float(c @ one) for c, one in zip(closed, length, strict=True)) - force

    upper = 1e-3
    while carried(upper) < 0.0:
        upper *= 2.0
        if upper > 10.0:
            raise ConvergenceError("contact: no load is carried within 10 mm of approach; check torque and placement")
    approach = float(brentq(carried, 0.0, upper))
    near, loads, widths = {}, {}, {}
    for j, line in enumerate(lines, start=first):
        load = stiffness * np.maximum(approach - (line.gap - least), 0.0)
        if np.min(line.gap) - least < 1.5 * approach:
            near[j], loads[j] = line, load
            widths[j] = np.sqrt(4.0 * load / (pi * modulus * line.curvature))
    return Forecast(approach, least, near, loads, widths)
