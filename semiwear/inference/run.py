"""Unknown fields of a scene from measured flanks, wear and transmission error: `infer`."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import qmc

from semiwear.arrays import FloatArray
from semiwear.errors import Collected, Problem, SceneError, SemiwearError
from semiwear.inference.model import Model, Runs, model_of
from semiwear.inference.observations import Channel, Observation, channels_of
from semiwear.inference.posterior import Posterior
from semiwear.inference.sampling import Target, draw_posterior
from semiwear.inference.unknowns import COEFFICIENT, Unknowns, unknowns_of
from semiwear.scatter.distributions import Distribution
from semiwear.scatter.run import Sampling, draw
from semiwear.scene import Scene
from semiwear.scene.values import is_number, is_whole, shown
from semiwear.simulate import Progress
from semiwear.sweep.bar import progress_receiver
from semiwear.sweep.measure import MESHES
from semiwear.sweep.outcome import Status
from semiwear.sweep.run import crew_of, read_job, solve_job, workers_of
from semiwear.sweep.store import open_store

if TYPE_CHECKING:
    from distributed import Client

# Wear steps of a run, up to the prior's greatest k: in two stages, the error of steps is 0.03 to 0.17 % of k and
# 0.002 to 0.007 of an exponent of the load on a coarse face gear, at 0.16 to 0.44 of that k
_STEPS = 24
_RUNS_A_FIELD = 10
_LEAST_RUNS = 32
_GROWTH = 4  # times the first runs, at most
_REACH = 3.5  # standard deviations of the posterior that further runs span
_LEAST_SHARE = 0.9  # of runs that have to succeed
_MOST_SHARE = 100.0  # standard deviations of an unknown by the emulator's error
_SPEED = "operation.pinion_speed_rpm"
_SAME_LEVEL = 1e-9  # of the meshes: wear states of all runs
_OF_THE_RUN = ("wear.until.", "numerics.", "effects.run_life.")  # set by an inference itself


def infer(
    scene: Scene,
    unknown: Mapping[str, Distribution],
    observed: Observation | Sequence[Observation],
    *,
    runs: int | None = None,
    emulator_share: float = 0.3,
    seed: int = 0,
    crew: int | str | Client | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: Progress | bool | None = None,
) -> Posterior:
    """The posterior of unknown fields of a scene, from measurements on worn gears.

    Parameters
    ----------
    scene : Scene
        With a table [wear]. ``numerics.accuracy`` is ignored.
    unknown : mapping
        From dotted key to the prior distribution of a field: `Normal`, `LogNormal`, `Uniform` or `Triangular`, such
        as of ``"wear.coefficient_mm2_per_N"``, ``"operation.pinion_torque_Nm"``, ``"effects.misalignment.offset_mm"``
        or ``"effects.wear_law.load.exponent"``. The outermost 0.2 % at both ends are cut off. None of ``wear.until``,
        ``numerics`` or ``effects.run_life``, which the runs set themselves.
    observed : WornFlank, WearAtPoints, TransmissionErrorCurve, Reading, or several
        Measurements, all on one pair.
    runs : int, optional
        Runs to which the emulator is fitted; up to four times as many are added in the range of the posterior, until
        its error is small enough. Default: 10 for each field but the wear coefficient, 32 or more. With only the wear
        coefficient a single run is enough, without an emulator.
    emulator_share : float
        Greatest standard deviation of an unknown by the emulator's error alone, as a fraction of its posterior
        standard deviation. The posterior includes that error in any case. Default 0.3.
    seed : int
        Random seed of runs and draws. Default 0.
    crew : int, str or distributed.Client, optional
        Where to run: `workers` or `client` of `sweep`.
    store : path, optional
        Folder that keeps every run, as of `sweep`.
    progress : Progress or bool, optional
        Called after every run and during the sampling; True shows a bar (extra ``progress``).

    Returns
    -------
    Posterior
        Draws, intervals, undetermined fields, lives.

    Raises
    ------
    SceneError
        With all faults of the arguments, before anything runs.
    SemiwearError
        The emulator's error stays above the limit, or runs fail.
    MissingExtraError
        emcee or scikit-learn is missing; install the extra ``infer``.

    Notes
    -----
    Of 600 simulated flanks with four unknowns 90 % intervals held in 87 to 90 % (docs/inference.md).
    """
    problems = workers_of(*crew_of(crew))[1]
    with Collected(problems):
        planned = plan_inference(scene, unknown, observed, runs=runs, emulator_share=emulator_share, seed=seed)
    if problems:
        raise SceneError(problems, "infer")
    with progress_receiver(progress) as report:
        return _inferred(planned, crew, store, report)


@dataclass(frozen=True)
class Plan:
    """An inference with valid arguments.

    Attributes
    ----------
    scene : Scene
        The given scene.
    unknowns : Unknowns
    channels : tuple of Channel
    runs : int
        First number of runs.
    emulator_share : float
    seed : int
    """

    scene: Scene
    unknowns: Unknowns
    channels: tuple[Channel, ...]
    runs: int
    emulator_share: float
    seed: int

    @property
    def run_scene(self) -> Scene:
        """The scene of runs, worn as far as with the greatest wear coefficient."""
        most = max(channel.meshes for channel in self.channels)
        steps = self.scene.numerics.wear_steps
        changes: dict[str, object] = {
            "wear.until.meshes": max(most, 1.0) * self.unknowns.greatest_stretch,
            "numerics.wear_steps": steps if isinstance(steps, int) else _STEPS,
            "numerics.wear_scheme": "two-stage",
            "numerics.accuracy": None,
            "effects.run_life": None,
        }
        return self.scene.replace(changes)


def plan_inference(
    scene: Scene | None,
    unknown: Mapping[str, Distribution],
    observed: Observation | Sequence[Observation],
    *,
    runs: int | None = None,
    emulator_share: float = 0.3,
    seed: int = 0,
) -> Plan:
    """An inference from arguments of `infer`.

    Raises
    ------
    SceneError
        With all faults; without a scene, those that can be found without it.
    """
    problems: list[Problem] = []
    keys = unknown if isinstance(unknown, Mapping) else ()
    if runs is not None and (not is_whole(runs) or not _LEAST_RUNS <= runs <= 4096):
        problems.append(Problem("runs", shown(runs), f"a whole number, {_LEAST_RUNS} to 4096", "leave it out"))
    if not is_number(emulator_share) or not 0.0 < emulator_share <= _MOST_SHARE:
        problems.append(
            Problem("emulator_share", shown(emulator_share), f"above 0, up to {_MOST_SHARE:g}", "0.3 is usual")
        )
    problems += [_of_the_run(key) for key in keys if isinstance(key, str) and key.startswith(_OF_THE_RUN)]
    sampling = Sampling(64, seed)
    priors: dict[str, Distribution] = {}
    with Collected(problems):
        priors, _ = draw(scene, unknown, sampling, "unknown")
    if scene is None:
        raise SceneError(problems, "infer")
    wear = scene.wear
    if wear is None:  # measured wear cannot be read without a body that wears
        fix = "give wear.coefficient_mm2_per_N, a first guess"
        raise SceneError([*problems, Problem("wear", None, "a table [wear]", fix)], "infer")
    coefficient = wear.coefficient_mm2_per_N
    if COEFFICIENT in keys and not isinstance(coefficient, float | int):
        allowed = "one number for both bodies, where it is unknown"
        problems.append(Problem(COEFFICIENT, shown(coefficient), allowed, "name one wear.worn_bodies"))
    if wear.until.hours is not None and _SPEED in keys:
        problems += _without_meshes(observed)
    channels: list[Channel] = []
    with Collected(problems):
        channels = channels_of(scene, observed)
    if problems:
        raise SceneError(problems, "infer")
    scale = float(coefficient) if isinstance(coefficient, float | int) else 1.0
    unknowns = unknowns_of(priors, scale)
    fields = len(unknowns.solved)
    count = runs or max(_LEAST_RUNS, _RUNS_A_FIELD * fields)
    planned = Plan(scene, unknowns, tuple(channels), count if fields else 1, float(emulator_share), seed)
    planned.run_scene.to_dict()  # its fields are checked
    return planned


def _of_the_run(key: str) -> Problem:
    """Problem of a field that sets the end or the numerics of a run."""
    fix = "infer the wear coefficient: it counts times the meshes" if key.startswith("wear.") else "remove it"
    return Problem(key, "an unknown field", "a field that no run sets: not of wear.until, numerics or run_life", fix)


def _without_meshes(observed: object) -> list[Problem]:
    """Problems of observations whose meshes would follow from the scene's hours at an unknown speed."""
    given = list(observed) if isinstance(observed, list | tuple) else [observed]
    fix = "give meshes: wear.until.hours has them at the speed of the scene, which is an unknown"
    return [
        Problem(f"observed[{k}].meshes" if len(given) > 1 else "observed.meshes", None, "a number", fix)
        for k, observation in enumerate(given)
        if getattr(observation, "meshes", 0.0) is None
    ]


