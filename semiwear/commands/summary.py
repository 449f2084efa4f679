"""The end of a command that solved a study file."""

from __future__ import annotations

import time


def print_summary(summary: str, begin: float) -> float:
    """Print the summary of a study and the seconds since it began, which are returned."""
    spent = time.perf_counter() - begin
    print(summary)
    print(f"\n{spent:.1f} s")
    return spent
