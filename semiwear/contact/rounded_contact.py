"""Contact of a few points that come to bear by and by, for results that are differentiated.

Where a point begins to press, its force F and its separation s change over with a corner, and with them the slopes of
all that depends on them. A slice of a contact line has a length: where the gap varies along it, it begins to bear at
one end. With a gap that varies by +-d, and layers that yield by c F, this makes

    sqrt(s/d) + sqrt(F/f) = 1   (s <= d, F <= f = d/c)

in place of s = 0 or F = 0: a parabola that touches both. The points of this curve, straight on at its ends, are those
of one number t,

    F = 0, s = d (1 - 2 t)  for t <= 0;   F = f t^2, s = d (1 - t)^2;   F = f (2 t - 1), s = 0  for t >= 1,

with slopes that change continuously. Newton's method in t therefore ends in a few steps.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from semiwear.contact.active_set import ActiveSetStatus, cholesky_solve, separate, substitute
from semiwear.kernel_cache import inner_njit

__all__ = ["Rounding", "rounded_from", "solve_rounded"]

_STEPS = 60
_FREELY = 20  # steps; then half of each
_SLOWLY = 0.1  # of the residual: what a step by an old factor has to bring it down to

_CONVERGED, _NO_CONTACT_SET = int(ActiveSetStatus.CONVERGED), int(ActiveSetStatus.NO_CONTACT_SET)
_NOT_POSITIVE_DEFINITE = int(ActiveSetStatus.NOT_POSITIVE_DEFINITE)


class Rounding(NamedTuple):
    """How slices of contact lines come to bear; in kernels None where they bear from where they touch.

    Attributes
    ----------
    depth : float [mm]
        Separation from which a slice comes to bear.
    load : float [N/mm]
        Line load from which it bears as without rounding.
    """

    depth: float
    load: float


@inner_njit(cache=True, error_model="numpy")
def rounded_from(rounding):  # type: ignore[no-untyped-def]
    """Separation from which a slice comes to bear [mm]; only what is needed of the two is compiled."""
    if rounding is None:
        return 0.0
    return rounding.depth


@inner_njit(cache=True, error_model="numpy")
def _joins(slack, compliance, depth, full):  # type: ignore[no-untyped-def]
    """Force on a point by itself that bears nothing yet and is nearer than the depth."""
    near, stiff = 1.0 - slack / depth, compliance * full / depth
    t = near / (1.0 + sqrt(max(1.0 - (1.0 - stiff) * near, 0.0)))
    return full * min(t, 1.0) ** 2


@inner_njit(cache=True, error_model="numpy")
def _moved(force, change, full):  # type: ignore[no-untyped-def]
    """Force after a change that is linear in t."""
    t = sqrt(force / full) if force < full else 0.5 * (force / full + 1.0)
    t += change / (2.0 * full * min(t, 1.0))
    if t <= 0.0:
        return 0.0
    return full * t * t if t < 1.0 else full * (2.0 * t - 1.0)


@inner_njit(cache=True, error_model="numpy")
def _residuals(matrix, gap, lever, full, depth, approach, force, slack):  # type: ignore[no-untyped-def]
    """Separations less those of the curve, in `slack`, of points that bear or come to do so; the greatest one."""
    separate(matrix, gap, lever, approach, force, slack)
    worst = 0.0
    for i in range(gap.shape[0]):
        if force[i] <= 0.0 and slack[i] < depth:
            force[i] = _joins(slack[i], matrix[i, i], depth, full[i])
            worst = depth  # another set of points
    if worst > 0.0:
        separate(matrix, gap, lever, approach, force, slack)
    for i in range(gap.shape[0]):
        if force[i] > 0.0:
            if force[i] < full[i]:
                slack[i] -= depth * (1.0 - sqrt(force[i] / full[i])) ** 2
            worst = max(worst, abs(slack[i]))
    return worst


@inner_njit(cache=True, error_model="numpy")
def _factored(work, matrix, lever, full, depth, force):  # type: ignore[no-untyped-def]
    """Factor of the compliance between points that bear, each with that of the curve; False if not positive."""
    a, on, count = work.factor, work.points, 0
    for i in range(force.shape[0]):
        if force[i] > 0.0:
            on[count] = i
            count += 1
    work.pressed[0] = count
    for i in range(count):
        for j in range(i + 1):
            a[i, j] = matrix[on[i], on[j]]
        t = sqrt(force[on[i]] / full[on[i]])
        if t < 1.0:
            a[i, i] += depth / full[on[i]] * (1.0 - t) / t
        work.closing[i], work.response[i] = 0.0, lever[on[i]]
    return cholesky_solve(a, count, work.closing, work.response)


@inner_njit(cache=True, error_model="numpy")
def _same_points(work, force):  # type: ignore[no-untyped-def]
    """Whether the points that bear are those of the factor."""
    count = 0
    for i in range(force.shape[0]):
        if force[i] > 0.0:
            if count >= work.pressed[0] or work.points[count] != i:
                return False
            count += 1
    return count == work.pressed[0]


@inner_njit(cache=True, error_model="numpy")
def _changes(work, lever, missing, slack):  # type: ignore[no-untyped-def]
    """Forces that close what is left of the separations, in `work`, and the turn that bears what is missing."""
    count, stiffness = work.pressed[0], 0.0
    for i in range(count):
        work.closing[i] = -slack[work.points[i]]
    substitute(work.factor, count, work.closing)
    for i in range(count):
        missing -= lever[work.points[i]] * work.closing[i]
        stiffness += lever[work.points[i]] * work.response[i]
    return missing / stiffness


@inner_njit(cache=True, error_model="numpy")
def solve_rounded(work, known, matrix, gap, lever, full, depth, load, closed, approach, force, slack):  # type: ignore[no-untyped-def]
    """Forces and approach under a load, from those of a contact with corners or of one like it.

    Parameters
    ----------
    work : ActiveSetWork
    known : bool
        Whether its factor is that of a contact like this one, rounded as well.
    matrix : (n, n) array [mm/N]
        Symmetric, positive definite.
    gap, lever : (n,) arrays [mm]
    full : (n,) array [N]
        Forces from which points bear as without rounding.
    depth : float [mm]
        Separation from which they begin to.
    load : float [N mm]
        Sum of lever times force.
    closed : float
        Residual separation over the approach, and missing load over the load, at the end.
    approach : float [rad]
    force : (n,) array [N], changed
    slack : (n,) array [mm], changed
        Separations, less those of the curve where points bear.

    Returns
    -------
    status : int
        `ActiveSetStatus`.
    approach : float [rad]
    """
    last = 0.0
    for step in range(_STEPS):
        worst, missing, farthest = _residuals(matrix, gap, lever, full, depth, approach, force, slack), load, 0.0
        for i in range(gap.shape[0]):
            missing -= lever[i] * force[i]
            if force[i] > 0.0:
                farthest = max(farthest, abs(lever[i] * approach))
        worst = max(worst / farthest, abs(missing) / load)
        if worst <= closed:
            return _CONVERGED, approach
        if not (known and _same_points(work, force)) or (step > 0 and worst > _SLOWLY * last):
            if not _factored(work, matrix, lever, full, depth, force):
                return _NOT_POSITIVE_DEFINITE, approach
            known = True
        last = worst
        if work.pressed[0] == 0:
            return _NO_CONTACT_SET, approach
        turn, share = _changes(work, lever, missing, slack), 1.0 if step < _FREELY else 0.5
        for i in range(work.pressed[0]):
            p = work.points[i]
            force[p] = _moved(force[p], share * (work.closing[i] + turn * work.response[i]), full[p])
        approach += share * turn
    return _NO_CONTACT_SET, approach
