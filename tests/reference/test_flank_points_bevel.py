"""Spiral bevel and hypoid pairs from a construction of their own, through unloaded and loaded contact and wear.

How displacements move the pattern is foretold by the construction's own rigid tooth contact analysis, to the first
order: the gap that a displacement d opens along the contact line is n . d, over the lever arm (`BevelPair`).
Park and Kahraman (2009, Wear 267, 1595-1604) find the same for a hypoid pair: an offset error moves contact and wear
lengthwise to one end of the tooth, its opposite to the other end, and wear grows where the contact moves to.
"""

from math import cos

import numpy as np
import pytest

import semiwear as sw
from semiwear.geometry.point_grid import PointGrid, read_point_grid, write_point_grid
from semiwear.meshing.pairs import flank_pair
from semiwear.meshing.tooth_contact import contact_points, unloaded_contact
from semiwear.scene import Placement
from tests.strategies.bevel import BevelPair
from tests.strategies.point_flanks import bevel_scene, scene_of

PAIRS = {"spiral bevel": BevelPair(), "hypoid": BevelPair(offset=-15.0)}
MOVES = {
    "offset_mm": (0.02, np.array([1.0, 0.0, 0.0]), np.zeros(3)),
    "axial_pinion_mm": (0.02, np.array([0.0, 0.0, 1.0]), np.zeros(3)),
    "axial_gear_mm": (0.02, np.array([0.0, 1.0, 0.0]), np.zeros(3)),
    "shaft_angle_error_mrad": (0.2, np.zeros(3), np.array([1e-3, 0.0, 0.0])),
    "pinion_slope_mrad": (0.2, np.zeros(3), np.array([0.0, 1e-3, 0.0])),
}


@pytest.fixture(scope="module", params=list(PAIRS))
def pair(request) -> BevelPair:
    return PAIRS[request.param]


@pytest.fixture(scope="module")
def scene(pair, tmp_path_factory) -> sw.Scene:
    return scene_of(bevel_scene(pair, tmp_path_factory.mktemp("bevel"), harmonics=5))


@pytest.fixture(scope="module")
def mesh(scene):
    return flank_pair(scene.gear_pair, Placement())


def test_the_pitch_surfaces_are_the_pitch_cones(pair, mesh):
    surface = mesh.flanks.pitch_surfaces[1]
    # of the gear, whose own axis points from the apex to the heel; its teeth point to the apex's side
    assert surface.normal == pytest.approx((cos(pair.pitch_angle), -np.sin(pair.pitch_angle)), abs=1e-3)
    face = np.linspace(*mesh.face_limits, 5)
    share = mesh.pitch_profile(face) / mesh.borders(face, sharp=True).tip
    height = (pair.pinion_addendum + 0.05) / (pair.pinion_addendum + 0.05 + pair.gear_addendum)
    assert share == pytest.approx(height, abs=0.06)


def test_without_ease_off_the_pair_is_conjugate(tmp_path):
    exact = BevelPair(crowning=0.0, profile_crowning=0.0)
    mesh = flank_pair(scene_of(bevel_scene(exact, tmp_path, (61, 81))).gear_pair, Placement())
    face = np.linspace(*mesh.face_limits, 7)[1:-1]
    profile = np.linspace(0.1, 0.9, 60)[:, None] * mesh.borders(face).tip
    roll = np.linspace(-0.6, 0.6, 241)[:, None, None]
    met = mesh.meeting(face, profile, roll)
    ends = mesh.borders(face)
    inside = (met.driving_profile > 0.0) & (met.driving_profile < ends.driving_tip)
    least = np.where(inside, met.separation, np.inf).min(axis=0)
    touched = np.isfinite(least) & (np.argmin(np.where(inside, met.separation, np.inf), axis=0) > 0)
    touched &= np.argmin(np.where(inside, met.separation, np.inf), axis=0) < roll.size - 1
    assert touched.sum() > 50
    # a point is met between two of the rolls: what is left is the sagitta of its approach
    assert np.abs(least[touched]).max() < 5e-4
    assert least[touched].min() > -1e-4


def test_unloaded_contact(pair, mesh):
    contact = unloaded_contact(mesh, 11)
    assert contact.contact_ratio > 1.2
    assert contact.points.inside.all()
    assert np.all(contact.points.curvature > 0.0)
    # the contact runs across the middle of the tooth
    assert abs(np.interp(0.0, contact.roll, contact.points.face)) < 0.15 * pair.face_width
    error = contact.transmission_error
    middle = int(np.argmax(error))
    assert 0 < middle < 10
    assert np.all(np.diff(error[: middle + 1]) > 0.0) and np.all(np.diff(error[middle:]) < 0.0)


