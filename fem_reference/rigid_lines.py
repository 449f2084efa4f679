"""Lines of least gap of rigid, possibly worn flanks, and an estimate of the load on them, for the mesh refinement.

On every cylinder of the gear the gap has one minimum across the tooth; these valleys are the contact line. The
estimate only controls the refinement and the choice of contact candidates. It does not affect results: where it is
wrong, the contact reaches the border of the candidates, which is reported.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import pi

import numpy as np

from fem_reference.arrays import FloatArray
from fem_reference.pair_motion import PairMotion, rounded
from fem_reference.wear import NoWear, WearDepth
from semiwear.errors import ConvergenceError, SceneError
from semiwear.scene import Material, Scene

_FAR = 0.1  # of the flank's height: greater gaps are not distinguished
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
        Roundings of the edges and wear included; infinite where no point lies opposite.
    position : (face, 3) array [mm]
        Fixed frame.
    pinion_profile, pinion_face : arrays [mm]
    spacing : array
        Distance normal to the line per profile coordinate [mm/mm].
    across : (face, heights) array [mm]
        Profile coordinates at which the slice is sampled, evenly spaced.
    gap_across : (face, heights) array [mm]
        The gap there.
    """

    roll: float
    face: FloatArray
    profile: FloatArray
    gap: FloatArray
    position: FloatArray
    pinion_profile: FloatArray
    pinion_face: FloatArray
    spacing: FloatArray
    across: FloatArray
    gap_across: FloatArray

    @property
    def arc(self) -> FloatArray:
        """Length along the line from its first station [mm]."""
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.position, axis=0), axis=1))])

    def half_width(self, rise: FloatArray) -> FloatArray:
        """Half the width of the part less than `rise` (face,) above the valley, in profile coordinates [mm].

        A Hertz contact of line load q closes the gap as far as it rises by 2 q/(pi E*) (Johnson 1985, section 4.2);
        on a ridge left by wear this is narrower than from a mean curvature.
        """
        far = _FAR * float(np.ptp(self.across, axis=1).max())
        above = np.minimum(self.gap_across, far) - np.minimum(self.gap + rise, far)[:, None]
        low, high = np.minimum(above[:, 1:], above[:, :-1]), np.maximum(above[:, 1:], above[:, :-1])
        share = np.clip(-low / np.maximum(high - low, 1e-15), 0.0, 1.0)
        return np.asarray(0.5 * share.sum(axis=1) * (self.across[:, 1] - self.across[:, 0]))

    def farthest(self, rise: FloatArray, middle: FloatArray) -> float:
        """Greatest distance from `middle` (face,) of the part less than `rise` (face,) above the valley [mm].

        In profile coordinates; stations without a rise do not count. Between a ridge and the valley beside it a
        worn line jumps; its touching parts can lie to either side of where a fresh one runs.
        """
        near = (self.gap_across < (self.gap + rise)[:, None]) & (rise > 0.0)[:, None]
        return float(np.abs(self.across - middle[:, None]).max(where=near, initial=0.0))


