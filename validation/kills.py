"""Kill runs at random moments, resume them, and compare with a run that nobody disturbed.

    python -m validation.kills [--count 50] [--seed 1]

Every run is the command line itself, `semiwear run SCENE -o worn.nc --resume`, ended by SIGKILL; now and then what
was resumed is killed again. All variables must come out the same, bit for bit; `seconds` and `effect_seconds` in
`/diagnostics` and the attribute `history` depend on the run and are left out.
"""

from __future__ import annotations

import argparse
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import semiwear as sw
from semiwear.results.checkpoint import peek
from tests.same_result import different_variables

_SMALL = {
    "numerics.face_slices": 31,
    "numerics.roll_positions": 12,
    "numerics.harmonics": 5,
    "wear.until.control_depths_um": [2.0 * k for k in range(1, 21)],
}
KINDS: dict[str, dict[str, Any]] = {
    "line": _SMALL,
    "line, both bodies": _SMALL | {"wear.worn_bodies": ["pinion", "gear"]},
    "patch": _SMALL | {"numerics.fidelity": "patch"},
}
_AGAIN = 0.4  # of the resumed runs are killed as well
_EARLIEST = 0.4  # of a run's time: before, it only loads its libraries


@dataclass
class Trial:
    """One run that was killed, once or more.

    Attributes
    ----------
    kind : str
    finished : list of int or None
        Wear steps in the checkpoint after each kill; None where there was none.
    different : list of str
        Variables that differ from those of the undisturbed run.
    left : list of str
        Files beside the result at the end.
    """

    kind: str
    finished: list[int | None] = field(default_factory=list)
    different: list[str] = field(default_factory=list)
    left: list[str] = field(default_factory=list)


def trials(changes: Mapping[str, Any], kind: str, count: int, seed: int, folder: Path) -> list[Trial]:
    """Kill runs of a changed shipped scene `count` times and resume each to its end."""
    rng = random.Random(f"{kind} {seed}")
    scene = folder / "scene.toml"
    scene.write_text(sw.load_scene("face_gear_25x160").replace(changes).to_toml(), encoding="utf-8")
    _run(scene, folder / "warm.nc")  # compiled code and files are in caches then
    usual = _run(scene, folder / "whole.nc")
    assert usual is not None
    whole = sw.open_results(folder / "whole.nc")
    done: list[Trial] = []
    while sum(len(trial.finished) for trial in done) < count:
        trial = Trial(kind)
        place = folder / f"trial_{len(done)}"
        place.mkdir(exist_ok=True)
        output = place / "worn.nc"
        while True:
            wanted = not trial.finished or rng.random() < _AGAIN
            seconds = _run(scene, output, rng.uniform(_EARLIEST, 1.0) * usual if wanted else None)
            if seconds is not None:
                if not trial.finished:
                    usual = seconds  # it came to its end before it was killed: the machine is less busy now
                break
            found = peek(f"{output}.partial")
            trial.finished.append(None if found is None else found.finished)
            usual *= 1.02  # and so that it follows a machine that is busier
        if not trial.finished:
            continue
        trial.different = different_variables(sw.open_results(output), whole)
        trial.left = sorted(path.name for path in place.iterdir() if path.name != output.name)
        done.append(trial)
    return done


def _run(scene: Path, output: Path, kill_after: float | None = None) -> float | None:
    """Run the command line, killed after some seconds; what it took [s], None if it was killed."""
    begin = time.perf_counter()
    command = [sys.executable, "-m", "semiwear", "run", str(scene), "-o", str(output), "--resume"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        try:
            _, errors = process.communicate(timeout=kill_after)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return None
    if process.returncode != 0:
        raise SystemExit(f"{' '.join(command)} failed:\n{errors}")
    return time.perf_counter() - begin


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a table; 1 where a result differs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=50, help="kills, over all kinds of runs")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    print(f"{'run':20}{'kills':>7}{'no step yet':>13}{'in between':>12}{'all steps':>11}{'runs':>6}{'identical':>11}")
    kills, runs, identical = 0, 0, 0
    for k, (kind, changes) in enumerate(KINDS.items()):
        share = options.count // len(KINDS) + (k < options.count % len(KINDS))
        with tempfile.TemporaryDirectory() as folder:
            done = trials(changes, kind, share, options.seed, Path(folder))
        steps = len(changes["wear.until.control_depths_um"])
        after = [finished for trial in done for finished in trial.finished]
        same = sum(not trial.different for trial in done)
        early, late = sum(not finished for finished in after), after.count(steps)
        middle = len(after) - early - late
        print(f"{kind:20}{len(after):7}{early:13}{middle:12}{late:11}{len(done):6}{same:11}", flush=True)
        for trial in done:
            if trial.different:
                print(f"  killed with {trial.finished} steps kept, differs in {', '.join(trial.different)}")
            if trial.left:
                print(f"  left behind: {', '.join(trial.left)}")
        kills, runs, identical = kills + len(after), runs + len(done), identical + same
    print(f"{kills} kills, {identical} of {runs} results identical to that of an undisturbed run")
    return int(identical < runs)


if __name__ == "__main__":
    raise SystemExit(main())
