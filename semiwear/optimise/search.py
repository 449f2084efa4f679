"""Search for the best design: a scan of the space, then designs that a surrogate of all known ones calls for.

The scan is a scrambled Sobol' sequence at a coarse resolution. Each further design is the best that the surrogate
sees in a region about the best known one, which grows and shrinks with success (a trust region); every fourth is the
best far from all that are known, so that a second valley is not missed (Regis and Shoemaker 2007, INFORMS J. Comput.
19, 497-509). Where the region has closed, the search begins anew about the best design elsewhere. Limits have a
margin that grows as long as designs which should keep them do not (Regis 2014, Eng. Optim. 46, 218-243). What a
coarse grid gets wrong is made good by the difference to a fine one at the design that was found, and the search goes
on with it (Alexandrov and Lewis 2001, Optimization and Engineering 2, 413-430).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import qmc

from semiwear.arrays import FloatArray
from semiwear.optimise.designs import COARSE, DOUBLED, OWN, Design, Designs, size_of
from semiwear.optimise.space import Space
from semiwear.optimise.surrogate import Surrogate

__all__ = ["Found", "Goal", "scan", "search", "settle"]


_SEED = 20011
_FIRST_RADIUS, _LAST_RADIUS = 0.25, 0.002  # of the ranges
_ELSEWHERE = 0.15  # of a range: another valley than the one about a design in which a search has ended
_EVERY = 4  # designs of which one is far from those that are known
_CANDIDATES = 512
_ZOOMS, _ZOOM = 4, 0.3  # times that candidates are drawn anew about the best of them, and how much closer
_APART = 0.1  # of the region: least distance to what is known
_FAR = 0.5  # of the greatest distance to what is known that a design can have
_FIRST_MARGIN, _MOST_MARGIN = 0.002, 0.03  # of a limit
_CORRECTIONS = 4
_MARGIN = 0.002  # of a limit, doubled each time: a corrected search stays within it, since corrections vary


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


@dataclass(frozen=True)
class _Region:
    """Where the next design is looked for.

    Attributes
    ----------
    radius : float
        About the best known design, of the ranges.
    margin : float
        Of the limits.
    """

    radius: float
    margin: float = 0.0

    def after(self, *, better: bool, far: bool, broken: bool) -> _Region:
        """The region after a design that was better or not, far from the region or in it, beyond a limit or not."""
        margin = min(max(2.0 * self.margin, _FIRST_MARGIN), _MOST_MARGIN) if broken else 0.5 * self.margin
        if far:
            return replace(self, radius=_FIRST_RADIUS) if better else self
        return _Region(min(1.5 * self.radius, _FIRST_RADIUS) if better else 0.5 * self.radius, margin)


def search(designs: Designs, goal: Goal, most: int) -> Design:
    """The best design on a coarse grid after `most` further ones.

    Where the region has closed about a design, the search begins anew about the best one that lies elsewhere.
    """
    region = _Region(_FIRST_RADIUS)
    ends: list[FloatArray] = []
    for step in range(most):
        known = best(designs, goal, ends)
        if known is None:
            break
        far = step % _EVERY == _EVERY - 1
        place = _next(designs, goal, known.place, region, step if far else None)
        if place is None or region.radius < _LAST_RADIUS:
            ends.append(known.place)
            region = _Region(_FIRST_RADIUS, region.margin)
            continue
        (tried,) = designs.solved([place], COARSE)
        rank = _rank(designs, goal, tried)
        better = rank < _rank(designs, goal, known) and _elsewhere(tried, ends)
        region = region.after(better=better, far=far, broken=rank[0] > 0.0)
    found = best(designs, goal)
    assert found is not None  # the scan has tried some
    return found


def _next(designs: Designs, goal: Goal, centre: FloatArray, region: _Region, far: int | None) -> FloatArray | None:
    """The best new design that a surrogate sees, about `centre` or far from all that are known; None without one."""
    tried = [design for design in designs.tried if design.resolution == COARSE]
    solved = [design for design in tried if design.solved]
    failed = [design.place for design in tried if not design.solved]
    surrogate = Surrogate(
        designs.space,
        np.stack([design.place for design in solved]),
        np.stack([_values(designs, goal, design) for design in solved]),
        np.reshape(failed, (-1, len(designs.space.fields))),
    )
    if far is not None:
        places = qmc.Sobol(len(centre), scramble=True, seed=_SEED + far).random(_CANDIDATES)
        away = surrogate.distance(places)
        return _best_of(surrogate, places[away >= _FAR * away.max()], region.margin)
    radius, found = region.radius, centre
    for _ in range(_ZOOMS):
        places = _about(designs.space, found, radius, choices=radius == region.radius)
        apart = surrogate.distance(places) >= _APART * region.radius
        seen = _best_of(surrogate, places[apart], region.margin)
        if seen is None:
            break
        found, radius = seen, _ZOOM * radius
    return None if found is centre else found


def _about(space: Space, centre: FloatArray, radius: float, *, choices: bool) -> FloatArray:
    """Designs about a centre (n, fields), the centre among them; with `choices` half of them make another one."""
    drawn = qmc.Sobol(len(centre), scramble=True, seed=_SEED).random(_CANDIDATES)
    free = space.continuous
    places = np.tile(centre, (_CANDIDATES, 1))
    places[1:, free] = np.clip(centre[free] + radius * (2.0 * drawn[1:, free] - 1.0), 0.0, 1.0)
    fixed = np.setdiff1d(np.arange(len(centre)), free)
    if choices and fixed.size:
        # runs of the sequence: every second one of it lies in the same half of a coordinate
        for column, rows in zip(fixed, np.array_split(np.arange(1, _CANDIDATES // 2), fixed.size), strict=True):
            places[rows, column] = drawn[rows, column]
    return np.stack([space.snapped(place) for place in places])


def _best_of(surrogate: Surrogate, places: FloatArray, margin: float) -> FloatArray | None:
    """The place whose limits are kept with a margin and whose aim is least, else the one that is least beyond."""
    places = places[~surrogate.may_fail(places)] if len(places) else places
    if not len(places):
        return None
    values = surrogate.at(places)
    beyond = np.maximum(values[:, 1:].max(axis=1, initial=-np.inf) + margin, 0.0)
    return np.asarray(places[np.lexsort((values[:, 0], beyond))[0]])


def best(designs: Designs, goal: Goal, ends: Sequence[FloatArray] = ()) -> Design | None:
    """The best design that is known on the coarse grid: the least violation where no one keeps the limits.

    Of those that lie elsewhere than about some places; None where there is none.
    """
    tried = [design for design in designs.tried if design.resolution == COARSE and _elsewhere(design, ends)]
    return min(tried, key=lambda design: _rank(designs, goal, design), default=None)


def _elsewhere(design: Design, ends: Sequence[FloatArray]) -> bool:
    return all(np.abs(design.place - end).max() >= _ELSEWHERE for end in ends)


def _rank(designs: Designs, goal: Goal, design: Design) -> tuple[float, float]:
    """Violation of the limits, then the aim: lower is better."""
    values = _values(designs, goal, design)
    return max([0.0, *values[1:].tolist()]), float(values[0])


def _values(designs: Designs, goal: Goal, design: Design) -> FloatArray:
    """The aim, lower is better, and the excess over every limit over its size; shifted as the goal says."""
    count = len(designs.limits) + (goal.other is not None)
    if not design.solved:
        return np.full(1 + count, np.inf)
    shift = np.zeros(design.aims.size + design.limited.size) if goal.shift is None else goal.shift
    aims, limited = design.aims + shift[: design.aims.size], design.limited + shift[design.aims.size :]
    found = [_signed(designs, goal.aim, aims)]
    for limit, value, bound in zip(designs.limits, limited, goal.bounds, strict=True):
        found.append((value - bound if limit.at_most else bound - value) / size_of(limit))
    if goal.other is not None:
        found.append((_signed(designs, 1 - goal.aim, aims) - goal.other) / (abs(goal.other) or 1.0))
    return np.array(found)


def _signed(designs: Designs, aim: int, values: FloatArray) -> float:
    return float(values[aim]) if designs.aims[aim].minimise else -float(values[aim])


def settle(designs: Designs, goal: Goal, design: Design, most: int) -> Found:
    """The design on finer grids; searched anew with what these correct until all limits are kept there."""
    tried: list[Design] = []
    for turn in range(_CORRECTIONS):
        doubled = designs.solved([design.place], DOUBLED)[0]
        tried.append(doubled)
        if not (doubled.solved and design.solved) or designs.violation(doubled, goal.bounds) <= 0.0:
            break
        shift = np.concatenate([doubled.aims - design.aims, doubled.limited - design.limited])
        inwards = [-size_of(limit) if limit.at_most else size_of(limit) for limit in designs.limits]
        corrected = Goal(goal.aim, goal.bounds + 2.0**turn * _MARGIN * np.array(inwards), goal.other, shift)
        again = search(designs, corrected, most)
        if np.array_equal(again.place, design.place):
            break
        design = again
    chosen = min(tried, key=lambda one: designs.violation(one, goal.bounds))
    return Found(designs.solved([chosen.place], OWN)[0], chosen, designs.violation(chosen, goal.bounds) <= 0.0)
