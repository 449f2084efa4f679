"""Steps to control depths, in parts where they are deep.

Depths at the control point say little of what wears elsewhere: where both bodies wear, a tooth of one may meet many
times as often as a tooth of the other. A step far deeper than usual errs by several per cent. Its parts together take
less than half as long again, since time goes with the cycles in which the contact's shape follows the wear.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Protocol

from semiwear.wear.state import ControlPoint, WearState
from semiwear.wear.step_count import DEEP, parts_of_step

__all__ = ["parted_step_to_depth"]

_SPLINTER = 1e-2  # of a part: a shorter last one joins the one before


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
        So far, the unworn one first: the step starts from the last. How much the step before wore off foretells the
        parts of this one; the first step is taken whole, and once more in parts where it was deep.
    point : ControlPoint
    depths : sequence of float [mm]
        At the control point in every state from the unworn one on, and at least in one more.
    part : float [mm]
        Greatest wear depth that one part is meant for.
    smooth : bool
        Whether what is found is to be a smooth function of the wear: the last part is a shorter one then, instead of
        all being alike.
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
