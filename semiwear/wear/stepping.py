"""Wear steps: from one worn flank to the next.

Implicit: within a step of dN meshes the wear that a load causes is itself a gap. Its rate times dN joins the
diagonal of the compliance and the loads at the end of the step are found in one solution; no step is unstable.
Explicit: the loads at the start of the step hold throughout; only for comparison.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.teeth_solver import TeethLoads
from semiwear.errors import ConvergenceError
from semiwear.wear.mapping import InterpolatedWear, WearMapping
from semiwear.wear.swept_line import Sweep, own_wear, sweep

__all__ = ["ControlPoint", "WearState", "WearStepper"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_DEPTH_A_CYCLE = 1.25e-3  # mm: within an implicit step the contact's shape follows the wear that often
_CYCLES = (4, 32)
_DEEPEST = 0.1  # of the flank's height: beyond, sections and contact lines of the fresh tooth mean nothing
_DEPTH_TOLERANCE = 2e-5  # of the depth that a step adds
_DEPTH_MISSED = 1e-3  # of it: then all mesh positions are solved
_DEPTH_ITERATIONS = 40


@dataclass(frozen=True)
class WearState:
    """A worn flank and its elastic contact.

    Attributes
    ----------
    meshes : float
        Engagements of one driven tooth so far.
    contact : LoadedState
    pace : float
        Meshes that the last step to a depth took, over those that the wear rate at its start had promised.
    """

    meshes: float
    contact: LoadedState
    pace: float = 1.0

    @property
    def wear(self) -> FloatArray:
        """Wear depth on the grid [mm]."""
        return self.contact.wear


@dataclass(frozen=True)
class ControlPoint:
    """A point of the driven flank whose wear controls the steps.

    Attributes
    ----------
    face : float [mm]
    profile : (face,) array [mm]
        Profile coordinate at which each slice is read: the point's height there.
    """

    face: float
    profile: FloatArray


@dataclass(frozen=True)
class WearStepper:
    """Advances the wear of the driven flank.

    Attributes
    ----------
    teeth : LoadedTeeth
    coefficient : float [mm^2/N]
        Wear coefficient k of the driven body.
    implicit : bool
    mapping : WearMapping
        From loads to wear depths on the flank.
    """

    teeth: LoadedTeeth
    coefficient: float
    implicit: bool = True
    mapping: WearMapping = field(default_factory=InterpolatedWear)

    def start(self) -> WearState:
        """The unworn flank."""
        return WearState(0.0, self.teeth.load(np.zeros(self.teeth.grid.profile.shape)))

    def step(self, state: WearState, meshes: float) -> WearState:
        """The state `meshes` engagements later."""
        step = _Step(self, state)
        return self._committed(step, meshes)

    def step_to_depth(self, state: WearState, point: ControlPoint, depth: float) -> WearState:
        """The state in which the control point has worn to `depth` [mm]; the meshes for it are found."""
        step = _Step(self, state)
        meshes = step.meshes_to(point, depth, nearby=True)
        end = self._committed(step, meshes)
        if abs(self.depth_at(point, end.wear) - depth) > _DEPTH_MISSED * (depth - self.depth_at(point, state.wear)):
            # a long step brings to the point what was far from it
            end = self._committed(step, step.meshes_to(point, depth, nearby=False))
        return end

    def depth_at(self, point: ControlPoint, wear: FloatArray) -> float:
        """Wear depth at a control point [mm]."""
        return self.teeth.grid.interpolate(wear, point.face, point.profile)

    def _committed(self, step: _Step, meshes: float) -> WearState:
        """The end of a step of known length; nothing is changed before everything has converged."""
        loads = step.loads(meshes)
        wear = step.worn(loads, meshes)
        deepest, height = float(wear.max()), float(np.ptp(self.teeth.grid.profile, axis=1).max())
        if deepest > _DEEPEST * height:
            raise ConvergenceError(
                f"a step of {meshes:.3g} meshes from {step.state.meshes:.3g} would wear {deepest:.3g} mm off a flank "
                f"{height:.3g} mm high: the tooth is gone long before; ask for fewer wear.until.meshes or a smaller "
                "wear.coefficient_mm2_per_N"
            )
        contact = self.teeth.load(wear, loads)
        return WearState(step.state.meshes + meshes, contact, step.pace)


class _Step:
    """What a step knows about its start, whatever its length."""

    def __init__(self, stepper: WearStepper, state: WearState):
        teeth = stepper.teeth
        self.stepper, self.teeth, self.state = stepper, teeth, state
        per_time = teeth.pair.roll_per_time
        self.motion: Sweep = sweep(teeth.fine, state.contact.fine, per_time)
        self.coarse_motion = sweep(teeth.lines, state.contact.coarse, per_time)
        rotation = np.tile(state.contact.loads.rotation, teeth.rolls.pairs)
        self.distance = state.contact.coarse.gap - rotation[:, None] * teeth.lines.lever_arm
        self._rate: FloatArray | None = None
        self.cycles = 1
        self.pace = state.pace

    def rate(self, meshes: float) -> FloatArray:
        """Own wear per mesh, force and wear coefficient, fixed by the first length that is asked for."""
        if self._rate is None:
            arguments = (self.teeth.lines, self.coarse_motion, self.state.contact.coarse, self.distance)
            force = self.state.contact.loads.force
            now = own_wear(*arguments, 0.0)
            # wear that the present loads would leave, where they are; elasticity spreads it when it is large
            depth = meshes * self.stepper.coefficient * float(np.sum(now * force**2) / np.sum(force))
            elastic = 2.0 * float(np.abs(self.teeth.solver.approach(self.state.contact.loads)).mean())
            growth = depth / (1.0 + depth / elastic)
            self._rate = own_wear(*arguments, growth)
            self.cycles = int(np.clip(np.ceil(growth / _DEPTH_A_CYCLE), *_CYCLES))
        return self._rate

    def loads(
        self, meshes: float, positions: Sequence[int] | None = None, start: TeethLoads | None = None
    ) -> TeethLoads:
        """Loads that hold over the step, found from `start` (its first loads unless given)."""
        contact = self.state.contact
        if not self.stepper.implicit:
            return contact.loads
        own = meshes * self.stepper.coefficient * self.rate(meshes)
        return self.teeth.solver.solve(contact.coarse, start or contact.loads, own, positions)

    def worn(self, loads: TeethLoads, meshes: float, slices: IntArray | None = None) -> FloatArray:
        """Wear at the end of the step [mm]."""
        if slices is None:
            slices = np.arange(self.teeth.grid.face.size)
        dose = meshes * self.stepper.coefficient
        return self.stepper.mapping.worn(self.teeth, self.motion, self.state.wear, loads, dose, self.cycles, slices)

    def meshes_to(self, point: ControlPoint, depth: float, *, nearby: bool) -> float:
        """Meshes after which the control point has worn to `depth` [mm]: a secant held in its bracket.

        With `nearby` only the mesh positions are solved whose contact passes near the point.
        """
        stepper, teeth = self.stepper, self.teeth
        low, weight = teeth.grid.bracket(point.face)
        slices = np.unique([low, min(low + 1, teeth.grid.face.size - 1)]) if weight > 0.0 else np.array([low])
        now = stepper.depth_at(point, self.state.wear)
        wanted = depth - now
        positions = self._positions_at(point, slices) if nearby else None
        loads = self.state.contact.loads
        mesh = stepper.mapping.of_mesh(teeth, self.motion, self.state.wear, loads, slices)
        rate = stepper.coefficient * stepper.depth_at(point, mesh)
        if rate <= 0.0:
            raise ConvergenceError(
                f"the control point (radius {point.face:g} mm) carries no load at {self.state.meshes:.3g} meshes and "
                "wears no further: choose another wear.control_point or smaller wear.until.control_depths_um"
            )
        known = [(0.0, -wanted)]
        promised = wanted / rate
        trial = self.state.pace * promised
        for _ in range(_DEPTH_ITERATIONS):
            loads = self.loads(trial, positions, loads)
            value = stepper.depth_at(point, self.worn(loads, trial, slices)) - depth
            if abs(value) <= _DEPTH_TOLERANCE * wanted:
                self.pace = trial / promised
                return trial
            known.append((trial, value))
            trial = _next_trial(known)
        raise ConvergenceError(
            f"no number of meshes wears the control point (radius {point.face:g} mm) to {depth * 1e3:g} um: "
            "it loses its load on the way; choose another wear.control_point or smaller control depths"
        )

    def _positions_at(self, point: ControlPoint, slices: IntArray) -> list[int]:
        """Mesh positions whose footprints, in these slices, can reach the control point."""
        teeth = self.teeth
        place = self.state.contact.coarse.profile[:, slices]
        loaded = self.state.contact.loads.force[:, slices] > 0.0
        reach = 3.0 * teeth.half_width / float(teeth.lines.spacing[:, slices].min())
        near = loaded & (np.abs(place - point.profile[slices]) <= reach)
        rolls = np.flatnonzero(near.any(axis=1))
        # loads are interpolated between positions, so the next ones count as well
        rolls = np.unique(np.clip(np.concatenate([rolls - 1, rolls, rolls + 1]), 0, place.shape[0] - 1))
        return [int(position) for position in np.unique(rolls % teeth.rolls.phase.size)]


def _next_trial(known: list[tuple[float, float]]) -> float:
    """Next argument on the way to the zero of a rising function: a secant between the nearest on either side."""
    below = max(x for x, y in known if y < 0.0)
    above = min((x for x, y in known if y >= 0.0), default=4.0 * max(x for x, _ in known))
    (x_0, y_0), (x_1, y_1) = known[-2:]
    secant = x_1 - y_1 * (x_1 - x_0) / (y_1 - y_0) if y_1 != y_0 else above
    margin = 1e-3 * (above - below)
    if below + margin < secant < above - margin or abs(y_1) < 1e-3 * abs(known[0][1]):
        return min(max(secant, below), above)
    return 0.5 * (below + above) if len(known) > 3 else min(max(secant, below + margin), above - margin)
