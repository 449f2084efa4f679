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
from collections.abc import Sequence
from pathlib import Path

from validation.finite_elements import CASES, recompute
from validation.parallel import build_all
from validation.problems import PROBLEMS
from validation.progress import progress_on
from validation.sections import SECTIONS
from validation.writer import write


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
        unknown = [case for case in options.recompute if case not in CASES]
        if unknown:
            sys.exit(f"--recompute: no case {', '.join(unknown)}; there are: {', '.join(CASES)}")
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
