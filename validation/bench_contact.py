"""Half-space contact: our solver against tamaas, ContactMechanics and aspher, on one core, at the same field error.

    python validation/bench_contact.py [--json FILE] [--sizes 64 128 256 512] [--repeats N] [--quick]
    python validation/bench_contact.py --rough 512 1024  # self-affine surfaces, 1, 10 and 50 % in contact, instead

Elliptic Hertz contact on n x n cells, circular Hertz contact on square cells (for aspher), and sweeps of 40 roll
positions at 30 x 100 and 64 x 200 cells with warm starts (ms are then per position, errors the greatest of all).
All codes have Love's kernel and so the same discrete solution. Tolerances mean something else in each of them: what
counts is the relative L2 error of the pressure against the converged discrete solution (ours at a tight tolerance,
checked against the peers at theirs). Each code runs at its loosest tolerance with an error of at most 1e-6, in its
fastest variant, in turn with the others. Operators are set up before; ours has what it keeps from earlier calls,
and is timed once more "on a new grid" (whose cell differs in the ninth digit); ratios "with setup" compare that.
Times are processor seconds, which other work on the machine disturbs least; our rough ones come in units of one
zero-padded convolution, too.

The JSON has `machine`, `versions`, `missing` (code: why), `cold` (seconds of first calls in new processes),
`cases` (one each: reference check, and Hertz errors) and `rows` (one each case and code; see `Row`).
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import argparse
import json
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from importlib import metadata
from typing import Any

from contact_peers import PEERS, Answer, Code, Semiwear, Solve, field_error, solve_case
from contact_problems import ROUGH_LOADS, Case, HertzProblem, RollSweep, RoughProblem, circular_hertz, unseen

from semiwear.compliance.half_space import HalfSpace

TARGET = 1e-6  # relative L2 error of the pressure
STEP = 10.0**0.5
LADDER = tuple(10.0 ** (-rung / 2) for rung in range(4, 23))
FIRST_RUNG = LADDER.index(10.0**-7)
TIGHT = 1e-11  # of peers, against which the reference is checked; 1e-10 on more than 256 x 256 cells
CHECKED = 1024 * 1024  # cells at most; peers take an hour for more
REFERENCE = 1e-12  # of ours
BUDGET = 12.0  # seconds of timed runs of one code in one case; two at least, one that found the setting if longer
TURN = 0.3  # seconds within which a fast code runs up to five times in its turn
SLOW = 1.0  # seconds of a run beyond which a case keeps the variant that was best in the case before

REQUIRED: dict[tuple[str, str], dict[tuple[int, int], float]] = {
    ("elliptic", "tamaas"): {(64, 64): 10, (128, 128): 25, (256, 256): 40, (512, 512): 50},
    ("elliptic", "ContactMechanics"): {(64, 64): 8, (128, 128): 12, (256, 256): 20, (512, 512): 20},
    ("circular", "aspher"): {(64, 64): 1, (128, 128): 2, (256, 256): 3, (512, 512): 4},
    ("sweep", "tamaas"): {(30, 100): 15, (64, 200): 25},
}
COLD = """
import time
import numpy as np
from semiwear.contact import solve_half_space
x = (np.arange(64) - 31.5) / 40
begin = time.perf_counter()
solve_half_space(x[:, None]**2 / 40 + x**2 / 40, cell=(1 / 40, 1 / 40), effective_modulus=115e3, load=1000.0)
print(time.perf_counter() - begin)
"""


@dataclass(frozen=True)
class Row:
    """One code in one case; ratios are its times over ours, None for ours.

    `ms` is a median (per position in a sweep), `ratio` that of medians, judged against `required`; `ratio_of_bests`
    is that of least times. `setup_ms` is what a peer took before, `new_grid_ms` our time on a grid that we have not
    seen, `ratio_with_setup` the ratio of the two sums. `variants_ms` has every variant that was tried, at its own
    cheapest tolerance. `convolutions` is our time on a new grid in units of one zero-padded convolution of the grid.
    """

    case: str
    points: tuple[int, int]
    code: str
    variant: str
    tolerance: float
    ms: float
    best_ms: float
    repeats: int
    field_error: float
    iterations: float | None
    converged: bool
    setup_ms: float
    variants_ms: dict[str, float]
    new_grid_ms: float | None = None
    ratio: float | None = None
    ratio_of_bests: float | None = None
    ratio_with_setup: float | None = None
    convolutions: float | None = None
    required: float | None = None
    met: bool | None = None


@dataclass
class Contender:
    """A code that was opened on a case, and the setting that was found for it."""

    code: Code
    solve: Solve
    setup: float
    variant: str
    rung: int
    error: float
    answers: list[Answer]
    variants_ms: dict[str, float]


BEGIN = time.perf_counter()


def progress(text: str) -> None:
    """Say on stderr what is going on."""
    print(f"[{time.perf_counter() - BEGIN:4.0f} s] {text}", file=sys.stderr, flush=True)


def timed(action: Callable[[], Any]) -> tuple[Any, float]:
    """What an action returns, and its processor seconds."""
    begin = time.process_time()
    result = action()
    return result, time.process_time() - begin


def cheapest_rung(error_at: Callable[[int], float], first: int, rungs: int, target: float = TARGET) -> int | None:
    """Loosest rung of a ladder of tolerances whose error is within the target, searched from a first guess.

    A looser rung is only tried where the error leaves room for it, since runs can be long.
    """
    known: dict[int, float] = {}

    def error(rung: int) -> float:
        if rung not in known:
            known[rung] = error_at(rung)
        return known[rung]

    rung = first
    while error(rung) > target:
        if rung + 1 == rungs:
            return None
        rung += 1
    while rung > 0 and error(rung) * STEP <= target and error(rung - 1) <= target:
        rung -= 1
    return rung


def references(case: Case) -> list[Answer]:
    """Our solution at a tight tolerance."""
    return solve_case(Semiwear().open(case), case, Semiwear.variants[0], REFERENCE)


def prepare(code: Code, case: Case, exact: Sequence[Answer], before: Contender | None) -> Contender | None:
    """Set a code up and find its fastest variant and cheapest tolerance; `before` is the code in the case before."""
    solve, setup = timed(lambda: code.open(case, [float(answer.approach) for answer in exact]))
    variants = code.variants
    if len(case.problems) == 1 and code.name == "tamaas":
        variants = variants[:1]  # they differ in warm starts only
    slowest = 0.0 if before is None else before.variants_ms[before.variant] / 1e3 * len(case.problems)
    if before is not None and slowest > SLOW / 5 and before.variant in variants:
        variants = (before.variant,)
    found: dict[str, tuple[float, int, float, list[Answer]]] = {}
    for variant in variants:
        runs: dict[int, tuple[list[Answer], float, float]] = {}

        def error_at(rung: int, variant: str = variant, runs: dict[int, Any] = runs) -> float:
            answers, seconds = timed(lambda: solve_case(solve, case, variant, LADDER[rung]))
            runs[rung] = answers, seconds, field_error(answers, exact)
            progress(
                f"{case.label}: {code.name}, {variant}, {LADDER[rung]:.1e}: {runs[rung][2]:.1e} in {seconds:.3f} s"
            )
            return runs[rung][2]

        rung = cheapest_rung(error_at, before.rung if before else FIRST_RUNG, len(LADDER))
        if rung is None:
            progress(f"{case.label}: {code.name}, {variant}: never within {TARGET:g}")
            continue
        answers, seconds, error = runs[rung]
        if len(variants) > 1 and seconds < SLOW:
            again = [timed(lambda v=variant, r=rung: solve_case(solve, case, v, LADDER[r]))[1] for _ in range(4)]
            seconds = min(seconds, *again)
        found[variant] = seconds, rung, error, answers
    if not found:
        return None
    variants_ms = {variant: 1e3 * entry[0] / len(case.problems) for variant, entry in found.items()}
    best = min(found, key=lambda variant: found[variant][0])
    _, rung, error, answers = found[best]
    return Contender(code, solve, setup, best, rung, error, answers, variants_ms)


def race(case: Case, contenders: Sequence[Contender], rounds: int) -> tuple[dict[str, list[float]], list[float]]:
    """Run all codes in turn; seconds of each, and ours on unseen grids.

    Slow codes sit out some rounds, fast ones run a few times in each.
    """
    seconds: dict[str, list[float]] = {contender.code.name: [] for contender in contenders}
    fresh: list[float] = []
    turns, times = {}, {}
    for contender in contenders:
        name, expected = contender.code.name, contender.variants_ms[contender.variant] / 1e3 * len(case.problems)
        turns[name] = max(min(2, rounds), min(rounds, int(BUDGET / expected)))
        times[name] = max(1, min(5, int(TURN / expected)))
        if expected > BUDGET:
            seconds[name], turns[name] = [expected], 1
    progress(f"{case.label}: " + ", ".join(f"{name} {turns[name] * times[name]} times" for name in turns))
    for number in range(rounds):
        for contender in contenders:
            name, tolerance = contender.code.name, LADDER[contender.rung]
            if (number + 1) * turns[name] // rounds == number * turns[name] // rounds:
                continue
            for _ in range(times[name]):
                run = timed(lambda c=contender, t=tolerance: solve_case(c.solve, case, c.variant, t))
                seconds[name].append(run[1])
            if name == Semiwear.name:
                solve = contender.code.open(unseen(case, number), ())
                fresh.append(timed(lambda s=solve, c=contender, t=tolerance: solve_case(s, case, c.variant, t))[1])
    return seconds, fresh


def check(case: Case, exact: Sequence[Answer], codes: Sequence[Code]) -> dict[str, Any]:
    """Hertz errors of the reference, and its difference from peers at tight tolerances (one on fine grids)."""
    entry: dict[str, Any] = {"case": case.name, "points": case.points, "positions": len(case.problems)}
    if case.hertz is not None:
        entry["peak_error"] = float(exact[0].pressure.max() / case.hertz.peak_pressure - 1)
        entry["approach_error"] = float(exact[0].approach / case.hertz.approach - 1)
    entry["reference_converged"] = all(answer.converged for answer in exact)
    entry["reference_against"] = {}
    cells = case.points[0] * case.points[1]
    if cells > CHECKED:
        codes = []
    elif cells > 128 * 128 or len(case.problems) > 1:
        codes = [code for code in codes if code.name != "tamaas"] or codes[:1]
    for code in codes:
        solve = code.open(case, [float(answer.approach) for answer in exact])
        answers = solve_case(solve, case, code.variants[0], TIGHT if cells <= 256 * 256 else 10 * TIGHT)
        entry["reference_against"][code.name] = field_error(answers, exact)
    differences = ", ".join(f"{name} {error:.1e}" for name, error in entry["reference_against"].items())
    progress(f"{case.label}: reference against {differences or 'nobody'}")
    return entry


def row(case: Case, contender: Contender, seconds: Sequence[float]) -> Row:
    """Figures of one code in one case, not yet compared."""
    milliseconds = [1e3 * value / len(case.problems) for value in seconds]
    counts = [answer.iterations for answer in contender.answers if answer.iterations >= 0]
    return Row(
        case=case.name,
        points=case.points,
        code=contender.code.name,
        variant=contender.variant,
        tolerance=LADDER[contender.rung],
        ms=statistics.median(milliseconds),
        best_ms=min(milliseconds),
        repeats=len(seconds),
        field_error=contender.error,
        iterations=statistics.mean(counts) if counts else None,
        converged=all(answer.converged for answer in contender.answers),
        setup_ms=1e3 * contender.setup,
        variants_ms=contender.variants_ms,
        required=REQUIRED.get((case.name, contender.code.name), {}).get(case.points),
    )


def compared(peer: Row, ours: Row, positions: int) -> Row:
    """Figures of a peer with its ratios to ours."""
    ratio, setup = peer.ms / ours.ms, peer.setup_ms / positions
    return replace(
        peer,
        ratio=ratio,
        ratio_of_bests=peer.best_ms / ours.best_ms,
        ratio_with_setup=(peer.ms + setup) / ours.new_grid_ms if ours.new_grid_ms else None,
        met=None if peer.required is None else ratio >= peer.required,
    )


def convolution(case: Case) -> float:
    """Processor seconds of one zero-padded convolution of a case's grid, in double precision: a median of nine."""
    operator = HalfSpace(case.points, case.problems[0].cell)
    operator.apply(case.problems[0].gap)
    return statistics.median(timed(lambda: operator.apply(case.problems[0].gap))[1] for _ in range(9))


