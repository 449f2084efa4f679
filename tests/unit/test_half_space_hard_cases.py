"""Half-space contacts on which solvers fail without saying so. Each is judged by a convolution of the test's own."""

import numpy as np
import pytest
from scipy.signal import fftconvolve

from semiwear.closed_forms.love import love_coefficients
from semiwear.contact import ContactStatus, HalfSpaceContact, bounding_box, extrapolate, solve_half_space
from tests.strategies.contact import coordinates

MODULUS = 1e5


def certify(
    result: HalfSpaceContact, gap: np.ndarray, cell: tuple[float, float], mask: np.ndarray | None = None
) -> None:
    """The contact conditions hold on the whole grid, whatever the result says of itself."""
    allowed = np.ones(gap.shape, bool) if mask is None else mask
    quarter = love_coefficients(gap.shape, cell) / MODULUS
    kernel = np.concatenate([quarter[:0:-1], quarter])
    kernel = np.concatenate([kernel[:, :0:-1], kernel], axis=1)
    nx, ny = gap.shape
    displacement = fftconvolve(result.pressure, kernel)[nx - 1 : 2 * nx - 1, ny - 1 : 2 * ny - 1]
    base = gap[allowed].min()
    separation = np.where(allowed, gap - base, 0.0) + displacement - (result.approach - base)
    scale = displacement.max()
    rounding = 4.0 * np.spacing(abs(base))
    pressed = result.pressure > 0.0
    assert not pressed[~allowed].any()
    assert result.pressure.min() >= 0.0
    assert separation[allowed].min() > -1e-6 * scale - rounding
    assert np.abs(separation[pressed]).max() < 1e-6 * scale + rounding
    assert result.load == pytest.approx(result.pressure.sum() * cell[0] * cell[1], rel=1e-12)
    assert result.contact_cells == np.count_nonzero(pressed)


def bowl(
    shape: tuple[int, int] = (40, 48), cell: tuple[float, float] = (0.1, 0.1), radius: float = 50.0
) -> np.ndarray:
    x, y = coordinates(shape, cell)
    return (x**2 + y**2) / (2.0 * radius)


def solve(gap: np.ndarray, cell: tuple[float, float] = (0.1, 0.1), **more: object) -> HalfSpaceContact:
    return solve_half_space(gap, cell=cell, effective_modulus=MODULUS, **more)


@pytest.mark.parametrize("control", [{"load": 0.0}, {"approach": 2.0}, {"approach": -1.5}])
def test_nothing_touches(control):
    result = solve(bowl() + 2.0, **control)
    base = float((bowl() + 2.0).min())
    assert result.status is ContactStatus.NO_LOAD and result.status.valid
    assert not result.pressure.any() and result.load == 0.0 and result.contact_cells == 0
    assert result.approach == pytest.approx(control.get("approach", base))


@pytest.mark.parametrize("load", [1e-9, 1e-3, 1.0, 1e3, 1e7, 1e12])
def test_any_load_on_one_grid(load):
    """A grid made for some load, at one that is a million times lighter or heavier."""
    result = solve(bowl(), load=load)
    assert result.status is {1e7: ContactStatus.FULL_CONTACT, 1e12: ContactStatus.FULL_CONTACT}.get(
        load, ContactStatus.CONVERGED
    )
    assert result.load == load
    assert result.edge_contact == (load > 1e6) and result.status.valid
    certify(result, bowl(), (0.1, 0.1))


def test_contact_at_the_border_is_flagged():
    gap = bowl((60, 48))[30:]  # the lowest point on the first row
    result = solve(gap, load=100.0)
    assert result.edge_contact
    assert result.status is ContactStatus.EDGE_CONTACT and result.status.valid
    certify(result, gap, (0.1, 0.1))
    inside = solve(bowl((60, 48)), load=100.0)
    assert not inside.edge_contact and inside.status is ContactStatus.CONVERGED


def test_flat_punch():
    x, y = coordinates((41, 41), (0.1, 0.1))
    mask = np.hypot(x, y) < 1.6
    gap = np.where(mask, 0.0, np.inf)
    result = solve(gap, load=100.0, mask=mask)
    assert result.status is ContactStatus.FULL_CONTACT
    assert result.mask_edge_contact and not result.edge_contact
    certify(result, gap, (0.1, 0.1), mask)
    deep = np.where(mask, 0.0, 1e6)
    same = solve(deep, load=100.0)
    np.testing.assert_allclose(same.pressure, result.pressure, rtol=1e-5, atol=1e-7 * result.pressure.max())


def test_constant_added_to_the_gap():
    """1e6 mm leave 1e-10 mm of the gap, and no more is lost."""
    offset = 1e6
    result, moved = solve(bowl(), load=50.0), solve(bowl() + offset, load=50.0)
    assert moved.status is ContactStatus.CONVERGED
    certify(moved, bowl() + offset, (0.1, 0.1))
    assert moved.approach - offset == pytest.approx(result.approach, abs=4e-10)
    np.testing.assert_allclose(moved.pressure, result.pressure, atol=1e-4 * result.pressure.max())


