"""Grids of deviations: files written and read back, values and signs, and every way a file can be wrong."""

import numpy as np
import pytest
import xarray as xr

from semiwear.errors import SceneError
from semiwear.meshing.deviation_grid import DeviationGrid, read_deviation_grid, write_deviation_grid

PROFILE, FACE = np.array([0.0, 0.1, 0.4, 0.7, 1.0]), np.array([0.0, 0.2, 0.5, 0.6, 0.9, 1.0])
VALUES = 10.0 * np.sin(3.0 * PROFILE)[:, None] * np.cos(2.0 * FACE) - 4.0
LENGTH, WIDTH = 12.0, 80.0


@pytest.mark.parametrize("suffix", [".csv", ".nc"])
@pytest.mark.parametrize("units", [("1", "1"), ("mm", "mm"), ("1", "mm")])
def test_round_trip(tmp_path, suffix, units):
    path = tmp_path / f"flank{suffix}"
    profile, face = (c * (7.0 if unit == "mm" else 1.0) for c, unit in zip((PROFILE, FACE), units, strict=True))
    write_deviation_grid(path, profile, face, VALUES, profile_unit=units[0], face_unit=units[1])
    grid = read_deviation_grid(path)
    np.testing.assert_array_equal(grid.profile, profile)
    np.testing.assert_array_equal(grid.face, face)
    np.testing.assert_allclose(grid.deviation, 1e-3 * VALUES, rtol=1e-15)
    assert (grid.profile_unit, grid.face_unit) == units
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_removed_is_the_highest_less_the_local_material():
    grid = DeviationGrid(PROFILE, FACE, 1e-3 * VALUES)
    found = grid.removed(LENGTH * PROFILE[:, None], LENGTH, WIDTH * FACE, WIDTH)
    assert found.min() >= 0.0
    np.testing.assert_allclose(found, grid.highest - 1e-3 * VALUES, atol=1e-15)
    # the highest place lies between the points: of the surface that they were taken from it is 6 um
    assert 1e-3 * VALUES.max() < 0.0054
    assert grid.highest == pytest.approx(0.006, abs=0.0001)


def test_cubics_are_reproduced():
    def cubic(x, y):
        return 0.01 * (x**3 - 2.0 * x * y**2 + y**3 + 0.3)

    grid = DeviationGrid(PROFILE, FACE, cubic(PROFILE[:, None], FACE))
    x, y = np.linspace(0.0, 1.0, 23)[:, None], np.linspace(0.0, 1.0, 19)
    np.testing.assert_allclose(grid.removed(x, 1.0, y, 1.0), grid.highest - cubic(x, y), atol=1e-15)


def test_coordinates_in_millimetres_do_not_follow_the_length_of_the_flank():
    fractions = DeviationGrid(PROFILE, FACE, 1e-3 * VALUES)
    lengths = DeviationGrid(LENGTH * PROFILE, WIDTH * FACE, 1e-3 * VALUES, "mm", "mm")
    at = 5.0, 33.0
    same = fractions.removed(at[0], LENGTH, at[1], WIDTH)
    assert lengths.removed(at[0], LENGTH, at[1], WIDTH) == pytest.approx(same, rel=1e-12)
    assert lengths.removed(at[0], 2.0 * LENGTH, at[1], 2.0 * WIDTH) == pytest.approx(same, rel=1e-12)
    assert fractions.removed(at[0], 2.0 * LENGTH, at[1], WIDTH) != pytest.approx(same, rel=1e-2)


def test_border_goes_on_beyond_the_measured_area():
    grid = DeviationGrid(0.1 + 0.8 * PROFILE, 0.2 + 0.6 * FACE, 1e-3 * VALUES)
    inside = grid.removed([0.1, 0.9], 1.0, [0.2, 0.8], 1.0)
    np.testing.assert_allclose(grid.removed([-0.3, 1.2], 1.0, [0.0, 1.1], 1.0), inside, rtol=1e-12)


def test_slope_is_continuous_across_grid_lines():
    grid = DeviationGrid(PROFILE, FACE, 1e-3 * VALUES)
    step = 1e-6
    before, at, after = grid.removed(PROFILE[2] + step * np.array([-1.0, 0.0, 1.0]), 1.0, 0.35, 1.0)
    assert abs(after - 2.0 * at + before) / step < 1e-3 * abs(after - before) / (2.0 * step)


def test_other_separators_comments_and_a_mark_of_bytes(tmp_path):
    plain, other = tmp_path / "a.csv", tmp_path / "b.csv"
    write_deviation_grid(plain, PROFILE, FACE, VALUES)
    text = plain.read_text().replace(",", " ; ").replace("um 1 1", "um")
    other.write_text("\ufeff# measured\n\n" + text, encoding="utf-8")
    np.testing.assert_array_equal(read_deviation_grid(other).deviation, read_deviation_grid(plain).deviation)


def dataset(**changes):
    """What a good netCDF file holds, with changes to its pieces."""
    parts = {"profile": PROFILE, "face": FACE, "values": VALUES, "units": "um", "unit": "1", "name": "deviation"}
    parts |= changes
    data = xr.Dataset({parts["name"]: (("profile", "face"), parts["values"], {"units": parts["units"]})})
    return data.assign_coords(
        profile=("profile", parts["profile"], {"units": parts["unit"]}), face=("face", parts["face"])
    )


