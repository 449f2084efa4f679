"""Life until wear reaches a depth, and what it depends on: table `[effects.run_life]`.

The flanks are worn anew, from unworn, in implicit steps of about equal depth, each in two stages: a life of 8 um
comes out 8 % too long in three plain ones, 1 % in three of two stages. The last one ends where the greatest wear
depth of a body's flank is the limit. Where the run itself ends does not matter.

Names and units of what is told here are written in `semiwear.results.schema`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import ceil, log

import numpy as np

from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.errors import ConvergenceError
from semiwear.meshing.flank_pair import BODIES, DRIVING
from semiwear.plan import Plan, plan
from semiwear.scene import Scene
from semiwear.wear.stepping import WearState, WearStepper
from semiwear.wear.two_stage import TwoStageStepper

__all__ = ["Life", "find_life", "life_group", "step_lengths_to"]

_DEPTH_A_STEP = 6e-3  # mm, as an automatic wear step
_STEPS = (3, 40)
_TORQUE_CHANGE = 0.05  # to either side: from one node to the next the greatest depth leaves 0.2 % of the life open
_TOLERANCE = 1e-5  # of the limit
_ITERATIONS = 40


@dataclass(frozen=True)
class Life:
    """Life of a pair of flanks.

    Attributes
    ----------
    limit : float [mm]
        Greatest wear depth at its end.
    meshes : float
        Engagements of one gear tooth until then.
    hours : float or None
        Running time; None where the scene gives no speed.
    sensitivity_to_wear_coefficient : float
        Relative change of the life over that of the wear coefficients of both bodies together. Exactly -1: wear knows
        the coefficient only times the meshes, and every law is a factor on that product.
    sensitivity_to_torque : float
        Relative change of the life over that of the torque, or of all torques of a spectrum together.
    """

    limit: float
    meshes: float
    hours: float | None
    sensitivity_to_wear_coefficient: float
    sensitivity_to_torque: float


def life_group(physics: Plan, teeth: LoadedTeeth, stepper: WearStepper) -> dict[str, np.ndarray]:
    """Arrays of the group `/life`; none where the scene has no `[effects.run_life]`.

    Raises
    ------
    ConvergenceError
        As `find_life`.
    """
    if physics.scene.effects.run_life is None:
        return {}
    with physics.clock.measure("run_life"):
        life = find_life(physics, teeth, stepper)
    arrays = {
        "depth_limit": np.asarray(1e3 * life.limit),
        "meshes_to_limit": np.asarray(life.meshes),
        "sensitivity_to_wear_coefficient": np.asarray(life.sensitivity_to_wear_coefficient),
        "sensitivity_to_torque": np.asarray(life.sensitivity_to_torque),
    }
    return arrays | ({} if life.hours is None else {"hours_to_limit": np.asarray(life.hours)})


def find_life(physics: Plan, teeth: LoadedTeeth, stepper: WearStepper) -> Life:
    """The life that `[effects.run_life]` asks for.

    Raises
    ------
    ConvergenceError
        If the flank cannot be worn to the limit; it says why and what to change.
    """
    scene = physics.scene
    table = scene.effects.run_life
    assert table is not None
    body, limit = BODIES.index(table.body), 1e-3 * table.depth_limit_um
    try:
        lengths = step_lengths_to(replace(stepper, implicit=True), body, limit)
        factors = (1.0 - _TORQUE_CHANGE, 1.0 + _TORQUE_CHANGE)
        # the same steps at other torques, so that what they leave out cancels in the difference
        low, high = (
            sum(step_lengths_to(_under(scene, factor), body, limit, [length / factor for length in lengths]))
            for factor in factors
        )
    except ConvergenceError as error:
        raise ConvergenceError(
            f"[effects.run_life] finds no life of the {table.body} until {table.depth_limit_um:g} um: {error}; for "
            "the life, lower effects.run_life.depth_limit_um"
        ) from error
    meshes = sum(lengths)
    speed = scene.operation.pinion_speed_rpm
    # a driven tooth meshes once a turn of its body, which takes as many turns of the pinion as the ratio says
    hours = None if speed is None else meshes * teeth.pair.driving_meshes / (60.0 * speed)
    return Life(limit, meshes, hours, -1.0, log(high / low) / log(factors[1] / factors[0]))


def step_lengths_to(
    stepper: WearStepper, body: int, limit: float, lengths: Sequence[float] | None = None
) -> list[float]:
    """Lengths of wear steps from unworn flanks to a greatest depth on a body's flank; their sum is the life.

    Parameters
    ----------
    stepper : WearStepper
        Implicit.
    body : int
    limit : float [mm]
    lengths : sequence of float, optional
        Steps to take [meshes], of which the last to begin before the limit ends there. Default: steps that add
        about equal depths.

    Raises
    ------
    ConvergenceError
        If the flank stops wearing before the limit.
    """
    scheme, now, taken = TwoStageStepper(stepper), 0.0, list[float]()
    state = scheme.start()
    steps = len(lengths) if lengths is not None else int(np.clip(ceil(limit / _DEPTH_A_STEP), *_STEPS))
    rate = limit / sum(lengths) if lengths is not None else _greatest(scheme.step(state, 1.0), body)
    for k in range(1, steps):
        _must_wear(rate, body, now, limit)
        length = lengths[k - 1] if lengths is not None else (limit * k / steps - now) / rate
        ahead = scheme.step(state, length)
        depth = _greatest(ahead, body)
        if depth >= limit:
            break
        rate = (depth - now) / length
        state, now = ahead, depth
        taken.append(length)
    _must_wear(rate, body, now, limit)

    def beyond(length: float) -> float:
        return _greatest(scheme.step(state, length), body) - limit

    return [*taken, _zero_of(beyond, now - limit, (limit - now) / rate, _TOLERANCE * limit)]


def _greatest(state: WearState, body: int) -> float:
    """Greatest wear depth on a body's flank [mm]."""
    worn = state.worn.driving if body == DRIVING else state.worn.driven
    return 0.0 if worn is None else float(worn.max())


