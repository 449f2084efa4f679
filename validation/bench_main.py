"""What runs take: seconds and memory, case by case and stage by stage, against another version, and as they grow.

    python validation/bench_main.py                      # every case, warm, on one thread
    python validation/bench_main.py main patch --threads 1 2
    python validation/bench_main.py main --against v0.1  # a stored commit, in pairs
    python validation/bench_main.py --cold               # first runs in new processes
    python validation/bench_main.py --growth growth.svg  # over slices, roll positions and so on (extra plot)
    python validation/bench_main.py --doubling           # what twice the resolution changes

Every case runs in a process of its own that lives on, so that kernels are compiled and kept compliance is there; its
first run is not counted. Where two are compared, their runs take turns, and ratios are of each turn. Beside the
speed-up of several threads stands that of as many processes which share nothing: what the cores of the machine give.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, os.fspath(Path(__file__).parents[1]))  # as a script it finds its own folder only

import semiwear as sw
from validation.bench_cases import CASES, GROWTH, BenchCase, Growth
from validation.problems import KINDS

ROOT = Path(__file__).resolve().parents[1]
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
COLD = """
import time; t0 = time.perf_counter()
import semiwear as sw; t1 = time.perf_counter()
scene = sw.load_scene("face_gear_25x160"); plan = sw.plan(scene); t2 = time.perf_counter()
sw.simulate(scene); t3 = time.perf_counter()
print(t1 - t0, t2 - t1, t3 - t2)
"""
STARTS = ("import", "plan", "simulate")


class Worker:
    """A process that runs cases of one version, and waits in between.

    Parameters
    ----------
    tree : Path
        Folder of the version.
    environment : dict, optional
        What is set besides.
    """

    def __init__(self, tree: Path, environment: dict[str, str] | None = None) -> None:
        # no compliance from the disk: the older version has none, and one case times it
        settings = os.environ | ONE_THREAD | {"SEMIWEAR_CACHE_DIR": "off", "PYTHONPATH": os.fspath(tree)}
        self._process = subprocess.Popen(
            [sys.executable, os.fspath(ROOT / "validation" / "bench_worker.py")],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env=settings | (environment or {}),
        )

    def run(self, request: dict[str, Any]) -> dict[str, Any]:
        """One run; an error of the run is one of the answer, too."""
        if self._process.stdin is None or self._process.stdout is None:
            raise RuntimeError("the worker has no pipes")
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"the worker ended with {self._process.wait()}")
        answered: dict[str, Any] = json.loads(line)
        return answered

    def close(self) -> None:
        """End the process."""
        self._process.communicate()


@contextlib.contextmanager
def workers(trees: Sequence[Path]) -> Iterator[list[Worker]]:
    """A process for every folder."""
    started = [Worker(tree) for tree in trees]
    try:
        yield started
    finally:
        for worker in started:
            worker.close()


@contextlib.contextmanager
def checked_out(commit: str) -> Iterator[Path]:
    """A stored version of the sources, in a folder that is removed afterwards."""
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "tree"
        git = ["git", "-C", os.fspath(ROOT), "worktree"]
        subprocess.run([*git, "add", "--quiet", "--detach", os.fspath(tree), commit], check=True)
        try:
            yield tree
        finally:
            subprocess.run([*git, "remove", "--force", os.fspath(tree)], check=True)


def in_turn(running: Sequence[Worker], requests: Sequence[dict[str, Any]], rounds: int) -> list[list[dict[str, Any]]]:
    """Answers of every worker to its request, after one run that is not counted; who begins a round alternates."""
    found: list[list[dict[str, Any]]] = [[] for _ in running]
    for turn in range(-1, rounds):
        order = range(len(running)) if turn % 2 else reversed(range(len(running)))
        for k in order:
            answered = running[k].run(requests[k])
            if turn >= 0 or "error" in answered:
                found[k].append(answered)
        if any("error" in answers[-1] for answers in found if answers):
            break
    return found


def summary(answers: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Medians of repeated runs."""
    failed = next((answer["error"] for answer in answers if "error" in answer), None)
    if failed is not None:
        return {"error": failed}
    stages = {name: statistics.median(a["stages"].get(name, 0.0) for a in answers) for name in answers[0]["stages"]}
    peaks = [answer["peak"] for answer in answers if answer["peak"] is not None]
    return {
        "wall": statistics.median(answer["wall"] for answer in answers),
        "least": min(answer["wall"] for answer in answers),
        "processor": statistics.median(answer["processor"] for answer in answers),
        "peak": max(peaks) if peaks else None,
        "stages": stages,
    }


def warm(case: BenchCase, threads: Sequence[int], rounds: int) -> list[dict[str, Any]]:
    """Seconds and memory of a case at every number of threads, in turn."""
    with workers([ROOT] * len(threads)) as running:
        answers = in_turn(running, [case.request(count) for count in threads], rounds)
    rows = []
    for count, found in zip(threads, answers, strict=True):
        row = {"case": case.name, "threads": count} | summary(found)
        if "error" not in row:
            row["speed-up"] = ratio_of(answers[0], found)
            row["copies"] = copies(case, count, rounds) if count > 1 else None
        rows.append(row)
    return rows


