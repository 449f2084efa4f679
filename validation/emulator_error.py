"""Does the stated error of emulators hold on fresh scenes?

    python -m validation.emulator_error [--solved 64] [--fresh 200] [--store FOLDER]

Four fields of the shipped face gear scatter: torque, offset, tip relief and wear coefficient. Emulators learn from
some solved samples, as in `sw.scatter(..., emulate=...)`; fresh scenes, drawn by themselves, are solved and compared.
The stated error should hold in 95 % of them. From n samples the share that it holds in is itself beta-distributed,
with a standard deviation of 0.22 / sqrt(n) (Vovk 2012, J. Mach. Learn. Res. 25, 475-490), and m fresh scenes tell it
within 0.22 / sqrt(m): the mean over all quantities is asked to be within two of both together.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from math import sqrt
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.emulator import CONFIDENCE, emulator_of
from semiwear.scatter.design import design
from semiwear.scatter.distributions import LogNormal
from semiwear.scatter.statistics import quantities_of

SCENE = sw.load_scene("face_gear_25x160").replace(
    {
        "numerics.face_slices": 21,
        "numerics.roll_positions": 12,
        "numerics.profile_points": 71,
        "numerics.harmonics": 5,
        "wear.until.meshes": 3e8,
        "wear.control_point": None,
    }
)
FIELDS = {
    "operation.pinion_torque_Nm": sw.Normal(1600.0, 150.0),
    "effects.misalignment.offset_mm": sw.Normal(0.0, 0.04),
    "effects.modification.pinion.tip_relief_um": sw.Uniform(0.0, 20.0),
    "wear.coefficient_mm2_per_N": sw.LogNormal(1e-13, 0.3),
}


def inputs(values: np.ndarray, like: np.ndarray) -> np.ndarray:
    """Inputs of emulators: logarithms of log-normal fields, of the order of one over the samples `like`."""
    columns = []
    for k, one in enumerate(FIELDS.values()):
        first, second = (np.log(a[:, k]) if isinstance(one, LogNormal) else a[:, k] for a in (values, like))
        columns.append((first - second.mean()) / (2.0 * second.std()))
    return np.stack(columns, axis=1)


def solved(values: np.ndarray, store: Path) -> xr.Dataset:
    table = {key: values[:, k].tolist() for k, key in enumerate(FIELDS)}
    return sw.sweep(SCENE, table, combine="zip", measure="history", wear_states="last", store=store)


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare stated errors with those of fresh scenes; 0 where they hold as often as they say."""
    parser = argparse.ArgumentParser(prog="python -m validation.emulator_error")
    parser.add_argument("--solved", type=int, default=64, help="a power of two")
    parser.add_argument("--fresh", type=int, default=200)
    parser.add_argument("--store", type=Path, default=Path("emulator-error"), help="folder of solved scenes")
    options = parser.parse_args(arguments)
    values = design(list(FIELDS.values()), options.solved, 0, paired=False).values
    random = np.random.default_rng(1)
    fresh = np.stack([one.quantile(random.uniform(size=options.fresh)) for one in FIELDS.values()], axis=1)
    known, true = solved(values, options.store), dict(quantities_of(solved(fresh, options.store)))
    shares = []
    for name, own in quantities_of(known):
        good = np.isfinite(own)
        if good.sum() < 20 or np.ptp(own[good]) <= 1e-9 * np.abs(own[good]).max():
            continue
        emulator = emulator_of(inputs(values, values)[good], own[good])
        apart = np.abs(emulator.at(inputs(fresh, values)) - true[name])
        held = float(np.mean(apart[np.isfinite(apart)] <= emulator.error))
        shares.append(held)
        print(f"{name:45s} stated {emulator.relative_error:6.3f} of its deviation; holds in {held:.1%}", flush=True)
    spread = sqrt(CONFIDENCE * (1.0 - CONFIDENCE) * (1.0 / options.solved + 1.0 / options.fresh))
    low = CONFIDENCE - 2.0 * spread
    mean = float(np.mean(shares))
    print(f"{options.fresh} fresh scenes, {options.solved} solved: holds in {mean:.1%} on average, {low:.1%} asked")
    return 0 if mean >= low else 1


if __name__ == "__main__":
    sys.exit(main())
