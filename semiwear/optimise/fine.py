"""A search whose best designs are solved at twice the resolution, until what is likely to be better there is none.

Errors of the coarse grid are told by the designs that were solved finely, more by the nearer ones, and the search
goes on with them (Alexandrov and Lewis 2001, Optimization and Engineering 2, 413-430). Every second time, and where
it finds nothing better, a design elsewhere is solved finely that may be, if errors differ there by as much as they do
among these. One that cannot be solved finely counts as failed from then on, and so do those next to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from semiwear.optimise.correction import Correction
from semiwear.optimise.designs import COARSE, DOUBLED, OWN, Design, Designs, size_of
from semiwear.optimise.search import Goal, ranks_of, search, values_of

_TURNS = 16  # designs that are solved finely, at most
_MARGIN = 0.002  # of a limit, for each design that did not keep one: a corrected search stays within it
_WORTH = 0.002  # of the aim: less than this is not worth another fine solution
_ELSEWHERE = 0.05  # of a range: not beside designs that were solved finely


@dataclass(frozen=True)
class Found:
    """End of a search.

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
    """A design that was solved on the grid of the search and at twice the resolution of the scene."""

    coarse: Design
    doubled: Design

    @property
    def solved(self) -> bool:
        return self.coarse.solved and self.doubled.solved


def search_finely(designs: Designs, goal: Goal, most: int) -> Found:
    """The best design after `most` further ones on a coarse grid, and a quarter as many for each solved finely.

    The best is the one of those solved finely that keeps all limits and whose aim is least, else the least beyond.
    """
    found = [_finely(designs, search(designs, goal, most))]
    while len(found) < _TURNS:
        known = [one for one in found if one.solved]
        design = _next(designs, goal, known, most // 4) if known else _away(designs, goal, found)
        if design is None or any(np.array_equal(design.place, one.coarse.place) for one in found):
            break
        found.append(_finely(designs, design))
    best = _best(designs, goal, [one for one in found if one.solved] or found)
    (own,) = designs.solved([best.coarse.place], OWN)
    return Found(own, best.doubled, designs.violation(best.doubled, goal.bounds) <= 0.0)


def _next(designs: Designs, goal: Goal, known: Sequence[_Fine], most: int) -> Design | None:
    """The design to be solved finely next: one that is likely to be better than these, else one that may be."""
    corrected = _corrected(designs, goal, known)
    (least,) = ranks_of(values_of(designs, goal, [_best(designs, goal, known).doubled]))
    design = search(designs, corrected, most)
    (rank,) = ranks_of(values_of(designs, corrected, [design]))
    at = [one.coarse for one in known]
    places = np.stack([one.place for one in at])
    likely = _is_better(rank, least) and not (places == design.place).all(axis=1).any()
    if likely and len(known) % 2:
        return design
    others = [one for one in designs.tried if one.resolution == COARSE and one.solved]
    others = [one for one in others if np.abs(places - one.place).max(axis=1).min() >= _ELSEWHERE]
    before = values_of(designs, replace(corrected, correction=None), at)
    after = values_of(designs, corrected, at)
    errors = np.subtract(after, before, out=np.zeros_like(after), where=np.isfinite(after) & np.isfinite(before))
    if least[0] > 0.0:  # none keeps the limits: the coarse grid may be right elsewhere
        errors = np.vstack([errors, np.zeros_like(errors[:1])])
    hoped = ranks_of(values_of(designs, corrected, others) - 0.5 * np.ptp(errors, axis=0))
    if not hoped or not _is_better(min(hoped), least):
        return design if likely else None
    return others[hoped.index(min(hoped))]


def _away(designs: Designs, goal: Goal, failed: Sequence[_Fine]) -> Design | None:
    """The best design on the coarse grid ever farther from those that could not be solved; None without one."""
    others = [one for one in designs.tried if one.resolution == COARSE and one.solved]
    places = np.stack([one.coarse.place for one in failed])
    away = np.array([np.abs(places - one.place).max(axis=1).min() for one in others])
    least = min(_ELSEWHERE * 2.0 ** (len(failed) - 1), 0.5 * away.max(initial=0.0))
    others = [one for one, far in zip(others, away, strict=True) if far >= least > 0.0]
    ranks = ranks_of(values_of(designs, goal, others))
    return others[ranks.index(min(ranks))] if ranks else None


def _finely(designs: Designs, design: Design) -> _Fine:
    return _Fine(design, designs.solved([design.place], DOUBLED)[0])


def _corrected(designs: Designs, goal: Goal, known: Sequence[_Fine]) -> Goal:
    """The goal with what fine grids say, within a margin of its limits."""
    fine, coarse = (
        np.stack([np.concatenate([one.aims, one.limited]) for one in told])
        for told in ([one.doubled for one in known], [one.coarse for one in known])
    )
    whole = np.isfinite(fine) & np.isfinite(coarse)
    wrong = np.subtract(fine, coarse, out=np.zeros_like(fine), where=whole)  # of a life without end nothing is wrong
    places = np.stack([one.coarse.place for one in known])
    inwards = np.array([-size_of(limit) if limit.at_most else size_of(limit) for limit in designs.limits])
    margin = _MARGIN * sum(designs.violation(one.doubled, goal.bounds) > 0.0 for one in known)
    correction = Correction(designs.space, places, wrong)
    return replace(goal, bounds=goal.bounds + margin * inwards, correction=correction)


def _best(designs: Designs, goal: Goal, found: Sequence[_Fine]) -> _Fine:
    ranked = ranks_of(values_of(designs, goal, [one.doubled for one in found]))
    return found[min(range(len(found)), key=ranked.__getitem__)]


def _is_better(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """Whether a design comes nearer to the limits, or is as near and has an aim that is worth the solution."""
    return one[0] < other[0] or (one[0] == other[0] and other[1] - one[1] > _WORTH * abs(other[1]))
