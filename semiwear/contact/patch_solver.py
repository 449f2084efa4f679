"""Complementarity of cell forces on all tooth pairs under one rotation.

Forces f >= 0 on cells and one rotation phi of the driving body with

    gap + C f - a phi >= 0,   f (gap + C f - a phi) = 0,   sum of a f = torque

C is the half-space under each pair, plus what one slice feels of another as a whole (teeth, rims, wear). A
primal-dual active set (Hintermueller, Ito, Kunisch 2002) changes the contact; for each contact, conjugate gradients
are preconditioned with the half-space of every slice by itself, exact, and the coupling between slices as a
whole, exact but for its shape across the line. That takes a handful of convolutions, whatever the cells' width.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from math import sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotrs

from semiwear.compliance.half_space import HalfSpace

__all__ = ["PatchSolution", "PatchStatus", "PatchSystem", "solve_patches"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_FIRST_DROP = 0.03  # of the residual, before the contact set is looked at again
_FREE_SETS = 25  # contact sets that change on both sides; then cells are only taken out, and put back one at a time
_SETTLED = 0.1  # of the tolerance: residual of the cells that touch
_EVEN_ACROSS = 0.6  # of a half-width: there a slice's displacement is about its mean over the next one's contact
_LEAST = 1e-12  # of what one cell would yield to the whole load: an approach that is none
_DEFINITE = 0.1  # least eigenvalue of the coupling of slices, when it has to be lifted


class PatchStatus(IntEnum):
    """What happened in `solve_patches`."""

    CONVERGED = 0
    ITERATIONS = 1
    NOT_POSITIVE_DEFINITE = 2


@dataclass(frozen=True)
class PatchSystem:
    """A mesh position: rows of cells of several pairs, one after the other.

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
    lever : (rows,) array [mm]
    gap : (rows, columns) array [mm]
        Infinite where nothing can touch.
    coefficients : (rows of the longest pair, columns) array [mm/N]
        Half-space influence of a unit force on a cell.
    half_width : float [mm] over the width of a cell
        Usual half-width in cells.
    """

    starts: IntArray
    half_spaces: tuple[HalfSpace, ...]
    per_force: float
    smooth: FloatArray
    lever: FloatArray
    gap: FloatArray
    coefficients: FloatArray
    half_width: float

    def displacement(self, force: FloatArray) -> FloatArray:
        """C f [mm] for cell forces [N], (rows, columns)."""
        out = np.empty_like(force)
        for half_space, start, stop in zip(self.half_spaces, self.starts[:-1], self.starts[1:], strict=True):
            out[start:stop] = half_space.apply(force[start:stop])
        out *= self.per_force
        out += (self.smooth @ force.sum(axis=1))[:, None]
        return out


@dataclass(frozen=True)
class PatchSolution:
    """Forces on cells [N], rotation [rad], and how well the equations are met.

    Attributes
    ----------
    status : PatchStatus
    force : (rows, columns) array [N]
    rotation : float [rad]
    iterations : int
        Convolutions.
    balance : float
        Relative error of the torque.
    complementarity : float
        Greatest gap where cells press, or penetration where they do not, over the approach.
    """

    status: PatchStatus
    force: FloatArray
    rotation: float
    iterations: int
    balance: float
    complementarity: float


@njit(cache=True, error_model="numpy")
def _factor_rows(active, own, factors, ones, compliance, members, counts):  # type: ignore[no-untyped-def]
    """Cholesky factors of every row's active cells, their response to an even displacement, and its sum."""
    rows, columns = active.shape
    for r in range(rows):
        m = 0
        for c in range(columns):
            if active[r, c]:
                members[r, m] = c
                m += 1
        counts[r] = m
        total = 0.0
        for i in range(m):
            for j in range(i + 1):
                value = own[abs(members[r, i] - members[r, j])]
                for k in range(j):
                    value -= factors[r, i, k] * factors[r, j, k]
                if i == j:
                    if value <= 0.0:
                        return False
                    factors[r, i, i] = sqrt(value)
                else:
                    factors[r, i, j] = value / factors[r, j, j]
            value = 1.0
            for k in range(i):
                value -= factors[r, i, k] * ones[r, k]
            ones[r, i] = value / factors[r, i, i]
        for i in range(m - 1, -1, -1):
            value = ones[r, i]
            for k in range(i + 1, m):
                value -= factors[r, k, i] * ones[r, k]
            ones[r, i] = value / factors[r, i, i]
            total += ones[r, i]
        compliance[r] = total
    return True


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
    """What active rows feel of one another as a whole [mm/N], times `root` from the left; 1 + that from both."""
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


