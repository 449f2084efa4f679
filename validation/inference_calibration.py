"""Simulation-based calibration of `sw.infer`: are its posteriors as wide as they should be?

    python -m validation.inference_calibration [--flanks 200] [--runs 128] [--seed 1] [--emulated]
        [--store FOLDER] [-o RANKS.csv] [--table validation/data/inference_intervals.csv]

Talts et al. 2018 (arXiv:1804.06788): unknown fields are drawn from their priors, the flank that they wear is solved
in a run of its own (not emulated; in plain steps of its own lengths), and measured: with noise that is alike at
neighbouring points by a share and over lengths that are drawn, too, and displaced by a rotation and a shift along
the axis. The rank of each true value among the draws of its posterior is uniform where the posterior is right.

The test is stated: Pearson's chi-square of the ranks in 10 equal bins, at 1 % for all unknowns together
(Bonferroni); and 90 % intervals hold the truth in 86 to 94 % of the flanks. All flanks share the runs of the
emulator, which lie all over the prior; `sw.infer` adds runs where a posterior is. With `--emulated` the true flanks
are the emulator's own: what is missing there is not due to runs or emulator.
"""

from __future__ import annotations

import argparse
import csv
import os
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import xarray as xr
from scipy.stats import chisquare

import semiwear as sw
from semiwear.inference.evidence import LONGEST, SHORTEST
from semiwear.inference.model import Model, model_of
from semiwear.inference.observations import channels_of
from semiwear.inference.run import Plan, plan_inference, solved_runs, spread_over, target_of
from semiwear.inference.sampling import draw_posterior
from semiwear.inference.unknowns import Unknowns
from semiwear.measured.comparison import grid_of
from semiwear.measured.nominal import NominalFlank, nominal_flank
from semiwear.measured.predicted import FlankReading
from semiwear.measured.quantities import labelled
from semiwear.measured.rigid import DATUM, motions_of
from semiwear.simulate import NoProgress
from semiwear.threads import available_threads

MESHES = 5e8
SCENE = sw.load_scene("face_gear_25x160").replace(
    {
        "numerics.face_slices": 21,
        "numerics.roll_positions": 12,
        "numerics.profile_points": 71,
        "numerics.harmonics": 5,
        "wear.until.meshes": MESHES,
        "wear.control_point": None,
        "wear.coefficient_mm2_per_N": 1e-13,
        "effects.wear_law.load.exponent": 0.5,
        "effects.misalignment.offset_mm": 0.0,
    }
)
UNKNOWN = {
    "wear.coefficient_mm2_per_N": sw.LogNormal(1e-13, 0.5),
    "operation.pinion_torque_Nm": sw.Normal(1600.0, 150.0),
    "effects.misalignment.offset_mm": sw.Normal(0.0, 0.05),
    "effects.wear_law.load.exponent": sw.Uniform(0.2, 0.8),
}
CALLED = dict(zip(UNKNOWN, ("wear coefficient", "torque", "offset", "exponent of the load"), strict=True))
ROWS, COLUMNS, MARGIN = 31, 21, 0.04
NOISE = sw.LogNormal(0.5, 0.5)  # um
BINS, LEVEL = 10, 0.01
CONFIDENCE, COVERED = 0.9, (0.86, 0.94)


@dataclass(frozen=True)
class Ranked:
    """Calibration of one unknown.

    Attributes
    ----------
    key : str
    p_value : float
        Of uniform ranks.
    covered : float
        Share of flanks whose 90 % interval holds the truth.
    """

    key: str
    p_value: float
    covered: float

    def holds(self, unknowns: int) -> bool:
        """Whether ranks are uniform and intervals hold, by the stated test."""
        return self.p_value >= LEVEL / unknowns and COVERED[0] <= self.covered <= COVERED[1]


def ranked(key: str, ranks: np.ndarray) -> Ranked:
    """Calibration of an unknown from the shares of draws below its true values."""
    counts = np.histogram(ranks, BINS, (0.0, 1.0))[0]
    miss = 0.5 * (1.0 - CONFIDENCE)
    covered = float(np.mean((ranks > miss) & (ranks < 1.0 - miss)))
    return Ranked(key, float(chisquare(counts).pvalue), covered)


