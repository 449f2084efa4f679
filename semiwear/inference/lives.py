"""Lives from a posterior: solved at some of its draws, emulated at all."""

from __future__ import annotations

import os
from dataclasses import dataclass
from math import exp, sqrt
from typing import TYPE_CHECKING

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.emulator import LEAST_RUNS, emulator_of
from semiwear.errors import Problem, SceneError, SemiwearError
from semiwear.inference.unknowns import Unknowns
from semiwear.measured.life_spread import MOST_SCATTER, log_deviation, quantiles_in_words, require_share
from semiwear.plain_text import folded
from semiwear.scene import Scene
from semiwear.scene.values import is_number, is_whole, shown
from semiwear.sweep.outcome import Status, has_numbers
from semiwear.sweep.run import crew_of, sweep
from semiwear.untyped import Value

if TYPE_CHECKING:
    from distributed import Client

    from semiwear.simulate import Progress

_MOST_RUNS = 4096
_SPEED = "operation.pinion_speed_rpm"


@dataclass(frozen=True)
class PosteriorLife:
    """Life until a depth of wear, with the scatter of a posterior.

    Attributes
    ----------
    body : str
    depth_limit : float [um]
    meshes : array (draw,)
        Engagements of one gear tooth; infinite where the flank wears no further before the depth. Then only the
        solved draws are given, since lives without end cannot be emulated.
    error : float
        Of emulated lives, relative; 95 % of solved ones are within it. 0 if none was emulated.
    k_scatter : float
        Coefficient of variation of the wear coefficient from part to part, included in the life.
    hours_per_mesh : array (draw,) or None
        Running time, at the speed of each draw; None where the scene gives no speed.
    """

    body: str
    depth_limit: float
    meshes: FloatArray
    error: float
    k_scatter: float
    hours_per_mesh: FloatArray | None

    def quantile(self, share: float) -> float:
        """Meshes before which the depth is reached with a probability; 0.1 for the life B10, infinite without end.

        Raises
        ------
        SceneError
            For a probability not between 0 and 1.
        """
        require_share(share)
        return _quantile(self.meshes, share)

    def hours(self, share: float) -> float | None:
        """Running time [h] before which the depth is reached with a probability; None where no speed is given.

        Raises
        ------
        SceneError
            For a probability not between 0 and 1.
        """
        require_share(share)
        return None if self.hours_per_mesh is None else _quantile(self.meshes * self.hours_per_mesh, share)

    def __str__(self) -> str:
        quantiles = quantiles_in_words(self.quantile, self.hours)
        error = f"; emulated lives are within {100.0 * self.error:.2g} %" if self.error else ""
        endless = int(np.isinf(self.meshes).sum())
        if endless:
            error = f"; of {self.meshes.size} solved lives {endless} have no end, and none is emulated"
        scatter = (
            f"; k scatters by {100.0 * self.k_scatter:.0f} % from part to part"
            if self.k_scatter
            else "; of this pair, without the scatter from part to part"
        )
        return folded(f"life of the {self.body} until {self.depth_limit:g} um: {quantiles}{scatter}{error}")