def test_beyond_both_flanks_everything_is_finite(scene, mesh):
    """Tooth pairs far from contact, places beyond all borders, a pinion far from its place."""
    low, high = mesh.face_limits
    face = np.linspace(low - 0.1 * (high - low), high + 0.1 * (high - low), 9)
    tip = mesh.borders(face, sharp=True).tip
    profile = np.linspace(-0.4, 1.4, 11)[:, None] * tip
    roll = np.linspace(-5.0, 5.0, 31)[:, None, None]
    for placement in (Placement(), Placement(offset_mm=0.5, axial_pinion_mm=-1.0, shaft_angle_error_mrad=5.0)):
        met = flank_pair(scene.gear_pair, placement).meeting(face, profile, roll)
        for values in (met.separation, met.position, met.normal, met.driving_profile, met.driving_face):
            assert np.isfinite(values).all()
        # far above the tip the driving flank ends where it should
        assert met.driving_profile.max() > mesh.borders(face).driving_tip


@pytest.mark.parametrize("name", list(MOVES))
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_position_errors_move_the_pattern(pair, scene, mesh, name, sign):
    size, shift, turn = MOVES[name]
    placement = Placement(**{name: sign * size})
    moved = contact_points(flank_pair(scene.gear_pair, placement), np.zeros(1))
    before = contact_points(mesh, np.zeros(1))
    foretold = pair.contact_shift(sign * size * shift, sign * size * turn, mesh.pitch_point) / cos(pair.spiral_angle)
    found = float(moved.face[0] - before.face[0])
    assert moved.inside.all()
    assert np.sign(found) == np.sign(foretold)
    assert 0.8 < found / foretold < 1.25


@pytest.mark.slow
def test_loaded_contact_and_wear(pair, scene):
    tree = sw.simulate(scene)
    history, flank = tree["history"], tree["flank"]
    assert float(history.wear_depth_max_pinion[-1]) > float(history.wear_depth_max_root[-1]) > 0.0
    assert np.all(history.root_stress_max.values > 0.0)
    assert np.all(history.transmission_error_mean.values < 0.0)
    assert float(history.load_share_max.max()) <= 1.0 + 1e-9
    worn = flank.wear_depth.isel(wear_step=-1, body=1)
    along = worn.max("profile").values
    # the ease-off keeps the contact off both ends
    assert max(along[0], along[-1]) < 0.5 * along.max()
    assert np.all(flank.surface_error.values < 0.01)


@pytest.mark.slow
def test_columns_may_run_either_way(tmp_path):
    """A pinion whose columns run from heel to toe: its stations are named after those of the gear that they meet."""
    data = bevel_scene(BevelPair(), tmp_path, tooth_compliance="rigid")
    grid = read_point_grid(tmp_path / "pinion.nc")
    assert isinstance(grid, PointGrid)
    file = tmp_path / "reversed.nc"
    write_point_grid(file, PointGrid(grid.points[:, ::-1], grid.normals[:, ::-1]))
    other = data | {"gear_pair": data["gear_pair"] | {"pinion_file": str(file)}}
    first, second = (sw.simulate(scene_of(one))["history"].to_dataset() for one in (data, other))
    for name, values in first.data_vars.items():
        assert second[name].values == pytest.approx(values.values, rel=1e-4), name


@pytest.mark.slow
def test_an_offset_error_moves_the_wear_to_an_end(pair, scene, mesh):
    """To the side that the rigid analysis tells, and deeper where less of the tooth carries."""
    rigid = scene.replace({"numerics.tooth_compliance": "rigid"})
    centres = []
    for offset in (-0.04, 0.04):
        tree = sw.simulate(rigid.replace({"effects.misalignment.offset_mm": offset}))
        depth = tree["flank"].wear_depth.isel(wear_step=-1, body=1).sum("profile")
        centres.append(float((depth * depth.face).sum() / depth.sum()))
    foretold = pair.contact_shift(np.array([0.04, 0.0, 0.0]), np.zeros(3), mesh.pitch_point)
    assert np.sign(centres[1] - centres[0]) == np.sign(foretold)
    assert abs(centres[1] - centres[0]) > 0.5 * abs(foretold)
