"""Half-space contact problems, and the codes that solve them, behind one interface.

A `Case` is one problem or a sweep of them on one grid, all under a given load. A code opens a `Session` on a case
(its operator is set up there, and that is not timed) and solves the problems one after the other. tamaas,
ContactMechanics and aspher are peers on PyPI; a code that is not installed raises `ImportError` when opened.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from semiwear.closed_forms.hertz import EllipticContact, elliptic_contact

FloatArray = NDArray[np.float64]

MAX_ITERATIONS = 2000  # of any code; on smooth surfaces none needs more than a tenth of it


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


@dataclass(frozen=True, eq=False)
class Answer:
    """Pressure [MPa], what came with it, and whether the code says that it converged."""

    pressure: FloatArray
    iterations: int
    converged: bool
    approach: float = float("nan")


def field_error(answers: Sequence[Answer], exact: Sequence[Answer]) -> float:
    """Greatest relative L2 error of the pressures; infinite where one is not a number."""
    errors = [
        float(np.linalg.norm(answer.pressure - right.pressure) / np.linalg.norm(right.pressure))
        for answer, right in zip(answers, exact, strict=True)
    ]
    return max(errors) if np.all(np.isfinite(errors)) else float("inf")


class Session(Protocol):
    """A code that is set up for the grid of a case."""

    def solve(self, position: int, start: FloatArray | None, variant: str, tolerance: float) -> Answer:
        """Solve one problem of the case, from a pressure [MPa] if there is one."""
        ...


class Code(Protocol):
    """A code under test; its variants are ways to solve the same problem, and the best one counts."""

    name: str
    variants: tuple[str, ...]

    def open(self, case: Case, approaches: Sequence[float]) -> Session:
        """Set up for a case; approaches [mm] are those of the solutions: scales of tolerances."""
        ...

    def can(self, case: Case) -> bool:
        """Whether the code takes cases of this kind."""
        ...


def solve_case(session: Session, case: Case, variant: str, tolerance: float) -> list[Answer]:
    """Solve all problems of a case, each from the linear extrapolation of the last two pressures."""
    answers: list[Answer] = []
    for position in range(len(case.problems)):
        last = [answer.pressure for answer in answers[-2:]]
        start = np.maximum(2 * last[1] - last[0], 0.0) if len(last) == 2 else last[0] if last else None
        answers.append(session.solve(position, start, variant, tolerance))
    return answers


class Semiwear:
    """Our solver; its certificate is part of its time."""

    name = "semiwear"
    variants = ("nested",)

    def can(self, case: Case) -> bool:
        """Any case."""
        return True

    def open(self, case: Case, approaches: Sequence[float] = ()) -> Session:
        """Nothing to set up: what the solver keeps between calls is its own business."""
        from semiwear.contact import solve_half_space

        return _SemiwearSession(case, solve_half_space)


@dataclass(frozen=True)
class _SemiwearSession:
    case: Case
    solver: Callable[..., Any]

    def solve(self, position: int, start: FloatArray | None, variant: str, tolerance: float) -> Answer:
        problem = self.case.problems[position]
        result = self.solver(
            problem.gap,
            cell=problem.cell,
            effective_modulus=problem.effective_modulus,
            load=problem.load,
            start=start,
            tolerance=tolerance,
            max_iterations=MAX_ITERATIONS,
        )
        return Answer(result.pressure, result.iterations, result.status.valid, result.approach)


class Tamaas:
    """tamaas' Polonsky-Keer-Rey solver on its non-periodic operator.

    Without `setIntegralOperator` it solves the periodic problem and says nothing. Warm starts go through
    `model.traction`: the last pressure, or the extrapolated one.
    """

    name = "tamaas"
    variants = ("extrapolated", "last pressure")

    def can(self, case: Case) -> bool:
        """Any case."""
        return True

    def open(self, case: Case, approaches: Sequence[float]) -> Session:
        """Make the model and its convolution."""
        import tamaas

        tamaas.set_log_level(tamaas.LogLevel.error)
        first = case.problems[0]
        model = tamaas.Model(tamaas.model_type.basic_2d, list(first.size), list(case.points))
        model.E, model.nu = first.effective_modulus, 0.0
        tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
        return _TamaasSession(case, tamaas, model)


@dataclass(frozen=True)
class _TamaasSession:
    case: Case
    tamaas: Any
    model: Any

    def solve(self, position: int, start: FloatArray | None, variant: str, tolerance: float) -> Answer:
        problem = self.case.problems[position]
        if start is None:
            self.model.traction[...] = 0.0
        elif variant == "extrapolated":
            self.model.traction[...] = start
        surface = np.ascontiguousarray(-problem.gap)
        solver = self.tamaas.PolonskyKeerRey(self.model, surface, tolerance)
        solver.setIntegralOperator("dcfft")
        solver.max_iter = MAX_ITERATIONS
        error = solver.solve(problem.load / (problem.size[0] * problem.size[1]))
        # tamaas does not say how many iterations it took
        return Answer(np.array(self.model.traction), -1, error <= tolerance)


class ContactMechanics:
    """ContactMechanics on its free half-space.

    Under a load: its own Polonsky-Keer, and the restarted conjugate gradient of NuMPI, which it comes with, on its
    dual objective. Its other two solvers take an approach only: they are given the right one as a present.
    """

    name = "ContactMechanics"
    variants = (
        "restarted CG",
        "Polonsky-Keer",
        "CG, approach given",
        "L-BFGS-B, approach given",
    )

    def can(self, case: Case) -> bool:
        """Any case."""
        return True

    def open(self, case: Case, approaches: Sequence[float]) -> Session:
        """Make the free half-space, with its Green's function."""
        from ContactMechanics import FreeFFTElasticHalfSpace
        from ContactMechanics.Systems import NonSmoothContactSystem
        from NuMPI.Optimization.CCGWithRestart import constrained_conjugate_gradients_with_restart
        from SurfaceTopography import Topography

        first = case.problems[0]
        substrate = FreeFFTElasticHalfSpace(case.points, first.effective_modulus, first.size)

        def system(problem: GapProblem) -> Any:
            return NonSmoothContactSystem(substrate, Topography(-problem.gap, problem.size))

        return _ContactMechanicsSession(case, approaches, system, constrained_conjugate_gradients_with_restart)


