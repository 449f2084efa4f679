"""Wear steps that measure their own error and are as long as it allows.

A step is solved whole and in two halves, all three implicit and of first order. Their difference tells the error, and
their combination 2 (halves) - (whole) is better than either (Richardson 1911, Phil. Trans. R. Soc. A 210, 307-357;
step doubling with local extrapolation: Hairer, Norsett and Wanner 1993, Solving Ordinary Differential Equations I,
II.4). The combination is clipped, so that wear never shrinks.

Worn flanks are stiff: where too much is taken off, less load falls in the next step. Hence errors do not pile up as
in II.4; on worn gear flanks one third of what a step leaves is there after the next, and the difference goes with the
length of the step, not with its square.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from semiwear.errors import ConvergenceError
from semiwear.wear.mapping import Worn
from semiwear.wear.stepping import ControlPoint, Trial, WearState, WearStepper

__all__ = ["AdaptiveStepper", "Doubled", "doubled"]

_STEP_SHARE = 0.5  # of an asked accuracy; as squares, most of it is left for slices, roll positions and the like
_STEP_MOST = 0.03  # longer steps leave rough flanks, which no finer grid smoothes
_STAYS = 1.0 / 3.0  # of an error, after the next step
_LEFT = 1.2  # error of an extrapolated step, over the difference that it tells
_SAFETY = 0.9
_GROWTH = (0.3, 3.0)  # of the step's length, from one to the next
_SHORTEST = 1e-3  # of what is asked for: shorter steps would not end
_END = 1e-9  # of what is asked for

FloatArray = NDArray[np.float64]
Advance = Callable[[WearState, float], Trial]
"""A step from a state to a reading of what measures the way."""


@dataclass(frozen=True)
class Doubled:
    """A step solved whole and in two halves.

    Attributes
    ----------
    trial : Trial
        Extrapolated.
    difference : float [mm]
        Of whole and halves, root of the sum of squares over the worn flanks.
    size : float [mm]
        Of the wear at the end of the step, likewise.
    """

    trial: Trial
    difference: float
    size: float


def doubled(stepper: WearStepper, state: WearState, advance: Advance) -> Doubled:
    """A step, and it again in two halves.

    Parameters
    ----------
    stepper : WearStepper
    state : WearState
        Where it starts.
    advance : callable
        The step's trial from a state to a part of its length: 0.5 or 1.
    """
    whole = advance(state, 1.0)
    middle = stepper.commit(advance(state, 0.5))
    halves = advance(middle, 1.0)
    meshes = 2.0 * (middle.meshes + halves.meshes - state.meshes) - whole.meshes
    worn = _extrapolated(state.worn, whole.worn, halves.worn)
    trial = Trial(state, max(meshes, 0.0), halves.loads, worn, halves.pace)
    return Doubled(trial, _size(halves.worn, whole.worn), _size(worn, worn, 0.0))


def _extrapolated(start: Worn, whole: Worn, halves: Worn) -> Worn:
    driven = np.maximum(2.0 * halves.driven - whole.driven, start.driven)
    if start.driving is None or whole.driving is None or halves.driving is None:
        return Worn(driven)
    return Worn(driven, np.maximum(2.0 * halves.driving - whole.driving, start.driving))


def _size(a: Worn, b: Worn, less: float = 1.0) -> float:
    """Root of the sum of squares of one wear less another [mm]."""
    pairs = [(x, y) for x, y in zip(a, b, strict=True) if x is not None and y is not None]
    return float(np.sqrt(sum(np.sum((x - less * y) ** 2) for x, y in pairs)))


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

        def advance(now: WearState, end: float) -> Trial:
            return self.stepper.trial(now, end - now.meshes)

        return self._until(state, begin, begin + meshes, advance, lambda now: now.meshes)

    def step_to_depth(self, state: WearState, point: ControlPoint, depth: float) -> WearState:
        """The state in which the control point has worn to `depth` [mm]."""
        stepper = self.stepper

        def advance(now: WearState, end: float) -> Trial:
            return stepper.trial_to_depth(now, point, end)

        def reading(now: WearState) -> float:
            return stepper.depth_at(point, now.wear)

        return self._until(state, reading(state), depth, advance, reading)

    def _until(
        self, state: WearState, begin: float, end: float, advance: Advance, reading: Callable[[WearState], float]
    ) -> WearState:
        """Steps until the reading is at `end`."""
        now, wanted = begin, end - begin
        stride = state.stride[0] if state.stride else wanted
        while end - now > _END * wanted:
            count = max(1, int(np.ceil((end - now) / stride - _END)))
            length = (end - now) / count  # even steps to the end, none of them a splinter
            there = end if count == 1 else now + length
            try:
                step = doubled(self.stepper, state, _part(advance, now, there))
            except ConvergenceError:
                if length < _SHORTEST * wanted:
                    raise
                stride = _GROWTH[0] * length
                continue
            self.solved += 3
            # over the wear at the end of the run, which is in proportion to what measures the way
            left = _LEFT * step.difference / step.size * min(there / self.end, 1.0) if step.size > 0.0 else 0.0
            allowed = (1.0 - _STAYS) * self.tolerance
            stride = length * float(np.clip(_SAFETY * allowed / max(left, _END), *_GROWTH))
            if left > allowed and length > _SHORTEST * wanted:
                continue
            state = replace(self.stepper.commit(step.trial), error=_STAYS * state.error + left, stride=(stride,))
            now = end if count == 1 else reading(state)
        return state


def _part(advance: Advance, begin: float, end: float) -> Advance:
    """Goes to a part of the way from `begin` to `end`."""
    return lambda state, part: advance(state, begin + part * (end - begin) if part < 1.0 else end)
