"""An implicit wear step in two stages: the loads after the share g of its length wear the share 1 - g.

    h_1 = h_0 + (1 - g) n f(h_a),  h_a = h_0 + g n f(h_a)
    h_2 = h_1 + g n f(h_2)

f is the wear of one mesh, n the number of meshes. Every weight is positive, so that wear never shrinks. A wear mode
of rate z per step is multiplied by (1 + (1 - 2 g) z)/(1 - g z)^2, which for g >= 1/4 is stable at every z <= 0 and
vanishes as -z grows (R. Alexander, SIAM J. Numer. Anal. 14 (1977) 1006-1021, diagonally implicit methods).

`SECOND_ORDER` is the g of adaptive steps. In steps of fixed length modes of all rates occur, and the greatest error
of any of them counts. A ripple wears away at the rate of the wear over the depth of a footprint: a step that wears m
footprint depths has rates from -m to 0, over which `first_stage_of` minimises |factor - exp(z)| (`FIRST_STAGES`,
fitted to that alone). For one footprint depth this error is 0.0023, against 0.017 of second order; for twelve and
more it is 0.047, against 0.21 of second order and 0.204 of a plain implicit step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from semiwear.contact.loads import TeethLoads
from semiwear.errors import ConvergenceError
from semiwear.wear.state import ControlPoint, Trial, WearState
from semiwear.wear.stepping import WearStepper
from semiwear.wear.worn import Worn

SECOND_ORDER = 1.0 - 0.5**0.5
FIRST_STAGES = {
    0.0: SECOND_ORDER, 0.25: 0.29922, 0.5: 0.30538, 1.0: 0.31717, 1.5: 0.3281, 2.0: 0.33807, 3.0: 0.35492,
    4.0: 0.36773, 5.0: 0.37701, 6.0: 0.38348, 8.0: 0.39071, 10.0: 0.39354, 12.0: 0.39419,
}  # fmt: skip
"""g of least error over rates from -m to 0, by m; the last one is valid for all greater m."""
ERROR_SHARE = 0.0663
"""Greatest error of a step of second order at any rate z <= 0, over the difference of the wear rates of its stages
times the step: |factor - exp(z)| over (1 - g) z^2/(1 - g z)^2, reached at z = -3.5."""

_HALVINGS = 10  # of a step to a depth
_MOST_WORN = 2.0 / 3.0  # wear of a cycle over the depth of a footprint; less than usual, since the steps are deep

ToTheEnd = Callable[[WearState, Sequence[TeethLoads] | None], Trial]
"""Trial of a plain implicit step from a state to the end of a step, with estimated loads."""


def first_stage_of(footprints: float) -> float:
    """Share g of the first stage in a step that wears this number of footprint depths."""
    return float(np.interp(footprints, list(FIRST_STAGES), list(FIRST_STAGES.values())))


@dataclass(frozen=True)
class TwoStageStepper:
    """Steps of a `WearStepper`, each in two stages.

    Attributes
    ----------
    stepper : WearStepper
        With implicit steps.
    """

    stepper: WearStepper

    @cached_property
    def _stepper(self) -> WearStepper:
        return self.stepper.fully_implicit(_MOST_WORN)

    def start(self) -> WearState:
        """The unworn flanks."""
        return self.stepper.start()

    def step(self, state: WearState, meshes: float) -> WearState:
        """The state `meshes` engagements later."""
        stepper, end = self._stepper, state.meshes + meshes
        first = _first_stage(stepper, state, meshes, None, first_stage_of(stepper.footprints_worn(state, meshes)))
        middle = stepper.commit(first)
        return stepper.commit(stepper.trial(middle, end - middle.meshes, first.loads))

    def predicted_depth(self, state: WearState, meshes: float) -> float:
        """As `WearStepper.predicted_depth`."""
        return self.stepper.predicted_depth(state, meshes)

    def step_to_depth(self, state: WearState, point: ControlPoint, depth: float, *, halvings: int = 0) -> WearState:
        """The state in which the control point has worn to `depth` [mm]; the number of meshes is solved for.

        Raises
        ------
        ConvergenceError
            The first stage goes beyond the depth however often the step has been halved.
        """
        stepper = self._stepper
        plain = stepper.trial_to_depth(state, point, depth)
        share = first_stage_of(stepper.footprints_between(state, plain.worn))
        first = _first_stage(stepper, state, plain.meshes, plain.loads, share)
        if stepper.depth_at(point, point.wear(first.worn)) >= depth:
            # the point loses its load within the step; in shorter steps it does so gradually
            if halvings == _HALVINGS:
                raise ConvergenceError(
                    f"no step of two stages wears the point (radius {point.face:g} mm) to {depth * 1e3:g} um: "
                    'it loses its load on the way; choose another wear.control_point or wear_scheme = "implicit"'
                )
            middle = 0.5 * (stepper.depth_at(point, point.wear(state.worn)) + depth)
            half = self.step_to_depth(state, point, middle, halvings=halvings + 1)
            return self.step_to_depth(half, point, depth, halvings=halvings + 1)
        last = stepper.trial_to_depth(stepper.commit(first), point, depth, plain.loads)
        return stepper.commit(replace(last, pace=plain.pace))


@dataclass(frozen=True)
class Measured:
    """A step in two stages with its estimated error.

    Attributes
    ----------
    trial : Trial
        The last stage.
    meshes : float
        Length of the step.
    error : float [mm]
        Estimated error: root of the sum of its squares over the worn flanks.
    size : float [mm]
        Root of the sum of squares of the wear at the end of the step.
    """

    trial: Trial
    meshes: float
    error: float
    size: float


def measured(stepper: WearStepper, state: WearState, meshes: float, to_the_end: ToTheEnd) -> Measured:
    """A step of second order, with its error estimated from the change between its stages.

    Parameters
    ----------
    stepper : WearStepper
        Implicit with theta = 1.
    state : WearState
    meshes : float
        Approximate length: the first stage takes a share of it, the second goes to the end.
    to_the_end : callable
    """
    first = _first_stage(stepper, state, meshes, None, SECOND_ORDER)
    trial = to_the_end(stepper.commit(first), first.loads)
    wear, earlier = trial.worn.plus(-1.0, first.worn), first.worn.plus(-1.0, state.worn)
    change = _size(wear.plus(-trial.meshes / first.meshes, earlier)) / trial.meshes
    whole = first.meshes + trial.meshes
    return Measured(trial, whole, ERROR_SHARE * whole * change, _size(trial.worn))


def _first_stage(
    stepper: WearStepper, state: WearState, meshes: float, estimate: Sequence[TeethLoads] | None, g: float
) -> Trial:
    """First stage of a step of about this length; without estimated loads it predicts them first."""
    return stepper.trial(state, (1.0 - g) * meshes, estimate, loads_after=g * meshes)


def _size(worn: Worn) -> float:
    """Root of the sum of squares of wear depths [mm]."""
    return float(np.sqrt(sum(np.sum(part**2) for part in worn if part is not None)))
