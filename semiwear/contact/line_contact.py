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
from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotrs

from semiwear.compliance.tooth import BodyOnLines, line_compliance
from semiwear.contact.hertz import line_contact_half_width, line_contact_pressure
from semiwear.contact.stripe import add_stripe_compliance, average_along_lines, stripe_table
from semiwear.contact.worn_lines import WornLines
from semiwear.errors import ConvergenceError
from semiwear.meshing.contact_lines import ContactLines

__all__ = ["LineContact", "LineLoads"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_WIDTH_TOLERANCE = 1e-6  # of the half-widths, between two solutions
_NEAR = 0.5  # mm
_FIRST_CAP = 2.0  # candidates reach to this multiple of a typical approach; more when that is too little


@dataclass
class LineLoads:
    """Loads on the contact lines; changed in place while positions are solved.

    Attributes
    ----------
    force : (roll, face) array [N]
        Normal force on each slice.
    half_width : (roll, face) array [mm]
        Hertz half-width.
    rotation : (mesh_position,) array [rad]
        Rotation of the driving body beyond its nominal place.
    iterations : (mesh_position,) int array
    balance, complementarity : (mesh_position,) arrays
        Relative error of the torque; greatest product of force over its peak and gap over approach, a negative
        gap counting in full.
    """

    force: FloatArray
    half_width: FloatArray
    rotation: FloatArray
    iterations: IntArray
    balance: FloatArray
    complementarity: FloatArray

    @classmethod
    def none(cls, rolls: int, faces: int, positions: int) -> LineLoads:
        """No loads yet."""
        return cls(
            np.zeros((rolls, faces)),
            np.zeros((rolls, faces)),
            np.zeros(positions),
            np.zeros(positions, dtype=np.int64),
            np.zeros(positions),
            np.zeros(positions),
        )

    def copy(self) -> LineLoads:
        """An independent copy."""
        return LineLoads(
            self.force.copy(),
            self.half_width.copy(),
            self.rotation.copy(),
            self.iterations.copy(),
            self.balance.copy(),
            self.complementarity.copy(),
        )


@dataclass
class _System:
    """What a mesh position needs at every wear state: candidates and their tooth compliance."""

    cap: float
    rolls: IntArray
    faces: IntArray
    starts: IntArray
    tooth: FloatArray
    slope: FloatArray


@dataclass
class LineContact:
    """Contact solver on fresh contact lines.

    Attributes
    ----------
    lines : ContactLines
        Lines of all roll positions: `pairs` mesh cycles of `per_cycle` positions.
    per_cycle : int
        Mesh positions in a cycle.
    bodies : tuple of BodyOnLines
        Tooth compliance of both bodies; empty for rigid teeth.
    torque : float [N mm]
    modulus : float [MPa]
        Effective modulus E*.
    max_iterations : int
    """

    lines: ContactLines
    per_cycle: int
    bodies: tuple[BodyOnLines, ...]
    torque: float
    modulus: float
    max_iterations: int = 60
    _systems: dict[int, _System] = field(default_factory=dict, repr=False)

    @property
    def near(self) -> BoolArray:
        """Slices whose fresh separation is small enough that elasticity and wear may close it, (roll, face)."""
        return self.lines.separation[0] < _NEAR

    @property
    def pairs(self) -> int:
        """Tooth pairs considered at once."""
        return self.lines.roll.size // self.per_cycle

    def line_load(self, loads: LineLoads) -> FloatArray:
        """Line load q [N/mm], (roll, face)."""
        return loads.force / self.lines.length

    def pressure(self, loads: LineLoads, worn: WornLines) -> FloatArray:
        """Greatest Hertz pressure of each slice [MPa], (roll, face)."""
        return line_contact_pressure(self.line_load(loads), worn.curvature, self.modulus)

    def approach(self, loads: LineLoads) -> FloatArray:
        """Approach along the line of action at each mesh position [mm]."""
        return loads.rotation * self.lines.lever_arm[: self.per_cycle, 0]

    def _rolls_of(self, position: int) -> IntArray:
        return np.arange(self.pairs) * self.per_cycle + position

    def _system(self, position: int, cap: float) -> _System:
        """Candidates whose fresh separation is below `cap` [mm], and their tooth compliance.

        Wear only adds to the separation, and compliance couples with one sign: a slice whose fresh separation
        exceeds the approach cannot touch.
        """
        known = self._systems.get(position)
        if known is not None and known.cap >= cap:
            return known
        rolls = self._rolls_of(position)
        pair, face = np.nonzero(self.lines.separation[0][rolls] < cap)
        starts = np.searchsorted(pair, np.arange(self.pairs + 1))
        tooth, slope = line_compliance(self.bodies, rolls[pair], face, pair)
        system = _System(cap, rolls[pair], face, starts, tooth, slope)
        self._systems[position] = system
        return system

    def solve(
        self,
        worn: WornLines,
        loads: LineLoads,
        wear_compliance: FloatArray | None = None,
        positions: Sequence[int] | None = None,
    ) -> LineLoads:
        """Solve mesh positions, starting from `loads`, which stays as it is.

        Parameters
        ----------
        worn : WornLines
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
        self, position: int, worn: WornLines, loads: LineLoads, wear_compliance: FloatArray | None
    ) -> None:
        rolls = self._rolls_of(position)
        known = self._systems.get(position)
        if known is not None:
            cap = known.cap
        else:
            near = self.near[rolls]
            least = float(worn.gap[rolls][near].min()) if near.any() else 0.0
            cap = _FIRST_CAP * self._typical_approach() + least
        while True:
            system = self._system(position, cap)
            rotation = self._solve_system(position, system, worn, loads, wear_compliance)
            reached = float(np.max(rotation * self.lines.lever_arm[rolls]))
            if reached <= system.cap:
                return
            cap = 1.5 * reached

    def _typical_approach(self) -> float:
        """Order of the approach: one pair loaded over half the face, q/(pi E*) times a usual fourteen [mm]."""
        face = self.lines.face
        half_width = 0.5 * float(face[-1] - face[0]) if face.size > 1 else 1.0
        load = self.torque / float(self.lines.lever_arm.max()) / half_width
        return 14.0 * load / (pi * self.modulus)

    def _solve_system(
        self,
        position: int,
        system: _System,
        worn: WornLines,
        loads: LineLoads,
        wear_compliance: FloatArray | None,
    ) -> float:
        at = (system.rolls, system.faces)
        lines = self.lines
        gap = worn.gap[at]
        near = np.flatnonzero(np.isfinite(gap))
        if near.size == 0:
            raise ConvergenceError(
                f"no flank can touch at mesh position {position}/{self.per_cycle}: check the placement"
            )
        lever, curvature, length, arc = (x[at] for x in (lines.lever_arm, worn.curvature, lines.length, lines.arc))
        moved = (worn.profile - lines.profile)[at]
        tooth = system.tooth
        if np.any(moved):
            change = system.slope * moved[:, None]
            tooth = tooth + change + change.T
        diagonal = None if wear_compliance is None else wear_compliance[at]
        depth = (
            np.stack([body.depth[at] for body in self.bodies]) if self.bodies else np.zeros((0, gap.size))
        )
        shear = np.array(
            [(1 + b.body.poissons_ratio) / (2 * pi * b.body.youngs_modulus) for b in self.bodies]
        )
        poisson = np.array([b.body.poissons_ratio for b in self.bodies])
        values, slopes = stripe_table()

        force = np.where(np.isfinite(gap), loads.force[at], 0.0)
        typical = self.torque / float(lever.max()) / (0.3 * float(length.sum()))
        usual = line_contact_half_width(np.full(gap.size, typical), curvature, self.modulus)
        floor, reach = 0.2 * usual, 2.0 * float(np.median(usual))
        if force.any():
            active = force > 0.0
            width = np.maximum(loads.half_width[at], floor)
        else:
            active = gap <= np.partition(gap, min(gap.size - 1, gap.size // 4))[min(gap.size - 1, gap.size // 4)]
            active &= np.isfinite(gap)
            width = usual
        rotation = 0.0
        residual = image = None
        for iteration in range(1, self.max_iterations + 1):
            matrix = tooth.copy()
            for start, stop in zip(system.starts[:-1], system.starts[1:], strict=True):
                add_stripe_compliance(
                    matrix, start, stop, arc, length, width, depth, 1.0 / (pi * self.modulus), shear, poisson,
                    values, slopes,
                )  # fmt: skip
            if diagonal is not None:
                matrix[np.diag_indices_from(matrix)] += diagonal
            solved = _complementarity(matrix, gap, lever, self.torque, active)
            if solved is None:
                raise ConvergenceError(
                    f"load sharing stopped at mesh position {position}/{self.per_cycle}: the contact set does not "
                    "settle; use more numerics.face_slices or fewer, or a smaller placement"
                )
            force, rotation, active = solved
            even = average_along_lines(force, system.starts, arc, length, reach)
            new_width = np.maximum(line_contact_half_width(even, curvature, self.modulus), floor)
            change_of_width = float(np.max(np.abs(new_width - width)) / new_width.max())
            if change_of_width < _WIDTH_TOLERANCE:
                break
            width, residual, image = _accelerated(np.log(width), np.log(new_width), residual, image)
        else:
            raise ConvergenceError(
                f"load sharing stopped at mesh position {position}/{self.per_cycle}: half-widths still change by "
                f"{change_of_width:.1e}; raise numerics.max_iterations above {self.max_iterations}"
            )
        near_gap = gap + matrix @ force - lever * rotation
        loads.force[self._rolls_of(position)] = 0.0
        loads.force[at] = force
        loads.half_width[at] = np.where(force > 0.0, new_width, 0.0)
        loads.rotation[position] = rotation
        loads.iterations[position] = iteration
        approach = float(np.max(lever * rotation - gap, where=np.isfinite(gap), initial=0.0))
        loads.balance[position] = abs(float(lever @ force) / self.torque - 1.0)
        loads.complementarity[position] = max(
            float(np.max(force / force.max() * np.abs(near_gap), where=np.isfinite(gap), initial=0.0)),
            float(np.max(-near_gap, where=np.isfinite(gap), initial=0.0)),
        ) / approach
        return rotation


def _accelerated(
    argument: FloatArray, image: FloatArray, last_residual: FloatArray | None, last_image: FloatArray | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Next half-widths of the fixed point on their logarithms (Anderson 1965, depth one).

    Widths and loads answer each other, sometimes slowly, sometimes with overshoot; either is one eigenvalue.
    """
    residual = image - argument
    following = image
    if last_residual is not None and last_image is not None:
        change = residual - last_residual
        square = float(change @ change)
        if square > 0.0:
            mixing = min(max(float(residual @ change) / square, -5.0), 5.0)
            following = image - mixing * (image - last_image)
    return np.exp(following), residual, image


def _complementarity(
    matrix: FloatArray, gap: FloatArray, lever: FloatArray, torque: float, active: BoolArray
) -> tuple[FloatArray, float, BoolArray] | None:
    """Forces and rotation by a primal-dual active set (Hintermueller, Ito, Kunisch 2002).

    Returns None when the set does not settle.
    """
    active = active.copy()
    count = gap.size
    for attempt in range(200):
        on = np.flatnonzero(active)
        if on.size == 0:
            active[np.argmin(gap / lever)] = True
            continue
        factor, failed = dpotrf(matrix[np.ix_(on, on)], lower=1, overwrite_a=1)
        if failed:
            return None
        rhs = np.column_stack([gap[on], lever[on]])
        solution, _ = dpotrs(factor, rhs, lower=1)
        rotation = (torque + lever[on] @ solution[:, 0]) / (lever[on] @ solution[:, 1])
        force_on = rotation * solution[:, 1] - solution[:, 0]
        force = np.zeros(count)
        force[on] = force_on
        slack = gap + matrix[:, on] @ force_on - lever * rotation
        slack[on] = 0.0
        tolerance = 1e-13 * abs(rotation) * float(lever.max())
        pull = on[force_on < 0.0]
        press = np.flatnonzero(~active & (slack < -tolerance))
        if pull.size == 0 and press.size == 0:
            return force, float(rotation), active
        if attempt < 20:
            active[pull] = False
            active[press] = True
        elif pull.size:
            # one at a time always ends, if slowly
            active[pull[np.argmin(force[pull])]] = False
        else:
            active[press[np.argmin(slack[press])]] = True
    return None
