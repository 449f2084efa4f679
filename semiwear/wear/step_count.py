"""How many implicit wear steps a depth takes.

A step's error grows with its depth over the size of the teeth. On the shipped spur pair three steps leave 2 % of the
greatest depth, whichever body wears, and twice as many half of that.
"""

from __future__ import annotations

from math import ceil

__all__ = [
    "DEEP",
    "LEAST_STEPS",
    "MOST_STEPS",
    "PLAIN_STEPS",
    "SEARCH_STEPS",
    "depth_of_step",
    "life_steps_for_depth",
    "parts_of_step",
    "steps_for_depth",
    "steps_of_life",
]

_DEPTH_A_STEP = 4.5e-4  # of the base pitch: 6 um at a module of 4.5 mm
LEAST_STEPS, MOST_STEPS = 3, 40
# in two stages: lives of the shipped pair until 10 to 60 um err by 1.1 % at most then, in three steps by 4.6 %
_LEAST_LIFE_STEPS = 6
SEARCH_STEPS = 3  # that a search for the end of a life takes, about, besides those to it
# errors of the greatest depth at three times: 0.6 % until 60 um on the shipped scene, 1.1 and 5 % on other kinds
DEEP = 3.0  # times the depth that a step is meant for
PLAIN_STEPS = 2.0  # that one in two stages is worth


def depth_of_step(base_pitch: float) -> float:
    """Greatest wear depth of either body that one step is meant for [mm], on teeth of a base pitch [mm]."""
    return _DEPTH_A_STEP * base_pitch


def parts_of_step(depth: float, usual: float) -> float:
    """In how many parts of the usual depth a step is taken, the last one shorter; 1 where it is not deep."""
    return min(depth / usual, float(MOST_STEPS)) if depth > DEEP * usual else 1.0


def steps_for_depth(depth: float, base_pitch: float) -> int:
    """Steps until the greatest wear depth of either body [mm] is `depth`, on teeth of a base pitch [mm]."""
    return min(max(ceil(depth / depth_of_step(base_pitch)), LEAST_STEPS), MOST_STEPS)


def life_steps_for_depth(depth: float, base_pitch: float) -> int:
    """Steps in two stages of a life until the greatest wear depth [mm] is `depth`, on teeth of a base pitch [mm]."""
    return max(steps_for_depth(depth, base_pitch), _LEAST_LIFE_STEPS)


def steps_of_life(depth_limit: float, base_pitch: float) -> int:
    """Steps in two stages, about, for a life until a depth [mm] and for what torque does to it: two more lives."""
    return 3 * life_steps_for_depth(depth_limit, base_pitch) + SEARCH_STEPS