def life_of(
    scene: Scene,
    unknowns: Unknowns,
    normal: FloatArray,
    request: tuple[float, str, float, int],
    *,
    where: tuple[int | str | Client | None, str | os.PathLike[str] | None, Progress | bool | None],
) -> PosteriorLife:
    """Lives at the draws of a posterior.

    Parameters
    ----------
    scene : Scene
    unknowns : Unknowns
    normal : array (draw, unknown)
        Standard normal under the prior.
    request : (float, str, float, int)
        Depth [um], body, scatter of the wear coefficient, and number of lives that are solved.
    where : tuple
        `crew`, `store` and `progress` of `Posterior.life`.

    Raises
    ------
    SceneError, SemiwearError
        As of `Posterior.life`.
    """
    depth, body, k_scatter, runs = request
    _require(k_scatter, runs)
    values = unknowns.values(normal)
    chosen = np.linspace(0, values.shape[0] - 1, runs).round().astype(int) if unknowns.solved else np.zeros(1, int)
    table: dict[str, list[float]] = {unknowns.keys[k]: values[chosen, k].tolist() for k in unknowns.solved}
    changes = {"effects.run_life": {"depth_limit_um": depth, "body": body}, "numerics.accuracy": None}
    crew, store, progress = where
    workers, client = crew_of(crew)
    found = sweep(
        scene.replace(changes), table or {"effects.run_life.depth_limit_um": [depth]}, measure="life", combine="zip",
        store=store, progress=progress, workers=workers, client=client,
    )  # fmt: skip
    status = found["status"].values
    ends, good = status == Status.DONE, has_numbers(status)
    if good.mean() < 0.9 or not ends.any():
        failed = ~good if ends.any() else ~ends
        reasons = "; ".join(dict.fromkeys(str(message) for message in found["message"].values[failed]))
        raise SemiwearError(f"{int(failed.sum())} of {good.size} lives cannot be found: {reasons}")
    lives = found["meshes_to_limit"].values
    parts = np.random.default_rng(0).standard_normal(values.shape[0])
    # both the measured pair and the next one are samples of the scatter
    shorter = unknowns.stretch(values) / np.exp(sqrt(2.0) * log_deviation(k_scatter) * parts)
    if not ends[good].all():
        rows, known, error = chosen[good], lives[good], 0.0
    else:
        rows = np.arange(values.shape[0])
        known, error = _emulated(unknowns.inputs(values), chosen[good], lives[good])
    per_mesh, first = None, int(np.argmax(ends))
    if "hours_to_limit" in found:
        hours = found["hours_to_limit"].values[first] / lives[first]
        per_mesh = hours * _slower(unknowns, values, int(chosen[first]))[rows]
    return PosteriorLife(body, float(depth), known / shorter[rows], error, float(k_scatter), per_mesh)


def _emulated(inputs: FloatArray, solved: IntArray, lives: FloatArray) -> tuple[FloatArray, float]:
    """Lives of all draws from their inputs, (draw, field), and the solved ones; and their relative error."""
    if not inputs.shape[1]:
        return np.full(inputs.shape[0], lives[0]), 0.0
    middle, spread = inputs.mean(axis=0), np.maximum(inputs.std(axis=0), 1e-12)
    scaled = (inputs - middle) / (2.0 * spread)
    emulator = emulator_of(scaled[solved], np.log(lives))
    return np.exp(emulator.at(scaled)), exp(emulator.error) - 1.0


def _quantile(lives: FloatArray, share: float) -> float:
    # no interpolation between a finite life and one without end
    return float(np.quantile(lives, share, method="linear" if np.isfinite(lives).all() else "inverted_cdf"))


def _slower(unknowns: Unknowns, values: FloatArray, draw: int) -> FloatArray:
    """Speed of one draw over those of all, (draw,): the ratio of the durations of a mesh."""
    if _SPEED not in unknowns.keys:
        return np.ones(values.shape[0])
    speed = values[:, unknowns.keys.index(_SPEED)]
    return np.asarray(speed[draw] / speed)


def scatter_problems(k_scatter: Value) -> list[Problem]:
    """The problem of a scatter of the wear coefficient that is out of range."""
    if is_number(k_scatter) and 0.0 <= k_scatter <= MOST_SCATTER:
        return []
    return [Problem("k_scatter", shown(k_scatter), f"a fraction, 0 to {MOST_SCATTER:g}", "0.5 for 50 %")]


def _require(k_scatter: Value, runs: Value) -> None:
    problems = scatter_problems(k_scatter)
    if not is_whole(runs) or not LEAST_RUNS <= runs <= _MOST_RUNS:
        problems.append(Problem("runs", shown(runs), f"a whole number, {LEAST_RUNS} to {_MOST_RUNS}", "32 is usual"))
    if problems:
        raise SceneError(problems, "life")
