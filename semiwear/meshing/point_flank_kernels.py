"""Inner loops of flanks given as points: values of a spline surface, and points of a flank on circles.

A surface is continued beyond its grid: by the polynomials of its outermost cells for a twentieth of its extent, which
is more than any difference quotient needs, and from there by its slopes and, where `bend` is 1, curvatures.
"""

from __future__ import annotations

import numpy as np

from semiwear.kernel_cache import njit

_BEYOND = 0.05  # of the extent, within which the outermost polynomials are used
_PASSES = 40
_LONGEST = 0.3  # step of the parameters in one pass
_CLOSE = 1e-13  # of the flank's size


@njit(cache=True, error_model="numpy")
def _cell(knots, x):  # type: ignore[no-untyped-def]
    """Cell of a parameter; the outermost cells extend beyond the grid."""
    last = knots.shape[0] - 2
    low = min(max(int(x * (last + 1)), 0), last)  # knots are about even
    while low > 0 and x < knots[low]:
        low -= 1
    while low < last and x >= knots[low + 1]:
        low += 1
    return low


@njit(cache=True, error_model="numpy")
def _surface(cells, knots_u, knots_v, u, v, bend, out):  # type: ignore[no-untyped-def]
    """Value and both slopes of three coordinates: rows of `out`."""
    inside_u = min(max(u, -_BEYOND), 1.0 + _BEYOND)
    inside_v = min(max(v, -_BEYOND), 1.0 + _BEYOND)
    far_u, far_v = u - inside_u, v - inside_v
    i, j = _cell(knots_u, inside_u), _cell(knots_v, inside_v)
    x, y = inside_u - knots_u[i], inside_v - knots_v[j]
    for c in range(3):
        a = cells[i, j, c]
        r0 = ((a[0, 0] * y + a[0, 1]) * y + a[0, 2]) * y + a[0, 3]
        r1 = ((a[1, 0] * y + a[1, 1]) * y + a[1, 2]) * y + a[1, 3]
        r2 = ((a[2, 0] * y + a[2, 1]) * y + a[2, 2]) * y + a[2, 3]
        r3 = ((a[3, 0] * y + a[3, 1]) * y + a[3, 2]) * y + a[3, 3]
        s0 = (3.0 * a[0, 0] * y + 2.0 * a[0, 1]) * y + a[0, 2]
        s1 = (3.0 * a[1, 0] * y + 2.0 * a[1, 1]) * y + a[1, 2]
        s2 = (3.0 * a[2, 0] * y + 2.0 * a[2, 1]) * y + a[2, 2]
        s3 = (3.0 * a[3, 0] * y + 2.0 * a[3, 1]) * y + a[3, 2]
        value = ((r0 * x + r1) * x + r2) * x + r3
        by_u = (3.0 * r0 * x + 2.0 * r1) * x + r2
        by_v = ((s0 * x + s1) * x + s2) * x + s3
        if far_u != 0.0 or far_v != 0.0:
            value += by_u * far_u + by_v * far_v
            if bend[c] != 0.0:
                by_uu = 6.0 * r0 * x + 2.0 * r1
                t0, t1 = 6.0 * a[0, 0] * y + 2.0 * a[0, 1], 6.0 * a[1, 0] * y + 2.0 * a[1, 1]
                t2, t3 = 6.0 * a[2, 0] * y + 2.0 * a[2, 1], 6.0 * a[3, 0] * y + 2.0 * a[3, 1]
                by_vv = ((t0 * x + t1) * x + t2) * x + t3
                value += bend[c] * 0.5 * (by_uu * far_u * far_u + by_vv * far_v * far_v)
                by_u += bend[c] * by_uu * far_u
                by_v += bend[c] * by_vv * far_v
        out[c, 0], out[c, 1], out[c, 2] = value, by_u, by_v


@njit(cache=True, error_model="numpy")
def surface_points(cells, knots_u, knots_v, u, v, out):  # type: ignore[no-untyped-def]
    """Values and slopes of three coordinates at n places: `out` is (n, 3, 3), see `_surface`."""
    bend = np.ones(3)
    for k in range(u.shape[0]):
        _surface(cells, knots_u, knots_v, u[k], v[k], bend, out[k])


