"""Half-space contact against closed forms and against a dense solution; tolerances follow from the mesh."""

from math import pi, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import nnls
from scipy.special import elliprd, elliprf

from semiwear.closed_forms.hertz import elliptic_contact, line_contact_half_width, line_contact_pressure
from semiwear.closed_forms.love import love_coefficients
from semiwear.compliance.half_space import HalfSpace
from semiwear.contact import ContactStatus, solve_half_space
from semiwear.contact.complementarity import ComplementarityStatus, solve_complementarity
from tests.strategies.contact import compliance_matrix, coordinates

MODULUS = 115e3


def quadrature(i: int, j: int, cell: tuple[float, float]) -> float:
    """Love's integral over a rectangle away from the origin, by 20 x 20 Gauss points."""
    points, weights = np.polynomial.legendre.leggauss(20)
    x, y = (i + 0.5 * points)[:, None] * cell[0], (j + 0.5 * points) * cell[1]
    return float(weights @ (1.0 / np.hypot(x, y)) @ weights) * cell[0] * cell[1] / 4.0 / pi


@pytest.mark.parametrize("aspect", [1.0, 3.0, 0.2])
def test_love_against_quadrature(aspect):
    table = love_coefficients((301, 301), (1.0, aspect))
    for i, j in [(3, 3), (4, 9), (30, 2), (25, 26), (26, 25), (100, 100), (300, 7), (2, 300)]:
        assert table[i, j] == pytest.approx(quadrature(i, j, (1.0, aspect)), rel=1e-12)


def test_love_at_the_loaded_cell():
    """Johnson 1985, eq. 3.26: the middle of a square of side 2 a under p sinks by 1.122 * 2 a p / E*."""
    assert love_coefficients((1, 1), (2.0, 2.0))[0, 0] == pytest.approx(2.0 * 4.0 / pi * np.log(1.0 + sqrt(2.0)))


@pytest.mark.parametrize("cell", [(1.0, 1.0), (1.0, 1e3), (1e6, 1.0), (0.3, 1.0)])
def test_love_is_additive_at_every_distance(cell):
    """Three cells are one cell: the closed form and both Gauss rules agree where they meet."""
    small = love_coefficients((900, 900), cell)
    for axis in (0, 1):
        table = np.moveaxis(small, axis, 0)
        wide = love_coefficients(
            (300, 900) if axis == 0 else (900, 300), tuple(np.where([axis == 0, axis == 1], 3, 1) * cell)
        )
        three = table[:-1:3].copy()
        three[1:] += table[2:-1:3][: len(three) - 1] + table[4::3][: len(three) - 1]
        three[0] += 2.0 * table[1]
        assert_allclose(three[:299], np.moveaxis(wide, axis, 0)[:299], rtol=1e-13)


@pytest.mark.parametrize(
    ("shape", "curvatures"), [((65, 65), (0.01, 0.01)), ((71, 94), (0.05, 5e-4)), ((96, 51), (2e-4, 0.2))]
)
@pytest.mark.parametrize("by_load", [True, False])
def test_hertz(shape, curvatures, by_load):
    """Point and elliptic contact on odd grids and cells of aspect up to 100."""
    load = 5e3
    exact = elliptic_contact(load, *curvatures, MODULUS)
    half_axes = [exact.major_half_axis, exact.minor_half_axis]
    if curvatures[0] > curvatures[1]:
        half_axes.reverse()
    cell = (2.6 * half_axes[0] / shape[0], 2.6 * half_axes[1] / shape[1])
    x, y = coordinates(shape, cell)
    gap = curvatures[0] * x**2 / 2.0 + curvatures[1] * y**2 / 2.0
    control = {"load": load} if by_load else {"approach": exact.approach}
    result = solve_half_space(gap, cell=cell, effective_modulus=MODULUS, **control)
    assert result.status is ContactStatus.CONVERGED
    fineness = 1.0 / min(shape)  # errors at the edge of the contact go as the cell over the half-axis
    field = exact.peak_pressure * np.sqrt(np.maximum(1.0 - (x / half_axes[0]) ** 2 - (y / half_axes[1]) ** 2, 0.0))
    assert result.pressure.max() == pytest.approx(exact.peak_pressure, rel=4.0 * fineness**2)
    assert result.approach == pytest.approx(exact.approach, rel=4.0 * fineness**2)
    assert result.load == pytest.approx(load, rel=6.0 * fineness**2)
    assert np.linalg.norm(result.pressure - field) < 5.0 * fineness**1.5 * np.linalg.norm(field)
    for axis in (0, 1):
        extent = np.count_nonzero(result.pressure.any(axis=1 - axis)) * cell[axis] / 2.0
        assert extent == pytest.approx(half_axes[axis], abs=1.01 * cell[axis])
    area = result.contact_cells * cell[0] * cell[1]
    assert area == pytest.approx(pi * half_axes[0] * half_axes[1], rel=3.0 * fineness)