def copies(case: BenchCase, count: int, rounds: int) -> float | None:
    """How many times as much is done by so many processes side by side as by one, on one thread each."""
    request, gains = case.request(), []
    with workers([ROOT] * count) as running, ThreadPoolExecutor(count) as pool:
        for turn in range(-1, rounds):
            alone = running[0].run(request)
            together = list(pool.map(lambda worker: worker.run(request), running))
            if any("error" in answered for answered in (alone, *together)):
                return None
            if turn >= 0:
                gains.append(count * alone["wall"] / max(answered["wall"] for answered in together))
    return statistics.median(gains)


def ratio_of(before: Sequence[dict[str, Any]], after: Sequence[dict[str, Any]]) -> float | None:
    """Median over the turns of wall time before over after."""
    if any("error" in answer for answer in (*before, *after)):
        return None
    return statistics.median(old["wall"] / new["wall"] for old, new in zip(before, after, strict=True))


def against(commit: str, cases: Sequence[BenchCase], rounds: int) -> list[dict[str, Any]]:
    """How much faster every case is than at a stored commit."""
    rows = []
    with checked_out(commit) as tree:
        for case in cases:
            with workers([tree, ROOT]) as running:
                before, after = in_turn(running, [case.request()] * 2, rounds)
            told, own = summary(before), summary(after)
            rows.append({"case": case.name, "before": told, "after": own, "ratio": ratio_of(before, after)})
            print(_pair_line(rows[-1]), flush=True)
    return rows


def _pair_line(row: dict[str, Any]) -> str:
    for side in ("before", "after"):
        if "error" in row[side]:
            return f"{row['case']:12s} {side}: {row[side]['error'].splitlines()[0]}"
    return f"{row['case']:12s} {row['before']['wall']:8.2f} s {row['after']['wall']:8.2f} s {row['ratio']:7.2f}x"


