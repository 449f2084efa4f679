"""Scenes of flanks given as points: files, fields, and what keeps points from being flanks."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import fem_reference
import semiwear as sw
from semiwear.check import geometric_problems
from semiwear.errors import Problem, SceneError
from semiwear.geometry.point_grid import PointGrid, read_point_grid, write_point_grid
from semiwear.meshing.pairs import flank_pair, on_loaded_flank
from semiwear.scene import FlankPointsPair, Placement, parse_scene, scene_from_dict
from tests.scenes import TINY, problems_of
from tests.strategies.bevel import BevelPair
from tests.strategies.point_flanks import bevel_scene, exported, scene_of

SPUR = sw.load_scene("spur_fzg_c").replace(TINY | {"numerics.face_slices": 7, "numerics.wear_steps": 1})


@pytest.fixture(scope="module")
def data(tmp_path_factory) -> dict[str, Any]:
    """The spur pair as points."""
    return exported(SPUR, tmp_path_factory.mktemp("points"), (41, 31))


@pytest.fixture(scope="module")
def scene(data) -> sw.Scene:
    return scene_of(data)


def with_grid(
    data: dict[str, Any], folder: Path, change: Callable[[PointGrid], PointGrid], body: str = "gear"
) -> Any:
    """The scene with another grid of one body."""
    grid = read_point_grid(data["gear_pair"][f"{body}_file"])
    assert isinstance(grid, PointGrid)
    file = folder / f"{body}_changed.nc"
    write_point_grid(file, change(grid))
    return data | {"gear_pair": data["gear_pair"] | {f"{body}_file": str(file)}}


def bare(grid: PointGrid, points: np.ndarray) -> PointGrid:
    """Other points without anything that goes with them."""
    return PointGrid(points, attributes={"teeth": grid.attributes["teeth"]})


# ---------------------------------------------------------------------- the scene


def test_it_is_a_scene_like_any_other(scene):
    assert isinstance(scene.gear_pair, FlankPointsPair)
    assert geometric_problems(scene) == []
    again = parse_scene(scene.to_toml(), check=geometric_problems)
    assert again == scene
    assert again.to_toml() == scene.to_toml()
    assert "pinion 41 x 31 points" in sw.plan(scene).choices[0].why
    assert any("de Boor" in source for source in sw.plan(scene).references)


@pytest.mark.slow
def test_every_answer_works_for_it(scene, tmp_path):
    tree = sw.simulate(scene)
    assert float(tree["flank"].wear_depth.min()) >= 0.0
    assert float(tree["history"].wear_depth_max_pinion[-1]) > 0.0
    assert tree["flank"].surface_error.dims == ("body",)
    sw.save(tree, tmp_path / "worn.nc")
    assert sw.open_results(tmp_path / "worn.nc").attrs["scene_toml"] == scene.to_toml()
    sw.report(tree, tmp_path / "worn.html")
    analysis = sw.tooth_contact_analysis(scene)
    assert float(analysis.contact_ratio) == pytest.approx(1.4377, abs=2e-3)
    loaded = sw.loaded_contact(scene, placement=Placement(pinion_slope_mrad=0.1))
    assert np.isfinite(loaded["engagement"].root_stress.values).all()


@pytest.mark.parametrize(
    "effect",
    [
        {"effects.friction": {}},
        {"effects.free_edges": {}},
        {"effects.modification.gear.crowning_um": 5.0},
        {"effects.pitch_error.pinion_um": [0.0, 5.0]},
        {"effects.shaft_compliance": {}},
        {"numerics.fidelity": "patch"},
    ],
    ids=str,
)
def test_effects_work_through_the_protocol(scene, effect):
    rigid = scene.replace({"numerics.tooth_compliance": "rigid"} | effect)
    pressure = sw.loaded_contact(rigid)["engagement"].contact_pressure_max_edge.values
    assert np.isfinite(pressure).all()


def test_the_pitch_error_counts_on_the_pitch_circle(scene):
    """As on the exact pair, to the ratio of its reference and pitch circles."""
    sizes = []
    for one in (scene, SPUR):
        table = one.replace({"numerics.tooth_compliance": "rigid", "effects.pitch_error.pinion_um": [0.0, 20.0]})
        sizes.append(sw.loaded_contact(table)["mesh_cycle"].transmission_error_unloaded.values.min())
    assert sizes[0] == pytest.approx(sizes[1], rel=0.05)


def test_finite_elements_say_that_they_cannot(scene):
    with pytest.raises(SceneError, match="use the core"):
        fem_reference.loaded_contact(scene)


def test_a_changed_file_makes_another_table(data, tmp_path):
    table = with_grid(data, tmp_path, lambda grid: grid)
    before = scene_from_dict(table).gear_pair
    with_grid(data, tmp_path, lambda grid: replace(grid, points=grid.points + 1e-4))
    after = scene_from_dict(table).gear_pair
    assert before != after
    assert hash(before) != hash(after)


def turned(data: dict[str, Any]) -> str:
    return {"positive": "negative", "negative": "positive"}[data["gear_pair"]["pinion_rotation"]]


@pytest.mark.parametrize(
    ("key", "value", "field", "words"),
    [
        ("gear_pair.gear_file", "gear.txt", "", ""),
        ("gear_pair.pinion_teeth", 0, "", ""),
        ("gear_pair.gear_axis_direction", [0, 0, 0], "", ""),
        ("gear_pair.gear_axis_point_mm", [1, 2], "", ""),
        ("gear_pair.pinion_rotation", "left", "", ""),
        ("gear_pair.smoothing_um", -1, "", ""),
        ("gear_pair.smoothing_um", "much", "", ""),
        ("gear_pair.gear_fillet_radius_mm", 0, "", ""),
        ("gear_pair.pinion_tip_edge_radius_mm", 50.0, "", ""),
        ("gear_pair.gear_axis_point_mm", [0, 0, 0], "", ""),
        ("gear_pair.gear_axis_point_mm", [0.0, -191.5, 0.0], "", "meet nowhere"),
        ("gear_pair.pinion_rotation", turned, "gear_pair.pinion_file", "rotation"),
        ("operation.loaded_flank", "coast", "", "only one flank"),
        ("wear.control_point", {"face_mm": 60.0, "height_mm": 0.0}, "wear.control_point.face_mm", ""),
        ("wear.control_point", {"face_mm": 0.0, "height_mm": -30.0}, "wear.control_point.height_mm", ""),
    ],
)
def test_each_field_has_a_range(data, key, value, field, words):
    table, _, name = key.partition(".")
    value = value(data) if callable(value) else value
    problem = problems_of(scene_of, data | {table: data[table] | {name: value}})[field or key]
    assert words in f"{problem.value} {problem.fix}"


# ---------------------------------------------------------------------- files


@pytest.mark.slow
def test_csv_holds_the_same_flank(data, scene, tmp_path):
    grids = {body: read_point_grid(data["gear_pair"][f"{body}_file"]) for body in ("pinion", "gear")}
    table = dict(data["gear_pair"])
    for body, grid in grids.items():
        table[f"{body}_file"] = str(tmp_path / f"{body}.csv")
        write_point_grid(table[f"{body}_file"], grid)
        again = read_point_grid(table[f"{body}_file"])
        assert again.points == pytest.approx(grid.points, abs=0.0)
        assert again.normals == pytest.approx(grid.normals, abs=0.0)
    # sections are drawn, since CSV brings none
    plain = scene_of(data | {"gear_pair": table})
    first, second = (sw.loaded_contact(one)["engagement"].root_stress.values.max() for one in (scene, plain))
    assert second == pytest.approx(first, rel=0.25)


def test_csv_with_decimal_commas(tmp_path):
    rng = np.random.default_rng(1)
    file = tmp_path / "flank.csv"
    write_point_grid(file, PointGrid(rng.normal(size=(3, 4, 3))))
    plain = read_point_grid(file).points
    for separator in (";", "\t"):
        file.write_text(file.read_text().replace(",", separator).replace(".", ","))
        np.testing.assert_array_equal(read_point_grid(file).points, plain)
        write_point_grid(file, PointGrid(plain))


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "column"),
        ("a remark\nprofile,face,x_mm,y_mm,z_mm\n0,0,1,2,3\n", "remarks begin with #"),
        ("profile,face,x_m,y_m,z_m\n0,0,1,2,3\n", "millimetres"),
        ("profile,face,x_mm,y_mm,z_mm\n0,0,1,2\n", "cells"),
        ("profile,face,x_mm,y_mm,z_mm\n0,0,1,2,a\n", "correct"),
        ("profile,face,x_mm,y_mm,z_mm\n0,0,1,2,3\n0,0,1,2,3\n", "2 times"),
        ("profile,face,x_mm,y_mm,z_mm\n0,0,1,2,3\n1,1,1,2,3\n", "missing"),
        ("profile,face,x_mm,y_mm,z_mm\n0.5,0,1,2,3\n", "number rows"),
    ],
)
def test_csv_that_is_no_grid(text, word, tmp_path):
    file = tmp_path / "flank.csv"
    file.write_text(text)
    problem = read_point_grid(file, "gear_pair.gear_file")
    assert isinstance(problem, Problem)
    assert word in f"{problem.value} {problem.fix}"


def test_netcdf_that_holds_no_flank(data, tmp_path):
    file = tmp_path / "other.nc"
    assert "no such file" in str(read_point_grid(file))
    file.write_text("no")
    assert "netCDF" in str(read_point_grid(file))
    xr.Dataset({"points": (("profile", "face"), np.zeros((9, 9)))}).to_netcdf(file)
    assert "xyz" in str(read_point_grid(file))
    with xr.open_dataset(data["gear_pair"]["gear_file"]) as opened:
        metres = opened.load()
    metres["points"].attrs["units"] = "m"
    metres.to_netcdf(file)
    assert "millimetres" in str(read_point_grid(file))


def test_both_files_are_looked_at_at_once(data, tmp_path):
    table = data["gear_pair"] | {"pinion_file": str(tmp_path / "a.nc"), "gear_file": str(tmp_path / "b.csv")}
    found = problems_of(scene_of, data | {"gear_pair": table | {"pinion_end_edge_radius_mm": -1.0}})
    assert "gear_pair.pinion_end_edge_radius_mm" in found
    assert set(problems_of(scene_of, data | {"gear_pair": table})) == {"gear_pair.pinion_file", "gear_pair.gear_file"}


# ---------------------------------------------------------------------- grids that are no flanks


def _nan(grid: PointGrid) -> PointGrid:
    points = grid.points.copy()
    points[3, 4, 1] = np.nan
    return bare(grid, points)


def _folded(grid: PointGrid) -> PointGrid:
    points = grid.points.copy()
    points[[10, 12]] = points[[12, 10]]
    return bare(grid, points)


def _crossed(grid: PointGrid) -> PointGrid:
    points = grid.points.copy()
    points[8, 5] += 3.0 * (points[9, 5] - points[8, 5]) + 1e-3
    return bare(grid, points)


def _outlier(grid: PointGrid) -> PointGrid:
    points = grid.points.copy()
    points[20, 15] += 0.1 * np.cross([0.0, 0.0, 1.0], points[20, 15]) / np.linalg.norm(points[20, 15])
    return bare(grid, points)


BAD_GRIDS: dict[str, tuple[Callable[[PointGrid], PointGrid], str]] = {
    "too coarse": (lambda grid: bare(grid, grid.points[::8, ::8]), "finer"),
    "turns too much": (_outlier, "finer"),
    "not a number": (_nan, "fill"),
    "rows swapped": (_folded, "sort"),
    "folded at a point": (_crossed, "correct"),
    "a row twice": (lambda grid: bare(grid, np.insert(grid.points, 5, grid.points[5], axis=0)), "once"),
    "a column twice": (lambda grid: bare(grid, np.insert(grid.points, 5, grid.points[:, 5], axis=1)), "once"),
    "in metres": (lambda grid: bare(grid, 1e-3 * grid.points), "metres"),
    "in inches": (lambda grid: bare(grid, grid.points / 25.4), "inches"),
    "normals inward": (lambda grid: replace(grid, normals=-grid.normals), "inward"),
    "normals of length two": (lambda grid: replace(grid, normals=2.0 * grid.normals), "divide"),
    "normals elsewhere": (lambda grid: replace(grid, normals=np.roll(grid.normals, 1, axis=-1)), "normals"),
    "from tip to root": (lambda grid: bare(grid, grid.points[::-1]), "reverse"),
    "the other flank": (lambda grid: bare(grid, grid.points * np.array([-1.0, 1.0, 1.0])), "other flank"),
    "beside its axis": (lambda grid: bare(grid, grid.points - grid.points.mean(axis=(0, 1))), "axis"),
    "another tooth number": (lambda grid: replace(grid, attributes={"teeth": 11}), "teeth"),
    "a face coordinate that falls": (lambda grid: replace(grid, face=grid.face[::-1]), "sort"),
}


@pytest.mark.parametrize("body", ["pinion", "gear"])
@pytest.mark.parametrize("name", list(BAD_GRIDS))
def test_a_bad_grid_is_told(data, tmp_path, name, body):
    change, word = BAD_GRIDS[name]
    found = problems_of(scene_of, with_grid(data, tmp_path, change, body))
    problem = found[f"gear_pair.{body}_file"]
    assert word in f"{problem.value} {problem.allowed} {problem.fix}"
    assert problem.allowed and problem.fix


@pytest.mark.parametrize("teeth", [(25, 27), (22, 24)])  # 26 times and 23 times
def test_nearly_equal_gears_in_millimetres_are_no_inches(tmp_path, teeth):
    """25.4 times the difference of their radii is about their centre distance."""
    scene = sw.load_scene("spur_fzg_c").replace(
        {
            "gear_pair.pinion_teeth": teeth[0],
            "gear_pair.gear_teeth": teeth[1],
            "gear_pair.centre_distance_mm": None,
            "gear_pair.pinion_profile_shift": 0.0,
            "gear_pair.gear_profile_shift": 0.0,
        }
    )
    data = exported(scene, tmp_path, (21, 21))
    assert scene_of(data).gear_pair.pinion_teeth == teeth[0]


def test_both_in_inches_are_told_by_the_centre_distance(data, tmp_path):
    inches = with_grid(data, tmp_path, BAD_GRIDS["in inches"][0], "pinion")
    found = problems_of(scene_of, with_grid(inches, tmp_path, BAD_GRIDS["in inches"][0], "gear"))
    assert "25.4" in found["gear_pair.pinion_file"].fix


def test_bad_grids_of_both_bodies_are_told_at_once(data, tmp_path):
    first = with_grid(data, tmp_path, _nan, "pinion")
    found = problems_of(scene_of, with_grid(first, tmp_path, BAD_GRIDS["in metres"][0], "gear"))
    assert set(found) == {"gear_pair.pinion_file", "gear_pair.gear_file"}


def test_flanks_of_different_hands_cannot_touch(tmp_path):
    """A bevel gear with the pinion of its mirror image: no rotation brings their normals together."""
    data = bevel_scene(BevelPair(), tmp_path)
    other = tmp_path / "other"
    other.mkdir()
    bevel_scene(replace(BevelPair(), spiral_angle=-BevelPair().spiral_angle), other)
    pair = data["gear_pair"] | {"pinion_file": str(other / "pinion.nc")}
    found = problems_of(scene_of, data | {"gear_pair": pair})
    assert "other side" in found["gear_pair.pinion_file"].fix


def _sheet(make: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, ...]]) -> Callable[[PointGrid], PointGrid]:
    u, v = np.linspace(0.0, 1.0, 15)[:, None], np.linspace(0.0, 1.0, 15)
    return lambda grid: bare(grid, np.stack(np.broadcast_arrays(*make(u, v)), axis=-1))


SHEETS = {
    "a cylinder about the axis": _sheet(lambda u, v: (35.0 * np.cos(0.3 * u), 35.0 * np.sin(0.3 * u), 14.0 * v)),
    "a plane across the axis": _sheet(lambda u, v: (30.0 + 10.0 * u, 14.0 * v, 0.0 * v)),
    "a ball": _sheet(
        lambda u, v: (40.0 + 5.0 * np.cos(u), 5.0 * np.sin(u) * np.cos(1.0 + v), 5.0 * np.sin(u) * np.sin(1.0 + v))
    ),
    "one point": _sheet(lambda u, v: (40.0 + 0.0 * u, 0.0 * v, 0.0 * v)),
}


@pytest.mark.parametrize("body", ["pinion", "gear"])
@pytest.mark.parametrize("name", list(SHEETS))
def test_what_is_no_flank_is_an_error_of_the_scene(data, tmp_path, name, body):
    with pytest.raises(SceneError) as caught:
        scene_of(with_grid(data, tmp_path, SHEETS[name], body))
    assert all(problem.field.startswith("gear_pair.") and problem.fix for problem in caught.value.problems)


def test_the_coast_flank_is_refused_without_a_check_as_well(scene):
    with pytest.raises(SceneError, match="only that flank"):
        on_loaded_flank(scene.gear_pair, Placement(), "coast")


# ---------------------------------------------------------------------- export


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        ({"body": "wheel"}, "body"),
        ({"points": (5, 101)}, "points"),
        ({"path": "flank.txt"}, "path"),
        ({"worn": xr.DataTree()}, "worn"),
    ],
)
def test_what_cannot_be_exported(arguments, key, tmp_path):
    usual = {"body": "gear", "path": "flank.nc"} | arguments
    usual["path"] = tmp_path / usual["path"]
    with pytest.raises(SceneError) as caught:
        sw.export_flank(SPUR, **usual)
    assert caught.value.problems[0].field == key


def test_points_are_exported_again(scene, data, tmp_path):
    """The pair of points hands its own flanks on."""
    again = scene_from_dict(exported(scene, tmp_path, (41, 31)))
    first, second = (flank_pair(one.gear_pair, Placement()).flanks for one in (scene, again))
    for mine, other in zip(first.bodies, second.bodies, strict=True):
        places = np.linspace(0.05, 0.95, 7)
        radii = [body.radius_and_axial(places[:, None], places)[0] for body in (mine, other)]
        assert radii[0] == pytest.approx(radii[1], abs=1e-5)
