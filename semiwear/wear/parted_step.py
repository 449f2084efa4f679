"""Steps to control depths, divided into parts where they are deep.

The depth at the control point says little about the wear elsewhere: where both bodies wear, a tooth of one may mesh
many times as often as a tooth of the other. A step far deeper than usual has an error of several per cent. Dividing
it takes less than half as long again, since the time depends on the number of cycles.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Protocol

from semiwear.wear.state import ControlPoint, WearState
from semiwear.wear.step_count import DEEP, parts_of_step

_SPLINTER = 1e-2  # of a part: a shorter last part is added to the one before


class _ToDepth(Protocol):
    def step_to_depth(self, state: WearState, point: ControlPoint, depth: float) -> WearState: ...


def parted_step_to_depth(
    stepper: _ToDepth,
    states: Sequence[WearState],
    point: ControlPoint,
    depths: Sequence[float],
    part: float,
    *,
    smooth: bool = False,
) -> WearState:
    """The state at the next control depth: in one step, or in parts if that would be deep on either body.

    Parameters
    ----------
    stepper : WearStepper or TwoStageStepper
    states : sequence of WearState
        States so far, the unworn one first; the step starts from the last. The wear of the previous step predicts the
        number of parts. The first step is done whole, and again in parts if it was deep.
    point : ControlPoint
    depths : sequence of float [mm]
        Depths of the control point in all states so far, and at least one more.
    part : float [mm]
        Greatest wear depth that one part is meant for.
    smooth : bool
        Whether the result is to be a smooth function of the wear: the last part is then shorter, instead of all parts
        being equal.
    """
    state, begin, end = states[-1], depths[len(states) - 1], depths[len(states)]
    parts = 1.0
    if len(states) > 1:
        grown = states[-1].worn.deepest_since(states[-2].worn)
        parts = parts_of_step(grown * (end - begin) / (begin - depths[len(states) - 2]), part)
    while True:
        now = state
        for share in _ends(parts, smooth):
            now = stepper.step_to_depth(now, point, end if share == 1.0 else begin + share * (end - begin))
        needed = parts_of_step(now.worn.deepest_since(state.worn), part)
        if needed <= DEEP * parts:
            return now
        parts = needed


def _ends(parts: float, smooth: bool) -> list[float]:
    """Shares of a step at which its parts end."""
    count = ceil(parts - _SPLINTER)
    return [*(k / (parts if smooth else count) for k in range(1, count)), 1.0]
