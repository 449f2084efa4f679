"""Slices along a tooth."""

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from semiwear.geometry.face_slices import slice_middles
from semiwear.meshing.contact_lines import face_stations
from semiwear.plan import plan
from tests.scenes import SHIPPED, TINY


@pytest.mark.parametrize("slices", [7, 11, 31, 40, 61, 128, 161, 401])
@pytest.mark.parametrize("whole", [(-6.8, 6.8), (-3.0, 6.5), (-7.0, 7.0), (-9.0, 2.0)])
def test_borders_fall_on_the_ends_of_what_is_whole(slices, whole):
    found = slice_middles((-7.0, 7.0), whole, slices)
    width = found[1] - found[0]
    assert found.size == slices
    np.testing.assert_allclose(np.diff(found), width)
    for end in (max(whole[0], -7.0), min(whole[1], 7.0)):
        beside = (end - found[0]) / width + 0.5
        assert beside == pytest.approx(round(beside), abs=1e-9)
    assert -7.0 <= found[0] < -7.0 + 2.5 * width
    assert 7.0 - 2.5 * width < found[-1] <= 7.0
    if whole[0] == -whole[1]:
        np.testing.assert_allclose(found, -found[::-1], atol=1e-12)


@pytest.mark.parametrize("whole", [(1.0, -1.0), (float("nan"), float("nan"))])
def test_without_anything_whole_the_flank_is_divided(whole):
    np.testing.assert_allclose(slice_middles((-7.0, 7.0), whole, 7), np.arange(-6.0, 7.0, 2.0))


def test_a_narrower_pinion_gives_the_borders():
    scene = sw.load_scene("spur_fzg_c").replace(
        {
            "gear_pair.gear_face_width_mm": 16.0,
            "gear_pair.face_offset_mm": 0.3,
            "gear_pair.pinion_end_edge_radius_mm": 0.1,
        }
    )
    found = face_stations(plan(scene).flank_pair(), 40)
    width = found[1] - found[0]
    for end in (-6.6, 7.2):
        beside = (end - found[0]) / width + 0.5
        assert beside == pytest.approx(round(beside), abs=1e-6)


@pytest.mark.slow
def test_misalignment_leaves_the_slices_where_they_are():
    scene = sw.load_scene("spur_fzg_c").replace({"numerics.face_slices": 15, "numerics.roll_positions": 8})
    moved = scene.replace({"effects.misalignment.axial_pinion_mm": 0.5})
    one, two = (plan(each).loaded_teeth().grid.face for each in (scene, moved))
    np.testing.assert_array_equal(one, two)


@pytest.mark.slow
def test_a_wear_depth_brings_its_slices():
    scene = SHIPPED.replace(TINY | {"numerics.face_slices": 15})
    other = np.linspace(481.0, 559.0, 40)
    depth = xr.DataArray(np.full((31, 40), 5.0), dims=("profile", "face"), coords={"face": other})
    tree = sw.loaded_contact(scene, [0.0], depth)
    np.testing.assert_array_equal(tree["engagement"].face, other)
    plain = sw.loaded_contact(scene.replace({"numerics.face_slices": 40}), [0.0])
    # an even depth is no wear, and slices a little apart bear about the same
    for name in ("contact_pressure_max", "load_share"):
        np.testing.assert_allclose(tree["engagement"][name], plain["engagement"][name], rtol=0.05, atol=0.01)


@pytest.mark.parametrize("face", [[481.0, 500.0, 559.0], [559.0, 520.0, 481.0]])
def test_uneven_slices_are_refused(face):
    scene = SHIPPED.replace(TINY)
    depth = xr.DataArray(np.zeros((31, 3)), dims=("profile", "face"), coords={"face": face})
    with pytest.raises(sw.SceneError, match=r"wear_depth\.face.*even"):
        sw.loaded_contact(scene, [0.0], depth)


def test_slices_off_the_flank_are_refused():
    scene = SHIPPED.replace(TINY)
    depth = xr.DataArray(np.zeros((31, 61)), dims=("profile", "face"), coords={"face": np.arange(61)})
    with pytest.raises(sw.SceneError, match=r"wear_depth\.face.*0 to 60 mm.*480 to 560"):
        sw.loaded_contact(scene, [0.0], depth)
