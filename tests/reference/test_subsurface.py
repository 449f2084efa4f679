"""Stress below a contact against closed forms: point, rectangle, circle, Hertz circle and Hertz line."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from semiwear.closed_forms.love_stress import corner_stress, point_stress, rectangle_stress
from semiwear.contact.subsurface import (
    default_depths,
    greatest_subsurface_stress,
    maximum_shear,
    subsurface_stress,
    von_mises,
)

NU = 0.3


def matrices(stress):
    xx, yy, zz, xy, xz, yz = stress
    return np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), (0, 1), (-2, -1))


def point_load(x, y, z, nu):
    """Stress of a unit force on the surface (Johnson 1985, eq. 3.18, with the 2 in xy that turning the axes asks)."""
    r2, rho = x**2 + y**2, np.sqrt(x**2 + y**2 + z**2)
    plane = (1.0 - 2.0 * nu) / r2

    def normal(s, t):
        return plane * ((1.0 - z / rho) * (s**2 - t**2) / r2 + z * t**2 / rho**3) - 3.0 * z * s**2 / rho**5

    return np.array(
        [
            normal(x, y),
            normal(y, x),
            -3.0 * z**3 / rho**5,
            plane * (2.0 * (1.0 - z / rho) * x * y / r2 - x * y * z / rho**3) - 3.0 * x * y * z / rho**5,
            -3.0 * x * z**2 / rho**5,
            -3.0 * y * z**2 / rho**5,
        ]
    ) / (2.0 * np.pi)


def hertz_line_pressure(count, half_width=1.0):
    """Semi-ellipse averaged over equal cells that reach from edge to edge (p0 = 1)."""
    edges = np.linspace(-1.0, 1.0, count + 1)
    area = 0.5 * (edges * np.sqrt(1.0 - edges**2) + np.arcsin(edges))
    return np.diff(area) / np.diff(edges), 2.0 * half_width / count


def line_stress(x, z):
    """xx, zz, xz below a Hertz line of half-width 1 and p0 = 1 (McEwen 1949; Johnson 1985, sec. 4.2c)."""
    half, root = 0.5 * (1.0 - x**2 + z**2), 0.5 * np.sqrt((1.0 - x**2 + z**2) ** 2 + 4.0 * x**2 * z**2)
    m, n = np.sqrt(root + half), np.sign(x) * np.sqrt(root - half)
    share = (z**2 + n**2) / (m**2 + n**2)
    return np.array([-m * (1.0 + share) + 2.0 * z, -m * (1.0 - share), -n * (m**2 - z**2) / (m**2 + n**2)])


def hertz_circle_pressure(count, ratio=1.0):
    """Hertz pressure of radius 1 at the middles of `count` cells across, and their sides."""
    cell = (2.0 / count, 2.0 / count * ratio)
    x = (np.arange(count) + 0.5) * cell[0] - 1.0
    rows = int(np.ceil(1.0 / cell[1]))
    y = (np.arange(2 * rows + 1) - rows) * cell[1]
    return np.sqrt(np.maximum(1.0 - x[:, None] ** 2 - y**2, 0.0)), cell


def hertz_circle_axis(z, nu):
    """Radial and axial stress on the axis of a Hertz circle of radius 1 and p0 = 1 (Johnson 1985, eq. 3.45)."""
    axial = -1.0 / (1.0 + z**2)
    return -(1.0 + nu) * (1.0 - z * np.arctan(1.0 / z)) - 0.5 * axial, axial


# ---------------------------------------------------------------- one rectangle


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("place", [(0, 0), (2, 1), (1, 3), (0, 2)])
def test_rectangle_against_the_integrated_point_load(place, nu):
    cell, depth = (0.7, 1.3), 0.6
    points, weights = np.polynomial.legendre.leggauss(60)  # even, so that none lies below the load
    x, y = place[0] * cell[0] + 0.5 * cell[0] * points, place[1] * cell[1] + 0.5 * cell[1] * points
    expected = point_load(x[:, None], y, depth, nu) @ weights @ weights * 0.25 * cell[0] * cell[1]
    found = rectangle_stress(4, 4, cell=cell, depth=depth, poissons_ratio=nu)[:, *place]
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-9)


def test_a_far_rectangle_is_a_point_load():
    found = rectangle_stress(1201, 901, cell=(0.01, 0.01), depth=5.0, poissons_ratio=NU)[:, -1, -1]
    np.testing.assert_allclose(found, point_load(12.0, 9.0, 5.0, NU) * 1e-4, rtol=1e-6)


@pytest.mark.parametrize("place", [(0.3, -0.2), (1.7, 0.4), (-0.6, -2.0)])
def test_equilibrium_below_a_rectangle(place):
    """The divergence of the stress vanishes."""
    step, depth = 1e-3, 0.5

    def stress(x, y, z):
        ends = (1.0, -1.0), (0.5, -0.5)
        corners = corner_stress(x + np.array(ends[0])[:, None], y + np.array(ends[1]), z, NU)
        return corners[:, 0, 0] - corners[:, 0, 1] - corners[:, 1, 0] + corners[:, 1, 1]

    slope = []
    for axis in range(3):
        offset = np.eye(3)[axis] * step
        ahead, behind = (stress(*(np.array([*place, depth]) + sign * offset)) for sign in (1.0, -1.0))
        slope.append((ahead - behind) / (2.0 * step))
    tensor = matrices(np.array(slope).T)
    np.testing.assert_allclose(np.einsum("kik->i", tensor), 0.0, atol=2e-6)


@pytest.mark.parametrize("cell", [(1.0, 1.0), (100.0, 1.0), (1.0, 100.0), (1e-4, 1e-2)])
def test_surface_below_a_rectangle(cell):
    """Just below the surface sigma_z is -p inside and 0 outside, and the surface is free of shear."""
    depth = 1e-9 * min(cell)
    stress = rectangle_stress(5, 5, cell=cell, depth=depth, poissons_ratio=NU)
    inside = np.zeros((5, 5))
    inside[0, 0] = -1.0
    np.testing.assert_allclose(stress[2], inside, atol=1e-8)
    np.testing.assert_allclose(stress[4:], 0.0, atol=1e-8)
    # sigma_x + sigma_y = -(1 + 2 nu) p there, shared by the angle that the rectangle takes at its middle
    np.testing.assert_allclose(stress[0] + stress[1], (1.0 + 2.0 * NU) * inside, atol=1e-8)
    shared = 2.0 / np.pi * np.arctan(cell[1] / cell[0])
    assert stress[0, 0, 0] == pytest.approx(-2.0 * NU - (1.0 - 2.0 * NU) * shared, abs=1e-8)


@pytest.mark.parametrize("cell", [(0.01, 1.0), (1.0, 0.01), (0.1, 0.1)])
@pytest.mark.parametrize("depth", [1e-6, 1e-3, 0.1, 10.0])
def test_cells_against_higher_precision(cell, depth):
    """Nothing is lost in long cells, near the surface or far away."""
    if np.finfo(np.longdouble).eps > 1e-18:
        pytest.skip("no extended precision on this machine")
    x, y = ((np.arange(41, dtype=np.longdouble) - 0.5) * np.longdouble(side) for side in cell)
    z, nu = np.longdouble(depth), np.longdouble(NU)
    X, Y = x[:, None], y[None, :]
    rho = np.sqrt(X**2 + Y**2 + z**2)
    angle = np.arctan(X * Y / (z * rho))
    axial = -angle - z * X * Y / rho * (1 / (X**2 + z**2) + 1 / (Y**2 + z**2))
    across = (
        z * X * Y / (rho * (X**2 + z**2))
        - 2 * nu * angle
        - (1 - 2 * nu) * (np.arctan(Y / X) - np.arctan(z * Y / (X * rho)))
    )
    stress = rectangle_stress(40, 40, cell=cell, depth=depth, poissons_ratio=NU)
    for found, corner in ((stress[2], axial), (stress[0], across)):
        expected = np.diff(np.diff(corner, axis=0), axis=1) / (2 * np.longdouble(np.pi))
        np.testing.assert_allclose(found, expected.astype(float), rtol=0.0, atol=1e-15)


# ---------------------------------------------------------------- circles


@pytest.mark.parametrize("ratio", [1.0, 0.31, 4.0])
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_hertz_circle_on_its_axis(nu, ratio):
    pressure, cell = hertz_circle_pressure(81, ratio)
    depths = np.array([0.1, 0.48, 1.0, 2.5])
    stress = subsurface_stress(pressure, cell=cell, poissons_ratio=nu, depths=depths)
    axis = stress[:, :, 40, pressure.shape[1] // 2]
    radial, axial = hertz_circle_axis(depths, nu)
    # in a circle of oblong cells sigma_x and sigma_y differ a little
    tolerance = 5e-4 if ratio <= 1.0 else 3e-3
    np.testing.assert_allclose(axis[2], axial, atol=tolerance)
    np.testing.assert_allclose(axis[:2], [radial, radial], atol=tolerance)
    np.testing.assert_allclose(axis[3:], 0.0, atol=1e-12)


@pytest.mark.parametrize(("nu", "shear", "depth"), [(0.3, 0.310, 0.48), (0.0, 0.3849, 0.38), (0.4, 0.288, 0.51)])
def test_greatest_stress_below_a_hertz_circle(nu, shear, depth):
    pressure, cell = hertz_circle_pressure(81)
    found = greatest_subsurface_stress(pressure, cell=cell, poissons_ratio=nu)

    def half_difference(z):
        radial, axial = hertz_circle_axis(z, nu)
        return -0.5 * (radial - axial)

    exact = minimize_scalar(half_difference, bounds=(0.2, 1.0), method="bounded", options={"xatol": 1e-9})
    assert found.shear == pytest.approx(-exact.fun, rel=5e-4)
    assert found.shear_depth == pytest.approx(exact.x, rel=5e-3)
    assert found.shear == pytest.approx(shear, abs=1e-3 if nu else 0.02)  # as the textbook has it
    assert found.shear_depth == pytest.approx(depth, abs=0.01 if nu else 0.03)
    # two equal principal stresses: von Mises is twice the shear
    assert found.von_mises == pytest.approx(2.0 * found.shear, rel=1e-4)
    assert found.von_mises_depth == pytest.approx(found.shear_depth, rel=1e-3)
    assert found.shear_place == found.von_mises_place == (40, pressure.shape[1] // 2)


def test_greatest_stress_does_not_sit_on_the_given_depths():
    pressure, cell = hertz_circle_pressure(41)
    fine = greatest_subsurface_stress(pressure, cell=cell, poissons_ratio=NU)
    coarse = greatest_subsurface_stress(pressure, cell=cell, poissons_ratio=NU, depths=[1.1, 0.2, 0.7])
    assert coarse.shear == pytest.approx(fine.shear, rel=1e-7)
    assert coarse.shear_depth == pytest.approx(fine.shear_depth, rel=1e-3)
    only = greatest_subsurface_stress(pressure, cell=cell, poissons_ratio=NU, depths=[0.8])
    assert only.shear_depth == only.von_mises_depth == 0.8
    below = greatest_subsurface_stress(pressure, cell=cell, poissons_ratio=NU, depths=[0.9, 1.5])
    assert below.shear_depth == 0.9


def test_refinement_converges_on_the_hertz_circle():
    errors = []
    for count in (9, 27, 81):
        pressure, cell = hertz_circle_pressure(count)
        radial, axial = hertz_circle_axis(np.array([0.48]), NU)
        middle = (count // 2, pressure.shape[1] // 2)
        found = point_stress(pressure, middle, cell=cell, depth=0.48, poissons_ratio=NU)
        errors.append(max(abs(found[2] - axial[0]), abs(found[0] - radial[0])))
    assert errors[1] < 0.25 * errors[0]
    assert errors[2] < 0.25 * errors[1]


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_uniform_circle_on_its_axis(nu):
    """Johnson 1985, eq. 3.33; cells at the rim carry the share of them that the circle covers."""
    count, fine = 61, 20
    x = (np.arange(count * fine) + 0.5) * 2.0 / (count * fine) - 1.0
    covered = (x[:, None] ** 2 + x**2 < 1.0).astype(float)
    pressure = covered.reshape(count, fine, count, fine).mean(axis=(1, 3))
    z = np.array([0.2, 0.6, 1.5])
    stress = subsurface_stress(pressure, cell=(2.0 / count, 2.0 / count), poissons_ratio=nu, depths=z)
    axis = stress[:, :, count // 2, count // 2]
    far = np.sqrt(1.0 + z**2)
    np.testing.assert_allclose(axis[2], -1.0 + (z / far) ** 3, atol=3e-4)
    radial = -0.5 * (1.0 + 2.0 * nu) + (1.0 + nu) * z / far - 0.5 * (z / far) ** 3
    np.testing.assert_allclose(axis[:2], [radial, radial], atol=3e-4)


@pytest.mark.parametrize(
    ("ratio", "shear", "depth"), [(0.2, 0.322, 0.745), (0.4, 0.325, 0.665), (0.6, 0.323, 0.590), (0.8, 0.317, 0.530)]
)
@pytest.mark.parametrize("counts", [(61, 61), (61, 15), (41, 201)])
def test_greatest_stress_below_a_hertz_ellipse(ratio, shear, depth, counts):
    """Johnson 1985, table 4.1, for nu = 0.3, in half-widths b across the ellipse."""
    x, y = (2.0 * (np.arange(count) - count // 2) / count for count in counts)
    pressure = np.sqrt(np.maximum(1.0 - x[:, None] ** 2 - y**2, 0.0))
    cell = (2.0 / counts[0], 2.0 / counts[1] / ratio)
    found = greatest_subsurface_stress(pressure, cell=cell, poissons_ratio=NU)
    assert found.shear_place == (counts[0] // 2, counts[1] // 2)
    assert found.shear == pytest.approx(shear, abs=1.5e-3)
    assert found.shear_depth == pytest.approx(depth, abs=0.015)


# ---------------------------------------------------------------- lines


@pytest.mark.parametrize("rows", [1, 5])
@pytest.mark.parametrize("turned", [False, True])
def test_hertz_line_against_mcewen(rows, turned):
    """Everywhere below a very long line, in very long cells; along it the strain vanishes."""
    across, width = hertz_line_pressure(200)
    z = np.array([0.05, 0.3, 0.786, 2.0])
    pressure, cell = np.repeat(across[:, None], rows, axis=1), (width, 1e6 / rows)
    if turned:
        pressure, cell = pressure.T, cell[::-1]
    stress = subsurface_stress(pressure, cell=cell, poissons_ratio=NU, depths=z)
    if turned:
        stress = stress.swapaxes(2, 3)[[1, 0, 2, 3, 5, 4]]
    found = stress[:, :, :, rows // 2]
    x = (np.arange(200) + 0.5) * width - 1.0
    xx, zz, xz = line_stress(x, z[:, None])
    inner = np.abs(x) < 0.98
    for values, expected in ((found[0], xx), (found[2], zz), (found[4], xz), (found[1], NU * (xx + zz))):
        np.testing.assert_allclose(values[:, inner], expected[:, inner], atol=1e-3)
    np.testing.assert_allclose(found[3], 0.0, atol=1e-12)
    np.testing.assert_allclose(found[5], 0.0, atol=1e-12)


def test_hertz_line_on_its_axis():
    across, width = hertz_line_pressure(401)
    z = np.array([0.2, 0.786, 1.5])
    found = np.array(
        [point_stress(across[:, None], (200, 0), cell=(width, 1e6), depth=d, poissons_ratio=NU) for d in z]
    ).T
    root = np.sqrt(1.0 + z**2)
    np.testing.assert_allclose(found[0], -(1.0 + 2.0 * z**2) / root + 2.0 * z, atol=1e-5)
    np.testing.assert_allclose(found[2], -1.0 / root, atol=1e-5)


def test_greatest_stress_below_a_hertz_line():
    across, width = hertz_line_pressure(81)
    found = greatest_subsurface_stress(across[:, None], cell=(width, 1e6), poissons_ratio=NU)
    assert found.shear == pytest.approx(0.30028, rel=3e-4)
    assert found.shear_depth == pytest.approx(0.78615, rel=1e-3)
    assert found.shear_place == (40, 0)

    # von Mises of McEwen's stresses on the axis, in plane strain
    def equivalent(depth):
        xx, zz, _ = line_stress(np.array(1e-12), depth)
        return -von_mises(np.array([xx, NU * (xx + zz), zz, 0.0, 0.0, 0.0]))

    exact = minimize_scalar(equivalent, bounds=(0.3, 1.2), method="bounded", options={"xatol": 1e-9})
    assert found.von_mises == pytest.approx(-exact.fun, rel=3e-4)
    assert found.von_mises_depth == pytest.approx(exact.x, rel=2e-3)


def test_a_spike_on_a_wide_contact_is_found_at_its_own_depth():
    across, width = hertz_line_pressure(100)
    pressure = np.repeat(across[:, None], 40, axis=1)
    pressure[70, 20] += 5.0
    found = greatest_subsurface_stress(pressure, cell=(width, width), poissons_ratio=NU)
    alone = greatest_subsurface_stress(np.array([[5.0]]), cell=(width, width), poissons_ratio=NU)
    assert found.shear_place == found.von_mises_place == (70, 20)
    assert found.shear_depth == pytest.approx(alone.shear_depth, rel=0.1)
    assert found.shear == pytest.approx(alone.shear, rel=0.1)


def test_two_contacts_side_by_side_keep_their_depth():
    """The default depths follow the loaded stretches, not the distance of two lines."""
    across, width = hertz_line_pressure(21)
    pressure = np.concatenate([across, np.zeros(300), 1.1 * across])[:, None]
    found = greatest_subsurface_stress(pressure, cell=(width, 500.0), poissons_ratio=NU)
    assert found.shear == pytest.approx(1.1 * 0.3003, rel=1e-2)
    assert found.shear_depth == pytest.approx(0.786, rel=3e-2)
    assert found.shear_place == (331, 0)


# ---------------------------------------------------------------- the whole field


def test_every_plane_carries_the_load():
    """What lies outside a square plane is known: by reciprocity, the stress below a square under pressure."""
    pressure = np.zeros((161, 161))
    pressure[80, 80] = 3.0
    side, z = 0.25, np.array([0.7, 2.0, 4.0])
    stress = subsurface_stress(pressure, cell=(side, side), poissons_ratio=NU, depths=z)
    half = 80.5 * side
    for k, depth in enumerate(z):
        inside = 4.0 * corner_stress(np.array(half), np.array(half), depth, NU)[2]
        assert inside < -0.98
        assert stress[2, k].sum() == pytest.approx(3.0 * inside, rel=1e-4)
        np.testing.assert_allclose(stress[3:, k].sum(axis=(1, 2)), 0.0, atol=1e-10)


def test_field_against_the_sum_over_corners():
    generator = np.random.default_rng(5)
    pressure, cell = generator.random((13, 8)), (0.02, 0.7)
    stress = subsurface_stress(pressure, cell=cell, poissons_ratio=0.25, depths=[0.01, 0.4])
    for k, depth in enumerate((0.01, 0.4)):
        for place in ((0, 0), (12, 7), (4, 6), (9, 1)):
            expected = point_stress(pressure, place, cell=cell, depth=depth, poissons_ratio=0.25)
            np.testing.assert_allclose(stress[:, k, *place], expected, atol=1e-13)


def test_equivalent_stresses_against_principal_stresses():
    generator = np.random.default_rng(3)
    stress = generator.normal(size=(6, 500))
    stress[:, :100] = np.array([1.0, 1.0, -2.0, 0.0, 0.0, 0.0])[:, None] + 1e-9 * stress[:, :100]
    principal = np.linalg.eigvalsh(matrices(stress))
    np.testing.assert_allclose(maximum_shear(stress), 0.5 * (principal[:, 2] - principal[:, 0]), rtol=1e-7)
    squares = (np.diff(principal, axis=1) ** 2).sum(axis=1) + (principal[:, 2] - principal[:, 0]) ** 2
    np.testing.assert_allclose(von_mises(stress), np.sqrt(0.5 * squares), rtol=1e-10)
    assert maximum_shear(np.zeros(6)) == von_mises(np.zeros(6)) == 0.0
    assert maximum_shear(np.array([5.0, 5.0, 5.0, 0.0, 0.0, 0.0])) == 0.0


def test_default_depths_hold_the_narrow_and_the_whole():
    pressure, cell = hertz_circle_pressure(41)
    depths = default_depths(pressure, cell=cell)
    assert 0.01 < depths[0] <= 0.02
    assert 2.7 < depths[-1] < 3.3
    assert np.all(np.diff(depths) > 0.0)
    assert depths.size < 25


def test_without_load_all_is_zero():
    empty = np.zeros((4, 5))
    found = greatest_subsurface_stress(empty, cell=(0.1, 0.1), poissons_ratio=NU)
    assert (found.von_mises, found.von_mises_depth, found.shear, found.shear_depth) == (0.0, 0.0, 0.0, 0.0)
    assert not subsurface_stress(empty, cell=(0.1, 0.1), poissons_ratio=NU, depths=[0.1]).any()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"pressure": np.ones(4)}, r"pressure: found 'shape \(4,\)'.*nx, ny"),
        ({"pressure": np.ones((0, 4))}, "pressure"),
        ({"pressure": np.array([[1.0, np.nan]])}, r"pressure: found 'nan at \(0, 1\)'.*finite"),
        ({"cell": (0.1, 0.0)}, "cell.*positive"),
        ({"cell": (0.1,)}, "cell.*two"),
        ({"cell": (0.1, np.nan)}, "cell"),
        ({"poissons_ratio": -0.1}, "poissons_ratio: found -0.1; allowed: 0 to 0.5"),
        ({"poissons_ratio": 0.51}, "poissons_ratio"),
        ({"poissons_ratio": np.nan}, "poissons_ratio"),
        ({"depths": [0.1, 0.0]}, "depths: found 0.0; allowed: positive"),
        ({"depths": []}, "depths"),
        ({"depths": [np.inf]}, "depths: found inf"),
        ({"depths": np.ones((2, 2))}, "depths"),
    ],
)
def test_errors_say_what_to_change(changes, message):
    arguments = {"pressure": np.ones((3, 4)), "cell": (0.1, 0.1), "poissons_ratio": NU, "depths": [0.1]} | changes
    pressure = arguments.pop("pressure")
    for function in (subsurface_stress, greatest_subsurface_stress):
        with pytest.raises(ValueError, match=message):
            function(pressure, **arguments)
