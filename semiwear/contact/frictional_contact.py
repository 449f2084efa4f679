"""Loaded contact of teeth with friction, which takes part of the torque or adds to it.

The torque balance of the driving body is sum F (a + mu s t) = T, with a the lever of the normal force, t that of the
friction force and s its share of mu F (`traction`); the separation does not depend on it. The moment of friction is
nearly proportional to the loads, so a few frictionless solutions with torques T - sum F mu s t find it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.contact.fidelity import SolveLoads
from semiwear.contact.footprint import Footprints
from semiwear.contact.friction import Friction
from semiwear.contact.line_conditions import line_conditions
from semiwear.contact.loads import TeethLoads
from semiwear.contact.problem import ContactProblem
from semiwear.contact.traction import full_sliding_speed, share_per_speed
from semiwear.errors import ConvergenceError
from semiwear.meshing.surface_speed import SurfaceSpeeds

ROUGHLY = 1e-4
"""Tolerance of the torque while quantities that depend on the loads have not settled."""

_TOLERANCE = 1e-10  # of the torque
_FRICTION_PART = (-0.5, 1.0)  # bounds of friction's part of the torque if the start is loads of another state
_ITERATIONS = 30


@dataclass(frozen=True)
class FrictionalContact:
    """Load sharing with friction, from frictionless solutions under corrected torques; a `SolveLoads`.

    Attributes
    ----------
    frictionless : SolveLoads
    friction : Friction
    speeds : SurfaceSpeeds
        At the solved roll positions.
    tolerance : float
        Of the torque.
    """

    frictionless: SolveLoads
    friction: Friction
    speeds: SurfaceSpeeds
    tolerance: float = _TOLERANCE

    def moment(self, problem: ContactProblem, loads: TeethLoads, worn: Footprints) -> FloatArray:
        """Moment on the driving body that friction takes up at each mesh position [N mm]."""
        conditions, speeds = line_conditions(problem, loads, worn, self.speeds), self.speeds
        coefficient = self.friction.coefficient_of(conditions)
        roll, face = np.nonzero(loads.force)
        full = full_sliding_speed(conditions, coefficient)[roll, face]
        share = share_per_speed(speeds.sliding_in_parts[:, roll, face], full)
        lever = np.mean(share * speeds.sliding_with_driving[:, roll, face], axis=0)
        each = np.zeros(loads.force.shape)
        each[roll, face] = coefficient[roll, face] * loads.force[roll, face] * lever
        return np.asarray(each.sum(axis=1).reshape(-1, problem.per_cycle).sum(axis=0))

    def __call__(
        self,
        problem: ContactProblem,
        worn: Footprints,
        start: TeethLoads | None = None,
        wear_compliance: FloatArray | None = None,
        positions: Sequence[int] | None = None,
    ) -> TeethLoads:
        """Loads under friction; as in `SolveLoads`."""
        chosen = np.arange(problem.per_cycle) if positions is None else np.asarray(positions, dtype=np.int64)
        given, torque = problem.torque, problem.torque.copy()
        loads = problem.no_loads() if start is None else start
        if loads.force.any():
            torque[chosen] /= 1.0 + np.clip(self.moment(problem, loads, worn) / given, *_FRICTION_PART)[chosen]
        left = chosen
        for _ in range(_ITERATIONS):
            at = [int(position) for position in left]
            loads = self.frictionless(problem.under(torque), worn, loads, wear_compliance, at)
            needed = torque + self.moment(problem, loads, worn)  # of the driving body, for these loads
            left = chosen[np.abs(needed - given)[chosen] > self.tolerance * given[chosen]]
            if left.size == 0:
                return loads
            if np.any(needed[left] <= 0.0):
                break
            torque[left] *= given[left] / needed[left]
        raise ConvergenceError(
            f"friction takes more torque than there is at mesh position {int(left[0])}/{problem.per_cycle}, or keeps "
            "changing: lower effects.friction.coefficient"
        )
