"""Archard wear of a contact that stands still, in the plane: strips of a half-space, pressed and worn.

The solver is that of fidelity `line`, with a compliance of its own: strips of even width under even pressures in
plane strain. Within an implicit step the wear that a pressure causes is itself a gap and joins the diagonal.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi

import numpy as np
from scipy.linalg import toeplitz

from semiwear.arrays import FloatArray
from semiwear.contact.active_set import ActiveSetStatus, solve_active_set
from semiwear.errors import ConvergenceError

CATALAN = 0.915965594177219
EXPLICIT_LIMIT = 16.0 * CATALAN / pi**2
"""Longest stable explicit step: k ds over dx/E*. Twice the least eigenvalue of the compliance of many strips."""


def strips(count: int) -> FloatArray:
    """Displacement of strips of unit width under unit pressure, E* = 1, in plane strain (Johnson 1985, eq. 2.25).

    Returns
    -------
    (count, count) array
        Apart from a constant, as always in the plane.
    """
    s = np.arange(count, dtype=float)
    high, low = s + 0.5, np.abs(s - 0.5)
    influence = 1.0 - high * np.log(high) + np.where(s > 0.0, 1.0, -1.0) * low * np.log(low)
    return np.asarray(toeplitz(2.0 / pi * (influence + np.log(2.0 * count))))


def loads_of_strips(compliance: FloatArray, gap: FloatArray, load: float) -> FloatArray:
    """Loads of strips under a compliance of any kind, by the active set of fidelity `line`.

    Parameters
    ----------
    compliance : (n, n) array
        Positive definite.
    gap : (n,) array
    load : float

    Raises
    ------
    ConvergenceError
        If no active set is found.
    """
    size = gap.size
    force, slack = np.zeros(size), np.zeros(size)
    status, *_ = solve_active_set(
        compliance, gap, np.ones(size), load, 0.0, True, np.ones(size, dtype=bool), force, slack, 400
    )
    if status != ActiveSetStatus.CONVERGED:
        raise ConvergenceError(
            f"no loads of {size} strips: {ActiveSetStatus(status).name}; check that the gap is finite"
        )
    return force


def roughness_after(wear_a_step: float, *, implicit: bool, steps: int = 60, count: int = 60) -> float:
    """How a wave from strip to strip has grown, its height at the start being one.

    Parameters
    ----------
    wear_a_step : float
        k ds over dx/E*.
    implicit : bool
    steps, count : int
        Wear steps, and strips.
    """
    compliance = strips(count)
    wave = 1e-6 * (-1.0) ** np.arange(count) * np.hanning(count)
    matrix = compliance + wear_a_step * np.eye(count) if implicit else compliance
    # pressed by a stamp that fits: the even contact stays even
    even = loads_of_strips(matrix, 0.0 * wave, float(count))
    worn = wave.copy()
    for _ in range(steps):
        worn = worn + wear_a_step * (loads_of_strips(matrix, worn, float(count)) - even)
        if np.abs(worn).max() > 1.0:  # beyond any doubt, and before it presses strips apart for good
            break
    return float(np.abs(np.diff(worn, 2)).max() / np.abs(np.diff(wave, 2)).max())


@dataclass(frozen=True)
class StandingContact:
    """A cylinder that slides on a flat block, which wears; nothing moves along x.

    Attributes
    ----------
    radius : float [mm]
    line_load : float [N/mm]
    modulus : float [MPa]
        Effective modulus E*.
    coefficient : float [mm^2/N]
    half_length : float [mm]
        Of the stretch that is looked at.
    count : int
        Strips on it.
    """

    radius: float
    line_load: float
    modulus: float
    coefficient: float
    half_length: float
    count: int
    _compliance: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_compliance", strips(self.count) * (self.cell / self.modulus))

    @property
    def cell(self) -> float:
        """Width of a strip [mm]."""
        return 2.0 * self.half_length / self.count

    @property
    def place(self) -> FloatArray:
        """Middles of the strips [mm]."""
        return np.asarray((np.arange(self.count) + 0.5) * self.cell - self.half_length)

    @property
    def explicit_limit(self) -> float:
        """Longest stable explicit step [mm of sliding]."""
        return EXPLICIT_LIMIT * self.cell / (self.modulus * self.coefficient)

    def pressure(self, worn: FloatArray, slid: float = 0.0) -> FloatArray:
        """Pressure [MPa] on a worn block, at the end of a further stretch of sliding [mm] that wears it."""
        gap = self.place**2 / (2.0 * self.radius) + worn
        matrix = self._compliance + self.coefficient * slid * np.eye(self.count)
        # per strip: pressure times the strip's width
        return np.asarray(loads_of_strips(matrix / self.cell, gap, self.line_load) / self.cell)

    def step(self, worn: FloatArray, slid: float, *, implicit: bool = True) -> FloatArray:
        """Depth [mm] after a further stretch of sliding [mm]."""
        return worn + self.coefficient * slid * self.pressure(worn, slid if implicit else 0.0)

    def run(self, distances: tuple[float, ...], steps_each: int, *, implicit: bool = True) -> FloatArray:
        """Depths [mm] at some distances [mm], (distance, strip); so many steps between two of them."""
        worn, before, found = np.zeros(self.count), 0.0, []
        for distance in distances:
            for _ in range(steps_each):
                worn = self.step(worn, (distance - before) / steps_each, implicit=implicit)
            before = distance
            found.append(worn)
        return np.array(found)
