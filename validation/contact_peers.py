"""The codes that solve half-space contact problems, behind one interface.

A code is opened on a `Case` (its operator is set up there, and that is not timed), and solves the problems one after
the other. tamaas, ContactMechanics and aspher are peers on PyPI; a code that is not installed raises
`ImportError` when opened.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from contact_problems import Case

from semiwear.arrays import FloatArray

MAX_ITERATIONS = 2000  # of any code; on smooth surfaces none needs more than a tenth of it


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


Solve = Callable[[int, FloatArray | None, str, float], Answer]
"""A code that is set up for a case: from the position of a problem, a pressure [MPa] to begin with or None, a variant
and a tolerance to the answer."""


class Code(Protocol):
    """A code under test; its variants are ways to solve the same problem, and the best one counts."""

    name: str
    variants: tuple[str, ...]

    def open(self, case: Case, approaches: Sequence[float]) -> Solve:
        """Set up for a case; approaches [mm] are those of the solutions: scales of tolerances."""
        ...

    def can(self, case: Case) -> bool:
        """Whether the code takes cases of this kind."""
        ...


def solve_case(solve: Solve, case: Case, variant: str, tolerance: float) -> list[Answer]:
    """Solve all problems of a case, each from the linear extrapolation of the last two pressures."""
    answers: list[Answer] = []
    for position in range(len(case.problems)):
        last = [answer.pressure for answer in answers[-2:]]
        start = np.maximum(2 * last[1] - last[0], 0.0) if len(last) == 2 else last[0] if last else None
        answers.append(solve(position, start, variant, tolerance))
    return answers


class Semiwear:
    """Our solver; its certificate is part of its time."""

    name = "semiwear"
    variants = ("nested",)

    def can(self, case: Case) -> bool:
        """Any case."""
        return True

    def open(self, case: Case, approaches: Sequence[float] = ()) -> Solve:
        """Nothing to set up: what the solver keeps between calls is its own business."""
        from semiwear.contact import solve_half_space

        def solve(position: int, start: FloatArray | None, variant: str, tolerance: float) -> Answer:
            problem = case.problems[position]
            result = solve_half_space(
                problem.gap,
                cell=problem.cell,
                effective_modulus=problem.effective_modulus,
                load=problem.load,
                start=start,
                tolerance=tolerance,
                max_iterations=MAX_ITERATIONS,
            )
            return Answer(result.pressure, result.iterations, result.status.valid, result.approach)

        return solve


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

    def open(self, case: Case, approaches: Sequence[float]) -> Solve:
        """Make the model and its convolution."""
        import tamaas

        tamaas.set_log_level(tamaas.LogLevel.error)
        first = case.problems[0]
        model = tamaas.Model(tamaas.model_type.basic_2d, list(first.size), list(case.points))
        model.E, model.nu = first.effective_modulus, 0.0
        tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")

        def solve(position: int, start: FloatArray | None, variant: str, tolerance: float) -> Answer:
            problem = case.problems[position]
            if start is None:
                model.traction[...] = 0.0
            elif variant == "extrapolated":
                model.traction[...] = start
            surface = np.ascontiguousarray(-problem.gap)
            solver = tamaas.PolonskyKeerRey(model, surface, tolerance)
            solver.setIntegralOperator("dcfft")
            solver.max_iter = MAX_ITERATIONS
            error = solver.solve(problem.load / (problem.size[0] * problem.size[1]))
            # tamaas does not say how many iterations it took
            return Answer(np.array(model.traction), -1, error <= tolerance)

        return solve


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

    def open(self, case: Case, approaches: Sequence[float]) -> Solve:
        """Make the free half-space, with its Green's function."""
        from ContactMechanics import FreeFFTElasticHalfSpace
        from ContactMechanics.Systems import NonSmoothContactSystem
        from NuMPI.Optimization.CCGWithRestart import constrained_conjugate_gradients_with_restart
        from SurfaceTopography import Topography

        first = case.problems[0]
        substrate = FreeFFTElasticHalfSpace(case.points, first.effective_modulus, first.size)

        def solve(position: int, start: FloatArray | None, variant: str, tolerance: float) -> Answer:
            problem, approach = case.problems[position], approaches[position]
            shape, load = problem.gap.shape, problem.load
            mean = load / problem.gap.size
            forces = np.full(shape, mean) if start is None else start * (load / start.sum())
            system = NonSmoothContactSystem(substrate, Topography(-problem.gap, problem.size))
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
                result = constrained_conjugate_gradients_with_restart(
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

        return solve


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

    def open(self, case: Case, approaches: Sequence[float]) -> Solve:
        """Make the solver on one grid."""
        import aspher

        first = case.problems[0]
        solver = aspher.ContactSolver(
            grid_size=case.points[0], domain_size=first.size[0], E_star=first.effective_modulus, backend="fft"
        )

        def solve(position: int, start: FloatArray | None, variant: str, tolerance: float) -> Answer:
            problem = case.problems[position]
            gap, mean = problem.gap.ravel(), problem.load / (problem.size[0] * problem.size[1])
            if variant == "one grid":
                result = solver.solve(gap, mean, tol=tolerance, precond="fourier-fft")
            else:
                shipped = variant.endswith("shipped")
                result = aspher.solve_nested(
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

        return solve


PEERS: tuple[Code, ...] = (Tamaas(), ContactMechanics(), Aspher())