def write_table(path: Path, results: Sequence[Ranked]) -> None:
    """Write what the documentation shows."""
    with path.open("w", newline="", encoding="utf-8") as opened:
        writer = csv.writer(opened, lineterminator="\n")
        writer.writerow(["unknown", "90 % intervals that held [%]", "p of uniform ranks"])
        writer.writerows([CALLED[one.key], f"{100.0 * one.covered:.1f}", f"{one.p_value:.2f}"] for one in results)


def places(flank: NominalFlank) -> tuple[np.ndarray, np.ndarray]:
    """Face and profile coordinates of the measured points [mm], both (profile, face)."""
    across, along = (np.linspace(MARGIN, 1.0 - MARGIN, count) for count in (ROWS, COLUMNS))
    return flank.places(*np.meshgrid(along, across))


def noise(random: np.random.Generator, profile: np.ndarray, face: np.ndarray) -> np.ndarray:
    """Noise [um] of a flank, alike at neighbouring points by a share and over lengths that are drawn."""
    shape, share = (profile.size, face.size), random.uniform()
    factors = []
    for place in (profile, face):
        extent = float(np.ptp(place))
        low, high = np.log(SHORTEST * extent / (place.size - 1)), np.log(LONGEST * extent)
        correlation = np.exp(-np.abs(place[:, None] - place) / np.exp(random.uniform(low, high)))
        factors.append(np.linalg.cholesky(correlation + 1e-10 * np.eye(place.size)))
    alike = factors[0] @ random.standard_normal(shape) @ factors[1].T
    size = float(NOISE.quantile(np.array([random.uniform()]))[0])
    return size * (np.sqrt(share) * alike + np.sqrt(1.0 - share) * random.standard_normal(shape))


def measured(wear: np.ndarray, random: np.random.Generator) -> xr.Dataset:
    """A true flank, worn by so much (profile, face) [um], as it is measured."""
    flank = nominal_flank(SCENE)
    face, profile = places(flank)
    points, normals = flank.points(face, profile)
    motion = motions_of(flank, DATUM).modes(points, normals) @ np.array([2e-5, 5e-3] * random.standard_normal(2))
    inside = np.ones(face.shape, dtype=bool)
    error = noise(random, profile.mean(axis=1), face.mean(axis=0))
    height, radius = flank.place(face, profile)
    values: dict[str, object] = {
        "wear_depth": wear + 1e3 * motion + error, "flank_profile": profile, "flank_face": face, "inside": inside,
        "flank_height": height, "flank_radius": radius, "points": inside.sum(),
    }  # fmt: skip
    return labelled(values, {"body": "gear"}, "synthetic flank")


def wear_of_runs(values: np.ndarray, workers: int | None, store: Path) -> list[np.ndarray | None]:
    """Wear [um] of the measured points for true values (flank, unknown), each run by itself; None where it failed."""
    table = {key: values[:, k].tolist() for k, key in enumerate(UNKNOWN)}
    scene = SCENE.replace({"numerics.wear_steps": 32})
    found = sw.sweep(
        scene, table, combine="zip", measure="wear_depth", wear_states="last", store=store / "true", workers=workers
    )
    depths = found["wear_depth"].sel(body="gear").values
    grid = grid_of(SCENE, found["face"].values, depths.shape[1], "gear")
    face, profile = places(nominal_flank(SCENE))
    reading = FlankReading.of(grid, face.ravel(), profile.ravel())
    done = found["status"].values == 0
    return [
        reading.read(depth.T).reshape(face.shape) if solved else None
        for depth, solved in zip(depths, done, strict=True)
    ]


def wear_of_emulator(values: np.ndarray, planned: Plan, model: Model) -> list[np.ndarray | None]:
    """The same as the emulator tells it, but for what the datum leaves open."""
    meshes = planned.unknowns.stretch(values)[:, None] * planned.channels[0].meshes
    told = model.amounts(planned.unknowns.inputs(values), meshes)[0] @ model.shapes[0].T
    return list(told.reshape(len(values), ROWS, COLUMNS))


@dataclass(frozen=True)
class Flank:
    """A true flank as it is measured.

    Attributes
    ----------
    number : int
        Seed of the draws of its posterior.
    truth : (unknowns,) array
    measured : Dataset
    """

    number: int
    truth: np.ndarray
    measured: xr.Dataset


@dataclass(frozen=True)
class Told:
    """Where the posterior of a flank holds the truth.

    Attributes
    ----------
    ranks : (unknowns,) array
        Shares of draws below the truth.
    settled : bool
        Whether the chains are long enough.
    seconds : float
        Of the processor.
    """

    ranks: np.ndarray
    settled: bool
    seconds: float


