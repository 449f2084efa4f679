"""The posterior of an inference: intervals, undetermined fields, the fit, and lives."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.arrays import FloatArray
from semiwear.errors import SemiwearError
from semiwear.inference.apart import undetermined_fields
from semiwear.inference.lives import PosteriorLife, life_of
from semiwear.inference.sampling import Draws, Target
from semiwear.measured.life_spread import require_share
from semiwear.plain_text import folded, table
from semiwear.results.provenance import version
from semiwear.scene import Scene
from semiwear.scene.closest import advised_name
from semiwear.scene.units import unit_of

if TYPE_CHECKING:
    from distributed import Client

    from semiwear.simulate import Progress

HEAD = ("field", "median", "95 % interval", "of the prior's", "emulator", "unit")


@dataclass(frozen=True)
class Posterior:
    """Unknown fields of a scene given the observations; made by `infer`, printed as a table.

    Attributes
    ----------
    scene : Scene
    target : Target
        The density of the draws.
    draws : Draws
    best : (unknown,) array
        The most likely point, standard normal under the prior.
    emulator_shares : (unknown,) array
        Standard deviation of each unknown by the emulator's error, over the posterior's.
    """

    scene: Scene
    target: Target
    draws: Draws
    best: FloatArray
    emulator_shares: FloatArray

    @property
    def keys(self) -> tuple[str, ...]:
        """Dotted keys of the unknown fields."""
        return self.target.unknowns.keys

    @property
    def values(self) -> FloatArray:
        """Draws of the unknown fields, (draw, unknown)."""
        return self.target.unknowns.values(self.draws.normal)

    def of(self, key: str) -> FloatArray:
        """Draws of one field, by its dotted key, the last part of it or its name in `to_dataset`.

        Raises
        ------
        SemiwearError
            It is not an unknown field, or the last part of several keys.
        """
        names = [unknown.name for unknown in self.target.unknowns.every]
        for known in (self.keys, names):
            if key in known:
                return np.asarray(self.values[:, list(known).index(key)])
        ends = [k for k, own in enumerate(self.keys) if own.rpartition(".")[2] == key]
        if len(ends) == 1:
            return np.asarray(self.values[:, ends[0]])
        if ends:
            raise SemiwearError(f"{key} is the last part of {' and of '.join(self.keys[k] for k in ends)}: give one")
        hint = advised_name(key, [*self.keys, *names], f"there are {', '.join(self.keys)}")
        raise SemiwearError(f"{key} was not inferred: {hint}")

    def quantile(self, key: str, share: float) -> float:
        """Value below which a field lies with a probability."""
        require_share(share)
        return float(np.quantile(self.of(key), share))

    def interval(self, key: str, confidence: float = 0.95) -> tuple[float, float]:
        """Values between which a field lies with a probability, with equal tails."""
        miss = 0.5 * (1.0 - confidence)
        return self.quantile(key, miss), self.quantile(key, 1.0 - miss)

    @property
    def shares_of_prior(self) -> FloatArray:
        """Standard deviation of each unknown over that of its prior: near 1 if nothing was learnt."""
        return np.asarray(self.draws.normal.std(axis=0))

    @property
    def not_told_apart(self) -> tuple[str, ...]:
        """Sentences on fields that the observations do not determine, singly or independently of each other."""
        return undetermined_fields(self.target.unknowns.every, self.values, self.shares_of_prior)

    @property
    def inferred_scene(self) -> Scene:
        """The scene at the posterior's medians."""
        medians = self.target.unknowns.values(np.median(self.draws.normal, axis=0)[None])[0]
        return self.scene.replace(dict(zip(self.keys, map(float, medians), strict=True)))

    def fitted(self) -> list[tuple[str, float, float]]:
        """For every observation its name, the standard deviation of its noise, and the misfit at the best point.

        The misfit is the distance of observed from predicted values, in standard deviations, over that by noise
        alone: about 1 if the model explains the observation. For a measured flank, whose noise is unknown, it
        compares amounts of predicted shapes; the rest is taken as noise.
        """
        amounts = self.target.amounts(self.best[None])
        return [
            (channel.name, evidence.deviation, evidence.misfit(own[0]))
            for evidence, own, channel in zip(self.target.evidence, amounts, self.target.channels, strict=True)
        ]

    def life(
        self,
        depth_limit_um: float,
        body: str = "gear",
        *,
        k_scatter: float = 0.0,
        runs: int = 32,
        crew: int | str | Client | None = None,
        store: str | os.PathLike[str] | None = None,
        progress: Progress | bool | None = None,
    ) -> PosteriorLife:
        """Life until a flank's greatest wear is a depth, with the scatter of the posterior.

        Parameters
        ----------
        depth_limit_um : float
        body : str
        k_scatter : float
            Coefficient of variation of the wear coefficient from part to part, for the life of the next part
            (`semiwear.measured.life_spread`). Default 0: the life of the measured pair itself.
        runs : int
            Lives that are solved, at draws of the posterior; all others are emulated. One if only the wear
            coefficient is unknown: a life is inverse to it.
        crew, store, progress
            As of `infer`.

        Raises
        ------
        SceneError
            For a depth, body, scatter or number of runs out of range.
        SemiwearError
            The flank cannot be worn so deep.
        """
        return life_of(
            self.scene, self.target.unknowns, self.draws.normal, (depth_limit_um, body, k_scatter, runs),
            where=(crew, store, progress),
        )  # fmt: skip

    def to_dataset(self) -> xr.Dataset:
        """The draws, a variable for each field along `draw`, with the summary in attributes."""
        data = {
            unknown.name: (
                "draw",
                self.of(unknown.key),
                {"field": unknown.key, "units": unit_of(unknown.key), "prior": str(unknown.prior)},
            )
            for unknown in self.target.unknowns.every
        }
        attrs = {
            "title": f"Posterior: {self.scene.title}" if self.scene.title else "Posterior",
            "observed": "; ".join(unknown.name for unknown in self.target.channels),
            "not_told_apart": "\n".join(self.not_told_apart),
            "runs": self.runs,
            "effective_draws": self.draws.effective,
            "scene_toml": self.scene.to_toml(),
            "scene_sha256": self.scene.sha256,
            "source": f"semiwear {version()}",
        }
        return xr.Dataset(data, {"draw": np.arange(self.draws.normal.shape[0])}, attrs)

    @property
    def runs(self) -> int:
        """Runs that were solved."""
        return int(self.target.model.runs.values[0].shape[0])

    @property
    def sampled(self) -> str:
        """One sentence on runs and draws."""
        chains = "" if self.draws.settled else "; the chains are SHORT for that: intervals may be off"
        return (
            f"{self.runs} run{'s' if self.runs > 1 else ''}; {self.draws.effective:.0f} effective draws, "
            f"autocorrelation time {self.draws.autocorrelation:.3g} steps{chains}"
        )

    def rows(self) -> list[tuple[str, ...]]:
        """A row of the summary for every unknown: field, median, interval, shares, unit."""
        found: list[tuple[str, ...]] = []
        for k, key in enumerate(self.keys):
            low, high = self.interval(key)
            shares = f"{100.0 * self.shares_of_prior[k]:.0f} %", f"{100.0 * self.emulator_shares[k]:.0f} %"
            found.append((key, f"{self.quantile(key, 0.5):.4g}", f"{low:.4g} to {high:.4g}", *shares, unit_of(key)))
        return found

    def misfits(self) -> list[str]:
        """A sentence for every observation, and whether the model explains it."""
        lines = []
        for name, deviation, misfit in self.fitted():
            far = "; the scene does NOT explain it" if misfit > _FAR else ""
            lines.append(f"{name}: noise {deviation:.3g}, misfit {misfit:.2f} times that of noise{far}")
        return lines

    def __str__(self) -> str:
        apart: Sequence[str] = self.not_told_apart or ("the observations determine every unknown",)
        return "\n".join(
            [
                table(HEAD, self.rows()),
                "",
                *(folded(f"- {line}") for line in apart),
                "",
                *(folded(line) for line in self.misfits()),
                folded(self.sampled),
            ]
        )


_FAR = 3.0
