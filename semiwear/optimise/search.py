"""Search for the best design: a scan of the space, then designs that a surrogate of all known ones calls for.

The scan is a scrambled Sobol' sequence at a coarse resolution. Each further design is the best that the surrogate
sees in a region about the best known one, which grows and shrinks with success (a trust region). Of four designs one
is the best far from all that are known, so that a second valley is not missed (Regis and Shoemaker 2007, INFORMS J.
Comput. 19, 497-509), and one the best on folds through the designs around (`fold`). Where the region has closed, the
search begins anew about the best design elsewhere. Limits have a margin that grows as long as designs which should
keep them do not (Regis 2014, Eng. Optim. 46, 218-243).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.distance import cdist
from scipy.stats import qmc

from semiwear.arrays import BoolArray, FloatArray
from semiwear.optimise.correction import Correction
from semiwear.optimise.designs import COARSE, DOUBLED, Design, Designs, size_of
from semiwear.optimise.space import Space
from semiwear.optimise.surrogate import Surrogate, inputs_of

_SEED = 20011
_FIRST_RADIUS, _LAST_RADIUS = 0.25, 0.002  # of the ranges
_ELSEWHERE = 0.15  # of a range: another valley than the one about a design in which a search has ended
_EVERY, _FOLD_TURN, _FAR_TURN = 4, 1, 3  # of four designs one is that of a fold, one is far from what is known
_CANDIDATES = 512
_ZOOMS, _ZOOM = 4, 0.3  # times that candidates are drawn anew about the best of them, and how much closer
_APART = 0.1  # of the region: least distance to what is known
_FAR = 0.5  # of the greatest distance to what is known that a design can have
_FIRST_MARGIN, _MOST_MARGIN = 0.002, 0.03  # of a limit


@dataclass(frozen=True)
class Goal:
    """One search: which aim counts, under which bounds, and by how much coarse values are corrected.

    Attributes
    ----------
    aim : int
    bounds : (limits,) array
    other : float or None
        Bound on the other one of two aims, as the first is minimised.
    correction : Correction or None
        What is added to aims and limited quantities of a coarse grid.
    """

    aim: int
    bounds: FloatArray
    other: float | None = None
    correction: Correction | None = None


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
        place = _next(designs, goal, known.place, region, step)
        if place is None or region.radius < _LAST_RADIUS:
            ends.append(known.place)
            region = _Region(_FIRST_RADIUS, region.margin)
            continue
        (tried,) = designs.solved([place], COARSE)
        rank, before = ranks_of(values_of(designs, goal, [tried, known]))
        better = rank < before and _elsewhere(tried, ends)
        region = region.after(better=better, far=step % _EVERY == _FAR_TURN, broken=rank[0] > 0.0)
    found = best(designs, goal)
    assert found is not None  # the scan has tried some
    return found


def _next(designs: Designs, goal: Goal, centre: FloatArray, region: _Region, step: int) -> FloatArray | None:
    """The best new design that a surrogate sees, about `centre` or far from all that are known; None without one."""
    tried = [design for design in designs.tried if design.resolution == COARSE]
    fails = [not one.solved or doubt for one, doubt in zip(tried, _may_fail_finely(designs, tried), strict=True)]
    solved = [design for design, fail in zip(tried, fails, strict=True) if not fail]
    failed = [design.place for design, fail in zip(tried, fails, strict=True) if fail]
    if not solved:
        return None
    surrogate = Surrogate(
        designs.space,
        np.stack([design.place for design in solved]),
        finite_of(values_of(designs, goal, solved)),
        np.reshape(failed, (-1, len(designs.space.fields))),
    )
    if step % _EVERY == _FAR_TURN:
        places = qmc.Sobol(len(centre), scramble=True, seed=_SEED + step).random(_CANDIDATES)
        away = surrogate.distance(places)
        return _best_of(surrogate, places[away >= _FAR * away.max()], region.margin)
    if step % _EVERY == _FOLD_TURN:
        surrogate = surrogate.folded(centre)
    radius, found = region.radius, centre
    for _ in range(_ZOOMS):
        places = _about(designs.space, found, radius, choices=radius == region.radius)
        apart = surrogate.distance(places) >= _APART * region.radius
        seen = _best_of(surrogate, places[apart], region.margin)
        if seen is None:
            break
        found, radius = seen, _ZOOM * radius
    return None if found is centre else found


def finite_of(values: FloatArray) -> FloatArray:
    """Values for a surrogate (n, values): of a life without end one beyond all others by as much as these spread."""
    found = values.copy()
    for column in found.T:
        known = column[np.isfinite(column)]
        low, high = (known.min(), known.max()) if known.size else (0.0, 0.0)
        spread = high - low or abs(high) or 1.0
        np.clip(column, low - spread, high + spread, out=column)
    return found


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

    Of those that lie elsewhere than about some places; None where there is none. Those next to one that could not
    be solved at twice the resolution come last.
    """
    tried = [design for design in designs.tried if design.resolution == COARSE and _elsewhere(design, ends)]
    values = values_of(designs, goal, tried)
    values[_may_fail_finely(designs, tried)] = np.inf
    ranks = ranks_of(values)
    return tried[ranks.index(min(ranks))] if ranks else None


