"""Pressures to start from: from a coarser grid to a finer one, and from two positions to the next.

Near the edge of a smooth contact the pressure varies as the square root of the distance (Johnson 1985, sec. 5.1).
Its square ends with a slope, so that interpolation and extrapolation of the square find the edge between cells.
"""

from __future__ import annotations

import numpy as np

from semiwear.kernel_cache import njit

_SHIFT = 4  # cells by which an edge may move from one position to the next within the extrapolation


@njit(cache=True, error_model="numpy")
def coarsen(gap, allowed, along_x, along_y):  # type: ignore[no-untyped-def]
    """Mean gap of the allowed cells in blocks of two (along_x, along_y: 1 or 2 cells); False where there is none.

    The gap is zero where it is not allowed.
    """
    nx, ny = gap.shape
    mx, my = (nx + along_x - 1) // along_x, (ny + along_y - 1) // along_y
    mean, some = np.zeros((mx, my)), np.zeros((mx, my), dtype=np.bool_)
    count, total = np.empty(ny, dtype=np.int8), np.empty(ny)
    for i in range(mx):
        k, last = i * along_x, min((i + 1) * along_x, nx) - 1
        for j in range(ny):
            total[j] = gap[k, j] + gap[last, j]
            count[j] = np.int8(allowed[k, j]) + np.int8(allowed[last, j])
        for j in range(my):
            m, far = j * along_y, min((j + 1) * along_y, ny) - 1
            number = count[m] + count[far]  # a cell alone counts twice in its block
            mean[i, j] = (total[m] + total[far]) / max(number, 1)
            some[i, j] = number > 0
    return mean, some


@njit(cache=True, error_model="numpy")
def _beyond_the_edge(pressure, cells):  # type: ignore[no-untyped-def]
    """Squared pressure, continued as a straight line (negative) for some cells beyond the edge of the contact."""
    nx, ny = pressure.shape
    result = pressure * pressure
    for _ in range(cells):
        known = result.copy()
        for i in range(nx):
            for j in range(ny):
                if known[i, j] != 0.0:
                    continue
                total, count = 0.0, 0
                for step_x, step_y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                    k, m = i + step_x, j + step_y
                    far_k, far_m = k + step_x, m + step_y
                    if 0 <= far_k < nx and 0 <= far_m < ny and known[k, m] != 0.0 and known[far_k, far_m] != 0.0:
                        count += 1
                        total += min(2.0 * known[k, m] - known[far_k, far_m], 0.0)
                if count > 0:
                    result[i, j] = total / count
    return result


@njit(cache=True, error_model="numpy")
def refine_pressure(coarse, nx, ny, along_x, along_y, allowed):  # type: ignore[no-untyped-def]
    """Pressure on the finer grid: its square is interpolated linearly."""
    square = _beyond_the_edge(coarse, 1)
    mx, my = coarse.shape
    row = np.empty(my)
    result = np.zeros((nx, ny))
    for i in range(nx):
        k = i // along_x
        k_next = min(max(k + (2 * (i % 2) - 1 if along_x == 2 else 0), 0), mx - 1)
        first, last = my, -1
        for m in range(my):
            row[m] = 0.75 * square[k, m] + 0.25 * square[k_next, m]
            if row[m] > 0.0:
                first, last = min(first, m), m
        for j in range(max(first - 1, 0) * along_y, min(last + 2, my) * along_y if last >= 0 else 0):
            if j >= ny:
                break
            m = j // along_y
            m_next = min(max(m + (2 * (j % 2) - 1 if along_y == 2 else 0), 0), my - 1)
            value = 0.75 * row[m] + 0.25 * row[m_next]
            if value > 0.0 and allowed[i, j]:
                result[i, j] = np.sqrt(value)
    return result


@njit(cache=True, error_model="numpy")
def extrapolate_pressure(previous, before):  # type: ignore[no-untyped-def]
    """Pressure extrapolated from the last two, linearly in its square."""
    now, past = _beyond_the_edge(previous, _SHIFT), _beyond_the_edge(before, _SHIFT)
    nx, ny = now.shape
    result = np.zeros((nx, ny))
    for i in range(nx):
        for j in range(ny):
            square = 2.0 * now[i, j] - past[i, j]
            if now[i, j] != 0.0 and square > 0.0:
                result[i, j] = np.sqrt(square)
    return result
