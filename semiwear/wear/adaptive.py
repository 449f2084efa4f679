"""Wear steps that measure their own error and are as long as it allows.

A step is solved in two stages (`two_stage`), both implicit, and the change of the wear rate between them tells the
error.

Worn flanks are stiff: where too much is taken off, less load falls in the next step. What a step leaves is made by
rates about as fast as itself, whatever its length, so that errors hardly pile up: a quarter of it is taken to be
there after the next step. Stages do not tell that the contact's shape follows the wear in cycles, nor that slices
come to bear within a step. Four times what they tell covers the error on the worn flank of the shipped scene,
nominal, misaligned and lightly loaded, at tolerances from 0.03 to 0.003: what is said is 2.5 to 6 times what is
found, and at 0.001 2.4 to 2.8 times. With cases that were not fitted (a spur pair, the tip's side, friction) it is
2.3 to 5 times what is found at 0.03 and 0.01, 1.1 to 2.7 times at 0.003 and 0.6 to 2.1 times at 0.001, the least of
them on the spur pair.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from semiwear.contact.loads import TeethLoads
from semiwear.errors import ConvergenceError
from semiwear.wear.stepping import ControlPoint, Trial, WearState, WearStepper
from semiwear.wear.two_stage import measured

__all__ = ["AdaptiveStepper"]

_STEP_SHARE = 0.5  # of an asked accuracy; as squares, most of it is left for slices, roll positions and the like
_STEP_MOST = 0.03  # longer steps leave rough flanks, which no finer grid smoothes
_STAYS = 0.25  # of an error, after the next step
_BEYOND_STAGES = 4.0  # times what the stages tell: fitted, as said above
_SAFETY = 0.9
_GROWTH = (0.3, 3.0)  # of the step's length, from one to the next
_SHORTEST = 1e-3  # of what is asked for: shorter steps would not end
_ADVANCES = 0.1  # of a step's length, that it has to get on at least
_END = 1e-9  # of what is asked for

Advance = Callable[[WearState, float, Sequence[TeethLoads] | None], Trial]
"""A step from a state to a reading of what measures the way, with loads near those to come."""


@dataclass
class AdaptiveStepper:
    """Steps in place of a `WearStepper`'s: as many as the tolerance needs.

    Attributes
    ----------
    stepper : WearStepper
        Implicit.
    tolerance : float
        Error of the wear, over the wear at the end of the run.
    end : float
        Of the run: meshes, or depth of the control point [mm].
    solved : int
        Implicit solutions so far.
    """

    stepper: WearStepper
    tolerance: float
    end: float
    solved: int = field(default=0, init=False)

    @classmethod
    def for_accuracy(cls, stepper: WearStepper, accuracy: float, end: float) -> AdaptiveStepper:
        """Steps that use up a part of an accuracy."""
        return cls(stepper, min(_STEP_SHARE * accuracy, _STEP_MOST), end)

    def start(self) -> WearState:
        """The unworn flanks."""
        return self.stepper.start()

    def step(self, state: WearState, meshes: float) -> WearState:
        """The state `meshes` engagements later."""
        begin = state.meshes

        def advance(now: WearState, end: float, near: Sequence[TeethLoads] | None) -> Trial:
            return self.stepper.trial(now, end - now.meshes, near)

        return self._until(state, begin, begin + meshes, advance, lambda now: now.meshes, 1.0)

    def step_to_depth(self, state: WearState, point: ControlPoint, depth: float) -> WearState:
        """The state in which the control point has worn to `depth` [mm]."""
        stepper = self.stepper

        def advance(now: WearState, end: float, near: Sequence[TeethLoads] | None) -> Trial:
            return stepper.trial_to_depth(now, point, end, near)

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
        """Steps until the reading is at `end`; a plain step tells its meshes where nothing else does."""
        now, wanted = begin, end - begin
        stride, per_reading = state.stride or (wanted, meshes_per_reading)
        while end - now > _END * wanted:
            count = max(1, int(np.ceil((end - now) / stride - _END)))
            length = (end - now) / count  # even steps to the end, none of them a splinter
            there = end if count == 1 else now + length
            try:
                if per_reading is None:
                    per_reading = advance(state, there, None).meshes / length
                    self.solved += 1
                step = measured(self.stepper, state, per_reading * length, _to(advance, there))
            except ConvergenceError:
                if length < _SHORTEST * wanted:
                    raise
                stride, per_reading = _GROWTH[0] * length, meshes_per_reading
                continue
            self.solved += 2
            per_reading = step.meshes / length
            # over the wear at the end of the run, which is in proportion to what measures the way
            told = _BEYOND_STAGES * step.error
            left = told / step.size * min(there / self.end, 1.0) if step.size > 0.0 else 0.0
            allowed = (1.0 - _STAYS) * self.tolerance
            stride = length * float(np.clip(_SAFETY * allowed / max(left, _END), *_GROWTH))
            if left > allowed and length > _SHORTEST * wanted:
                continue
            error = _STAYS * state.error + left
            state = replace(self.stepper.commit(step.trial), error=error, stride=(stride, per_reading))
            reached = end if count == 1 else reading(state)
            if not reached > now + _ADVANCES * length:
                raise ConvergenceError(
                    f"no wear step advances: after {now:.6g} of {end:.6g} (meshes, or mm at the control point) "
                    f"the next ends at {reached:.6g}; choose another wear.control_point, or give numerics.wear_steps "
                    "instead of numerics.accuracy"
                )
            now = reached
        return state


def _to(advance: Advance, there: float) -> Callable[[WearState, Sequence[TeethLoads] | None], Trial]:
    """Goes from a state to the end of a step."""
    return lambda state, near: advance(state, there, near)