def cold(report: bool = True) -> dict[str, dict[str, float]]:
    """Seconds of import, plan and a first run: kernels to compile, then kept; then with kept compliance, too."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        settings = os.environ | {"NUMBA_CACHE_DIR": f"{folder}/kernels", "PYTHONPATH": os.fspath(ROOT)}
        kept = settings | {"SEMIWEAR_CACHE_DIR": f"{folder}/teeth"}
        ways = {
            "kernels compiled": kept,
            "kernels and compliance kept": kept,
            "kernels kept": settings | {"SEMIWEAR_CACHE_DIR": "off"},
        }
        for name, environment in ways.items():
            done = subprocess.run(
                [sys.executable, "-c", COLD], env=environment, capture_output=True, text=True, check=True
            )
            found[name] = dict(zip(STARTS, map(float, done.stdout.split()), strict=True))
            if report:
                print(
                    f"{name:30s}" + "".join(f"{part:>10s} {found[name][part]:6.2f} s" for part in STARTS), flush=True
                )
    return found


def growth(kinds: Sequence[Growth], rounds: int) -> dict[str, dict[str, Any]]:
    """Seconds and added memory over the numbers that make a run larger, with exponents fitted over all values."""
    found = {}
    for kind in kinds:
        values, seconds, memory = np.array(list(kind.changes)), [], []
        for changes in kind.changes.values():
            case = BenchCase(kind.name, kind.label, kind.scene, changes)
            with workers([ROOT]) as running:
                (answers,) = in_turn(running, [case.request()], rounds)
            told = summary(answers)
            if "error" in told:
                raise RuntimeError(f"{kind.name}: {told['error']}")
            seconds.append(told["processor"])
            memory.append(told["peak"] or float("nan"))
        exponent, memory_exponent = (
            float(np.polyfit(np.log(values), np.log(taken), 1)[0]) for taken in (seconds, memory)
        )
        last = float(np.log(seconds[-1] / seconds[-2]) / np.log(values[-1] / values[-2]))
        found[kind.name] = {
            "label": kind.label,
            "values": values.tolist(),
            "seconds": seconds,
            "peak": memory,
            "exponent": exponent,
            "last exponent": last,
            "memory exponent": memory_exponent,
        }
        taken = ", ".join(
            f"{value:g}: {second:.2f} s {peak:.0f} MB"
            for value, second, peak in zip(values, seconds, memory, strict=True)
        )
        print(
            f"{kind.name:16s} {taken}; exponent {exponent:.2f} (last {last:.2f}), memory {memory_exponent:.2f}",
            flush=True,
        )
    return found


def draw_growth(found: dict[str, dict[str, Any]], path: str) -> None:
    """One panel a number: seconds and memory over it, both logarithmic."""
    plt, ticker = importlib.import_module("matplotlib.pyplot"), importlib.import_module("matplotlib.ticker")
    figure, axes = plt.subplots(2, len(found), figsize=(3.0 * len(found), 5.4), squeeze=False, sharey="row")
    for column, told in enumerate(found.values()):
        for row, (key, exponent) in enumerate((("seconds", "exponent"), ("peak", "memory exponent"))):
            axis, values = axes[row, column], np.array(told["values"])
            taken = np.array(told[key])
            axis.loglog(values, taken, "o-", color="tab:blue")
            line = np.exp(np.log(taken).mean()) * (values / np.exp(np.log(values).mean())) ** told[exponent]
            axis.loglog(values, line, ":", color="0.5", label=f"power {told[exponent]:.2f}")
            axis.set_xticks(values, [f"{value:g}" for value in values])
            axis.minorticks_off()
            axis.set_title(told["label"] if row == 0 else "", fontsize="medium")
            axis.legend(frameon=False)
    for row in (0, 1):  # marks that the eye can read: 1, 2, 5, 10 and so on
        axes[row, 0].yaxis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0)))
        axes[row, 0].yaxis.set_major_formatter(ticker.FormatStrFormatter("%g"))
    axes[1, 0].set_ylim(*(limit * factor for limit, factor in zip(axes[1, 0].get_ylim(), (0.5, 1.5), strict=True)))
    axes[0, 0].set_ylabel("processor time [s]")
    axes[1, 0].set_ylabel("greatest memory [MB]")
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)


def doubling() -> dict[str, float]:
    """Greatest change of each kind of history when roll positions and slices double, over its greatest magnitude."""
    scene = sw.load_scene("face_gear_25x160")
    twice = {f"numerics.{name}": 2 * getattr(scene.numerics, name) for name in ("roll_positions", "face_slices")}
    coarse, fine = sw.simulate(scene)["history"], sw.simulate(scene.replace(twice))["history"]
    changes = {}
    for kind, names in KINDS.items():
        greatest = max(float(abs(fine[name]).max()) for name in names)
        changes[kind] = max(float(abs(fine[name] - coarse[name]).max()) for name in names) / greatest
        print(f"{kind:20s} {100.0 * changes[kind]:5.2f} %")
    return changes


def _print_warm(row: dict[str, Any]) -> None:
    if "error" in row:
        print(f"{row['case']:12s} {row['threads']:2d}  {row['error'].splitlines()[0]}", flush=True)
        return
    peak = "" if row["peak"] is None else f"{row['peak']:7.0f} MB"
    stages = ", ".join(f"{name} {value:.2f}" for name, value in row["stages"].items() if value >= 0.01)
    side_by_side = " " * 7 if row["copies"] is None else f"{row['copies']:6.2f}x"
    print(
        f"{row['case']:12s} {row['threads']:2d} {row['wall']:8.2f} s {row['processor']:8.2f} s {peak}"
        f" {row['speed-up']:6.2f}x {side_by_side}  {stages}",
        flush=True,
    )


def _arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", help=", ".join(case.name for case in CASES))
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="runs of each, after one more")
    parser.add_argument("--threads", type=int, nargs="+", default=[1], metavar="N", help="numbers of threads")
    parser.add_argument("--cold", action="store_true", help="first runs in new processes instead")
    parser.add_argument("--against", metavar="COMMIT", help="a stored commit instead, in pairs")
    parser.add_argument("--growth", metavar="PICTURE", help="time and memory over what makes a run larger instead")
    parser.add_argument("--doubling", action="store_true", help="what twice the resolution changes instead")
    parser.add_argument("--json", metavar="FILE", help="write the figures")
    options = parser.parse_args(arguments)
    known = {case.name for case in CASES} | ({kind.name for kind in GROWTH} if options.growth else set())
    for name in options.cases:
        if name not in known:
            parser.error(f"no case {name!r}; there are {', '.join(sorted(known))}")
    if options.repeat < 1 or min(options.threads) < 1:
        parser.error("--repeat and --threads are at least 1")
    return options


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the benchmark and print its tables."""
    options = _arguments(arguments)
    cases = [case for case in CASES if not options.cases or case.name in options.cases]
    figures: dict[str, Any] = {"when": time.strftime("%Y-%m-%d"), "processors": os.cpu_count()}
    if options.cold:
        figures["cold"] = cold()
    elif options.doubling:
        figures["doubling"] = doubling()
    elif options.growth:
        kinds = [kind for kind in GROWTH if not options.cases or kind.name in options.cases]
        figures["growth"] = growth(kinds, options.repeat)
        draw_growth(figures["growth"], options.growth)
    elif options.against:
        print(f"{'case':12s} {options.against:>10s} {'now':>10s}")
        figures["against"] = {options.against: against(options.against, cases, options.repeat)}
    else:
        print(f"{'case':12s} threads  wall  processor    peak  speed-up  copies  stages [s]")
        figures["warm"] = []
        for case in cases:
            for row in warm(case, options.threads, options.repeat):
                figures["warm"].append(row)
                _print_warm(row)
    if options.json:
        Path(options.json).write_text(json.dumps(figures, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
