"""Frictionless contact of an elastic half-space with a surface given on a regular grid."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from math import isfinite, sqrt

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import BoolArray, FloatArray
from semiwear.contact.bounding_box import DimensionlessContact, WholeGridSolution, solve_in_boxes
from semiwear.contact.certificate import ContactCertificate
from semiwear.contact.nested_grids import extrapolate_pressure

__all__ = ["ContactCertificate", "ContactStatus", "HalfSpaceContact", "extrapolate", "solve_half_space"]

# Largest separation where there should be none, over the largest displacement, for a field error of one: measured on
# smooth, rough and flat surfaces it stays below one; rounding is left besides.
_SEPARATION_PER_ERROR = 3.0
_ROUNDING = 1e-10


class ContactStatus(Enum):
    """How `solve_half_space` ended; the value is a sentence for the user."""

    CONVERGED = "converged"
    NO_LOAD = "nothing touches: the load is zero, or the approach does not close the least gap"
    EDGE_CONTACT = "converged, but the contact reaches the border of the grid: what lies beyond is not seen"
    FULL_CONTACT = "converged, but every allowed cell touches: the contact is as large as the grid or mask"
    NOT_CONVERGED = "iterations exhausted: raise max_iterations, or ask for less than this tolerance"

    @property
    def valid(self) -> bool:
        """True when pressure and approach solve the problem that was given."""
        return self is not ContactStatus.NOT_CONVERGED


@dataclass(frozen=True)
class HalfSpaceContact:
    """Solution of a half-space contact.

    Attributes
    ----------
    pressure : (nx, ny) array [MPa]
    displacement : (nx, ny) array [mm]
        Elastic displacement of the surface, both bodies together, everywhere on the grid.
    approach : float [mm]
        How far the bodies approach each other, from the zero of the gap.
    load : float [N]
    status : ContactStatus
    iterations : int
        On the grid itself; those on coarser grids are not counted.
    contact_cells : int
        Number of cells under pressure. With fewer than some ten across the contact the grid is too coarse for it.
    edge_contact : bool
        There is pressure on the first or last row or column of the grid.
    mask_edge_contact : bool
        There is pressure next to a cell that the mask forbids.
    certificate : ContactCertificate
    """

    pressure: FloatArray
    displacement: FloatArray
    approach: float
    load: float
    status: ContactStatus
    iterations: int
    contact_cells: int
    edge_contact: bool
    mask_edge_contact: bool
    certificate: ContactCertificate


def solve_half_space(
    gap: ArrayLike,
    *,
    cell: tuple[float, float],
    effective_modulus: float,
    load: float | None = None,
    approach: float | None = None,
    mask: ArrayLike | None = None,
    start: FloatArray | HalfSpaceContact | None = None,
    tolerance: float = 1e-7,
    max_iterations: int = 200,
) -> HalfSpaceContact:
    """Pressure between two elastic bodies that are flat apart from a gap, under a load or at an approach.

    The deformed separation is gap + displacement - approach; it is not negative, there is no tension, and pressure
    acts only where the separation is zero (Johnson 1985, sec. 5.9). The pressure is constant in each cell and the
    conditions hold at the centres of cells.

    Parameters
    ----------
    gap : (nx, ny) array [mm]
        Separation of the undeformed surfaces, measured from any zero. Cells outside the mask may hold anything.
    cell : (float, float) [mm]
        Sides dx, dy of a cell, of any aspect.
    effective_modulus : float [MPa]
        E* = 1 / ((1 - nu1^2)/E1 + (1 - nu2^2)/E2).
    load : float [N]
        0 or more.
    approach : float [mm]
        How far the bodies approach each other, from the zero of the gap. Give either this or the load.
    mask : (nx, ny) bool array, optional
        True where the surfaces may touch. Default: everywhere.
    start : (nx, ny) array [MPa] or HalfSpaceContact, optional
        A pressure near the solution, e.g. of the position before (see `extrapolate`); negative values count as zero.
    tolerance : float
        Relative L2 error of the pressure against the exact solution of the discrete problem. Default 1e-7.
    max_iterations : int
        On the grid itself. Default 200.

    Returns
    -------
    HalfSpaceContact
        Its `status` states whether the tolerance was reached; no error is raised where it was not.

    Raises
    ------
    ValueError
        An argument cannot be used; the message says why and what to do.

    Notes
    -----
    All decisions are made in dimensionless numbers, so that units do not matter. A first pressure comes from
    coarser grids, the iterations run in a box around the contact, a few cells are solved directly; in the end the
    conditions are checked on the whole grid, and the box grows if contact was missed.

    References
    ----------
    Love (1929) for the kernel; Polonsky & Keer, Wear 231 (1999) 206, for the iteration.

    Examples
    --------
    >>> import numpy as np
    >>> from semiwear.contact import solve_half_space
    >>> x = np.linspace(-0.5, 0.5, 65)
    >>> gap = (x[:, None] ** 2 + x**2) / 40.0  # a sphere of 20 mm radius
    >>> contact = solve_half_space(gap, cell=(x[1] - x[0],) * 2, effective_modulus=115e3, load=500.0)
    >>> contact.status.name
    'CONVERGED'
    >>> print(f"{contact.pressure.max() / 1500.0:.1f}")
    1.0
    """
    heights, allowed = _checked_surface(gap, mask)
    dx, dy = _checked_cell(cell)
    _require(
        isfinite(effective_modulus) and effective_modulus > 0.0,
        f"effective_modulus: found {effective_modulus!r}; allowed: a positive number [MPa] -> check the elastic data",
    )
    _require(
        isfinite(tolerance) and 0.0 < tolerance < 1.0,
        f"tolerance: found {tolerance!r}; allowed: between 0 and 1 -> 1e-7 is enough for most purposes",
    )
    _require(max_iterations >= 1, f"max_iterations: found {max_iterations!r}; allowed: 1 or more -> try 200")
    _check_control(load, approach)
    first = _checked_start(start, heights.shape)

    zero = float(heights.min() if mask is None else heights[allowed].min())
    length = sqrt(dx) * sqrt(dy)
    closing = None if approach is None else float(approach) - zero
    if load == 0.0 or (closing is not None and closing <= 0.0):
        return _empty(heights.shape, zero if approach is None else float(approach))
    if load is not None:
        pressure_unit = float(load) / dx / dy
        displacement_unit = pressure_unit * length / effective_modulus
    else:
        assert closing is not None
        displacement_unit = closing
        pressure_unit = displacement_unit * effective_modulus / length
    relative = (heights - zero) / displacement_unit
    if mask is not None:
        relative[~allowed] = 0.0
    problem = DimensionlessContact(
        relative,
        allowed,
        (dx / length, dy / length),
        by_load=load is not None,
        tolerance=float(tolerance),
        max_iterations=int(max_iterations),
    )
    solved = solve_in_boxes(problem, None if first is None else first / pressure_unit)
    pressure, displacement = solved.pressure, solved.displacement
    pressed = pressure > 0.0
    certificate = _certify(problem, solved)
    total = float(pressure.sum())
    pressure *= pressure_unit
    displacement *= displacement_unit
    edge = bool(pressed[[0, -1]].any() or pressed[:, [0, -1]].any())
    return HalfSpaceContact(
        pressure=pressure,
        displacement=displacement,
        approach=zero + solved.approach * displacement_unit if approach is None else float(approach),
        load=total * pressure_unit * dx * dy if load is None else float(load),
        status=_judge(certificate, problem, pressed, edge),
        iterations=solved.iterations,
        contact_cells=int(np.count_nonzero(pressed)),
        edge_contact=edge,
        mask_edge_contact=_touches(pressed, ~allowed),
        certificate=certificate,
    )


def extrapolate(previous: HalfSpaceContact, before: HalfSpaceContact | None = None) -> FloatArray:
    """A pressure from which to start the next of a row of contacts, by its square, linear through the last two.

    Parameters
    ----------
    previous, before : HalfSpaceContact
        The last contact, and the one before it; without that, the pressure is the last one.

    Returns
    -------
    (nx, ny) array [MPa]
        For the argument `start` of `solve_half_space`.

    Raises
    ------
    ValueError
        Both are on grids of different shapes.
    """
    if before is None:
        return previous.pressure
    if before.pressure.shape != previous.pressure.shape:
        raise ValueError(
            f"before: found pressure of shape {before.pressure.shape}; allowed: that of previous, "
            f"{previous.pressure.shape}; leave it out where the grid changes"
        )
    return np.asarray(extrapolate_pressure(previous.pressure, before.pressure))


def _certify(problem: DimensionlessContact, solved: WholeGridSolution) -> ContactCertificate:
    left = solved.residuals
    scale = max(left.displacement, np.finfo(float).tiny)
    return ContactCertificate(
        penetration=max(-left.least, 0.0) / scale,
        gap_spread=left.spread / scale,
        load_error=abs(float(solved.pressure.sum()) - 1.0) if problem.by_load else 0.0,
        field_error=solved.error,
    )


def _judge(
    certificate: ContactCertificate, problem: DimensionlessContact, pressed: BoolArray, edge: bool
) -> ContactStatus:
    limit = _SEPARATION_PER_ERROR * problem.tolerance + _ROUNDING
    good = (
        certificate.field_error <= problem.tolerance
        and certificate.penetration <= limit
        and certificate.gap_spread <= limit
        and certificate.load_error <= 1e-12
    )
    if not good:  # also when a number is not a number
        return ContactStatus.NOT_CONVERGED
    if np.array_equal(pressed, problem.allowed):
        return ContactStatus.FULL_CONTACT
    return ContactStatus.EDGE_CONTACT if edge else ContactStatus.CONVERGED


def _touches(pressed: BoolArray, forbidden: BoolArray) -> bool:
    if not forbidden.any():
        return False
    return bool(
        (pressed[1:] & forbidden[:-1]).any()
        or (pressed[:-1] & forbidden[1:]).any()
        or (pressed[:, 1:] & forbidden[:, :-1]).any()
        or (pressed[:, :-1] & forbidden[:, 1:]).any()
    )


def _empty(shape: tuple[int, ...], approach: float) -> HalfSpaceContact:
    return HalfSpaceContact(
        pressure=np.zeros(shape),
        displacement=np.zeros(shape),
        approach=approach,
        load=0.0,
        status=ContactStatus.NO_LOAD,
        iterations=0,
        contact_cells=0,
        edge_contact=False,
        mask_edge_contact=False,
        certificate=ContactCertificate(0.0, 0.0, 0.0, 0.0),
    )


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise ValueError(message)


def _checked_surface(gap: ArrayLike, mask: ArrayLike | None) -> tuple[FloatArray, BoolArray]:
    heights = np.asarray(gap, dtype=float)
    _require(
        heights.ndim == 2 and heights.size > 0,
        f"gap: found an array of shape {heights.shape}; allowed: (nx, ny) with at least one cell"
        " -> give a line of cells as (1, n)",
    )
    allowed = np.ones(heights.shape, bool) if mask is None else np.asarray(mask)
    _require(
        allowed.shape == heights.shape and allowed.dtype == bool,
        f"mask: found shape {allowed.shape} of {allowed.dtype}; allowed: bool of the gap's shape {heights.shape}"
        " -> True where the surfaces may touch",
    )
    _require(
        bool(allowed.any()), "mask: found no True; allowed: at least one cell -> let the surfaces touch somewhere"
    )
    bad = ~np.isfinite(heights)
    if mask is not None:
        bad &= allowed
    if bad.any():
        where = tuple(int(i) for i in np.argwhere(bad)[0])
        raise ValueError(
            f"gap: found {heights[where]} in cell {where}, {int(bad.sum())} such cells; allowed: finite numbers [mm]"
            " where the mask is True -> exclude cells without a surface by the mask"
        )
    return heights, allowed


def _checked_cell(cell: tuple[float, float]) -> tuple[float, float]:
    sides = tuple(float(side) for side in np.ravel(cell))
    _require(
        len(sides) == 2 and all(isfinite(side) and side > 0.0 for side in sides),
        f"cell: found {cell!r}; allowed: two positive numbers dx, dy [mm] -> spacing of the gap's rows and columns",
    )
    return sides[0], sides[1]


def _check_control(load: float | None, approach: float | None) -> None:
    _require(
        (load is None) != (approach is None),
        f"load, approach: found {load!r} and {approach!r}; allowed: exactly one of them -> leave the other out",
    )
    if load is not None:
        _require(
            isfinite(load) and load >= 0.0,
            f"load: found {load!r}; allowed: zero or a positive number [N] -> surfaces without adhesion only push",
        )
    else:
        assert approach is not None
        _require(
            isfinite(approach),
            f"approach: found {approach!r}; allowed: a finite number [mm] -> measure it from the gap's zero",
        )


def _checked_start(start: FloatArray | HalfSpaceContact | None, shape: tuple[int, ...]) -> FloatArray | None:
    if start is None:
        return None
    pressure = np.asarray(start.pressure if isinstance(start, HalfSpaceContact) else start, dtype=float)
    advice = f"allowed: finite pressures [MPa] of the gap's shape {shape} -> leave it out for a first position"
    _require(pressure.shape == shape, f"start: found shape {pressure.shape}; {advice}")
    bad = ~np.isfinite(pressure)
    if bad.any():
        where = tuple(int(i) for i in np.argwhere(bad)[0])
        raise ValueError(
            f"start: found {pressure[where]} in cell {where}, not finite, {int(bad.sum())} such cells; {advice}"
        )
    return pressure