@njit(cache=True, error_model="numpy")
def touch(cells, knots_u, knots_v, start, radius, axial, size, out):  # type: ignore[no-untyped-def]
    """Points of a flank in coordinates (radius, axial, polar angle) on circles about its axis.

    Parameters
    ----------
    cells, knots_u, knots_v
        The flank's splines, see `spline_cells`.
    start : (2, 3) array
        Affine guess: u and v from (1, radius, axial place).
    radius, axial : (n,) arrays [mm]
        The circles.
    size : float [mm]
        Of the flank.
    out : (n, 4) array
        Receives u, v, the flank's polar angle there, and its lever arm: approach along its normal per angle [mm].
    """
    bend = np.array([0.0, 0.0, 1.0])  # radius and axial place linear beyond: the equations stay solvable
    at = np.empty((3, 3))
    u, v, last_radius, last_axial = 0.5, 0.5, 0.0, 0.0
    for k in range(radius.shape[0]):
        r, z = radius[k], axial[k]
        near = k > 0 and abs(r - last_radius) + abs(z - last_axial) < 0.3 * size
        if near:  # neighbours have similar solutions
            u += start[0, 1] * (r - last_radius) + start[0, 2] * (z - last_axial)
            v += start[1, 1] * (r - last_radius) + start[1, 2] * (z - last_axial)
        else:
            u = start[0, 0] + start[0, 1] * r + start[0, 2] * z
            v = start[1, 0] + start[1, 1] * r + start[1, 2] * z
        for _ in range(_PASSES):
            _surface(cells, knots_u, knots_v, u, v, bend, at)
            off_r, off_z = r - at[0, 0], z - at[1, 0]
            if abs(off_r) + abs(off_z) < _CLOSE * size:
                break
            determinant = at[0, 1] * at[1, 2] - at[0, 2] * at[1, 1]
            step_u = (off_r * at[1, 2] - off_z * at[0, 2]) / determinant
            step_v = (off_z * at[0, 1] - off_r * at[1, 1]) / determinant
            longest = max(abs(step_u), abs(step_v))
            # far away the straight continuation gives the solution at once
            if longest > _LONGEST and -_LONGEST < u < 1.0 + _LONGEST and -_LONGEST < v < 1.0 + _LONGEST:
                step_u *= _LONGEST / longest
                step_v *= _LONGEST / longest
            u += step_u
            v += step_v
        last_radius, last_axial = r, z
        _surface(cells, knots_u, knots_v, u, v, bend, at)
        around_u, around_v = r * at[2, 1], r * at[2, 2]
        n_r = around_u * at[1, 2] - at[1, 1] * around_v
        n_c = at[1, 1] * at[0, 2] - at[0, 1] * at[1, 2]
        n_z = at[0, 1] * around_v - around_u * at[0, 2]
        out[k, 0], out[k, 1], out[k, 2] = u, v, at[2, 0]
        out[k, 3] = r * abs(n_c) / np.sqrt(n_r * n_r + n_c * n_c + n_z * n_z)


@njit(cache=True, error_model="numpy")
def meet(own, normals, turn, driven_frame, driven_centre, driving_frame, driving_centre, position, normal, local):  # type: ignore[no-untyped-def]
    """Driven points turned about their own axis, in the fixed frame and in the driving body's.

    Parameters
    ----------
    own, normals : (n, 3) arrays
        In the driven body's own frame.
    turn : (n,) array [rad]
        About its z axis.
    driven_frame, driving_frame : (3, 3) arrays
        Columns: the bodies' own axes in the fixed frame.
    driven_centre, driving_centre : (3,) arrays [mm]
        Origins of the bodies' own frames.
    position, normal : (n, 3) arrays
        Receive points and normals in the fixed frame.
    local : (n, 3) array
        Receives radius, axial place and polar angle about the driving axis.
    """
    place = np.empty(3)
    for k in range(turn.shape[0]):
        c, s = np.cos(turn[k]), np.sin(turn[k])
        x, y, z = c * own[k, 0] - s * own[k, 1], s * own[k, 0] + c * own[k, 1], own[k, 2]
        a, b, d = c * normals[k, 0] - s * normals[k, 1], s * normals[k, 0] + c * normals[k, 1], normals[k, 2]
        for m in range(3):
            position[k, m] = (
                driven_centre[m] + driven_frame[m, 0] * x + driven_frame[m, 1] * y + driven_frame[m, 2] * z
            )
            normal[k, m] = driven_frame[m, 0] * a + driven_frame[m, 1] * b + driven_frame[m, 2] * d
            place[m] = position[k, m] - driving_centre[m]
        x = place[0] * driving_frame[0, 0] + place[1] * driving_frame[1, 0] + place[2] * driving_frame[2, 0]
        y = place[0] * driving_frame[0, 1] + place[1] * driving_frame[1, 1] + place[2] * driving_frame[2, 1]
        z = place[0] * driving_frame[0, 2] + place[1] * driving_frame[1, 2] + place[2] * driving_frame[2, 2]
        local[k, 0], local[k, 1], local[k, 2] = np.hypot(x, y), z, np.arctan2(y, x)
