"""Flank fracture against integrals over planes, the half-space's own stresses and limits.

No worked example could be had with its inputs; docs/failure_modes.md says what was looked for.
"""

from math import pi, sqrt

import numpy as np
import pytest
from scipy.integrate import dblquad, quad

from semiwear.closed_forms import effective_modulus, line_contact_half_width, line_contact_pressure
from semiwear.ratings.flank_fracture import (
    FlankMaterial,
    flank_fracture_safety,
    line_contact_stress,
    material_exposure,
    shear_stress_intensity,
)
from semiwear.ratings.hardness import hardness_of_case, hardness_of_table, residual_stress

MODULUS = effective_modulus(206e3, 0.3, 206e3, 0.3)
CASE = FlankMaterial(hardness_of_case(700.0, 400.0, 0.8), 400.0)


@pytest.mark.parametrize("stress", [(900.0, 0.0, 0.0), (0.0, 500.0, -500.0), (-200.0, -450.0, -1100.0)])
def test_intensity_is_the_mean_square_of_shear_over_all_planes(stress):
    def shear_squared(polar: float, azimuth: float) -> float:
        normal = np.array([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)])
        traction = np.array(stress) * normal
        return float((traction @ traction - (traction @ normal) ** 2) * np.sin(polar))

    mean = dblquad(shear_squared, 0.0, 2.0 * pi, 0.0, pi)[0] / (4.0 * pi)
    assert shear_stress_intensity(np.array(stress)) == pytest.approx(sqrt(mean), rel=1e-8)


@pytest.mark.parametrize("depth", [0.3, 0.786, 2.0, 9.0])
def test_stress_below_a_line_contact(depth):
    """Flamant's line forces summed over the Hertz pressure (Johnson 1985, eqs. 2.23)."""

    def share(x: float, power: int) -> float:
        return 2.0 / pi * sqrt(1.0 - x * x) * depth ** (3 - power) * x**power / (x * x + depth**2) ** 2

    across = -quad(share, -1.0, 1.0, args=(2,))[0]
    normal = -quad(share, -1.0, 1.0, args=(0,))[0]
    found = line_contact_stress(1.0, depth)
    assert found == pytest.approx(np.array([across, 0.3 * (across + normal), normal]), rel=1e-7)


def test_greatest_shear_below_a_line_contact():
    """Johnson 1985, eq. 4.47: 0.300 p0 at 0.786 half-widths, and the von Mises stress 0.557 p0 at 0.704."""
    depth = np.linspace(0.1, 3.0, 29001)
    stress = line_contact_stress(1.0, depth)
    shear = 0.5 * (stress[0] - stress[2])
    assert (shear.max(), depth[shear.argmax()]) == pytest.approx((0.300, 0.786), abs=6e-4)
    mises = sqrt(7.5) * shear_stress_intensity(stress)
    assert (mises.max(), depth[mises.argmax()]) == pytest.approx((0.557, 0.704), abs=1e-3)


def test_exposure_of_steel_hard_throughout():
    """Without a case there is no residual stress: the intensity one half-width down over 0.4 HV, and 0.04."""
    pressure = 1200.0
    width = float(line_contact_half_width(np.array(1.0), np.array(0.05), MODULUS))
    steel = FlankMaterial(lambda depth: np.full_like(np.asarray(depth, float), 350.0), 350.0)
    exposure, depth = material_exposure(pressure, width, steel)
    at_width = float(shear_stress_intensity(line_contact_stress(pressure, 1.0)))
    assert exposure == pytest.approx(at_width / (0.4 * 350.0) + 0.04, rel=1e-12)
    assert depth == pytest.approx(width, rel=1e-12)


def test_greatest_exposure_is_found_between_the_depths_looked_at():
    pressure, width = 1400.0, 0.45
    depth = np.linspace(width, 12.0 * width, 200_001)
    stress = line_contact_stress(pressure, depth / width)
    residual = residual_stress(CASE.hardness(depth), CASE.core)
    stress[:2] += residual
    shear = np.maximum(shear_stress_intensity(stress) - sqrt(2.0 / 15.0) * np.abs(residual), 0.0)
    fine = shear / (0.4 * CASE.hardness(depth)) + 0.04
    exposure, where = material_exposure(pressure, width, CASE)
    assert exposure == pytest.approx(fine.max(), rel=1e-3)
    assert where == pytest.approx(depth[fine.argmax()], rel=0.02)


def test_fracture_starts_at_the_foot_of_the_case():
    """With a case that is thin against the contact (Witzig 2012; ISO/TS 6336-4, clause 4): at 1 to 2 case depths."""
    load, curvature = np.array([900.0, 1400.0]), np.full(2, 1.0 / 20.0)
    width = line_contact_half_width(load, curvature, MODULUS)
    _, depth = material_exposure(line_contact_pressure(load, curvature, MODULUS), width, CASE)
    assert ((depth / 0.8 > 0.8) & (depth / 0.8 < 2.5)).all()


def test_flanks_without_load_are_safe():
    exposure, depth = material_exposure(np.array([[0.0, 1500.0]]), np.array([[np.nan, 0.5]]), CASE)
    assert exposure[0, 0] == 0.0 and depth[0, 0] == 0.0 and exposure[0, 1] > 0.5
    assert flank_fracture_safety(exposure)[0, 0] == np.inf
    assert flank_fracture_safety(0.8) == pytest.approx(1.0)


def test_case_depth_is_where_550_are_left():
    """ISO 18203, for any surface and core; with 750 and 353 HV it is Lang's own curve."""
    for surface, core, depth in ((700.0, 350.0, 0.5), (760.0, 430.0, 2.0), (640.0, 300.0, 1.0)):
        hardness = hardness_of_case(surface, core, depth)
        assert hardness([0.0, depth, 20.0 * depth]) == pytest.approx([surface, 550.0, core], rel=1e-9)
    lang = 353.0 + 397.0 * 10.0 ** -(0.0381 * 0.5 + 0.2662 * 0.25)
    assert hardness_of_case(750.0, 353.0, 1.0)(0.5) == pytest.approx(lang, rel=1e-3)


def test_table_of_hardness():
    hardness = hardness_of_table([0.1, 0.5, 1.0], [720.0, 600.0, 420.0])
    assert hardness([0.0, 0.3, 0.75, 3.0]) == pytest.approx([720.0, 660.0, 510.0, 420.0])


def test_residual_stress_of_a_case():
    """Lang's two lines meet at 300 HV above the core within 1 MPa, and a core has none."""
    hardness = np.array([380.0, 400.0, 500.0, 700.0, 700.001, 760.0])
    assert residual_stress(hardness, 400.0) == pytest.approx([0.0, 0.0, -125.0, -375.0, -374.3, -357.1], abs=0.1)