@dataclass(frozen=True)
class _ContactMechanicsSession:
    case: Case
    approaches: Sequence[float]
    system: Callable[[GapProblem], Any]
    restarted: Callable[..., Any]

    def solve(self, position: int, start: FloatArray | None, variant: str, tolerance: float) -> Answer:
        problem, approach = self.case.problems[position], self.approaches[position]
        shape, load = problem.gap.shape, problem.load
        mean = load / problem.gap.size
        forces = np.full(shape, mean) if start is None else start * (load / start.sum())
        system = self.system(problem)
        if variant == "Polonsky-Keer":
            if start is not None:
                padded = np.zeros((2 * shape[0], 2 * shape[1]))
                padded[: shape[0], : shape[1]] = -forces
            result = system.minimize_proxy(
                external_force=load,
                initial_forces=None if start is None else padded,
                pentol=tolerance * approach,
                forcetol=tolerance * load,
                thermotol=max(tolerance, 1e-12),
                maxiter=MAX_ITERATIONS,
            )
            return Answer(result.jac / problem.cell_area, result.nit, result.success, result.offset)
        if variant == "restarted CG":
            result = self.restarted(
                system.dual_objective(0.0, gradient=True),
                system.dual_hessian_product,
                x0=forces,
                gtol=tolerance * approach,
                mean_val=mean,
                maxiter=MAX_ITERATIONS,
            )
        else:
            solver = "l-bfgs-b" if variant.startswith("L-BFGS-B") else "ccg-without-restart"
            result = system.dual_minimize_proxy(
                approach, init_force=forces, solver=solver, gtol=tolerance * approach, maxiter=MAX_ITERATIONS
            )
        return Answer(result.x.reshape(shape) / problem.cell_area, result.nit, result.success)


class Aspher:
    """aspher on its exact convolution: square cells, n x n of them, no sweeps.

    Its default operator (h2) approximates the kernel to 2e-5 and cannot be compared. "As shipped" is `solve_nested`
    with its other defaults; "nested" is preconditioned by transforms and starts from 16 x 16 cells, which is faster.
    `solve_nested` makes its operators in the call, so that its time has the set-up in it.
    """

    name = "aspher"
    variants = ("nested", "nested, float then double", "nested, as shipped", "one grid")

    def can(self, case: Case) -> bool:
        """One problem on n x n square cells, n = 16 * 2^k."""
        (n, m), cell = case.points, case.problems[0].cell
        halved = n // 16
        power = n % 16 == 0 and halved & (halved - 1) == 0
        return len(case.problems) == 1 and n == m and power and abs(cell[0] / cell[1] - 1) < 1e-12

    def open(self, case: Case, approaches: Sequence[float]) -> Session:
        """Make the solver on one grid."""
        import aspher

        first = case.problems[0]
        solver = aspher.ContactSolver(
            grid_size=case.points[0], domain_size=first.size[0], E_star=first.effective_modulus, backend="fft"
        )
        return _AspherSession(case, aspher, solver)


@dataclass(frozen=True)
class _AspherSession:
    case: Case
    aspher: Any
    solver: Any

    def solve(self, position: int, start: FloatArray | None, variant: str, tolerance: float) -> Answer:
        problem = self.case.problems[position]
        gap, mean = problem.gap.ravel(), problem.load / (problem.size[0] * problem.size[1])
        if variant == "one grid":
            result = self.solver.solve(gap, mean, tol=tolerance, precond="fourier-fft")
        else:
            shipped = variant.endswith("shipped")
            result = self.aspher.solve_nested(
                grid_size=problem.gap.shape[0],
                gap=gap,
                p_nominal=mean,
                domain_size=problem.size[0],
                E_star=problem.effective_modulus,
                coarsest=min(64, problem.gap.shape[0]) if shipped else 16,
                tol=tolerance,
                backend="fft",
                precond_engine="auto" if shipped else "fft",
                precision="float_then_double" if variant.endswith("double") else "double",
            )
        return Answer(np.array(result.pressure).reshape(problem.gap.shape), result.iterations, result.converged)


PEERS: tuple[Code, ...] = (Tamaas(), ContactMechanics(), Aspher())
