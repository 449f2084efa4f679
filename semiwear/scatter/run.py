"""Scatter of a scene's fields: samples drawn, solved as a sweep, and evaluated statistically."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.arrays import FloatArray
from semiwear.emulator import LEAST_RUNS, require_emulator
from semiwear.errors import Collected, Problem, SceneError
from semiwear.scatter.design import Design, design, read_correlation
from semiwear.scatter.distributions import Distribution, median_is_the_scenes, read_distribution
from semiwear.scatter.emulated import emulated_samples, first_solved
from semiwear.scatter.statistics import Scatter
from semiwear.scene import Scene
from semiwear.scene.edit import unknown_field
from semiwear.scene.rule import Rule
from semiwear.scene.schema import schemas_of_scene
from semiwear.scene.values import is_number, is_whole, shown
from semiwear.simulate import Progress, wear_problems
from semiwear.sweep.bar import progress_receiver
from semiwear.sweep.measure import measure_of
from semiwear.sweep.run import Job, crew_of, read_job, run_job, workers_of
from semiwear.sweep.scenes import gather
from semiwear.sweep.store import open_store
from semiwear.sweep.variation import read_variation
from semiwear.untyped import Value

if TYPE_CHECKING:
    from distributed import Client

_DISTRIBUTIONS = "distributions"
_MOST_SAMPLES = 1 << 20
_LEAST_EMULATED = 1 << (LEAST_RUNS - 1).bit_length()


def scatter(
    scene: Scene,
    distributions: Mapping[str, Distribution],
    *,
    samples: int = 256,
    seed: int = 0,
    correlation: Mapping[tuple[str, str], float] | None = None,
    sensitivity: bool = False,
    confidence: float = 0.95,
    emulate: float | None = None,
    measure: str | Sequence[str] | None = None,
    crew: int | str | Client | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: Progress | bool | None = None,
) -> Scatter:
    """Life and every measured quantity of a scene whose fields scatter.

    Fields are drawn by scrambled Sobol' sequences and solved as by `sweep`. Life is exactly inverse to the wear
    coefficient, so that its scatter needs no further solutions if runs end at control depths.

    Parameters
    ----------
    scene : Scene
    distributions : mapping
        From dotted key to `Normal`, `LogNormal`, `Uniform` or `Triangular`, in the field's unit.
    samples : int
        A power of two, up to 1048576; default 256. Twice as many include the former ones; with a store only new ones
        are solved.
    seed : int
        Random seed of the sequence's scrambling. Default 0.
    correlation : mapping, optional
        Rank correlations (Spearman) of pairs of fields, such as ``{("a", "b"): 0.5}``.
    sensitivity : bool
        Whether to find Sobol' indices, which takes (number of fields + 2) times as many samples. Default: no.
    confidence : float
        Confidence level of the intervals. Default 0.95.
    emulate : float, optional
        Solve only some of the samples, and emulate the rest (extra ``infer``): greatest stated error of the emulator,
        within which 95 % of new samples lie, over a quantity's standard deviation. Further samples are solved, up to
        `samples`, until it is met; intervals of quantiles and probabilities are wider by it. Where all of them
        are solved, there is no emulator.
    measure, store, progress
        As of `sweep`; the value at the end of the run counts.
    crew : int, str or distributed.Client, optional
        Where to run: `workers` or `client` of `sweep`.

    Returns
    -------
    Scatter

    Raises
    ------
    SceneError
        With all faults, before anything runs.
    SemiwearError
        The emulator's error stays above the limit, and `sensitivity` takes more scenes than may be solved.
    MissingExtraError
        Emulation is requested without scikit-learn.

    Examples
    --------
    >>> import semiwear as sw
    >>> coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.wear_steps": 1}
    >>> scene = sw.load_scene("spur_fzg_c").replace(coarse)
    >>> found = sw.scatter(scene, {"operation.pinion_torque_Nm": sw.Normal(302.0, 15.0)}, samples=4, crew=0)
    >>> len(found.values("load_share_max"))
    4
    """
    sampling = Sampling(samples, seed, dict(correlation or {}), sensitivity, confidence, emulate)
    job = read_scatter(scene, distributions, sampling, measure=measure, crew=crew_of(crew))
    kept = open_store(store)

    def solve(sweep: Job) -> xr.Dataset:
        with progress_receiver(progress) as report:
            return run_job(sweep, kept, report)

    return job.statistics(solve)


@dataclass(frozen=True)
class Sampling:
    """Number, distribution and emulation of samples, and confidence of their intervals; arguments of `scatter`.

    Attributes
    ----------
    samples, seed : int
    correlation : mapping
    sensitivity : bool
    confidence : float
    emulate : float or None
    """

    samples: int = 256
    seed: int = 0
    correlation: Mapping[tuple[str, str], float] = field(default_factory=dict)
    sensitivity: bool = False
    confidence: float = 0.95
    emulate: float | None = None

    def problems(self) -> list[Problem]:
        """Problems of arguments out of range."""
        found: list[Problem] = []
        count, seed = self.samples, self.seed
        paired: object = self.sensitivity
        whole = is_whole(count) and 2 <= count <= _MOST_SAMPLES
        if not whole or count & (count - 1):
            nearest = 1 << max(int(count - 1).bit_length(), 1) if whole else 256
            found.append(Problem("samples", shown(count), f"a power of two, 2 to {_MOST_SAMPLES}", f"give {nearest}"))
        elif self.emulate is not None and count < _LEAST_EMULATED:
            allowed = f"{_LEAST_EMULATED} or more beside emulate"
            found.append(Problem("samples", shown(count), allowed, "fewer give no error of an emulator"))
        if not is_whole(seed) or seed < 0:
            found.append(Problem("seed", shown(seed), "a whole number, 0 or more", "give 0"))
        if not isinstance(paired, bool):
            found.append(Problem("sensitivity", shown(paired), "true or false", "leave it out for false"))
        elif self.correlation and paired:
            fix = "leave one of them out: Sobol' indices are defined for independent fields"
            found.append(Problem("sensitivity", True, "left out where fields are correlated", fix))
        if not _positive(self.confidence) or self.confidence >= 1.0:
            found.append(Problem("confidence", shown(self.confidence), "above 0 and below 1", "0.95 is usual"))
        if self.emulate is not None and not _positive(self.emulate):
            fix = "0.1 of a standard deviation, say"
            found.append(Problem("emulate", shown(self.emulate), "greater than 0", fix))
        return found


def _positive(value: Value) -> bool:
    return is_number(value) and 0.0 < value < np.inf


@dataclass(frozen=True)
class ScatterJob:
    """Samples of a scene that can be solved; made by `read_scatter`.

    Attributes
    ----------
    scene : Scene
    distributions : dict of str to Distribution
        By dotted key.
    sampling : Sampling
    drawn : Design
    job : Job
        The sweep of the samples that are solved in any case: all, or the first ones if others are emulated.
    """

    scene: Scene
    distributions: dict[str, Distribution]
    sampling: Sampling
    drawn: Design
    job: Job

    def statistics(self, solve: Callable[[Job], xr.Dataset]) -> Scatter:
        """Statistics of the samples, solved and emulated.

        Raises
        ------
        SemiwearError
            The emulator's error stays above the limit.
        """
        fields, drawn, limit = tuple(self.distributions), self.drawn, self.sampling.emulate
        if limit is None:
            return Scatter(solve(self.job), fields, drawn.count, drawn.paired, self.sampling.confidence)

        def first(count: int) -> xr.Dataset:
            if count == self.job.variation.count:
                return solve(self.job)
            variation = read_variation(self.scene, _table(drawn, fields, count), "zip")
            members, tasks = gather(self.scene, variation, self.job.measure)
            return solve(replace(self.job, variation=variation, members=members, tasks=tasks))

        found, errors = emulated_samples(first, drawn.values, self.distributions, limit, drawn.count)
        return Scatter(found, fields, drawn.count, drawn.paired, self.sampling.confidence, errors)


def read_scatter(
    scene: Scene | None,
    distributions: Mapping[str, Distribution],
    sampling: Sampling,
    *,
    measure: str | Sequence[str] | None = None,
    crew: tuple[int | str | None, Client | None] = (None, None),
    argument: str = _DISTRIBUTIONS,
) -> ScatterJob:
    """The samples of arguments of `scatter`; `crew` holds `workers` and `client` of `sweep`.

    Errors name the distributions by `argument`.

    Raises
    ------
    SceneError
        With all faults; without a scene, those that can be found without it.
    MissingExtraError
        Emulation is requested without scikit-learn.
    """
    problems: list[Problem] = []
    read, drawn = dict[str, Distribution](), None
    with Collected(problems):
        read, drawn = draw(scene, distributions, sampling, argument)
    if scene is not None:
        problems += wear_problems(scene)
    with Collected(problems):
        measure_of(measure, "last")
    problems += workers_of(*crew)[1]
    if problems or scene is None or drawn is None:
        raise SceneError(problems, "scatter")
    fields, count = tuple(distributions), len(drawn.values)
    if sampling.emulate is not None:
        require_emulator()
        count = first_solved(len(fields), drawn.count)
    table = _table(drawn, fields, count)
    job = read_job(scene, table, measure=measure, wear_states="last", combine="zip", crew=crew)
    return ScatterJob(scene, read, sampling, drawn, job)


def _table(drawn: Design, fields: Sequence[str], count: int) -> dict[str, list[float]]:
    """Values of fields in the first samples."""
    return {field: drawn.values[:count, k].tolist() for k, field in enumerate(fields)}


def draw(
    scene: Scene | None,
    distributions: Mapping[str, Distribution],
    sampling: Sampling,
    argument: str = _DISTRIBUTIONS,
) -> tuple[dict[str, Distribution], Design]:
    """The distributions of fields, and their samples; without a scene only for their faults.

    `argument` is what the caller, or the table of a study file, calls the distributions.

    Raises
    ------
    SceneError
        With all faults of distributions and sampling, including values out of a field's range.
    """
    problems = sampling.problems()
    if not isinstance(distributions, Mapping) or not distributions:
        allowed = "a mapping from dotted keys to distributions"
        fix = 'give e.g. {"operation.pinion_torque_Nm": Normal(1600, 80)}'
        if argument != _DISTRIBUTIONS:
            entry = 'operation.pinion_torque_Nm = {distribution = "normal", mean = 1600, deviation = 80}'
            fix += f"; in a study file {entry} under the header [{argument}]"
        raise SceneError([*problems, Problem(argument, shown(distributions), allowed, fix)], "scatter")
    read: dict[str, Distribution | None] = {}
    for key in distributions:
        if not _rules(scene, key):
            problems += unknown_field(scene, key, shown(distributions[key]))
    for key, raw in distributions.items():
        wrong: list[Problem] = []
        read[key] = read_distribution(key, raw, scene, wrong)
        if not _rules(scene, key):
            # what the distribution lacks may be known of the field that was meant
            wrong = [one for one in wrong if one.value is not None and one.field != key]
        problems += wrong
    matrix = read_correlation(list(read), sampling.correlation, problems)
    known = {key: own for key, own in read.items() if own is not None}
    if problems:
        raise SceneError(problems, "scatter")
    found = design(list(known.values()), sampling.samples, sampling.seed, matrix=matrix, paired=sampling.sensitivity)
    unsettled = {key for key, raw in distributions.items() if scene is None and median_is_the_scenes(key, raw)}
    ranges = {key: _rules(scene, key) for key in known if key not in unsettled}
    problems += _out_of_range(ranges, dict(zip(known, found.values.T, strict=True)))
    if problems:
        raise SceneError(problems, "scatter")
    return known, found


def _rules(scene: Scene | None, key: str) -> list[Rule]:
    """Rules of a field: of the scene's kind of gear pair, or of all that have it."""
    return [schema.rules[key] for schema in schemas_of_scene(scene) if key in schema.rules]


def _out_of_range(ranges: Mapping[str, list[Rule]], columns: Mapping[str, FloatArray]) -> list[Problem]:
    """Problems of fields whose samples are refused by every rule of theirs, one for each field."""
    problems = []
    for key, rules in ranges.items():
        drawn = columns[key]
        wrong = [x for x in drawn if rules and all(rule.apply(key, float(x))[1] is not None for rule in rules)]
        if wrong:
            distance = np.abs(np.array(wrong) - np.median(drawn))
            worst = wrong[int(np.argmax(distance))]
            allowed = " or ".join(dict.fromkeys(rule.allowed for rule in rules))
            fix = f"{len(wrong)} of {len(drawn)} samples: cut the distribution off with low and high"
            if "whole number" in allowed:
                fix = "a whole number does not scatter: vary it in a sweep"
            problems.append(Problem(key, f"samples as far out as {worst:.4g}", allowed, fix))
    return problems
