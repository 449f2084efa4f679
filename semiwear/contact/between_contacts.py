"""Values on the cells in contact, continued over the cells between them.

Contact on a grid is preconditioned by an inverse of the whole surface. Set to zero between the contacts, a residual
jumps at each of their edges, and the inverse turns jumps into spurious pressure. The inverse of the cells in contact
alone is that of the whole surface applied to the residual's continuation of least energy; any other continuation
gives more, never less, and the closer it comes to that one, the fewer iterations are needed.

The continuation here costs a few passes over the grid. Means over blocks of cells, in which a cell without contact
counts as zero, go from grid to coarser grid. On the way back each grid adds values of the coarser one: a cell without
contact takes all of its value, a block as much as its fraction of such cells. Between contacts the values are joined
smoothly, and around a single one they decay with the square of the distance.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from semiwear.arrays import BoolArray, FloatArray
from semiwear.kernel_cache import njit
from semiwear.untyped import Reals

_SQUARE = 1.5  # sides of a cell whose ratio is less are halved together
_COARSEST = 4  # cells along either side of a grid that is not coarsened further


_kernel = njit(cache=True, error_model="numpy")


@_kernel
def _means(values, along_x, along_y, coarse):  # type: ignore[no-untyped-def]
    """Means over blocks of cells; what lies beyond the border of the grid (nx, ny) is zero."""
    nx, ny = values.shape
    row = np.zeros(ny + 1)
    part = 1.0 / (along_x * along_y)
    for i in range(coarse.shape[0]):
        row[:ny] = 0.0
        for k in range(i * along_x, min((i + 1) * along_x, nx)):
            for j in range(ny):
                row[j] += values[k, j]
        for m in range(coarse.shape[1]):
            coarse[i, m] = part * (row[2 * m] + row[2 * m + 1] if along_y == 2 else row[m])


@_kernel
def _spread(row, along, fine):  # type: ignore[no-untyped-def]
    """Values of a row of coarse cells (m,), linear between their centres, at those of its fine cells (n,)."""
    if along == 1:
        fine[:] = row
        return
    n, last = fine.shape[0], row.shape[0] - 1
    fine[0] = row[0]
    for m in range(last):
        fine[2 * m + 1] = 0.75 * row[m] + 0.25 * row[m + 1]
        fine[2 * m + 2] = 0.25 * row[m] + 0.75 * row[m + 1]
    if n == 2 * last + 2:
        fine[n - 1] = row[last]


@_kernel
def _lend(fine, along, row):  # type: ignore[no-untyped-def]
    """Transpose of `_spread`."""
    if along == 1:
        row[:] = fine
        return
    n, last = fine.shape[0], row.shape[0] - 1
    row[:] = 0.0
    row[0] += fine[0]
    for m in range(last):
        row[m] += 0.75 * fine[2 * m + 1] + 0.25 * fine[2 * m + 2]
        row[m + 1] += 0.25 * fine[2 * m + 1] + 0.75 * fine[2 * m + 2]
    if n == 2 * last + 2:
        row[last] += fine[n - 1]


@_kernel
def _beside(i, along, coarse):  # type: ignore[no-untyped-def]
    """Neighbouring coarse row on the side of a fine row, and the interpolation weight of the fine row's own one."""
    if along == 1:
        return i, 1.0
    return min(max(i // 2 + 2 * (i % 2) - 1, 0), coarse - 1), 0.75


@_kernel
def _fill(coarse, present, along_x, along_y, values):  # type: ignore[no-untyped-def]
    """Add the coarser grid's values, linear between its cells, where a grid (nx, ny) has no contact."""
    nx, ny = values.shape
    rows = np.empty((3, ny))  # of the coarser grid, row i at i % 3
    known = -1
    for i in range(nx):
        own = i // along_x
        while known < min(own + 1, coarse.shape[0] - 1):
            known += 1
            _spread(coarse[known], along_y, rows[known % 3])
        beside, weight = _beside(i, along_x, coarse.shape[0])
        own_row, next_row = rows[own % 3], rows[beside % 3]
        for j in range(ny):
            values[i, j] += (1.0 - present[i, j]) * (weight * own_row[j] + (1.0 - weight) * next_row[j])


@_kernel
def _gather(values, present, along_x, along_y, coarse):  # type: ignore[no-untyped-def]
    """Transpose of the interpolation in `_fill`."""
    nx, ny = values.shape
    rows = np.zeros((3, ny))
    done = 0
    for i in range(nx):
        own = i // along_x
        while done < own - 1:
            _lend(rows[done % 3], along_y, coarse[done])
            rows[done % 3] = 0.0
            done += 1
        beside, weight = _beside(i, along_x, coarse.shape[0])
        own_row, next_row = rows[own % 3], rows[beside % 3]
        for j in range(ny):
            moved = (1.0 - present[i, j]) * values[i, j]
            own_row[j] += weight * moved
            next_row[j] += (1.0 - weight) * moved
    while done < coarse.shape[0]:
        _lend(rows[done % 3], along_y, coarse[done])
        done += 1


@_kernel
def _give_back(coarse, along_x, along_y, values):  # type: ignore[no-untyped-def]
    """Add the transpose of `_means` to values (nx, ny)."""
    nx, ny = values.shape
    row = np.empty(ny + 1)
    part = 1.0 / (along_x * along_y)
    for i in range(nx):
        if i % along_x == 0:
            for m in range(coarse.shape[1]):
                own = part * coarse[i // along_x, m]
                if along_y == 2:
                    row[2 * m] = own
                    row[2 * m + 1] = own
                else:
                    row[m] = own
        for j in range(ny):
            values[i, j] += row[j]


@njit(cache=True, error_model="numpy")
def _border(pressed):  # type: ignore[no-untyped-def]
    nx, ny = pressed.shape
    cells, border = 0, 0
    for i in range(nx):
        for j in range(ny):
            if not pressed[i, j]:
                continue
            cells += 1
            inside = 0 < i < nx - 1 and 0 < j < ny - 1
            if inside and not (pressed[i - 1, j] and pressed[i + 1, j] and pressed[i, j - 1] and pressed[i, j + 1]):
                border += 1
    return cells, border


def border_squared_over_area(pressed: BoolArray) -> float:
    """Squared number of cells at edges of contacts (nx, ny) over that of all pressed cells: 10 n for n discs."""
    cells, border = _border(pressed)
    return float(border**2 / cells) if cells else 0.0


class _Level(NamedTuple):
    """A coarser grid (nx, ny): finer cells in each cell along either axis, values, and fraction in contact."""

    along_x: int
    along_y: int
    values: Reals
    present: Reals


class BetweenContacts:
    """Continues values of the cells in contact over the cells between them, and does the transpose.

    Parameters
    ----------
    shape : (nx, ny)
    cell : (dx, dy)
        Sides of a cell, by which cells are joined along either axis.
    """

    def __init__(self, shape: tuple[int, int], cell: tuple[float, float]) -> None:
        self._levels: list[_Level] = []
        (nx, ny), (dx, dy) = shape, cell
        while max(nx, ny) > _COARSEST:
            along_x = 2 if nx > 1 and (dx < _SQUARE * dy or ny == 1) else 1
            along_y = 2 if ny > 1 and (dy < _SQUARE * dx or nx == 1) else 1
            nx, ny, dx, dy = -(-nx // along_x), -(-ny // along_y), dx * along_x, dy * along_y
            self._levels.append(_Level(along_x, along_y, *np.empty((2, nx, ny), np.float32)))

    def fill(self, values: FloatArray, contact: BoolArray) -> FloatArray:
        """Continue values (nx, ny), zero on cells without contact, over these cells, in place."""
        fine, present = values, contact
        for level in self._levels:
            _means(fine, level.along_x, level.along_y, level.values)
            _means(present, level.along_x, level.along_y, level.present)
            fine, present = level.values, level.present
        for level, (fine, present) in reversed(self._with_finer(values, contact)):
            _fill(level.values, present, level.along_x, level.along_y, fine)
        return values

    def collect(self, values: Reals, contact: BoolArray) -> Reals:
        """Transpose of `fill` for the cells in contact of its last call; changes the values (nx, ny)."""
        finer = self._with_finer(values, contact)
        for level, (fine, present) in finer:
            _gather(fine, present, level.along_x, level.along_y, level.values)
        for level, (fine, _) in reversed(finer):
            _give_back(level.values, level.along_x, level.along_y, fine)
        values *= contact
        return values

    def _with_finer(self, values: Reals, contact: BoolArray) -> list[tuple[_Level, tuple[Reals, Reals]]]:
        """Every coarser grid with the values and the fraction in contact of the next finer one."""
        finer = [(values, contact), *((level.values, level.present) for level in self._levels[:-1])]
        return list(zip(self._levels, finer, strict=False))
