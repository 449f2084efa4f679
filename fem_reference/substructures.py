r"""Compliance of a supported body, or a factor of its stiffness, by substructures within substructures.

From the smallest parts of a `Dissection` upwards each part eliminates its own unknowns, which are then coupled to no
other part, and passes on its Schur complement: a dense matrix of its border and of the loads on it. With the loads B
as unknowns of their own the matrix of the body is

.. math:: \begin{pmatrix} K & B \\ B^T & 0 \end{pmatrix} ,

and the Schur complement after elimination of all displacements is minus the compliance B' K^-1 B. There is no
backward substitution and no factor of the whole body is kept. For displacements under later loads the factors of the
parts are kept instead (`DissectionFactor`). All arithmetic is on dense matrices by scipy's own BLAS.

Sources: Przemieniecki, AIAA J. 1 (1963) 138 (substructures); Duff and Reid, ACM Trans. Math. Softw. 9 (1983) 302
(multifrontal elimination).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from scipy.linalg.blas import dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf
from scipy.sparse import csc_matrix, csr_matrix, vstack

from fem_reference.arrays import FloatArray, IntArray
from fem_reference.dissection import Dissection
from semiwear.errors import ConvergenceError

_Kept = tuple[int, int, IntArray, FloatArray, FloatArray]
"""First unknown of a part and the one after its last, its border, factor of its own unknowns, rows beside them."""


def compliance_by_parts(
    stiffness: csr_matrix, free: IntArray, points: FloatArray, unit_loads: csr_matrix
) -> FloatArray:
    """Displacements at each load by the others, B' K^-1 B.

    Parameters
    ----------
    stiffness : (3 n, 3 n) sparse array [N/mm]
        Of the free body, three unknowns a node.
    free : (m,) int array
        Unknowns that are not held.
    points : (n, 3) array [mm]
        Coordinates of the nodes.
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
    (loads, rest), _ = _eliminated_all(matrix, ends, parts)
    result = np.zeros((unit_loads.shape[1], unit_loads.shape[1]))
    at = loads - len(order)
    result[np.ix_(at, at)] = -(np.tril(rest) + np.tril(rest, -1).T)
    return result


class DissectionFactor:
    """Cholesky factor of a stiffness, part by part.

    Parameters
    ----------
    matrix : (n, n) sparse array, symmetric positive definite [N/mm]
    places : (n, 3) array [mm]
        Of the nodes to which the unknowns belong; those of one node follow one another.

    Raises
    ------
    ConvergenceError
        If the matrix is not positive definite.
    """

    name = "dissection"

    def __init__(self, matrix: csr_matrix, places: FloatArray):
        rows = csr_matrix(matrix)
        new = np.concatenate([[True], (np.diff(places, axis=0) != 0.0).any(axis=1)])
        node = np.cumsum(new) - 1
        member = csr_matrix((np.ones(len(node), dtype=np.int8), (node, np.arange(len(node)))))
        pattern = csr_matrix((np.ones(rows.nnz, dtype=np.int8), rows.indices, rows.indptr), shape=rows.shape)
        graph = csr_matrix((member.astype(np.int32) @ pattern @ member.T).astype(bool).astype(np.int8))
        parts = Dissection.of(graph, places[new])
        first = np.concatenate([np.flatnonzero(new), [len(node)]])
        counts = np.diff(first)[parts.order]
        ends = np.concatenate([[0], np.cumsum(counts)])[parts.ends]
        starts = np.repeat(first[parts.order] - np.concatenate([[0], np.cumsum(counts)[:-1]]), counts)
        self._order = starts + np.arange(len(node))
        lower = csc_matrix(rows[self._order][:, self._order])
        _, self._parts = _eliminated_all(lower, ends, parts, keep=True)

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Solution for one right-hand side (n,) or several (n, k), in the same shape."""
        loads = np.asarray(rhs, dtype=float)
        x = loads.reshape(len(loads), -1)[self._order]
        for start, end, border, pivot, beside in self._parts:
            x[start:end] = dtrsm(1.0, pivot, x[start:end], lower=1)
            x[border] -= beside @ x[start:end]
        for start, end, border, pivot, beside in reversed(self._parts):
            x[start:end] = dtrsm(1.0, pivot, x[start:end] - beside.T @ x[border], lower=1, trans_a=1)
        result = np.empty_like(x)
        result[self._order] = x
        return result.reshape(loads.shape)


def _eliminated_all(
    matrix: csc_matrix, ends: IntArray, parts: Dissection, *, keep: bool = False
) -> tuple[tuple[IntArray, FloatArray], list[_Kept]]:
    """Border of the last part, and the eliminated unknowns of all parts if they are to be kept."""
    matrix.sort_indices()
    place, room = np.empty(matrix.shape[0], dtype=np.int64), _Room()
    left: dict[int, tuple[IntArray, FloatArray]] = {}
    kept: list[_Kept] | None = [] if keep else None
    for k, below in enumerate(parts.below):
        handed = [left.pop(part) for part in below]
        left[k] = _eliminated(matrix, int(ends[k]), int(ends[k + 1]), handed, place, room, kept)
    (last,) = left.values()
    return last, kept or []


class _Room:
    """Memory for dense matrices, kept for reuse: new memory pages cost more than the arithmetic on them."""

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
    kept: list[_Kept] | None,
) -> tuple[IntArray, FloatArray]:
    """Border of a part: its unknowns, in order, and their matrix, of which the lower half counts.

    Parameters
    ----------
    matrix : (n + k, n) sparse array
    start, end : int
        Unknowns of the part.
    below : list of (unknowns, matrix)
        Schur complements passed on by the parts below it.
    place : (n + k,) int array
        To work in.
    room : _Room
    kept : list, optional
        To which the part adds its unknowns, its border and its part of the factor.
    """
    columns = slice(matrix.indptr[start], matrix.indptr[end])
    rows, values = matrix.indices[columns], matrix.data[columns]
    column = np.repeat(np.arange(end - start), np.diff(matrix.indptr[start : end + 1]))
    border = np.unique(np.concatenate([rows[rows >= end], *[unknowns[unknowns >= end] for unknowns, _ in below]]))
    own, others = end - start, len(border)
    place[start:end], place[border] = np.arange(own), np.arange(others)
    new = room.zeros if kept is None else _fresh
    pivot, beside, rest = new(own, own), new(others, own), room.zeros(others, others)
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
        pivot, wrong = dpotrf(pivot, lower=1, overwrite_a=1, clean=0)
        if wrong:
            raise ConvergenceError("the stiffness of a body is not positive definite: hold its bore or back face")
        beside = dtrsm(1.0, pivot, beside, side=1, lower=1, trans_a=1, overwrite_b=1)
        if others:
            rest = dsyrk(-1.0, beside, beta=1.0, c=rest, lower=1, overwrite_c=1)
    if kept is None:
        room.give_back(pivot, beside)
    elif own:
        kept.append((start, end, border, pivot, beside))
    return border, rest


def _fresh(rows: int, columns: int) -> FloatArray:
    """A matrix of zeros, column after column."""
    return np.zeros((columns, rows)).T


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
    """Runs of consecutive places: their positions in the array, and the places."""
    breaks = np.flatnonzero(places[1:] - places[:-1] != 1) + 1
    for start, end in itertools.pairwise([0, *breaks.tolist(), len(places)]):
        if end > start:
            first = int(places[start])
            yield slice(start, end), slice(first, first + end - start)
