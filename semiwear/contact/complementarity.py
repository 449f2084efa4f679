"""Normal contact as a complementarity problem, by preconditioned conjugate gradients on the cells in contact.

    p >= 0,  s = gap + C p - approach * direction >= 0,  p s = 0,  and either sum(lever * p) = load or the approach

The method is that of Polonsky & Keer (1999) with three changes. It is preconditioned; cells that penetrate join
through the preconditioned step itself, so that no step length has to be guessed for them; and pressures are cut
off at zero *before* the compliance is applied, at a guessed length of the step, and the best length is found along
the change that remains. The displacement of every admissible change is then known: one application of the
compliance an iteration suffices. The displacement of a change is in single precision, whose error is relative to
the change; one application in double precision at the end replaces the recurrence.

The caller gives the compliance and its preconditioner: a half-space on a grid (`half_space`), or the teeth of all
pairs with a half-space under each (`patch_contact`), where the unknowns are forces.

The steps and their end are kernels in this module. The loop around them exists twice: `solve_complementarity` takes
any compliance, in single precision, whose rounding shows in the errors (`iteration_errors`), and frees arrays where
grids are large; `patch_iteration` is compiled as a whole, since each of its steps takes less time than a call from
Python and must not hold Python's lock.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np
from numba import types
from numba.extending import overload

from semiwear.arrays import BoolArray, FloatArray
from semiwear.contact.iteration_errors import IterationErrors
from semiwear.kernel_cache import njit
from semiwear.untyped import CompilerPart, Reals

FIRST_REACH = 0.7
"""Step length along the first direction: the preconditioner is an inverse within a factor of two."""
_CAUTION = 0.7  # along later ones, relative to the best length before: rather short, as cut steps end at one
_ERROR_PER_STEP = 1.4  # greatest measured error over preconditioned residual: the preconditioner underestimates
_FINEST = 1e-13  # error below which further steps only add rounding
_ATTEMPTS = 12  # directions and lengths tried until the energy falls
_ROUNDING = 1e-14  # of the load


class Compliance(Protocol):
    """Linear relation between pressure and displacement, symmetric and positive in the product with cell areas."""

    def apply(self, pressure: FloatArray, *, roughly: bool = False) -> Reals:
        """Displacement [mm] of a pressure [MPa]: a new array of the same shape; in single precision if roughly."""


Preconditioner = Callable[[FloatArray, BoolArray], Reals]
"""Pressure that causes about a displacement on the cells that are free to change; symmetric and positive, too.

Its arguments are arrays of the gap's shape; what it returns elsewhere than on the free cells does not matter.
"""


class ComplementarityStatus(Enum):
    """How `solve_complementarity` ended."""

    CONVERGED = "the pressure is within the tolerance"
    NO_CONTACT = "nothing touches: no load, or an approach less than the least gap"
    NOT_CONVERGED = "iterations exhausted, or rounding met, before the tolerance was reached"
    NOT_POSITIVE = "the compliance is not positive definite in the product with the cell areas"


STATUSES = tuple(ComplementarityStatus)
"""Statuses by the numbers that kernels return."""
CONVERGED, NO_CONTACT, NOT_CONVERGED, NOT_POSITIVE = range(len(STATUSES))
GOES_ON = -1
"""Returned by kernels instead of a status while the iteration goes on."""


@dataclass(frozen=True)
class Complementarity:
    """Solution of a complementarity problem.

    Attributes
    ----------
    pressure : array [MPa]
    displacement : array [mm]
        C p, computed from the pressure at the end (not by the recurrence).
    approach : float
        In the unit of gap over direction ([mm], or [rad] where the direction is a lever arm).
    load : float
        sum(lever * p).
    status : ComplementarityStatus
    iterations : int
    error : float
        Estimated error of the pressure, relative in L2: 1.4 times the preconditioned residual.
    """

    pressure: FloatArray
    displacement: FloatArray
    approach: float
    load: float
    status: ComplementarityStatus
    iterations: int
    error: float


def _of(values: CompilerPart, i: CompilerPart) -> CompilerPart:
    """Value of a cell in compiled code: the array's, or the common one of all cells."""


@overload(_of)
def _compiled_of(values, i):  # type: ignore[no-untyped-def]
    if isinstance(values, types.Array):
        return lambda values, i: values[i]
    return lambda values, i: values


