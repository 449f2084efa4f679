"""The seed paper: its title, the numbers of its reference file and all its statements."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from semiwear.report.comparison import Comparison
from semiwear.report.paper_load import LEVEL_DEPTH, LOAD
from semiwear.report.paper_wear import WEAR

__all__ = ["SEED_PAPER", "TITLE", "numbers"]

TITLE = "Analysis on load-bearing contact characteristics of face gear tooth surface wear"

SEED_PAPER: tuple[Comparison, ...] = (*WEAR, *LOAD)
"""Every statement of the seed paper, in the order of the report."""


def numbers(paper: Mapping[str, Any]) -> dict[str, Any]:
    """Numbers that the statements name, from the reference file."""
    engagements = paper["wear"]["engagements_1e10"]
    increments = np.diff([0.0, *engagements])
    return {
        **{name: str(value).replace("-", "−") for name, value in paper["at_60_um"].items()},
        "depth": paper["wear"]["control_depth_um"][-1],
        "level_engagements": engagements[paper["wear"]["control_depth_um"].index(LEVEL_DEPTH)],
        "first_increment": increments[0],
        "last_increment": increments[-1],
        "last_engagements": engagements[-1],
    }