@njit(cache=True, error_model="numpy")
def _take_step(active, force, displacement, residual, direction, image, length):  # type: ignore[no-untyped-def]
    """Go along a direction whose displacement is `image`."""
    rows, columns = active.shape
    for r in range(rows):
        for c in range(columns):
            force[r, c] += length * direction[r, c]
            displacement[r, c] += length * image[r, c]
            if active[r, c]:
                residual[r, c] -= length * image[r, c]


@njit(cache=True, error_model="numpy")
def _turn(active, residual, z, answer, lever, slip):  # type: ignore[no-untyped-def]
    """Turn the driving body by `slip`; returns the greatest residual and its product with z."""
    greatest, product = 0.0, 0.0
    rows, columns = active.shape
    for r in range(rows):
        for c in range(columns):
            if active[r, c]:
                residual[r, c] += slip * lever[r]
                z[r, c] += slip * answer[r, c]
                greatest = max(greatest, abs(residual[r, c]))
                product += residual[r, c] * z[r, c]
    return greatest, product


class _Preconditioner:
    """Rows by themselves, and their coupling as a whole (Woodbury)."""

    def __init__(self, system: PatchSystem, active: BoolArray):
        rows, most = active.shape[0], int(active.sum(axis=1).max())
        self.factors = np.empty((rows, most, most))
        self.ones = np.empty((rows, most))
        self.members = np.empty((rows, most), dtype=np.int64)
        self.counts = np.empty(rows, dtype=np.int64)
        compliance = np.empty(rows)
        self.valid = _factor_rows(
            active, system.coefficients[0], self.factors, self.ones, compliance, self.members, self.counts
        )
        if not self.valid:
            return
        self.on = np.flatnonzero(self.counts)
        self.root = np.sqrt(compliance[self.on])
        self.coupling, matrix = np.empty((self.on.size, self.on.size)), np.empty((self.on.size, self.on.size))
        _couple_rows(
            self.on, self.counts, system.starts, system.coefficients, system.smooth, self.root, self.coupling, matrix
        )
        # LAPACK itself: scipy's wrappers take longer than matrices of this size
        self.whole, failed = dpotrf(matrix, lower=1)
        if failed:
            # a preconditioner has to be positive definite, whatever it stands for
            matrix.ravel()[:: self.on.size + 1] += _DEFINITE - float(np.linalg.eigvalsh(matrix)[0])
            self.whole, _ = dpotrf(matrix, lower=1)
        self.lever = self(np.where(active, system.lever[:, None], 0.0))

    def __call__(self, residual: FloatArray) -> FloatArray:
        """Forces that answer a displacement, zero on cells that do not touch."""
        out, sums = np.empty_like(residual), np.empty(residual.shape[0])
        _solve_rows(residual, self.factors, self.members, self.counts, out, sums)
        # (D + E c E')^-1 = D^-1 - D^-1 E R (1 + R c R)^-1 R c E' D^-1, with R^2 = E' D^-1 E
        amount = np.zeros(residual.shape[0])
        amount[self.on] = -dpotrs(self.whole, self.coupling @ sums[self.on], lower=1)[0] / self.root
        _add_even(out, self.ones, self.members, self.counts, amount)
        return out


@njit(cache=True, error_model="numpy")
def _change_contact(active, force, gap, displacement, shift, tolerance, near, free):  # type: ignore[no-untyped-def]
    """Take out cells that pull; add cells that are pierced, in each row `near` its deepest; returns how many."""
    rows, columns = active.shape
    changed = 0
    worst, worst_r, worst_c = -tolerance, -1, -1
    for r in range(rows):
        deepest, at = -tolerance, -1
        for c in range(columns):
            if active[r, c]:
                if force[r, c] < 0.0:
                    active[r, c] = False
                    changed += 1
                continue
            slack = gap[r, c] + displacement[r, c] - shift[r]
            if slack < deepest:
                deepest, at = slack, c
        if at >= 0 and deepest < worst:
            worst, worst_r, worst_c = deepest, r, at
        if at >= 0 and free:
            for c in range(max(at - near, 0), min(at + near + 1, columns)):
                slack = gap[r, c] + displacement[r, c] - shift[r]
                if not active[r, c] and slack < -tolerance and force[r, c] >= 0.0:
                    active[r, c] = True
                    changed += 1
    if not free and changed == 0 and worst_r >= 0:
        active[worst_r, worst_c] = True
        changed = 1
    return changed