def run_case(
    case: Case, codes: Sequence[Code], rounds: int, before: dict[tuple[str, str], Contender]
) -> tuple[dict[str, Any], list[Row]]:
    """All codes on one case; `before` has the contenders of the cases before, and gets these."""
    takers = [code for code in codes if code.can(case)]
    if case.name == "circular":
        takers = [code for code in takers if code.name == "aspher"]
    progress(f"{case.label}: reference")
    exact = references(case)
    entry = check(case, exact, takers)
    contenders = []
    for code in (Semiwear(), *takers):
        contender = prepare(code, case, exact, before.get((case.name, code.name)))
        if contender is not None:
            contenders.append(contender)
            before[case.name, code.name] = contender
    answered = [contender.code.name for contender in contenders]
    entry["without_answer"] = [code.name for code in (Semiwear(), *takers) if code.name not in answered]
    seconds, fresh = race(case, contenders, rounds)
    rows = [row(case, contender, seconds[contender.code.name]) for contender in contenders]
    if Semiwear.name in answered:
        new_grid = statistics.median(fresh) / len(case.problems)
        ours = replace(rows[0], new_grid_ms=1e3 * new_grid, setup_ms=0.0, convolutions=new_grid / convolution(case))
        rows = [ours, *(compared(peer, ours, len(case.problems)) for peer in rows[1:])]
    return entry, rows


