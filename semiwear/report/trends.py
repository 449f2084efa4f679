"""Rules by which a series of values rises, falls or levels, stated in words and computed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.report.markup import with_unit

REVERSAL_SHARE = 0.05
"""Part of its range by which a rising series may lie below its running maximum."""

LEVEL_SHARE = 0.25
"""A series levels if it changes by less than this part of its range over the last third of the meshes."""

RULES: dict[str, str] = {
    "rises": (
        f"the last value is above the first, and no value lies below the running maximum by more than "
        f"{REVERSAL_SHARE:.0%} of the whole range"
    ),
    "falls": "the same for the negative of the values",
    "levels": (
        f"over the last third of the meshes the value changes by less than {LEVEL_SHARE:.0%} of its whole range "
        "(an even slope would change it by 33 %)"
    ),
}


@dataclass(frozen=True)
class Trend:
    """Whether a rule holds, and a description of the series."""

    holds: bool
    text: str


def rises(values: np.ndarray, units: str = "") -> Trend:
    """Whether a series rises (see `RULES`)."""
    return _monotone(values, 1.0, "drops", units)


def falls(values: np.ndarray, units: str = "") -> Trend:
    """Whether a series falls (see `RULES`)."""
    return _monotone(values, -1.0, "climbs", units)


def levels(meshes: np.ndarray, values: np.ndarray) -> Trend:
    """Whether a series levels over the last third of the meshes (see `RULES`)."""
    spread = float(np.ptp(values))
    before = float(np.interp(2.0 / 3.0 * meshes[-1], meshes, values))
    change = abs(float(values[-1]) - before)
    share = change / spread if spread > 0 else 0.0
    return Trend(share < LEVEL_SHARE, f"it changes by {share:.0%} of its range over the last third of the meshes")


def _monotone(values: np.ndarray, sign: float, reversal: str, units: str) -> Trend:
    signed = sign * np.asarray(values, dtype=float)
    spread = float(np.ptp(signed))
    behind = np.maximum.accumulate(signed) - signed
    worst = int(behind.argmax())
    share = float(behind[worst]) / spread if spread > 0 else 0.0
    first, last = (with_unit(values[step], units) for step in (0, -1))
    text = f"{first} at first, {last} at last"
    if share > REVERSAL_SHARE:
        turn = int(signed[: worst + 1].argmax())
        text += (
            f"; in between it {reversal} from {with_unit(values[turn], units)} at step {turn} to "
            f"{with_unit(values[worst], units)} at step {worst}, {share:.0%} of its range"
        )
    return Trend(bool(signed[-1] > signed[0]) and share <= REVERSAL_SHARE, text)
