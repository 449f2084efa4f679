"""Wear steps: from one worn flank to the next.

Implicit: within a step of dN meshes the wear that a load causes is itself a gap. Its rate times dN joins the
diagonal of the compliance and the loads at the end of the step are found in one solution; no step is unstable. The
rate, at first an estimate from the lines' motion, is corrected by a trial of the step: what the flanks that it
would leave feel. Where the tip of the driving body digs in, the estimate alone is a third too high.
Explicit: the loads at the start of the step hold throughout; only for comparison.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from semiwear.contact.footprint import depth_of
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.loads import TeethLoads
from semiwear.errors import ConvergenceError
from semiwear.meshing.flank_grid import at_places
from semiwear.meshing.flank_pair import DRIVEN, DRIVING
from semiwear.wear.mapping import (
    InterpolatedWear,
    WearMapping,
    WearMultipliers,
    WeightedLoads,
    Worn,
    driving_wear_at,
)
from semiwear.wear.state import ControlPoint, LoadCase, Trial, WearState
from semiwear.wear.swept_line import Sweep, own_wear, sweep
from semiwear.wear.volume import WearVolume, sliding_work

__all__ = ["ControlPoint", "LoadCase", "Trial", "WearState", "WearStepper"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

CoefficientFactor = Callable[[LoadedTeeth, TeethLoads, LoadedState], FloatArray]
"""Factor on the wear coefficient in every slice, (roll, face), under loads on worn flanks."""

_CYCLES = (4, 64)  # within an implicit step
_FEWER, _LEAST_CYCLES = 2, 2  # half of them show the own wear of lines as well: results change by less than 0.05 %
_DEPTH_A_CYCLE = 6.9e-5  # of the base pitch: wear after which the contact's shape follows it
_MOST_CYCLES = 128  # where wear between two of them would be deeper than a footprint reaches
_DEEPEST = 0.1  # of the flank's height: beyond, sections and contact lines of the fresh tooth mean nothing
_DEPTH_TOLERANCE = 2e-5  # of the depth that a step adds
_DEPTH_MISSED = 3e-4  # of it: then all mesh positions are solved; a smaller jump of the depth is let be
_DEPTH_ITERATIONS = 40
_NO_STEP = 1e-12  # of the meshes of a step
_SMOOTH_DEPTH_TOLERANCE = 1e-8  # of the same, where results are to be smooth
_FACTOR_TOLERANCE = 1e-3  # of the greatest factor on the wear coefficient
_SMOOTH_FACTOR_TOLERANCE = 1e-7  # of the same, where results are to be smooth
_FACTOR_ITERATIONS = 60
_FACTOR_MISSED = 5e-2  # more than that after the last iteration: no wear can be told
_FADES = 0.25  # of the elastic approach: a slice this much later still counts in part where results are smooth
_CORRECTION = (0.25, 2.0)  # of own wear, by a trial of the step: within it no step was unstable
_LEAST_SLOPE = 0.1  # of the driving flank's place against the driven one's: 1 where both roll alike
_FELT = 1e-3  # of the greatest force on a slice: less tells nothing of the wear that it causes


@dataclass(frozen=True)
class WearStepper:
    """Advances the wear of the flanks.

    Attributes
    ----------
    teeth : LoadedTeeth
        Under the load whose contact is reported.
    coefficients : WearMultipliers
        Wear coefficient of each body [mm^2/N], times its meshes in one mesh of a driven tooth.
    implicit : bool
    mapping : WearMapping
        From loads to wear depths on the flanks.
    cases : tuple of LoadCase
        What the teeth wear under; empty for `teeth` alone.
    factor : callable or None
        On the wear coefficients, where they depend on the contact.
    depth_factor : callable or None
        On the wear coefficient of the driven flank at its present depth, (face, profile).
    depth_a_cycle : float
        Within an implicit step the contact's shape follows the wear that often; over the base pitch.
    """

    teeth: LoadedTeeth
    coefficients: WearMultipliers
    implicit: bool = True
    mapping: WearMapping = field(default_factory=InterpolatedWear)
    cases: tuple[LoadCase, ...] = ()
    factor: CoefficientFactor | None = None
    depth_factor: Callable[[FloatArray], FloatArray] | None = None
    depth_a_cycle: float = _DEPTH_A_CYCLE

    @property
    def load_cases(self) -> tuple[LoadCase, ...]:
        """Load cases under which the teeth wear."""
        return self.cases or (LoadCase(1.0, self.teeth),)

    def following(self, depth: float) -> WearStepper:
        """The same, with the contact's shape following every so much wear within a step, over the base pitch."""
        return replace(self, depth_a_cycle=depth)

    def start(self) -> WearState:
        """The unworn flanks."""
        teeth = self.teeth
        driving = None if teeth.driving is None else np.zeros(teeth.driving.grid.profile.shape)
        wear = np.zeros(teeth.grid.profile.shape)
        cases = tuple(case.teeth.load(wear, None, driving) for case in self.cases)
        return WearState(0.0, teeth.load(wear, None, driving), cases=cases)

    def step(self, state: WearState, meshes: float) -> WearState:
        """The state `meshes` engagements later."""
        return self.commit(self.trial(state, meshes))

    def step_to_depth(self, state: WearState, point: ControlPoint, depth: float) -> WearState:
        """The state in which the control point has worn to `depth` [mm]; the meshes for it are found."""
        return self.commit(self.trial_to_depth(state, point, depth))

    def trial(
        self,
        state: WearState,
        meshes: float,
        near: Sequence[TeethLoads] | None = None,
        *,
        loads_after: float | None = None,
    ) -> Trial:
        """Trial of a step of known length.

        Parameters
        ----------
        state : WearState
        meshes : float
        near : sequence, optional
            Loads of every case near those of the step: they spare its trial a solution.
        loads_after : float, optional
            The loads that hold are those of a step of this length [meshes].
        """
        return self._tried(_Step(self, state, near), meshes, loads_after)

    def trial_to_depth(
        self, state: WearState, point: ControlPoint, depth: float, near: Sequence[TeethLoads] | None = None
    ) -> Trial:
        """Trial of a step to a depth of the control point [mm]; `near` as in `trial`."""
        step = _Step(self, state, near)
        trial = self._tried(step, step.meshes_to(point, depth, nearby=True))
        missed = abs(self.depth_at(point, point.wear(trial.worn)) - depth)
        if missed > _DEPTH_MISSED * (depth - self.depth_at(point, point.wear(state.worn))):
            # a long step brings to the point what was far from it
            trial = self._tried(step, step.meshes_to(point, depth, nearby=False))
        return trial

    def depth_at(self, point: ControlPoint, wear: FloatArray) -> float:
        """Wear depth at a control point [mm], from the wear of its flank."""
        driving = self.teeth.driving
        grid = self.teeth.grid if point.body == DRIVEN or driving is None else driving.grid
        return grid.interpolate(wear, point.face, point.profile)

    def multipliers(self, meshes: float) -> WearMultipliers:
        """Wear coefficients times the meshes of a step."""
        return WearMultipliers(meshes * self.coefficients.driven, meshes * self.coefficients.driving)

    def commit(self, trial: Trial) -> WearState:
        """The state after a trial: elastic contact on its worn flanks."""
        worn, loads = trial.worn, trial.loads
        cases = tuple(
            case.teeth.load(worn.driven, start, worn.driving)
            for case, start in zip(self.cases, loads, strict=bool(self.cases))
        )
        contact = self.teeth.load(worn.driven, loads[0], worn.driving)
        volume = trial.start.volume + trial.volume
        meshes, residual = trial.start.meshes + trial.meshes, trial.law_residual
        return WearState(meshes, contact, trial.pace, cases, volume=volume, law_residual=residual)

    def _tried(self, step: _Step, meshes: float, loads_after: float | None = None) -> Trial:
        """The end of a step of known length; nothing is changed before everything has converged."""
        loads = step.loads(meshes if loads_after is None else loads_after)
        worn, on_edges = step.mapped(loads, meshes)
        deepest = max(float(depth.max()) for depth in worn if depth is not None)
        height = float(np.ptp(self.teeth.grid.profile, axis=1).max())
        if not deepest <= _DEEPEST * height:  # nor no number at all
            raise ConvergenceError(
                f"a step of {meshes:.3g} meshes from {step.state.meshes:.3g} would wear {deepest:.3g} mm off a flank "
                f"{height:.3g} mm high: the tooth is gone long before; ask for fewer wear.until.meshes or a smaller "
                "wear.coefficient_mm2_per_N"
            )
        work = sliding_work(step.weighted_loads(loads), step.motion, self.teeth)
        multipliers = self.multipliers(meshes)
        volume = WearVolume(work * np.array([multipliers.driving, multipliers.driven]), on_edges)
        return Trial(step.state, meshes, loads, worn, step.pace, volume, step.law_residual)


