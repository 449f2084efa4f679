"""Cells of all tooth pairs that may touch at a mesh position: their compliance, and what preconditions it.

Forces f >= 0 on cells and one rotation phi of the driving body with

    gap + C f - a phi >= 0,   f (gap + C f - a phi) = 0,   sum of a f = torque

are what `complementarity` solves. C is the half-space under each pair, plus what one slice feels of another as a
whole (teeth, rims, wear). Cells free to change are preconditioned with the half-space of every slice by itself,
exact, and the coupling between slices as a whole, exact but for its shape across the line. That takes a handful of
convolutions, whatever the cells' width.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotrs

from semiwear.compliance.half_space import HalfSpace
from semiwear.contact.certificate import residuals_of
from semiwear.contact.complementarity import Complementarity, ComplementarityStatus, solve_complementarity

__all__ = ["PatchSystem", "RowPreconditioner", "SharedTorque", "share_torque"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_TOLERANCE = 1e-9  # relative L2 error of the forces: what is less differs with the last bit of a gap
_LEAST = 1e-12  # of what one cell would yield to the whole load: an approach that is none
_FIRST_DROP = 0.03  # of the residual, before the active set is looked at again
_FREE_SETS = 25  # active sets that change on both sides; then cells are only let go, and taken in one at a time
_SETTLED = 1e-7  # of the approach: residual of the cells that touch
_PIERCED = 1e-6  # of the approach: penetration from which on a cell is taken in
_EVEN_ACROSS = 0.6  # of a half-width: there a slice's displacement is about its mean over the next one's contact
_DEFINITE = 0.1  # least eigenvalue of the coupling of slices, when it has to be lifted


@dataclass(frozen=True)
class PatchSystem:
    """Compliance of rows of cells of several pairs, one after the other.

    Attributes
    ----------
    starts : (pairs + 1,) int array
        First row of each pair.
    half_spaces : tuple of HalfSpace
        One for each pair, per pressure.
    per_force : float [1/mm^2]
        Pressure of a unit force on a cell.
    smooth : (rows, rows) array [mm/N]
        What a row feels of another as a whole: tooth compliance less the half-space at the mid-surface, and wear.
    coefficients : (rows of the longest pair, columns) array [mm/N]
        Half-space influence of a unit force on a cell.
    """

    starts: IntArray
    half_spaces: tuple[HalfSpace, ...]
    per_force: float
    smooth: FloatArray
    coefficients: FloatArray

    def apply(self, force: FloatArray, *, roughly: bool = False) -> FloatArray:
        """C f [mm] for cell forces [N], (rows, columns); half-spaces in single precision if roughly."""
        out = np.empty_like(force)
        for half_space, start, stop in zip(self.half_spaces, self.starts[:-1], self.starts[1:], strict=True):
            out[start:stop] = half_space.apply(force[start:stop], roughly=roughly)
        out *= self.per_force
        out += (self.smooth @ force.sum(axis=1))[:, None]
        return out


@njit(cache=True, error_model="numpy")
def _factor_row(own, members, m, factor, ones):  # type: ignore[no-untyped-def]
    """Cholesky factor of m cells of a row, their response to an even displacement, and its sum."""
    total = 0.0
    for i in range(m):
        for j in range(i + 1):
            value = own[abs(members[i] - members[j])]
            for k in range(j):
                value -= factor[i, k] * factor[j, k]
            factor[i, j] = sqrt(value) if i == j else value / factor[j, j]
        value = 1.0
        for k in range(i):
            value -= factor[i, k] * ones[k]
        ones[i] = value / factor[i, i]
    for i in range(m - 1, -1, -1):
        value = ones[i]
        for k in range(i + 1, m):
            value -= factor[k, i] * ones[k]
        ones[i] = value / factor[i, i]
        total += ones[i]
    return total


@njit(cache=True, error_model="numpy")
def _factor_rows(active, before, own, factors, ones, compliance, members, counts):  # type: ignore[no-untyped-def]
    """`_factor_row` of every row whose active cells are not those that they were before."""
    rows, columns = active.shape
    for r in range(rows):
        if np.array_equal(active[r], before[r]):
            continue
        m = 0
        for c in range(columns):
            if active[r, c]:
                members[r, m] = c
                m += 1
        counts[r] = m
        compliance[r] = _factor_row(own, members[r], m, factors[r], ones[r])


@njit(cache=True, error_model="numpy")
def _solve_rows(residual, factors, members, counts, out, sums):  # type: ignore[no-untyped-def]
    """Every row's cells by themselves; `out` is zero elsewhere."""
    rows, columns = residual.shape
    x = np.empty(columns)
    for r in range(rows):
        m = counts[r]
        for c in range(columns):
            out[r, c] = 0.0
        for i in range(m):
            value = residual[r, members[r, i]]
            for k in range(i):
                value -= factors[r, i, k] * x[k]
            x[i] = value / factors[r, i, i]
        total = 0.0
        for i in range(m - 1, -1, -1):
            value = x[i]
            for k in range(i + 1, m):
                value -= factors[r, k, i] * x[k]
            x[i] = value / factors[r, i, i]
            out[r, members[r, i]] = x[i]
            total += x[i]
        sums[r] = total


