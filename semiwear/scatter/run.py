"""Scatter of a scene's fields: samples drawn, solved as a sweep, and told as statistics."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.errors import Problem, SceneError
from semiwear.scatter.design import Design, design, read_correlation
from semiwear.scatter.distributions import Distribution, read_distribution
from semiwear.scatter.emulated import emulated_samples
from semiwear.scatter.statistics import Scatter
from semiwear.scene import Scene
from semiwear.scene.edit import edited
from semiwear.scene.schema import schema_of_scene
from semiwear.scene.values import shown
from semiwear.simulate import Progress
from semiwear.sweep.bar import hearing
from semiwear.sweep.run import crew_of, read_job, run_job
from semiwear.sweep.store import open_store

if TYPE_CHECKING:
    from distributed import Client

__all__ = ["Sampling", "draw", "scatter"]

_MOST_SAMPLES = 1 << 20


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
    coefficient, so that its scatter takes no solution of its own where runs end at control depths.

    Parameters
    ----------
    scene : Scene
    distributions : mapping
        From dotted key to `Normal`, `LogNormal`, `Uniform` or `Triangular`, in the field's unit.
    samples : int
        A power of two. Twice as many contain the ones before; with a store only new ones are solved.
    seed : int
        Of the sequence's scrambling.
    correlation : mapping, optional
        Rank correlations (Spearman) of pairs of fields, such as ``{("a", "b"): 0.5}``.
    sensitivity : bool
        Whether Sobol' indices are wanted, which takes (number of fields + 2) times as many samples.
    confidence : float
        Of the intervals. Default 0.95.
    emulate : float, optional
        Solve only some of the samples, and let an emulator (extra ``infer``) tell the rest: its stated error, which
        95 % of fresh samples keep, may be so much of a quantity's standard deviation. Further samples are solved, up
        to `samples`, until it is; intervals of quantiles and probabilities are wider by it.
    measure, store, progress
        As of `sweep`; of every quantity the value at the end of the run counts.
    crew : int, str or distributed.Client, optional
        Where to run: `workers` or `client` of `sweep`.

    Returns
    -------
    Scatter

    Raises
    ------
    SceneError
        With everything that is wrong, before anything runs.
    SemiwearError
        The emulator's error stays above what was asked.

    Examples
    --------
    >>> import semiwear as sw
    >>> coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.wear_steps": 1}
    >>> scene = sw.load_scene("spur_fzg_c").replace(coarse)
    >>> found = sw.scatter(scene, {"operation.pinion_torque_Nm": sw.Normal(302.0, 15.0)}, samples=4, crew=0)
    >>> len(found.values("load_share_max"))
    4
    """
    problems: list[Problem] = []
    if emulate is not None and (isinstance(emulate, bool) or not isinstance(emulate, int | float) or not emulate > 0):
        problems.append(Problem("emulate", shown(emulate), "greater than 0", "0.1 of a standard deviation, say"))
    if isinstance(confidence, bool) or not isinstance(confidence, int | float) or not 0.0 < confidence < 1.0:
        problems.append(Problem("confidence", shown(confidence), "above 0 and below 1", "0.95 is usual"))
    try:
        drawn = draw(scene, distributions, Sampling(samples, seed, dict(correlation or {}), sensitivity))
    except SceneError as error:
        raise SceneError([*problems, *error.problems], "scatter") from None
    if problems:
        raise SceneError(problems, "scatter")
    fields = tuple(distributions)
    kept = open_store(store)

    def solve(count: int) -> xr.Dataset:
        table = {field: drawn.values[:count, k].tolist() for k, field in enumerate(fields)}
        job = read_job(scene, table, measure=measure, wear_states="last", combine="zip", crew=crew_of(crew))
        with hearing(progress) as hears:
            return run_job(job, kept, hears)

    if emulate is None:
        return Scatter(solve(len(drawn.values)), fields, drawn.count, drawn.paired, confidence)
    priors = {key: one for key, raw in distributions.items() if (one := read_distribution(key, raw, scene, []))}
    found, errors = emulated_samples(solve, drawn.values, priors, emulate, drawn.count)
    return Scatter(found, fields, drawn.count, drawn.paired, confidence, errors)


@dataclass(frozen=True)
class Sampling:
    """How samples are drawn; arguments of `scatter`.

    Attributes
    ----------
    samples, seed : int
    correlation : mapping
    sensitivity : bool
    """

    samples: int
    seed: int
    correlation: Mapping[tuple[str, str], float]
    sensitivity: bool


def draw(scene: Scene, distributions: Mapping[str, Distribution], sampling: Sampling) -> Design:
    """The samples of fields.

    Raises
    ------
    SceneError
        With everything that is wrong with distributions and sampling, values out of a field's range included.
    """
    problems: list[Problem] = []
    if not isinstance(distributions, Mapping) or not distributions:
        allowed = "a mapping from dotted keys to distributions"
        fix = 'give e.g. {"operation.pinion_torque_Nm": Normal(1600, 80)}'
        raise SceneError.of("distributions", shown(distributions), allowed, fix)
    count, seed = sampling.samples, sampling.seed
    whole = isinstance(count, int) and not isinstance(count, bool) and 2 <= count <= _MOST_SAMPLES
    if not whole or count & (count - 1):
        near = 1 << max(int(count - 1).bit_length(), 1) if whole else 256
        problems.append(Problem("samples", shown(count), f"a power of two, 2 to {_MOST_SAMPLES}", f"give {near}"))
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        problems.append(Problem("seed", shown(seed), "a whole number, 0 or more", "give 0"))
    schema = schema_of_scene(scene)
    for key in distributions:
        if key not in schema.rules:
            problems += edited(scene, {key: 0.0})[1]
    read = {key: read_distribution(key, raw, scene, problems) for key, raw in distributions.items()}
    matrix = read_correlation(list(read), sampling.correlation, problems)
    if sampling.correlation and sampling.sensitivity:
        fix = "leave one of them out: shares of the variance are defined for independent fields"
        problems.append(Problem("sensitivity", True, "left out where fields are correlated", fix))
    known = {key: one for key, one in read.items() if one is not None}
    if problems:
        raise SceneError(problems, "scatter")
    found = design(list(known.values()), count, seed, matrix=matrix, paired=sampling.sensitivity)
    problems += _out_of_range(scene, known, found)
    if problems:
        raise SceneError(problems, "scatter")
    return found


def _out_of_range(scene: Scene, known: Mapping[str, Distribution], found: Design) -> list[Problem]:
    """Fields whose samples are refused, each once."""
    rules, problems = schema_of_scene(scene).rules, []
    for k, key in enumerate(known):
        if key not in rules:
            continue
        wrong = [value for value in found.values[:, k] if rules[key].apply(key, float(value))[1] is not None]
        if wrong:
            away = np.abs(np.array(wrong) - np.median(found.values[:, k]))
            worst = wrong[int(np.argmax(away))]
            fix = f"{len(wrong)} of {len(found.values)} samples: cut the distribution off with low and high"
            if "whole number" in rules[key].allowed:
                fix = "a whole number does not scatter: vary it in a sweep"
            problems.append(Problem(key, f"samples as far out as {worst:.4g}", rules[key].allowed, fix))
    return problems
