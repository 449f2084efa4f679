"""Draws of the posterior of unknown fields, given the observations (emcee; Goodman and Weare 2010)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.errors import MissingExtraError
from semiwear.inference.evidence import Evidence
from semiwear.inference.model import Model
from semiwear.inference.observations import Channel
from semiwear.inference.unknowns import Unknowns
from semiwear.untyped import Value

_WALKERS = 32
_TRIALS = 2000  # of the prior, from which walkers start
_ROUNDS, _BEST_TRIALS = 20, 40  # of the search for the most likely point, and trials kept in it
_BLOCK, _MOST_BLOCKS = 400, 15  # steps
_SETTLED = 50.0  # autocorrelation times that a chain has to last (emcee's own rule)
_KEPT = 4000  # draws, about
_STEP = 0.05  # of a standard normal coordinate, for derivatives
_NEAR = 0.7  # of half the range: runs this near to the best fit give the emulator's error there
_LEAST_NEAR = 16


@dataclass(frozen=True)
class Target:
    """Posterior density, in coordinates that are standard normal under the prior."""

    unknowns: Unknowns
    model: Model
    channels: Sequence[Channel]
    evidence: Sequence[Evidence]

    def log_density(self, normal: FloatArray) -> FloatArray:
        """Logarithm of the density, up to a constant, at (point, unknown): (point,)."""
        amounts = self.amounts(normal)
        likelihood = sum(evidence.log_likelihood(own) for evidence, own in zip(self.evidence, amounts, strict=True))
        return np.asarray(likelihood - 0.5 * np.sum(normal**2, axis=1))

    def amounts(self, normal: FloatArray) -> list[FloatArray]:
        """Amounts of the shapes of every channel, at (point, unknown)."""
        values = self.unknowns.values(normal)
        meshes = self.unknowns.stretch(values)[:, None] * np.array([channel.meshes for channel in self.channels])
        return self.model.amounts(self.unknowns.inputs(values), meshes)

    def widened(self, at: FloatArray) -> Target:
        """The same with the emulator's error about a point added to the noise."""
        errors = self.emulator_errors(at)
        evidence = [known.widened(error) for known, error in zip(self.evidence, errors, strict=True)]
        return Target(self.unknowns, self.model, self.channels, evidence)

    def emulator_errors(self, at: FloatArray) -> list[FloatArray]:
        """Covariance of the emulator's errors of every channel, about a point (unknown,)."""
        values = self.unknowns.values(at[None])
        stretch = float(self.unknowns.stretch(values)[0])
        runs = self.model.runs.inputs
        near = np.all(np.abs(runs - self.unknowns.inputs(values)) <= _NEAR, axis=1)
        counted = near if near.sum() >= _LEAST_NEAR else None
        return [self.model.error(k, stretch * channel.meshes, counted) for k, channel in enumerate(self.channels)]

    def best(self, seed: int) -> FloatArray:
        """The most likely point, (unknown,)."""
        random = np.random.default_rng(seed)
        count = len(self.unknowns.every)
        trials = random.standard_normal((_TRIALS, count))
        for _ in range(_ROUNDS):  # cross-entropy: ever narrower normal distributions about the most likely trials
            kept = trials[np.argsort(self.log_density(trials))[-_BEST_TRIALS:]]
            middle, spread = kept.mean(axis=0), np.atleast_2d(np.cov(kept.T)) + 1e-8 * np.eye(count)
            more = random.multivariate_normal(middle, 2.0 * spread, _TRIALS // 5)
            trials = np.concatenate([kept, more])
        return np.asarray(trials[np.argmax(self.log_density(trials))])

    def emulator_shares(self, at: FloatArray, errors: Sequence[FloatArray]) -> FloatArray:
        """Standard deviation of each unknown by the emulator's error, over the posterior's, from slopes."""
        count = at.size
        steps = _STEP * np.eye(count)
        ahead, behind = self.amounts(at + steps), self.amounts(at - steps)
        information, made = np.eye(count), np.zeros((count, count))
        for evidence, error, a, b in zip(self.evidence, errors, ahead, behind, strict=True):
            slopes = ((a - b) / (2.0 * _STEP)).T
            weighted = evidence.widened(error).precision @ slopes
            information += slopes.T @ weighted
            made += weighted.T @ error @ weighted
        posterior = np.linalg.inv(information)
        return np.asarray(np.sqrt(np.diag(posterior @ made @ posterior) / np.diag(posterior)))


@dataclass(frozen=True)
class Draws:
    """Draws of a posterior.

    Attributes
    ----------
    normal : (draw, unknown) array
        Standard normal under the prior.
    autocorrelation : float
        Longest autocorrelation time [steps].
    effective : float
        Equivalent number of independent draws.
    settled : bool
        Whether the chains are long enough for a reliable autocorrelation time.
    """

    normal: FloatArray
    autocorrelation: float
    effective: float
    settled: bool


def draw_posterior(
    target: Target,
    best: FloatArray,
    seed: int,
    report: Callable[[int, int, str], None] | None = None,
    most: int = _MOST_BLOCKS,
) -> Draws:
    """Draws of a posterior; `report` is called after each block of steps, of which there are `most` at most.

    Raises
    ------
    MissingExtraError
        emcee is missing; install the extra ``infer``.
    """
    try:
        import emcee
    except ImportError as error:
        raise MissingExtraError("emcee", "infer", "inference") from error
    count = best.size
    random = np.random.default_rng(seed)
    walkers = max(_WALKERS, 4 * count)
    moves = [(emcee.moves.DEMove(), 0.7), (emcee.moves.DESnookerMove(), 0.1), (emcee.moves.StretchMove(), 0.2)]
    sampler: Value = emcee.EnsembleSampler(walkers, count, target.log_density, vectorize=True, moves=moves)
    sampler.random_state = np.random.RandomState(seed).get_state()
    state: Value = _starts(target, best, walkers, random)
    time, length = float("inf"), 0
    for block in range(1, most + 1):
        state = sampler.run_mcmc(state, _BLOCK)
        length = block * _BLOCK
        time = float(np.max(sampler.get_autocorr_time(tol=0, discard=length // 4)))
        if report is not None:
            report(block, most, f"sampling, autocorrelation time {time:.3g} steps")
        if length > _SETTLED * time:
            break
    burn = length // 4
    whole = walkers * (length - burn)
    chain = sampler.get_chain(discard=burn, thin=max(whole // _KEPT, 1), flat=True)
    return Draws(np.asarray(chain), time, whole / time, length > _SETTLED * time)


def _starts(target: Target, best: FloatArray, walkers: int, random: np.random.Generator) -> FloatArray:
    """Starts of walkers: likely ones among draws of the prior and of ever narrower balls about the best point."""
    balls = [best + width * random.standard_normal((_TRIALS // 4, best.size)) for width in (1.0, 0.3, 0.1, 0.03)]
    trials = np.concatenate([random.standard_normal((_TRIALS, best.size)), *balls])
    densities = target.log_density(trials)
    chances = np.exp(densities - densities.max())
    known = np.flatnonzero(chances > 1e-8)
    if known.size < 2 * walkers:  # a posterior far narrower than all balls
        return np.asarray(best + 1e-3 * random.standard_normal((walkers, best.size)))
    chances = np.clip(chances[known], 1e-6, None)
    chosen = random.choice(known, walkers, replace=False, p=chances / chances.sum())
    return np.asarray(trials[chosen])
