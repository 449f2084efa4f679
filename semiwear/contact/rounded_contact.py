"""Contact of a few points that come into contact gradually, for results that are differentiated.

Where a point comes into contact, its force F against its separation s has a corner, and the slopes of all results
jump. A slice of a contact line has a length: where the gap varies along it, it comes into contact at one end. With a
gap that varies by +-d, and layers that yield by c F, this gives

    sqrt(s/d) + sqrt(F/f) = 1   (s <= d, F <= f = d/c)

in place of s = 0 or F = 0: a parabola that touches both. The curve, continued straight at its ends, is described
by a parameter t,

    F = 0, s = d (1 - 2 t)  for t <= 0;   F = f t^2, s = d (1 - t)^2;   F = f (2 t - 1), s = 0  for t >= 1,

with slopes that change continuously. Newton's method in t therefore ends in a few steps.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from semiwear.contact.active_set import ActiveSetStatus, cholesky_solve, separate, substitute
from semiwear.kernel_cache import inner_njit

_STEPS = 60
_FREELY = 20  # steps; later ones are halved
_SLOWLY = 0.1  # of the residual, to which a step with an old factor has to reduce it

_CONVERGED, _NO_CONTACT_SET = int(ActiveSetStatus.CONVERGED), int(ActiveSetStatus.NO_CONTACT_SET)
_NOT_POSITIVE_DEFINITE = int(ActiveSetStatus.NOT_POSITIVE_DEFINITE)


class Rounding(NamedTuple):
    """Gradual contact of slices of contact lines; None in kernels if they bear load as soon as they touch.

    Attributes
    ----------
    depth : float [mm]
        Separation from which a slice bears load.
    load : float [N/mm]
        Line load above which rounding has no effect.
    """

    depth: float
    load: float


@inner_njit(cache=True, error_model="numpy")
def rounded_from(rounding):  # type: ignore[no-untyped-def]
    """Separation from which a slice bears load [mm]; only the branch that is needed is compiled."""
    if rounding is None:
        return 0.0
    return rounding.depth


@inner_njit(cache=True, error_model="numpy")
def _joins(slack, compliance, depth, full):  # type: ignore[no-untyped-def]
    """Force on a single point without load that is nearer than the depth."""
    closed, stiff = 1.0 - slack / depth, compliance * full / depth
    t = closed / (1.0 + sqrt(max(1.0 - (1.0 - stiff) * closed, 0.0)))
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
    """Separations less those of the curve, in `slack`, of points under load or about to be; the greatest one."""
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
    """Factor of the compliance between loaded points, each with that of the curve; False if not positive."""
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
    """Whether the loaded points are those of the factor."""
    count = 0
    for i in range(force.shape[0]):
        if force[i] > 0.0:
            if count >= work.pressed[0] or work.points[count] != i:
                return False
            count += 1
    return count == work.pressed[0]


@inner_njit(cache=True, error_model="numpy")
def _changes(work, lever, missing, slack):  # type: ignore[no-untyped-def]
    """Forces that close the remaining separations, in `work`, and the rotation that bears the missing load."""
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
    """Forces and approach under a load, started from those of a sharp or a similar rounded contact.

    Parameters
    ----------
    work : ActiveSetWork
    known : bool
        Whether its factor is that of a similar contact, rounded as well.
    matrix : (n, n) array [mm/N]
        Symmetric, positive definite.
    gap, lever : (n,) arrays [mm]
    full : (n,) array [N]
        Forces above which rounding has no effect.
    depth : float [mm]
        Separation from which points bear load.
    load : float [N mm]
        Sum of lever times force.
    closed : float
        Residual separation over the approach, and missing load over the load, at the end.
    approach : float [rad]
    force : (n,) array [N], changed
    slack : (n,) array [mm], changed
        Separations, less those of the curve for loaded points.

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
        turn, part = _changes(work, lever, missing, slack), 1.0 if step < _FREELY else 0.5
        for i in range(work.pressed[0]):
            p = work.points[i]
            force[p] = _moved(force[p], part * (work.closing[i] + turn * work.response[i]), full[p])
        approach += part * turn
    return _NO_CONTACT_SET, approach
