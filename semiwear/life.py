"""Life until wear reaches a depth, and what it depends on: table `[effects.run_life]`.

The flanks are worn again, from unworn, in implicit steps of about equal depth, each in two stages: a life of 8 um
is 8 % too long in three plain steps, 1 % in three of two stages. Where wear nearly stops, there are more steps, each
at most 1.5 times as long as all before it. The last one ends where the greatest wear depth of a body's flank is the
limit. The end of the run itself does not matter.

Other torques take the same steps once more; their lives follow from the depth at the end, which is near the limit,
and the wear rate there. The wear coefficient needs none: a life is exactly inverse to it.

Names and units of the results are defined in `semiwear.results.schema`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import inf, log, nan

import numpy as np

from semiwear.errors import ConvergenceError, EndlessWearError
from semiwear.meshing.flank_pair import BODIES, DRIVING, FlankPair
from semiwear.plan import Plan, plan
from semiwear.scene import Scene
from semiwear.scene.effects import RunLife
from semiwear.wear.step_count import SEARCH_STEPS, life_steps_for_depth, steps_of_life
from semiwear.wear.stepping import WearState, WearStepper
from semiwear.wear.two_stage import TwoStageStepper

ReportStep = Callable[[int, int, str], None]
"""Called with the number of steps done, their total, and a description."""

_WEAR = "wear"  # end of a life that no failure mode ends
_MOST_MESHES = 1e15  # of a step, a million years at 2000 rev/min: a flank that takes longer wears no further
_GROWTH = 1.5  # of the meshes before it, the greatest length of a step that may reach the limit: see `_last_steps`
_ENDLESS = 1e30  # meshes after which a flank that wears no further is rated once more
_TORQUE_CHANGE = 0.05  # to either side: the grid's resolution of the greatest depth is 0.2 % of the life
_TOLERANCE = 1e-5  # of the limit
_ITERATIONS = 40
_JUMP = 1e-3  # of the limit: depths jump by less where a footprint moves from one border to another
_NEAR = 0.03  # of the limit: a smaller difference in depth is corrected with the wear rate, to second order


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
        Relative change of the life over that of the wear coefficients of both bodies together. Exactly -1: wear
        depends on the product of coefficient and meshes, and every law is a factor on that product. NaN of a life
        without end.
    sensitivity_to_torque : float
        Relative change of the life over that of the torque, or of all torques of a spectrum together; NaN likewise,
        and where the life has no end at 5 % more or less torque.
    states : tuple of WearState
        From unworn flanks to the limit, after the steps of the search; on flanks that wear no further, a last one
        after practically endless meshes.
    endless : str
        Reason why the life has no end; empty if it has one.
    """

    limit: float
    meshes: float
    hours: float | None
    sensitivity_to_wear_coefficient: float
    sensitivity_to_torque: float
    states: tuple[WearState, ...] = ()
    endless: str = ""


def life_group(physics: Plan, stepper: WearStepper, report: ReportStep | None = None) -> dict[str, np.ndarray]:
    """Arrays of the group `/life`; empty if the scene has no `[effects.run_life]`.

    Parameters
    ----------
    physics : Plan
    stepper : WearStepper
    report : callable, optional
        Called after every step of the search with the steps done, their total, and a description.

    Raises
    ------
    ConvergenceError
        As `find_life`. `EndlessWearError` where nothing ends the life: the flank wears no further before the limit,
        and no failure mode is to end it, or does.
    """
    if physics.scene.effects.run_life is None:
        return {}
    with physics.clock.measure("run_life"):
        life = find_life(physics, stepper, report)
    ended = _end_of(physics, stepper, life) if physics.scene.effects.run_life.ends_at == "first_failure" else {}
    if ended.get("meshes_to_end", life.meshes) == inf:
        raise EndlessWearError(life.endless, life=True)
    arrays = {
        "depth_limit": np.asarray(1e3 * life.limit),
        "meshes_to_limit": np.asarray(life.meshes),
        "sensitivity_to_wear_coefficient": np.asarray(life.sensitivity_to_wear_coefficient),
        "sensitivity_to_torque": np.asarray(life.sensitivity_to_torque),
    }
    arrays |= {} if life.hours is None else {"hours_to_limit": np.asarray(life.hours)}
    return arrays | ended


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


