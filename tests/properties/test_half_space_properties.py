"""What every half-space contact must fulfil."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.signal import fftconvolve

from semiwear.closed_forms.love import love_coefficients
from semiwear.compliance.half_space import HalfSpace
from semiwear.contact import HalfSpaceContact, solve_half_space
from tests.strategies.contact import Surface, compliance_matrix, surfaces


def solve(surface: Surface, **more: object) -> HalfSpaceContact:
    control = {} if "approach" in more else {"load": surface.load}
    return solve_half_space(
        surface.gap, cell=surface.cell, effective_modulus=surface.modulus, **{"tolerance": 1e-9, **control, **more}
    )


def differ(one: np.ndarray, other: np.ndarray) -> float:
    """Relative L2 difference."""
    return float(np.linalg.norm(one - other) / np.linalg.norm(other))


@given(surfaces())
def test_complementarity(surface):
    result = solve(surface)
    assert result.status.valid
    displacement = compliance_matrix(surface.gap.shape, surface.cell, surface.modulus) @ result.pressure.ravel()
    separation = surface.gap + displacement.reshape(surface.gap.shape) - result.approach
    scale = displacement.max()
    assert result.pressure.min() >= 0.0
    assert separation.min() >= -1e-8 * scale
    assert np.abs(separation[result.pressure > 0.0]).max() <= 1e-8 * scale
    assert result.pressure.sum() * surface.cell[0] * surface.cell[1] == pytest.approx(surface.load, rel=1e-12)
    assert_allclose(result.displacement, displacement.reshape(surface.gap.shape), rtol=1e-11)


@given(surfaces(), st.integers(0, 2**32 - 1))
def test_operator_is_the_direct_sum(surface, seed):
    pressure = np.random.default_rng(seed).standard_normal(surface.gap.shape)
    matrix = compliance_matrix(surface.gap.shape, surface.cell, 1.0)
    operator = HalfSpace(surface.gap.shape, surface.cell)
    direct = matrix @ pressure.ravel()
    assert_allclose(operator.apply(pressure).ravel(), direct, atol=1e-13 * (matrix @ np.abs(pressure).ravel()).max())


@given(surfaces(), st.integers(0, 2**32 - 1))
def test_superposition_and_reciprocity(surface, seed):
    operator = HalfSpace(surface.gap.shape, surface.cell)
    one, other = np.random.default_rng(seed).random((2, *surface.gap.shape))
    both = operator.apply(one + 3.0 * other)
    assert_allclose(both, operator.apply(one) + 3.0 * operator.apply(other), rtol=1e-12)
    assert np.vdot(other, operator.apply(one)) == pytest.approx(np.vdot(one, operator.apply(other)), rel=1e-12)
    step, back = operator.precondition(one), operator.precondition(other)
    assert abs(np.vdot(other, step) - np.vdot(one, back)) < 1e-12 * np.linalg.norm(other) * np.linalg.norm(step)
    assert np.vdot(one, step) > 0.0


@given(surfaces(most=12))
def test_preconditioner_is_nearly_the_inverse(surface):
    operator = HalfSpace(surface.gap.shape, surface.cell)
    matrix = compliance_matrix(surface.gap.shape, surface.cell, 1.0)
    inverse = np.array([operator.precondition(e.reshape(surface.gap.shape)).ravel() for e in np.eye(len(matrix))])
    values = np.linalg.eigvals(inverse @ matrix).real
    assert values.min() > 0.4 and values.max() < 5.0


@given(surfaces(), st.integers(0, 2**32 - 1))
def test_single_precision_is_near_double(surface, seed):
    operator = HalfSpace(surface.gap.shape, surface.cell)
    grid = np.random.default_rng(seed).standard_normal(surface.gap.shape)
    for transform in (operator.apply, operator.precondition):
        exact, rough = transform(grid), transform(grid, roughly=True)
        assert rough.dtype == np.float32
        assert np.linalg.norm(rough - exact) < 3e-6 * np.linalg.norm(exact)


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (3, 1), (5, 5), (4, 81), (125, 6), (60, 64), (97, 30), (2, 250)])
def test_operator_for_every_factor_of_the_length(shape):
    """Stages of two, three, four and five, odd and even lengths, whole and broken blocks of lanes."""
    pressure = np.random.default_rng(1).standard_normal(shape)
    coefficients = love_coefficients(shape, (0.3, 0.7))
    kernel = np.pad(coefficients, [(n - 1, 0) for n in shape], mode="reflect") if min(shape) > 1 else None
    if kernel is None:  # numpy does not reflect a single cell
        line = coefficients.ravel()
        kernel = np.concatenate([line[:0:-1], line]).reshape([2 * n - 1 for n in shape])
    direct = fftconvolve(pressure, kernel, mode="full")[shape[0] - 1 :, shape[1] - 1 :][: shape[0], : shape[1]]
    result = HalfSpace(shape, (0.3, 0.7)).apply(pressure)
    assert_allclose(result, direct, atol=1e-13 * coefficients[0, 0] * pressure.size)


@given(st.sampled_from([(0.1, 0.3), (3.0, 0.1)]), st.integers(1, 40), st.integers(1, 40))
def test_what_earlier_grids_left_does_not_matter(cell, nx, ny):
    """Coefficients are kept and shared by cells of the same aspect, whichever grid came first."""
    pressure = np.random.default_rng(2).random((nx, ny))
    twice = HalfSpace((nx, ny), (2.0 * cell[0], 2.0 * cell[1])).apply(pressure)
    assert_allclose(twice, 2.0 * HalfSpace((nx, ny), cell).apply(pressure), rtol=1e-14)
    matrix = compliance_matrix((nx, ny), cell, 1.0) if nx * ny <= 400 else None
    if matrix is not None:
        assert_allclose(0.5 * twice.ravel(), matrix @ pressure.ravel(), rtol=1e-12)


def test_threads_do_not_share_work_space():
    operators = [HalfSpace((40 + k, 50), (0.1, 0.1 + 0.01 * k)) for k in range(4)]
    pressure = [np.random.default_rng(k).random(operator.shape) for k, operator in enumerate(operators)]
    alone = [operator.apply(p) for operator, p in zip(operators, pressure, strict=True)]

    def again(k: int) -> bool:
        return all(np.array_equal(operators[k].apply(pressure[k]), alone[k]) for _ in range(50))

    with ThreadPoolExecutor(4) as threads:
        assert all(threads.map(again, range(4)))


@given(surfaces(), st.sampled_from([1e-3, 25.4, 1e6]), st.sampled_from([1e-6, 6.894757e-3, 1e9]))
def test_units_do_not_matter(surface, length, stress):
    result = solve(surface, tolerance=3e-13)
    scaled = solve(
        Surface(
            surface.gap * length,
            (surface.cell[0] * length, surface.cell[1] * length),
            surface.modulus * stress,
            surface.load * stress * length**2,
        ),
        tolerance=3e-13,
    )
    assert scaled.status is result.status
    assert differ(scaled.pressure / stress, result.pressure) < 1e-12
    relative = result.approach - surface.gap.min()
    assert scaled.approach / length - surface.gap.min() == pytest.approx(relative, rel=1e-12, abs=1e-14)


@given(surfaces())
def test_load_and_approach_control_agree(surface):
    by_load = solve(surface)
    by_approach = solve(surface, approach=by_load.approach)
    assert by_approach.load == pytest.approx(surface.load, rel=1e-6)
    assert differ(by_approach.pressure, by_load.pressure) < 1e-6


@given(surfaces())
def test_mirrored_surface_has_mirrored_pressure(surface):
    result = solve(surface)
    mirrored = solve(replace(surface, gap=np.ascontiguousarray(surface.gap[::-1, ::-1])))
    turned = solve(replace(surface, gap=np.ascontiguousarray(surface.gap.T), cell=surface.cell[::-1]))
    assert differ(mirrored.pressure[::-1, ::-1], result.pressure) < 5e-9
    assert differ(turned.pressure.T, result.pressure) < 5e-9


@given(surfaces(), st.integers(1, 5), st.integers(0, 5))
def test_position_in_the_grid_does_not_matter(surface, before, after):
    if solve(surface).edge_contact:
        return
    farther = np.pad(surface.gap, ((before, after), (after, before)), constant_values=10.0 * np.ptp(surface.gap))
    moved = solve(replace(surface, gap=farther))
    nx, ny = surface.gap.shape
    inside = moved.pressure[before : before + nx, after : after + ny]
    assert differ(inside, solve(surface).pressure) < 5e-9


@given(surfaces(), st.floats(1.01, 5.0))
def test_more_load_more_approach(surface, factor):
    little, much = solve(surface), solve(surface, load=factor * surface.load)
    assert much.approach > little.approach
    # the stiffness of a contact grows with the load: the approach grows less than in proportion
    base = surface.gap.min()
    assert much.approach - base <= factor * (little.approach - base) * (1.0 + 1e-8)


@given(surfaces(), st.floats(0.5, 2.0))
def test_start_changes_only_the_way(surface, factor):
    cold = solve(surface)
    near = solve(surface, load=factor * surface.load)
    for start in (near, cold, near.pressure * 10.0, np.ones(surface.gap.shape)):
        assert differ(solve(surface, start=start).pressure, cold.pressure) < 5e-9
