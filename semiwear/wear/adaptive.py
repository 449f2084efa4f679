"""Adaptive wear steps: each as long as its estimated error allows.

A step is solved in two implicit stages (`two_stage`); the change of the wear rate between them gives the error
estimate.

Wear is a stiff process: where a step removes too much, the next step carries less load there. Errors of earlier steps
therefore decay quickly; a quarter of a step's error is assumed to be left after the next step. The stages do not see
that the contact geometry is updated in cycles, nor that slices come into contact within a step. Their estimate is
multiplied by four. This factor was fitted on the shipped scene, nominal, misaligned and lightly loaded, at tolerances
from 0.03 to 0.003: there the estimate is 2.5 to 6 times the true error, and 2.4 to 2.8 times at 0.001. In cases that
were not fitted (a spur pair, the tip's side, friction) it is 2.3 to 5 times the true error at 0.03 and 0.01, 1.1 to
2.7 times at 0.003 and 0.6 to 2.1 times at 0.001, the least of them for the spur pair.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from semiwear.contact.loads import TeethLoads
from semiwear.errors import ConvergenceError
from semiwear.wear.stepping import ControlPoint, Trial, WearState, WearStepper
from semiwear.wear.two_stage import measured

_STEP_SHARE = 0.5  # of the requested accuracy; errors add as squares, so that most of it is left for the grids
_STEP_MOST = 0.03  # longer steps leave rough flanks, which a finer grid does not smooth
_REMAINS = 0.25  # share of an error that is left after the next step
_BEYOND_STAGES = 4.0  # error over the estimate of the stages: fitted, see above
_SAFETY = 0.9
_GROWTH = (0.3, 3.0)  # of the step's length from one step to the next
_SHORTEST = 1e-3  # length of a step over that of the run: shorter steps would not end
_LEAST_ADVANCE = 0.1  # of a step's length
_END = 1e-9  # of the length of the run

Advance = Callable[[WearState, float, Sequence[TeethLoads] | None], Trial]
"""Trial of a step from a state to a value of the measure of progress, with estimated loads."""


@dataclass
class AdaptiveStepper:
    """Steps of a `WearStepper` whose number follows from a tolerance.

    Attributes
    ----------
    stepper : WearStepper
        With implicit steps.
    tolerance : float
        Error of the wear, over the wear at the end of the run.
    end : float
        End of the run: meshes, or depth of the control point [mm].
    solved : int
        Number of implicit steps solved so far.
    """

    stepper: WearStepper
    tolerance: float
    end: float
    solved: int = field(default=0, init=False)

    @classmethod
    def for_accuracy(cls, stepper: WearStepper, accuracy: float, end: float) -> AdaptiveStepper:
        """Steps whose error is a part of the accuracy."""
        return cls(stepper, min(_STEP_SHARE * accuracy, _STEP_MOST), end)

    def start(self) -> WearState:
        """The unworn flanks."""
        return self.stepper.start()

    def step(self, state: WearState, meshes: float) -> WearState:
        """The state `meshes` engagements later."""
        begin = state.meshes

        def advance(now: WearState, end: float, estimate: Sequence[TeethLoads] | None) -> Trial:
            return self.stepper.trial(now, end - now.meshes, estimate)

        return self._until(state, begin, begin + meshes, advance, lambda now: now.meshes, 1.0)

    def step_to_depth(self, state: WearState, point: ControlPoint, depth: float) -> WearState:
        """The state in which the control point has worn to `depth` [mm]."""
        stepper = self.stepper

        def advance(now: WearState, end: float, estimate: Sequence[TeethLoads] | None) -> Trial:
            return stepper.trial_to_depth(now, point, end, estimate)

        def reading(now: WearState) -> float:
            return stepper.depth_at(point, point.wear(now.worn))

        return self._until(state, reading(state), depth, advance, reading)

    def _until(
        self,
        state: WearState,
        begin: float,
        end: float,
        advance: Advance,
        reading: Callable[[WearState], float],
        meshes_per_reading: float | None = None,
    ) -> WearState:
        """Steps until the reading is at `end`; a plain step gives the meshes per reading where they are unknown."""
        now, whole = begin, end - begin
        stride, per_reading = state.stride or (whole, meshes_per_reading)
        while end - now > _END * whole:
            count = max(1, int(np.ceil((end - now) / stride - _END)))
            length = (end - now) / count  # equal steps to the end
            target = end if count == 1 else now + length
            try:
                if per_reading is None:
                    per_reading = advance(state, target, None).meshes / length
                    self.solved += 1
                step = measured(self.stepper, state, per_reading * length, _to(advance, target))
            except ConvergenceError:
                if length < _SHORTEST * whole:
                    raise
                stride, per_reading = _GROWTH[0] * length, meshes_per_reading
                continue
            self.solved += 2
            per_reading = step.meshes / length
            # relative to the wear at the end of the run, which is about proportional to the reading
            error = _BEYOND_STAGES * step.error
            added = error / step.size * min(target / self.end, 1.0) if step.size > 0.0 else 0.0
            allowed = (1.0 - _REMAINS) * self.tolerance
            stride = length * float(np.clip(_SAFETY * allowed / max(added, _END), *_GROWTH))
            if added > allowed and length > _SHORTEST * whole:
                continue
            error = _REMAINS * state.error + added
            state = replace(self.stepper.commit(step.trial), error=error, stride=(stride, per_reading))
            reached = end if count == 1 else reading(state)
            if not reached > now + _LEAST_ADVANCE * length:
                raise ConvergenceError(
                    f"no wear step advances: after {now:.6g} of {end:.6g} (meshes, or mm at the control point) "
                    f"the next ends at {reached:.6g}; choose another wear.control_point, or give numerics.wear_steps "
                    "instead of numerics.accuracy"
                )
            now = reached
        return state


def _to(advance: Advance, target: float) -> Callable[[WearState, Sequence[TeethLoads] | None], Trial]:
    """Trial of a step from a state to the target reading."""
    return lambda state, estimate: advance(state, target, estimate)
