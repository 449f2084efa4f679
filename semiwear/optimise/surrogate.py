"""A surrogate of aim and limits: radial basis functions through all designs that are known.

Cubic functions with a linear tail (Regis and Shoemaker 2007, INFORMS J. Comput. 19, 497-509; scipy solves for their
weights). They go through every known value, need no derivatives and stay bounded by what they know where a quantity
has a kink. Choices that are numbers lie in their order between 0 and 1; others each have an axis of their own.
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

_SAME = 1e-9  # of the space: the same design
_UNLIKE = 0.5  # distance of two choices that have no order, along each of their axes


@dataclass(frozen=True)
class Surrogate:
    """Values of designs between those that are known.

    Attributes
    ----------
    space : Space
    places : (known, fields) array
        Designs that were solved.
    values : (known, values) array
        What is known of them.
    failed : (other, fields) array
        Designs that could not be solved.
    folds : tuple of Fold or None
        Of each value, in place of functions through all that is known.
    """

    space: Space
    places: FloatArray
    values: FloatArray
    failed: FloatArray
    folds: tuple[Fold | None, ...] = ()

    def at(self, places: FloatArray) -> FloatArray:
        """Values at places (n, fields): (n, values)."""
        inputs = inputs_of(self.space, places)
        found = np.asarray(self._functions(inputs))
        for k, fold in enumerate(self.folds):
            if fold is not None:
                found[:, k] = fold.at(inputs)
        return found

    def folded(self, centre: FloatArray) -> Surrogate:
        """The same with folds through the designs around a centre (fields,), where these are enough."""
        inputs = inputs_of(self.space, self.places)
        near = inputs_of(self.space, centre[None, :])[0]
        return replace(self, folds=tuple(fold_near(near, inputs, column) for column in self.values.T))

    def distance(self, places: FloatArray) -> FloatArray:
        """Distance of places (n, fields) to the nearest known design (n,), along its farthest axis."""
        every = np.vstack([self.places, self.failed])
        return np.asarray(cdist(inputs_of(self.space, places), inputs_of(self.space, every), "chebyshev").min(axis=1))

    def may_fail(self, places: FloatArray) -> BoolArray:
        """Whether the design next to a place could not be solved (n,)."""
        if not self.failed.size:
            return np.zeros(len(places), dtype=bool)
        inputs = inputs_of(self.space, places)
        return np.asarray(
            cdist(inputs, inputs_of(self.space, self.failed)).min(axis=1)
            < cdist(inputs, inputs_of(self.space, self.places)).min(axis=1)
        )

    @cached_property
    def _functions(self) -> RBFInterpolator:
        inputs = inputs_of(self.space, self.places)
        _, first = np.unique(np.round(inputs / _SAME), axis=0, return_index=True)
        inputs, values = inputs[first], self.values[first]
        try:
            return RBFInterpolator(inputs, values, kernel="cubic", degree=1)
        except (ValueError, np.linalg.LinAlgError):  # too few designs for a linear tail, or all in one plane
            return RBFInterpolator(inputs, values, kernel="linear", degree=0)


def inputs_of(space: Space, places: FloatArray) -> FloatArray:
    """Coordinates in which designs (n, fields) are as far apart as they are unlike: (n, inputs)."""
    columns: list[FloatArray] = []
    for k, field in enumerate(space.fields):
        if field.continuous or _in_order(field.values):
            columns.append(places[:, k])
        else:
            chosen = np.array([field.index(place) for place in places[:, k]])
            columns += [_UNLIKE * (chosen == one) for one in range(len(field.values))]
    return np.stack(columns, axis=1).astype(float)


def _in_order(values: Sequence[Value]) -> bool:
    return all(is_number(value) for value in values) and list(values) == sorted(values)
