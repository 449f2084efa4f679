"""Profile and lead traces: the surface between them, their files, and what is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import semiwear as sw
from semiwear.measured.nominal import nominal_flank
from semiwear.measured.traces import Trace

DATA = Path(__file__).parents[1] / "data"
SPUR = sw.load_scene("spur_fzg_c")
BASE = 108.0 * np.cos(np.radians(20.0))  # of the gear, 24 teeth of module 4.5
FLANK = nominal_flank(SPUR, "gear")
LOW, HIGH = FLANK.face_ends
ROOT, TIP = (float(end[0]) for end in FLANK.limits(np.zeros(1)))


def deviation(u, v):
    """A deepening near the root, crowned, with a twist that is bilinear [um]."""
    return -8.0 * np.exp(-(((u - 0.25) / 0.2) ** 2)) - 3.0 * (2.0 * v - 1.0) ** 2 + 2.0 * (2 * u - 1) * (2 * v - 1)


def trace(kind, at, zero=0.0, count=480, tooth=1, flank="left"):
    s = np.linspace(0.0, 1.0, count)
    u, v = (s, np.full(count, at)) if kind == "profile" else (np.full(count, at), s)
    diameter = 2.0 * FLANK.place(np.zeros(count), ROOT + u * (TIP - ROOT))[1]
    return Trace(kind, flank, tooth, diameter, v * (HIGH - LOW), deviation(u, v) + zero)


def error(found):
    """Greatest difference of the surface from the deviations, but for its zero [um]."""
    u, v = found.grid.profile[:, None] / (TIP - ROOT), found.grid.face / (HIGH - LOW)
    apart = 1e3 * found.grid.deviation - deviation(u, v)
    return np.abs(apart - apart.mean()).max()


def test_two_profiles_and_two_leads_tell_a_bilinear_twist_whatever_their_zeros():
    traces = [trace("profile", 0.0, 5.0), trace("profile", 1.0, -7.0), trace("lead", 0.1, 2.0), trace("lead", 0.9)]
    found = sw.flank_from_traces(SPUR, traces)
    assert error(found) < 0.05 and found.mismatch < 0.05
    assert (found.profiles, found.leads) == (2, 2)


def test_one_profile_and_one_lead_miss_the_twist_and_say_so():
    found = sw.flank_from_traces(SPUR, [trace("profile", 0.5), trace("lead", 0.5)])
    assert error(found) == pytest.approx(2.0, abs=0.1)
    assert "the same everywhere along the face" in str(found)


def test_teeth_are_averaged_unless_one_is_named():
    first = trace("profile", 0.5)
    traces = [first, replace(first, tooth=2, deviation=3.0 * first.deviation)]
    both, one = sw.flank_from_traces(SPUR, traces), sw.flank_from_traces(SPUR, traces, tooth=1)
    np.testing.assert_allclose(both.grid.deviation, 2.0 * one.grid.deviation, atol=1e-9)
    assert "2 teeth" in str(both) and "2 teeth" not in str(one)


def test_a_single_profile_keeps_its_zero():
    found = sw.flank_from_traces(SPUR, [trace("profile", 0.5, zero=4.0)])
    expected = deviation(found.grid.profile / (TIP - ROOT), 0.5) + 4.0
    assert np.abs(1e3 * found.grid.deviation - expected[:, None]).max() < 0.05


def test_a_topography_is_many_profiles_with_one_zero():
    traces = [trace("profile", v, count=200) for v in np.linspace(0.0, 1.0, 21)]
    assert error(sw.flank_from_traces(SPUR, traces, zeros="common")) < 0.05
    # with zeros of their own, profiles have lost the lead
    assert error(sw.flank_from_traces(SPUR, traces)) > 1.0
    with pytest.raises(sw.SceneError, match='"common"'):
        sw.flank_from_traces(SPUR, traces, zeros="mine")


def as_csv(traces, column):
    rows = [f"kind;tooth;flank;{column};z_mm;deviation_um"]
    for one in traces:
        across = one.diameter if column == "diameter_mm" else np.sqrt(one.diameter**2 - BASE**2) / 2.0
        points = zip(across, one.z, one.deviation, strict=True)
        rows += [f"{one.kind};{one.tooth};{one.flank};{a!r};{z!r};{d!r}" for a, z, d in points]
    return "\n".join(row.replace("np.float64(", "").replace(")", "") for row in rows)


@pytest.mark.parametrize("column", ["diameter_mm", "roll_length_mm"])
def test_tables_come_back(column, tmp_path):
    traces = [trace("profile", 0.2, count=40), trace("lead", 0.5, count=40), trace("profile", 0.2, count=40, tooth=3)]
    file = tmp_path / "traces.csv"
    file.write_text("# measured\n" + as_csv(traces, column))
    found = sw.read_traces(file, base_diameter=BASE)
    assert [(one.kind, one.tooth, one.flank) for one in found] == [(one.kind, one.tooth, one.flank) for one in traces]
    for one, other in zip(found, traces, strict=True):
        for name in ("diameter", "z", "deviation"):
            np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-12)


def test_curve_files_of_measuring_machines():
    traces = sw.read_traces(DATA / "spur_fzg_c_gear.mka", base_diameter=BASE)
    assert [(one.kind, one.flank) for one in traces] == 2 * [("profile", "left")] + [("lead", "left")] + 2 * [
        ("profile", "right")
    ] + [("lead", "right")]
    assert len(traces[0].deviation) == 46 and len(traces[1].deviation) == 48  # two points were not measured
    assert traces[1].diameter[[0, -1]] == pytest.approx([102.5, 117.0])
    assert np.ptp(np.diff(np.sqrt(traces[1].diameter ** 2 - BASE**2))) < 1e-9  # even in the length of roll
    assert traces[2].z[[0, -1]] == pytest.approx([0.5, 13.5]) and set(traces[2].diameter) == {109.0}
    with pytest.raises(sw.SceneError, match="which bears the load"):
        sw.flank_from_traces(SPUR, traces)
    found = sw.flank_from_traces(SPUR, traces, flank="left")
    assert (found.profiles, found.leads) == (2, 1) and found.mismatch < 0.2
    # deepest near the root, and the measured wear of the other side a fifth of it
    worn, less = (
        sw.measured_wear(SPUR, sw.flank_from_traces(SPUR, traces, flank=flank).grid) for flank in ("left", "right")
    )
    assert np.ptp(less.wear_depth.values) == pytest.approx(0.2 * np.ptp(worn.wear_depth.values), rel=0.01)
    row = int(np.argmax(worn.wear_depth.mean("face").values))
    rolls = [np.sqrt(diameter**2 - BASE**2) for diameter in (102.5, 117.0)]
    deepest = np.hypot(BASE, rolls[0] + 0.2 * (rolls[1] - rolls[0]))  # as the file was made
    assert 2.0 * float(worn.flank_radius[row, 0]) == pytest.approx(deepest, abs=0.3)


MKA = (DATA / "spur_fzg_c_gear.mka").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.mka", MKA[: MKA.rindex(" ") - 300], "48 in its heading"),
        ("a.mka", MKA.replace("/ 48 Werte  / z= 2.0", "/ 60 Werte  / z= 2.0", 1), "48 values, 60 in its heading"),
        ("a.mka", MKA.replace("da  [mm]", "dx  [mm]"), "no range da"),
        ("a.mka", MKA.replace("PROFILE      diameter", "PROFILE      length"), "PROFILE length"),
        ("a.mka", MKA.replace("UNITS        mm", "UNITS        inch"), "UNITS inch"),
        ("a.mka", "HEADER KS.MK.FILE\n", "no curves"),
        ("a.csv", "kind,tooth,flank,z_mm,deviation_um\n", "no column diameter_mm"),
        ("a.csv", "kind,tooth,flank,diameter_mm,z_mm,deviation_um\n", "no points"),
        ("a.csv", "kind,tooth,flank,diameter_mm,z_mm,deviation_um\nprofil,1,left,110,7,0\n", "kind 'profil'"),
        ("a.csv", "kind,tooth,flank,diameter_mm,z_mm,deviation_um\nprofile,1,left,110,7,zero\n", "line 2"),
        ("a.csv", "kind,tooth,flank,diameter_mm,z_mm,deviation_um\nprofile,1,left,110,7\n", "5 cells"),
        ("a.txt", "nothing", "name it .csv or .mka"),
        ("a.gde", "<gde/>", "name it .csv or .mka"),
    ],
)
def test_damaged_files_are_refused(name, text, words, tmp_path):
    (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(sw.SceneError, match=words):
        sw.read_traces(tmp_path / name, base_diameter=BASE)


def test_lengths_of_roll_need_the_base_circle(tmp_path):
    with pytest.raises(sw.SceneError, match="base_diameter"):
        sw.read_traces(DATA / "spur_fzg_c_gear.mka")
    with pytest.raises(sw.SceneError, match="no such file"):
        sw.read_traces(tmp_path / "none.csv")


def test_traces_that_cannot_be_of_the_flank_are_refused_at_once():
    good = trace("profile", 0.5, count=40)
    bad = [
        replace(good, tooth=1, z=good.z + 50.0),
        replace(good, tooth=2, diameter=good.diameter / 2.0),
        replace(good, tooth=3, deviation=1e3 * good.deviation),
        replace(good, tooth=4, diameter=good.diameter[:2], z=good.z[:2], deviation=good.deviation[:2]),
        replace(good, tooth=5, deviation=np.full(40, np.nan)),
    ]
    with pytest.raises(sw.SceneError) as caught:
        sw.flank_from_traces(SPUR, bad)
    assert len(caught.value.problems) == 5
    with pytest.raises(sw.SceneError, match="no profile of the right flank"):
        sw.flank_from_traces(SPUR, [good], flank="right")
    with pytest.raises(sw.SceneError, match="grid of points"):
        sw.flank_from_traces(sw.load_scene("face_gear_25x160"), [good])
