"""How many implicit wear steps a depth takes.

A step's error grows with its depth over the size of the teeth. On the shipped spur pair three steps leave 2 % of the
greatest depth, whichever body wears, and twice as many half of that.
"""

from __future__ import annotations

from math import ceil

__all__ = ["LEAST_STEPS", "MOST_STEPS", "steps_for_depth"]

_DEPTH_A_STEP = 4.5e-4  # of the base pitch: 6 um at a module of 4.5 mm
LEAST_STEPS, MOST_STEPS = 3, 40


def steps_for_depth(depth: float, base_pitch: float) -> int:
    """Steps until the greatest wear depth of either body [mm] is `depth`, on teeth of a base pitch [mm]."""
    return min(max(ceil(depth / (_DEPTH_A_STEP * base_pitch)), LEAST_STEPS), MOST_STEPS)