def test_order_of_convergence():
    """The approach converges with the square of the cell, the field with its power 3/2 (square root at the edge)."""
    exact = elliptic_contact(1e3, 0.05, 0.02, MODULUS)
    approach, field = [], []
    for n in (32, 64, 128, 256):
        cell = (2.4 * exact.minor_half_axis / n, 2.4 * exact.major_half_axis / n)
        x, y = coordinates((n, n), cell)
        result = solve_half_space(0.025 * x**2 + 0.01 * y**2, cell=cell, effective_modulus=MODULUS, load=1e3)
        share = 1.0 - (x / exact.minor_half_axis) ** 2 - (y / exact.major_half_axis) ** 2
        hertz = exact.peak_pressure * np.sqrt(np.maximum(share, 0.0))
        approach.append(abs(result.approach / exact.approach - 1.0))
        field.append(np.linalg.norm(result.pressure - hertz) / np.linalg.norm(hertz))
    assert np.polyfit(np.log([32, 64, 128, 256]), np.log(field), 1)[0] == pytest.approx(-1.2, abs=0.45)
    assert np.polyfit(np.log([32, 64, 128, 256]), np.log(approach), 1)[0] < -1.4


def test_line_contact_far_from_its_ends():
    radius, line_load = 10.0, 200.0
    half_width = float(line_contact_half_width(np.array(line_load), np.array(1.0 / radius), MODULUS))
    length = 120.0 * half_width
    cell = (3.0 * half_width / 75, length / 61)
    x, _ = coordinates((75, 61), cell)
    gap = np.broadcast_to(x**2 / (2.0 * radius), (75, 61))
    result = solve_half_space(gap, cell=cell, effective_modulus=MODULUS, load=line_load * length)
    assert result.status is ContactStatus.EDGE_CONTACT
    middle = result.pressure[:, 30]
    there = float(middle.sum() * cell[0])  # the ends carry more than their share
    peak = float(line_contact_pressure(np.array(there), np.array(1.0 / radius), MODULUS))
    width = float(line_contact_half_width(np.array(there), np.array(1.0 / radius), MODULUS))
    hertz = peak * np.sqrt(np.maximum(1.0 - (x[:, 0] / width) ** 2, 0.0))
    assert 0.8 * line_load < there < line_load
    assert middle.max() == pytest.approx(peak, rel=2e-3)
    assert np.linalg.norm(middle - hertz) < 0.02 * np.linalg.norm(hertz)


def test_circular_punch():
    """Load 2 a E* delta (Johnson 1985, eq. 3.36), a from the area that the cells cover."""
    errors = []
    for n in (40, 80, 160):
        cell = 2.2 / n
        x, y = coordinates((n, n), (cell, cell))
        mask = np.hypot(x, y) < 1.0
        radius = sqrt(np.count_nonzero(mask) * cell**2 / pi)
        result = solve_half_space(
            np.zeros((n, n)), cell=(cell, cell), effective_modulus=MODULUS, approach=1e-3, mask=mask
        )
        assert result.status is ContactStatus.FULL_CONTACT
        errors.append(result.load / (2.0 * radius * MODULUS * 1e-3) - 1.0)
    assert abs(errors[0]) < 0.02 and abs(errors[2]) < 0.005


def dense_solution(gap: np.ndarray, cell: tuple[float, float], approach: float) -> np.ndarray:
    """Least p.Cp/2 - p.(approach - gap) with p >= 0, as non-negative least squares of the Cholesky factor."""
    matrix = compliance_matrix(gap.shape, cell, MODULUS)
    factor = np.linalg.cholesky(matrix)
    target = np.linalg.solve(factor, approach - gap.ravel())
    scale = np.abs(factor).max()
    return nnls(factor.T / scale, target / np.abs(target).max())[0].reshape(gap.shape) * np.abs(target).max() / scale