def find_life(physics: Plan, stepper: WearStepper, report: ReportStep | None = None) -> Life:
    """The life defined by `[effects.run_life]`; `report` as in `life_group`. Without end where wear stops before.

    Raises
    ------
    ConvergenceError
        If the flank cannot be worn to the limit, with reason and remedy.
    """
    table, pair = physics.scene.effects.run_life, stepper.teeth.pair
    assert table is not None
    body, limit = BODIES.index(table.body), 1e-3 * table.depth_limit_um
    count = life_steps_for_depth(limit, pair.base_pitch)
    counter = _Counter(report, steps_of_life(limit, pair.base_pitch), f"life until {table.depth_limit_um:g} um")
    per_mesh = hours_per_mesh(physics.scene, pair)
    try:
        counter.part("", count + SEARCH_STEPS)
        path = _path_to(replace(stepper, implicit=True), body, limit, None, counter)
        counter.finish_part()
        if path.endless:
            states = *path.states, replace(path.states[-1], meshes=_ENDLESS)
            hours = None if per_mesh is None else inf
            return Life(limit, inf, hours, nan, nan, states, _without_life(table, path.endless))
        factors = (1.0 - _TORQUE_CHANGE, 1.0 + _TORQUE_CHANGE)
        # the same steps at other torques, so that their errors cancel in the difference
        lives = []
        for factor in factors:
            counter.part(f" at {factor:g} of the torque", count)
            try:
                lives.append(_life_along(_under(physics, factor), body, limit, path, factor, counter))
            except EndlessWearError:
                lives.append(nan)
            counter.finish_part()
        low, high = lives
    except ConvergenceError as error:
        raise ConvergenceError(_without_life(table, error)) from error
    meshes = sum(path.lengths)
    hours = None if per_mesh is None else meshes * per_mesh
    return Life(limit, meshes, hours, -1.0, log(high / low) / log(factors[1] / factors[0]), tuple(path.states))


def _without_life(table: RunLife, reason: object) -> str:
    return (
        f"[effects.run_life] finds no life of the {table.body} until {table.depth_limit_um:g} um: {reason}; for the "
        "life, lower effects.run_life.depth_limit_um"
    )


