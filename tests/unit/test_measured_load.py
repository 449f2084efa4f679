"""A measured torque as a load spectrum and as cycles."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

import semiwear as sw
from semiwear.errors import SceneError
from tests.scenes import SHIPPED

SERIES = st.lists(st.tuples(st.floats(-2000, 2000), st.floats(0.01, 10), st.floats(1, 3000)), min_size=2, max_size=50)


@given(SERIES, st.integers(1, 30))
def test_a_spectrum_keeps_the_mean_torque_of_the_meshes(series, levels):
    torque, gaps, speed = np.array(series).T
    load = sw.measured_load(torque, time=np.cumsum(gaps), speed=speed)
    bears = torque > 0.0
    if not bears.any():
        with pytest.raises(SceneError, match="exchange the signs"):
            load.spectrum(levels)
        return
    found = load.spectrum(levels)
    assert sum(found["shares"]) == pytest.approx(1.0)
    mean = np.average(torque[bears], weights=load.weight[bears])
    assert np.dot(found["torques_Nm"], found["shares"]) == pytest.approx(mean)
    assert load.loaded_share() + load.loaded_share("coast") <= 1.0 + 1e-12
    assert SHIPPED.effects.load_spectrum is None


def test_a_second_at_twice_the_speed_counts_twice():
    even = {"time_s": [0.0, 1.0, 2.0, 3.0], "torque_Nm": [100.0, 100.0, 300.0, 300.0]}
    found = sw.measured_load(even).spectrum(2)
    np.testing.assert_allclose([found["torques_Nm"], found["shares"]], [[100.0, 300.0], [0.5, 0.5]])
    fast = sw.measured_load({**even, "speed_rpm": [500.0, 500.0, -1000.0, 1000.0]}).spectrum(2)
    np.testing.assert_allclose(fast["shares"], [1 / 3, 2 / 3])


def test_meshes_without_torque_and_torque_without_meshes_load_no_flank():
    """Samples for 0.5, 1, 1.5, 1.5 and 0.5 s; the pinion stands still under the greatest torque."""
    load = sw.measured_load(
        {
            "time_s": [0.0, 1.0, 2.0, 4.0, 5.0],
            "torque_Nm": [100.0, 0.0, 200.0, 300.0, 900.0],
            "speed_rpm": [100.0, 100.0, 100.0, 100.0, 0.0],
        }
    )
    assert load.loaded_share() == pytest.approx((0.5 + 1.5 + 1.5) / 4.5)
    assert load.loaded_share("coast") == 0.0
    found = load.spectrum(3)  # of 100 N m each: the last one takes its upper end
    np.testing.assert_allclose(found["torques_Nm"], [100.0, 250.0])
    np.testing.assert_allclose(found["shares"], [0.5 / 3.5, 3.0 / 3.5])


def test_a_spectrum_is_a_table_of_a_scene():
    load = sw.measured_load(1000.0 + 500.0 * np.sin(np.linspace(0, 20, 1000)))
    scene = SHIPPED.replace({"effects.load_spectrum": load.spectrum(5)})
    assert len(scene.effects.load_spectrum.torques_Nm) == 4  # none below a fifth of the greatest


def test_the_coast_flank_bears_the_negative_torques():
    load = sw.measured_load([100.0, -50.0, -50.0, 100.0])
    found = load.spectrum(1, "coast")
    np.testing.assert_allclose([found["torques_Nm"], found["shares"]], [[50.0], [1.0]])
    assert load.loaded_share("coast") == pytest.approx(2 / 3)


def test_cycles_are_those_of_the_standard():
    """The example of ASTM E1049-85, 5.4.4: ranges 3, 4, 6, 8, 9 with 0.5, 1.5, 0.5, 1, 0.5 cycles."""
    pytest.importorskip("rainflow")
    found = sw.measured_load([-2.0, 1, -3, 5, -1, 3, -4, 4, -2]).cycles(levels=9)
    np.testing.assert_allclose(found["range"], [3, 4, 6, 8, 9])
    np.testing.assert_allclose(found["count"], [0.5, 1.5, 0.5, 1.0, 0.5])
    # -2 to 1; half of 1 to -3 and one of -1 to 3; -2 to 4; halves of -3 to 5 and of -4 to 4; 5 to -4
    np.testing.assert_allclose(found["mean"], [-0.5, 1 / 3, 1.0, 0.5, 0.5])
    # levels up to 2.25, 4.5, 6.75 and 9
    coarse = sw.measured_load([-2.0, 1, -3, 5, -1, 3, -4, 4, -2]).cycles(levels=4)
    np.testing.assert_allclose(coarse["count"], [2.0, 0.5, 1.5])
    slow = np.interp(np.linspace(0, 8, 801), np.arange(9), [-2.0, 1, -3, 5, -1, 3, -4, 4, -2])
    np.testing.assert_allclose(sw.measured_load(slow).cycles(levels=9)["count"], found["count"])


def test_a_torque_that_never_changes_has_no_cycles():
    pytest.importorskip("rainflow")
    assert sw.measured_load([5.0, 5.0, 5.0]).cycles()["count"].sum() <= 0.5


def test_a_torque_that_only_rises_makes_half_a_cycle():
    pytest.importorskip("rainflow")
    found = sw.measured_load([0.0, 50.0, 100.0]).cycles()
    assert (found["count"].values, found["range"].values, found["mean"].values) == ([0.5], [100.0], [50.0])


@pytest.mark.parametrize("levels", [0, -3, 2.5, True, 1000])
def test_levels_of_cycles_are_checked(levels):
    with pytest.raises(SceneError, match=r"levels: found .*a whole number, 1 to 200 -> 64 is usual"):
        sw.measured_load([1.0, 2.0, 1.0]).cycles(levels)


def test_masked_samples_are_missing():
    with pytest.raises(SceneError, match="1 of 4 values are not finite, the first in sample 3"):
        sw.measured_load(np.ma.masked_values([100.0, 200.0, 1e36, 150.0], 1e36))


def test_times_beside_a_table_are_not_passed_over():
    with pytest.raises(SceneError, match=r"time, speed: found 'beside a table of torques'.*time_s or speed_rpm"):
        sw.measured_load({"torque_Nm": [1.0, 2.0]}, time=[0.0, 1.0], speed=[1.0, 1.0])


def test_a_file_names_each_column_once(tmp_path):
    (tmp_path / "twice.csv").write_text("torque_Nm,torque_Nm\n1,2\n3,4\n")
    with pytest.raises(SceneError, match="columns with names of their own"):
        sw.measured_load(tmp_path / "twice.csv")


def test_files_and_tables_are_read_alike(tmp_path):
    table = pd.DataFrame({"time_s": [0, 1, 3], "torque_Nm": [1.5, 2.0, 3.25], "speed_rpm": [10, 20, 30]})
    table.to_csv(tmp_path / "load.csv", index=False)
    table.to_csv(tmp_path / "commas.csv", index=False, sep=";", decimal=",")
    one = sw.measured_load(table)
    for name in ("load.csv", "commas.csv"):
        other = sw.measured_load(tmp_path / name)
        np.testing.assert_array_equal(one.weight, other.weight)
        np.testing.assert_array_equal(one.torque, other.torque)


@pytest.mark.parametrize(
    "given, part",
    [
        ({"torque": [1, 2]}, "did you mean torque_Nm"),
        ({"torque_Nm": [1, np.nan]}, "the first in sample 2"),
        ({"torque_Nm": [1, 2], "time_s": [0.0]}, "columns of one length"),
        ({"torque_Nm": [1, 2, 3], "time_s": [0, 2, 1]}, "sample 3 at 1 s"),
        ({"torque_Nm": [1, 2], "speed_rpm": [0, 0]}, "a pinion that turns"),
        ([[1, 2], [3, 4]], "one value a sample"),
        ([1], "two or more"),
        ("nowhere.csv", "a CSV file"),
        (None, "a file, a table or an array of torques"),
        (["a", "b"], "numbers"),
    ],
)
def test_what_is_wrong_is_named(given, part):
    with pytest.raises(SceneError, match=part):
        sw.measured_load(given)


def test_levels_and_flanks_are_checked():
    load = sw.measured_load([1.0, 2.0])
    for call in (lambda: load.spectrum(0), lambda: load.spectrum(5, "left")):
        with pytest.raises(SceneError):
            call()
