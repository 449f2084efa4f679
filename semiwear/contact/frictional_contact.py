"""Loaded contact of rubbing teeth: friction takes part of the torque, or adds to it.

The torque balance of the driving body is sum F (a + mu s t) = T, with a the lever of the normal force, t that of the
friction force and s its share of mu F (`traction`); the separation knows nothing of it. The moment of friction is
nearly proportional to the loads, so a few frictionless solutions with torques T - sum F mu s t find it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semiwear.compliance.tooth import CompliantBody
from semiwear.contact.footprint import Footprints
from semiwear.contact.friction import Friction
from semiwear.contact.line_conditions import line_conditions
from semiwear.contact.teeth_solver import SlicePressures, TeethSolver
from semiwear.contact.traction import full_sliding_speed, share_per_speed
from semiwear.errors import ConvergenceError
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.surface_speed import SurfaceSpeeds

__all__ = ["FrictionalContact"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_TOLERANCE = 1e-10  # of the torque
_USUAL = (-0.5, 1.0)  # bounds of friction's part of the torque where loads of another state start
_ITERATIONS = 30


@dataclass(frozen=True)
class FrictionalContact:
    """A `TeethSolver` around another one.

    Attributes
    ----------
    frictionless : callable
        The solver for torques at each mesh position [N mm].
    torque : (mesh_position,) array [N mm]
    friction : Friction
    speeds : SurfaceSpeeds
        At the solved roll positions.
    """

    frictionless: Callable[[FloatArray], TeethSolver]
    torque: FloatArray
    friction: Friction
    speeds: SurfaceSpeeds

    @property
    def solver(self) -> TeethSolver:
        """The frictionless solver, for all that does not depend on the torque."""
        return self.frictionless(self.torque)

    @property
    def bodies(self) -> tuple[CompliantBody, ...]:
        """Tooth compliance of both bodies; empty for rigid teeth."""
        return self.solver.bodies

    @property
    def reach(self) -> float:
        """Separation beyond which no slice can touch, however loaded and worn [mm]."""
        return self.solver.reach

    @property
    def modulus(self) -> float:
        """Effective modulus E* [MPa]."""
        return self.solver.modulus

    @property
    def resolved(self) -> Any:
        """The `PatchContact` that resolves pressure in two dimensions, or None."""
        return self.solver.resolved

    @property
    def line(self) -> Any:
        """The frictionless `LineContact`."""
        return self.solver.line

    def is_near(self, lines: ContactLines, depth: float = 0.0) -> BoolArray:
        """Slices whose fresh separation is small enough that elasticity and wear may close it, (roll, face)."""
        return self.solver.is_near(lines, depth)

    def no_loads(self) -> Any:
        """No loads yet."""
        return self.solver.no_loads()

    def moment(self, loads: Any, worn: Footprints) -> FloatArray:
        """Moment that friction needs of the driving body at each mesh position [N mm]."""
        conditions, speeds = line_conditions(self.solver, loads, worn, self.speeds), self.speeds
        coefficient = self.friction.coefficient_of(conditions)
        roll, face = np.nonzero(loads.force)
        full = full_sliding_speed(conditions, coefficient)[roll, face]
        share = share_per_speed(speeds.sliding_in_parts[:, roll, face], full)
        lever = np.mean(share * speeds.sliding_with_driving[:, roll, face], axis=0)
        each = np.zeros(loads.force.shape)
        each[roll, face] = coefficient[roll, face] * loads.force[roll, face] * lever
        return np.asarray(each.sum(axis=1).reshape(-1, self.torque.size).sum(axis=0))

    def solve(
        self,
        worn: Footprints,
        loads: Any,
        wear_compliance: FloatArray | None = None,
        positions: Sequence[int] | None = None,
    ) -> Any:
        """Solve mesh positions, starting from `loads`, which stays as it is.

        Raises
        ------
        ConvergenceError
            Naming the mesh position.
        """
        chosen = np.arange(self.torque.size) if positions is None else np.asarray(positions, dtype=np.int64)
        torque = self.torque.copy()
        if loads.force.any():
            torque[chosen] /= 1.0 + np.clip(self.moment(loads, worn) / self.torque, *_USUAL)[chosen]
        left = chosen
        for _ in range(_ITERATIONS):
            loads = self.frictionless(torque).solve(worn, loads, wear_compliance, [int(at) for at in left])
            needed = torque + self.moment(loads, worn)  # of the driving body, for these loads
            left = chosen[np.abs(needed - self.torque)[chosen] > _TOLERANCE * self.torque[chosen]]
            if left.size == 0:
                return loads
            if np.any(needed[left] <= 0.0):
                break
            torque[left] *= self.torque[left] / needed[left]
        raise ConvergenceError(
            f"friction takes more torque than there is at mesh position {int(left[0])}/{self.torque.size}, or keeps "
            "changing: lower effects.friction.coefficient"
        )

    def with_edges(self, worn: Footprints, loads: Any, before: Footprints) -> Footprints:
        """Footprints with the gaps of pressed edges as these loads make them."""
        return self.solver.with_edges(worn, loads, before)

    @property
    def searched(self) -> FloatArray:
        """Separation up to which candidates are known at each mesh position; 0 where not yet looked for [mm]."""
        return self.solver.searched

    def search(self, searched: FloatArray) -> None:
        """Know the candidates that a solver knew which had searched so far: its solutions are then the same."""
        self.solver.search(searched)

    def line_load(self, loads: Any) -> FloatArray:
        """Line load q [N/mm], (roll, face)."""
        return self.solver.line_load(loads)

    def pressures(self, loads: Any, worn: Footprints, margin: float) -> SlicePressures:
        """Greatest pressures of each slice; less than `margin` [mm] across the line from an end is at the border."""
        return self.solver.pressures(loads, worn, margin)

    def approach(self, loads: Any) -> FloatArray:
        """Approach along the line of action at each mesh position [mm]."""
        return self.solver.approach(loads)
