"""Number of implicit wear steps for a depth.

The error of a step grows with its depth over the size of the teeth. For the shipped spur pair three steps have an
error of 2 % of the greatest depth, whichever body wears, and six steps half of that.
"""

from __future__ import annotations

from math import ceil

_DEPTH_A_STEP = 4.5e-4  # of the base pitch: 6 um at a module of 4.5 mm
LEAST_STEPS, MOST_STEPS = 3, 40
# in two stages: lives of the shipped pair until 10 to 60 um have errors up to 1.1 %, in three steps up to 4.6 %
_LEAST_LIFE_STEPS = 6
SEARCH_STEPS = 3  # additional steps of the search for the end of a life, about
# errors of the greatest depth at three times: 0.6 % until 60 um on the shipped scene, 1.1 and 5 % on other kinds
DEEP = 3.0  # multiple of the depth that a step is meant for, from which it is divided
PLAIN_STEPS = 2.0  # plain steps of the same cost as one in two stages


def depth_of_step(base_pitch: float) -> float:
    """Greatest wear depth of either body that one step is meant for [mm], on teeth of a base pitch [mm]."""
    return _DEPTH_A_STEP * base_pitch


def parts_of_step(depth: float, usual: float) -> float:
    """Number of parts of the usual depth into which a step is divided, with a fraction; 1 if it is not deep."""
    return min(depth / usual, float(MOST_STEPS)) if depth > DEEP * usual else 1.0


def steps_for_depth(depth: float, base_pitch: float) -> int:
    """Steps until the greatest wear depth of either body [mm] is `depth`, on teeth of a base pitch [mm]."""
    return min(max(ceil(depth / depth_of_step(base_pitch)), LEAST_STEPS), MOST_STEPS)


def life_steps_for_depth(depth: float, base_pitch: float) -> int:
    """Two-stage steps of a life until the greatest wear depth [mm] is `depth`, on teeth of a base pitch [mm]."""
    return max(steps_for_depth(depth, base_pitch), _LEAST_LIFE_STEPS)


def steps_of_life(depth_limit: float, base_pitch: float) -> int:
    """Approximate number of two-stage steps for a life until a depth [mm] and two more lives at other torques."""
    return 3 * life_steps_for_depth(depth_limit, base_pitch) + SEARCH_STEPS