class _CaseStep:
    """One load case within a step.

    The factor on the wear coefficient that spreads the wear is the one with which the loads were found: then the wear
    that a load causes is the gap that the load has felt, and no step is unstable.
    """

    def __init__(self, stepper: WearStepper, case: LoadCase, state: LoadedState, motion: Sweep):
        self.stepper, self.case, self.state, self.motion = stepper, case, state, motion
        teeth = case.teeth
        rotation = np.tile(state.loads.rotation, teeth.rolls.pairs)
        self.distance = state.coarse.gap - rotation[:, None] * teeth.lines.lever_arm
        self.elastic = float(np.abs(teeth.problem.approach(state.loads)).mean())
        self.rate = np.zeros(0)
        self.factor: FloatArray | None = self._factor(state.loads) if stepper.factor is not None else None
        self.law_residual = 0.0

    def prepare(self, meshes: float) -> float:
        """Own wear per mesh and force, for a step of about this length; returns the growth of the approach [mm]."""
        force = self.state.loads.force
        now = self._own(0.0)
        if self.factor is not None:
            now = now * self.factor
        # wear that the present loads would leave, where they are; elasticity spreads it when it is large
        depth = meshes * float(np.sum(now * force**2) / np.sum(force))
        growth = depth / (1.0 + 0.5 * depth / self.elastic)
        self.rate = self._own(growth)
        return growth

    def _own(self, growth: float) -> FloatArray:
        """Wear of both bodies in one mesh, as the line itself will feel it, per force on a slice [mm/N]."""
        stepper, teeth, coarse = self.stepper, self.case.teeth, self.state.coarse
        arguments = (teeth.lines, self.motion, coarse, self.distance, growth)
        fades = _FADES * self.elastic if teeth.smooth else 0.0
        total = np.zeros(0)
        if stepper.coefficients.driven:
            total = stepper.coefficients.driven * own_wear(*arguments, DRIVEN, fades)
            if stepper.depth_factor is not None:
                total = total * at_places(teeth.grid.profile, stepper.depth_factor(self.state.wear), coarse.profile)
        if stepper.coefficients.driving:
            driving = stepper.coefficients.driving * own_wear(*arguments, DRIVING, fades)
            total = total + driving if total.size else driving
        return self.case.others * total

    def correct(self, worn: Worn, loads: TeethLoads, meshes: float) -> None:
        """Own wear of the lines as these worn flanks show it, after a step under these loads."""
        teeth, force = self.case.teeth, loads.force
        after = teeth.touch_solved(teeth.removed(*worn))
        before = self.state.fine.every(teeth.rolls.substeps)  # as `after`, without what the loads press on edges
        rate = self.rate if self.factor is None else self.rate * self.factor
        said = meshes * rate * force
        felt = force > _FELT * force.max()
        ratio = np.ones_like(said)
        felt &= said > 0.0
        ratio[felt] = (after.gap[felt] - before.gap[felt]) / said[felt]
        ratio = np.clip(ratio, *_CORRECTION)
        if teeth.smooth:
            # a slice that comes to be felt is so by and by
            ratio = 1.0 + (ratio - 1.0) * np.clip(force / (_FELT * force.max()) - 1.0, 0.0, 1.0)
        self.rate = self.rate * ratio

    def _factor(self, loads: TeethLoads) -> FloatArray:
        assert self.stepper.factor is not None
        return self.stepper.factor(self.case.teeth, loads, self.state)

    def loads(self, meshes: float, positions: Sequence[int] | None, start: TeethLoads | None) -> TeethLoads:
        """Loads that hold over the step."""
        if not self.stepper.implicit:
            return self.state.loads
        loads = self._solve(meshes, positions, start or self.state.loads)
        if self.factor is None:
            return loads
        smooth = self.case.teeth.smooth
        tolerance = _SMOOTH_FACTOR_TOLERANCE if smooth else _FACTOR_TOLERANCE
        before: tuple[FloatArray, FloatArray] | None = None
        for _ in range(_FACTOR_ITERATIONS):
            change = np.where(loads.force > 0.0, self._factor(loads) - self.factor, 0.0)
            self.law_residual = float(np.abs(change).max() / self.factor.max())
            if self.law_residual <= tolerance:
                return loads
            now = self.factor, change
            # more load makes more wear and so less load: half of each change overshoots least
            self.factor = _mixed(now, before) if smooth and before is not None else self.factor + 0.5 * change
            before = now
            loads = self._solve(meshes, positions, loads)
        if self.law_residual > _FACTOR_MISSED:
            raise ConvergenceError(
                f"wear law and loads do not settle over a step of {meshes:.3g} meshes: after {_FACTOR_ITERATIONS} "
                f"iterations the wear coefficient still changes by {self.law_residual:.1%} of its greatest; take "
                "more numerics.wear_steps, or an effects.wear_law whose wear changes less with the load"
            )
        return loads

    def _solve(self, meshes: float, positions: Sequence[int] | None, start: TeethLoads) -> TeethLoads:
        rate = self.rate if self.factor is None else self.rate * self.factor
        teeth = self.case.teeth
        return teeth.fidelity.solve(teeth.problem, self.state.coarse, start, meshes * rate, positions)

    def weighted(self, loads: TeethLoads) -> WeightedLoads:
        """Part of the case in the wear."""
        weight = self.case.share if self.factor is None else self.case.share * self.factor
        return WeightedLoads(self.case.teeth, loads, weight)


