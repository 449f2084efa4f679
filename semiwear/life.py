"""Life until wear reaches a depth, and what it depends on: table `[effects.run_life]`.

The flanks are worn anew, from unworn, in implicit steps of about equal depth, each in two stages: a life of 8 um
comes out 8 % too long in three plain ones, 1 % in three of two stages. The last one ends where the greatest wear
depth of a body's flank is the limit. Where the run itself ends does not matter.

Other torques take the same steps once more; the depth at their end, which is near the limit, and the wear rate there
tell their lives. The wear coefficient takes none: a life is exactly inverse to it.

Names and units of what is told here are written in `semiwear.results.schema`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, log, nan

import numpy as np

from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.errors import ConvergenceError, EndlessWearError
from semiwear.meshing.flank_pair import BODIES, DRIVING, FlankPair
from semiwear.plan import Plan, plan
from semiwear.scene import Scene
from semiwear.scene.effects import RunLife
from semiwear.wear.step_count import SEARCH_STEPS, life_steps_for_depth, steps_of_life
from semiwear.wear.stepping import WearState, WearStepper
from semiwear.wear.two_stage import TwoStageStepper

__all__ = ["Life", "find_life", "hours_per_mesh", "life_group", "step_lengths_to"]

Heard = Callable[[int, int, str], None]
"""Hears how many steps are done, of how many, and what they are."""

_WEAR = "wear"  # what ends a life that no failure mode ends
_FOR_EVER = 1e30  # meshes: after them a flank that wears no further is rated once more
_TORQUE_CHANGE = 0.05  # to either side: from one node to the next the greatest depth leaves 0.2 % of the life open
_TOLERANCE = 1e-5  # of the limit
_ITERATIONS = 40
_JUMP = 1e-3  # of the limit: where a footprint moves from one border to another, depths jump by less
_NEAR = 0.03  # of the limit: a depth missed by less is made good by the wear rate there, to the square of that


@dataclass(frozen=True)
class Life:
    """Life of a pair of flanks.

    Attributes
    ----------
    limit : float [mm]
        Greatest wear depth at its end.
    meshes : float
        Engagements of one gear tooth until then; infinite where the flank wears no further before.
    hours : float or None
        Running time; None where the scene gives no speed.
    sensitivity_to_wear_coefficient : float
        Relative change of the life over that of the wear coefficients of both bodies together. Exactly -1: wear knows
        the coefficient only times the meshes, and every law is a factor on that product. NaN of a life without end.
    sensitivity_to_torque : float
        Relative change of the life over that of the torque, or of all torques of a spectrum together; NaN likewise.
    states : tuple of WearState
        From unworn flanks to the limit, after the steps in which it was found, or for ever on flanks that wear no
        further.
    endless : str
        Why it has no end; empty where it has one.
    """

    limit: float
    meshes: float
    hours: float | None
    sensitivity_to_wear_coefficient: float
    sensitivity_to_torque: float
    states: tuple[WearState, ...] = ()
    endless: str = ""


def life_group(
    physics: Plan, teeth: LoadedTeeth, stepper: WearStepper, heard: Heard | None = None
) -> dict[str, np.ndarray]:
    """Arrays of the group `/life`; none where the scene has no `[effects.run_life]`.

    Parameters
    ----------
    physics : Plan
    teeth : LoadedTeeth
    stepper : WearStepper
    heard : callable, optional
        Hears of every step of the search: how many are done, how many there are, and what it is.

    Raises
    ------
    ConvergenceError
        As `find_life`. `EndlessWearError` where nothing ends the life: the flank wears no further before the limit,
        and no failure mode is to end it, or does.
    """
    if physics.scene.effects.run_life is None:
        return {}
    with physics.clock.measure("run_life"):
        life = find_life(physics, teeth, stepper, heard)
    ended = _end_of(physics, stepper, life) if physics.scene.effects.run_life.ends_at == "first_failure" else {}
    if life.endless and not (ended and isfinite(ended["meshes_to_end"])):
        raise EndlessWearError(life.endless, life=True)
    arrays = {
        "depth_limit": np.asarray(1e3 * life.limit),
        "meshes_to_limit": np.asarray(_known(life.meshes)),
        "sensitivity_to_wear_coefficient": np.asarray(life.sensitivity_to_wear_coefficient),
        "sensitivity_to_torque": np.asarray(life.sensitivity_to_torque),
    }
    arrays |= {} if life.hours is None else {"hours_to_limit": np.asarray(_known(life.hours))}
    return arrays | ended


def _known(life: float) -> float:
    """A life as a result holds it: NaN without end, of which the schema says why."""
    return life if isfinite(life) else nan


def _end_of(physics: Plan, stepper: WearStepper, life: Life) -> dict[str, np.ndarray]:
    """The end of a life by the first of its depth of wear and the failure modes."""
    per_mesh = hours_per_mesh(physics.scene, stepper.teeth.pair)
    rated = physics.ratings(replace(stepper, implicit=True), life.states, per_mesh)
    assert rated is not None  # a rule of the scene
    end, ended_by = life.meshes, _WEAR
    modes = rated.arrays["meshes_to_failure"]
    if np.isfinite(modes).any() and np.nanmin(modes) < end:
        end = float(np.nanmin(modes))
        ended_by = rated.modes[int(np.nanargmin(modes)) // modes.shape[1]]
    arrays = {"meshes_to_end": np.asarray(end), "ended_by": np.asarray(ended_by)}
    return arrays | ({} if per_mesh is None else {"hours_to_end": np.asarray(end * per_mesh)})


def find_life(physics: Plan, teeth: LoadedTeeth, stepper: WearStepper, heard: Heard | None = None) -> Life:
    """The life that `[effects.run_life]` asks for; `heard` as in `life_group`. Without end where wear stops before.

    Raises
    ------
    ConvergenceError
        If the flank cannot be worn to the limit; it says why and what to change.
    """
    scene = physics.scene
    table = scene.effects.run_life
    assert table is not None
    body, limit = BODIES.index(table.body), 1e-3 * table.depth_limit_um
    count = life_steps_for_depth(limit, teeth.pair.base_pitch)
    told = _Told(heard, steps_of_life(limit, teeth.pair.base_pitch), f"life until {table.depth_limit_um:g} um")
    per_mesh = hours_per_mesh(scene, teeth.pair)
    try:
        told.part("", count + SEARCH_STEPS)
        way = _way_to(replace(stepper, implicit=True), body, limit, None, told)
        told.finish_part()
        if way.endless:
            states = *way.states, replace(way.states[-1], meshes=_FOR_EVER)
            hours = None if per_mesh is None else inf
            return Life(limit, inf, hours, nan, nan, states, _without_life(table, way.endless))
        factors = (1.0 - _TORQUE_CHANGE, 1.0 + _TORQUE_CHANGE)
        # the same steps at other torques, so that what they leave out cancels in the difference
        lives = []
        for factor in factors:
            told.part(f" at {factor:g} of the torque", count)
            lives.append(_life_along(_under(physics, factor), body, limit, way, factor, told))
            told.finish_part()
        low, high = lives
    except ConvergenceError as error:
        raise ConvergenceError(_without_life(table, error)) from error
    meshes = sum(way.lengths)
    hours = None if per_mesh is None else meshes * per_mesh
    return Life(limit, meshes, hours, -1.0, log(high / low) / log(factors[1] / factors[0]), tuple(way.states))


def _without_life(table: RunLife, reason: object) -> str:
    return (
        f"[effects.run_life] finds no life of the {table.body} until {table.depth_limit_um:g} um: {reason}; for the "
        "life, lower effects.run_life.depth_limit_um"
    )


def hours_per_mesh(scene: Scene, pair: FlankPair) -> float | None:
    """Running time of an engagement of one gear tooth [h]; None where the scene gives no speed."""
    speed = scene.operation.pinion_speed_rpm
    # a driven tooth meshes once a turn of its body, which takes as many turns of the pinion as the ratio says
    return None if speed is None else pair.driving_meshes / (60.0 * speed)


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
        If the flank loses its load before the limit. `EndlessWearError` where it wears no further.
    """
    return _ended(_way_to(stepper, body, limit, lengths, _Told(None, 0, ""))).lengths


