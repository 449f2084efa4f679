"""Search for the best design: a scan of the space, then a trust region about the best of it.

The scan is a scrambled Sobol' sequence; from its best designs on, COBYQA (Ragonneau 2022, Model-based derivative-free
optimization methods and software, PhD thesis), which models aim and limits by quadratics within a trust region, goes
on at a coarse resolution. What a coarse grid gets wrong is made good by the difference to a fine one at the design
that was found, and the search goes on from there (Alexandrov and Lewis 2001, Optimization and Engineering 2,
413-430).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, NonlinearConstraint, minimize
from scipy.stats import qmc

from semiwear.optimise.designs import COARSE, DOUBLED, OWN, Design, Designs, size_of

__all__ = ["Found", "Goal", "scan", "search", "settle"]

FloatArray = NDArray[np.float64]

_SEED = 20011
_STARTS = 2
_APART = 0.2  # of the space: starts nearer to each other find the same
_FIRST_RADIUS, _NEXT_RADIUS, _LAST_RADIUS = 0.15, 0.05, 0.004  # of the ranges
_KEPT = 1e-3  # of a limit: kept
_CORRECTIONS = 4
_MARGIN = 0.01  # of a limit, that a corrected search stays within it: the correction itself varies
_FAR = 10.0  # merit of a design that failed


@dataclass(frozen=True)
class Goal:
    """One search: which aim counts, under which bounds, and by how much coarse values are corrected.

    Attributes
    ----------
    aim : int
    bounds : (limits,) array
    other : float or None
        Bound on the other one of two aims, as the first is minimised.
    shift : (aims + limits,) array
        What is added to values of a coarse grid.
    """

    aim: int
    bounds: FloatArray
    other: float | None = None
    shift: FloatArray | None = None


@dataclass(frozen=True)
class Found:
    """End of a search.

    Attributes
    ----------
    own, doubled : Design
        The best design at the resolution of the scene, and at twice that.
    kept : bool
        Whether all limits are kept at twice the resolution.
    """

    own: Design
    doubled: Design
    kept: bool


def scan(designs: Designs, count: int) -> list[Design]:
    """Designs all over the space, the scene itself among them."""
    fields = len(designs.space.fields)
    sequence = qmc.Sobol(fields, scramble=True, seed=_SEED)
    places = [designs.space.start(designs.scene), *sequence.random_base2(max(int(np.ceil(np.log2(count))), 0))]
    return designs.solved(places, COARSE)


def search(designs: Designs, goal: Goal, most: int, starts: list[FloatArray] | None = None) -> Design:
    """The best design on a coarse grid, from `starts` or from the best that are known; `most` to be tried."""
    radius = _NEXT_RADIUS if starts else _FIRST_RADIUS
    begin = starts or _starts(designs, goal)
    if designs.space.continuous.size:
        for start in begin:
            _descend(designs, goal, start, radius, max(most // len(begin), 4))
    return best(designs, goal)


def best(designs: Designs, goal: Goal) -> Design:
    """The best design that is known on the coarse grid: the least violation where no one keeps the limits."""
    tried = [design for design in designs.tried if design.resolution == COARSE]
    return min(tried, key=lambda design: _rank(designs, goal, design))


def _rank(designs: Designs, goal: Goal, design: Design) -> tuple[float, float]:
    """Violation of the limits, then the aim: lower is better."""
    values = _values(designs, goal, design)
    violation = max([0.0, *values[1:]])
    return (violation if violation > _KEPT else 0.0), values[0]


def _values(designs: Designs, goal: Goal, design: Design) -> FloatArray:
    """The aim, lower is better, and the excess over every limit over its size; shifted as the goal says."""
    count = len(designs.limits) + (goal.other is not None)
    if not design.solved:
        return np.full(1 + count, _FAR)
    shift = np.zeros(design.aims.size + design.limited.size) if goal.shift is None else goal.shift
    aims, limited = design.aims + shift[: design.aims.size], design.limited + shift[design.aims.size :]
    found = [_signed(designs, goal.aim, aims) / _scale(designs, goal.aim)]
    for limit, value, bound in zip(designs.limits, limited, goal.bounds, strict=True):
        found.append((value - bound if limit.at_most else bound - value) / size_of(limit))
    if goal.other is not None:
        other = 1 - goal.aim
        found.append((_signed(designs, other, aims) - goal.other) / _scale(designs, other))
    return np.array(found)


def _signed(designs: Designs, aim: int, values: FloatArray) -> float:
    return float(values[aim]) if designs.aims[aim].minimise else -float(values[aim])


def _scale(designs: Designs, aim: int) -> float:
    """Size of an aim: its first value on the coarse grid."""
    first = next((abs(d.aims[aim]) for d in designs.tried if d.resolution == COARSE and d.solved), 1.0)
    return float(first) or 1.0


def _starts(designs: Designs, goal: Goal) -> list[FloatArray]:
    """The best known designs that lie apart or make another choice."""
    tried = [design for design in designs.tried if design.resolution == COARSE and design.solved]
    chosen: list[FloatArray] = []
    for design in sorted(tried, key=lambda one: _rank(designs, goal, one)):
        part = designs.space.discrete_part(design.place)
        apart = all(
            part != designs.space.discrete_part(other) or np.abs(design.place - other).max() > _APART
            for other in chosen
        )
        if apart:
            chosen.append(design.place)
        if len(chosen) == _STARTS:
            break
    return chosen


def _descend(designs: Designs, goal: Goal, start: FloatArray, radius: float, most: int) -> None:
    """Go on from a start by COBYQA; what is found is among the designs that were tried."""
    free = designs.space.continuous

    def values(point: FloatArray) -> FloatArray:
        place = start.copy()
        place[free] = np.clip(point, 0.0, 1.0)
        return _values(designs, goal, designs.solved([place], COARSE)[0])

    count = len(designs.limits) + (goal.other is not None)
    limits = [NonlinearConstraint(lambda point: values(point)[1:], -np.inf, np.zeros(count))] if count else []
    minimize(
        lambda point: values(point)[0],
        start[free],
        method="COBYQA",
        bounds=Bounds(np.zeros(free.size), np.ones(free.size)),
        constraints=limits,
        options={"maxfev": most, "initial_tr_radius": radius, "final_tr_radius": _LAST_RADIUS},
    )


def settle(designs: Designs, goal: Goal, design: Design, most: int) -> Found:
    """The design on finer grids; searched anew with what these correct until all limits are kept there."""
    tried: list[Design] = []
    for _ in range(_CORRECTIONS):
        doubled = designs.solved([design.place], DOUBLED)[0]
        tried.append(doubled)
        if not (doubled.solved and design.solved) or designs.violation(doubled, goal.bounds) <= _KEPT:
            break
        shift = np.concatenate([doubled.aims - design.aims, doubled.limited - design.limited])
        inwards = [-size_of(limit) if limit.at_most else size_of(limit) for limit in designs.limits]
        corrected = Goal(goal.aim, goal.bounds + _MARGIN * np.array(inwards), goal.other, shift)
        again = search(designs, corrected, most, [design.place])
        if np.array_equal(again.place, design.place):
            break
        design = again
    kept = [one for one in tried if designs.violation(one, goal.bounds) <= _KEPT]
    if kept:
        chosen = min(kept, key=lambda one: _signed(designs, goal.aim, one.aims))
    else:
        chosen = min(tried, key=lambda one: designs.violation(one, goal.bounds))
    return Found(designs.solved([chosen.place], OWN)[0], chosen, bool(kept))