# Sums may be reordered: in order, each addition would wait for the one before. These kernels are inlined into those
# that call them. Otherwise there would be two compiled copies of each, whose sums differ by a rounding error, and
# which one runs would depend on whether a process compiles kernels or finds them compiled.
# `area` is that of a cell, lever over direction.
_kernel = njit(cache=True, error_model="numpy", inline="always", fastmath={"reassoc", "contract"})


@_kernel
def separation_left(pressure, displacement, gap, area, direction, by_load, approach, free, residual):  # type: ignore[no-untyped-def]
    """Negative separation on the free cells (pressed or penetrating), and the approach; fills free and residual."""
    n = pressure.shape[0]
    work, travel = 0.0, 0.0
    if by_load:  # the pressed cells have no separation on average
        for i in range(n):
            lever, pressed = _of(area, i) * _of(direction, i), pressure[i] > 0.0
            above, far = lever * (gap[i] + displacement[i]), lever * _of(direction, i)
            above, far = (above, far) if pressed else (0.0, 0.0)
            work += above
            travel += far
        approach = work / travel
        work, travel = 0.0, 0.0
    for i in range(n):
        below = approach * _of(direction, i) - gap[i] - displacement[i]
        lever = _of(area, i) * _of(direction, i)
        far = lever * _of(direction, i)
        on = (pressure[i] > 0.0) | (below > 0.0)
        below = below if on else 0.0
        free[i], residual[i] = on, below
        work += lever * below
        far = far if on else 0.0
        travel += far
    shift = work / travel if by_load and travel > 0.0 else 0.0
    for i in range(n):
        change = shift * _of(direction, i)
        residual[i] -= change if free[i] else 0.0
    return approach


@_kernel
def search_direction(step, residual, last_residual, last_product, pressure, area, direction, by_load, free, search):  # type: ignore[no-untyped-def]
    """Make the preconditioned residual admissible and the search direction from it (Polak-Ribiere, not negative)."""
    n = step.shape[0]
    work, travel = 0.0, 0.0
    if by_load:
        for i in range(n):
            lever = _of(area, i) * _of(direction, i)
            change, far = lever * step[i], lever * _of(direction, i)
            change, far = (change, far) if free[i] else (0.0, 0.0)
            work += change
            travel += far
    shift = work / travel if travel > 0.0 else 0.0
    product, overlap, size, pressed = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        change, own, on = step[i] - shift * _of(direction, i), _of(area, i), pressure[i]
        change = change if free[i] else 0.0
        step[i] = change
        product += own * change * residual[i]
        overlap += own * change * last_residual[i]
        size += own * change * change
        pressed += own * on * on
    factor = 0.0
    if last_product > 0.0:
        factor = max((product - overlap) / last_product, 0.0)
    for i in range(n):
        further = step[i] + factor * search[i]
        search[i] = further if free[i] else 0.0
    return product, size, pressed


@_kernel
def judged(size, pressed, tolerance, exact, spent):  # type: ignore[no-untyped-def]
    """Estimated error of the pressure, whether the displacement is to be computed again for it, and the status.

    A small error is final if the displacement is `exact`; one that is not small if the iterations are `spent`.
    """
    error = _ERROR_PER_STEP * np.sqrt(size / pressed) if pressed > 0.0 else np.inf
    small = error <= max(tolerance, _FINEST) or size == 0.0
    if exact and small:
        if not pressed > 0.0:
            return 0.0, small, NO_CONTACT
        return error, small, CONVERGED if error <= tolerance else NOT_CONVERGED
    return error, small, NOT_CONVERGED if spent and not small else GOES_ON


@_kernel
def _admissible(pressure, search, residual, length, area, direction, by_load, load, move):  # type: ignore[no-untyped-def]
    """Change of pressure that a step would cause once negative pressures are cut off and the load is kept.

    Returns its work on the residual, and whether anything was cut off.
    """
    n = pressure.shape[0]
    total, cut = 0.0, False
    for i in range(n):
        old = pressure[i]
        new = old + length * search[i]
        cut |= (new < 0.0) & (old > 0.0)
        new = new if new > 0.0 else 0.0
        move[i] = new
        total += _of(area, i) * _of(direction, i) * new
    scale = load / total if by_load and total > 0.0 else 1.0
    work = 0.0
    for i in range(n):
        change = move[i] * scale - pressure[i]
        move[i] = change
        work += _of(area, i) * change * residual[i]
    return work, cut