def changed(place, value):
    values = VALUES.copy()
    values[place] = value
    return values


BAD_NETCDF = {
    "nan": (dataset(values=changed((1, 2), np.nan)), "finite"),
    "infinite": (dataset(values=changed((1, 2), np.inf)), "finite"),
    "coordinate not finite": (dataset(face=np.append(FACE[:-1], np.nan)), "finite"),
    "not growing": (dataset(profile=PROFILE[::-1].copy()), "growing"),
    "twice": (dataset(face=np.append(FACE[:-1], FACE[-2])), "growing"),
    "too few": (dataset().isel(profile=slice(0, 3)), "4 x 4"),
    "millimetres as micrometres": (dataset(values=1e4 * VALUES), "units"),
    "other unit": (dataset(units="mm"), "um"),
    "other unit of place": (dataset(unit="inch"), "inch"),
    "millimetres as fractions": (dataset(profile=12.0 * PROFILE), "fractions"),
    "no variable": (dataset(name="height"), "deviation"),
    "no coordinate": (dataset().drop_vars("face"), "coordinate"),
    "other dims": (dataset().isel(face=0), "deviation"),
}


@pytest.mark.parametrize("case", BAD_NETCDF)
def test_bad_netcdf_is_refused(case, tmp_path):
    data, word = BAD_NETCDF[case]
    path = tmp_path / "bad.nc"
    data.to_netcdf(path, engine="netcdf4")
    with pytest.raises(SceneError, match=word) as caught:
        read_deviation_grid(path, "modification.gear.deviations")
    problem = caught.value.problems[0]
    assert problem.field == "modification.gear.deviations"
    assert "bad.nc" in str(problem.value)
    assert problem.allowed and problem.fix


GOOD_CSV = "um,0,0.3,0.6,1\n" + "".join(f"{x},1,2,3,4\n" for x in (0, 0.3, 0.6, 1))
BAD_CSV = {
    "empty": ("", "rows"),
    "header only": ("um,0,0.3,0.6,1\n", "rows"),
    "no unit": (GOOD_CSV.replace("um", ""), "first cell"),
    "other unit": (GOOD_CSV.replace("um", "mm"), "first cell"),
    "ragged": (GOOD_CSV.replace("0.3,1,2,3,4", "0.3,1,2,3"), "row 3"),
    "words": (GOOD_CSV.replace("0.3,1,2,3,4", "0.3,1,two,3,4"), "two"),
    "hole": (GOOD_CSV.replace("0.3,1,2,3,4", "0.3,1,,3,4"), "numbers"),
    "nan": (GOOD_CSV.replace("0.3,1,2,3,4", "0.3,1,nan,3,4"), "finite"),
    "not growing": (GOOD_CSV.replace("0.3,1,2", "0.7,1,2"), "growing"),
    "absurd": (GOOD_CSV.replace("0.3,1,2", "0.3,1,5001"), "micrometres"),
    "too few": (GOOD_CSV[: GOOD_CSV.index("1,1,2,3,4")], "4 x 4"),
}


@pytest.mark.parametrize("case", BAD_CSV)
def test_bad_csv_is_refused(case, tmp_path):
    text, word = BAD_CSV[case]
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(SceneError, match=word) as caught:
        read_deviation_grid(path)
    problem = caught.value.problems[0]
    assert "bad.csv" in str(problem.value)
    assert problem.allowed and problem.fix


def test_good_csv_is_read(tmp_path):
    path = tmp_path / "good.CSV"
    path.write_text(GOOD_CSV)
    np.testing.assert_allclose(
        read_deviation_grid(path).removed([0.0, 1.0], 1.0, [0.0, 1.0], 1.0), [0.003, 0.0], atol=1e-15
    )


def test_other_files_are_refused(tmp_path):
    with pytest.raises(SceneError, match="no such file"):
        read_deviation_grid(tmp_path / "missing.csv")
    (tmp_path / "grid.txt").write_text(GOOD_CSV)
    with pytest.raises(SceneError, match=r"\.nc"):
        read_deviation_grid(tmp_path / "grid.txt")
    (tmp_path / "grid.nc").write_text(GOOD_CSV)
    with pytest.raises(SceneError, match="no netCDF file"):
        read_deviation_grid(tmp_path / "grid.nc")
    (tmp_path / "cut.nc").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(200))
    with pytest.raises(SceneError, match="cannot be read"):
        read_deviation_grid(tmp_path / "cut.nc")
    (tmp_path / "latin.csv").write_bytes(b"\xb5m,0,1\n0,1,2\n")
    with pytest.raises(SceneError, match="UTF-8"):
        read_deviation_grid(tmp_path / "latin.csv")


def test_nothing_is_written_that_could_not_be_read(tmp_path):
    with pytest.raises(SceneError, match="finite"):
        write_deviation_grid(tmp_path / "a.csv", PROFILE, FACE, changed((0, 0), np.nan))
    with pytest.raises(SceneError, match=r"\.nc"):
        write_deviation_grid(tmp_path / "a.xlsx", PROFILE, FACE, VALUES)
    with pytest.raises(SceneError, match="each pair"):
        write_deviation_grid(tmp_path / "a.csv", PROFILE, FACE, VALUES.T)
    assert not list(tmp_path.iterdir())
