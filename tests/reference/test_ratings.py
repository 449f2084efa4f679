"""Pitting and bending against worked examples of a public program, and against published exponents.

The program is Gear-Calculation by C. Fernandes (FEUP, github.com/cfernandesFEUP/Gear-Calculation, commit 0e4a135),
its module GearC/DIN3990.py: three of the gear sets that it ships, 130 N m on the pinion at 1406.25 rev/min, oil P150,
steel of 1500 and 430 MPa, Rz 4.8 um on both flanks. Figures are as it prints them, and those of Z_v and Y_delta_relT
as its comments would. Examples of ISO/TR 6336-30 and ISO 6336-6 are in `test_worked_examples.py`.
"""

from dataclasses import dataclass
from math import cos, radians

import numpy as np
import pytest

from semiwear.ratings.bending import (
    bending_curve,
    relative_notch_sensitivity_factor,
    relative_surface_factor,
    size_factor,
)
from semiwear.ratings.bending import life_points as bending_points
from semiwear.ratings.pitting import (
    life_points,
    lubricant_factor,
    pitting_curve,
    roughness_factor,
    velocity_factor,
)

VISCOSITY = 148.94161893989624  # mm2/s at 40 degrees Celsius
RZ = 4.8


@dataclass(frozen=True)
class Example:
    """A gear set of the program, and what it prints."""

    module: float
    helix: float
    teeth: tuple[int, int]
    centre: float
    speed: float
    z_v: float
    z_r: float
    contact: tuple[float, float]
    permissible: float
    safety: tuple[float, float]
    y_delta: tuple[float, float]
    root: tuple[float, float]
    limit_root: tuple[float, float]


C14 = Example(
    module=4.5,
    helix=0.0,
    teeth=(16, 24),
    centre=91.50007859607446,
    speed=5.3014376029327825,
    z_v=0.9835456108258777,
    z_r=0.9601145374932925,
    contact=(1141.94736697, 1062.39640779),
    permissible=1404.65762071,
    safety=(1.23005461, 1.32215961),
    y_delta=(0.99420974, 0.99581949),
    root=(196.29911409, 190.31310897),
    limit_root=(818.25450427, 819.57935412),
)
H501 = Example(
    module=3.5,
    helix=15.0,
    teeth=(20, 30),
    centre=91.50025755899904,
    speed=5.335995070239781,
    z_v=0.9836993681727114,
    z_r=0.9601145875696769,
    contact=(861.5096269, 843.72746824),
    permissible=1404.87728363,
    safety=(1.63071571, 1.66508421),
    y_delta=(0.99775489, 0.99807992),
    root=(163.90959751, 164.27792376),
    limit_root=(821.17222968, 821.43973725),
)
H951 = Example(
    module=1.75,
    helix=15.0,
    teeth=(38, 57),
    centre=91.50001373492388,
    speed=5.069195316727791,
    z_v=0.9824943608901415,
    z_r=0.9601145193441919,
    contact=(889.40135159, 889.40132886),
    permissible=1403.15624416,
    safety=(1.57764123, 1.57764127),
    y_delta=(0.99755669, 0.99299034),
    root=(258.98529404, 245.44518073),
    limit_root=(821.0091076, 817.25091094),
)
EXAMPLES = pytest.mark.parametrize("example", [C14, H501, H951], ids=["C14", "H501", "H951"])


@EXAMPLES
def test_film_factors(example):
    assert lubricant_factor(1500.0, VISCOSITY) == pytest.approx(0.9916574305959553, rel=1e-12)
    assert velocity_factor(1500.0, example.speed) == pytest.approx(example.z_v, rel=1e-12)


@EXAMPLES
def test_permissible_pressure_and_safety(example):
    """With its Z_R, which it takes from DIN 3990: from the centre distance and not from the curvature."""
    film = lubricant_factor(1500.0, VISCOSITY) * velocity_factor(1500.0, example.speed) * example.z_r
    permissible = float(pitting_curve(1500.0, "hardened", 0.85, film, 1.0).permissible(5e7))
    # 1.02 for (6/100^(1/3))^0.08, which is 1.0208
    assert permissible == pytest.approx(example.permissible, rel=1e-8)
    for stress, safety in zip(example.contact, example.safety, strict=True):
        assert permissible / stress == pytest.approx(safety, rel=1e-8)


@EXAMPLES
def test_roughness_by_curvature_is_near_that_by_centre_distance(example):
    """ISO 6336-2 takes the relative curvature where DIN 3990 takes a/100, so that Z_R differs by less than 1 %."""
    z1, z2 = example.teeth
    sine = np.sqrt(1.0 - (_base_sum(example) / (2.0 * example.centre)) ** 2)
    radius = example.centre * sine * z1 * z2 / (z1 + z2) ** 2 / cos(radians(example.helix))
    assert roughness_factor(1500.0, RZ, radius) == pytest.approx(example.z_r, rel=0.01)
    by_distance = (3.0 / (RZ * (100.0 / example.centre) ** (1.0 / 3.0))) ** 0.08
    assert by_distance == pytest.approx(example.z_r, rel=1e-3)


