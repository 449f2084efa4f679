"""When a contact problem's iterations end: at the tolerance, or where nothing but rounding is left."""

from dataclasses import dataclass

import numpy as np
import pytest

from semiwear.arrays import BoolArray, FloatArray
from semiwear.contact.complementarity import Complementarity, ComplementarityStatus, solve_complementarity

CELLS = 120


@dataclass
class Rounded:
    """A compliance whose displacements are rounded, those that need not be exact more so; it counts the others."""

    matrix: FloatArray
    exact: float
    rough: float
    counted: int = 0

    def apply(self, pressure: FloatArray, *, roughly: bool = False) -> FloatArray:
        self.counted += not roughly
        displacement, digits = self.matrix @ pressure, self.rough if roughly else self.exact
        unit = digits * np.abs(displacement).max()
        return unit * np.round(displacement / unit) if digits else displacement


def problem() -> tuple[FloatArray, FloatArray]:
    """Compliance of a row of cells that yield to each other, and a rough gap."""
    away = np.abs(np.subtract.outer(np.arange(CELLS), np.arange(CELLS)))
    x = np.linspace(-1.0, 1.0, CELLS)
    return 1.0 / (1.0 + away), 2.0 * x**2 + 0.1 * np.random.default_rng(5).standard_normal(CELLS)


def solved(
    exact: float, rough: float, tolerance: float, iterations: int = 5000, noise: float = 0.0
) -> tuple[Complementarity, int]:
    """The contact, and how often an exact displacement was found."""
    matrix, gap = problem()
    compliance, inverse = Rounded(matrix, exact, rough), np.linalg.inv(matrix)
    random = np.random.default_rng(7)

    def precondition(residual: FloatArray, free: BoolArray) -> FloatArray:
        return inverse @ residual + noise * random.standard_normal(CELLS)

    found = solve_complementarity(
        compliance, gap, precondition, load=10.0, tolerance=tolerance, max_iterations=iterations,
        verify=compliance.apply,
    )  # fmt: skip
    return found, compliance.counted


@pytest.fixture(scope="module")
def truth() -> FloatArray:
    return solved(0.0, 0.0, 1e-12)[0].pressure


def apart(found: Complementarity, truth: FloatArray) -> float:
    """Relative L2 error of a pressure."""
    return float(np.linalg.norm(found.pressure - truth) / np.linalg.norm(truth))


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10])
def test_rough_displacements_leave_no_error(truth, tolerance):
    found, counted = solved(0.0, 1e-6, tolerance)
    assert found.status is ComplementarityStatus.CONVERGED and found.error <= tolerance
    assert apart(found, truth) <= tolerance and counted <= 4


@pytest.mark.parametrize("exact", [1e-8, 1e-11])
def test_iterations_end_where_rounding_is_left(truth, exact):
    found, _ = solved(exact, 1e-6, 1e-3 * exact)
    assert found.status is ComplementarityStatus.NOT_CONVERGED
    assert found.iterations < 200 and apart(found, truth) < 100.0 * exact


def test_iterations_end_where_they_stall(truth):
    """No error comes out less than the noise of what preconditions them."""
    found, counted = solved(0.0, 0.0, 1e-12, noise=1e-8)
    assert found.status is ComplementarityStatus.NOT_CONVERGED and counted > 1
    assert found.iterations < 200 and apart(found, truth) < 1e-5


def test_exhausted_iterations_are_told():
    found, _ = solved(0.0, 0.0, 1e-9, iterations=4)
    assert found.status is ComplementarityStatus.NOT_CONVERGED and found.iterations == 4 and found.error > 1e-9