def ranks_of(unknowns: Unknowns, model: Model, flank: Flank) -> Told:
    """Draw from the posterior of a flank."""
    begin = time.process_time()
    seen = channels_of(SCENE, [sw.WornFlank(flank.measured)])
    target = target_of(Plan(SCENE, unknowns, tuple(seen), 0, 1.0, flank.number), model)
    best = target.best(flank.number)
    draws = draw_posterior(target.widened(best), best, flank.number)
    ranks = np.mean(unknowns.values(draws.normal) < flank.truth, axis=0)
    return Told(ranks, draws.settled, time.process_time() - begin)


def ranked_flanks(unknowns: Unknowns, model: Model, flanks: Sequence[Flank], workers: int) -> Iterator[Told]:
    """Ranks of all flanks in their order, found in so many processes."""
    context = get_context("spawn")  # a fork of a process with threads may hang
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        yield from pool.map(
            partial(ranks_of, unknowns, model), flanks, chunksize=4
        )  # each chunk takes the model along


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the calibration; 0 where the stated tests hold."""
    parser = argparse.ArgumentParser(prog="python -m validation.inference_calibration")
    parser.add_argument("--flanks", type=int, default=200)
    parser.add_argument("--runs", type=int, default=128, help="runs of the emulator")
    parser.add_argument("--store", type=Path, default=Path("inference-calibration"), help="folder of solved runs")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--emulated", action="store_true", help="true flanks as the emulator tells them")
    parser.add_argument("--workers", type=int, help="processes; default: one a core")
    parser.add_argument("-o", "--output", type=Path, default=Path("inference_calibration.csv"))
    parser.add_argument("--table", type=Path, help="file for the table of the documentation")
    options = parser.parse_args(arguments)
    random = np.random.default_rng(options.seed)
    options.store.mkdir(parents=True, exist_ok=True)

    flank = nominal_flank(SCENE)
    face, profile = places(flank)
    blank = labelled(
        {"wear_depth": profile, "flank_profile": profile, "flank_face": face,
         "inside": np.ones(face.shape, dtype=bool)}, {"body": "gear"}, "places",
    )  # fmt: skip
    planned = plan_inference(SCENE, UNKNOWN, sw.WornFlank(blank), runs=options.runs)
    box = np.tile([-1.0, 1.0], (len(planned.unknowns.solved), 1))
    runs = solved_runs(
        planned, spread_over(box, planned.runs, 0), options.workers, options.store / "runs", NoProgress()
    )
    model = model_of(runs, planned.channels)
    values = planned.unknowns.values(random.standard_normal((options.flanks, len(UNKNOWN))))
    if options.emulated:
        wear = wear_of_emulator(values, planned, model)
    else:
        wear = wear_of_runs(values, options.workers, options.store)
    flanks = [Flank(k, values[k], measured(one, random)) for k, one in enumerate(wear) if one is not None]
    found = ranked_flanks(planned.unknowns, model, flanks, options.workers or available_threads())
    every = []
    for true, told in zip(flanks, found, strict=True):
        every.append(told)
        print(f"{true.number + 1}: ranks {np.round(told.ranks, 3)}, {told.seconds:.1f} s", flush=True)
    ranks = np.stack([told.ranks for told in every])
    with options.output.open("w", newline="", encoding="utf-8") as opened:
        writer = csv.writer(opened)
        writer.writerow(UNKNOWN)
        writer.writerows(np.round(ranks, 5).tolist())
    results = [ranked(key, ranks[:, k]) for k, key in enumerate(UNKNOWN)]
    if options.table is not None:
        write_table(options.table, results)
    short, seconds = sum(not told.settled for told in every), np.median([told.seconds for told in every])
    errors = ", ".join(f"{100 * one.relative_error:.2g} %" for one in model.emulators[:3])
    print(
        f"{len(every)} flanks, {runs.inputs.shape[0]} runs, first components emulated within {errors} of their "
        f"deviation; {short} chains short; median {seconds:.1f} processor seconds a flank"
    )
    for one in results:
        verdict = "holds" if one.holds(len(results)) else "FAILS"
        print(f"{one.key}: p of uniform ranks {one.p_value:.3f}, 90 % intervals hold in {one.covered:.1%}: {verdict}")
    return 0 if all(one.holds(len(results)) for one in results) else 1


if __name__ == "__main__":
    sys.exit(main())
