"""Displacement of an elastic half-space under a pressure on a regular grid, by fast Fourier transform."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable
from functools import lru_cache
from math import frexp, ldexp
from threading import Lock, local
from typing import NamedTuple

import numpy as np
from numpy.typing import DTypeLike
from scipy import fft

from semiwear.arrays import FloatArray, IntArray
from semiwear.closed_forms.love import love_coefficients
from semiwear.compliance.fourier import convolve, half_steps, in_lanes, work_size
from semiwear.untyped import Reals

_Plan = tuple[Reals, Reals, Reals, int, int, int]

_MOST_KEPT = 64 * 2**20  # bytes of coefficients and spectra together
_MOST_IDLE = 32 * 2**20  # bytes of work space in double precision that are kept: it is rarely needed
_LINE = 64  # bytes of a line of the cache


def fast_length(length: int) -> int:
    """Least number of cells, at least `length`, for which the transforms are fast."""
    return int(fft.next_fast_len(length, real=True))


class _KeptArrays:
    """Most recently used arrays, up to a total number of bytes."""

    def __init__(self, most: int) -> None:
        self._most, self._arrays, self._lock = most, OrderedDict[Hashable, Reals](), Lock()

    def get(self, key: Hashable) -> Reals | None:
        with self._lock:
            if key in self._arrays:
                self._arrays.move_to_end(key)
            return self._arrays.get(key)

    def keep(self, key: Hashable, array: Reals) -> Reals:
        """The array, read-only."""
        array.flags.writeable = False
        with self._lock:
            self._arrays.pop(key, None)
            self._arrays[key] = array
            total = sum(kept.nbytes for kept in self._arrays.values())
            while total > self._most:
                total -= self._arrays.popitem(last=False)[1].nbytes
        return array


_kept = _KeptArrays(_MOST_KEPT)


def _coefficients(px: int, py: int, dx: float, dy: float) -> tuple[FloatArray, float]:
    """Love's coefficients over a factor; they are proportional to the size of the cells."""
    exponent = frexp(dx)[1]
    unit = ldexp(dx, -exponent), ldexp(dy, -exponent)
    table = _kept.get(unit)
    if table is None or table.shape[0] <= px or table.shape[1] <= py:
        size = (px + 1, py + 1) if table is None else (max(px + 1, table.shape[0]), max(py + 1, table.shape[1]))
        table = _kept.keep(unit, love_coefficients(size, unit))
    return table[: px + 1, : py + 1], ldexp(1.0, exponent)


