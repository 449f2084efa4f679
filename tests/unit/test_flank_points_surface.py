"""A surface through points: how close it comes, and what it says of itself."""

import numpy as np
import pytest

from semiwear.geometry.point_surface import NOISY, PointSurface, noise_of
from semiwear.meshing.point_flank_kernels import surface_points


def flank(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A twisted, curved sheet of about 10 by 60 mm, and its unit normals."""
    x, y = np.broadcast_arrays(10.0 * u, 60.0 * v)

    def point(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.stack([40.0 + x, 0.02 * x**2 + 0.003 * x * y + 0.3 * np.sin(x / 4.0) + 1e-3 * y**2, y], axis=-1)

    step = 1e-5
    across = point(x + step, y) - point(x - step, y)
    along = point(x, y + step) - point(x, y - step)
    normal = np.cross(across, along)
    return point(x, y), normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def error_of(surface: PointSurface, smooth: tuple[np.ndarray, np.ndarray] | None = None) -> np.ndarray:
    """Distances of a surface from the sheet, along its normal, at many places."""
    rng = np.random.default_rng(3)
    u, v = rng.uniform(0.0, 1.0, (2, 4000))
    out = np.empty((u.size, 3, 3))
    surface_points(surface.cells, surface.u, surface.v, u, v, out)
    points = out[..., 0]
    exact, normal = flank((points[:, 0] - 40.0) / 10.0, points[:, 2] / 60.0)
    return np.abs(np.sum((points - exact) * normal, axis=-1))


def grid(rows: int, columns: int, uneven: float = 0.0) -> np.ndarray:
    u, v = np.linspace(0.0, 1.0, rows)[:, None], np.linspace(0.0, 1.0, columns)
    return flank(u + uneven * u * (1.0 - u), v + uneven * v * (1.0 - v))[0]


@pytest.mark.parametrize("uneven", [0.0, 0.6])
@pytest.mark.parametrize("size", [11, 21, 41])
def test_the_estimate_covers_the_error_and_is_no_wild_guess(size, uneven):
    surface = PointSurface.through(grid(size, size, uneven))
    found = float(np.quantile(error_of(surface), 0.95))
    assert surface.smoothing == 0.0
    assert found < 2.0 * surface.error
    assert surface.error < 30.0 * found + 1e-9


def test_the_error_falls_with_the_fourth_power():
    errors = [PointSurface.through(grid(size, size)).error for size in (17, 33)]
    assert 8.0 < errors[0] / errors[1] < 40.0


@pytest.mark.parametrize("size", [1e-4, 1e-3, 3e-3])
def test_noise_is_estimated_and_smoothed(size):
    noisy = grid(81, 61) + size * np.random.default_rng(1).standard_normal((81, 61, 3))
    assert noise_of(noisy) == pytest.approx(size, rel=0.1)
    surface = PointSurface.through(noisy)
    assert surface.smoothing == pytest.approx(size, rel=0.1)
    found = float(np.quantile(error_of(surface), 0.95))
    assert found < 0.3 * size  # as against 2 times the noise of a surface through all points
    assert found < 2.5 * surface.error
    assert surface.error < size


def test_the_error_rises_with_the_noise():
    noise = np.random.default_rng(2).standard_normal((61, 61, 3))
    errors = [PointSurface.through(grid(61, 61) + size * noise).error for size in (0.0, 1e-4, 3e-4, 1e-3, 3e-3)]
    assert np.all(np.diff(errors) > 0.0)


def test_smoothing_can_be_refused_or_ordered():
    noisy = grid(41, 41) + 1e-3 * np.random.default_rng(1).standard_normal((41, 41, 3))
    through = PointSurface.through(noisy, smoothing=0.0)
    assert through.smoothing == 0.0
    assert through.points is noisy
    assert through.error > 1e-3  # the noise is its error, and it says so
    assert PointSurface.through(noisy, smoothing=2e-3).smoothing == 2e-3


def test_smooth_points_are_not_taken_for_noise():
    assert noise_of(grid(41, 41)) < 0.1 * NOISY
    assert noise_of(grid(21, 21)) < NOISY


def test_beyond_its_ends_the_surface_goes_on():
    surface = PointSurface.through(grid(31, 31))
    u, v = (entry.ravel() for entry in np.meshgrid(np.linspace(-2.0, 3.0, 21), np.linspace(-2.0, 3.0, 21)))
    out = np.empty((u.size, 3, 3))
    surface_points(surface.cells, surface.u, surface.v, u, v, out)
    assert np.isfinite(out).all()
    # no jump at the ends, nor where the polynomials give way to slopes
    for border in (0.0, 1.0, -0.05, 1.05):
        sides = np.empty((2, 3, 3))
        surface_points(surface.cells, surface.u, surface.v, border + np.array([-1e-9, 1e-9]), np.full(2, 0.4), sides)
        assert sides[0] == pytest.approx(sides[1], abs=1e-5)


def test_lengths():
    surface = PointSurface.through(grid(31, 31))
    u = np.linspace(0.0, 1.0, 20001)
    line = flank(u, np.zeros(1))[0]
    assert surface.profile_lengths[0] == pytest.approx(np.linalg.norm(np.diff(line, axis=0), axis=1).sum(), rel=1e-6)
