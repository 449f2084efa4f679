"""Static condensation of a section's elements level by level, of many stiffness matrices at a time."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dtrtrs

from semiwear.arrays import BoolArray, FloatArray, IntArray


def levels_towards(last: IntArray, elements: IntArray, free: BoolArray) -> list[tuple[IntArray, int]]:
    """Free nodes level by level, as they are eliminated: a level is coupled only to the one before and the next.

    Counted backwards, a level has the further nodes of all elements that the one after it meets. With each comes the
    number of its last nodes that share elements with the level before: no others are coupled to that.

    Parameters
    ----------
    last : int array
        Nodes of the last level; all that the level before meets keep their order.
    elements : (elements, nodes) int array
    free : (nodes,) bool array
    """
    left = free.copy()
    levels, level = [], last
    while level.size:
        left[level] = False
        before = np.unique(elements[np.isin(elements, level).any(axis=1)])
        before = before[left[before]]
        met = np.isin(level, elements[np.isin(elements, before).any(axis=1)])
        levels.append((np.concatenate([level[~met], level[met]]), int(met.sum())))
        level = before
    return levels[::-1]


def factors_of(stiffness: FloatArray) -> FloatArray:
    """Lower triangular factors L L^T of positive definite matrices: (n, u, u) arrays."""
    return np.asarray(np.linalg.cholesky(stiffness), dtype=np.float64)


def halves(factors: FloatArray, right: FloatArray) -> FloatArray:
    """Halves L^-1 C of the symmetric products C^T K^-1 C, from factors (n, u, u) and C (n, u, v)."""
    # scipy.linalg.solve_triangular takes several times as long for matrices of some ten unknowns
    pairs = zip(factors, right, strict=True)
    return np.array([dtrtrs(factor.T, of_one, lower=0, trans=1)[0] for factor, of_one in pairs])
