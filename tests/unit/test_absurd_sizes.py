"""Inputs of absurd sizes are refused before they are worked on, and no text is opened that is no file's name."""

import resource
import sys
from contextlib import contextmanager
from pathlib import Path

import netCDF4
import pytest

import semiwear as sw
from semiwear.compliance.influence import read_influence
from semiwear.errors import Problem, SceneError
from semiwear.geometry.point_grid import read_point_grid
from semiwear.measured.files import read_measured
from semiwear.meshing.deviation_grid import read_deviation_grid
from semiwear.results.run_identity import run_identity
from semiwear.scene import load, parse_scene, reading, scene_files, scene_from_dict
from tests.scenes import SHIPPED


@contextmanager
def little_memory():
    """Half a gigabyte more than now: what is absurd would take ten and more."""
    if sys.platform != "linux":
        yield
        return
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    limit = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (used + 2**29, limit[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, limit)


HEADER = "profile,face,x_mm,y_mm,z_mm\n"
ROWS = {
    "a row of 1e9": ("0,0,1,2,3\n1000000000,0,1,2,3\n", "1e+09 in a file of 2 points"),
    "a column of 1e300": ("0,1e300,1,2,3\n0,0,1,2,3\n", "1e+300 in a file of 2 points"),
    "an endless row": ("0,inf,1,2,3\n0,0,1,2,3\n", "inf in a file"),
    "a point missing": (
        "0,0,1,2,3\n0,1,1,2,3\n1,0,1,2,3\n",
        "(profile 1, face 1) is missing'; allowed: each point of the grid once -> fill the gap",
    ),
    "a point twice": (
        "0,0,1,2,3\n0,1,1,2,3\n0,1,1,2,3\n1,0,1,2,3\n",
        "(profile 0, face 1) is there 2 times'; allowed: each point of the grid once -> leave the others out",
    ),
    "the first missing": ("0,1,1,2,3\n1,0,1,2,3\n1,1,1,2,3\n", "(profile 0, face 0) is missing"),
    "a diagonal": ("".join(f"{k},{k},1,2,3\n" for k in range(30_000)), "(profile 0, face 1) is missing"),
}


@pytest.mark.parametrize("name", ROWS)
def test_points_whose_numbers_make_no_grid(name, tmp_path):
    rows, words = ROWS[name]
    path = tmp_path / "flank.csv"
    path.write_text(HEADER + rows)
    with little_memory():
        found = read_point_grid(path)
    assert isinstance(found, Problem)
    assert words in str(found)


@pytest.fixture(scope="module", params=["data", "coordinate"])
def unwritten(request, tmp_path_factory):
    """A file of a few kilobytes that says of itself to hold some gigabytes."""
    path = tmp_path_factory.mktemp("absurd") / "flank.nc"
    with netCDF4.Dataset(path, "w") as made:
        for name, size in (("profile", 40_000), ("face", 40_000), ("xyz", 3), ("huge", 2_000_000_000)):
            made.createDimension(name, size)
        if request.param == "coordinate":
            made.createVariable("huge", "f8", ("huge",))
        else:
            made.createVariable("points", "f8", ("profile", "face", "xyz"))
            made.createVariable("deviation", "f8", ("profile", "face")).units = "um"
    return path


@pytest.mark.parametrize("read", [read_point_grid, read_deviation_grid, read_influence, read_measured])
def test_netcdf_files_that_would_fill_the_memory(read, unwritten):
    with little_memory():
        try:
            told = str(read(unwritten))
        except SceneError as error:
            told = str(error)
    assert "= " in told and "allowed: at most 1e+07 values" in told


def test_ever_so_many_unknown_names_are_counted(monkeypatch):
    asked = []
    meanings = reading._meanings
    monkeypatch.setattr(reading, "_meanings", lambda *args: asked.append(args) or meanings(*args))
    many = {f"unknown_{k}": k for k in range(200_000)}
    for data in (SHIPPED.to_dict() | many, {"gear_pair": SHIPPED.to_dict()["gear_pair"] | many}, many):
        asked.clear()
        with pytest.raises(SceneError, match="more unknown names") as caught:
            scene_from_dict(data)
        assert len(caught.value.problems) < 100
        assert len(asked) <= 200
    asked.clear()
    with pytest.raises(SceneError, match="more unknown names") as caught:
        SHIPPED.replace(many)
    assert len(caught.value.problems) < 100
    assert len(asked) <= 200


def test_a_scene_of_more_than_a_million_bytes_is_none(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SHIPPED.to_toml() + "# remark\n" * 200_000)
    with pytest.raises(SceneError, match=r"more than 1e\+06 bytes"):
        sw.load_scene(path)


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="a device without an end")
def test_a_scene_without_end(monkeypatch):
    if not hasattr(load, "_MOST_BYTES"):
        pytest.fail("a device would be read without end")
    with pytest.raises(SceneError, match="more than"):
        sw.load_scene("/dev/zero")


def test_only_fields_that_are_files_are_opened(tmp_path):
    secret, flank = tmp_path / "secret.csv", tmp_path / "gear.csv"
    for path in (secret, flank):
        path.write_text("um,0,1\n", encoding="utf-8")
    scene = parse_scene(SHIPPED.to_toml()).replace(
        {
            "title": str(secret),
            "material.gear.name": str(secret),
            "effects.modification.gear.file": str(flank),
        }
    )
    assert scene_files(scene) == {"effects.modification.gear.file": str(flank)}
    assert [name for name in run_identity(scene.to_toml()) if name.startswith("content")] == [f"content of {flank}"]
