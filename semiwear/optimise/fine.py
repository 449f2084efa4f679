"""A search whose best designs are solved at twice the resolution, until no better one is expected there.

The error of the coarse grid is interpolated between the designs solved on the fine grid, and the search continues
with values corrected by it (Alexandrov and Lewis 2001, Optimization and Engineering 2, 413-430). Every second time,
and where this finds nothing better, a distant design is solved on the fine grid: one that is better if its error
differs by as much as the known errors do. A design that cannot be solved on the fine grid counts as failed from then
on, and so do its neighbours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from semiwear.optimise.correction import Correction
from semiwear.optimise.designs import COARSE, DOUBLED, OWN, Design, Designs, size_of
from semiwear.optimise.search import Goal, ranks_of, search, values_of

_MOST_FINE = 16  # designs solved on the fine grid, at most
_MARGIN = 0.002  # of a limit, for each design that broke one; the corrected search stays within limits less this
_LEAST_GAIN = 0.002  # of the aim, below which another fine solution is not worth its time
_LEAST_DISTANCE = 0.05  # of a range, between designs that are solved on the fine grid to explore


@dataclass(frozen=True)
class Found:
    """Result of a search.

    Attributes
    ----------
    own, doubled : Design
        The best design at the resolution of the scene, and at twice that; either may have failed.
    kept : bool
        Whether all limits are kept at twice the resolution.
    """

    own: Design
    doubled: Design
    kept: bool


@dataclass(frozen=True)
class _Fine:
    """A design solved on the grid of the search and at twice the resolution of the scene."""

    coarse: Design
    doubled: Design

    @property
    def solved(self) -> bool:
        return self.coarse.solved and self.doubled.solved


def search_finely(designs: Designs, goal: Goal, most: int) -> Found:
    """Best design after `most` further ones on a coarse grid, and a quarter as many for each one on the fine grid.

    Of the designs on the fine grid it is the one with the least aim among those that keep all limits, or, if none
    does, the one with the least violation.
    """
    tried = [_finely(designs, search(designs, goal, most))]
    while len(tried) < _MOST_FINE:
        known = [pair for pair in tried if pair.solved]
        design = _next(designs, goal, known, most // 4) if known else _far_from_failures(designs, goal, tried)
        if design is None or any(np.array_equal(design.point, pair.coarse.point) for pair in tried):
            break
        tried.append(_finely(designs, design))
    best = _best(designs, goal, [pair for pair in tried if pair.solved] or tried)
    (own,) = designs.solved([best.coarse.point], OWN)
    return Found(own, best.doubled, designs.violation(best.doubled, goal.bounds) <= 0.0)


def _next(designs: Designs, goal: Goal, known: Sequence[_Fine], most: int) -> Design | None:
    """Next design for the fine grid: one expected to be better than the known ones, else one that may be."""
    corrected = _corrected(designs, goal, known)
    (least,) = ranks_of(values_of(designs, goal, [_best(designs, goal, known).doubled]))
    design = search(designs, corrected, most)
    # where no design keeps the limits any that comes nearer to them is better: without the margin
    judged = replace(corrected, bounds=goal.bounds) if least[0] > 0.0 else corrected
    (rank,) = ranks_of(values_of(designs, judged, [design]))
    coarse = [pair.coarse for pair in known]
    points = np.stack([known_design.point for known_design in coarse])
    expected_better = _is_better(rank, least) and not (points == design.point).all(axis=1).any()
    if expected_better and len(known) % 2:
        return design
    others = [other for other in designs.tried if other.resolution == COARSE and other.solved]
    others = [other for other in others if np.abs(points - other.point).max(axis=1).min() >= _LEAST_DISTANCE]
    before = values_of(designs, replace(corrected, correction=None), coarse)
    after = values_of(designs, corrected, coarse)
    errors = np.subtract(after, before, out=np.zeros_like(after), where=np.isfinite(after) & np.isfinite(before))
    if least[0] > 0.0:  # no design keeps the limits; elsewhere the coarse grid may have no error
        errors = np.vstack([errors, np.zeros_like(errors[:1])])
    optimistic = ranks_of(values_of(designs, judged, others) - 0.5 * np.ptp(errors, axis=0))
    if not optimistic or not _is_better(min(optimistic), least):
        return design if expected_better else None
    return others[optimistic.index(min(optimistic))]


def _far_from_failures(designs: Designs, goal: Goal, failed: Sequence[_Fine]) -> Design | None:
    """Best design on the coarse grid at a distance from those that failed on the fine one; None if there is none.

    The distance is doubled with every failure.
    """
    others = [design for design in designs.tried if design.resolution == COARSE and design.solved]
    points = np.stack([pair.coarse.point for pair in failed])
    distances = np.array([np.abs(points - design.point).max(axis=1).min() for design in others])
    least = min(_LEAST_DISTANCE * 2.0 ** (len(failed) - 1), 0.5 * distances.max(initial=0.0))
    others = [design for design, distance in zip(others, distances, strict=True) if distance >= least > 0.0]
    ranks = ranks_of(values_of(designs, goal, others))
    return others[ranks.index(min(ranks))] if ranks else None


def _finely(designs: Designs, design: Design) -> _Fine:
    return _Fine(design, designs.solved([design.point], DOUBLED)[0])


def _corrected(designs: Designs, goal: Goal, known: Sequence[_Fine]) -> Goal:
    """The goal with coarse values corrected to the fine grid, and with a margin on its limits."""
    fine, coarse = (
        np.stack([design.values for design in on_grid])
        for on_grid in ([pair.doubled for pair in known], [pair.coarse for pair in known])
    )
    finite = np.isfinite(fine) & np.isfinite(coarse)
    errors = np.subtract(fine, coarse, out=np.zeros_like(fine), where=finite)  # none for a life without end
    points = np.stack([pair.coarse.point for pair in known])
    inwards = np.array([-size_of(limit) if limit.at_most else size_of(limit) for limit in designs.limits])
    margin = _MARGIN * sum(designs.violation(pair.doubled, goal.bounds) > 0.0 for pair in known)
    correction = Correction(designs.space, points, errors)
    return replace(goal, bounds=goal.bounds + margin * inwards, correction=correction)


def _best(designs: Designs, goal: Goal, tried: Sequence[_Fine]) -> _Fine:
    ranks = ranks_of(values_of(designs, goal, [pair.doubled for pair in tried]))
    return tried[min(range(len(tried)), key=ranks.__getitem__)]


def _is_better(rank: tuple[float, float], other: tuple[float, float]) -> bool:
    """Whether the violation is less, or is the same with an aim so much better that a fine solution is worth it."""
    return rank[0] < other[0] or (rank[0] == other[0] and other[1] - rank[1] > _LEAST_GAIN * abs(other[1]))
