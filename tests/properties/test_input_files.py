"""Whatever a file holds that a scene names, there is a scene or an error that names the field and a way out."""

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import semiwear as sw
from semiwear.check import geometric_problems
from semiwear.errors import Problem
from semiwear.geometry.point_grid import read_point_grid
from semiwear.meshing.deviation_grid import read_deviation_grid, write_deviation_grid
from semiwear.scene import scene_from_dict
from tests.scenes import TINY
from tests.strategies.files import other_datasets, spoilt_binary, spoilt_text
from tests.strategies.point_flanks import exported

SPUR = sw.load_scene("spur_fzg_c").replace(TINY)
DEVIATIONS = "effects.modification.gear.file"
ONE_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture(scope="module")
def points(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The spur pair as points, the gear's also as a CSV file."""
    folder = tmp_path_factory.mktemp("points")
    exported(SPUR, folder, (9, 9), suffix=".csv")
    return exported(SPUR, folder, (9, 9))


@pytest.fixture(scope="module")
def deviations(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of deviations, as netCDF and as CSV beside it."""
    file = tmp_path_factory.mktemp("deviations") / "gear.nc"
    share = np.linspace(0.0, 1.0, 6)
    for suffix in (".nc", ".csv"):
        write_deviation_grid(file.with_suffix(suffix), share, share, 5.0 * np.outer(share, share))
    return file


def told(data: dict[str, Any], field: str) -> None:
    """There is a scene, or problems of which each says what to do, the file's field among them."""
    try:
        scene = scene_from_dict(data, check=geometric_problems)
    except sw.SceneError as error:
        assert all(one.field and one.allowed for one in error.problems)
        owners = [one.field for one in error.problems]
        assert all(owner.startswith(("gear_pair.", field)) for owner in owners), error
        assert " nan" not in str(error).casefold().replace("is nan", "").replace("'nan", ""), error
    else:
        assert np.isfinite(
            [value for value in scene.to_dict()["gear_pair"].values() if isinstance(value, float)]
        ).all()


def told_of_points(points: dict[str, Any], file: Path) -> None:
    data = copy.deepcopy(points)
    data["gear_pair"]["gear_file"] = str(file)
    told(data, "gear_pair.gear_file")


def told_of_deviations(file: Path) -> None:
    data = SPUR.to_dict()
    data["effects"] = {"modification": {"gear": {"file": str(file)}}}
    told(data, DEVIATIONS)


def test_a_cell_without_end_is_told(tmp_path: Path) -> None:
    """Readers of tables refuse cells beyond 131072 characters by an error of their own."""
    file = tmp_path / "gear.csv"
    file.write_text("um,0,1\n" + "9" * 200_000 + ",1,2\n")
    assert isinstance(read_point_grid(file), Problem)
    with pytest.raises(sw.SceneError, match="no table"):
        read_deviation_grid(file)
    with pytest.raises(sw.SceneError, match="no table"):
        sw.read_traces(file)


@pytest.mark.slow
@ONE_FOLDER
@given(data=st.data())
def test_any_text_in_a_file_of_points(points: dict[str, Any], tmp_path: Path, data: st.DataObject) -> None:
    text = Path(points["gear_pair"]["gear_file"]).with_suffix(".csv").read_text()
    file = tmp_path / "gear.csv"
    file.write_bytes(data.draw(spoilt_text(text)))
    told_of_points(points, file)


@pytest.mark.slow
@ONE_FOLDER
@given(data=st.data())
def test_any_bytes_in_a_file_of_points(points: dict[str, Any], tmp_path: Path, data: st.DataObject) -> None:
    file = tmp_path / "gear.nc"
    file.write_bytes(data.draw(spoilt_binary(Path(points["gear_pair"]["gear_file"]).read_bytes())))
    told_of_points(points, file)


@pytest.mark.slow
@ONE_FOLDER
@given(data=st.data())
def test_any_netcdf_in_a_file_of_points(points: dict[str, Any], tmp_path: Path, data: st.DataObject) -> None:
    with xr.open_dataset(points["gear_pair"]["gear_file"]) as opened:
        other = data.draw(other_datasets(opened.load()))
    file = tmp_path / "gear.nc"
    other.to_netcdf(file, engine="netcdf4")
    told_of_points(points, file)


@ONE_FOLDER
@given(data=st.data())
def test_any_text_in_a_file_of_deviations(deviations: Path, tmp_path: Path, data: st.DataObject) -> None:
    file = tmp_path / "gear.csv"
    file.write_bytes(data.draw(spoilt_text(deviations.with_suffix(".csv").read_text())))
    told_of_deviations(file)


@ONE_FOLDER
@given(data=st.data())
def test_any_bytes_in_a_file_of_deviations(deviations: Path, tmp_path: Path, data: st.DataObject) -> None:
    file = tmp_path / "gear.nc"
    file.write_bytes(data.draw(spoilt_binary(deviations.read_bytes())))
    told_of_deviations(file)


@ONE_FOLDER
@given(data=st.data())
def test_any_netcdf_in_a_file_of_deviations(deviations: Path, tmp_path: Path, data: st.DataObject) -> None:
    with xr.open_dataset(deviations) as opened:
        other = data.draw(other_datasets(opened.load()))
    file = tmp_path / "gear.nc"
    other.to_netcdf(file, engine="netcdf4")
    told_of_deviations(file)
