"""Search for the best design: a scan of the space, then designs chosen by a surrogate of all known ones.

The scan is a scrambled Sobol' sequence at a coarse resolution. Each further design is the optimum of the surrogate in
a trust region about the best known design, which grows and shrinks with success. Of every four designs one is the
optimum far from all known designs, so that a second minimum is not missed (Regis and Shoemaker 2007, INFORMS J.
Comput. 19, 497-509), and one the optimum of folds through the designs around (`fold`). When the region has become too
small, the search begins anew about the best design elsewhere. Limits have a margin that grows while designs which
should keep them do not (Regis 2014, Eng. Optim. 46, 218-243).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.spatial.distance import cdist
from scipy.stats import qmc

from semiwear.arrays import BoolArray, FloatArray
from semiwear.optimise.correction import Correction
from semiwear.optimise.designs import COARSE, DOUBLED, Design, Designs
from semiwear.optimise.space import Space
from semiwear.optimise.surrogate import Surrogate, inputs_of

_SEED = 20011
_FIRST_RADIUS, _LAST_RADIUS = 0.25, 0.002  # of the ranges
_ELSEWHERE = 0.15  # of a range: least distance of another minimum from a design at which a search has ended
_EVERY, _FOLD_TURN, _FAR_TURN = 4, 1, 3  # of four designs one is from folds, one is far from known designs
_CANDIDATES = 512
_ZOOMS, _ZOOM = 4, 0.3  # times that candidates are drawn anew about the best of them, and factor on the radius
_APART = 0.1  # of the region's radius: least distance to known designs
_FAR = 0.5  # of the greatest distance to known designs among the candidates
_FIRST_MARGIN, _MOST_MARGIN = 0.002, 0.03  # of a limit


@dataclass(frozen=True)
class Goal:
    """Goal of one search: its aim, the bounds, and the correction of coarse values.

    Attributes
    ----------
    aim : int
    bounds : (limits,) array
    other : float or None
        Bound on the other of two aims, with the sign by which it is minimised.
    correction : Correction or None
        Added to aims and limited quantities of the coarse grid.
    """

    aim: int
    bounds: FloatArray
    other: float | None = None
    correction: Correction | None = None


def scan(designs: Designs, count: int) -> list[Design]:
    """Designs spread over the space; the first is the scene itself."""
    fields = len(designs.space.fields)
    sequence = qmc.Sobol(fields, scramble=True, seed=_SEED)
    points = [designs.space.start(designs.scene), *sequence.random_base2(max(int(np.ceil(np.log2(count))), 0))]
    return designs.solved(points, COARSE)


@dataclass(frozen=True)
class _Region:
    """Trust region for the next design.

    Attributes
    ----------
    radius : float
        Half-width about the best known design, as a fraction of the ranges.
    margin : float
        Margin on the limits, as a fraction of their size.
    """

    radius: float
    margin: float = 0.0

    def after(self, *, better: bool, far: bool, broken: bool) -> _Region:
        """Region after a design: whether it was better, outside the region (far), and whether it broke a limit."""
        margin = min(max(2.0 * self.margin, _FIRST_MARGIN), _MOST_MARGIN) if broken else 0.5 * self.margin
        if far:
            return replace(self, radius=_FIRST_RADIUS) if better else self
        return _Region(min(1.5 * self.radius, _FIRST_RADIUS) if better else 0.5 * self.radius, margin)


def search(designs: Designs, goal: Goal, most: int) -> Design:
    """Best design on the coarse grid after `most` further ones.

    When the region about a design has become too small, the search begins anew about the best design elsewhere.
    """
    region = _Region(_FIRST_RADIUS)
    ends: list[FloatArray] = []
    for step in range(most):
        known = best(designs, goal, ends)
        if known is None:
            break
        point = _next(designs, goal, known.point, region, step)
        if point is None or region.radius < _LAST_RADIUS:
            ends.append(known.point)
            region = _Region(_FIRST_RADIUS, region.margin)
            continue
        (tried,) = designs.solved([point], COARSE)
        rank, before = ranks_of(values_of(designs, goal, [tried, known]))
        better = rank < before and _elsewhere(tried, ends)
        region = region.after(better=better, far=step % _EVERY == _FAR_TURN, broken=rank[0] > 0.0)
    result = best(designs, goal)
    assert result is not None  # the scan has tried some
    return result


def _next(designs: Designs, goal: Goal, centre: FloatArray, region: _Region, step: int) -> FloatArray | None:
    """Optimum of the surrogate about `centre`, or far from all known designs; None if there is no new design."""
    tried = [design for design in designs.tried if design.resolution == COARSE]
    fails = _may_fail_finely(designs, tried) | np.array([not design.solved for design in tried], dtype=bool)
    solved = [design for design, fail in zip(tried, fails, strict=True) if not fail]
    failed = [design.point for design, fail in zip(tried, fails, strict=True) if fail]
    if not solved:
        return None
    surrogate = Surrogate(
        designs.space,
        np.stack([design.point for design in solved]),
        finite_of(values_of(designs, goal, solved)),
        np.reshape(failed, (-1, len(designs.space.fields))),
    )
    if step % _EVERY == _FAR_TURN:
        points = qmc.Sobol(len(centre), scramble=True, seed=_SEED + step).random(_CANDIDATES)
        distance = surrogate.distance(points)
        return _best_of(surrogate, points[distance >= _FAR * distance.max()], region.margin)
    if step % _EVERY == _FOLD_TURN:
        surrogate = surrogate.folded(centre)
    radius, optimum = region.radius, centre
    for _ in range(_ZOOMS):
        points = _about(designs.space, optimum, radius, choices=radius == region.radius)
        apart = surrogate.distance(points) >= _APART * region.radius
        better = _best_of(surrogate, points[apart], region.margin)
        if better is None:
            break
        optimum, radius = better, _ZOOM * radius
    return None if optimum is centre else optimum


def finite_of(values: FloatArray) -> FloatArray:
    """Values for a surrogate (n, values): an infinite one is replaced by one beyond all others, by their spread."""
    finite = values.copy()
    for column in finite.T:
        known = column[np.isfinite(column)]
        low, high = (known.min(), known.max()) if known.size else (0.0, 0.0)
        spread = high - low or abs(high) or 1.0
        np.clip(column, low - spread, high + spread, out=column)
    return finite


def _about(space: Space, centre: FloatArray, radius: float, *, choices: bool) -> FloatArray:
    """Designs about a centre (n, fields), the centre first; with `choices` half of them change one of its choices."""
    drawn = _drawn(len(centre))
    free = space.continuous
    points = np.tile(centre, (_CANDIDATES, 1))
    points[1:, free] = np.clip(centre[free] + radius * (2.0 * drawn[1:, free] - 1.0), 0.0, 1.0)
    fixed = np.setdiff1d(np.arange(len(centre)), free)
    if choices and fixed.size:
        # consecutive rows, since every second point of the sequence lies in the same half of a coordinate
        for column, rows in zip(fixed, np.array_split(np.arange(1, _CANDIDATES // 2), fixed.size), strict=True):
            points[rows, column] = drawn[rows, column]
    return space.snapped(points)


@lru_cache(maxsize=4)
def _drawn(fields: int) -> FloatArray:
    """Points of the unit cube that are drawn about every centre (n, fields)."""
    return np.asarray(qmc.Sobol(fields, scramble=True, seed=_SEED).random(_CANDIDATES))


def _best_of(surrogate: Surrogate, points: FloatArray, margin: float) -> FloatArray | None:
    """Point of least aim among those that keep the limits with a margin, else the one of least violation."""
    points = points[~surrogate.may_fail(points)] if len(points) else points
    if not len(points):
        return None
    values = surrogate.at(points)
    violation = np.maximum(values[:, 1:].max(axis=1, initial=-np.inf) + margin, 0.0)
    return np.asarray(points[np.lexsort((values[:, 0], violation))[0]])


def best(designs: Designs, goal: Goal, ends: Sequence[FloatArray] = ()) -> Design | None:
    """Best known design on the coarse grid, the one of least violation if none keeps the limits.

    Designs about `ends` are left out; None if no others are left. Those whose neighbour could not be solved at twice
    the resolution come last.
    """
    tried = [design for design in designs.tried if design.resolution == COARSE and _elsewhere(design, ends)]
    values = values_of(designs, goal, tried)
    values[_may_fail_finely(designs, tried)] = np.inf
    ranks = ranks_of(values)
    return tried[ranks.index(min(ranks))] if ranks else None


def _may_fail_finely(designs: Designs, tried: Sequence[Design]) -> BoolArray:
    """Whether the nearest design at twice the resolution could not be solved, for each coarse design (n,)."""
    fine = [design for design in designs.tried if design.resolution == DOUBLED]
    failed = [design.point for design in fine if not design.solved]
    if not failed or not tried:
        return np.zeros(len(tried), dtype=bool)
    solved = [design.point for design in fine if design.solved]
    inputs = inputs_of(designs.space, np.stack([design.point for design in tried]))
    to_failed, *to_solved = (
        cdist(inputs, inputs_of(designs.space, np.stack(others))).min(axis=1) for others in (failed, solved) if others
    )
    return np.asarray(to_failed < to_solved[0] if to_solved else to_failed == 0.0)


def _elsewhere(design: Design, ends: Sequence[FloatArray]) -> bool:
    return all(np.abs(design.point - end).max() >= _ELSEWHERE for end in ends)


def ranks_of(values: FloatArray) -> list[tuple[float, float]]:
    """Ranks of designs from values (n, 1 + limits): the violation of the limits, then the aim; lower is better."""
    return list(zip(values[:, 1:].max(axis=1, initial=0.0).tolist(), values[:, 0].tolist(), strict=True))


def values_of(designs: Designs, goal: Goal, tried: Sequence[Design]) -> FloatArray:
    """Aim of each design, lower is better, and its excess over every limit, relative to its size, (n, 1 + limits).

    The correction of the goal is applied. Values are infinite for a design that could not be solved; a life without
    end is -inf if it is maximised.
    """
    judged = np.array([design.values for design in tried]).reshape(len(tried), len(designs.quantities))
    if goal.correction is not None and len(tried):
        judged = judged + goal.correction.at(np.stack([design.point for design in tried]))
    aims, limited = designs.signs * judged[:, : len(designs.aims)], judged[:, len(designs.aims) :]
    columns = [aims[:, goal.aim, None], designs.excesses(limited, goal.bounds)]
    if goal.other is not None:
        columns.append((aims[:, 1 - goal.aim, None] - goal.other) / (abs(goal.other) or 1.0))
    values = np.hstack(columns)
    return np.where(np.isnan(values).any(axis=1, keepdims=True), np.inf, values)
