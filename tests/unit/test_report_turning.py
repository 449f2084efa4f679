"""The tooth that can be turned: its shape against closed forms, its data, and the page without the library."""

import base64
import gzip
import sys
from math import cos, pi, radians, tan

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import semiwear as sw
from semiwear.commands.wear_table import life_sentence
from semiwear.meshing.driving_flank import driving_grid
from semiwear.meshing.flank_grid import flank_grid
from semiwear.meshing.pairs import flank_pair
from semiwear.report import pictures, turning, write_report
from semiwear.report.numbers import life_numbers
from semiwear.report.packing import Packer
from semiwear.report.tooth_shape import ToothShape, tooth_shape
from semiwear.scene import Placement
from tests.strategies.results import synthetic_tree

SPUR = sw.load_scene("spur_fzg_c")
HELICAL = SPUR.replace({"gear_pair.helix_angle_deg": 15.0, "gear_pair.centre_distance_mm": 95.0})
FACE_GEAR = sw.load_scene("face_gear_25x160").replace({"wear.worn_bodies": ["pinion", "gear"]})
BODIES = ("pinion", "gear")


def bare(scene, stations=9, points=61):
    """The flanks of a scene as a result that has nothing else, both bodies worn by 1 um."""
    pair = flank_pair(scene.gear_pair, Placement())
    low, high = pair.face_limits
    face = low + (high - low) * (np.arange(stations) + 0.5) / stations
    nodes = [driving_grid(pair, face, points).profile, flank_grid(pair, face, points).profile]
    places = [pair.flank_place(body, face[:, None], nodes[body]) for body in (0, 1)]
    height, radius = (np.stack([place[k].T for place in places]) for k in (0, 1))
    dims = ("body", "profile", "face")
    flank = xr.Dataset(
        {
            "flank_height": (dims, height),
            "flank_radius": (dims, radius),
            "specific_sliding": (dims, np.zeros(height.shape)),
            "wear_depth": (("wear_step", *dims), np.ones((2, *height.shape))),
        },
        {"face": face, "body": list(BODIES), "meshes": ("wear_step", [0.0, 1e6])},
    )
    engagement = xr.Dataset(coords={"roll_position": np.linspace(-0.5, 0.5, 5)})
    tree = xr.DataTree.from_dict({"/flank": flank, "/engagement": engagement})
    tree.attrs["scene_toml"] = scene.to_toml()
    return tree


def across(shape, height, at):
    """Distance of both flanks at a height of the middle station [mm]."""
    middle = shape.flank.shape[1] // 2
    apart = np.linalg.norm(shape.back - shape.flank, axis=-1)[:, middle]
    return float(np.interp(at, height[:, middle], apart))


@pytest.mark.parametrize("scene", [SPUR, HELICAL])
@pytest.mark.parametrize("body", BODIES)
def test_cylindrical_teeth_are_as_thick_as_iso_21771_says(scene, body):
    """s_t = m_n (pi/2 + 2 x tan(alpha_n)) / cos(beta) on the reference circle, here as the chord of that arc."""
    tree, pair = bare(scene), scene.gear_pair
    beta, teeth = radians(pair.helix_angle_deg), getattr(pair, f"{body}_teeth")
    arc = pair.normal_module_mm * (
        pi / 2 + 2 * getattr(pair, f"{body}_profile_shift") * tan(radians(pair.pressure_angle_deg))
    )
    diameter = pair.normal_module_mm * teeth / cos(beta)
    flank = tree["flank"].to_dataset().sel(body=body)
    shape = tooth_shape(tree, body)
    found = across(shape, flank["flank_radius"].values, diameter / 2)
    assert found == pytest.approx(diameter * np.sin(arc / cos(beta) / diameter), rel=2e-3)


def test_the_face_gears_tooth_is_half_a_pitch_thick_in_the_pitch_plane():
    tree = bare(FACE_GEAR, stations=81)
    flank = tree["flank"].to_dataset().sel(body="gear")
    station = int(np.abs(flank["face"].values - 508.0).argmin())
    shape = tooth_shape(tree, "gear")
    apart = np.linalg.norm(shape.back - shape.flank, axis=-1)[:, station]
    found = float(np.interp(0.0, flank["flank_height"].values[:, station], apart))
    assert found == pytest.approx(pi * 6.35 / 2, rel=5e-3)