@pytest.mark.parametrize("cell", [(0.001, 1.0), (1.0, 0.001)])
def test_aspect_of_a_thousand(cell):
    x, y = coordinates((40, 36), cell)
    gap = 1e-3 * ((x / x.max()) ** 2 + (y / y.max()) ** 2)
    result = solve(gap, cell, approach=2e-4)
    assert result.status is ContactStatus.CONVERGED
    certify(result, gap, cell)


@pytest.mark.parametrize(
    "control", [{"load": 1.0}, {"load": 100.0}, {"load": 1e4}, {"approach": -1.5e-3}, {"approach": 1e-3}]
)
def test_white_roughness(control):
    gap = 1e-3 * np.random.default_rng(5).standard_normal((48, 45))
    result = solve(gap, **control)
    assert result.status.valid
    certify(result, gap, (0.1, 0.1))


def test_mask_with_holes():
    random = np.random.default_rng(8)
    mask = random.random(bowl().shape) < 0.6
    gap = np.where(mask, bowl(), random.choice([np.nan, np.inf, -np.inf, -1e3], bowl().shape))
    result = solve(gap, load=100.0, mask=mask)
    assert result.status is ContactStatus.CONVERGED and result.mask_edge_contact
    certify(result, gap, (0.1, 0.1), mask)


def test_contact_that_coarse_grids_and_boxes_do_not_see():
    """One high cell in a far corner, averaged away on coarser grids, and a light start elsewhere."""
    gap = bowl((96, 90))
    gap[3, 86] = -1e-3
    elsewhere = np.zeros(gap.shape)
    elsewhere[46:50, 43:47] = 1.0
    approach = solve(gap, load=300.0).approach
    for more in ({"load": 300.0}, {"load": 300.0, "start": elsewhere}, {"approach": approach}):
        result = solve(gap, **more)
        assert result.status is ContactStatus.CONVERGED
        assert result.pressure[3, 86] > 0.0 and result.pressure[48, 45] > 0.0
        certify(result, gap, (0.1, 0.1))


@pytest.mark.parametrize("shape", [(1, 60), (300, 1), (1, 1), (2, 3)])
@pytest.mark.parametrize("cell", [(0.1, 0.1), (1.0, 0.01)])
def test_narrow_grids(shape, cell):
    gap = bowl(shape, cell, radius=5.0)
    result = solve(gap, cell, load=10.0)
    assert result.status.valid and result.edge_contact
    certify(result, gap, cell)


def test_constant_gap():
    gap = np.full((30, 31), 0.25)
    result = solve(gap, load=10.0)
    assert result.status is ContactStatus.FULL_CONTACT
    certify(result, gap, (0.1, 0.1))
    assert solve(gap, approach=0.25).status is ContactStatus.NO_LOAD


def test_exhausted_iterations_are_told():
    result = solve(bowl((64, 64)), load=1000.0, max_iterations=3)
    assert result.status is ContactStatus.NOT_CONVERGED and not result.status.valid
    assert "max_iterations" in result.status.value
    assert result.certificate.field_error > 1e-7
    unreachable = solve(bowl((64, 64)), load=1000.0, tolerance=1e-17, max_iterations=60)
    assert not unreachable.status.valid


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_tolerance_bounds_the_field_error(tolerance):
    rough = bowl() + 1e-4 * np.random.default_rng(1).standard_normal((40, 48))
    for gap in (bowl(), rough):
        exact = solve(gap, load=200.0, tolerance=1e-12).pressure
        error = np.linalg.norm(solve(gap, load=200.0, tolerance=tolerance).pressure - exact)
        assert error < tolerance * np.linalg.norm(exact)


def test_a_start_is_extrapolated_from_one_grid_alone():
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, 21), np.linspace(-0.5, 0.5, 15), indexing="ij")
    gap, given = 0.02 * (x**2 + y**2), {"cell": (0.05, 0.07), "effective_modulus": 115e3, "load": 10.0}
    whole, part = solve_half_space(gap, **given), solve_half_space(gap[4:17, 2:13], **given)
    with pytest.raises(ValueError, match=r"before: found pressure of shape \(13, 11\).*\(21, 15\)"):
        extrapolate(whole, part)


def test_sweep_from_extrapolated_starts():
    x, y = coordinates((30, 100), (0.1, 0.1))
    previous = before = None
    for position in np.linspace(-2.0, 2.0, 9):
        gap = x**2 / 40.0 + (y - position) ** 2 / 600.0
        start = None if previous is None else extrapolate(previous, before)
        result = solve(gap, load=100.0 + 20.0 * position, start=start)
        assert result.status is ContactStatus.CONVERGED
        certify(result, gap, (0.1, 0.1))
        previous, before = result, previous