def _base_sum(example):
    helix = radians(example.helix)
    alpha_t = np.arctan(np.tan(radians(20.0)) / cos(helix))
    return example.module / cos(helix) * sum(example.teeth) * np.cos(alpha_t)


@EXAMPLES
def test_limit_and_safety_of_the_root(example):
    """Its Y_R_relT is 0.957, that of Rz 20 um; its Y_delta_relT has four digits in its coefficients."""
    surface = relative_surface_factor("case_hardened", 20.0)
    assert surface == pytest.approx(0.957, abs=3e-4)
    for y_delta, limit, stress in zip(example.y_delta, example.limit_root, example.root, strict=True):
        notch = ((y_delta - 0.9434) / 0.0231) ** 2  # 1 + 2 q_s, from its formula
        found = relative_notch_sensitivity_factor(0.5 * (notch - 1.0), 0.0030)
        assert found == pytest.approx(y_delta, abs=1e-4)
        curve = bending_curve(430.0, "case_hardened", 0.85, y_delta, 0.957, 1.0)
        assert float(curve.permissible(3e6)) == pytest.approx(limit, rel=1e-8)
        assert curve.permissible(3e6) / stress == pytest.approx(limit / stress, rel=1e-8)


# Life factors between their points, as ISO 6336-2, -3 and class rules (DNVGL-CG-0036) write them.
@pytest.mark.parametrize(
    ("points", "group", "reference", "exponent", "cycles"),
    [
        (life_points, "hardened", 5e7, 0.0756, (1e5, 5e7)),
        (life_points, "hardened", 5e7, 0.0306, (5e7, 1e10)),
        (life_points, "hardened_some_pits", 3e8, 0.0756, (6e5, 1e7)),
        (life_points, "hardened_some_pits", 1e9, 0.057, (1e7, 1e9)),
        (life_points, "nitrided", 2e6, 0.0875, (1e5, 2e6)),
        (life_points, "nitrided", 2e6, 0.0191, (2e6, 1e10)),
        (life_points, "nitrocarburized", 2e6, 0.0318, (1e5, 2e6)),
        (bending_points, "through_hardened", 3e6, 0.16, (1e4, 3e6)),
        (bending_points, "case_hardened", 3e6, 0.115, (1e3, 3e6)),
        (bending_points, "nitrided", 3e6, 0.059, (1e3, 3e6)),
        (bending_points, "nitrocarburized", 3e6, 0.012, (1e3, 3e6)),
        (bending_points, "case_hardened", 3e6, 0.02, (3e6, 1e10)),
    ],
)
def test_life_factors_follow_their_published_powers(points, group, reference, exponent, cycles):
    known, factors = np.log(np.array(points(group, 0.85))).T
    at = np.linspace(*np.log(cycles), 7)
    found = np.exp(np.interp(at, known, factors))
    np.testing.assert_allclose(found, (reference / np.exp(at)) ** exponent, rtol=0.01)


def test_normalized_steel_and_cast_iron_have_factors_of_their_own():
    # ISO 6336-3, 14.3 (St; GG and GGG ferritic) and table of Y_X, whose lines meet 1 at a module of 5 mm
    assert [relative_surface_factor("normalized", rz) for rz in (1.0, 20.0, 40.0)] == pytest.approx(
        [1.074, 0.973, 0.944], abs=1e-3
    )
    assert relative_surface_factor("cast_iron", 20.0) == relative_surface_factor("nitrided", 20.0)
    assert [size_factor("cast_iron", m) for m in (3.0, 5.0, 20.0, 25.0, 30.0)] == pytest.approx(
        [1.0, 1.0, 0.775, 0.70, 0.70]
    )
    assert size_factor("normalized", 20.0) == size_factor("through_hardened", 20.0)


def test_oils_beyond_the_standards_figure_count_as_its_last_one():
    assert lubricant_factor(700.0, 1000.0) == lubricant_factor(700.0, 500.0) > lubricant_factor(700.0, 460.0)


def test_size_factors():
    assert [size_factor("case_hardened", m) for m in (3.0, 5.0, 10.0, 25.0, 40.0)] == pytest.approx(
        [1.0, 1.0, 0.95, 0.8, 0.8]
    )
    assert [size_factor("through_hardened", m) for m in (5.0, 10.0, 30.0, 40.0)] == pytest.approx(
        [1.0, 0.97, 0.85, 0.85]
    )