def _spectrum(px: int, py: int, dx: float, dy: float, inverse: bool) -> FloatArray:
    """Spectrum of Love's coefficients on the zero-padded grid, or the inverse one of the preconditioner.

    The padded kernel is even and periodic, so that its transform is the cosine transform of one quarter and real.
    The preconditioner is the optimal circulant of the unpadded grid (T. Chan 1988): the periodic kernel whose
    coefficients average those of each diagonal. Unlike |q| or a wrapped kernel it is positive definite for every
    shape of cell and grid, since the half-space is.
    """
    table, factor = _coefficients(px, py, dx, dy)
    if not inverse:
        spectrum = np.asarray(fft.dctn(table, type=1))
        spectrum *= factor
        spectrum /= 4 * px * py
        return spectrum
    periodic = np.empty((px, py))
    offset_x, offset_y = np.arange(px) / px, np.arange(py) / py
    for k, offset in enumerate(offset_x):  # row by row, which takes no extra memory
        row = (1.0 - offset) * table[k] + offset * table[px - k]
        periodic[k] = (1.0 - offset_y) * row[:-1] + offset_y * row[:0:-1]
    return np.asarray(1.0 / (fft.rfft2(periodic).real[: px // 2 + 1] * factor * (px * py)))


def _factors(px: int, py: int, dx: float, dy: float, inverse: bool, dtype: DTypeLike) -> Reals:
    """Spectrum in the order of `convolve`; the first call computes all spectra of the iterations of a contact."""

    def key(inverse: bool, dtype: DTypeLike) -> Hashable:
        return px, py, dx, dy, inverse, np.dtype(dtype)

    found = _kept.get(key(inverse, dtype))
    if found is not None:
        return found
    together: dict[bool, list[DTypeLike]] = {inverse: [dtype]}
    if np.dtype(dtype) == np.float32:
        together = {False: [np.float64, np.float32], True: [np.float32]}
    ordered = {}
    for backwards, precisions in together.items():
        spectrum = _spectrum(px, py, dx, dy, backwards)
        for precision in precisions:
            in_order = in_lanes(spectrum, (px, py), not backwards, precision)
            ordered[key(backwards, precision)] = _kept.keep(key(backwards, precision), in_order)
    return ordered[key(inverse, dtype)]


class _WorkSpace(local):
    """Work space of a thread, kept for reuse: new memory pages cost as much as a transform."""

    def __init__(self) -> None:
        self._kept = np.zeros(0, np.uint8)

    def of(self, size: int, dtype: type) -> Reals:
        needed = size * np.dtype(dtype).itemsize
        if self._kept.size < needed:
            self._kept = np.zeros(0, np.uint8)  # release before allocating more
            memory = np.zeros(needed + _LINE, np.uint8)
            first = -memory.ctypes.data % _LINE  # vectors must not straddle lines of the cache
            self._kept = memory[first : first + needed]
        return np.asarray(self._kept[:needed].view(dtype))

    def release(self) -> None:
        """Release a large work space."""
        if self._kept.size > _MOST_IDLE:
            self._kept = np.zeros(0, np.uint8)


_work = _WorkSpace()


class HalfSpace:
    """Compliance of an elastic half-space on a regular grid, for an effective modulus of 1 MPa.

    The displacement is the convolution of the pressure with Love's coefficients on a grid padded with zeros to
    twice its size (Stanley & Kato 1997; Liu, Wang & Liu 2000), hence free of periodic images.

    Parameters
    ----------
    shape : (nx, ny)
        Cells of the grid.
    cell : (dx, dy) [mm]
        Sides of a cell.

    Attributes
    ----------
    shape : tuple of int

    Notes
    -----
    Spectra are shared between instances.
    """

    def __init__(self, shape: tuple[int, ...], cell: tuple[float, float]):
        self.shape = nx, ny = int(shape[0]), int(shape[1])
        self._cell = float(cell[0]), float(cell[1])
        self._periodic = (fast_length(nx), fast_length(ny))
        self._plans: dict[tuple[bool, bool], _Plan] = {}

    def of_one_cell(self) -> float:
        """Displacement of a cell under its own pressure [mm/MPa]."""
        table, factor = _coefficients(*self._periodic, *self._cell)
        return float(table[0, 0]) * factor

    def apply(self, pressure: FloatArray, *, roughly: bool = False) -> Reals:
        """Displacement [mm] of a pressure [MPa], both of the grid's shape; in single precision with `roughly`."""
        return self._convolve(pressure, False, roughly)

    def precondition(self, residual: FloatArray, *, roughly: bool = False) -> Reals:
        """Approximate pressure [MPa] for a displacement [mm]: the inverse of a periodic approximation of `apply`."""
        return self._convolve(residual, True, roughly)

    def _plan(self, inverse: bool, roughly: bool) -> _Plan:
        dtype, (px, py) = np.float32 if roughly else np.float64, self._periodic
        plan = (
            _factors(px, py, *self._cell, inverse, dtype),
            half_steps(px, dtype),
            half_steps(py, dtype),
            *work_size(self._periodic, dtype),
        )
        self._plans[inverse, roughly] = plan
        return plan

    def _convolve(self, grid: FloatArray, inverse: bool, roughly: bool) -> Reals:
        plan = self._plans.get((inverse, roughly)) or self._plan(inverse, roughly)
        factors, turn_x, turn_y, size, spectrum, buffer = plan
        work = _work.of(size, np.float32 if roughly else np.float64)
        result, grid = np.empty(self.shape, work.dtype), np.ascontiguousarray(grid, float)
        convolve(grid, result, factors, not inverse, turn_x, turn_y, work, spectrum, buffer)
        del work
        if not roughly:
            _work.release()
        return result


class GridPlans(NamedTuple):
    """Factors and sizes for a compiled `convolve` of several grids with the same number of columns.

    Attributes
    ----------
    factors : (any,) array [mm/MPa]
        Factors of all grids in lanes, for a unit modulus.
    first_factor : (grids + 1,) int array
        Index of the first factor of each grid.
    turns : (any, 2) array
        Half steps along the rows of each grid.
    first_turn : (grids + 1,) int array
    turns_across : (any, 2) array
        Half steps along the columns, the same for all.
    sizes : (grids, 2) int array
        Numbers of work space for the spectrum and a buffer of each grid.
    work_size : int
        Numbers of work space for the largest grid.
    """

    factors: FloatArray
    first_factor: IntArray
    turns: FloatArray
    first_turn: IntArray
    turns_across: FloatArray
    sizes: IntArray
    work_size: int

    def work_space(self) -> FloatArray:
        """Work space of this thread, enough for each of the grids; the next caller overwrites it."""
        return np.asarray(_work.of(self.work_size, np.float64))


@lru_cache(maxsize=256)
def grid_plans(counts: tuple[int, ...], columns: int, cell: tuple[float, float]) -> GridPlans:
    """Independent half-spaces under grids with these numbers of rows and the same number of columns."""
    lengths, across = [fast_length(count) for count in counts], fast_length(columns)
    factors = [_factors(length, across, float(cell[0]), float(cell[1]), False, np.float64) for length in lengths]
    turns = [half_steps(length, np.float64) for length in lengths]
    sizes = np.array([work_size((length, across), np.float64) for length in lengths])
    together = np.concatenate(factors), np.concatenate(turns)
    for array in together:  # as those of a single grid, for which functions are compiled
        array.flags.writeable = False
    return GridPlans(
        together[0],
        np.cumsum([0, *(own.size for own in factors)]),
        together[1],
        np.cumsum([0, *(len(own) for own in turns)]),
        np.asarray(half_steps(across, np.float64), np.float64),
        sizes[:, 1:].copy(),
        int(sizes[:, 0].max()),
    )