def _inferred(
    planned: Plan, crew: int | str | Client | None, store: str | os.PathLike[str] | None, report: Progress
) -> Posterior:
    fields = len(planned.unknowns.solved)
    box = np.tile([-1.0, 1.0], (fields, 1))
    runs = solved_runs(planned, spread_over(box, planned.runs, planned.seed), crew, store, report)
    while True:
        target = target_of(planned, model_of(runs, planned.channels))
        best = target.best(planned.seed)
        errors = target.emulator_errors(best)
        shares = target.emulator_shares(best, errors)
        widened = target.widened(best)
        if not fields or shares.max() <= planned.emulator_share:
            break
        if runs.inputs.shape[0] >= (1 + _GROWTH) * planned.runs:
            raise SemiwearError(_refusal(planned, shares, runs.inputs.shape[0]))
        near = _box_about(planned.unknowns, widened, best, planned.seed)
        runs = runs.joined(
            solved_runs(
                planned, spread_over(near, planned.runs, planned.seed + runs.inputs.shape[0]), crew, store, report
            )
        )
    draws = draw_posterior(widened, best, planned.seed, report.step)
    return Posterior(planned.scene, widened, draws, best, shares)


def target_of(planned: Plan, model: Model) -> Target:
    """Posterior density of a model, without the emulator's error."""
    evidence = [channel.evidence(shapes) for channel, shapes in zip(planned.channels, model.shapes, strict=True)]
    return Target(planned.unknowns, model, planned.channels, evidence)