class _Step:
    """A step from a state, whatever its length."""

    def __init__(self, stepper: WearStepper, state: WearState, near: Sequence[TeethLoads] | None = None):
        teeth = stepper.teeth
        self.stepper, self.teeth, self.state, self.near = stepper, teeth, state, near
        per_time = teeth.pair.roll_per_time
        self.motion: Sweep = sweep(teeth.fine, state.contact.fine, per_time)
        coarse_motion = sweep(teeth.lines, state.contact.coarse, per_time)
        self.cases = [
            _CaseStep(stepper, case, loaded, coarse_motion)
            for case, loaded in zip(stepper.load_cases, state.loaded, strict=True)
        ]
        self.cycles = 0.0
        self.pace = state.pace

    def loads(
        self, meshes: float, positions: Sequence[int] | None = None, start: Sequence[TeethLoads] | None = None
    ) -> list[TeethLoads]:
        """Loads of every case that hold over the step, found from `start` (its first loads unless given)."""
        if self.cycles == 0:
            # fixed by the first length that is asked for
            growth = max(case.prepare(meshes) for case in self.cases) if self.stepper.implicit else 0.0
            self.cycles = 1.0
            if self.stepper.implicit:
                depth = self.stepper.depth_a_cycle * self.teeth.pair.base_pitch
                cycles = growth / depth if self.teeth.smooth else np.ceil(growth / depth)
                self.cycles = float(np.clip(cycles, *_CYCLES))
                self._correct_own_wear(meshes)
        starts: Sequence[TeethLoads | None] = start or self.near or [None] * len(self.cases)
        return [case.loads(meshes, positions, one) for case, one in zip(self.cases, starts, strict=True)]

    def _correct_own_wear(self, meshes: float) -> None:
        """Correct the own wear of every line by what a step of this length would leave."""
        loads = self.near or [case.loads(meshes, None, None) for case in self.cases]
        half = self.cycles / _FEWER
        few = max(half if self.teeth.smooth else np.floor(half), _LEAST_CYCLES)
        worn = self.worn(loads, meshes, cycles=few)
        stable = self._stable_cycles(worn)
        if stable > few:
            self.cycles = max(stable, self.cycles)
            worn = self.worn(loads, meshes)
        for case, one in zip(self.cases, loads, strict=True):
            case.correct(worn, one, meshes)

    def _stable_cycles(self, worn: Worn) -> int:
        """Cycles in each of which no more is worn than a footprint reaches down.

        A ripple in a flank is worn away at the rate of the wear over that depth: from twice as much on, it would
        come out greater on the other side.
        """
        lines, loaded = self.teeth.lines, self.state.contact.loads.force > 0.0
        bend = float(np.median(lines.separation[2][loaded] / lines.spacing[loaded] ** 2))
        reach = depth_of(bend, self.teeth.half_width)
        pairs = zip(worn, self.state.worn, strict=True)
        depth = sum(
            float((after - before).max()) for after, before in pairs if after is not None and before is not None
        )
        return int(min(np.ceil(depth / reach), _MOST_CYCLES))

    @property
    def law_residual(self) -> float:
        """Greatest of the load cases."""
        return max(case.law_residual for case in self.cases)

    def weighted_loads(self, loads: Sequence[TeethLoads]) -> list[WeightedLoads]:
        """The cases' parts in the wear."""
        return [case.weighted(one) for case, one in zip(self.cases, loads, strict=True)]

    def worn(
        self,
        loads: Sequence[TeethLoads],
        meshes: float,
        slices: IntArray | None = None,
        cycles: float | None = None,
    ) -> Worn:
        """Wear at the end of the step [mm]."""
        return self.mapped(loads, meshes, slices, cycles)[0]

    def mapped(
        self,
        loads: Sequence[TeethLoads],
        meshes: float,
        slices: IntArray | None = None,
        cycles: float | None = None,
    ) -> tuple[Worn, FloatArray]:
        """Wear at the end of the step [mm], and what it takes off the edges of both bodies [mm^3].

        Between whole numbers of cycles it is the mean of both: then it is no other by a jump where they change.
        """
        if slices is None:
            slices = np.arange(self.teeth.grid.face.size)
        wanted = cycles or self.cycles
        whole = int(wanted)
        few = self._mapped_in(whole, loads, meshes, slices)
        if whole == wanted:
            return few
        (worn, edges), (more, more_edges) = few, self._mapped_in(whole + 1, loads, meshes, slices)
        share = wanted - whole
        driving = None if worn.driving is None or more.driving is None else _mean(worn.driving, more.driving, share)
        return Worn(_mean(worn.driven, more.driven, share), driving), _mean(edges, more_edges, share)

    def _mapped_in(
        self, cycles: int, loads: Sequence[TeethLoads], meshes: float, slices: IntArray
    ) -> tuple[Worn, FloatArray]:
        multipliers = self.stepper.multipliers(meshes)
        return self.stepper.mapping.worn(
            self.teeth, self.motion, self.state.worn, self.weighted_loads(loads), multipliers, cycles, slices
        )

    def meshes_to(self, point: ControlPoint, depth: float, *, nearby: bool) -> float:
        """Meshes after which the control point has worn to `depth` [mm]: a secant held in its bracket.

        With `nearby` only the mesh positions are solved whose contact passes near the point.
        """
        stepper, teeth = self.stepper, self.teeth
        low, weight = teeth.grid.bracket(point.face)
        slices = np.unique([low, min(low + 1, teeth.grid.face.size - 1)]) if weight > 0.0 else np.array([low])
        now = stepper.depth_at(point, point.wear(self.state.worn))
        wanted = depth - now
        if wanted <= 0.0:
            raise ConvergenceError(
                f"the control point (radius {point.face:g} mm) is {now * 1e3:g} um deep already, no step wears it to "
                f"{depth * 1e3:g} um; give wear.until.control_depths_um that rise"
            )
        positions = self._positions_at(point, slices) if nearby else None
        loads: list[TeethLoads] = [loaded.loads for loaded in self.state.loaded]
        start = (teeth, self.motion, self.state.worn, self.weighted_loads(loads), slices)
        if point.body == DRIVEN:
            rate = stepper.coefficients.driven * stepper.depth_at(point, stepper.mapping.of_mesh(*start))
        else:
            rate = stepper.coefficients.driving * stepper.depth_at(point, driving_wear_at(*start))
        if rate <= 0.0:
            raise ConvergenceError(
                f"the control point (radius {point.face:g} mm) carries no load at {self.state.meshes:.3g} meshes and "
                "wears no further: choose another wear.control_point or smaller wear.until.control_depths_um"
            )
        known = [(0.0, -wanted)]
        promised = wanted / rate
        tolerance = _SMOOTH_DEPTH_TOLERANCE if teeth.smooth else _DEPTH_TOLERANCE
        trial = self.state.pace * promised
        for _ in range(_DEPTH_ITERATIONS):
            loads = self.loads(trial, positions, loads)
            value = stepper.depth_at(point, point.wear(self.worn(loads, trial, slices))) - depth
            if abs(value) <= tolerance * wanted:
                self.pace = trial / promised
                return trial
            known.append((trial, value))
            trial = _next_trial(known)
            if abs(trial - known[-1][0]) <= _NO_STEP * trial:
                break
        # where a slice comes into contact the depth jumps, by little
        trial, missed = min(known, key=lambda one: abs(one[1]))
        if abs(missed) <= _DEPTH_MISSED * wanted:
            self.pace = trial / promised
            return trial
        raise ConvergenceError(
            f"no number of meshes wears the control point (radius {point.face:g} mm) to {depth * 1e3:g} um: "
            "it loses its load on the way; choose another wear.control_point or smaller control depths"
        )

    def _positions_at(self, point: ControlPoint, slices: IntArray) -> list[int]:
        """Mesh positions whose footprints, in these slices, can reach the control point."""
        teeth = self.teeth
        place, spacing = self.state.contact.coarse.profile[:, slices], teeth.lines.spacing[:, slices]
        if point.body == DRIVING:
            lines = teeth.lines
            place = lines.on_driving(self.state.contact.coarse.profile)[:, slices]
            spacing = spacing / np.maximum(np.abs(lines.driving_slope[:, slices]), _LEAST_SLOPE)
        loaded = np.any([one.loads.force[:, slices] > 0.0 for one in self.state.loaded], axis=0)
        reach = 3.0 * teeth.half_width / float(spacing.min())
        near = loaded & (np.abs(place - point.profile[slices]) <= reach)
        rolls = np.flatnonzero(near.any(axis=1))
        # loads are interpolated between positions, so the next ones count as well
        rolls = np.unique(np.clip(np.concatenate([rolls - 1, rolls, rolls + 1]), 0, place.shape[0] - 1))
        return [int(position) for position in np.unique(rolls % teeth.rolls.phase.size)]


def _mean(one: FloatArray, other: FloatArray, share: float) -> FloatArray:
    """Weighted mean: the other one's share counts."""
    return (1.0 - share) * one + share * other


def _mixed(now: tuple[FloatArray, FloatArray], before: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Next values of a fixed-point iteration from the last two and their changes (Anderson 1965, depth one)."""
    (value, change), (last, last_change) = now, before
    bend = change - last_change
    square = float(np.vdot(bend, bend))
    share = min(max(float(np.vdot(change, bend)) / square, -1.0), 1.0) if square > 0.0 else 0.0
    return value + 0.5 * change - share * (value - last + 0.5 * bend)


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
