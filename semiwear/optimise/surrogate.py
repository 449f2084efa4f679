"""A surrogate of aim and limits: radial basis functions through all known designs.

Cubic functions with a linear tail (Regis and Shoemaker 2007, INFORMS J. Comput. 19, 497-509; scipy solves for their
weights). They interpolate every known value, need no derivatives and do not overshoot far where a quantity has a
kink. Choices that are numbers lie in their order between 0 and 1; of others each has an axis of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.spatial.distance import cdist

from semiwear.arrays import BoolArray, FloatArray
from semiwear.optimise.fold import Fold, fold_near
from semiwear.optimise.space import Space
from semiwear.scene.values import is_number
from semiwear.untyped import Value

_ROUNDING = 1e-9  # of the ranges: designs that differ by less are the same
_CHOICE_DISTANCE = 0.5  # of two choices that have no order, along each of their axes


@dataclass(frozen=True)
class Surrogate:
    """Values of designs, interpolated between known ones.

    Attributes
    ----------
    space : Space
    points : (known, fields) array
        Designs that were solved.
    values : (known, values) array
        Their values.
    failed : (other, fields) array
        Designs that could not be solved.
    folds : tuple of Fold or None
        For each value, a fold that replaces the radial basis functions.
    """

    space: Space
    points: FloatArray
    values: FloatArray
    failed: FloatArray
    folds: tuple[Fold | None, ...] = ()

    def at(self, points: FloatArray) -> FloatArray:
        """Values at points (n, fields): (n, values)."""
        inputs = inputs_of(self.space, points)
        values = np.asarray(self._functions(inputs))
        for k, fold in enumerate(self.folds):
            if fold is not None:
                values[:, k] = fold.at(inputs)
        return values

    def folded(self, centre: FloatArray) -> Surrogate:
        """The surrogate with folds fitted to the designs around a centre (fields,), if these are enough."""
        inputs = inputs_of(self.space, self.points)
        middle = inputs_of(self.space, centre[None, :])[0]
        return replace(self, folds=tuple(fold_near(middle, inputs, column) for column in self.values.T))

    def distance(self, points: FloatArray) -> FloatArray:
        """Chebyshev distance of points (n, fields) to the nearest known design (n,)."""
        every = np.vstack([self.points, self.failed])
        return np.asarray(cdist(inputs_of(self.space, points), inputs_of(self.space, every), "chebyshev").min(axis=1))

    def may_fail(self, points: FloatArray) -> BoolArray:
        """Whether the design nearest to a point could not be solved (n,)."""
        if not self.failed.size:
            return np.zeros(len(points), dtype=bool)
        inputs = inputs_of(self.space, points)
        return np.asarray(
            cdist(inputs, inputs_of(self.space, self.failed)).min(axis=1)
            < cdist(inputs, inputs_of(self.space, self.points)).min(axis=1)
        )

    @cached_property
    def _functions(self) -> RBFInterpolator:
        inputs = inputs_of(self.space, self.points)
        _, first = np.unique(np.round(inputs / _ROUNDING), axis=0, return_index=True)
        inputs, values = inputs[first], self.values[first]
        try:
            return RBFInterpolator(inputs, values, kernel="cubic", degree=1)
        except (ValueError, np.linalg.LinAlgError):  # too few designs for a linear tail, or all in one plane
            return RBFInterpolator(inputs, values, kernel="linear", degree=0)


def inputs_of(space: Space, points: FloatArray) -> FloatArray:
    """Inputs of the surrogate for designs (n, fields), with an axis for each unordered choice: (n, inputs)."""
    columns: list[FloatArray] = []
    for k, field in enumerate(space.fields):
        if field.continuous or _in_order(field.values):
            columns.append(points[:, k])
        else:
            chosen = field.index(points[:, k])
            columns += [_CHOICE_DISTANCE * (chosen == index) for index in range(len(field.values))]
    return np.stack(columns, axis=1).astype(float)


def _in_order(values: Sequence[Value]) -> bool:
    return all(is_number(value) for value in values) and list(values) == sorted(values)