class _Told:
    """Counts steps of a search that has several parts, whose lengths are known about, and tells of them."""

    def __init__(self, heard: Heard | None, total: int, what: str) -> None:
        self._heard, self._total, self._what = heard, total, what
        self._done = self._end = 0
        self._part = ""

    def part(self, name: str, steps: int) -> None:
        """A part of about so many steps begins."""
        self._part, self._end = name, self._done + steps

    def step(self) -> None:
        """One step is taken; those beyond what was expected count no more."""
        if self._done < self._end - 1:
            self._done += 1
            self._tell()

    def finish_part(self) -> None:
        """The part is done, whether or not it took as many steps."""
        self._done = self._end
        self._tell()

    def _tell(self) -> None:
        if self._heard is not None:
            self._heard(self._done, self._total, f"{self._what}{self._part}")


@dataclass(frozen=True)
class _Way:
    """Steps to the limit [meshes], the wear rate at their end [mm a mesh], and the states that they pass.

    Where the flank wears no further before the limit, `endless` says where.
    """

    lengths: list[float]
    rate: float
    states: list[WearState]
    endless: str = ""


def _ended(way: _Way) -> _Way:
    if way.endless:
        raise EndlessWearError(way.endless)
    return way


def _way_to(stepper: WearStepper, body: int, limit: float, lengths: Sequence[float] | None, told: _Told) -> _Way:
    scheme, now, taken = TwoStageStepper(stepper), 0.0, list[float]()
    state = scheme.start()
    passed = [state]

    def worn(begin: WearState, length: float) -> WearState:
        end = scheme.step(begin, length)
        told.step()
        return end

    steps = len(lengths) if lengths is not None else life_steps_for_depth(limit, stepper.teeth.pair.base_pitch)
    rate = limit / sum(lengths) if lengths is not None else _greatest(worn(state, 1.0), body)
    for k in range(1, steps):
        if rate <= 0.0:
            break
        length = lengths[k - 1] if lengths is not None else (limit * k / steps - now) / rate
        ahead = worn(state, length)
        depth = _greatest(ahead, body)
        if depth >= limit:
            break
        rate = (depth - now) / length
        state, now = ahead, depth
        taken.append(length)
        passed.append(state)
    if rate <= 0.0:
        return _Way(taken, 0.0, passed, _stopped(body, now, limit))
    depths = [(0.0, now)]

    tried: dict[float, WearState] = {}

    def beyond(length: float) -> float:
        tried[length] = worn(state, length)
        depths.append((length, _greatest(tried[length], body)))
        return depths[-1][1] - limit

    try:
        last = _zero_of(beyond, now - limit, (limit - now) / rate, _TOLERANCE * limit)
    except EndlessWearError as error:
        return _Way(taken, 0.0, [*passed, *(tried[length] for length in sorted(tried))], str(error))
    # of the last step's end: from the length tried last, and from the one before, or one beyond what depths jump by
    length_1, depth_1 = depths[-1]
    jumped = abs(depth_1 - limit) > _TOLERANCE * limit
    apart = (one for one in depths[-2::-1] if not jumped or abs(one[1] - depth_1) > _JUMP * limit)
    length_0, depth_0 = next(apart, depths[0])
    slope = (depth_1 - depth_0) / (length_1 - length_0) if length_1 != length_0 else rate
    return _Way([*taken, last], slope if slope > 0.0 else rate, [*passed, tried[last]])