@njit(cache=True, error_model="numpy")
def _add_even(out, ones, members, counts, amount):  # type: ignore[no-untyped-def]
    for r in range(out.shape[0]):
        for i in range(counts[r]):
            out[r, members[r, i]] += amount[r] * ones[r, i]


@njit(cache=True, error_model="numpy")
def _couple_rows(on, counts, starts, coefficients, smooth, root, coupling, matrix):  # type: ignore[no-untyped-def]
    """Deflection of active rows under one another's forces [mm/N], times `root` from the left; 1 + that from both."""
    n = on.shape[0]
    pair = 0
    pairs = np.empty(n, dtype=np.int64)
    for i in range(n):
        while pair < starts.shape[0] - 2 and on[i] >= starts[pair + 1]:
            pair += 1
        pairs[i] = pair
    for i in range(n):
        for j in range(i + 1):
            value = smooth[on[i], on[j]]
            if i != j and pairs[i] == pairs[j]:
                middle = int(0.5 * _EVEN_ACROSS * sqrt(counts[on[i]] * counts[on[j]]) + 0.5)
                value += coefficients[on[i] - on[j], middle]
            coupling[i, j] = root[i] * value
            coupling[j, i] = root[j] * value
            matrix[i, j] = matrix[j, i] = root[i] * value * root[j]
        matrix[i, i] += 1.0


class RowPreconditioner:
    """Forces that answer a displacement: rows of free cells by themselves, coupled as a whole (Woodbury).

    Factors are kept until other cells are free.
    """

    def __init__(self, system: PatchSystem, columns: int):
        rows = int(system.starts[-1])
        self._system = system
        self._free = np.zeros((rows, columns), dtype=bool)
        self._factors, self._ones = np.empty((rows, columns, columns)), np.empty((rows, columns))
        self._members, self._counts = np.empty((rows, columns), np.int64), np.zeros(rows, np.int64)
        self._compliance = np.zeros(rows)

    def __call__(self, residual: FloatArray, free: BoolArray) -> FloatArray:
        """Forces [N] for a displacement [mm], (rows, columns); zero on cells that are not free."""
        if not np.array_equal(free, self._free):
            self._factor(free)
        out, sums = np.empty_like(residual), np.empty(residual.shape[0])
        _solve_rows(residual, self._factors, self._members, self._counts, out, sums)
        # (D + E c E')^-1 = D^-1 - D^-1 E R (1 + R c R)^-1 R c E' D^-1, with R^2 = E' D^-1 E
        amount, on = np.zeros(residual.shape[0]), self._on
        amount[on] = -dpotrs(self._whole, self._coupling @ sums[on], lower=1)[0] / self._root
        _add_even(out, self._ones, self._members, self._counts, amount)
        return out

    def _factor(self, free: BoolArray) -> None:
        system = self._system
        _factor_rows(
            free, self._free, system.coefficients[0], self._factors, self._ones, self._compliance, self._members,
            self._counts,
        )  # fmt: skip
        self._free = free.copy()
        self._on = on = np.flatnonzero(self._counts)
        self._root = np.sqrt(self._compliance[on])
        self._coupling, matrix = np.empty((on.size, on.size)), np.empty((on.size, on.size))
        _couple_rows(
            on, self._counts, system.starts, system.coefficients, system.smooth, self._root, self._coupling, matrix
        )
        # LAPACK itself: scipy's wrappers take longer than matrices of this size
        self._whole, failed = dpotrf(matrix, lower=1)
        if failed:
            # a preconditioner has to be positive definite, whatever it stands for
            matrix.ravel()[:: on.size + 1] += _DEFINITE - float(np.linalg.eigvalsh(matrix)[0])
            self._whole, _ = dpotrf(matrix, lower=1)