@pytest.mark.parametrize("scene", [SPUR, HELICAL, FACE_GEAR])
@pytest.mark.parametrize("body", BODIES)
def test_teeth_stand_upright_with_their_flank_to_the_viewer(scene, body):
    shape = tooth_shape(bare(scene), body)
    assert (np.sum((shape.back - shape.flank) * shape.normal, axis=-1) < 0.0).all()  # normals point out of the tooth
    np.testing.assert_allclose(np.linalg.norm(shape.normal, axis=-1), 1.0, atol=1e-9)
    assert shape.normal[..., 1].mean() > 0.5
    assert (np.diff(shape.flank[..., 2], axis=0) > 0.0).all()
    lowest = shape.flank[0, :, 2].min()
    assert (shape.fillet[-1, :, 2] < lowest).all() and (shape.back_fillet[-1, :, 2] < lowest).all()
    np.testing.assert_allclose(shape.fillet[0], shape.flank[0], atol=1e-9)
    np.testing.assert_allclose(shape.back_fillet[0], shape.back[0], atol=1e-9)


@pytest.mark.parametrize("body", BODIES)
def test_both_sides_of_a_spur_tooth_mirror_each_other(body):
    shape = tooth_shape(bare(SPUR), body)
    for one, other in ((shape.flank, shape.back), (shape.fillet, shape.back_fillet)):
        np.testing.assert_allclose(
            one[..., 2], other[..., 2], atol=1e-4
        )  # of a section as a chain of straight pieces
        middle = 0.5 * (one + other)[..., 1]
        np.testing.assert_allclose(middle, middle[0, 0], atol=5e-4)


@pytest.mark.parametrize("body", BODIES)
def test_contact_of_a_spur_pair_is_on_the_pitch_cylinder_at_roll_position_0(body):
    tree = bare(SPUR)
    height = tree["flank"]["flank_height"].sel(body=body).values
    line = tooth_shape(tree, body).line[2]
    at = [np.interp(row, np.arange(height.shape[0]), height[:, k]) for k, row in enumerate(line)]
    np.testing.assert_allclose(at, 0.0, atol=2e-3)


