"""Estimates of wear for whole flanks: VDI 2736 against a report of the FVA-Workbench, Plewe's against its test."""

from math import cos, pi, radians

import numpy as np
import pytest

import semiwear as sw
from semiwear.ratings.plastic_wear import (
    active_profile_length,
    loss_factor,
    of_temperature,
    permissible_wear,
    plastic_wear,
    tooth_temperature,
)
from semiwear.ratings.slow_speed_wear import slow_speed_wear
from tests.strategies.spur_pair import C_GF

# Steel pinion and plastic wheel, z = 51/52, m_n = 1 mm, b = 15 mm: a report of the FVA-Workbench as the tests of an
# open program quote it (its kst-E example, 2026)
TEETH, LOSS = (51, 52), 0.0626


def test_loss_factor_of_the_report():
    """H_V = 0.0626 from the report's own contact ratios 0.600 and 0.554."""
    assert loss_factor(TEETH, (0.600, 0.554)) == pytest.approx(LOSS, abs=2e-4)


def test_wear_of_the_report():
    """W_m = 40.151 um of the wheel in 1.324e7 turns under 8.00 N m with k_w = 1e-6 mm^3/(N m)."""
    wear = plastic_wear(8.00, 1.324e7, LOSS, 1e-6, 15.0, 52, 1.330)
    assert 1e3 * wear == pytest.approx(40.151, rel=1e-3)
    assert permissible_wear(1.0) == pytest.approx(0.1)


def test_wear_of_the_reports_pinion():
    """The same work on 51 teeth of 1.349 mm: 7.85 N m and 1.350e7 turns."""
    wheel = plastic_wear(8.00, 1.324e7, LOSS, 1e-6, 15.0, 52, 1.330)
    pinion = plastic_wear(7.85, 1.350e7, LOSS, 1e-6, 15.0, 51, 1.349)
    assert pinion / wheel == pytest.approx(52.0 * 1.330 / (51.0 * 1.349), rel=2e-3)


def test_temperature_of_the_report():
    """theta = 107.767 degC: 1848.706 W, mu 0.04, 80 degC around, housing of 0.060 K m^2/W and 0.010 m^2."""
    assert tooth_temperature(80.0, 1848.706 * 0.04 * LOSS, 0.0, 0.060 / 0.010) == pytest.approx(107.767, abs=0.03)


def test_wear_is_archards_over_the_flank():
    """k_w times force times sliding distance of one mesh, spread over the flank: the loss factor is their mean."""
    base, force = [0.5 * z * cos(radians(20.0)) for z in TEETH], 100.0
    pitch = 2.0 * pi * base[0] / TEETH[0]
    first, second = 0.6, 0.554
    path = np.linspace(-second * pitch, first * pitch, 200_001)
    sliding = np.abs(path) * (1.0 / base[0] + 1.0 / base[1])  # over the way along the path of contact
    alone = (path > path[-1] - pitch) & (path < path[0] + pitch)
    load = np.where(alone, force, 0.5 * force)
    way = float(np.trapezoid(load * sliding, path))
    torque = 1e-3 * force * base[1]
    ours = plastic_wear(torque, 1.0, loss_factor(TEETH, (first, second)), 1e-6, 15.0, 52, 1.33)
    assert ours == pytest.approx(1e-9 * way / (15.0 * 1.33), rel=1e-3)