@pytest.mark.parametrize("kind", ["wavy", "rough", "punch edges"])
def test_against_dense_solution(kind):
    shape, cell = (19, 20), (0.1, 0.17)
    x, y = coordinates(shape, cell)
    gap = {
        "wavy": 1e-3 * (2.0 - np.cos(2 * pi * x / 0.95) - np.cos(2 * pi * y / 1.7)),
        "rough": 1e-3 * np.random.default_rng(4).random(shape),
        "punch edges": np.where((np.abs(x) < 0.6) & (np.abs(y) < 1.2), 1e-4 * x, 1.0),
    }[kind]
    approach = float(np.quantile(gap, 0.4)) + 2e-4
    dense = dense_solution(gap, cell, approach)
    result = solve_half_space(gap, cell=cell, effective_modulus=MODULUS, approach=approach, tolerance=1e-10)
    assert result.status.valid
    assert 0.02 < np.mean(dense > 0.0) < 0.99
    assert np.linalg.norm(result.pressure - dense) < 1e-8 * np.linalg.norm(dense)
    load = float(dense.sum() * cell[0] * cell[1])
    by_load = solve_half_space(gap, cell=cell, effective_modulus=MODULUS, load=load, tolerance=1e-10)
    assert by_load.approach == pytest.approx(approach, rel=1e-8)


@pytest.mark.slow
def test_levers_and_coupled_grids():
    """Two grids of different cells under one moment, against the conditions themselves."""
    shape, cells, arms = (2, 18, 21), np.array([[0.1, 0.1], [0.07, 0.3]]), np.array([80.0, 90.0])
    grids = [HalfSpace(shape[1:], tuple(cell)) for cell in cells]
    gap = np.stack([sum(c**2 / 40.0 for c in coordinates(shape[1:], tuple(cell))) for cell in cells])
    gap[1] += 2e-3
    direction = np.broadcast_to(arms[:, None, None], shape)
    lever = direction * cells.prod(axis=1)[:, None, None]

    class Together:
        def apply(self, pressure, *, roughly=False):
            moved = [grid.apply(own, roughly=roughly) for grid, own in zip(grids, pressure, strict=True)]
            return np.stack(moved) / MODULUS

    def precondition(residual, free):
        return MODULUS * np.stack([grids[k].precondition(residual[k], roughly=True) for k in range(2)])

    operator = Together()
    result = solve_complementarity(
        operator, gap, precondition, lever=lever, direction=direction, load=4e4, tolerance=1e-10
    )
    assert result.status is ComplementarityStatus.CONVERGED
    separation = gap + operator.apply(result.pressure) - result.approach * direction
    assert result.load == pytest.approx(4e4, rel=1e-12)
    assert (result.pressure > 0.0).any(axis=(1, 2)).all()
    assert separation.min() > -1e-9 * result.displacement.max()
    assert np.abs(separation[result.pressure > 0.0]).max() < 1e-9 * result.displacement.max()
    turned = solve_complementarity(
        operator, gap, precondition, lever=lever, direction=direction, approach=result.approach, tolerance=1e-10
    )
    assert turned.load == pytest.approx(4e4, rel=1e-8)
    none = solve_complementarity(operator, gap, precondition, lever=lever, direction=direction, load=0.0)
    assert none.status is ComplementarityStatus.NO_CONTACT and not none.pressure.any()


@pytest.mark.parametrize(
    "arguments, told",
    [
        ((np.nan, 0.05, 0.02, MODULUS), "found nan N"),
        ((1e3, 0.05, 0.02, -1.0), "-1 MPa"),
        ((1e3, np.inf, 0.02, MODULUS), "inf 1/mm"),
        ((1e3, 1e-15, 0.02, MODULUS), "line_contact_pressure"),
    ],
)
def test_an_ellipse_has_numbers_that_make_one(arguments, told):
    with pytest.raises(ValueError, match=told):
        elliptic_contact(*arguments)


@pytest.mark.parametrize("complement", [0.9, 1e-2, 1e-5, 1e-8, 1e-11, 3e-14])
def test_half_axes_of_an_ellipse_however_long(complement):
    """Curvatures that belong to a chosen (b/a)^2 (Johnson 1985, eq. 4.28) find it again."""
    first = elliprf(0.0, complement, 1.0)
    second = elliprd(0.0, complement, 1.0) / 3.0
    ratio = float((first - second) / (complement * second))
    found = elliptic_contact(1000.0, 1e-4, 1e-4 * ratio, 1e5)
    assert (found.minor_half_axis / found.major_half_axis) ** 2 == pytest.approx(complement, rel=1e-11)