@_kernel
def downhill_change(pressure, search, step, residual, product, reach, area, direction, by_load, load, move):  # type: ignore[no-untyped-def]
    """`_admissible` change along which the energy falls, at a length that may have to be shorter for that.

    Returns its work, not positive where only rounding is left, whether anything was cut off, and the length.
    """
    n = pressure.shape[0]
    work, cut = 0.0, False
    for attempt in range(_ATTEMPTS):
        work, cut = _admissible(pressure, search, residual, reach, area, direction, by_load, load, move)
        if work > 0.0:
            break
        # where penetrating cells are pushed back, a preconditioned direction can fail; the residual never does
        if attempt == 0:
            for i in range(n):
                search[i] = step[i]
        elif attempt == 1:
            square = 0.0
            for i in range(n):
                square += _of(area, i) * residual[i] * residual[i]
            for i in range(n):
                search[i] = residual[i] * (product / square)
        else:
            reach *= 0.25
    return work, cut, reach


@_kernel
def advance(pressure, displacement, move, image, work, cut, reach, area, direction, by_load, load):  # type: ignore[no-untyped-def]
    """Go along the change as far as the energy falls and no pressure becomes negative.

    Returns the first length to try for the next change, from that of this one (`reach`) and the best one; 0 where
    the compliance is not positive.
    """
    n = pressure.shape[0]
    curvature = 0.0
    for i in range(n):
        curvature += _of(area, i) * move[i] * image[i]
    if not curvature > 0.0:
        return 0.0
    best = work / curvature
    length = best
    if cut:
        length = min(best, 1.0)
    elif best > 1.0:  # no shorter step makes a pressure negative
        for i in range(n):
            if pressure[i] + length * move[i] < 0.0:
                length = -pressure[i] / move[i]
    total = 0.0
    for i in range(n):
        new = pressure[i] + length * move[i]
        new = new if new > 0.0 else 0.0
        pressure[i] = new
        displacement[i] += length * image[i]
        total += _of(area, i) * _of(direction, i) * new
    if by_load and abs(total - load) > _ROUNDING * load:  # an error that long steps would multiply
        for i in range(n):
            pressure[i] *= load / total
            displacement[i] *= load / total
    return reach * (_CAUTION * min(max(best, 0.5), 2.0))


def _flat(values: FloatArray | float, shape: tuple[int, ...]) -> FloatArray | float:
    if isinstance(values, np.ndarray):
        return np.ascontiguousarray(np.broadcast_to(values, shape), float).ravel()
    return float(values)


def _load(lever: FloatArray | float, pressure: FloatArray) -> float:
    """Sum of lever times pressure."""
    if isinstance(lever, np.ndarray):
        return float((lever * pressure).sum())
    return lever * float(pressure.sum())


def _first_pressure(
    start: FloatArray | None, allowed: BoolArray, lever: FloatArray | float, load: float | None
) -> FloatArray:
    """Pressure to start from: nowhere negative, zero where it must be, and with the load if that is given."""
    pressure = np.zeros(allowed.size) if start is None else np.asarray(start, float).ravel()
    np.maximum(pressure, 0.0, out=pressure)
    pressure *= allowed
    if load is None:
        return pressure
    total = _load(lever, pressure)
    if load > 0.0 and total <= 0.0:
        pressure = allowed.astype(float)
        total = _load(lever, pressure)
    pressure *= load / total if total > 0.0 else 0.0
    return pressure


