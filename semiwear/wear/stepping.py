"""Wear steps: from one worn flank to the next.

Implicit: within a step of dN meshes the wear that a load causes is itself a gap. Its rate (`case_step`) times t dN
joins the diagonal of the compliance, and the loads after a share t of the step are found in one solution. They hold
over all of it. Wear that answers at the rate z <= 0 per step is multiplied by

    (1 + (1 - t) z)/(1 - t z)

(the theta method), which is stable at every z for t >= 1/2. t = 1 damps all that is fast and errs by z^2/2; t = 1/2
errs in third order and damps nothing. In between, t = 3/4 halves the error of t = 1 and leaves a third of what is
fast, of the other sign. A step that wears less than three footprints' depths has nothing so fast but edges: t falls
with it, to 0.65 at two, which leaves a half. Wear never shrinks with any t: a step wears in proportion to its loads.
Explicit: the loads at the start of the step hold throughout; only for comparison.
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


# t of shallow steps and of deep ones. In deep ones of both bodies 0.75 errs least, of 1, 0.88, 0.8, 0.75 and 0.65; in
# shallow ones of three kinds of pairs 0.65 leaves half the error of loads, 0.6 more of depths
_HOLDS = (0.65, 0.75)
_TURNS = 0.75  # (1 - t) times footprints' depths that a step wears: no ripple changes sides below one
_LEAST_CYCLES, _MOST_CYCLES = 3.0, 128.0  # of an implicit step: in each the contact's shape follows the wear
_MOST_WORN = 1.0  # in a cycle, of the depth that a footprint reaches down
_ROUGHLY = (2.0, 1.5)  # cycles at least and most worn to foresee a depth: a single one leaves lives 0.4 % longer
_AS_FOLLOWED = (0.8, 1.25)  # of a step's length to that through which footprints were followed: beyond it, anew
_FORESEEN_TO = 1.0  # of a footprint's depth: where wear differs by more, footprints are followed anew
_SEARCHES = 3  # for the length of a step: beyond the first where footprints were followed anew
_DEEPEST = 0.1  # of the flank's height: beyond, sections and contact lines of the fresh tooth mean nothing
_DEPTH_TOLERANCE = 2e-5  # of the depth that a step adds
_DEPTH_MISSED = 3e-4  # of it: a smaller jump of the depth is let be
_LAW_MISSED = 1e-3  # of it under a wear law, which settles to as much of its greatest factor
_NEARLY = 3e-3  # of it: with so much less or more worn the loads of a step stay as they are
_FORETOLD = 0.03  # of it: by so much less or more a line through the start tells the length that close
_DEPTH_RATIO = (0.8, 1.25)  # of what a step wears to what is foretold: beyond, it says nothing of the next one
_DEPTH_ITERATIONS = 40
_NO_STEP = 1e-12  # of the meshes of a step
_SMOOTH_DEPTH_TOLERANCE = 1e-8  # of the same, where results are to be smooth


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
    mapping : InterpolatedWear or MarchedWear
        From loads to wear depths on the flanks.
    cases : tuple of LoadCase
        What the teeth wear under; empty for `teeth` alone.
    factor : callable or None
        On the wear coefficients, where they depend on the contact.
    depth_factor : callable or None
        On the wear coefficient of the driven flank at its present depth, (face, profile).
    most_worn : float
        Wear within an implicit step after which the contact's shape follows it, of a footprint's depth.
    hold : float, optional
        Share of an implicit step after which the loads are those that hold over it; by its depth unless given.
    spreading : LoadedTeeth, optional
        With footprints that spread as far as those of all load cases together, which say how the contact moves and
        how deep it reaches; `teeth` unless given. Every load case wears with footprints of its own width.
    """

    teeth: LoadedTeeth
    coefficients: WearMultipliers
    implicit: bool = True
    mapping: InterpolatedWear | MarchedWear = field(default_factory=InterpolatedWear)
    cases: tuple[LoadCase, ...] = ()
    factor: CoefficientFactor | None = None
    depth_factor: DepthFactor | None = None
    most_worn: float = _MOST_WORN
    hold: float | None = None
    spreading: LoadedTeeth | None = None

    @property
    def load_cases(self) -> tuple[LoadCase, ...]:
        """Load cases under which the teeth wear."""
        return self.cases or (LoadCase(1.0, self.teeth),)

    def following(self, most_worn: float) -> WearStepper:
        """The same under loads at the end of every step; the shape follows so much wear, of a footprint's depth."""
        return replace(self, most_worn=most_worn, hold=1.0)

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
            The loads that hold are those after so many meshes; by default after a share of the step (`hold`).
        """
        return self._tried(_Step(self, state, near), meshes, loads_after)

    def trial_to_depth(
        self, state: WearState, point: ControlPoint, depth: float, near: Sequence[TeethLoads] | None = None
    ) -> Trial:
        """Trial of a step to a depth of the control point [mm]; `near` as in `trial`."""
        step = _Step(self, state, near)
        wanted = depth - self.depth_at(point, point.wear(state.worn))
        foretold = wanted / state.depth_ratio
        trial = self._tried(step, step.meshes_to(point, depth - wanted + foretold, nearby=True))
        for search in range(_SEARCHES):
            missed = self.depth_at(point, point.wear(trial.worn)) - depth
            if search == 0 and abs(missed) > _DEPTH_MISSED * wanted:
                # a long step brings to the point what was far from it, and the next one about as much again
                step.depth_ratio = float(np.clip((wanted + missed) / foretold, *_DEPTH_RATIO))
            if abs(missed) <= _NEARLY * wanted:
                return replace(trial, depth_ratio=step.depth_ratio).scaled(wanted / (wanted + missed))
            trial = self._tried(step, step.meshes_to(point, depth, nearby=False, first=trial.meshes))
        return trial

    def foreseen_depth(self, state: WearState, meshes: float) -> float:
        """Greatest wear depth on either flank after a step of a length [mm], estimated at less than its price.

        An implicit step is rehearsed alone: within 10 % of what it would leave, less in most scenes.
        """
        if not self.implicit:
            return self.trial(state, meshes).worn.deepest
        worn = _Step(self, state).rehearse(meshes, roughly=True)
        self._require_teeth(worn, state, meshes)
        return worn.deepest

    def footprints_worn(self, state: WearState, meshes: float) -> float:
        """As `footprints_between` the start and the end of a step through which loads and shape of its start hold."""
        step = _Step(self, state)
        step.follow([loaded.loads for loaded in state.loaded], meshes, Cycles(1.0))
        assert step.influence is not None
        return self.footprints_between(state, step.influence.shapes[-1])

    def footprints_between(self, state: WearState, worn: Worn) -> float:
        """Greatest wear of both bodies between a state and worn flanks, in depths that a footprint reaches down."""
        force = state.contact.loads.force
        loaded = force > 0.0
        bends = self.teeth.lines.curvature[loaded]
        # a median jumps as a slice comes to bear
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
        # flanks have approached for a share of the step, which the start of a search goes on with
        loads = [
            replace(one, rotation=before.loads.rotation + (one.rotation - before.loads.rotation) / trial.hold)
            for one, before in zip(trial.loads, trial.start.loaded, strict=True)
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
        """The end of a step of known length; nothing is changed before everything has converged."""
        step.require_rehearsed(meshes, loads_after)
        loads = step.loads(step.hold * meshes if loads_after is None else loads_after)
        if not (step.follows(meshes) and step.foresaw(loads)):
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
            step.hold,
        )

    def _require_teeth(self, worn: Worn, state: WearState, meshes: float) -> None:
        height = float(np.ptp(self.teeth.grid.profile, axis=1).max())
        if not worn.deepest <= _DEEPEST * height:  # nor no number at all
            raise ConvergenceError(
                f"a step of {meshes:.3g} meshes from {state.meshes:.3g} would wear {worn.deepest:.3g} mm off a flank "
                f"{height:.3g} mm high: the tooth is gone long before; ask for fewer wear.until.meshes, "
                "less deep wear.until.control_depths_um or a smaller wear.coefficient_mm2_per_N"
            )


class _Step:
    """A step from a state, whatever its length."""

    def __init__(self, stepper: WearStepper, state: WearState, near: Sequence[TeethLoads] | None = None):
        teeth = stepper.teeth
        self.stepper, self.teeth, self.state, self.near = stepper, teeth, state, near
        self.spreading = stepper.spreading or teeth
        self.motion: Sweep = worn_sweep(teeth, self._spread_contact)
        known: Sequence[FloatArray | None] = state.corrections or [None] * len(stepper.load_cases)
        factors = stepper.factor, stepper.depth_factor
        motions = [sweep(teeth.lines, one.coarse.profile, teeth.pair.roll_per_time) for one in state.loaded]
        self.cases = [
            CaseStep(stepper.coefficients, case, loaded, motion, *factors, correction)
            for case, loaded, motion, correction in zip(stepper.load_cases, state.loaded, motions, known, strict=True)
        ]
        self.influence: StepInfluence | None = None
        self.foreseen: Sequence[TeethLoads] = ()
        self.cycles, self.followed = Cycles(1.0), 0.0  # of the influence, and the length of the step [meshes]
        self.hold = stepper.hold or _HOLDS[1]
        self.settled = bool(near or state.corrections) or not stepper.implicit
        self.pace, self.depth_ratio = state.pace, state.depth_ratio

    @property
    def _spread_contact(self) -> LoadedState:
        """The reported contact, touched as widely as wear is spread."""
        contact = self.state.contact
        if self.spreading is self.teeth:
            return contact
        return replace(contact, touched=self.spreading.touch_solved(contact.wear, contact.driving_wear))

    def loads(
        self, meshes: float, positions: Sequence[int] | None = None, start: Sequence[TeethLoads] | None = None
    ) -> list[TeethLoads]:
        """Loads of every case after so many meshes, found from `start` (those that were foreseen unless given)."""
        if not self.stepper.implicit:
            return [loaded.loads for loaded in self.state.loaded]
        starts: Sequence[TeethLoads | None] = start or self.near or self.foreseen or [None] * len(self.cases)
        roughly = positions is not None  # a depth is looked for, at which all are found anew
        pairs = zip(self.cases, starts, strict=True)
        return [case.loads(meshes, positions, one, roughly=roughly) for case, one in pairs]

    def require_rehearsed(self, whole: float, meshes: float | None = None) -> None:
        """Find the influence of loads on the wear of `whole` meshes, if unknown; `meshes` as in `rehearse`."""
        if self.influence is not None:
            return
        if self.stepper.implicit:
            self.rehearse(whole, meshes)
        else:
            self.follow([loaded.loads for loaded in self.state.loaded], whole)

    def rehearse(self, whole: float, meshes: float | None = None, *, roughly: bool = False) -> Worn:
        """Flanks that the step leaves under loads that are foreseen; on the way they correct the own wear of lines.

        Parameters
        ----------
        whole : float
            Length of the step.
        meshes : float, optional
            After which loads are foreseen; a share `hold` of the step by default.
        roughly : bool
            In fewer cycles.
        """
        meshes = self.hold * whole if meshes is None else meshes
        for case in self.cases:
            case.prepare(meshes)
        starts: Sequence[TeethLoads | None] = self.foreseen or [None] * len(self.cases)
        loads = self.near or [case.foreseen_loads(meshes, one) for case, one in zip(self.cases, starts, strict=True)]
        self.foreseen = loads
        self.follow(loads, whole, partial(self._cycles_to, roughly=roughly))
        assert self.influence is not None
        worn = self.influence.at(meshes / whole)
        for case, one in zip(self.cases, loads, strict=True):
            case.correct(worn, one, meshes)
        return self.influence.shapes[-1]

    def follow(self, loads: Sequence[TeethLoads], meshes: float, cycles: CyclesTo | None = None) -> None:
        """Let loads wear the flanks in cycles, after each of which the contact's shape follows the wear."""
        self.influence = self.stepper.mapping.followed(
            self.spreading,
            self.motion,
            self.state.worn,
            self.weighted_loads(loads),
            self.stepper.multipliers(meshes),
            cycles or self.cycles,
        )
        self.followed = meshes

    def follows(self, meshes: float) -> bool:
        """Whether footprints were followed through a step of about this length; of any, if nothing follows loads."""
        low, high = _AS_FOLLOWED
        return not self.stepper.implicit or low <= meshes / self.followed <= high

    def foresaw(self, loads: Sequence[TeethLoads]) -> bool:
        """Whether footprints were followed under about these loads.

        By what the line loads differ, places wear more or less: in as many cycles as a step has, by that part of so
        many footprints' depths. Where it is more than one, loads that follow the shape of others leave ripples.
        """
        if self.teeth.smooth and not self.settled:  # before own wear was corrected; no limit in smooth results
            return False
        assert self.influence is not None
        found = [one.line_load for one in by_width(self.spreading, self.weighted_loads(loads))]
        return self.influence.differs_from(found) * self.cycles.number <= _FORESEEN_TO

    def _cycles_to(self, worn: Worn, *, roughly: bool = False) -> Cycles:
        """Cycles of a step that would leave these flanks, if the shape of its start held.

        A ripple in a flank is worn away at the rate of the wear over the depth that a footprint reaches down. Where
        twice that depth is worn in a cycle whose footprints are found at its start, or once where they are found in
        its middle, it would come out greater on the other side: they are found the farther ahead, the less is worn.
        """
        footprints = self.stepper.footprints_between(self.state, worn)
        least, most_worn = _ROUGHLY if roughly else (_LEAST_CYCLES, self.stepper.most_worn)
        number = footprints / most_worn
        if not self.teeth.smooth:  # which takes a part of one
            number = np.ceil(number)
        number = float(np.clip(number, least, _MOST_CYCLES))
        self.cycles = Cycles(number, float(np.clip(2.0 * (1.0 - footprints / number), 0.0, 1.0)))
        if self.stepper.hold is None:
            self.hold = float(np.clip(1.0 - _TURNS / max(footprints, _TURNS), *_HOLDS))
        return self.cycles

    @property
    def law_residual(self) -> float:
        """Greatest of the load cases."""
        return max(case.law_residual for case in self.cases)

    def weighted_loads(self, loads: Sequence[TeethLoads]) -> list[WeightedLoads]:
        """The cases' parts in the wear."""
        return [case.weighted(one) for case, one in zip(self.cases, loads, strict=True)]

    @property
    def corrections(self) -> tuple[FloatArray, ...]:
        """Of the own wear of every line, by load case; empty in an explicit step."""
        return tuple(case.correction for case in self.cases if case.correction is not None)

    def mapped(
        self, loads: Sequence[TeethLoads], meshes: float, slices: IntArray | None = None
    ) -> tuple[Worn, FloatArray]:
        """Wear at the end of the step [mm], and what it takes off the edges of both bodies [mm^3]."""
        if slices is None:
            slices = np.arange(self.teeth.grid.face.size)
        assert self.influence is not None
        multipliers = self.stepper.multipliers(meshes)
        return self.stepper.mapping.worn(self.influence, self.weighted_loads(loads), multipliers, slices)

    def meshes_to(self, point: ControlPoint, depth: float, *, nearby: bool, first: float | None = None) -> float:
        """Meshes after which the control point has worn to `depth` [mm]: a secant held in its bracket.

        With `nearby` only the mesh positions are solved whose contact passes near the point; `first` is tried first.
        """
        stepper, teeth = self.stepper, self.teeth
        low, weight = teeth.grid.bracket(point.face)
        slices = np.unique([low, min(low + 1, teeth.grid.face.size - 1)]) if weight > 0.0 else np.array([low])
        now = stepper.depth_at(point, point.wear(self.state.worn))
        wanted = depth - now
        if wanted <= 0.0:
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
        known = [(0.0, -wanted)]
        promised = wanted / rate
        tolerance = _SMOOTH_DEPTH_TOLERANCE if teeth.smooth else _DEPTH_TOLERANCE
        trial = self.state.pace * promised if first is None else first
        for iteration in range(_DEPTH_ITERATIONS):
            if nearby and iteration == 1 and (teeth.smooth or not self.settled or not self.follows(trial)):
                self.rehearse(trial)
                self.settled, known = True, known[:1]
            self.require_rehearsed(trial)  # for the first length that is asked for
            loads = self.loads(self.hold * trial, positions, loads if iteration else self.foreseen)
            value = stepper.depth_at(point, point.wear(self.mapped(loads, trial, slices)[0])) - depth
            if abs(value) <= tolerance * wanted:
                self.pace = trial / promised
                return trial
            known.append((trial, value))
            trial = next_trial(known)
            near = _NEARLY if iteration else _FORETOLD
            if nearby and not teeth.smooth and self.settled and self.follows(trial) and abs(value) <= near * wanted:
                self.pace = trial / promised  # what is missed still is so little that loads stay as they are
                return trial
            if abs(trial - known[-1][0]) <= _NO_STEP * trial:
                break
        # where a slice comes into contact the depth jumps, by little
        trial, missed = min(known, key=lambda one: abs(one[1]))
        let_be = _DEPTH_MISSED if stepper.factor is None or teeth.smooth else _LAW_MISSED
        if abs(missed) <= let_be * wanted:
            self.pace = trial / promised
            return trial
        raise ConvergenceError(
            f"no number of meshes wears the control point (face {point.face:g} mm) to {depth * 1e3:g} um: "
            "it loses its load on the way; choose another wear.control_point or smaller control depths"
        )