@dataclass(frozen=True)
class SharedTorque:
    """Forces on the cells of a mesh position, and how well they meet the conditions.

    Attributes
    ----------
    sharing : Complementarity
        Its `pressure` are forces [N], (rows, columns).
    rotation : float [rad]
        Of the driving body.
    balance : float
        Relative error of the torque.
    complementarity : float
        Greatest gap where cells press, or penetration where they do not, over the approach.
    """

    sharing: Complementarity
    rotation: float
    balance: float
    complementarity: float


def share_torque(
    system: PatchSystem,
    gap: FloatArray,
    lever: FloatArray,
    torque: float,
    guess: FloatArray,
    max_iterations: int,
    tolerance: float = _TOLERANCE,
    again: bool = True,
) -> SharedTorque:
    """Forces on cells and rotation of the driving body that balance a torque.

    Parameters
    ----------
    system : PatchSystem
    gap : (rows, columns) array [mm]
        Infinite where nothing can touch.
    lever : (rows,) array [mm]
    torque : float [N mm]
    guess : (rows, columns) array [N]
        Forces to start from.
    max_iterations : int
        Convolutions.
    tolerance : float
        Relative L2 error of the forces.
    again : bool
        Whether active sets are tried where the iterations end short of the tolerance.
    """
    allowed = np.isfinite(gap)
    # from where the first cell touches: a gap that all share would cost digits
    touching = float((gap.min(axis=1) / lever).min())
    near = np.where(allowed, gap - touching * lever[:, None], 0.0)
    start = np.where(allowed, guess, 0.0)
    if not (start > 0.0).any():
        start.ravel()[np.argmin(gap / lever[:, None])] = 1.0
    arms = np.broadcast_to(lever[:, None], gap.shape)
    sharing = solve_complementarity(
        system,
        near,
        RowPreconditioner(system, gap.shape[1]),
        lever=arms,
        direction=arms,
        load=torque,
        allowed=allowed,
        start=start,
        tolerance=tolerance,
        max_iterations=max_iterations,
    )
    if sharing.status is ComplementarityStatus.NOT_CONVERGED and again:
        sharing = _by_active_sets(system, np.where(allowed, near, np.inf), lever, torque, sharing, max_iterations)
    closing = sharing.approach * lever
    left = residuals_of(near, sharing.displacement, closing, allowed, sharing.pressure)
    least = _LEAST * float(system.coefficients.max()) * torque / float(lever.max())
    approach = max(float(np.where(allowed, closing[:, None] - near, 0.0).max()), least)
    return SharedTorque(
        sharing,
        touching + sharing.approach,
        balance=abs(float(lever @ sharing.pressure.sum(axis=1)) / torque - 1.0),
        complementarity=max(left.spread, -left.least) / approach,
    )


