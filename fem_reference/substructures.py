r"""Compliance of a supported body by substructures within substructures.

From the smallest parts of a `Dissection` upwards each part eliminates its own unknowns, which by then nothing else
touches, and hands on what is left: a dense matrix of its border and of the loads on it. With the loads B as unknowns
of their own the matrix of the body is

.. math:: \begin{pmatrix} K & B \\ B^T & 0 \end{pmatrix} ,

and what is left in the end, when all displacements have gone, is minus the compliance B' K^-1 B. Nothing is solved
backwards and no factor of the whole body is kept.

Sources: Przemieniecki, AIAA J. 1 (1963) 138 (substructures); Duff and Reid, ACM Trans. Math. Softw. 9 (1983) 302
(multifrontal elimination).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf
from scipy.sparse import csc_matrix, csr_matrix, vstack

from fem_reference.dissection import Dissection
from semiwear.errors import ConvergenceError

__all__ = ["compliance_by_parts"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def compliance_by_parts(
    stiffness: csr_matrix, free: IntArray, points: FloatArray, unit_loads: csr_matrix
) -> FloatArray:
    """Displacements that loads see of one another, B' K^-1 B.

    Parameters
    ----------
    stiffness : (3 n, 3 n) sparse array [N/mm]
        Of the free body, three unknowns a node.
    free : (m,) int array
        Unknowns that are not held.
    points : (n, 3) array [mm]
        Places of the nodes.
    unit_loads : (3 n, k) sparse array
        B.

    Returns
    -------
    (k, k) array, symmetric [mm/N]

    Raises
    ------
    ConvergenceError
        If the stiffness is not positive definite: the body is not held.
    """
    nodes = np.unique(free // 3)
    blocks = csr_matrix(stiffness).tobsr(blocksize=(3, 3))
    graph = csr_matrix((np.ones(len(blocks.indices), dtype=np.int8), blocks.indices, blocks.indptr))
    parts = Dissection.of(graph[nodes][:, nodes], points[nodes])
    is_free = np.zeros(stiffness.shape[0], dtype=bool)
    is_free[free] = True
    unknowns = 3 * nodes[parts.order][:, None] + np.arange(3)
    ends = np.concatenate([[0], np.cumsum(is_free[unknowns].sum(axis=1))])[parts.ends]
    order = unknowns[is_free[unknowns]]

    # the lower triangle in the order of elimination; the loads come last
    own = csr_matrix(stiffness)[order][:, order]
    matrix = csc_matrix(vstack([own, csr_matrix(unit_loads)[order].T]))
    matrix.sort_indices()
    place, room = np.empty(matrix.shape[0], dtype=np.int64), _Room()
    left: dict[int, tuple[IntArray, FloatArray]] = {}
    for k, below in enumerate(parts.below):
        left[k] = _eliminated(matrix, int(ends[k]), int(ends[k + 1]), [left.pop(part) for part in below], place, room)
    ((loads, rest),) = left.values()
    result = np.zeros((unit_loads.shape[1], unit_loads.shape[1]))
    at = loads - len(order)
    result[np.ix_(at, at)] = -(np.tril(rest) + np.tril(rest, -1).T)
    return result


class _Room:
    """Memory for dense matrices that is used again: fresh pages cost more than the arithmetic on them."""

    def __init__(self) -> None:
        self._spare: list[FloatArray] = []

    def zeros(self, rows: int, columns: int) -> FloatArray:
        """A matrix of zeros, column after column."""
        size = rows * columns
        fitting = [one for one in self._spare if len(one) >= size]
        if fitting:
            buffer = min(fitting, key=len)
            self._spare = [one for one in self._spare if one is not buffer]
        else:
            buffer = np.empty(size)
        matrix = buffer[:size].reshape(columns, rows).T
        matrix[:] = 0.0
        return matrix

    def give_back(self, *matrices: FloatArray) -> None:
        """Matrices from `zeros` that are not needed any more."""
        for matrix in matrices:
            buffer = matrix
            while buffer.base is not None:
                buffer = buffer.base
            self._spare.append(buffer)


def _eliminated(
    matrix: csc_matrix,
    start: int,
    end: int,
    below: list[tuple[IntArray, FloatArray]],
    place: IntArray,
    room: _Room,
) -> tuple[IntArray, FloatArray]:
    """What a part hands on: the unknowns of its border, in order, and their matrix, of which the lower half counts.

    Parameters
    ----------
    matrix : (n + k, n) sparse array
    start, end : int
        Unknowns of the part.
    below : list of (unknowns, matrix)
        What the parts below it have handed on.
    place : (n + k,) int array
        To work in.
    room : _Room
    """
    columns = slice(matrix.indptr[start], matrix.indptr[end])
    rows, values = matrix.indices[columns], matrix.data[columns]
    column = np.repeat(np.arange(end - start), np.diff(matrix.indptr[start : end + 1]))
    border = np.unique(np.concatenate([rows[rows >= end], *[unknowns[unknowns >= end] for unknowns, _ in below]]))
    own, others = end - start, len(border)
    place[start:end], place[border] = np.arange(own), np.arange(others)
    pivot, beside, rest = room.zeros(own, own), room.zeros(others, own), room.zeros(others, others)
    inner, outer = (rows >= start + column) & (rows < end), rows >= end
    pivot[place[rows[inner]], column[inner]] = values[inner]
    beside[place[rows[outer]], column[outer]] = values[outer]
    for unknowns, handed in below:
        split = int(np.searchsorted(unknowns, end))
        inside, outside = np.split(place[unknowns], [split])
        _add(pivot, inside, inside, handed[:split, :split])
        _add(beside, outside, inside, handed[split:, :split])
        _add(rest, outside, outside, handed[split:, split:])
        room.give_back(handed)
    if own:
        factor, wrong = dpotrf(pivot, lower=1, overwrite_a=1, clean=0)
        if wrong:
            raise ConvergenceError("the stiffness of a body is not positive definite: hold its bore or back face")
        beside = dtrsm(1.0, factor, beside, side=1, lower=1, trans_a=1, overwrite_b=1)
        rest = dsyrk(-1.0, beside, beta=1.0, c=rest, lower=1, overwrite_c=1)
    room.give_back(pivot, beside)
    return border, rest


def _add(target: FloatArray, rows: IntArray, columns: IntArray, values: FloatArray) -> None:
    """Add a matrix at some rows and columns, block by block: they come in few runs of neighbours.

    Where rows and columns are the same, blocks above the diagonal stay away.
    """
    across = list(_runs(columns))
    for down, wanted_rows in _runs(rows):
        for aside, wanted_columns in across:
            if rows is columns and down.start < aside.start:
                break
            target[wanted_rows, wanted_columns] += values[down, aside]


def _runs(places: IntArray) -> Iterator[tuple[slice, slice]]:
    """Stretches in which places follow one another: where they stand, and what they say."""
    breaks = np.flatnonzero(places[1:] - places[:-1] != 1) + 1
    for start, end in itertools.pairwise([0, *breaks.tolist(), len(places)]):
        if end > start:
            first = int(places[start])
            yield slice(start, end), slice(first, first + end - start)
