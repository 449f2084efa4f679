"""A search whose best designs are solved on finer grids, until the best that is expected there is one of them.

What a coarse grid gets wrong of aim and limits is told by the designs that were solved finely, more by the nearer
ones, and the search goes on with it (Alexandrov and Lewis 2001, Optimization and Engineering 2, 413-430).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from semiwear.optimise.correction import Correction
from semiwear.optimise.designs import DOUBLED, OWN, Design, Designs, size_of
from semiwear.optimise.search import Goal, search, values_of

__all__ = ["Found", "search_finely"]


_TURNS = 8  # designs that are solved finely, at most
_MARGIN = 0.002  # of a limit, for each design that did not keep one: a corrected search stays within it
_WORTH = 0.002  # of the aim: less than this is not worth another fine solution


@dataclass(frozen=True)
class Found:
    """A design that was solved on fine grids.

    Attributes
    ----------
    coarse, own, doubled : Design
        On the grid of the search, at the resolution of the scene, and at twice that.
    kept : bool
        Whether all limits are kept at twice the resolution.
    """

    coarse: Design
    own: Design
    doubled: Design
    kept: bool

    @property
    def solved(self) -> bool:
        """Whether every number is known on all three."""
        return self.coarse.solved and self.own.solved and self.doubled.solved

    @property
    def told(self) -> Design:
        """Aims at the resolution of the scene, limited quantities at twice that."""
        return replace(self.doubled, aims=self.own.aims)


def search_finely(designs: Designs, goal: Goal, most: int) -> Found:
    """The best design after `most` further ones on a coarse grid, and a quarter as many for each solved finely.

    The best is the one of those solved finely that keeps all limits and whose aim is least, else the least beyond.
    """
    found = [_finely(designs, goal, search(designs, goal, most))]
    while len(found) < _TURNS:
        known = [one for one in found if one.solved]
        if not known:
            break
        corrected = _corrected(designs, goal, known)
        design = search(designs, corrected, most // 4)
        if any(np.array_equal(design.place, one.own.place) for one in found):
            break
        best = _best(designs, goal, known)
        if best.kept:
            now, then = values_of(designs, corrected, [best.coarse, design])[:, 0]
            if now - then <= _WORTH * abs(now):
                break
        found.append(_finely(designs, goal, design))
    return _best(designs, goal, [one for one in found if one.solved] or found)


def _finely(designs: Designs, goal: Goal, design: Design) -> Found:
    own, doubled = (designs.solved([design.place], resolution)[0] for resolution in (OWN, DOUBLED))
    return Found(design, own, doubled, designs.violation(doubled, goal.bounds) <= 0.0)


def _corrected(designs: Designs, goal: Goal, known: Sequence[Found]) -> Goal:
    """The goal with what fine grids say, within a margin of its limits."""
    wrong = [
        np.concatenate([one.told.aims - one.coarse.aims, one.told.limited - one.coarse.limited]) for one in known
    ]
    places = np.stack([one.coarse.place for one in known])
    inwards = np.array([-size_of(limit) if limit.at_most else size_of(limit) for limit in designs.limits])
    margin = _MARGIN * sum(not one.kept for one in known)
    correction = Correction(designs.space, places, np.stack(wrong))
    return replace(goal, bounds=goal.bounds + margin * inwards, correction=correction)


def _best(designs: Designs, goal: Goal, found: Sequence[Found]) -> Found:
    values = values_of(designs, goal, [one.told for one in found])
    order = np.lexsort((values[:, 0], values[:, 1:].max(axis=1, initial=0.0)))
    return found[int(order[0])]