@njit(cache=True, error_model="numpy")
def _change_contact(active, force, slack, tolerance, near, freely):  # type: ignore[no-untyped-def]  # noqa: C901
    """Let go of cells that pull; take in pierced cells, in each row `near` its deepest; returns how many change."""
    rows, columns = active.shape
    changed, worst, worst_r, worst_c = 0, -tolerance, -1, -1
    for r in range(rows):
        at = -1
        for c in range(columns):
            if active[r, c]:
                if force[r, c] < 0.0:
                    active[r, c] = False
                    changed += 1
            elif slack[r, c] < -tolerance and (at < 0 or slack[r, c] < slack[r, at]):
                at = c
        if at < 0:
            continue
        if slack[r, at] < worst:
            worst, worst_r, worst_c = slack[r, at], r, at
        for c in range(max(at - near, 0), min(at + near + 1, columns)):
            if freely and not active[r, c] and slack[r, c] < -tolerance and force[r, c] >= 0.0:
                active[r, c] = True
                changed += 1
    if not freely and changed == 0 and worst_r >= 0:
        active[worst_r, worst_c] = True
        changed = 1
    return changed


def _by_active_sets(
    system: PatchSystem,
    gap: FloatArray,
    lever: FloatArray,
    torque: float,
    iterated: Complementarity,
    max_iterations: int,
) -> Complementarity:
    """Solution by active sets, each solved by conjugate gradients; as it was where that fails, too.

    Under a wear step far too long, rows yield as a whole so much more than cells by themselves that cuts of negative
    forces undo the steps of projected gradients. Sets of cells that keep their forces, whatever the sign, until the
    equations are nearly solved do not mind (Hintermueller, Ito & Kunisch 2002).
    """
    allowed, arms = np.isfinite(gap), lever[:, None]
    closed, near = np.where(allowed, gap, 0.0), max(gap.shape[1] // 8, 1)
    active = iterated.pressure > 0.0
    force, used, changed = iterated.pressure.copy(), iterated.iterations, 1
    precondition, most = RowPreconditioner(system, gap.shape[1]), used + max_iterations
    for attempt in range(max_iterations):
        if not active.any():
            active.ravel()[np.argmin(gap / arms)] = True
        answer = precondition(np.where(active, arms, 0.0), active)
        moment = float(lever @ answer.sum(axis=1))
        force = np.where(active, force, 0.0)
        force += answer * ((torque - float(lever @ force.sum(axis=1))) / moment)
        displacement, used, rotation, slip = system.apply(force), used + 1, 0.0, 0.0
        residual, direction, before = np.where(active, -(closed + displacement), 0.0), np.zeros_like(force), 0.0
        goal = np.inf
        while True:
            z = precondition(residual, active)
            slip = -float(lever @ z.sum(axis=1)) / moment
            rotation += slip
            residual = residual + np.where(active, slip * arms, 0.0)
            z += slip * answer
            left, product = float(np.abs(residual).max()), float(np.vdot(residual, z))
            reference = float(np.max(rotation * arms - gap, where=allowed, initial=0.0))
            if not np.isfinite(goal):
                goal = max(_FIRST_DROP * left if changed else 0.0, _SETTLED * reference)
            if left <= goal or used >= most:
                break
            direction = z + (product / before if before > 0.0 else 0.0) * direction
            image, used, before = system.apply(direction), used + 1, product
            bend = float(np.vdot(direction, image))
            if bend <= 0.0:
                return replace(iterated, status=ComplementarityStatus.NOT_POSITIVE)
            length = float(np.vdot(direction, residual)) / bend
            force, displacement = force + length * direction, displacement + length * image
            residual = residual - np.where(active, length * image, 0.0)
        slack = gap + displacement - rotation * arms
        changed = _change_contact(active, force, slack, _PIERCED * reference, near, attempt < _FREE_SETS)
        if changed == 0 and left <= _SETTLED * reference:
            return replace(
                iterated, pressure=force, displacement=displacement, approach=rotation, load=torque,
                status=ComplementarityStatus.CONVERGED, iterations=used, error=0.0,
            )  # fmt: skip
        if used >= most:
            break
    return iterated