def installed() -> tuple[list[Code], dict[str, str]]:
    """Peers that can be opened, and why the others cannot."""
    codes, missing = [], {}
    for code in PEERS:
        try:
            code.open(circular_hertz(16).case(), [1.0])
            codes.append(code)
        except ImportError as error:
            missing[code.name] = str(error)
    return codes, missing


def cold_calls() -> dict[str, float]:
    """Seconds of our first call in a new process, without and with compiled kernels on disk."""
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | {"NUMBA_CACHE_DIR": cache}
        seconds = [
            float(
                subprocess.run([sys.executable, "-c", COLD], env=environment, capture_output=True, check=True).stdout
            )
            for _ in range(2)
        ]
    return dict(zip(("kernels compiled", "kernels cached"), seconds, strict=True))


def versions() -> dict[str, str]:
    """Versions of all codes that are there."""
    found = {}
    for name in ("semiwear", "numpy", "scipy", "numba", "tamaas", "ContactMechanics", "NuMPI", "muGrid", "aspher"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


def run(
    sizes: Sequence[int],
    others: Sequence[Case],
    rounds: int,
    *,
    cold: bool = True,
    only: Sequence[str] = (),
    keep: Callable[[dict[str, Any]], None] = lambda report: None,
) -> dict[str, Any]:
    """The whole benchmark, as it goes into the JSON; `only` names the peers if not all of them run.

    `keep` takes it after every case, so that a long run that is ended loses one case.
    """
    codes, missing = installed()
    for name, why in missing.items():
        progress(f'{name} is not there ({why}): pip install "semiwear[peers]"')
    codes = [code for code in codes if not only or code.name in only]
    cases = [HertzProblem(size).case() for size in sizes]
    if any(code.name == "aspher" for code in codes):
        cases += [circular_hertz(size).case() for size in sizes]
    cases += others
    report: dict[str, Any] = {
        "machine": {
            "processor": platform.machine(),
            "cpus": os.cpu_count(),
            "system": platform.system(),
            "python": platform.python_version(),
            "load_average": os.getloadavg() if hasattr(os, "getloadavg") else None,
        },
        "versions": versions(),
        "missing": missing,
        "target_field_error": TARGET,
        "cold": cold_calls() if cold else None,
        "cases": [],
        "rows": [],
    }
    before: dict[tuple[str, str], Contender] = {}
    for case in cases:
        entry, rows = run_case(case, codes, rounds, before)
        report["cases"].append(entry)
        report["rows"] += [asdict(figures) for figures in rows]
        report["seconds"] = time.perf_counter() - BEGIN
        keep(report)
    return report


def table(report: dict[str, Any]) -> str:
    """Report as plain text."""
    lines = []
    for name, why in report["missing"].items():
        lines.append(f'not installed: {name} ({why}); pip install "semiwear[peers]"')
    if report["cold"]:
        lines.append("our first call [s]: " + ", ".join(f"{k} {v:.2f}" for k, v in report["cold"].items()))
    for case in report["cases"]:
        against = ", ".join(f"{name} {error:.1e}" for name, error in case["reference_against"].items()) or "nobody"
        hertz = f"; peak {case['peak_error']:+.1e} of Hertz's" if "peak_error" in case else ""
        lines += ["", f"{case['case']} {case['points'][0]} x {case['points'][1]}: reference against {against}{hertz}"]
        heads = (
            "code",
            "variant",
            "tolerance",
            "ms",
            "runs",
            "field error",
            "iterations",
            "ratio",
            "required",
            "met",
        )
        lines.append("  {:17s}{:26s}{:>10s}{:>10s}{:>6s}{:>13s}{:>11s}{:>8s}{:>10s}{:>5s}".format(*heads))
        for entry in report["rows"]:
            if (entry["case"], entry["points"]) != (case["case"], case["points"]):
                continue
            figures = [("iterations", ".0f", 11), ("ratio", ".1f", 7), ("ratio_with_setup", ".1f", 11)]
            figures += [("required", "g", 9)]
            numbers = ["" if entry[k] is None else format(entry[k], form) for k, form, _ in figures]
            met = {True: "yes", False: "NO", None: ""}[entry["met"]]
            lines.append(
                f"  {entry['code']:17s}{entry['variant']:26s}{entry['tolerance']:9.0e}{entry['ms']:10.2f}"
                f"{entry['repeats']:5d}{entry['field_error']:9.0e}"
                + "".join(f"{number:>{figure[2]}s}" for number, figure in zip(numbers, figures, strict=True))
                + f"{met:>4s}"
                + ("" if entry["converged"] else "  says it did not converge")
            )
            if entry["new_grid_ms"] is not None:
                of_one = f"{entry['convolutions']:.0f} convolutions"
                lines.append(f"  {'':17s}{'on a new grid':35s}{entry['new_grid_ms']:10.2f}  {of_one}")
            if len(entry["variants_ms"]) > 1:
                tried = ", ".join(f"{name} {ms:.2f}" for name, ms in entry["variants_ms"].items())
                lines.append(f"  {'':17s}best of five [ms]: {tried}")
        lines += [f"  {name}: never within {TARGET:g}" for name in case["without_answer"]]
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the benchmark, print its tables, write its JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[64, 128, 256, 512], help="cells each way")
    parser.add_argument("--rough", type=int, nargs="+", metavar="N", help="rough surfaces of N x N cells instead")
    parser.add_argument("--peers", nargs="+", default=[], metavar="CODE", help="peers to run; all when missing")
    parser.add_argument("--repeats", type=int, default=9, help="runs of each code in a case; slow ones get fewer")
    parser.add_argument("--quick", action="store_true", help="64 cells, a short sweep, 3 runs, no new processes")
    parser.add_argument("--json", metavar="FILE", help="write the figures")
    options = parser.parse_args(arguments)

    def keep(report: dict[str, Any]) -> None:
        if options.json:
            with open(options.json, "w", encoding="utf-8") as file:
                json.dump(report, file, indent=1)

    if options.quick:
        sweep = RollSweep((30, 100)).case()
        report = run([64], [replace(sweep, problems=sweep.problems[:8])], 3, cold=False, keep=keep)
    elif options.rough:
        rough = [RoughProblem(size, fraction).case() for size in options.rough for fraction in ROUGH_LOADS]
        report = run([], rough, options.repeats, cold=False, only=options.peers, keep=keep)
    else:
        sweeps = [RollSweep(points).case() for points in ((30, 100), (64, 200))]
        report = run(options.sizes, sweeps, options.repeats, only=options.peers, keep=keep)
    print(table(report))


if __name__ == "__main__":
    main()
