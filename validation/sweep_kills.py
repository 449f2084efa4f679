"""Kill a driver and a worker of a sweep on a Dask cluster, resume it, and compare with a sweep that nobody disturbed.

    python -m validation.sweep_kills [--scenes 1000] [--memory docs/driver_memory.svg]

Two workers on this machine; one scene in fifty is made to fail. A first driver is killed by SIGKILL at half of the
scenes, a second one goes on from its store, and at three quarters one of the workers is killed. The dataset must be
that of a sweep in one process, bit for bit, but for `seconds`; the memory of the second driver is printed at every
tenth, and drawn over its scenes with `--memory` (extra ``plot``).
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import psutil
import xarray as xr
from distributed import Client, LocalCluster

import semiwear as sw
from tests.scenes import RIGID, SHIPPED, TINY

_EVERY = 50  # scenes, one of which fails for want of iterations


class _Watch:
    """Progress that calls something, once, when so many scenes are done, and notes the memory of the driver.

    Attributes
    ----------
    done : list of int
        Scenes, whenever the memory was noted.
    memory : list of float [MB]
    """

    def __init__(self, at: int, act: Callable[[], None]) -> None:
        self.at, self.act, self.acted = at, act, False
        self.done: list[int] = []
        self.memory: list[float] = []

    def step(self, done: int, total: int, text: str) -> None:
        """Hear of a scene."""
        self.done.append(done)
        self.memory.append(psutil.Process().memory_info().rss / 2**20)
        if done >= self.at and not self.acted:
            self.acted = True
            self.act()


def _draw(path: Path, watch: _Watch) -> None:
    """Draw the memory of the driver over the scenes that are done."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.4, 2.8), layout="constrained")
    axes = figure.subplots()
    axes.plot(watch.done, watch.memory)
    axes.axvline(watch.at, color="0.6", linestyle=":")
    axes.annotate("a worker is killed", (watch.at, 0.0), (4, 4), textcoords="offset points", color="0.4")
    axes.set(xlabel="scenes done", ylabel="memory of the driver [MB]", ylim=(0.0, 1.2 * max(watch.memory)))
    figure.savefig(path, metadata={"Date": None})


def _sweep(scenes: int, **where: object) -> xr.Dataset:
    scene = SHIPPED.replace({**RIGID, **TINY, "wear.until.control_depths_um": [2.0]})
    fails = np.arange(scenes) % _EVERY == _EVERY // 2
    vary = {
        "operation.pinion_torque_Nm": np.linspace(400.0, 2000.0, scenes),
        "numerics.max_iterations": np.where(fails, 1, 100),
    }
    return sw.sweep(scene, pd.DataFrame(vary), **where).drop_vars("seconds")  # type: ignore[arg-type]


def _until_killed(address: str, store: str, scenes: int) -> None:
    """Be a driver that is killed at half its scenes."""
    watch = _Watch(scenes // 2, lambda: os.kill(os.getpid(), signal.SIGKILL))
    with Client(address) as client:
        _sweep(scenes, client=client, store=store, progress=watch)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print what came of it; 1 where anything differs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=1000)
    parser.add_argument("--memory", type=Path, help="picture of the driver's memory")
    parser.add_argument("--driver", nargs=2, metavar=("ADDRESS", "STORE"), help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    scenes = options.scenes
    if options.driver:
        address, kept_in = options.driver
        _until_killed(address, kept_in, scenes)
        return 1  # it was not killed
    with (
        tempfile.TemporaryDirectory() as folder,
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
    ):
        store = Path(folder, "store")
        place = ["--driver", cluster.scheduler_address, str(store), "--scenes", str(scenes)]
        first = subprocess.run([sys.executable, "-m", "validation.sweep_kills", *place], check=False)
        kept = len(list(store.glob("*.npz")))
        print(f"first driver ended with status {first.returncode}, {kept} scenes kept", flush=True)
        with Client(cluster) as client:
            worker = next(iter(client.run(os.getpid).values()))
            watch = _Watch(3 * scenes // 4, lambda: os.kill(worker, signal.SIGKILL))
            found = _sweep(scenes, client=client, store=store, progress=watch)
    undisturbed = _sweep(scenes, workers=0)
    same = found.identical(undisturbed) and first.returncode == -signal.SIGKILL and watch.acted
    done = int((found["status"] == 0).sum())
    memory = [round(watch.memory[k]) for k in np.linspace(0, len(watch.memory) - 1, 11).astype(int)]
    print(f"{scenes} scenes, {done} done, {scenes - done} failed; memory of the driver [MB]: {memory}")
    if options.memory is not None:
        _draw(options.memory, watch)
    print("identical to an undisturbed sweep" if same else "DIFFERENT from an undisturbed sweep")
    return int(not same)


if __name__ == "__main__":
    raise SystemExit(main())