def hours_per_mesh(scene: Scene, pair: FlankPair) -> float | None:
    """Running time of an engagement of one gear tooth [h]; None where the scene gives no speed."""
    speed = scene.operation.pinion_speed_rpm
    # a driven tooth meshes once per turn of its body, which takes `driving_meshes` turns of the pinion
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
        Steps to take [meshes]; the step that reaches the limit ends there. Default: steps that add
        about equal depths.

    Raises
    ------
    ConvergenceError
        If the flank loses its load before the limit. `EndlessWearError` where it wears no further.
    """
    return _ended(_path_to(stepper, body, limit, lengths, _Counter(None, 0, ""))).lengths


class _Counter:
    """Counts and reports the steps of a search of several parts, whose lengths are estimated."""

    def __init__(self, report: ReportStep | None, total: int, text: str) -> None:
        self._report, self._total, self._text = report, total, text
        self._done = self._end = 0
        self._part = ""

    def part(self, name: str, steps: int) -> None:
        """Begin a part of about `steps` steps."""
        self._part, self._end = name, self._done + steps

    def step(self) -> None:
        """Count a step; those beyond the estimate are not counted."""
        if self._done < self._end - 1:
            self._done += 1
            self._call()

    def finish_part(self) -> None:
        """Count all estimated steps of the part as done."""
        self._done = self._end
        self._call()

    def _call(self) -> None:
        if self._report is not None:
            self._report(self._done, self._total, f"{self._text}{self._part}")


@dataclass(frozen=True)
class _Path:
    """Steps to the limit [meshes], the wear rate at their end [mm a mesh], and their states.

    `endless` gives the reason if the flank wears no further before the limit.
    """

    lengths: list[float]
    rate: float
    states: list[WearState]
    endless: str = ""


def _ended(path: _Path) -> _Path:
    if path.endless:
        raise EndlessWearError(path.endless)
    return path


def _path_to(
    stepper: WearStepper, body: int, limit: float, lengths: Sequence[float] | None, count: _Counter
) -> _Path:
    scheme, now, taken = TwoStageStepper(stepper), 0.0, list[float]()
    state = scheme.start()
    passed = [state]

    def worn(begin: WearState, length: float) -> WearState:
        end = scheme.step(begin, length)
        count.step()
        return end

    steps = len(lengths) if lengths is not None else life_steps_for_depth(limit, stepper.teeth.pair.base_pitch)
    rate = limit / sum(lengths) if lengths is not None else _greatest(worn(state, 1.0), body)
    for k in range(1, steps):
        if rate <= 0.0:
            break
        length = lengths[k - 1] if lengths is not None else (limit * k / steps - now) / rate
        if length > _MOST_MESHES:
            rate = 0.0
            break
        ahead = worn(state, length)
        depth = _greatest(ahead, body)
        if depth >= limit:
            break
        rate = (depth - now) / length
        state, now = ahead, depth
        taken.append(length)
        passed.append(state)
    if rate <= 0.0:
        return _Path(taken, 0.0, passed, _stopped(body, now, limit))
    return _last_steps(worn, body, limit, rate, taken, passed)


class _StepTooLongError(Exception):
    """A step to the limit would be much longer than all before it."""


@dataclass
class _LastStep:
    """Steps of several lengths from one state towards the limit.

    Attributes
    ----------
    worn : function of a state and a length [meshes]
        The state after it.
    state : WearState
    body : int
    limit : float [mm]
    reach : float
        Greatest length that is tried [meshes].
    ends : dict
        States by length [meshes].
    depths : list of tuple
        Length [meshes] and greatest depth [mm], as they were tried.
    """

    worn: Callable[[WearState, float], WearState]
    state: WearState
    body: int
    limit: float
    reach: float
    ends: dict[float, WearState] = field(default_factory=dict)
    depths: list[tuple[float, float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.depths.append((0.0, _greatest(self.state, self.body)))

    def beyond(self, length: float) -> float:
        """Depth after a step, less the limit [mm]."""
        if length > _MOST_MESHES:
            raise EndlessWearError(_stopped(self.body, self.depths[-1][1], self.limit))
        if length > self.reach:
            raise _StepTooLongError
        self.ends[length] = self.worn(self.state, length)
        self.depths.append((length, _greatest(self.ends[length], self.body)))
        return self.depths[-1][1] - self.limit


def _last_steps(
    worn: Callable[[WearState, float], WearState],
    body: int,
    limit: float,
    rate: float,
    taken: list[float],
    passed: list[WearState],
) -> _Path:
    """The path whose last step ends at the limit, from one that ends before it.

    Where a film comes to carry nearly all load, the wear rate falls by orders of magnitude. A single implicit step
    over many times the meshes before it then has several solutions, in which the film carries all load or not, and
    ends at the limit by chance. Such a step is therefore divided.
    """
    while True:
        step = _LastStep(worn, passed[-1], body, limit, _GROWTH * sum(taken) or inf)
        now = step.depths[0][1]
        try:
            trial = (limit - now) / rate if rate > 0.0 else inf
            last = _zero_of(step.beyond, now - limit, min(trial, step.reach), _TOLERANCE * limit)
            break
        except _StepTooLongError:  # the longest step that was tried falls short of the limit, and is taken
            length = max(step.ends)
            rate = (_greatest(step.ends[length], body) - now) / length
            taken, passed = [*taken, length], [*passed, step.ends[length]]
        except EndlessWearError as error:
            return _Path(taken, 0.0, [*passed, *(step.ends[length] for length in sorted(step.ends))], str(error))
    depths = step.depths
    # slope at the end: between the last length and the one before, or one whose depth differs by more than a jump
    length_1, depth_1 = depths[-1]
    jumped = abs(depth_1 - limit) > _TOLERANCE * limit
    apart = (entry for entry in depths[-2::-1] if not jumped or abs(entry[1] - depth_1) > _JUMP * limit)
    length_0, depth_0 = next(apart, depths[0])
    slope = (depth_1 - depth_0) / (length_1 - length_0) if length_1 != length_0 else rate
    return _Path([*taken, last], slope if slope > 0.0 else rate, [*passed, step.ends[last]])


def _life_along(stepper: WearStepper, body: int, limit: float, path: _Path, factor: float, count: _Counter) -> float:
    """Life at `factor` times the torque of a known path, in its steps divided by the factor.

    The wear of a step is about proportional to torque and length, so that the depth at the end is near the limit.
    """
    scheme, lengths = TwoStageStepper(stepper), [length / factor for length in path.lengths]
    state = scheme.start()
    for length in lengths:
        state = scheme.step(state, length)
        count.step()
    missed = limit - _greatest(state, body)
    if abs(missed) > _NEAR * limit:
        return sum(_ended(_path_to(stepper, body, limit, lengths, count)).lengths)
    return sum(lengths) + missed / (factor * path.rate)


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
        spectrum = replace(spectrum, torques_Nm=tuple(factor * torque for torque in spectrum.torques_Nm))
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
    """Value at y = 0 of the polynomial x(y) through points (x, y); NaN if two of them have equal y."""
    places, values = np.array(known).T
    others = ~np.eye(len(known), dtype=bool)
    with np.errstate(divide="ignore", invalid="ignore"):
        weights = [
            np.prod(values[other] / (values[other] - value)) for other, value in zip(others, values, strict=True)
        ]
        return float(np.dot(weights, places))
