"""Half-space contact solved in a box around it: coarse grids locate it, the whole grid checks the result."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import BoolArray, FloatArray
from semiwear.closed_forms.love import love_coefficients
from semiwear.compliance.half_space import HalfSpace, fast_length
from semiwear.contact.active_set import ActiveSetStatus, solve_active_set
from semiwear.contact.between_contacts import BetweenContacts, border_squared_over_area
from semiwear.contact.certificate import Residuals, residuals_of
from semiwear.contact.complementarity import Preconditioner, solve_complementarity
from semiwear.contact.nested_grids import coarsen, refine_pressure
from semiwear.kernel_cache import njit
from semiwear.untyped import Reals

Box = tuple[slice, slice]

_DENSE_CELLS = 160  # candidates up to which a Cholesky factor is faster than transforms
_SETS = 60  # active sets tried; two or three suffice, and after a failure the contact is iterated
_COARSEST = 500  # cells of a grid that is not coarsened further
_COARSE_TOLERANCE = 2e-3  # on coarser grids: less than their discretisation error
_BOXES = 12  # boxes tried before the whole grid is taken
_ROUNDING = 1e-13  # of the largest displacement: overlap by rounding
_WORTH_A_BOX = 0.75  # part of the grid above which a box does not pay
_MANY_CONTACTS = 100.0  # cells at edges, squared, over those in contact: a single round contact has ten


@dataclass(frozen=True)
class DimensionlessContact:
    """A contact problem without units: unit modulus, cells of unit area, unit load or unit approach.

    Attributes
    ----------
    gap : (nx, ny) array
        Zero where it is least among the allowed cells.
    allowed : (nx, ny) bool array
    cell : (float, float)
    by_load : bool
        Sum of pressures times cell area is one; otherwise the approach is one.
    tolerance : float
    max_iterations : int
    """

    gap: FloatArray
    allowed: BoolArray
    cell: tuple[float, float]
    by_load: bool
    tolerance: float
    max_iterations: int


@dataclass(frozen=True)
class WholeGridSolution:
    """Pressure with the displacement that it causes on the whole grid, and the separations that it leaves there."""

    pressure: FloatArray
    displacement: FloatArray
    approach: float
    iterations: int
    error: float
    residuals: Residuals


def solve_in_boxes(problem: DimensionlessContact, start: FloatArray | None) -> WholeGridSolution:
    """Solve in a box around the expected contact and enlarge it until the whole grid agrees.

    Parameters
    ----------
    problem : DimensionlessContact
    start : (nx, ny) array, optional
        Dimensionless pressure near the solution; without it, coarser grids provide one.
    """
    whole = HalfSpace(problem.gap.shape, problem.cell)
    one_cell = whole.of_one_cell()  # found first: coarser grids and boxes use a part of the same coefficients
    pressure = (
        np.zeros(problem.gap.shape) if start is None else np.where(problem.allowed, np.maximum(start, 0.0), 0.0)
    )
    if not pressure.any():
        pressure = _nested_start(problem)
    if not pressure.any():  # an approach that closes no gap on coarser grids, where high cells are averaged
        pressure = np.where(problem.allowed, np.maximum(1.0 - problem.gap, 0.0), 0.0)
    expected = pressure > 0.0
    iterations = 0
    for attempt in range(_BOXES + 1):
        box = _box_around(expected) if attempt < _BOXES else (slice(None), slice(None))
        patch = _solve_patch(problem, expected, whole) if attempt < _BOXES else None
        solved = patch or _solve_box(problem, box, pressure, problem.max_iterations - iterations, whole)
        pressure, iterations = solved.pressure, iterations + solved.iterations
        left = residuals_of(problem.gap, solved.displacement, solved.approach, problem.allowed, pressure)
        overlap = _harmless_overlap(left, one_cell * problem.tolerance)
        if left.least >= -overlap or iterations >= problem.max_iterations:
            break
        separation = problem.gap + solved.displacement - solved.approach
        missed = problem.allowed & ~solved.covered & (separation < -overlap)
        if not missed.any():
            break
        expected = missed | (pressure > 0.0)
    if solved.error > problem.tolerance and (patch := _solve_patch(problem, pressure > 0.0, whole)):
        # rounding stops the iterations where a light load closes little of a large gap; a few cells are solved anyway
        found = residuals_of(problem.gap, patch.displacement, patch.approach, problem.allowed, patch.pressure)
        if found.least >= -_harmless_overlap(found, one_cell * problem.tolerance):
            solved, pressure, left = patch, patch.pressure, found
    return WholeGridSolution(pressure, solved.displacement, solved.approach, iterations, solved.error, left)


def _harmless_overlap(left: Residuals, fraction: float) -> float:
    """Overlap by rounding, or within the tolerance of one cell, `fraction` of its pressure."""
    return max(fraction * left.pressure, _ROUNDING * left.displacement)


@dataclass(frozen=True)
class _Part:
    """Solution in which only the covered cells may touch, with the displacement of the whole grid."""

    pressure: FloatArray
    displacement: FloatArray
    covered: BoolArray
    approach: float
    iterations: int
    error: float


@njit(cache=True, error_model="numpy")
def _influence(coefficients, rows, columns):  # type: ignore[no-untyped-def]
    """Compliance matrix of cells at the given rows and columns of the grid."""
    n = rows.shape[0]
    matrix = np.empty((n, n))
    for i in range(n):
        for j in range(i + 1):
            matrix[i, j] = coefficients[abs(rows[i] - rows[j]), abs(columns[i] - columns[j])]
            matrix[j, i] = matrix[i, j]
    return matrix


def _solve_patch(problem: DimensionlessContact, expected: BoolArray, whole: HalfSpace) -> _Part | None:
    """Contact of the expected cells and those around them, solved directly if they are few."""
    if np.count_nonzero(expected) > _DENSE_CELLS:
        return None
    widened = np.pad(expected, 1)
    widened[1:-1] |= widened[:-2] | widened[2:]
    widened[:, 1:-1] |= widened[:, :-2] | widened[:, 2:]
    covered = widened[1:-1, 1:-1] & problem.allowed
    rows, columns = np.nonzero(covered)
    if rows.size > _DENSE_CELLS or rows.size == 0:
        return None
    span = int(np.ptp(rows)) + 1, int(np.ptp(columns)) + 1
    matrix = _influence(love_coefficients(span, problem.cell), rows, columns)
    force, slack, active = np.zeros(rows.size), np.zeros(rows.size), expected[covered]
    status, approach, tried = solve_active_set(
        matrix, problem.gap[covered], np.ones(rows.size), 1.0, 1.0, problem.by_load, active, force, slack, _SETS
    )
    if status != ActiveSetStatus.CONVERGED or not force.any():
        return None
    pressure = np.zeros(problem.gap.shape)
    pressure[covered] = force
    return _Part(pressure, whole.apply(pressure), covered, approach, tried, 0.0)


def _solve_box(
    problem: DimensionlessContact, box: Box, start: FloatArray, max_iterations: int, whole: HalfSpace
) -> _Part:
    """Contact of the cells in a box; the pressure to start from is overwritten."""
    pressure, covered = start, np.zeros(problem.gap.shape, bool)
    covered[box] = True
    pressure[~covered] = 0.0
    displacement = pressure  # until the solver calls `displacement_of_all`, as it does at the end

    def displacement_of_all(in_box: FloatArray) -> FloatArray:
        nonlocal displacement
        pressure[box] = in_box
        displacement = whole.apply(pressure)
        return displacement[box]  # the solver may iterate further from it, and then calls again

    solved = solve_complementarity(
        *_on_grid(problem.gap[box], problem.cell, start[box], whole),
        load=1.0 if problem.by_load else None,
        approach=None if problem.by_load else 1.0,
        allowed=problem.allowed[box],
        start=start[box],
        tolerance=problem.tolerance,
        max_iterations=max_iterations,
        verify=displacement_of_all,
    )
    pressure[box] = solved.pressure
    return _Part(pressure, displacement, covered, solved.approach, solved.iterations, solved.error)


def _on_grid(
    gap: FloatArray, cell: tuple[float, float], start: FloatArray, whole: HalfSpace | None = None
) -> tuple[HalfSpace, FloatArray, Preconditioner]:
    """Half-space under a gap, the gap, and its preconditioner, the inverse of the periodic half-space.

    Where a pressure to start from shows many contacts, residuals are continued between them.
    """
    half_space = whole if whole is not None and whole.shape == gap.shape else HalfSpace(gap.shape, cell)
    if border_squared_over_area(start > 0.0) < _MANY_CONTACTS:
        return half_space, gap, lambda residual, free: half_space.precondition(residual, roughly=True)
    between = BetweenContacts((gap.shape[0], gap.shape[1]), cell)

    def precondition(residual: FloatArray, free: BoolArray) -> Reals:
        step = half_space.precondition(between.fill(residual, free), roughly=True)
        residual *= free  # restored
        return between.collect(step, free)

    return half_space, gap, precondition


def _nested_start(problem: DimensionlessContact) -> FloatArray:
    """Pressure from the solution on a grid of half the cells in each direction, and so on down."""
    gap, allowed, cell = problem.gap, problem.allowed, problem.cell
    nx, ny = gap.shape
    along_x, along_y = (2 if nx >= 8 else 1), (2 if ny >= 8 else 1)
    if nx * ny <= _COARSEST or along_x * along_y == 1:
        return np.where(allowed, 1.0, 0.0) if problem.by_load else np.zeros(gap.shape)
    coarse_gap, coarse_allowed = coarsen(gap, allowed, along_x, along_y)
    coarse = DimensionlessContact(
        coarse_gap,
        coarse_allowed,
        (cell[0] * along_x, cell[1] * along_y),
        problem.by_load,
        _COARSE_TOLERANCE,
        40,
    )
    first = _nested_start(coarse)
    box = _box_around(first > 0.0) if first.any() else (slice(None), slice(None))
    solved = solve_complementarity(
        *_on_grid(coarse_gap[box], coarse.cell, first[box]),
        lever=coarse.cell[0] * coarse.cell[1],
        load=1.0 if problem.by_load else None,
        approach=None if problem.by_load else 1.0,
        allowed=coarse_allowed[box],
        start=first[box],
        tolerance=_COARSE_TOLERANCE,
        max_iterations=40,
    )
    pressure = np.zeros(coarse_gap.shape)
    pressure[box] = solved.pressure
    return np.asarray(refine_pressure(pressure, nx, ny, along_x, along_y, allowed))


def _box_around(expected: BoolArray) -> Box:
    """Box around the expected cells with a margin, of sizes that suit the transforms, or the whole grid."""
    spans = []
    for axis, length in enumerate(expected.shape):
        found = np.flatnonzero(expected.any(axis=1 - axis))
        first, last = int(found[0]), int(found[-1])
        margin = 3
        size = fast_length(last - first + 1 + 2 * margin)
        middle = (first + last + 1) // 2
        low = min(max(middle - size // 2, 0), max(length - size, 0))
        spans.append(slice(low, min(low + size, length)))
    sizes = [span.stop - span.start for span in spans]
    if sizes[0] * sizes[1] > _WORTH_A_BOX * expected.size:
        return slice(None), slice(None)
    return spans[0], spans[1]