def solve_patches(
    system: PatchSystem, torque: float, start: FloatArray, tolerance: float, max_iterations: int
) -> PatchSolution:
    """Forces on the cells of a mesh position.

    Parameters
    ----------
    system : PatchSystem
    torque : float [N mm]
    start : (rows, columns) array [N]
        Where it is positive, cells are first taken to touch.
    tolerance : float
        Greatest residual gap over the approach.
    max_iterations : int
        Convolutions.
    """
    gap, lever = system.gap, system.lever
    least, none = gap.min(axis=1), _no_approach(system, torque)
    open_gap = np.where(np.isfinite(gap), gap, 0.0)
    active = (start > 0.0) & np.isfinite(gap)
    force = np.where(active, start, 0.0)
    status, rotation, used, changed = PatchStatus.ITERATIONS, 0.0, 0, 1
    displacement, near = np.zeros_like(force), max(int(system.half_width), 1)
    for attempt in range(max_iterations):
        if not active.any():
            active.ravel()[np.argmin(gap / lever[:, None])] = True
        step = _Preconditioner(system, active)
        if not step.valid:
            status = PatchStatus.NOT_POSITIVE_DEFINITE
            break
        answer = step.lever
        moment = float(lever @ answer.sum(axis=1))
        # cells that left the contact took their load with them
        force += answer * ((torque - float(lever @ force.sum(axis=1))) / moment)
        displacement = system.displacement(force)
        used += 1
        residual = np.where(active, -(open_gap + displacement), 0.0)
        z = step(residual)
        rotation = -float(lever @ z.sum(axis=1)) / moment
        reference = max(float((rotation * lever - least).max()), none)
        left, product = _turn(active, residual, z, answer, lever, rotation)
        fine = _SETTLED * tolerance * reference
        # a contact that still changes is not worth solving to the end
        goal = max(_FIRST_DROP * left, fine) if changed else fine
        direction = z.copy()
        while left > goal and used < max_iterations:
            image = system.displacement(direction)
            used += 1
            bend = float(np.vdot(direction, image))
            if bend <= 0.0:
                return _solution(
                    PatchStatus.NOT_POSITIVE_DEFINITE, system, torque, active, force, displacement, rotation, used
                )
            _take_step(active, force, displacement, residual, direction, image, product / bend)
            z = step(residual)
            slip = -float(lever @ z.sum(axis=1)) / moment
            rotation += slip
            before = product
            left, product = _turn(active, residual, z, answer, lever, slip)
            direction *= product / before
            direction += z
        changed = _change_contact(
            active, force, gap, displacement, rotation * lever, tolerance * reference, near, attempt < _FREE_SETS
        )
        force[~active] = 0.0
        if changed == 0 and left <= fine:
            status = PatchStatus.CONVERGED
            break
        if used >= max_iterations:
            break
    return _solution(status, system, torque, active, force, displacement, rotation, used)


def _no_approach(system: PatchSystem, torque: float) -> float:
    """An approach that is as good as none, and above 0 [mm]."""
    return _LEAST * float(system.coefficients.max()) * torque / float(system.lever.max())


def _solution(
    status: PatchStatus,
    system: PatchSystem,
    torque: float,
    active: BoolArray,
    force: FloatArray,
    displacement: FloatArray,
    rotation: float,
    used: int,
) -> PatchSolution:
    shift = rotation * system.lever[:, None]
    slack = system.gap + displacement - shift
    worst = max(float(np.abs(slack[active]).max(initial=0.0)), float(-slack.min(initial=0.0)))
    approach = max(float((shift - system.gap).max()), _no_approach(system, torque))
    return PatchSolution(
        status=status,
        force=force,
        rotation=rotation,
        iterations=used,
        balance=abs(float(system.lever @ force.sum(axis=1)) / torque - 1.0),
        complementarity=worst / approach,
    )