def test_a_shifted_pinions_contact_lies_on_the_stretch_that_the_gear_covers():
    """One slice of the gear bears: the pinion is drawn loaded where the motions bring that slice."""
    shifted = SPUR.replace({"effects.misalignment": {"axial_pinion_mm": 3.0}})
    gear, pinion = (tooth_shape(bare(shifted), body) for body in ("gear", "pinion"))
    faces = bare(shifted)["flank"]["face"].values
    load = np.zeros((2, 5, faces.size))
    load[..., faces.size // 2] = 100.0
    np.testing.assert_array_equal(gear.at_stations(load), load)
    found = pinion.at_stations(load)
    middle = (found * faces).sum(axis=-1) / found.sum(axis=-1)
    np.testing.assert_allclose(np.abs(middle - faces[faces.size // 2]), 3.0, atol=0.6 * np.diff(faces)[0])


def test_without_loads_there_is_a_tooth_and_no_contact_line():
    view = turning._view(bare(SPUR), Packer())
    assert view["engagement"] is None and all(body["line"] is None for body in view["bodies"])
    assert "turning-roll" not in turning._controls(view) and "turning-body" in turning._controls(view)
    assert [one["name"] for one in view["bodies"][0]["quantities"]] == ["wear", "sliding"]


@pytest.mark.parametrize("scene_toml", ["", "this is = no toml = at all", SPUR.to_toml()])
def test_a_grid_that_the_scene_does_not_give_is_laid_flat(scene_toml):
    tree = synthetic_tree(2, scene_toml=scene_toml)
    shape = tooth_shape(tree, "gear")
    assert shape.line is None and np.ptp(shape.flank[..., 1]) == 0.0 and shape.fillet.size == 0
    np.testing.assert_allclose(
        np.ptp(shape.flank[..., 2]), np.ptp(tree["flank"]["flank_height"].sel(body="gear").values)
    )


def test_pressure_is_spread_along_lines_and_keeps_its_peaks():
    tree = synthetic_tree(3)
    engagement = tree["engagement"].to_dataset()
    profiles, faces, rolls = 41, 33, engagement.sizes["roll_position"]
    row = (np.arange(rolls) - 4.0)[:, None] * np.ones(faces)  # a roll position at every node
    nothing = np.zeros((profiles, faces, 3))
    load, wanted = engagement["line_load"].values, engagement["contact_pressure_max"].values
    hertz = wanted[0][:, None] / np.sqrt(load[0].max(axis=-1, keepdims=True)) * np.ones(faces)
    shape = ToothShape(nothing, nothing, nothing, nothing[:0], nothing[:0], np.clip(row, 0.0, 40.0), hertz)
    pressure, meaning = turning._pressure(tree, "pinion", shape)
    assert pressure.shape == (3, profiles, faces) and "Hertz" in meaning
    # where a line is loaded most the run's pressure comes back
    on_flank = (row[:, 0] > 0.0) & (row[:, 0] < 40.0)
    heaviest = load.argmax(axis=-1)
    for step in range(3):
        for roll in np.flatnonzero(on_flank & (engagement["load_share"].values[step] > 1e-3)):
            found = np.interp(row[roll, 0], np.arange(profiles), pressure[step, :, heaviest[step, roll]])
            assert found == pytest.approx(wanted[step, roll], rel=1e-12)
    assert pressure.max() <= wanted.max() * (1 + 1e-9)
    pattern, meaning = turning._pressure(tree, "gear", shape)
    np.testing.assert_array_equal(pattern, tree["flank"]["contact_pattern"].values)
    assert "each point" in meaning


def test_pressure_is_hertzs_where_the_run_had_it_and_ends_of_lines_stay_below():
    hertz = np.array([[[900.0, 800.0, 1500.0]], [[900.0, 400.0, 1200.0]]])  # (wear_step, roll, face)
    greatest = np.array([[900.0], [1350.0]])
    found = turning._along_lines(greatest, hertz)
    np.testing.assert_allclose(found[0, 0], [900.0, 800.0, 900.0])  # the last slice is an end: more than the run has
    np.testing.assert_allclose(found[1, 0], [1350.0, 600.0, 1350.0])
    alone = turning._along_lines(np.array([[0.0]]), hertz[:1])
    np.testing.assert_array_equal(alone, 0.0)


@given(arrays.arrays(float, arrays.array_shapes(max_dims=3, max_side=6), elements=st.floats(-1e4, 1e4)))
def test_packed_arrays_come_back_within_half_a_step(values):
    pack = Packer()
    pack.add(np.arange(5.0))
    told = pack.add(values)
    numbers = np.frombuffer(gzip.decompress(base64.b64decode(pack.base64())), "<u2")
    found = told["low"] + told["step"] * numbers[told["at"] : told["at"] + values.size].reshape(told["shape"])
    assert np.abs(found - values).max() <= 0.5 * told["step"] * (1 + 1e-6) + 1e-12
    assert told["step"] <= np.ptp(values) / 65535 * (1 + 1e-12)


@pytest.mark.parametrize(
    ("height", "deepest", "factors"),
    [(10.0, 0.0, [1]), (10.0, 0.01, [1, 50, 100, 200]), (14.0, 0.1, [1, 10, 20, 40]), (1.0, 5.0, [1, 2])],
)
def test_wear_is_drawn_by_round_factors(height, deepest, factors):
    assert turning._factors(height, deepest) == factors


@pytest.mark.parametrize(("ended_by", "earlier"), [("wear", False), ("pitting", True), (None, False)])
def test_the_life_says_what_ends_it_earlier(ended_by, earlier):
    life = {"depth_limit": 50.0, "meshes_to_limit": 8e9, "hours_to_limit": 1200.0}
    if ended_by:
        life |= {"ended_by": ended_by, "meshes_to_end": 2e9}
    tree = xr.DataTree.from_dict({"/life": xr.Dataset(life)})
    ((title, value, meaning),) = life_numbers(tree)
    assert (title, value) == ("Life until 50 µm of wear", "1200 h") and "8.00·10⁹ meshes of a gear tooth" in meaning
    assert ("pitting ends it earlier, after 2.00·10⁹ meshes" in meaning) == earlier


def test_a_life_that_no_wear_ends_is_told_without_end():
    life = {"depth_limit": 50.0, "meshes_to_limit": np.inf, "hours_to_limit": np.inf}
    life |= {"ended_by": "pitting", "meshes_to_end": 2e9, "hours_to_end": 300.0}
    tree = xr.DataTree.from_dict({"/life": xr.Dataset(life)})
    ((_, value, meaning),) = life_numbers(tree)
    assert value == "without end" and "pitting ends it earlier, after 2.00·10⁹ meshes" in meaning
    ended = "without end, the flank wears no further before that depth; pitting ends it after 2e+09 meshes"
    assert ended in life_sentence(tree)


def test_large_grids_are_thinned_and_keep_their_ends():
    rows, columns = turning._thinned(401, 201)
    assert rows.size * columns.size <= 1.05 * turning._MOST_NODES
    assert (rows[0], rows[-1], columns[0], columns[-1]) == (0, 400, 0, 200)
    assert turning._thinned(41, 33)[0].size == 41


@pytest.mark.slow
def test_without_the_library_there_are_pictures_and_a_word(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "plotly", None)
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    monkeypatch.setattr(pictures, "PICTURES", [one for one in pictures.PICTURES if one.part == "first"])
    turning._library.cache_clear()
    try:
        text = write_report(synthetic_tree(2), tmp_path / "r.html").read_text(encoding="utf-8")
    finally:
        turning._library.cache_clear()
    assert "<script" not in text and "script-src" not in text and 'alt="Worn flank of the gear' in text
    assert "pip install 'semiwear[report]'" in text