def _must_wear(rate: float, body: int, now: float, limit: float) -> None:
    if rate <= 0.0:
        raise ConvergenceError(
            f"the {BODIES[body]} wears no further at {1e3 * now:.4g} um of {1e3 * limit:.4g} um: its wear "
            "coefficient is 0 there, or a film carries all load"
        )


def _under(scene: Scene, factor: float) -> WearStepper:
    """The stepper of the scene under a multiple of its torques."""
    torque = factor * scene.operation.pinion_torque_Nm
    spectrum = scene.effects.load_spectrum
    if spectrum is not None:
        spectrum = replace(spectrum, torques_Nm=tuple(factor * one for one in spectrum.torques_Nm))
    other = plan(
        replace(
            scene,
            operation=replace(scene.operation, pinion_torque_Nm=torque),
            effects=replace(scene.effects, load_spectrum=spectrum),
        )
    )
    return replace(other.wear_stepper(other.loaded_teeth()), implicit=True)


def _zero_of(function: Callable[[float], float], at_zero: float, trial: float, tolerance: float) -> float:
    """Argument above 0 at which a rising function is zero: a secant held in its bracket."""
    known = [(0.0, at_zero)]
    for _ in range(_ITERATIONS):
        value = function(trial)
        if abs(value) <= tolerance:
            return trial
        known.append((trial, value))
        below = max(x for x, y in known if y < 0.0)
        above = min((x for x, y in known if y > 0.0), default=4.0 * below)
        (x_0, y_0), (x_1, y_1) = known[-2:]
        trial = x_1 - y_1 * (x_1 - x_0) / (y_1 - y_0) if y_1 != y_0 else above
        if not below < trial < above:
            trial = 0.5 * (below + above)
    raise ConvergenceError("no number of meshes wears the flank to the limit: it loses its load on the way")
