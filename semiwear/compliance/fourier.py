"""Convolution of a real grid with a kernel that is even along both axes, by dedicated Fourier transforms.

Several columns (or frequencies) are transformed at once, in the vector lanes of the processor; two real columns make
a complex one. A grid padded with zeros to twice its size has its even frequencies from the grid itself and its odd
ones from the grid turned by half a step, so that no operations on zeros are needed. With real factors the inverse
transform is the forward one with real and imaginary parts swapped.

Complex lanes lie in flat arrays, real parts before imaginary ones: element k starts at 2 k lanes.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import DTypeLike, NDArray

from semiwear.arrays import FloatArray, IntArray
from semiwear.compliance.lanes import lane_count, lanes_of, load, store
from semiwear.kernel_cache import ZERO, njit

_COS_72, _SIN_72 = -0.25 + 5**0.5 / 4, (0.625 + 5**0.5 / 8) ** 0.5
_COS_144, _SIN_144 = -0.25 - 5**0.5 / 4, (0.625 - 5**0.5 / 8) ** 0.5
_SIN_60 = 0.75**0.5
_BUFFERS = 6


@lru_cache(maxsize=64)
def half_steps(n: int, dtype: DTypeLike) -> NDArray[np.floating]:
    """Cosine and sine of -pi k / n, k < 2 n, for a transform of n cells, a product of 2, 3 and 5."""
    angle = -np.pi * np.arange(2 * n) / n
    turn = np.stack([np.cos(angle), np.sin(angle)], axis=1).astype(dtype)
    turn.flags.writeable = False
    return turn


def frequencies(n: int, padded: bool) -> IntArray:
    """Frequencies of a real axis of n cells in the order in which `convolve` keeps them; of 2 n cells if padded."""
    if not padded:
        return np.arange(n // 2 + 1)
    return np.concatenate([np.arange(0, n + 1, 2), np.arange(1, n + 1, 2)])


def in_lanes(factors: FloatArray, shape: tuple[int, int], padded: bool, dtype: DTypeLike) -> NDArray[np.floating]:
    """Factors in the order of `convolve`.

    Parameters
    ----------
    factors : (fx, fy) array
        Real spectrum of the kernel for the frequencies 0 .. n/2 of both axes, with the transform's division.
    shape : (px, py)
        Cells of the grid, without padding.
    padded : bool
    dtype : type
    """
    lanes, parts = lane_count(dtype), 2 if padded else 1
    along_x = frequencies(shape[0], padded)
    # the other half of each part mirrors it
    along_y = np.concatenate([np.arange(part, shape[1] * parts // 2 + 1, parts) for part in range(parts)])
    blocks = -(-along_x.size // lanes)
    ordered = np.zeros((blocks, along_y.size, lanes), dtype)
    for block, into in enumerate(ordered):  # block by block, which takes no extra memory
        rows = along_x[block * lanes : (block + 1) * lanes]
        into[:, : rows.size] = 0.5 * factors[rows[:, None], along_y].T  # two columns from one take a half
    return ordered.ravel()


def work_size(shape: tuple[int, int], dtype: DTypeLike) -> tuple[int, int, int]:
    """Work space of `convolve` for a grid of px x py cells, in numbers: total, of the spectrum, and of a buffer."""
    block = 2 * lane_count(dtype)
    spectrum, buffer = (shape[0] + 1) * (2 * -(-shape[1] // block) + 1) * block, max(shape) * block
    return spectrum + _BUFFERS * buffer, spectrum, buffer


@njit(cache=True, error_model="numpy")
def _put(target, at, real, imaginary, turn, k):  # type: ignore[no-untyped-def]
    """Store a number turned by the k-th angle."""
    lanes = lanes_of(target)
    c, s = turn[k, 0], turn[k, 1]
    store(target, at, real * c - imaginary * s)
    store(target, at + lanes, real * s + imaginary * c)


@njit(cache=True, error_model="numpy")
def _stage_2(source, target, turn, m, stride):  # type: ignore[no-untyped-def]
    lanes = lanes_of(source)
    far, hop = m * stride * 2 * lanes, stride * 2 * lanes
    for p in range(m):
        for q in range(stride):
            i, o, k = (q + stride * p) * 2 * lanes, (q + 2 * stride * p) * 2 * lanes, 2 * p * stride
            r0, i0 = load(source, i, source), load(source, i + lanes, source)
            r1, i1 = load(source, i + far, source), load(source, i + far + lanes, source)
            store(target, o, r0 + r1)
            store(target, o + lanes, i0 + i1)
            _put(target, o + hop, r0 - r1, i0 - i1, turn, k)


@njit(cache=True, error_model="numpy")
def _stage_3(source, target, turn, m, stride):  # type: ignore[no-untyped-def]
    lanes, kind = lanes_of(source), source.dtype.type
    far, hop = m * stride * 2 * lanes, stride * 2 * lanes
    half, sine = kind(0.5), kind(_SIN_60)
    for p in range(m):
        for q in range(stride):
            i, o, k = (q + stride * p) * 2 * lanes, (q + 3 * stride * p) * 2 * lanes, 2 * p * stride
            r0, i0 = load(source, i, source), load(source, i + lanes, source)
            r1, i1 = load(source, i + far, source), load(source, i + far + lanes, source)
            r2, i2 = load(source, i + 2 * far, source), load(source, i + 2 * far + lanes, source)
            ar, ai, br, bi = r1 + r2, i1 + i2, (r1 - r2) * sine, (i1 - i2) * sine
            store(target, o, r0 + ar)
            store(target, o + lanes, i0 + ai)
            cr, ci = r0 - ar * half, i0 - ai * half
            _put(target, o + hop, cr + bi, ci - br, turn, k)
            _put(target, o + 2 * hop, cr - bi, ci + br, turn, 2 * k)


@njit(cache=True, error_model="numpy")
def _stage_4(source, target, turn, m, stride):  # type: ignore[no-untyped-def]
    lanes = lanes_of(source)
    far, hop = m * stride * 2 * lanes, stride * 2 * lanes
    for p in range(m):
        for q in range(stride):
            i, o, k = (q + stride * p) * 2 * lanes, (q + 4 * stride * p) * 2 * lanes, 2 * p * stride
            r0, i0 = load(source, i, source), load(source, i + lanes, source)
            r1, i1 = load(source, i + far, source), load(source, i + far + lanes, source)
            r2, i2 = load(source, i + 2 * far, source), load(source, i + 2 * far + lanes, source)
            r3, i3 = load(source, i + 3 * far, source), load(source, i + 3 * far + lanes, source)
            ar, ai, br, bi = r0 + r2, i0 + i2, r0 - r2, i0 - i2
            cr, ci, dr, di = r1 + r3, i1 + i3, r1 - r3, i1 - i3
            store(target, o, ar + cr)
            store(target, o + lanes, ai + ci)
            _put(target, o + hop, br + di, bi - dr, turn, k)
            _put(target, o + 2 * hop, ar - cr, ai - ci, turn, 2 * k)
            _put(target, o + 3 * hop, br - di, bi + dr, turn, 3 * k)


@njit(cache=True, error_model="numpy")
def _stage_5(source, target, turn, m, stride):  # type: ignore[no-untyped-def]
    lanes, kind = lanes_of(source), source.dtype.type
    far, hop = m * stride * 2 * lanes, stride * 2 * lanes
    c1, s1, c2, s2 = kind(_COS_72), kind(_SIN_72), kind(_COS_144), kind(_SIN_144)
    for p in range(m):
        for q in range(stride):
            i, o, k = (q + stride * p) * 2 * lanes, (q + 5 * stride * p) * 2 * lanes, 2 * p * stride
            r0, i0 = load(source, i, source), load(source, i + lanes, source)
            r1, i1 = load(source, i + far, source), load(source, i + far + lanes, source)
            r2, i2 = load(source, i + 2 * far, source), load(source, i + 2 * far + lanes, source)
            r3, i3 = load(source, i + 3 * far, source), load(source, i + 3 * far + lanes, source)
            r4, i4 = load(source, i + 4 * far, source), load(source, i + 4 * far + lanes, source)
            ar, ai, br, bi = r1 + r4, i1 + i4, r1 - r4, i1 - i4
            cr, ci, dr, di = r2 + r3, i2 + i3, r2 - r3, i2 - i3
            store(target, o, r0 + ar + cr)
            store(target, o + lanes, i0 + ai + ci)
            er, ei, fr, fi = r0 + ar * c1 + cr * c2, i0 + ai * c1 + ci * c2, br * s1 + dr * s2, bi * s1 + di * s2
            _put(target, o + hop, er + fi, ei - fr, turn, k)
            _put(target, o + 4 * hop, er - fi, ei + fr, turn, 4 * k)
            er, ei, fr, fi = r0 + ar * c2 + cr * c1, i0 + ai * c2 + ci * c1, br * s2 - dr * s1, bi * s2 - di * s1
            _put(target, o + 2 * hop, er + fi, ei - fr, turn, 2 * k)
            _put(target, o + 3 * hop, er - fi, ei + fr, turn, 3 * k)


@njit(cache=True, error_model="numpy")
def _transform(source, one, other, turn):  # type: ignore[no-untyped-def]
    """Fourier transform (Stockham) of complex lanes; one or other of the two buffers, source is kept."""
    n, stride = turn.shape[0] // 2, ZERO + 1
    if n == 1:
        for k in range(2 * lanes_of(one)):
            one[k] = source[k]
        return one
    now, then, first = source, one, True
    while n > 1:
        if n % 4 == 0:
            n, radix = n // 4, 4
            _stage_4(now, then, turn, n, stride)
        elif n % 2 == 0:
            n, radix = n // 2, 2
            _stage_2(now, then, turn, n, stride)
        elif n % 3 == 0:
            n, radix = n // 3, 3
            _stage_3(now, then, turn, n, stride)
        else:
            n, radix = n // 5, 5
            _stage_5(now, then, turn, n, stride)
        stride *= radix
        now, then, first = then, other if first else now, False
    return now


@njit(cache=True, error_model="numpy")
def _turn_half_a_step(values, turn, count):  # type: ignore[no-untyped-def]
    lanes = lanes_of(values)
    for k in range(count):
        at = 2 * k * lanes
        _put(values, at, load(values, at, values), load(values, at + lanes, values), turn, k)


@njit(cache=True, error_model="numpy")
def _add_turned_back(total, values, turn, count):  # type: ignore[no-untyped-def]
    """Both are swapped, so that turning back is turning."""
    lanes = lanes_of(values)
    for k in range(count):
        at, c, s = 2 * k * lanes, turn[k, 0], turn[k, 1]
        r, i = load(values, at, values), load(values, at + lanes, values)
        store(total, at, load(total, at, total) + r * c - i * s)
        store(total, at + lanes, load(total, at + lanes, total) + r * s + i * c)


@njit(cache=True, error_model="numpy")
def _scale_and_swap(values, factors, at, n, odd):  # type: ignore[no-untyped-def]
    """Multiply by factors that are the same for a frequency and its negative; returns how many were read."""
    lanes = lanes_of(values)
    count = (n + 1) // 2 if odd else n // 2 + 1
    for k in range(count):
        factor = load(factors, at + k * lanes, values)
        far = n - 1 - k if odd else (n - k) % n
        r, i = load(values, 2 * k * lanes, values) * factor, load(values, (2 * k + 1) * lanes, values) * factor
        x, y = load(values, 2 * far * lanes, values) * factor, load(values, (2 * far + 1) * lanes, values) * factor
        store(values, 2 * k * lanes, i)
        store(values, (2 * k + 1) * lanes, r)
        store(values, 2 * far * lanes, y)
        store(values, (2 * far + 1) * lanes, x)
    return count


@njit(cache=True, error_model="numpy")
def _split(values, n, odd, spectrum, row, width, column):  # type: ignore[no-untyped-def]
    """Spectra (twice) of the two real columns that make a complex one, into rows of the grid's spectrum."""
    lanes = lanes_of(values)
    for k in range((n + 1) // 2 if odd else n // 2 + 1):
        far = n - 1 - k if odd else (n - k) % n
        at = (row + k) * (2 * width + 2 * lanes) + column
        r, i = load(values, 2 * k * lanes, values), load(values, (2 * k + 1) * lanes, values)
        x, y = load(values, 2 * far * lanes, values), load(values, (2 * far + 1) * lanes, values)
        store(spectrum, at, r + x)
        store(spectrum, at + width, i - y)
        store(spectrum, at + lanes, i + y)
        store(spectrum, at + width + lanes, x - r)


@njit(cache=True, error_model="numpy")
def _join(values, n, odd, spectrum, row, width, column):  # type: ignore[no-untyped-def]
    """Inverse of `_split`, swapped."""
    lanes = lanes_of(values)
    for k in range((n + 1) // 2 if odd else n // 2 + 1):
        far = n - 1 - k if odd else (n - k) % n
        at = (row + k) * (2 * width + 2 * lanes) + column
        ar, ai = load(spectrum, at, values), load(spectrum, at + width, values)
        br, bi = load(spectrum, at + lanes, values), load(spectrum, at + width + lanes, values)
        store(values, 2 * far * lanes, br - ai)
        store(values, (2 * far + 1) * lanes, ar + bi)
        store(values, 2 * k * lanes, br + ai)
        store(values, (2 * k + 1) * lanes, ar - bi)


@njit(cache=True, error_model="numpy")
def _columns_forward(grid, padded, turn, spectrum, width, buffers):  # type: ignore[no-untyped-def]
    (nx, ny), n, lanes = grid.shape, turn.shape[0] // 2, lanes_of(spectrum)
    flat, values = grid.reshape(-1), buffers[0]
    for k in range(2 * nx * lanes, 2 * n * lanes):
        values[k] = 0.0
    for column in range(0, ny, 2 * lanes):
        if column + 2 * lanes <= ny:
            for i in range(nx):
                store(values, 2 * i * lanes, load(flat, i * ny + column, values))
                store(values, (2 * i + 1) * lanes, load(flat, i * ny + column + lanes, values))
        else:
            for i in range(nx):
                for j in range(2 * lanes):
                    values[2 * i * lanes + j] = grid[i, column + j] if column + j < ny else 0.0
        _split(_transform(values, buffers[1], buffers[2], turn), n, False, spectrum, ZERO, width, column)
        if padded:
            _turn_half_a_step(values, turn, nx)
            _split(_transform(values, buffers[1], buffers[2], turn), n, True, spectrum, n // 2 + 1, width, column)


@njit(cache=True, error_model="numpy")
def _rows(ny, rows, padded, factors, turn, spectrum, width, buffers):  # type: ignore[no-untyped-def]
    """Forward and back along the rows of the spectrum, with the factors in between."""
    n, lanes, values = turn.shape[0] // 2, lanes_of(spectrum), buffers[0]
    at = ZERO
    for first in range(0, rows, lanes):
        count = min(lanes, rows - first)
        for lane in range(count):
            row = (first + lane) * (2 * width + 2 * lanes)
            for j in range(ny):
                values[2 * j * lanes + lane] = spectrum[row + j]
                values[(2 * j + 1) * lanes + lane] = spectrum[row + width + j]
        for k in range(2 * ny * lanes, 2 * n * lanes):
            values[k] = 0.0
        waves = _transform(values, buffers[1], buffers[2], turn)
        at += _scale_and_swap(waves, factors, at, n, False) * lanes
        result = _transform(waves, buffers[3], buffers[4], turn)
        if padded:
            _turn_half_a_step(values, turn, ny)
            waves = _transform(values, buffers[1], buffers[2], turn)
            at += _scale_and_swap(waves, factors, at, n, True) * lanes
            _add_turned_back(result, _transform(waves, buffers[0], buffers[5], turn), turn, ny)
        for lane in range(count):
            row = (first + lane) * (2 * width + 2 * lanes)
            for j in range(ny):
                spectrum[row + j] = result[(2 * j + 1) * lanes + lane]
                spectrum[row + width + j] = result[2 * j * lanes + lane]


@njit(cache=True, error_model="numpy")
def _columns_back(result, padded, turn, spectrum, width, buffers):  # type: ignore[no-untyped-def]
    (nx, ny), n, lanes = result.shape, turn.shape[0] // 2, lanes_of(spectrum)
    flat, values = result.reshape(-1), buffers[0]
    for column in range(0, ny, 2 * lanes):
        _join(values, n, False, spectrum, ZERO, width, column)
        total = _transform(values, buffers[1], buffers[2], turn)
        if padded:
            _join(values, n, True, spectrum, n // 2 + 1, width, column)
            _add_turned_back(total, _transform(values, buffers[3], buffers[4], turn), turn, nx)
        if column + 2 * lanes <= ny:
            for i in range(nx):
                store(flat, i * ny + column, load(total, (2 * i + 1) * lanes, total))
                store(flat, i * ny + column + lanes, load(total, 2 * i * lanes, total))
        else:
            for i in range(nx):
                for j in range(ny - column):
                    lane = j + lanes if j < lanes else j - lanes
                    result[i, column + j] = total[2 * i * lanes + lane]


@njit(cache=True, error_model="numpy")
def convolve(grid, result, factors, padded, turn_x, turn_y, work, spectrum_size, buffer_size):  # type: ignore[no-untyped-def]
    """Convolution of a grid, written to `result`, in the precision of the work space.

    Parameters
    ----------
    grid, result : (nx, ny) contiguous arrays
        At most as large as the axes; the rest counts as zero and is not written.
    factors : array
        From `in_lanes`.
    padded : bool
        True for the convolution in free space, False for the periodic one.
    turn_x, turn_y : arrays
        From `half_steps`.
    work : array
    spectrum_size, buffer_size : int
        See `work_size`.
    """
    spectrum, ny = work[:spectrum_size], grid.shape[1]
    buffers = work[spectrum_size : spectrum_size + _BUFFERS * buffer_size].reshape(_BUFFERS, buffer_size)
    block, px = 2 * lanes_of(work), turn_x.shape[0] // 2
    width = (ny + block - 1) // block * block
    _columns_forward(grid, padded, turn_x, spectrum, width, buffers)
    _rows(ny, px + 1 if padded else px // 2 + 1, padded, factors, turn_y, spectrum, width, buffers)
    _columns_back(result, padded, turn_x, spectrum, width, buffers)
