"""Wear steps: from one worn flank to the next.

Implicit: over a step of dN meshes the wear caused by a load opens the gap under it. The wear rate per force
(`case_step`) times theta dN is added to the diagonal of the compliance, so that one solution gives the loads after
the share theta of the step. The whole step wears under these loads. A wear mode of rate z <= 0 per step is multiplied
by

    (1 + (1 - theta) z)/(1 - theta z)

(the theta method), which is stable at every z for theta >= 1/2. theta = 1 damps all fast modes and has an error of
z^2/2; theta = 1/2 has a third-order error and damps nothing. theta = 3/4 halves the error of theta = 1 and leaves a
third of a fast mode, with the opposite sign. A step that wears less than three footprint depths has no fast modes
except at edges, so theta decreases with the depth of the step, to 0.65 at two footprint depths, which leaves a half.
Wear never shrinks for any theta, because a step wears in proportion to its loads.
Explicit: the whole step wears under the loads at its start; only for comparison.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.contact.footprint import depth_of
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.loads import TeethLoads
from semiwear.errors import ConvergenceError, EndlessWearError
from semiwear.meshing.flank_pair import DRIVEN
from semiwear.wear.case_step import CaseStep, CoefficientFactor, DepthFactor
from semiwear.wear.depth_search import next_trial, positions_at
from semiwear.wear.mapping import InterpolatedWear, MarchedWear, WeightedLoads, by_width, driving_wear_at
from semiwear.wear.state import ControlPoint, LoadCase, Trial, WearState
from semiwear.wear.step_influence import Cycles, CyclesTo, StepInfluence
from semiwear.wear.swept_line import Sweep, sweep, worn_sweep
from semiwear.wear.volume import WearVolume, sliding_work
from semiwear.wear.worn import WearMultipliers, Worn

__all__ = ["ControlPoint", "LoadCase", "Trial", "WearState", "WearStepper"]


# theta of shallow and of deep steps. For deep steps with both bodies worn 0.75 has the least error of 1, 0.88, 0.8,
# 0.75 and 0.65. For shallow steps of three kinds of pairs 0.65 halves the error of loads; 0.6 raises that of depths
_THETA = (0.65, 0.75)
_RIPPLE = 0.75  # (1 - theta) times the footprint depths worn by a step: no ripple changes its sign below 1
_LEAST_CYCLES, _MOST_CYCLES = 3.0, 128.0  # of an implicit step; the contact geometry is updated after each cycle
_MOST_WORN = 1.0  # wear of a cycle over the depth of a footprint
_ROUGHLY = (2.0, 1.5)  # least cycles and most worn to predict a depth: a single cycle makes lives 0.4 % longer
_LENGTH_RATIO = (
    0.8,
    1.25,
)  # of a step's length to the length its footprints were found for; beyond, they are renewed
_MOST_DEVIATION = 1.0  # footprint depths: where the predicted wear is off by more, footprints are found again
_SEARCHES = 3  # for the length of a step; more than one where the footprints had to be found again
_DEEPEST = 0.1  # of the flank's height; beyond it sections and contact lines of the fresh tooth are invalid
_DEPTH_TOLERANCE = 2e-5  # of the depth added by a step
_DEPTH_JUMP = 3e-4  # of the depth added by a step: a smaller jump of the depth is accepted
_LAW_JUMP = 1e-3  # the same under a wear law, whose factor is converged to this share of its greatest value
_SAME_LOADS = 3e-3  # of the depth added by a step: within it the loads of a step need no new solution
_LINEAR = 0.03  # of the depth added by a step: within it a secant through the start gives the length as closely
_DEPTH_RATIO = (0.8, 1.25)  # of the depth worn by a step to the estimate; beyond, it is no guide to the next step
_DEPTH_ITERATIONS = 40
_NO_STEP = 1e-12  # of the meshes of a step
_SMOOTH_DEPTH_TOLERANCE = 1e-8  # of the depth added by a step, where results are to be smooth


@dataclass(frozen=True)
class WearStepper:
    """Advances the wear of the flanks.

    Attributes
    ----------
    teeth : LoadedTeeth
        Under the load for which results are reported.
    coefficients : WearMultipliers
        Wear coefficient of each body [mm^2/N], times its meshes in one mesh of a driven tooth.
    implicit : bool
    mapping : InterpolatedWear or MarchedWear
        From loads to wear depths on the flanks.
    cases : tuple of LoadCase
        Load cases that wear the teeth; empty for that of `teeth` alone.
    factor : callable or None
        Factor on the wear coefficients where they depend on the contact.
    depth_factor : callable or None
        Factor on the wear coefficient of the driven flank by its wear depth, (face, profile).
    most_worn : float
        Wear in a cycle of an implicit step, over the depth of a footprint.
    theta : float, optional
        Share of an implicit step after which its loads are solved; by default it follows from the depth of the step.
    spreading : LoadedTeeth, optional
        Teeth with footprints of a mean width of all load cases, by which the contact moves and cycles are counted; by
        default `teeth`. Every load case wears with footprints of its own width.
    """

    teeth: LoadedTeeth
    coefficients: WearMultipliers
    implicit: bool = True
    mapping: InterpolatedWear | MarchedWear = field(default_factory=InterpolatedWear)
    cases: tuple[LoadCase, ...] = ()
    factor: CoefficientFactor | None = None
    depth_factor: DepthFactor | None = None
    most_worn: float = _MOST_WORN
    theta: float | None = None
    spreading: LoadedTeeth | None = None

    @property
    def load_cases(self) -> tuple[LoadCase, ...]:
        """Load cases under which the teeth wear."""
        return self.cases or (LoadCase(1.0, self.teeth),)

    def fully_implicit(self, most_worn: float) -> WearStepper:
        """The same stepper with theta = 1 and another `most_worn`."""
        return replace(self, most_worn=most_worn, theta=1.0)

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
        """The state in which the control point has worn to `depth` [mm]; the number of meshes is solved for."""
        return self.commit(self.trial_to_depth(state, point, depth))

    def trial(
        self,
        state: WearState,
        meshes: float,
        estimate: Sequence[TeethLoads] | None = None,
        *,
        loads_after: float | None = None,
    ) -> Trial:
        """Trial of a step of known length.

        Parameters
        ----------
        state : WearState
        meshes : float
        estimate : sequence, optional
            Estimated loads of every load case; with them the step needs one solution less.
        loads_after : float, optional
            Meshes after which the loads are solved; by default the share `theta` of the step.
        """
        return self._tried(_Step(self, state, estimate), meshes, loads_after)

    def trial_to_depth(
        self, state: WearState, point: ControlPoint, depth: float, estimate: Sequence[TeethLoads] | None = None
    ) -> Trial:
        """Trial of a step to a depth of the control point [mm]; `estimate` as in `trial`."""
        step = _Step(self, state, estimate)
        increment = depth - self.depth_at(point, point.wear(state.worn))
        aim = increment / state.depth_ratio
        trial = self._tried(step, step.meshes_to(point, depth - increment + aim, nearby=True))
        for search in range(_SEARCHES):
            excess = self.depth_at(point, point.wear(trial.worn)) - depth
            if search == 0 and abs(excess) > _DEPTH_JUMP * increment:
                # over a long step the point also wears under lines that were far from it, as it will in the next step
                step.depth_ratio = float(np.clip((increment + excess) / aim, *_DEPTH_RATIO))
            if abs(excess) <= _SAME_LOADS * increment:
                return replace(trial, depth_ratio=step.depth_ratio).scaled(increment / (increment + excess))
            trial = self._tried(step, step.meshes_to(point, depth, nearby=False, first=trial.meshes))
        return trial

    def predicted_depth(self, state: WearState, meshes: float) -> float:
        """Estimate of the greatest wear depth on either flank after a step [mm], cheaper than the step.

        Only the prediction of an implicit step is done: within 10 % of the depth after the step, less in most scenes.
        """
        if not self.implicit:
            return self.trial(state, meshes).worn.deepest
        worn = _Step(self, state).predict_wear(meshes, roughly=True)
        self._require_teeth(worn, state, meshes)
        return worn.deepest

    def footprints_worn(self, state: WearState, meshes: float) -> float:
        """As `footprints_between`, for a step that wears in a single cycle under the loads at its start."""
        step = _Step(self, state)
        step.follow([loaded.loads for loaded in state.loaded], meshes, Cycles(1.0))
        assert step.influence is not None
        return self.footprints_between(state, step.influence.course.shapes[-1])

    def footprints_between(self, state: WearState, worn: Worn) -> float:
        """Greatest wear of both bodies between a state and worn flanks, in footprint depths."""
        force = state.contact.loads.force
        loaded = force > 0.0
        bends = self.teeth.lines.curvature[loaded]
        # a median jumps when another slice comes into contact
        bend = float(np.average(bends, weights=force[loaded]) if self.teeth.smooth else np.median(bends))
        pairs = zip(worn, state.worn, strict=True)
        depth = sum(
            float((after - before).max()) for after, before in pairs if after is not None and before is not None
        )
        return float(depth / depth_of(bend, (self.spreading or self.teeth).half_width))

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
        worn = trial.worn
        # the approach was solved after the share theta of the step: extrapolate it to the end as a start
        loads = [
            replace(after, rotation=before.loads.rotation + (after.rotation - before.loads.rotation) / trial.theta)
            for after, before in zip(trial.loads, trial.start.loaded, strict=True)
        ]
        cases = tuple(
            case.teeth.load(worn.driven, start, worn.driving)
            for case, start in zip(self.cases, loads, strict=bool(self.cases))
        )
        contact = self.teeth.load(worn.driven, loads[0], worn.driving)
        return WearState(
            trial.start.meshes + trial.meshes,
            contact,
            trial.pace,
            cases,
            volume=trial.start.volume + trial.volume,
            law_residual=trial.law_residual,
            depth_ratio=trial.depth_ratio,
            corrections=trial.corrections,
        )

    def _tried(self, step: _Step, meshes: float, loads_after: float | None = None) -> Trial:
        """Trial of a step of known length; the state is not changed before everything has converged."""
        step.require_influence(meshes, loads_after)
        loads = step.loads(step.theta * meshes if loads_after is None else loads_after)
        if not (step.has_footprints_for(meshes) and step.predicted_well(loads)):
            step.follow(loads, meshes)
        worn, on_edges = step.mapped(loads, meshes)
        self._require_teeth(worn, step.state, meshes)
        work = sliding_work(step.weighted_loads(loads), step.motion, self.teeth)
        multipliers = self.multipliers(meshes)
        volume = WearVolume(work * np.array([multipliers.driving, multipliers.driven]), on_edges)
        return Trial(
            step.state,
            meshes,
            loads,
            worn,
            step.pace,
            volume,
            step.law_residual,
            step.depth_ratio,
            step.corrections,
            step.theta,
        )

    def _require_teeth(self, worn: Worn, state: WearState, meshes: float) -> None:
        height = float(np.ptp(self.teeth.grid.profile, axis=1).max())
        if not worn.deepest <= _DEEPEST * height:  # true for NaN as well
            raise ConvergenceError(
                f"a step of {meshes:.3g} meshes from {state.meshes:.3g} would wear {worn.deepest:.3g} mm off a flank "
                f"{height:.3g} mm high: the tooth is worn away long before; ask for fewer wear.until.meshes, "
                "less deep wear.until.control_depths_um or a smaller wear.coefficient_mm2_per_N"
            )


class _Step:
    """A step from a state, of a length still to be chosen."""

    def __init__(self, stepper: WearStepper, state: WearState, estimate: Sequence[TeethLoads] | None = None):
        teeth = stepper.teeth
        self.stepper, self.teeth, self.state, self.estimate = stepper, teeth, state, estimate
        self.spreading = stepper.spreading or teeth
        self.motion: Sweep = worn_sweep(teeth, self._spread_contact)
        corrections: Sequence[FloatArray | None] = state.corrections or [None] * len(stepper.load_cases)
        factors = stepper.factor, stepper.depth_factor
        motions = [sweep(teeth.lines, contact.coarse.profile, teeth.pair.roll_per_time) for contact in state.loaded]
        self.cases = [
            CaseStep(stepper.coefficients, case, loaded, motion, *factors, correction)
            for case, loaded, motion, correction in zip(
                stepper.load_cases, state.loaded, motions, corrections, strict=True
            )
        ]
        self.influence: StepInfluence | None = None
        self.predicted: Sequence[TeethLoads] = ()
        self.cycles, self.followed = Cycles(1.0), 0.0  # of the influence; length it was found for [meshes]
        self.theta = stepper.theta or _THETA[1]
        self.settled = bool(estimate or state.corrections) or not stepper.implicit
        self.pace, self.depth_ratio = state.pace, state.depth_ratio

    @property
    def _spread_contact(self) -> LoadedState:
        """The reported contact with the footprints on which wear is deposited."""
        contact = self.state.contact
        if self.spreading is self.teeth:
            return contact
        return replace(contact, touched=self.spreading.touch_solved(contact.wear, contact.driving_wear))

    def loads(
        self, meshes: float, positions: Sequence[int] | None = None, start: Sequence[TeethLoads] | None = None
    ) -> list[TeethLoads]:
        """Loads of every load case after some meshes, solved from `start` (by default the predicted loads)."""
        if not self.stepper.implicit:
            return [loaded.loads for loaded in self.state.loaded]
        starts: Sequence[TeethLoads | None] = start or self.estimate or self.predicted or [None] * len(self.cases)
        roughly = positions is not None  # in the search for a depth, after which all positions are solved again
        pairs = zip(self.cases, starts, strict=True)
        return [case.loads(meshes, positions, begin, roughly=roughly) for case, begin in pairs]

    def require_influence(self, whole: float, meshes: float | None = None) -> None:
        """Find the influence of loads on the wear of `whole` meshes, if unknown; `meshes` as in `predict_wear`."""
        if self.influence is not None:
            return
        if self.stepper.implicit:
            self.predict_wear(whole, meshes)
        else:
            self.follow([loaded.loads for loaded in self.state.loaded], whole)

    def predict_wear(self, whole: float, meshes: float | None = None, *, roughly: bool = False) -> Worn:
        """Wear depths after the step under predicted loads; also corrects the implicit wear compliance of the cases.

        Parameters
        ----------
        whole : float
            Length of the step.
        meshes : float, optional
            Meshes after which the loads are predicted; by default the share `theta` of the step.
        roughly : bool
            Whether fewer cycles are enough.
        """
        meshes = self.theta * whole if meshes is None else meshes
        for case in self.cases:
            case.prepare(meshes)
        starts: Sequence[TeethLoads | None] = self.predicted or [None] * len(self.cases)
        pairs = zip(self.cases, starts, strict=True)
        loads = self.estimate or [case.predicted_loads(meshes, begin) for case, begin in pairs]
        self.predicted = loads
        self.follow(loads, whole, partial(self._cycles_to, roughly=roughly))
        assert self.influence is not None
        worn = self.influence.course.at(meshes / whole)
        for case, of_case in zip(self.cases, loads, strict=True):
            case.correct(worn, of_case, meshes)
        return self.influence.course.shapes[-1]

    def follow(self, loads: Sequence[TeethLoads], meshes: float, cycles: CyclesTo | None = None) -> None:
        """Wear the flanks under given loads in cycles, and keep every footprint (`step_influence`)."""
        self.influence = self.stepper.mapping.followed(
            self.spreading,
            self.motion,
            self.state.worn,
            self.weighted_loads(loads),
            self.stepper.multipliers(meshes),
            cycles or self.cycles,
        )
        self.followed = meshes

    def has_footprints_for(self, meshes: float) -> bool:
        """Whether the footprints were found for a step of about this length; explicit steps have no such limit."""
        low, high = _LENGTH_RATIO
        return not self.stepper.implicit or low <= meshes / self.followed <= high

    def predicted_well(self, loads: Sequence[TeethLoads]) -> bool:
        """Whether the footprints were found under about these loads.

        The relative difference of the line loads times the number of cycles is the difference of the wear in
        footprint depths. Where that is more than one, footprints of other loads leave ripples.
        """
        if self.teeth.smooth and not self.settled:  # wear compliance not yet corrected; no limit for smooth results
            return False
        assert self.influence is not None
        line_loads = [load.line_load for load in by_width(self.spreading, self.weighted_loads(loads))]
        return self.influence.differs_from(line_loads) * self.cycles.number <= _MOST_DEVIATION

    def _cycles_to(self, worn: Worn, *, roughly: bool = False) -> Cycles:
        """Cycles of a step that would leave these wear depths with the contact geometry of its start.

        A ripple of a flank wears away at the rate of the wear over the depth of a footprint. It would be amplified
        with the opposite sign where a cycle wears more than two footprint depths with footprints found at its start,
        or more than one with footprints found in its middle. So the less a cycle wears, the farther ahead they are
        found.
        """
        footprints = self.stepper.footprints_between(self.state, worn)
        least, most_worn = _ROUGHLY if roughly else (_LEAST_CYCLES, self.stepper.most_worn)
        number = footprints / most_worn
        if not self.teeth.smooth:  # smooth results take a fraction of a cycle
            number = np.ceil(number)
        number = float(np.clip(number, least, _MOST_CYCLES))
        self.cycles = Cycles(number, float(np.clip(2.0 * (1.0 - footprints / number), 0.0, 1.0)))
        if self.stepper.theta is None:
            self.theta = float(np.clip(1.0 - _RIPPLE / max(footprints, _RIPPLE), *_THETA))
        return self.cycles

    @property
    def law_residual(self) -> float:
        """Greatest change of a law's factor of all load cases."""
        return max(case.law_residual for case in self.cases)

    def weighted_loads(self, loads: Sequence[TeethLoads]) -> list[WeightedLoads]:
        """Loads of the cases with their weights in the wear."""
        return [case.weighted(of_case) for case, of_case in zip(self.cases, loads, strict=True)]

    @property
    def corrections(self) -> tuple[FloatArray, ...]:
        """Corrections of the implicit wear compliance, by load case; empty in an explicit step."""
        return tuple(case.correction for case in self.cases if case.correction is not None)

    def mapped(
        self, loads: Sequence[TeethLoads], meshes: float, slices: IntArray | None = None
    ) -> tuple[Worn, FloatArray]:
        """Wear depths at the end of the step [mm], and the volume worn off the edges of both bodies [mm^3]."""
        if slices is None:
            slices = np.arange(self.teeth.grid.face.size)
        assert self.influence is not None
        multipliers = self.stepper.multipliers(meshes)
        return self.stepper.mapping.worn(self.influence, self.weighted_loads(loads), multipliers, slices)

    def meshes_to(self, point: ControlPoint, depth: float, *, nearby: bool, first: float | None = None) -> float:
        """Meshes after which the control point has worn to `depth` [mm], by a bracketed secant search.

        With `nearby` only mesh positions are solved whose contact passes near the point; `first` is the first trial.
        """
        stepper, teeth = self.stepper, self.teeth
        low, weight = teeth.grid.bracket(point.face)
        slices = np.unique([low, min(low + 1, teeth.grid.face.size - 1)]) if weight > 0.0 else np.array([low])
        now = stepper.depth_at(point, point.wear(self.state.worn))
        increment = depth - now
        if increment <= 0.0:
            raise ConvergenceError(
                f"the control point (face {point.face:g} mm) is {now * 1e3:g} um deep already, no step wears it to "
                f"{depth * 1e3:g} um; give wear.until.control_depths_um that rise"
            )
        positions = positions_at(teeth, self.spreading.half_width, self.state, point, slices) if nearby else None
        loads: list[TeethLoads] = [loaded.loads for loaded in self.state.loaded]
        start = (self.spreading, self.motion, self.state.worn, self.weighted_loads(loads), slices)
        if point.body == DRIVEN:
            rate = stepper.coefficients.driven * stepper.depth_at(point, stepper.mapping.of_mesh(*start))
        else:
            rate = stepper.coefficients.driving * stepper.depth_at(point, driving_wear_at(*start))
        if rate <= 0.0:
            raise EndlessWearError(
                f"the control point (face {point.face:g} mm) carries no load at {self.state.meshes:.3g} meshes and "
                "wears no further: choose another wear.control_point or smaller wear.until.control_depths_um"
            )
        tried = [(0.0, -increment)]
        by_present_rate = increment / rate
        tolerance = _SMOOTH_DEPTH_TOLERANCE if teeth.smooth else _DEPTH_TOLERANCE
        trial = self.state.pace * by_present_rate if first is None else first
        for iteration in range(_DEPTH_ITERATIONS):
            if nearby and iteration == 1 and (teeth.smooth or not self.settled or not self.has_footprints_for(trial)):
                self.predict_wear(trial)
                self.settled, tried = True, tried[:1]
            self.require_influence(trial)  # found for the first trial
            loads = self.loads(self.theta * trial, positions, loads if iteration else self.predicted)
            value = stepper.depth_at(point, point.wear(self.mapped(loads, trial, slices)[0])) - depth
            if abs(value) <= tolerance * increment:
                self.pace = trial / by_present_rate
                return trial
            tried.append((trial, value))
            trial = next_trial(tried)
            close = abs(value) <= (_SAME_LOADS if iteration else _LINEAR) * increment
            if nearby and close and not teeth.smooth and self.settled and self.has_footprints_for(trial):
                self.pace = trial / by_present_rate
                return trial
            if abs(trial - tried[-1][0]) <= _NO_STEP * trial:
                break
        # the depth jumps a little where a slice comes into contact
        trial, excess = min(tried, key=lambda pair: abs(pair[1]))
        jump = _DEPTH_JUMP if stepper.factor is None or teeth.smooth else _LAW_JUMP
        if abs(excess) <= jump * increment:
            self.pace = trial / by_present_rate
            return trial
        raise ConvergenceError(
            f"no number of meshes wears the control point (face {point.face:g} mm) to {depth * 1e3:g} um: "
            "it loses its load on the way; choose another wear.control_point or smaller control depths"
        )
