"""Modifications of a flank: where they take material, how much, and that they never add any."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from semiwear.meshing.deviation_grid import DeviationGrid
from semiwear.meshing.flank_modification import FlankModification, Relief

ROOT, TIP, ENDS = -4.0, 8.0, (480.0, 560.0)
MIDDLE = 2.0, 520.0


def depth(modification, profile, face):
    return modification.depth(profile, face, ROOT, TIP, ENDS)


def test_nothing_by_default():
    profile, face = np.linspace(-6.0, 10.0, 9), np.linspace(470.0, 570.0, 7)
    found = depth(FlankModification(), profile[:, None], face)
    assert found.shape == (9, 7)
    assert not found.any()


@pytest.mark.parametrize(("form", "half"), [("linear", 0.5), ("parabolic", 0.25)])
def test_reliefs(form, half):
    tip = FlankModification(tip_relief=Relief(0.02, 3.0, form))
    np.testing.assert_allclose(depth(tip, [TIP, 6.5, 5.0, 2.0, ROOT], 500.0), [0.02, half * 0.02, 0.0, 0.0, 0.0])
    root = FlankModification(root_relief=Relief(0.01, 2.0, form))
    np.testing.assert_allclose(depth(root, [ROOT, -3.0, -2.0, 2.0, TIP], 500.0), [0.01, half * 0.01, 0.0, 0.0, 0.0])
    # it goes on beyond the end
    assert depth(tip, TIP + 1.0, 500.0) > 0.02


def test_relief_without_a_length_takes_a_third_of_the_profile():
    given_length, third = (FlankModification(tip_relief=Relief(0.02, length)) for length in (4.0, None))
    profile = np.linspace(ROOT, TIP, 50)
    np.testing.assert_allclose(depth(third, profile, 500.0), depth(given_length, profile, 500.0), atol=1e-15)


def test_parabolic_relief_has_no_kink_and_linear_one_has():
    step = 1e-5
    for form, kink in (("parabolic", 0.0), ("linear", 0.02 / 4.0)):
        before, at, after = depth(
            FlankModification(tip_relief=Relief(0.02, 4.0, form)), [4 - step, 4, 4 + step], 500.0
        )
        assert (after - 2.0 * at + before) / step == pytest.approx(kink, abs=1e-7)


def test_crowning():
    found = depth(FlankModification(crowning=0.008), 0.0, [480.0, 500.0, 520.0, 540.0, 560.0, 580.0])
    np.testing.assert_allclose(found, 0.008 * np.array([1.0, 0.25, 0.0, 0.25, 1.0, 2.25]), atol=1e-15)


def test_lead_slope_takes_at_the_end_its_sign_names():
    face = [470.0, 480.0, 520.0, 560.0, 570.0]
    np.testing.assert_allclose(depth(FlankModification(lead_slope=0.01), 0.0, face), [0.0, 0.0, 0.005, 0.01, 0.01])
    np.testing.assert_allclose(depth(FlankModification(lead_slope=-0.01), 0.0, face), [0.01, 0.01, 0.005, 0.0, 0.0])


def test_bias_is_a_twist():
    profile, face = np.array([ROOT, 2.0, TIP])[:, None], np.array([480.0, 520.0, 560.0])
    expected = 0.005 * np.array([[2.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 2.0]])
    np.testing.assert_allclose(depth(FlankModification(bias=0.01), profile, face), expected)
    np.testing.assert_allclose(depth(FlankModification(bias=-0.01), profile, face), expected[::-1])


def test_ends_of_the_profile_may_differ_by_station():
    face = np.array([480.0, 520.0, 560.0])
    root, tip = np.array([-4.0, -4.0, -3.0]), np.array([9.0, 7.0, 5.0])
    modification = FlankModification(tip_relief=Relief(0.02), root_relief=Relief(0.01))
    np.testing.assert_allclose(modification.depth(tip, face, root, tip, ENDS), 0.02)
    np.testing.assert_allclose(modification.depth(root, face, root, tip, ENDS), 0.01)
    stations = modification.depth(np.linspace(root, tip, 5, axis=1), face[:, None], root[:, None], tip[:, None], ENDS)
    assert stations.shape == (3, 5)
    np.testing.assert_allclose(stations, np.tile(stations[0], (3, 1)), atol=1e-16)


small = st.floats(-0.05, 0.05)
amount = st.floats(0.0, 0.05)
reliefs = st.builds(Relief, amount, st.none() | st.floats(0.1, 30.0), st.sampled_from(["linear", "parabolic"]))


@given(st.builds(FlankModification, reliefs, reliefs, amount, small, small))
def test_never_negative_and_the_sum_of_its_parts(modification):
    profile, face = np.linspace(ROOT, TIP, 13)[:, None], np.linspace(*ENDS, 11)
    found = depth(modification, profile, face)
    assert found.min() >= 0.0
    parts = [
        FlankModification(tip_relief=modification.tip_relief),
        FlankModification(root_relief=modification.root_relief),
        FlankModification(crowning=modification.crowning),
        FlankModification(lead_slope=modification.lead_slope),
        FlankModification(bias=modification.bias),
    ]
    values = [depth(part, profile, face) for part in parts]
    np.testing.assert_allclose(found, sum(values), atol=1e-15)
    for value in values[3:]:
        assert value.min() < 1e-15


def test_grid_of_deviations_is_added():
    x, y = np.linspace(0.0, 1.0, 6), np.linspace(0.0, 1.0, 5)
    grid = DeviationGrid(x, y, 0.003 * np.add.outer(x, 2.0 * y))
    modification = FlankModification(crowning=0.002, deviations=grid)
    np.testing.assert_allclose(depth(modification, TIP, 560.0), 0.002, atol=1e-12)
    np.testing.assert_allclose(depth(modification, *MIDDLE), 0.0045, atol=1e-12)
    np.testing.assert_allclose(depth(modification, ROOT, 480.0), 0.011, atol=1e-12)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Relief(-0.01),
        lambda: Relief(float("nan")),
        lambda: Relief(0.01, 0.0),
        lambda: Relief(0.01, float("inf")),
        lambda: Relief(0.01, 1.0, "cubic"),
        lambda: FlankModification(crowning=-0.01),
        lambda: FlankModification(bias=float("inf")),
        lambda: FlankModification(lead_slope=float("nan")),
    ],
)
def test_impossible_numbers_are_refused(make):
    with pytest.raises(ValueError, match=r"finite number|one of"):
        make()