def solve_complementarity(  # noqa: C901
    compliance: Compliance,
    gap: FloatArray,
    precondition: Preconditioner,
    *,
    lever: FloatArray | float = 1.0,
    direction: FloatArray | float = 1.0,
    load: float | None = None,
    approach: float | None = None,
    allowed: BoolArray | None = None,
    start: FloatArray | None = None,
    tolerance: float = 1e-7,
    max_iterations: int = 200,
    verify: Callable[[FloatArray], FloatArray] | None = None,
) -> Complementarity:
    """Solve a normal contact problem under a load or an approach.

    Parameters
    ----------
    compliance : Compliance
    gap : array of any shape [mm]
        Undeformed separation; finite on the allowed cells.
    precondition : Preconditioner
    lever : float or array like the gap
        Load of a cell for unit pressure: cell area [mm^2], or area times lever arm [mm^3].
    direction : float or array like the gap
        How far a unit of approach closes the gap: 1, or the lever arm [mm]. Positive, and lever/direction is the
        area of a cell: energy is then conserved and the problem has one solution.
    load, approach : float
        Exactly one of them: sum(lever * p) [N or N mm] or the approach [mm or rad].
    allowed : bool array like the gap
        Cells that may touch.
    start : array like the gap [MPa]
        Pressure to start from; negative values count as zero. Its memory may become that of the result.
    tolerance : float
        Relative L2 error of the pressure. What is compared with it is the preconditioned residual relative to the
        pressure, times 1.4: a bound as long as the preconditioner is not less than 0.7 times the inverse.
    max_iterations : int
    verify : function from pressure to displacement, optional
        Replaces `compliance.apply` at the end, if the displacement of more than this grid is needed.

    Returns
    -------
    Complementarity

    References
    ----------
    Polonsky & Keer, Wear 231 (1999) 206; Bugnicourt et al., Tribol. Int. 121 (2018) on preconditioning.
    """
    if (load is None) == (approach is None):
        raise ValueError("give exactly one of load and approach")
    by_load = load is not None
    shape = gap.shape
    allowed_flat = np.ones(gap.size, bool) if allowed is None else np.ascontiguousarray(allowed, bool).ravel()
    gap_flat = np.ascontiguousarray(gap, float).ravel()
    if not allowed_flat.all():  # a cell infinitely far away never becomes free
        gap_flat = np.where(allowed_flat, gap_flat, np.inf)
    lever_flat, direction_flat = _flat(lever, shape), _flat(direction, shape)
    area_flat = lever_flat / direction_flat
    pressure = _first_pressure(start, allowed_flat, lever_flat, load)
    target, level = (0.0 if load is None else float(load)), (0.0 if approach is None else float(approach))
    free, search = np.empty(gap.size, bool), np.zeros(0)
    residual, move = np.zeros(gap.size), np.zeros(gap.size)
    last_residual: Reals = np.zeros(gap.size, np.float32)  # only decides how much of a direction is kept
    iteration, last_product, reach, exact = 0, 0.0, FIRST_REACH, verify is None
    errors = IterationErrors.on(gap.size)
    if pressure.any():  # in single precision if computed again at the end in any case
        displacement = compliance.apply(pressure.reshape(shape), roughly=not exact).astype(float, copy=False).ravel()
    else:
        displacement = np.zeros(gap.size)

    def check() -> None:
        """Compute the displacement again; arrays of the steps are freed, since this takes most memory."""
        nonlocal displacement, residual, last_residual, move, exact, last_product
        displacement = residual = last_residual = move = np.zeros(0)
        displacement = (verify or compliance.apply)(pressure.reshape(shape)).ravel()
        residual, move, last_residual = np.zeros(gap.size), np.zeros(gap.size), np.zeros(gap.size, np.float32)
        exact, last_product = True, 0.0

    def finish(status: int, error: float) -> Complementarity:
        reached = _load(lever_flat, pressure)
        return Complementarity(
            pressure.reshape(shape), displacement.reshape(shape), level, reached, STATUSES[status], iteration, error
        )

    if by_load and target <= 0.0:
        level = float(np.min((gap_flat / direction_flat)[allowed_flat]))
        return finish(NO_CONTACT, 0.0)
    while True:
        level = separation_left(
            pressure, displacement, gap_flat, area_flat, direction_flat, by_load, level, free, residual
        )
        step = precondition(residual.reshape(shape), free.reshape(shape)).ravel()
        if search.dtype != step.dtype or search.size == 0:
            search = np.zeros(gap.size, step.dtype)  # as precise as the preconditioner, on which conjugacy rests
        product, size, pressed = search_direction(
            step, residual, last_residual, last_product, pressure, area_flat, direction_flat, by_load, free, search
        )
        error, small, status = judged(size, pressed, tolerance, exact, iteration >= max_iterations)
        if not exact:
            small |= errors.small(error)
        elif errors.rounding(error) and status == GOES_ON:
            status = NOT_CONVERGED
        if status == GOES_ON and not small:
            iteration += 1
            work, cut, reach = downhill_change(
                pressure, search, step, residual, product, reach, area_flat, direction_flat, by_load, target, move
            )
            del step  # memory for what follows
            if work > 0.0:
                image = compliance.apply(move.reshape(shape), roughly=True).ravel()
                reach = advance(
                    pressure, displacement, move, image, work, cut, reach, area_flat, direction_flat, by_load, target
                )
                del image
                if reach > 0.0:
                    last_residual[:] = residual
                    exact, last_product = False, product
                    continue
                status = NOT_POSITIVE
            elif exact:  # what is left is rounding
                status = NOT_CONVERGED
            else:  # the recurrence's rounding
                reach = FIRST_REACH
        if not exact:
            check()
        if status != GOES_ON:
            return finish(status, error)