def test_arguments_are_not_changed():
    gap, start = bowl() + 0.5, np.ones(bowl().shape)
    gap.flags.writeable = start.flags.writeable = False
    assert solve(gap, load=1.0, start=start).status.valid


@pytest.mark.parametrize(
    ("argument", "more"),
    [
        ("load", {"load": -1.0}),
        ("load", {"load": np.nan}),
        ("load", {"load": np.inf}),
        ("load", {}),
        ("load", {"load": 1.0, "approach": 1.0}),
        ("approach", {"approach": np.nan}),
        ("cell", {"load": 1.0, "cell": (0.1, 0.0)}),
        ("cell", {"load": 1.0, "cell": (0.1, np.nan)}),
        ("cell", {"load": 1.0, "cell": (0.1,)}),
        ("effective_modulus", {"load": 1.0, "effective_modulus": 0.0}),
        ("effective_modulus", {"load": 1.0, "effective_modulus": np.inf}),
        ("gap", {"load": 1.0, "gap": np.zeros(5)}),
        ("gap", {"load": 1.0, "gap": np.zeros((0, 5))}),
        ("gap", {"load": 1.0, "gap": np.array([[0.0, np.nan]])}),
        ("gap", {"load": 1.0, "gap": np.array([[0.0, np.inf]])}),
        ("mask", {"load": 1.0, "mask": np.zeros((4, 5), bool)}),
        ("mask", {"load": 1.0, "mask": np.ones((5, 4), bool)}),
        ("mask", {"load": 1.0, "mask": np.ones((4, 5))}),
        ("start", {"load": 1.0, "start": np.ones((5, 4))}),
        ("start", {"load": 1.0, "start": np.full((4, 5), np.nan)}),
        ("tolerance", {"load": 1.0, "tolerance": 0.0}),
        ("max_iterations", {"load": 1.0, "max_iterations": 0}),
    ],
)
def test_bad_input_is_named(argument, more):
    arguments = {"gap": np.zeros((4, 5)), "cell": (0.1, 0.1), "effective_modulus": 1e5, **more}
    with pytest.raises(ValueError, match=rf"^(load, )?{argument}.*: found .*; allowed: .* -> "):
        solve_half_space(**arguments)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_start_that_is_not_finite_is_told_apart_from_a_wrong_shape(value):
    start = np.ones((4, 5))
    start[2, 3] = value
    with pytest.raises(
        ValueError, match=rf"^start: found {value} in cell \(2, 3\), not finite, 1 such cells; allowed: "
    ):
        solve(np.zeros((4, 5)), load=1.0, start=start)


@pytest.mark.parametrize(("seed", "cells"), [(380, 15), (763, 21), (1720, 14), (1885, 20)])
def test_few_cells_on_a_rough_bowl_of_long_cells(seed, cells):
    """Conjugate gradients stopped at errors of up to 16 % here; two to five cells touch."""
    random = np.random.default_rng(seed)
    assert int(random.integers(5, 24)) == cells
    x = (np.arange(cells) - (cells - 1) / 2) / cells
    gap = 1e-4 * (x[:, None] ** 2 + x**2 + 0.2 * x[:, None] + 0.01 * random.random((cells, cells)))
    cell = (0.1, 2.0)
    load = 1e-7 * MODULUS * np.sqrt(cells**2 * cell[0] * cell[1])
    result = solve(gap, cell, load=load, tolerance=1e-9)
    assert result.status is ContactStatus.CONVERGED and 2 <= result.contact_cells <= 5
    certify(result, gap, cell)


def test_many_contacts_take_few_iterations(monkeypatch):
    n = 256
    wave = np.hypot(np.fft.fftfreq(n, 1 / n)[:, None], np.fft.rfftfreq(n, 1 / n))
    amplitude = np.where((wave > 0.0) & (wave <= n / 2), np.maximum(wave, 4.0) ** -1.8, 0.0)
    noise = np.random.default_rng(2).standard_normal((n, n))
    heights = np.fft.irfft2(amplitude * np.fft.rfft2(noise), (n, n))
    gap = -1e-3 * heights / heights.std()
    result = solve(gap, (1 / n, 1 / n), load=2200.0)
    assert result.status.valid
    assert 0.4 < result.contact_cells / gap.size < 0.6
    certify(result, gap, (1 / n, 1 / n))
    monkeypatch.setattr(bounding_box, "_MANY_CONTACTS", np.inf)
    plain = solve(gap, (1 / n, 1 / n), load=2200.0)
    assert result.iterations < 0.6 * plain.iterations
    assert np.linalg.norm(result.pressure - plain.pressure) < 2e-7 * np.linalg.norm(plain.pressure)
