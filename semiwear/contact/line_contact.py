"""Loaded contact of all tooth pairs on their contact lines: fidelity `line`.

For every mesh position: forces F >= 0 on the slices of all pairs and one rotation phi of the driving body with

    gap + C F - a phi >= 0,   F (gap + C F - a phi) = 0,   sum of a F = torque

(a: lever arms). C is the stripe kernel of each line less the half-space displacement at the mid-surface, plus
the tooth compliance of both bodies with its coupling to neighbouring teeth, plus, in a wear step, the wear that
a force itself causes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import pi

import numpy as np
from numpy.typing import NDArray

from semiwear.closed_forms.hertz import line_contact_pressure
from semiwear.closed_forms.stripe import stripe_table
from semiwear.compliance.slice_compliance import SliceCompliance
from semiwear.compliance.tooth import CompliantBody, line_compliance
from semiwear.contact.footprint import Footprints
from semiwear.contact.line_loads import LineLoads
from semiwear.contact.line_solver import LineStatus, NearField, Slices, solve_line_loads
from semiwear.contact.mesh_position import MeshPosition
from semiwear.contact.slice_pressure import solve_slices
from semiwear.contact.stripe import add_far_stripe, subtract_mid_surface
from semiwear.contact.teeth_solver import SlicePressures
from semiwear.errors import ConvergenceError, SceneError
from semiwear.meshing.contact_lines import ContactLines

__all__ = ["LineContact", "usual_approach"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_LEAST_WIDTH = 0.1  # of the usual half-width: what slices hardly loaded are given
_LEAST_DEPTH = 1.5  # half-widths: a contact as wide as the tooth has no dent of its own, and the rest stays positive
_NEAR_FIELD = 12.0  # half-widths; farther away the width of a stripe does not show
_WIDTH_TOLERANCE = 1e-5  # of the half-widths, between two solutions
_LIGHTEST = 0.03  # of the usual line load: what an edge that hardly touches is taken to bear
_MARGIN = 1.15  # of the expected approach
_CAPS = 20  # more candidates let the approach grow less, so that two or three are enough
_FARTHEST_MOVE = 0.083  # of the base pitch: up to there tooth compliance follows a worn line linearly
_FIRST_CAP = 3.5  # candidates reach to this multiple of a typical approach; more when that is too little


def usual_approach(line_load: float, modulus: float) -> float:
    """Order of the approach of loaded teeth: q/(pi E*) times a usual fourteen [mm]."""
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


@dataclass
class LineContact:
    """Contact solver on fresh contact lines.

    Attributes
    ----------
    lines : ContactLines
        Lines of all roll positions: `pairs` mesh cycles of `per_cycle` positions.
    per_cycle : int
        Mesh positions in a cycle.
    bodies : tuple of CompliantBody
        Tooth compliance of both bodies; empty for rigid teeth.
    torque : (mesh_position,) array [N mm]
    reach : float [mm]
        Separation beyond which no slice can touch, however loaded and worn.
    modulus : float [MPa]
        Effective modulus E*.
    usual_load : float [N/mm]
        Order of the line load.
    usual_half_width : float [mm]
        Half-width under it.
    base_pitch : float [mm]
        Of the pair.
    max_iterations : int
    more : tuple of SliceCompliance
        Further compliance between slices.
    """

    lines: ContactLines
    per_cycle: int
    bodies: tuple[CompliantBody, ...]
    torque: FloatArray
    reach: float
    modulus: float
    usual_load: float
    usual_half_width: float
    base_pitch: float
    max_iterations: int = 60
    more: tuple[SliceCompliance, ...] = ()
    _systems: dict[int, MeshPosition] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        height = float(((self.lines.high - self.lines.low) * self.lines.spacing).max())
        if self.typical_approach > height:
            raise SceneError.of(
                "operation.pinion_torque_Nm",
                1e-3 * float(self.torque.max()),
                f"loads that press flanks {height:.3g} mm high together by much less",
                f"they would approach by some {self.typical_approach:.3g} mm: give less, or stiffer materials",
            )

    @property
    def resolved(self) -> None:
        """Nothing: pressure is not resolved along the line."""
        return None

    @property
    def line(self) -> LineContact:
        """The solver itself."""
        return self

    def is_near(self, lines: ContactLines, depth: float = 0.0) -> BoolArray:
        """Slices whose fresh separation is small enough that elasticity and wear may close it, (roll, face).

        `depth` [mm] is the wear that there is already, where it is more than usual.
        """
        separation = _least_separation(lines)
        # of the nearest pair at the same mesh position: misplaced flanks transmit unevenly
        per_cycle = lines.roll.size // self.pairs
        position = np.arange(lines.roll.size) % per_cycle
        least = np.full(per_cycle, np.inf)
        np.minimum.at(least, position, separation.min(axis=1))
        return separation < (least[position] + self.reach + depth)[:, None]

    @cached_property
    def _least_curvature(self) -> float:
        """Of a usual contact as wide as the flank [1/mm]: none is wider, however flat a slice."""
        half_flank = 0.5 * float(((self.lines.high - self.lines.low) * self.lines.spacing).max())
        return 4.0 * self.usual_load / (pi * self.modulus * half_flank**2)

    @cached_property
    def _least(self) -> FloatArray:
        return _least_separation(self.lines)

    @property
    def pairs(self) -> int:
        """Tooth pairs considered at once."""
        return self.lines.roll.size // self.per_cycle

    def no_loads(self) -> LineLoads:
        """No loads yet."""
        rolls, faces = self.lines.profile.shape
        return LineLoads.none(rolls, faces, self.per_cycle)

    def line_load(self, loads: LineLoads) -> FloatArray:
        """Line load q [N/mm], (roll, face)."""
        return loads.force / self.lines.length

    def pressures(self, loads: LineLoads, worn: Footprints, margin: float) -> SlicePressures:
        """Hertz's pressures, and exact ones across worn slices and edges; as in `TeethSolver`."""
        line_load, lines = self.line_load(loads), self.lines
        hertz = line_contact_pressure(line_load, worn.curvature, self.modulus)
        distance = np.minimum(worn.profile - lines.low, lines.high - worn.profile) * lines.spacing
        other = worn.edge | (distance < margin) | worn.removed.varies
        exact, _ = solve_slices(lines, worn, np.where(other, line_load, 0.0), self.modulus, margin)
        return SlicePressures(
            np.where(other, exact.inner, hertz), np.where(other, exact.place, worn.profile), exact.border
        )

    def with_edges(self, worn: Footprints, loads: LineLoads, before: Footprints) -> Footprints:
        """Contact of edges that are pressed, or nearly so, from the plane contact of each such slice under its load.

        Hertz's law with a footprint's mean gap is too stiff where pressure leans on the rounding of an edge, and too
        soft where the wall of a groove is all that bears. An edge that is pressed in `before` stays so: under much
        load it may hold the flanks farther apart than its footprint's mean gap says.
        """
        approach = np.tile(loads.rotation, self.pairs)[:, None] * self.lines.lever_arm
        near = self.is_near(self.lines) if worn.near is None else worn.near
        pressed = (worn.edge & near & (worn.least < approach)) | (before.gap != worn.gap)
        if not pressed.any():
            return worn
        load = np.where(pressed, np.maximum(self.line_load(loads), _LIGHTEST * self.usual_load), 0.0)
        touched = solve_slices(self.lines, worn, load, self.modulus, 0.0)[1]
        # no half-width is less than the load sharing allows: as much farther away as it is then too stiff
        closes, least = 2.0 / (pi * self.modulus) * load[pressed], _LEAST_WIDTH * self.usual_half_width
        width = np.sqrt(2.0 * closes / touched.curvature[pressed])
        touched.gap[pressed] += closes * np.log(np.maximum(least / width, 1.0))
        touched.curvature[pressed] = 2.0 * closes / np.maximum(width, least) ** 2
        return touched

    def approach(self, loads: LineLoads) -> FloatArray:
        """Approach along the line of action at each mesh position [mm]."""
        return loads.rotation * self.lines.lever_arm[: self.per_cycle, 0]

    @property
    def searched(self) -> FloatArray:
        """Separation up to which candidates are known at each mesh position; 0 where not yet looked for [mm]."""
        known = [self._systems.get(position) for position in range(self.per_cycle)]
        return np.array([0.0 if system is None else system.cap for system in known])

    def search(self, searched: FloatArray) -> None:
        """Know the candidates that a solver knew which had searched so far: its solutions are then the same."""
        for position in np.flatnonzero(searched):
            self.mesh_position(int(position), float(searched[position]))

    def rolls_of(self, position: int) -> IntArray:
        """Roll positions of all pairs at a mesh position."""
        return np.arange(self.pairs) * self.per_cycle + position

    def mesh_position(self, position: int, cap: float) -> MeshPosition:
        """Candidates whose fresh separation is below `cap` [mm], and their tooth compliance.

        Wear only adds to the separation, and compliance couples with one sign: a slice whose fresh separation
        exceeds the approach cannot touch.
        """
        known = self._systems.get(position)
        if known is not None and known.cap >= cap:
            return known
        rolls, lines = self.rolls_of(position), self.lines
        pair, face = np.nonzero(self._least[rolls] < cap)
        if pair.size == 0:
            raise ConvergenceError(
                f"no flank can touch at mesh position {position}/{self.per_cycle}: check the depth of wear and "
                "modifications, and the placement if the pinion is displaced"
            )
        at = (rolls[pair], face)
        starts = np.searchsorted(pair, np.arange(self.pairs + 1))
        smooth, slope = line_compliance(self.bodies, *at, pair)
        usual = self.usual_half_width
        arc, length = lines.arc[at], lines.length[at]
        subtract_mid_surface(smooth, starts, arc, length, *self._mid_surface(at, _LEAST_DEPTH * usual))
        for further in self.more:
            smooth += further.matrix(at, starts)
        static = smooth.copy()
        add_far_stripe(static, starts, arc, length, usual, _NEAR_FIELD * usual, 1.0 / (pi * self.modulus))
        system = MeshPosition(
            cap=cap,
            index=np.ravel_multi_index(at, lines.profile.shape),
            starts=starts,
            usual=usual,
            smooth=smooth,
            static=static,
            slope=slope,
            profile=lines.profile[at],
            lever=lines.lever_arm[at],
            length=length,
            arc=arc,
            farthest_move=_FARTHEST_MOVE * self.base_pitch,
        )
        self._systems[position] = system
        return system

    def _mid_surface(self, at: tuple[IntArray, IntArray], least: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Depth of the mid-surface below the points, (1 + nu)/(2 pi E) and nu, of each body."""
        if not self.bodies:
            return np.zeros((0, at[0].size)), np.zeros(0), np.zeros(0)
        bodies = [on_lines.body for on_lines in self.bodies]
        return (
            np.maximum(np.stack([on_lines.depth[at] for on_lines in self.bodies]), least),
            np.array([(1.0 + b.poissons_ratio) / (2.0 * pi * b.youngs_modulus) for b in bodies]),
            np.array([b.poissons_ratio for b in bodies]),
        )

    def solve(
        self,
        worn: Footprints,
        loads: LineLoads,
        wear_compliance: FloatArray | None = None,
        positions: Sequence[int] | None = None,
    ) -> LineLoads:
        """Solve mesh positions, starting from `loads`, which stays as it is.

        Parameters
        ----------
        worn : Footprints
            Current gaps and curvatures.
        loads : LineLoads
            Start; loads of another state serve well.
        wear_compliance : (roll, face) array [mm/N], optional
            Wear at the end of the step per force on the slice: the implicit term.
        positions : sequence of int, optional
            Mesh positions to solve; the others keep their loads.

        Raises
        ------
        ConvergenceError
            Naming the mesh position; `loads` is still the last good state.
        """
        new = loads.copy()
        for position in range(self.per_cycle) if positions is None else positions:
            self._solve_position(position, worn, new, wear_compliance)
        return new

    def _solve_position(
        self, position: int, worn: Footprints, loads: LineLoads, wear_compliance: FloatArray | None
    ) -> None:
        rolls = self.rolls_of(position)
        known = self._systems.get(position)
        if known is not None:
            cap = known.cap
        else:
            near = self.is_near(self.lines)[rolls]
            least = float(worn.gap[rolls][near].min()) if near.any() else 0.0
            cap = _FIRST_CAP * self.typical_approach + least
        for _ in range(_CAPS):
            system = self.mesh_position(position, cap)
            rotation = self._solve_system(position, system, worn, loads, wear_compliance)
            reached = rotation * float(system.lever.max())
            if reached <= system.cap:
                if wear_compliance is None:
                    worn.require_followed(loads.force, rolls, f"{position}/{self.per_cycle}")
                return
            cap = reached + 0.5 * _FIRST_CAP * self.typical_approach
        raise ConvergenceError(
            f"load sharing stopped at mesh position {position}/{self.per_cycle}: the approach, {cap:.3g} mm by now, "
            "grows with every slice that is let touch; check the torque, the materials and numerics.tooth_compliance"
        )

    @property
    def typical_approach(self) -> float:
        """Order of the approach [mm]."""
        return usual_approach(self.usual_load, self.modulus)

    def _solve_system(
        self,
        position: int,
        system: MeshPosition,
        worn: Footprints,
        loads: LineLoads,
        wear_compliance: FloatArray | None,
    ) -> float:
        gap = worn.gap.ravel()[system.index]
        # only what is nearer than the approach can touch; where the start knows it, that spares much
        chosen = np.arange(gap.size)
        if loads.force.ravel()[system.index].any():
            least = float(gap.min())
            expected = least + _MARGIN * (loads.rotation[position] * system.lever - least)
            chosen = np.flatnonzero(gap < expected)
        if chosen.size == 0:
            chosen = np.arange(gap.size)
        rotation = self._solve_chosen(position, system, chosen, worn, loads, wear_compliance)
        if chosen.size < gap.size and np.any(np.delete(gap - rotation * system.lever, chosen) < 0.0):
            rotation = self._solve_chosen(position, system, np.arange(gap.size), worn, loads, wear_compliance)
        return rotation

    def _solve_chosen(
        self,
        position: int,
        system: MeshPosition,
        chosen: IntArray,
        worn: Footprints,
        loads: LineLoads,
        wear_compliance: FloatArray | None,
    ) -> float:
        index = system.index[chosen]
        gap, curvature = worn.gap.ravel()[index], np.maximum(worn.curvature.ravel()[index], self._least_curvature)
        lever, length, arc = system.lever[chosen], system.length[chosen], system.arc[chosen]
        starts = np.searchsorted(chosen, system.starts)
        # from where the first slice touches: a misplaced pinion may be millimetres off, a light approach nanometres
        touching = float((gap / lever).min())
        gap -= touching * lever
        static = system.compliance(system.static, chosen, worn, wear_compliance)

        torque = float(self.torque[position])
        active = loads.force.ravel()[index] > 0.0
        floor = np.full(index.size, _LEAST_WIDTH * system.usual)
        if active.any():
            width = np.maximum(loads.half_width.ravel()[index], floor)
        else:
            active, width = gap <= np.quantile(gap, 0.25), np.full(index.size, system.usual)
        status, rotation, force, slack, iterations, change_of_width = solve_line_loads(
            Slices(static, gap, lever, arc, length, floor, curvature, starts),
            NearField(_NEAR_FIELD * system.usual, self.modulus, 2.0 * system.usual, *stripe_table()),
            torque, _WIDTH_TOLERANCE, self.max_iterations, active, width,
        )  # fmt: skip
        if status != LineStatus.CONVERGED:
            where = f"load sharing stopped at mesh position {position}/{self.per_cycle}: "
            shorter = "" if wear_compliance is None else ", or take shorter wear steps (more numerics.wear_steps)"
            raise ConvergenceError(where + self._reason(LineStatus(status), change_of_width) + shorter)
        loads.force[self.rolls_of(position)] = 0.0
        loads.force.ravel()[index] = force
        loads.half_width.ravel()[index] = np.where(force > 0.0, width, 0.0)
        loads.rotation[position] = touching + rotation
        loads.iterations[position] = iterations
        loads.balance[position] = abs(float(lever @ force) / torque - 1.0)
        # the Hertz pressure goes with the root of line load times curvature
        pressure = np.sqrt(force / length * curvature)
        worst = max(float((pressure * np.abs(slack)).max() / pressure.max()), float(-slack.min()))
        loads.complementarity[position] = worst / float((lever * rotation - gap).max())
        return touching + float(rotation)

    def _reason(self, status: LineStatus, change: float) -> str:
        if status == LineStatus.WIDTHS_CHANGE:
            return (
                f"half-widths still change by {change:.1e}; raise numerics.max_iterations above {self.max_iterations}"
            )
        if status == LineStatus.NO_CONTACT_SET:
            return "the contact set does not settle; change numerics.face_slices"
        return "the compliance is not positive definite; raise numerics.harmonics or use fewer numerics.face_slices"
