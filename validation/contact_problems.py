"""Half-space contact problems that `bench_contact.py` has solved: Hertz contacts, rough surfaces, roll sweeps.

A `Case` is one problem or a sweep of them on one grid, all under a given load.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.closed_forms.hertz import EllipticContact, elliptic_contact


@dataclass(frozen=True, eq=False)
class GapProblem:
    """A rigid body with a gap above a half-space, pressed down by a load.

    Attributes
    ----------
    gap : (x, y) array [mm]
    cell : size of a cell along x and y [mm]
    effective_modulus : float [MPa]
    load : float [N]
    """

    gap: FloatArray
    cell: tuple[float, float]
    effective_modulus: float
    load: float

    @property
    def cell_area(self) -> float:
        """Area of a cell [mm^2]."""
        return self.cell[0] * self.cell[1]

    @property
    def size(self) -> tuple[float, float]:
        """Lengths of the grid [mm]."""
        return self.cell[0] * self.gap.shape[0], self.cell[1] * self.gap.shape[1]


@dataclass(frozen=True, eq=False)
class Case:
    """Problems on one grid, in the order in which they are solved; several are a sweep with warm starts."""

    name: str
    problems: tuple[GapProblem, ...]
    hertz: EllipticContact | None = None

    @property
    def points(self) -> tuple[int, int]:
        """Cells along x and y."""
        return self.problems[0].gap.shape

    @property
    def label(self) -> str:
        """Name and grid."""
        return f"{self.name} {self.points[0]} x {self.points[1]}"


def unseen(case: Case, number: int) -> Case:
    """The same case on cells whose aspect differs in the ninth digit: nothing kept for a grid can be used."""
    larger = 1.0 + 1e-9 * (number + 1)
    problems = tuple(replace(problem, cell=(problem.cell[0] * larger, problem.cell[1])) for problem in case.problems)
    return replace(case, problems=problems)


def centres(points: int, cell: float) -> FloatArray:
    """Centres of cells [mm], about the middle of the grid."""
    return (np.arange(points) + 0.5 - points / 2) * cell


def paraboloid(
    points: tuple[int, int],
    cell: tuple[float, float],
    radii: tuple[float, float],
    centre: tuple[float, float] = (0.0, 0.0),
) -> FloatArray:
    """Gap under a paraboloid [mm]."""
    x, y = (centres(n, size) - middle for n, size, middle in zip(points, cell, centre, strict=True))
    return x[:, None] ** 2 / (2 * radii[0]) + y**2 / (2 * radii[1])


@dataclass(frozen=True)
class HertzProblem:
    """An elliptic Hertz contact on n x n cells that cover `extent` half-axes each way.

    As it stands: half-axes 0.35691 and 6.49113 mm, 1030.46 MPa, approach 13.718 um.
    """

    points: int
    radii: tuple[float, float] = (20.0, 2000.0)
    effective_modulus: float = 115e3
    load: float = 5000.0
    extent: float = 3.0
    name: str = "elliptic"

    @cached_property
    def solution(self) -> EllipticContact:
        """Hertz's solution, without a grid."""
        return elliptic_contact(self.load, 1 / self.radii[0], 1 / self.radii[1], self.effective_modulus)

    def case(self) -> Case:
        """The problem on its grid."""
        across, along = self.solution.minor_half_axis, self.solution.major_half_axis
        cell = (self.extent * across / self.points, self.extent * along / self.points)
        gap = paraboloid((self.points, self.points), cell, self.radii)
        return Case(self.name, (GapProblem(gap, cell, self.effective_modulus, self.load),), self.solution)


def circular_hertz(points: int) -> HertzProblem:
    """A ball of 20 mm under 1 kN: square cells, for codes that want them."""
    return HertzProblem(points, radii=(20.0, 20.0), load=1000.0, name="circular")


ROUGH_LOADS = {0.01: 31.9, 0.1: 347.0, 0.5: 2500.0}
"""Load [N] by share of the cells in contact, found by trial on 512 x 512 cells of `RoughProblem`."""


@dataclass(frozen=True)
class RoughProblem:
    """A self-affine surface of 1 x 1 mm and 1 um rms on a half-space, n x n cells; Hurst exponent 0.8.

    Its power is flat below four waves a side and reaches to two cells. Finer cells add slopes, so that the load of a
    fraction grows: as n^0.2, the power with which the rms slope of such a surface does.
    """

    points: int
    fraction: float
    hurst: float = 0.8
    seed: int = 1

    def case(self) -> Case:
        """The problem on its grid."""
        n, longest = self.points, 4
        wave = np.hypot(np.fft.fftfreq(n, 1 / n)[:, None], np.fft.rfftfreq(n, 1 / n))
        amplitude = np.where((wave > 0) & (wave <= n / 2), np.maximum(wave, longest) ** (-1 - self.hurst), 0.0)
        noise = np.random.default_rng(self.seed).standard_normal((n, n))
        heights = np.fft.irfft2(amplitude * np.fft.rfft2(noise), (n, n))
        gap = -1e-3 * heights / heights.std()
        load = ROUGH_LOADS[self.fraction] * (n / 512) ** (1 - self.hurst)
        problem = GapProblem(gap - gap.min(), (1 / n, 1 / n), 1e5, load)
        return Case(f"rough {self.fraction:.0%}", (problem,))


@dataclass(frozen=True)
class RollSweep:
    """A contact line that rolls over a flank: centre, curvatures and load drift from position to position.

    Over the sweep the contact's centre moves by 0.3 half-axes across the line and 0.4 along it, the radii grow from
    18 to 24 mm and from 1800 to 2400 mm, and the load rises from 2 to 5 kN and falls again (half a sine).
    The grid, the same at all positions, covers 3 half-axes of the heaviest load on the largest radii each way.
    """

    points: tuple[int, int]
    positions: int = 40
    effective_modulus: float = 115e3

    def case(self) -> Case:
        """All positions on one grid."""
        largest = elliptic_contact(5000.0, 1 / 24.0, 1 / 2400.0, self.effective_modulus)
        across, along = largest.minor_half_axis, largest.major_half_axis
        cell = (3.0 * across / self.points[0], 3.0 * along / self.points[1])
        problems = []
        for s in np.linspace(0.0, 1.0, self.positions):
            gap = paraboloid(
                self.points,
                cell,
                (18.0 + 6.0 * s, 1800.0 + 600.0 * s),
                (0.3 * across * (s - 0.5), 0.4 * along * (s - 0.5)),
            )
            load = 2000.0 + 3000.0 * float(np.sin(np.pi * s))
            problems.append(GapProblem(gap, cell, self.effective_modulus, load))
        return Case("sweep", tuple(problems))