def _refusal(planned: Plan, shares: FloatArray, count: int) -> str:
    worst = int(np.argmax(shares))
    return (
        f"after {count} runs the emulator's error still is {shares[worst]:.2g} of the posterior's standard "
        f"deviation of {planned.unknowns.keys[worst]}, {planned.emulator_share:g} was requested: give more runs, "
        "narrower priors, or a greater emulator_share (the posterior includes the error)"
    )


def spread_over(box: FloatArray, count: int, seed: int) -> FloatArray:
    """Inputs spread evenly over a box (field, 2): a scrambled Sobol' sequence."""
    if not box.shape[0]:
        return np.zeros((1, 0))
    power = int(np.ceil(np.log2(count)))
    fraction = qmc.Sobol(box.shape[0], scramble=True, seed=np.random.default_rng(seed)).random_base2(power)[:count]
    return np.asarray(box[:, 0] + fraction * (box[:, 1] - box[:, 0]))


def _box_about(unknowns: Unknowns, target: Target, best: FloatArray, seed: int) -> FloatArray:
    """Box of inputs that the posterior takes, (field, 2), from a short chain."""
    draws = draw_posterior(target, best, seed, most=1)
    inputs = unknowns.inputs(unknowns.values(draws.normal))
    middle, spread = inputs.mean(axis=0), inputs.std(axis=0)
    low = np.clip(middle - _REACH * spread, -1.0, 1.0)
    high = np.clip(middle + _REACH * spread, -1.0, 1.0)
    thin = high - low < 1e-3
    return np.column_stack([np.where(thin, low - 1e-3, low), np.where(thin, high + 1e-3, high)]).clip(-1.0, 1.0)


def solved_runs(
    planned: Plan,
    inputs: FloatArray,
    crew: int | str | Client | None,
    store: str | os.PathLike[str] | None,
    report: Progress,
) -> Runs:
    """Runs at inputs (run, field), with predictions of all observations.

    Raises
    ------
    SemiwearError
        Too many fail.
    """
    scene, unknowns = planned.run_scene, planned.unknowns
    keys = [unknowns.every[k] for k in unknowns.solved]
    table = {unknown.key: unknown.at(inputs[:, k]).tolist() for k, unknown in enumerate(keys)}
    table = table or {"wear.until.meshes": [scene.wear.until.meshes if scene.wear else None]}
    names = list(dict.fromkeys(channel.path.rpartition("/")[2] for channel in planned.channels))
    job = read_job(scene, table, measure=names, combine="zip", crew=crew_of(crew))
    kept = open_store(store)
    solve_job(job, kept, report)
    values: list[list[FloatArray]] = []
    levels: list[FloatArray] = []
    good, reasons = [], []
    for member in job.members:
        outcome = kept.get(member.key) if member.key else None
        if outcome is None or outcome.status is not Status.DONE:
            reasons.append(member.refused if outcome is None else outcome.message)
            good.append(False)
            continue
        solved = job.tasks[member.key].scene
        values.append([channel.read(solved, outcome.measured) for channel in planned.channels])
        levels.append(np.asarray(outcome.measured.variables[MESHES], float))
        good.append(True)
    if not values or np.mean(good) < _LEAST_SHARE:
        listed = "; ".join(dict.fromkeys(reasons))
        raise SemiwearError(f"{good.count(False)} of {len(good)} runs fail: {listed}; give narrower priors")
    stacked = tuple(np.stack([own[k] for own in values]) for k in range(len(planned.channels)))
    return Runs(inputs[np.array(good)], _same_levels(levels), stacked)


def _same_levels(levels: Sequence[FloatArray]) -> FloatArray:
    """Meshes of the wear states, which all runs share.

    Raises
    ------
    SemiwearError
        They do not.
    """
    first = levels[0]
    for own in levels:
        if own.shape != first.shape or not np.allclose(own, first, rtol=_SAME_LEVEL, atol=0.0):
            raise SemiwearError("runs have wear states at different meshes: an unknown field changes how far they go")
    return first
