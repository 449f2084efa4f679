"""Contact problem of all tooth pairs: lines, compliance, torque, and which slices may touch.

For every mesh position: forces F >= 0 on the slices of all pairs and one rotation phi of the driving body with

    gap + C F - a phi >= 0,   F (gap + C F - a phi) = 0,   sum of a F = torque

(a: lever arms). C is the contact compliance of each line, plus the tooth compliance of both bodies with its coupling
to neighbouring teeth, plus, in a wear step, the wear per force.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import ceil, log2, pi
from typing import NamedTuple

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.compliance.elastic_teeth import CompliantBody, ElasticTeeth, PointCompliance
from semiwear.compliance.slice_compliance import SliceCompliance
from semiwear.contact.footprint import Footprints
from semiwear.contact.loads import TeethLoads
from semiwear.contact.patch_gap import PatchCells
from semiwear.contact.stripe import NearPairs, add_far_stripe, less_aside, near_pairs, subtract_mid_surface
from semiwear.errors import ConvergenceError, SceneError
from semiwear.kernel_cache import njit
from semiwear.meshing.contact_lines import ContactLines

_LEAST_DEPTH = 1.5  # half-widths: under a contact as wide as the tooth, so that the compliance stays positive
_WIDE = 0.25  # of the height of a flank: contact wider than this is no half-space's any more
_NEAR_FIELD = 12.0  # half-widths; beyond, the width of a stripe has no effect
FIRST_CAP = 3.5
"""Typical approaches within which slices may touch at first."""
_ROOM = 1.5  # times that first range: candidates for typical wear, too
_RUNGS = 2  # levels of the candidates' separation for each factor of two
_FARTHEST_ASIDE = 0.67  # of the depth of the mid-surface: up to there its displacement falls with the square
_FARTHEST_MOVE = 0.083  # of the base pitch: up to there tooth compliance follows a worn line linearly


def usual_approach(line_load: float, modulus: float) -> float:
    """Order of the approach of loaded teeth [mm]: 14 q/(pi E*)."""
    return 14.0 * line_load / (pi * modulus)


def _least_separation(lines: ContactLines) -> FloatArray:
    """Least fresh separation of each slice [mm], (roll, face).

    Where the line is held at a border the flanks come nearer still on the rounding of the edge: least where the arc
    has turned by as much as they are inclined to each other.
    """
    slope = lines.separation[1] / lines.spacing
    nearer = np.hypot(1.0, slope) - 1.0
    at_low = np.where((lines.profile <= lines.low) & (slope > 0.0), nearer * lines.low_edge_radius, 0.0)
    at_high = np.where((lines.profile >= lines.high) & (slope < 0.0), nearer * lines.high_edge_radius, 0.0)
    return np.asarray(lines.separation[0] - np.maximum(at_low, at_high))


def _mid_surface(teeth: PointCompliance, least: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Depth of the mid-surface below the points, (1 + nu)/(2 pi E) and nu, of each body."""
    return (
        np.maximum(teeth.depth, least),
        np.array([(1.0 + body.poissons_ratio) / (2.0 * pi * body.youngs_modulus) for body in teeth.elastic]),
        np.array([body.poissons_ratio for body in teeth.elastic]),
    )


@njit(cache=True, error_model="numpy", nogil=True)
def picked(matrix, slope, chosen, moved):  # type: ignore[no-untyped-def]
    """Part of a symmetric matrix between chosen points, each moved [mm]; `slope`: change of row i by its move."""
    out = np.empty((chosen.size, chosen.size))
    for i in range(chosen.size):
        for j in range(i + 1):
            change = slope[chosen[i], chosen[j]] * moved[i] + slope[chosen[j], chosen[i]] * moved[j]
            out[i, j] = out[j, i] = matrix[chosen[i], chosen[j]] + change
    return out


class Candidates(NamedTuple):
    """Slices that may touch at a mesh position, and their compliance.

    Attributes
    ----------
    cap : float [mm]
        Fresh separation below which a slice is a candidate.
    flat : (n,) int array
        Flat indices of the candidates in (roll, face) arrays.
    starts : (lines + 1,) int array
        First candidate of each contact line.
    smooth : (n, n) array [mm/N]
        Compliance between slices as a whole: tooth compliance less the half-space displacement at
        the mid-surface.
    static : (n, n) array [mm/N]
        The same and the far field of the stripe kernel.
    slope : (n, n) array [mm/N/mm]
        Change of row i when point i moves.
    pairs : NearPairs
        Pairs of slices whose stripe kernel is not in `static`.
    aside : (m, m) array [mm/N/mm^2]
        `less_aside` between all n; no rows if pressure is not resolved across the lines.
    farthest_aside : (n,) array [mm]
        Distance from a footprint, across the line, up to which `slope` and `aside` hold.
    least, profile, lever, length, arc : (n,) arrays [mm]
        Least fresh separation, profile coordinate, lever arm, length, position along the line.
    farthest_move : float [mm]
        Displacement of a worn line up to which tooth compliance is linear.
    """

    cap: float
    flat: IntArray
    starts: IntArray
    smooth: FloatArray
    static: FloatArray
    slope: FloatArray
    pairs: NearPairs
    aside: FloatArray
    farthest_aside: FloatArray
    least: FloatArray
    profile: FloatArray
    lever: FloatArray
    length: FloatArray
    arc: FloatArray
    farthest_move: float

    def deflection(self, slices: IntArray, force: FloatArray, worn: Footprints) -> FloatArray:
        """Deflection of some candidates where they lie on the worn flank, (n,) [mm], apart from the near field.

        Parameters
        ----------
        slices : (n,) array
            Which of the candidates.
        force : (roll, face) array [N]
        worn : Footprints
        """
        on, limit = force.ravel()[self.flat], self.farthest_move
        moved = np.clip(worn.profile.ravel()[self.flat] - self.profile, -limit, limit)
        own = self.static[slices] @ on + moved[slices] * (self.slope[slices] @ on)
        return np.asarray(own + (moved * on) @ self.slope[:, slices])


