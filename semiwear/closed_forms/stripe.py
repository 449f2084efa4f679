"""Displacement of an elastic half-space along a line contact of finite length, under a semi-elliptic stripe.

A line load with Hertz half-width b acts along its own line like the kernel

    K(s) = 1/(pi E*) 4/(pi b^2) sqrt(b^2 + s^2) [K(m) - E(m)],  m = b^2/(b^2 + s^2)

(complete elliptic integrals): the displacement at the middle of a semi-elliptic stripe of zero length, a
distance s along the line (integral of the point-load solution, Johnson 1985, eq. 3.22b, over the stripe).
Far away it is 1/(pi E* s); integrated over a long line it is the Hertz approach of line contact.
"""

from __future__ import annotations

from functools import lru_cache
from math import exp, log, pi

import numpy as np
from scipy.special import elliprd

from semiwear.arrays import FloatArray
from semiwear.kernel_cache import inner_njit

_TABLE_START = 0.01  # distance over half-width below which the logarithmic limit is used
_TABLE_END = 1000.0  # and beyond which the kernel is 1/s
_TABLE_NODES = 400
_LOG_START, _LOG_END = log(_TABLE_START), log(_TABLE_END)
_PER_LOG = (_TABLE_NODES - 1) / (_LOG_END - _LOG_START)


def stripe_kernel(distance: FloatArray) -> FloatArray:
    """Displacement along a line contact of half-width b that a force on a short piece of it causes, times pi E* b.

    The load is semi-elliptic across the line. At a distance s along it the displacement of its middle over the force
    is K(s), the integral of the displacement under a point load (Johnson 1985, eq. 3.22b):

        pi E* b K(s) = 4/pi sqrt(1 + t^2) [K(m) - E(m)],    t = s/b,    m = 1 / (1 + t^2)

    with the complete elliptic integrals; far away it is 1/t. By Carlson's integral,
    K(m) - E(m) = m/3 R_D(0, 1 - m, 1), which loses no digits there.

    Parameters
    ----------
    distance : array
        Distance over half-width, t = s/b, 0 or more; the kernel is infinite at 0.

    Returns
    -------
    array [1]
    """
    t = np.asarray(distance, float)
    root = np.hypot(1.0, t)
    sine = np.divide(t, root, out=np.ones_like(root), where=np.isfinite(root))
    return np.asarray(4.0 / (3.0 * pi) / root * elliprd(0.0, sine**2, 1.0))


@lru_cache(maxsize=1)
def stripe_table() -> FloatArray:
    """Integral of the kernel from 0 to s/b as cubics between nodes equal in ln(s/b), the constant first: (nodes, 4).

    The last one is the end of the table.
    """
    nodes = np.linspace(log(_TABLE_START), log(_TABLE_END), _TABLE_NODES)
    points, weights = np.polynomial.legendre.leggauss(8)
    half = 0.5 * (nodes[1] - nodes[0])
    inside = np.exp((nodes[:-1] + half)[:, None] + half * points)
    pieces = half * (stripe_kernel(inside) * inside) @ weights
    # from 0 to the first node: k behaves like ln t there; Gauss points in t^2 remove most of the singularity
    first = np.polynomial.legendre.leggauss(60)
    t = 0.5 * (first[0] + 1.0)
    start = float(np.sum(0.5 * first[1] * stripe_kernel(_TABLE_START * t**2) * _TABLE_START * 2.0 * t))
    values = start + np.concatenate([[0.0], np.cumsum(pieces)])
    at = np.exp(nodes)
    slopes = stripe_kernel(at) * at * (nodes[1] - nodes[0])
    rise, first, last = np.diff(values), slopes[:-1], slopes[1:]
    table = np.zeros((_TABLE_NODES, 4))
    table[:, 0], table[:-1, 1] = values, first
    table[:-1, 2], table[:-1, 3] = 3.0 * rise - 2.0 * first - last, first + last - 2.0 * rise
    return table


@inner_njit(cache=True, error_model="numpy")
def stripe_integral_to(logarithm, table):  # type: ignore[no-untyped-def]
    """Integral of the kernel from 0 to s/b by cubic Hermite in ln(s/b), from this logarithm."""
    if logarithm < _LOG_START:
        # scaled so that it meets the table
        return exp(logarithm) * (log(4.0) - logarithm) * (table[0, 0] / (_TABLE_START * (log(4.0) - _LOG_START)))
    if logarithm >= _LOG_END:
        return table[_TABLE_NODES - 1, 0] + (logarithm - _LOG_END)
    place = (logarithm - _LOG_START) * _PER_LOG
    k = min(int(place), _TABLE_NODES - 2)
    x = place - k
    return table[k, 0] + x * (table[k, 1] + x * (table[k, 2] + x * table[k, 3]))