def _life_along(stepper: WearStepper, body: int, limit: float, way: _Way, factor: float, told: _Told) -> float:
    """Life in the steps of another torque's way, `factor` times as great: each that much shorter.

    What a step wears is about in proportion to both, so that the depth at the end is near the limit.
    """
    scheme, lengths = TwoStageStepper(stepper), [length / factor for length in way.lengths]
    state = scheme.start()
    for length in lengths:
        state = scheme.step(state, length)
        told.step()
    missed = limit - _greatest(state, body)
    if abs(missed) > _NEAR * limit:
        return sum(_ended(_way_to(stepper, body, limit, lengths, told)).lengths)
    return sum(lengths) + missed / (factor * way.rate)


def _greatest(state: WearState, body: int) -> float:
    """Greatest wear depth on a body's flank [mm]."""
    worn = state.worn.driving if body == DRIVING else state.worn.driven
    return 0.0 if worn is None else float(worn.max())


def _stopped(body: int, now: float, limit: float) -> str:
    return (
        f"the {BODIES[body]} wears no further at {1e3 * now:.4g} um of {1e3 * limit:.4g} um: its wear coefficient is "
        "0 there, or a film carries all load"
    )


def _under(physics: Plan, factor: float) -> WearStepper:
    """The stepper of a scene under a multiple of its torques."""
    scene = physics.scene
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
    other = replace(other, compared=physics.compared)
    return replace(other.wear_stepper(other.loaded_teeth()), implicit=True)


def _zero_of(function: Callable[[float], float], at_zero: float, trial: float, tolerance: float) -> float:
    """Argument above 0 at which a rising function is zero, or jumps across it, by inverse interpolation in a bracket.

    Source: R. P. Brent, Algorithms for Minimization without Derivatives, 1973, ch. 4.
    """
    known = [(0.0, at_zero)]
    for _ in range(_ITERATIONS):
        value = function(trial)
        if abs(value) <= tolerance:
            return trial
        known.append((trial, value))
        below = max(x for x, y in known if y < 0.0)
        above = min((x for x, y in known if y > 0.0), default=4.0 * below)
        if above - below <= _TOLERANCE * above:
            return trial
        trial = _inverse_at_zero(known[-3:])
        if not below < trial < above:
            trial = 0.5 * (below + above)
    message = "no number of meshes wears the flank to the limit: it loses its load on the way"
    if any(y > 0.0 for _, y in known):
        raise ConvergenceError(message)
    raise EndlessWearError(message)


def _inverse_at_zero(known: Sequence[tuple[float, float]]) -> float:
    """Where the polynomial x(y) through points (x, y) has y = 0; NaN where two of them are as high."""
    places, values = np.array(known).T
    others = ~np.eye(len(known), dtype=bool)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = [
            np.prod(values[other] / (values[other] - value)) for other, value in zip(others, values, strict=True)
        ]
        return float(np.dot(shares, places))