@dataclass(frozen=True)
class RigidFlank:
    """The gear's flank on a fine grid, from which lines are read.

    Attributes
    ----------
    pair : PairMotion
    wear : WearDepth
    stations, heights : int
        Points along and across the flank.
    """

    pair: PairMotion
    wear: WearDepth = field(default_factory=NoWear)
    stations: int = 81
    heights: int = 161

    @cached_property
    def _grid(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Face stations (S, 1), profile (S, H) and wear (S, H) [mm]; the roundings of the ends are left out."""
        low, high = self.pair.gear_face
        inset = 2.0 * float(self.pair.scene.gear_pair.gear_end_edge_radius_mm)
        face = np.linspace(low + inset, high - inset, self.stations)[:, None]
        tip = self.pair.gear.tip_profile(face)
        profile = self.pair.gear.root_profile + (tip - self.pair.gear.root_profile) * np.linspace(0, 1, self.heights)
        return face, profile, self.wear.depth(np.broadcast_to(face, profile.shape), profile)

    def line(self, roll: float) -> RigidLine:
        """Valley at a roll position."""
        face, profile, worn = self._grid
        met = self.pair.meeting(face, profile, roll)
        smooth = met.gap + worn
        rounding = rounded(self.pair, face, profile, met)
        gap = smooth + rounding
        place = np.argmin(gap, axis=1)
        rows = np.arange(len(place))
        inner = np.clip(place, 1, self.heights - 2)
        left, middle, right = (smooth[rows, inner + k] for k in (-1, 0, 1))
        bend = left - 2.0 * middle + right
        # between grid points only away from tips: the parabola does not represent their roundings
        near = rounding[rows[:, None], inner[:, None] + [-1, 0, 1]]
        free = (place == inner) & (bend > 0.0) & np.isfinite(near[:, 1]) & (near == near[:, 1:2]).all(axis=1)
        shift = np.where(free, 0.5 * (left - right) / np.where(free, bend, 1.0), 0.0)
        step = profile[:, 1] - profile[:, 0]
        best = profile[rows, place] + shift * step
        least = gap[rows, place] - np.where(free, 0.5 * bend * shift**2, 0.0)
        at = self.pair.meeting(face[:, 0], best, roll)
        slope = (met.position[rows, inner + 1] - met.position[rows, inner - 1]) / (2.0 * step[:, None])
        along = np.gradient(at.position, axis=0)
        along /= np.linalg.norm(along, axis=1)[:, None]
        spacing = np.linalg.norm(slope - np.sum(slope * along, axis=1)[:, None] * along, axis=1)
        return RigidLine(
            roll, face[:, 0], best, least, at.position, at.pinion_profile, at.pinion_face, spacing, profile, gap
        )

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
    line_load : dict from pair to (face,) array [N/mm]
    half_width : dict from pair to (face,) array [mm]
        In profile coordinates.
    """

    approach: float
    least: float
    lines: dict[int, RigidLine]
    line_load: dict[int, FloatArray]
    half_width: dict[int, FloatArray]

    def usual_half_width(self, pair: int) -> float:
        """Median half-width by load and width, in profile coordinates, for the size of elements [mm].

        Not the least one: where a line crosses a worn ridge, or two valleys part, few slices are far narrower.
        """
        width = self.half_width[pair]
        order = np.argsort(width)
        carried = np.cumsum((width * self.line_load[pair])[order])
        return float(width[order][np.searchsorted(carried, 0.5 * carried[-1])]) if carried[-1] > 0.0 else 0.0

    def share(self, pair: int) -> float:
        """Estimated share of the load on a pair."""
        return float(self.line_load[pair].sum() / sum(load.sum() for load in self.line_load.values()))


def forecast(lines: Sequence[RigidLine], first: int, force: float, modulus: float) -> Forecast:
    """Winkler foundation along the lines, with the usual stiffness of gear teeth.

    Parameters
    ----------
    lines : sequence of RigidLine
        Pairs first, first + 1, ...
    first : int
    force : float [N]
        Sum of the normal forces.
    modulus : float [MPa]
        Effective modulus E*.

    Raises
    ------
    ConvergenceError
        For a force that would take an approach by more than the height of the flank.
    """
    least = min(float(line.gap.min()) for line in lines)
    stiffness = pi * modulus / _APPROACH
    length = [np.linalg.norm(np.gradient(line.position, axis=0), axis=1) for line in lines]
    rise, borne = np.concatenate([line.gap - least for line in lines]), np.concatenate(length)
    order = np.argsort(rise)[: np.count_nonzero(np.isfinite(rise))]
    rise, borne = rise[order], borne[order]
    # the k lowest stations bear the force at the k-th of these, and those that bear it are the set that needs least
    approach = float(np.min((force / stiffness + np.cumsum(borne * rise)) / np.cumsum(borne)))
    height = max(float(np.ptp(line.across, axis=1).max()) for line in lines)
    if approach > height:
        raise ConvergenceError(
            f"contact: the force would take an approach of {approach:.3g} mm, and the flank is {height:.3g} mm high; "
            "check torque and placement"
        )
    near, loads, widths = {}, {}, {}
    for j, line in enumerate(lines, start=first):
        load = stiffness * np.maximum(approach - (line.gap - least), 0.0)
        if np.min(line.gap) - least < 1.5 * approach:
            near[j], loads[j] = line, load
            widths[j] = line.half_width(2.0 * load / (pi * modulus))
    return Forecast(approach, least, near, loads, widths)


def effective_modulus(scene: Scene) -> float:
    """E* of both materials [MPa] (Johnson 1985, equation 4.5)."""

    def softness(material: Material) -> float:
        return (1.0 - material.poissons_ratio**2) / material.youngs_modulus_MPa

    return 1.0 / (softness(scene.material.pinion) + softness(scene.material.gear))
