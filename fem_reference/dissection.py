"""Nested dissection: elimination order of the nodes of a body by repeated bisection, separators last.

A separator, connected to both halves of the nodes, lies between them. The halves are not connected and are eliminated
independently. Planes are tried in several directions and at several positions: teeth on a rim are best separated at
the rim between them, not in the middle of a fine patch.

Source: George, SIAM J. Numer. Anal. 10 (1973) 345.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from fem_reference.arrays import FloatArray, IntArray

LEAST = 80
"""Nodes of a part that is not divided further."""

_OUTER = 0.2  # least fraction of the nodes below a plane, and above it
_BALANCE = 1.0 / 3.0  # exponent that weighs the size of the smaller half against that of the separator


@dataclass(frozen=True)
class Dissection:
    """Nodes in the order of their elimination, in parts.

    Attributes
    ----------
    order : (n,) int array
    ends : (parts + 1,) int array
        Part k is ``order[ends[k]:ends[k + 1]]`` and comes after all below it.
    below : tuple of tuples of int
        The parts directly below each part; the last part is above all others.
    """

    order: IntArray
    ends: IntArray
    below: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, graph: csr_matrix, points: FloatArray) -> Dissection:
        """Dissect nodes.

        Parameters
        ----------
        graph : (n, n) sparse array
            Entries where two nodes are connected, symmetric.
        points : (n, 3) array [mm]
        """
        parts: list[IntArray] = []
        below: list[tuple[int, ...]] = []

        def dissect(nodes: IntArray, graph: csr_matrix) -> int:
            under: tuple[int, ...] = ()
            if len(nodes) > LEAST and (found := _cut(graph, points[nodes])):
                low, high, between = found
                under = tuple(dissect(nodes[half], graph[half][:, half]) for half in (low, high))
                nodes = nodes[between]
            parts.append(nodes)
            below.append(under)
            return len(parts) - 1

        dissect(np.arange(len(points)), csr_matrix(graph))
        return cls(np.concatenate(parts), np.cumsum([0] + [len(part) for part in parts]), tuple(below))


def _cut(graph: csr_matrix, points: FloatArray) -> tuple[IntArray, IntArray, IntArray] | None:
    """Numbers of the nodes below and above the best plane, and of the separator; None if no plane separates them."""
    count = len(points)
    _, principal = np.linalg.eigh(np.cov(points.T))
    outer = int(_OUTER * count)
    cuts = np.arange(outer, count - outer)
    least, found, rank = np.inf, None, np.empty(count, dtype=np.int64)
    for direction in (*np.eye(3), *principal.T):
        rank[np.argsort(points @ direction, kind="stable")] = np.arange(count)
        # a node lies at a plane if it has a neighbour beyond
        beside = rank[graph.indices]
        for reach, behind in ((np.maximum, False), (np.minimum, True)):
            farthest = reach.reduceat(beside, graph.indptr[:-1])
            before = np.concatenate([[0], np.cumsum(np.bincount(farthest, minlength=count))])[cuts]
            size = np.abs(cuts - before)
            below, above = (cuts, count - cuts - size) if behind else (cuts - size, count - cuts)
            smaller = np.minimum(below, above)
            cost = np.where(smaller > 0, size / np.maximum(smaller, 1) ** _BALANCE, np.inf)
            k = int(np.argmin(cost))
            if cost[k] < least:
                least, low = cost[k], rank < cuts[k]
                between = ~low & (farthest < cuts[k]) if behind else low & (farthest >= cuts[k])
                found = low & ~between, ~low & ~between, between
    if found is None:
        return None
    first, second, third = (np.flatnonzero(part) for part in found)
    return first, second, third
