"""The validation report: python -m validation [--quick] [-o FOLDER] [--recompute [CASE ...]] [--sections NAME ...]
        [--jobs N].

Writes `validation.html`, one page that needs nothing but itself, and its numbers as `validation.nc` and CSV files.
Every number is computed in the run, but for finite elements, which are read from stored results and renewed with
`--recompute`, outside the time limits. The exit status is 1 if a section could not be built.
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from validation.parallel import build_all
from validation.problems import PROBLEMS
from validation.progress import progress_on
from validation.sections import SECTIONS
from validation.writer import write


def recompute(cases: Sequence[str]) -> None:
    """Renew stored finite-element results; all cases where none is named."""
    import semiwear as sw
    from validation import finite_elements

    unknown = [case for case in cases if case not in finite_elements.CASES]
    if unknown:
        sys.exit(f"--recompute: no case {', '.join(unknown)}; there are: {', '.join(finite_elements.CASES)}")
    scene = sw.load_scene(finite_elements.SCENE)
    for case in cases or finite_elements.CASES:
        started = time.perf_counter()
        tree = finite_elements.compute(case, scene)
        print(f"{case}: {finite_elements.store(case, tree, time.perf_counter() - started)}", flush=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Build the report."""
    names = [plan.name for plan in SECTIONS]
    parser = argparse.ArgumentParser(prog="python -m validation", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="under three minutes: fewer points, coarser references")
    parser.add_argument("-o", "--output", type=Path, default=Path("validation-report"), metavar="FOLDER")
    parser.add_argument("--recompute", nargs="*", metavar="CASE", help="finite elements anew; alone: all cases")
    parser.add_argument("--sections", nargs="+", choices=names, default=names, metavar="NAME", help=", ".join(names))
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1), metavar="N", help="processes")
    options = parser.parse_args(arguments)

    if options.recompute is not None:
        recompute(options.recompute)
    chosen = [plan for plan in SECTIONS if plan.name in options.sections]
    progress = progress_on(sys.stderr, len(chosen))
    parts = build_all(chosen, PROBLEMS, options.quick, progress, options.jobs)
    progress.close()
    print(write(parts, options.output, quick=options.quick))
    for part in parts:
        if part.error:
            print(f"{part.plan.title}: {part.error}", file=sys.stderr)
    return 1 if any(part.error for part in parts) else 0


if __name__ == "__main__":
    sys.exit(main())