def _may_fail_finely(designs: Designs, tried: Sequence[Design]) -> BoolArray:
    """Whether, of the designs at twice the resolution, the one next to each could not be solved."""
    fine = [design for design in designs.tried if design.resolution == DOUBLED]
    failed = [design.place for design in fine if not design.solved]
    if not failed or not tried:
        return np.zeros(len(tried), dtype=bool)
    solved = [design.place for design in fine if design.solved]
    at = inputs_of(designs.space, np.stack([design.place for design in tried]))
    far = [cdist(at, inputs_of(designs.space, np.stack(one))).min(axis=1) for one in (failed, solved) if one]
    return np.asarray(far[0] < far[1] if solved else far[0] == 0.0)


def _elsewhere(design: Design, ends: Sequence[FloatArray]) -> bool:
    return all(np.abs(design.place - end).max() >= _ELSEWHERE for end in ends)


def ranks_of(values: FloatArray) -> list[tuple[float, float]]:
    """Of designs with values (n, 1 + limits) the violation of the limits, then the aim: lower is better."""
    return list(zip(values[:, 1:].max(axis=1, initial=0.0).tolist(), values[:, 0].tolist(), strict=True))


def values_of(designs: Designs, goal: Goal, tried: Sequence[Design]) -> FloatArray:
    """Of each design the aim, lower is better, and the excess over every limit over its size, (n, 1 + limits).

    Corrected as the goal says; infinite where a design could not be solved. A life without end is -inf where it is to
    be great.
    """
    aims, limited = (
        np.array([getattr(one, name) for one in tried]).reshape(len(tried), len(told))
        for name, told in (("aims", designs.aims), ("limited", designs.limits))
    )
    if goal.correction is not None and len(tried):
        wrong = goal.correction.at(np.stack([one.place for one in tried]))
        aims, limited = aims + wrong[:, : len(designs.aims)], limited + wrong[:, len(designs.aims) :]
    signs = np.array([1.0 if one.minimise else -1.0 for one in designs.aims])
    senses = np.array([1.0 if limit.at_most else -1.0 for limit in designs.limits])
    sizes = np.array([size_of(limit) for limit in designs.limits])
    columns = [(signs * aims)[:, goal.aim, None], senses * (limited - goal.bounds) / sizes]
    if goal.other is not None:
        columns.append(((signs * aims)[:, 1 - goal.aim, None] - goal.other) / (abs(goal.other) or 1.0))
    found = np.hstack(columns)
    return np.where(np.isnan(found).any(axis=1, keepdims=True), np.inf, found)
