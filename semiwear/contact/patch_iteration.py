"""Iterations of fidelity `patch`, compiled as a whole: each mesh position is one call, which releases Python's lock.

The steps are those of `complementarity`. They are taken on windows, the columns around the cells in contact, equally
many for each pair: contacts are narrow compared with the cells that may touch, and convolutions take most of the
time. The displacement of all cells, once at the end, shows whether any beyond a window touches; then windows grow.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.contact.complementarity import (
    CONVERGED,
    FIRST_REACH,
    GOES_ON,
    NOT_CONVERGED,
    NOT_POSITIVE,
    STATUSES,
    Complementarity,
    advance,
    downhill_change,
    judged,
    search_direction,
    separation_left,
)
from semiwear.contact.patch_system import PatchSystem, displace, plans_of
from semiwear.contact.row_preconditioner import precondition, row_preconditioner
from semiwear.kernel_cache import inner_njit, njit

_WINDOWS = 12  # tried before all columns are taken
_MARGIN = 3  # cells to either side of those in contact
_COLUMNS = 8  # widths of windows come in multiples
_ROUNDING = 1e-13  # of the largest displacement: penetration by rounding


class _Window(NamedTuple):
    """Columns of cells, equally many for each pair.

    Attributes
    ----------
    first : (rows,) int array
        First column in each row.
    columns : int
    """

    first: IntArray
    columns: int


def solve_in_windows(
    system: PatchSystem,
    gap: FloatArray,
    lever: FloatArray,
    torque: float,
    start: FloatArray,
    tolerance: float,
    max_iterations: int,
) -> Complementarity:
    """Forces on cells that balance a torque; arguments as of `patch_sharing.share_torque`.

    The forces to `start` from are not negative, zero where nothing can touch, and not all zero.
    """
    force, displacement, expected = start.copy(), np.empty_like(start), start > 0.0
    entire, used = plans_of(system, gap.shape[1]), 0
    for attempt in range(_WINDOWS + 1):
        window = _Window(*_window_around(expected, gap, system.starts, attempt == _WINDOWS))
        inside = plans_of(system, window.columns)
        work = (inside if inside.work_size > entire.work_size else entire).work_space()
        code, rotation, steps, error = _solve(
            system, inside, entire, work, window, gap, lever, torque, tolerance, max_iterations - used, force,
            displacement,
        )  # fmt: skip
        used += steps
        harmless = float(system.coefficients[0, 0]) * tolerance
        if code != CONVERGED or not _missed(window, gap, lever, rotation, force, displacement, harmless, expected):
            break
    return Complementarity(force, displacement, rotation, torque, STATUSES[code], used, error)


@njit(cache=True, error_model="numpy", nogil=True)
def _window_around(expected, gap, starts, every):  # type: ignore[no-untyped-def]
    """First column of the window in each row, and its width; of all columns, if `every`."""
    rows, columns = expected.shape
    pairs = starts.shape[0] - 1
    low, high, width = np.empty(pairs, dtype=np.int64), np.empty(pairs, dtype=np.int64), 0
    for pair in range(pairs):
        low[pair], high[pair] = columns, -1
        nearest, least = columns // 2, np.inf
        for r in range(starts[pair], starts[pair + 1]):
            for c in range(columns):
                if expected[r, c]:
                    low[pair], high[pair] = min(low[pair], c), max(high[pair], c)
                if gap[r, c] < least:
                    nearest, least = c, gap[r, c]
        if high[pair] < 0:
            low[pair], high[pair] = nearest, nearest
        width = max(width, high[pair] - low[pair] + 1)
    width = (width + 2 * _MARGIN + _COLUMNS - 1) // _COLUMNS * _COLUMNS
    width = columns if every else min(width, columns)
    first = np.empty(rows, dtype=np.int64)
    for pair in range(pairs):
        at = min(max((low[pair] + high[pair] + 1 - width) // 2, 0), columns - width)
        for r in range(starts[pair], starts[pair + 1]):
            first[r] = at
    return first, width


@inner_njit(cache=True, error_model="numpy", nogil=True)
def _missed(window, gap, lever, rotation, force, displacement, harmless, expected):  # type: ignore[no-untyped-def]
    """Whether cells beyond the window penetrate by more than rounding or `harmless` times the greatest force.

    These are then `expected` in contact, with those under force.
    """
    rows, columns = gap.shape
    strongest, deepest, found = 0.0, 0.0, False
    for r in range(rows):
        for c in range(columns):
            strongest, deepest = max(strongest, force[r, c]), max(deepest, displacement[r, c])
    overlap = max(harmless * strongest, _ROUNDING * deepest)
    for r in range(rows):
        stop = window.first[r] + window.columns
        for c in range(columns):
            out = (c < window.first[r]) | (c >= stop)
            pierced = out & (gap[r, c] + displacement[r, c] - lever[r] * rotation < -overlap)
            expected[r, c] = pierced | (force[r, c] > 0.0)
            found |= pierced
    return found


@inner_njit(cache=True, error_model="numpy")
def _inside(window, values, out):  # type: ignore[no-untyped-def]
    """Values of all cells in the window."""
    for r in range(values.shape[0]):
        for c in range(window.columns):
            out[r, c] = values[r, window.first[r] + c]


@inner_njit(cache=True, error_model="numpy")
def _everywhere(window, values, out):  # type: ignore[no-untyped-def]
    """Values of all cells from those in the window, zero beyond."""
    for r in range(out.shape[0]):
        for c in range(out.shape[1]):
            out[r, c] = 0.0
        for c in range(window.columns):
            out[r, window.first[r] + c] = values[r, c]


@inner_njit(cache=True, error_model="numpy")
def _rising_arms(lever, window, torque, pressure, arms):  # type: ignore[no-untyped-def]
    """Lever arm of every cell in the window, and forces scaled to bear the torque."""
    total = 0.0
    for r in range(lever.shape[0]):
        for c in range(window.columns):
            arms[r, c] = lever[r]
            total += lever[r] * pressure[r, c]
    for r in range(lever.shape[0]):
        for c in range(window.columns):
            pressure[r, c] *= torque / total


@njit(cache=True, error_model="numpy", nogil=True, fastmath={"reassoc", "contract"})
def _solve(system, inside, entire, work, window, gap, lever, torque, tolerance, most, force, displacement):  # type: ignore[no-untyped-def]
    """Forces on the cells of a window, started from `force`, and the displacement of all cells.

    The iterations of `solve_complementarity`, in double precision throughout: the transforms of a window are short.

    Returns
    -------
    status : int
        Number of the `ComplementarityStatus`.
    rotation : float [rad]
    iterations : int
    error : float
    """
    shape = gap.shape[0], window.columns
    across, arms, closed, pressure, opening = (
        np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape),
    )  # fmt: skip
    _inside(window, system.across, across)
    _inside(window, gap, opening)
    _inside(window, force, pressure)
    _rising_arms(lever, window, torque, pressure, arms)
    displace(system, inside, work, across, pressure, closed)
    kept, free = row_preconditioner(shape[0], shape[1]), np.empty(shape, dtype=np.bool_)
    residual, last_residual, step = np.zeros(shape), np.zeros(shape), np.empty(shape)
    search, move, image = np.zeros(shape), np.empty(shape), np.empty(shape)
    arm, p, u, g = arms.reshape(-1), pressure.reshape(-1), closed.reshape(-1), opening.reshape(-1)
    iteration, last_product, reach, exact, rotation = 0, 0.0, FIRST_REACH, False, 0.0
    while True:
        rotation = separation_left(p, u, g, 1.0, arm, True, rotation, free.reshape(-1), residual.reshape(-1))
        precondition(kept, system, residual, free, step)
        product, size, pressed = search_direction(
            step.reshape(-1), residual.reshape(-1), last_residual.reshape(-1), last_product, p, 1.0, arm, True,
            free.reshape(-1), search.reshape(-1),
        )  # fmt: skip
        error, small, status = judged(size, pressed, tolerance, exact, iteration >= most)
        if status == GOES_ON and not small:
            work_done, cut, reach = downhill_change(
                p, search.reshape(-1), step.reshape(-1), residual.reshape(-1), product, reach, 1.0, arm, True, torque,
                move.reshape(-1),
            )  # fmt: skip
            iteration += 1
            if work_done > 0.0:
                displace(system, inside, work, across, move, image)
                reach = advance(
                    p, u, move.reshape(-1), image.reshape(-1), work_done, cut, reach, 1.0, arm, True, torque
                )
                if reach > 0.0:
                    residual, last_residual = last_residual, residual
                    exact, last_product = False, product
                    continue
                status = NOT_POSITIVE
            elif exact:  # what is left is rounding
                status = NOT_CONVERGED
            else:
                reach = FIRST_REACH
        if not exact:
            _everywhere(window, pressure, force)
            displace(system, entire, work, system.across, force, displacement)
            _inside(window, displacement, closed)
            exact, last_product = True, 0.0
        if status != GOES_ON:
            return status, rotation, iteration, error