def test_beside_the_local_wear_of_fresh_flanks():
    """The volume that VDI 2736 spreads evenly is the local one within 1 %; locally it is some 3.5 times as deep.

    Loads are shared as stiff teeth share them, not evenly, and the flanks do not wear at the pitch point.
    """
    meshes, coefficient = 1e5, 1e-13  # of a gear tooth, mm^2/N
    grid = {"face_slices": 11, "roll_positions": 32, "profile_points": 121, "harmonics": 3, "wear_steps": 1}
    changes = {f"numerics.{name}": value for name, value in grid.items()}
    tree = sw.simulate(sw.load_scene("spur_fzg_c").replace(changes | {"wear.until.meshes": meshes}))
    base, tip = C_GF.base_radius, C_GF.tip_curvature
    loss = loss_factor(C_GF.teeth, C_GF.addendum_ratios)
    for body, teeth, torque, turns in ((0, 16, 302.0, 1.5 * meshes), (1, 24, 453.0, meshes)):
        length = active_profile_length(base[body], C_GF.action - tip[1 - body], tip[body])
        depth = float(plastic_wear(torque, turns, loss, 1e3 * coefficient, 14.0, teeth, length))
        local = tree["history"].wear_volume[-1, body]
        assert depth * length * 14.0 == pytest.approx(float(local), rel=0.01)
        middle = tree["flank"].wear_depth.isel(wear_step=-1, body=body, face=5)
        assert 2.5 < 1e-3 * float(middle.max()) / depth < 4.5


def test_modulus_and_wear_by_temperature():
    """A table ends where its measurements do."""
    temperatures, modulus = [20.0, 60.0, 100.0], [2800.0, 1800.0, 900.0]
    assert of_temperature([40.0, 100.0], temperatures, modulus) == pytest.approx([2300.0, 900.0])
    with pytest.raises(ValueError, match="allowed: 20 to 100 degC"):
        of_temperature(120.0, temperatures, modulus)


def test_plewe_gives_back_its_test():
    """The test's own gears wear as they did; half the pressure wears a gear 2^1.4 times less."""
    test = {"test_pressure": 1200.0, "test_radius": 8.5, "test_specific_sliding": 0.4}
    same = {"pressure": 1200.0, "radius": 8.5, "specific_sliding": -0.4}
    assert slow_speed_wear(1e-9, 1e6, **same, **test) == pytest.approx(1e-3)
    light = slow_speed_wear(1e-9, 1e6, **(same | {"pressure": 600.0}), **test)
    assert light == pytest.approx(1e-3 / 2.0**1.4)


SLOW = {"pressure": 600.0, "radius": 10.0, "specific_sliding": 0.5,
        "test_pressure": 600.0, "test_radius": 10.0, "test_specific_sliding": -0.5}  # fmt: skip


@pytest.mark.parametrize(
    ("called", "word"),
    [
        (lambda: loss_factor((16, 0), (0.6, 0.6)), "number of teeth .* not 0"),
        (lambda: loss_factor(TEETH, (1.2, 0.5)), "addendum must be at least 0 and at most 1, not 1.2"),
        (lambda: loss_factor(TEETH, (0.4, 0.4)), "contact ratio must be at least 1 and at most 2, not 0.8"),
        (lambda: loss_factor(TEETH, (0.6, 0.6), 0.0), "base helix angle .* not 0"),
        (lambda: tooth_temperature(80.0, -1.0, 0.0, 6.0), "friction power .* not -1"),
        (lambda: tooth_temperature(80.0, 1.0, -2.0, 6.0), "thermal resistance .* not -2"),
        (lambda: tooth_temperature(80.0, 1.0, 0.0, 6.0, 50.0), "run must be at least 0 and at most 1, not 50"),
        (lambda: plastic_wear([8.0, -8.0], 1e7, LOSS, 1e-6, 15.0, 52, 1.33), "torque .* not -8"),
        (lambda: plastic_wear(8.0, 1e7, LOSS, 1e-6, 15.0, 52, 0.0), "length of the active profile .* not 0"),
        (lambda: active_profile_length(20.0, 5.0, 4.0), "tip must be at least 5 mm, not 4"),
        (lambda: slow_speed_wear(-1e-9, 1e6, **SLOW), "wear rate and cycles .* not -1e-09"),
        (lambda: slow_speed_wear(1e-9, 1e6, **SLOW | {"test_pressure": 0.0}), "of the test .* not 0"),
    ],
)
def test_estimates_refuse_numbers_out_of_range(called, word):
    with pytest.raises(ValueError, match=word):
        called()