@dataclass(frozen=True)
class ContactProblem:
    """Contact of all tooth pairs over a mesh cycle, for any wear.

    Attributes
    ----------
    lines : ContactLines
        Lines of all roll positions: `pairs` mesh cycles of `per_cycle` positions.
    per_cycle : int
        Mesh positions in a cycle.
    teeth : ElasticTeeth
        Tooth compliance of both bodies.
    torque : (mesh_position,) array [N mm]
    reach : float [mm]
        Separation beyond which no slice can touch, under any load and typical wear.
    modulus : float [MPa]
        Effective modulus E*.
    usual_load : float [N/mm]
        Order of the line load.
    usual_half_width : float [mm]
        Half-width under it.
    base_pitch : float [mm]
        Of the pair.
    max_iterations : int
        Of load sharing on lines.
    more : tuple of SliceCompliance
        Further compliance between slices.
    cells : PatchCells or None
        Cells across the lines where pressure is resolved in two dimensions.
    """

    lines: ContactLines
    per_cycle: int
    teeth: ElasticTeeth
    torque: FloatArray
    reach: float
    modulus: float
    usual_load: float
    usual_half_width: float
    base_pitch: float
    max_iterations: int = 60
    more: tuple[SliceCompliance, ...] = ()
    cells: PatchCells | None = None
    _kept: dict[tuple[int, int], Candidates] = field(default_factory=dict, repr=False, compare=False)

    def __post_init__(self) -> None:
        if self.typical_approach > self._flank_height:
            raise SceneError.of(
                "operation.pinion_torque_Nm",
                1e-3 * float(self.torque.max()),
                f"loads that press flanks {self._flank_height:.3g} mm high together by much less",
                f"they would approach by some {self.typical_approach:.3g} mm: give less, or stiffer materials",
            )

    def under(self, torque: FloatArray) -> ContactProblem:
        """The same problem under other torques [N mm], (mesh_position,)."""
        return replace(self, torque=torque)

    def on_lines(self, lines: ContactLines) -> ContactProblem:
        """The same problem on other lines at the same places of the flanks."""
        cells = None if self.cells is None else replace(self.cells, lines=lines)
        return replace(self, lines=lines, cells=cells, _kept={})

    @property
    def bodies(self) -> tuple[CompliantBody, ...]:
        """Tooth compliance of each body; empty for rigid teeth."""
        return self.teeth.bodies

    @property
    def pairs(self) -> int:
        """Tooth pairs considered at once."""
        return self.lines.roll.size // self.per_cycle

    @cached_property
    def typical_approach(self) -> float:
        """Order of the approach [mm]."""
        return usual_approach(self.usual_load, self.modulus)

    @property
    def near_field(self) -> float:
        """Distance along a line up to which the stripe kernel follows half-widths [mm]."""
        return _NEAR_FIELD * self.usual_half_width

    @cached_property
    def least_curvature(self) -> float:
        """Curvature of a typical contact as wide as the flank [1/mm]: the lower limit for flat slices."""
        return 4.0 * self.usual_load / (pi * self.modulus * (0.5 * self._flank_height) ** 2)

    @cached_property
    def _flank_height(self) -> float:
        """Height of the highest slice [mm]."""
        return float(((self.lines.high - self.lines.low) * self.lines.spacing).max())

    def why_not_positive(self) -> str:
        """Reason and remedy where the compliance is not positive definite."""
        begin, width = "the compliance is not positive definite", 2.0 * self.usual_half_width
        if width > _WIDE * self._flank_height:
            wide = f"contact some {width:.2g} mm wide is not small beside flanks {self._flank_height:.3g} mm high"
            return f"{begin}: {wide}; choose less load or stiffer materials"
        return f"{begin}; raise numerics.harmonics or use fewer numerics.face_slices"

    @cached_property
    def slice_length(self) -> float:
        """Mean length of the slices that can touch [mm]."""
        near = self.is_near(self.lines)
        if not near.any():
            raise ConvergenceError(
                "no flank can touch at any mesh position: check the depth of modifications, and the placement if the "
                "pinion is displaced"
            )
        return float(self.lines.length[near].mean())

    def is_near(self, lines: ContactLines, depth: float = 0.0) -> BoolArray:
        """Slices whose fresh separation is small enough that elasticity and wear may close it, (roll, face).

        `depth` [mm] is the present wear, if it is more than typical.
        """
        separation = self._least if lines is self.lines else _least_separation(lines)
        # relative to the nearest pair at the same mesh position: misaligned flanks transmit unevenly
        per_cycle = lines.roll.size // self.pairs
        position = np.arange(lines.roll.size) % per_cycle
        least = np.full(per_cycle, np.inf)
        np.minimum.at(least, position, separation.min(axis=1))
        return separation < (least[position] + self.reach + depth)[:, None]

    def rolls_of(self, position: int) -> IntArray:
        """Roll positions of all pairs at a mesh position."""
        rolls: IntArray = self._rolls[position]
        return rolls

    def no_loads(self) -> TeethLoads:
        """No loads yet."""
        rolls, faces = self.lines.profile.shape
        return TeethLoads.none(rolls, faces, self.per_cycle)

    def line_load(self, loads: TeethLoads) -> FloatArray:
        """Line load q [N/mm], (roll, face)."""
        return loads.force / self.lines.length

    def approach(self, loads: TeethLoads) -> FloatArray:
        """Approach along the line of action at each mesh position [mm]."""
        return loads.rotation * self.lines.lever_arm[: self.per_cycle, 0]

    def candidates(self, position: int, approach: float) -> Candidates:
        """Slices that may touch under an approach [mm], and perhaps some more.

        Wear only adds to the separation, and compliance couples with one sign: a slice whose fresh separation
        exceeds the approach cannot touch. The result is kept, and does not depend on earlier calls.
        """
        nearest = float(self._nearest[position])
        height = max(_ROOM * FIRST_CAP * self.typical_approach, approach - nearest)
        # on few levels, so that other loads find the same slices
        rung = ceil(_RUNGS * log2(height / self.base_pitch))
        known = self._kept.get((position, rung))
        if known is None:
            cap = nearest + self.base_pitch * 2.0 ** (rung / _RUNGS)
            known = self._kept[position, rung] = self._found(position, cap)
        return known

    @cached_property
    def _rolls(self) -> IntArray:
        return np.ascontiguousarray(np.arange(self.pairs * self.per_cycle).reshape(self.pairs, -1).T)

    @cached_property
    def longest_lever(self) -> FloatArray:
        """Greatest lever arm of all slices at a mesh position [mm], (mesh_position,)."""
        return np.asarray(self.lines.lever_arm[self._rolls].max(axis=(1, 2)))

    @cached_property
    def _least(self) -> FloatArray:
        return _least_separation(self.lines)

    @cached_property
    def _nearest(self) -> FloatArray:
        """Least separation of all slices at a mesh position [mm], (mesh_position,)."""
        return np.asarray(self._least[self._rolls].min(axis=(1, 2)))

    def _found(self, position: int, cap: float) -> Candidates:
        rolls, lines, half_width = self.rolls_of(position), self.lines, self.usual_half_width
        pair, face = np.nonzero(self._least[rolls] < cap)
        if pair.size == 0:
            raise ConvergenceError(
                f"no flank can touch at mesh position {position}/{self.per_cycle}: check the depth of wear and "
                "modifications, and the placement if the pinion is displaced"
            )
        at = (rolls[pair], face)
        starts = np.searchsorted(pair, np.arange(self.pairs + 1))
        teeth = self.teeth.compliance(*at, pair)
        smooth = teeth.matrix.copy()
        arc, length = lines.arc[at], lines.length[at]
        mid_surface = _mid_surface(teeth, _LEAST_DEPTH * half_width)
        subtract_mid_surface(smooth, starts, arc, length, *mid_surface)
        resolved = self.cells is not None
        depth = mid_surface[0].min(axis=0, initial=np.inf)
        for further in self.more:
            smooth += further.matrix(at, starts)
        static = smooth.copy()
        add_far_stripe(static, starts, arc, length, half_width, self.near_field, 1.0 / (pi * self.modulus))
        return Candidates(
            cap=cap,
            flat=np.ravel_multi_index(at, lines.profile.shape),
            starts=starts,
            smooth=smooth,
            static=static,
            slope=teeth.slope,
            pairs=near_pairs(starts, arc, length, self.near_field),
            aside=less_aside(starts, arc, length, *mid_surface) if resolved else np.zeros((0, 0)),
            farthest_aside=np.minimum(_FARTHEST_ASIDE * depth, _FARTHEST_MOVE * self.base_pitch * lines.spacing[at]),
            least=self._least[at],
            profile=lines.profile[at],
            lever=lines.lever_arm[at],
            length=length,
            arc=arc,
            farthest_move=_FARTHEST_MOVE * self.base_pitch,
        )
