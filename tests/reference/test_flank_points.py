"""Flanks given as points against the pairs they were exported from."""

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from semiwear.meshing.contact_lines import face_stations, trace_contact_lines
from semiwear.meshing.flank_grid import flank_grid
from semiwear.meshing.pairs import flank_pair
from semiwear.meshing.tooth_contact import unloaded_contact
from semiwear.plan import plan
from semiwear.scene import Placement, scene_from_dict
from tests.scenes import TINY
from tests.strategies.point_flanks import COARSE, exported, noisy, scene_of

FACE_GEAR = sw.load_scene("face_gear_25x160").replace(
    {f"numerics.{name}": value for name, value in COARSE.items()} | {"wear.until.control_depths_um": [5.0, 10.0]}
)
HELICAL = {
    "gear_pair.helix_angle_deg": 20.0,
    "gear_pair.centre_distance_mm": None,
    "gear_pair.pinion_face_width_mm": 30.0,
}
DISPLACED = Placement(offset_mm=0.05, axial_gear_mm=0.1, shaft_angle_error_mrad=0.3, pinion_slope_mrad=0.2)
KINDS = {"wear_depth": "wear", "contact_pressure": "pressure", "transmission_error": "error"}


def kind_of(name: str) -> str:
    return next((kind for start, kind in KINDS.items() if name.startswith(start)), name)


def apart(first, second) -> dict[str, float]:
    """Greatest difference of every quantity of two histories, over the greatest value of its kind."""
    greatest: dict[str, float] = {}
    for name, values in first.data_vars.items():
        kind = kind_of(name)
        greatest[kind] = max(greatest.get(kind, 0.0), float(np.abs(values).max()))
    return {
        name: float(np.abs(first[name].values - second[name].values).max()) / greatest[kind_of(name)]
        for name in first.data_vars
    }


@pytest.fixture(scope="module")
def exact():
    return sw.simulate(FACE_GEAR)


@pytest.fixture(scope="module")
def exact_history(exact):
    return exact["history"].to_dataset()


@pytest.fixture(scope="module")
def face_gear(tmp_path_factory) -> sw.Scene:
    return scene_of(exported(FACE_GEAR, tmp_path_factory.mktemp("points")))


@pytest.fixture(scope="module")
def worn(face_gear):
    return sw.simulate(face_gear)


@pytest.mark.slow
def test_the_face_gear_as_points_wears_as_itself(exact_history, worn):
    found = apart(exact_history, worn["history"].to_dataset())
    assert set(found) == set(exact_history.data_vars)
    assert max(found.values()) < 0.005, found
    assert float(worn["flank"].surface_error.max()) < 0.01  # um


def test_pitch_point_and_rolls_are_those_of_the_exact_pair(face_gear):
    mesh, exact = flank_pair(face_gear.gear_pair, Placement()), flank_pair(FACE_GEAR.gear_pair, Placement())
    assert mesh.pitch_point == pytest.approx(exact.pitch_point, abs=1e-4)
    assert mesh.base_pitch == pytest.approx(exact.base_pitch, rel=1e-6)
    assert mesh.arcsec_per_mm == pytest.approx(exact.arcsec_per_mm, rel=1e-6)
    face = np.linspace(481.0, 559.0, 9)
    places = [pair.meeting(face, pair.pitch_profile(face), np.zeros(1)).position for pair in (mesh, exact)]
    assert places[0] == pytest.approx(places[1], abs=1e-4)


@pytest.mark.parametrize("placement", [Placement(), DISPLACED], ids=["aligned", "displaced"])
def test_separation_of_the_face_gear(face_gear, placement):
    """Where both are told from the same place, inside both flanks: normal distances to some nanometres."""
    mesh, exact = flank_pair(face_gear.gear_pair, placement), flank_pair(FACE_GEAR.gear_pair, placement)
    face, roll = face_stations(exact, 15), np.linspace(-0.9, 0.9, 13)
    lines = [trace_contact_lines(pair, roll, face) for pair in (exact, mesh)]
    ends = exact.borders(face)
    depth = lines[0].driving_profile - ends.driving_root
    inside = (lines[0].separation[0] < 0.1) & (depth > 0.0) & (depth < ends.driving_tip - ends.driving_root)
    assert inside.sum() > 30
    gaps = [line.separation[0] for line in lines]
    # a displaced pair is turned on until it touches: what is left is common to all
    shift = np.median((gaps[0] - gaps[1])[inside])
    if placement.is_aligned:
        assert abs(shift) < 1e-6
    assert (gaps[0] - shift)[inside] == pytest.approx(gaps[1][inside], abs=3e-6)
    assert lines[0].sliding[inside] == pytest.approx(lines[1].sliding[inside], abs=2e-2)
    # curvatures where the difference quotients stay on both flanks
    inside &= (depth > 1.0) & (depth < ends.driving_tip - ends.driving_root - 1.0)
    assert lines[0].separation[2][inside] == pytest.approx(lines[1].separation[2][inside], rel=2e-3)


@pytest.fixture(scope="module")
def helical(tmp_path_factory) -> tuple[sw.Scene, sw.Scene]:
    scene = sw.load_scene("spur_fzg_c").replace(HELICAL)
    return scene, scene_of(exported(scene, tmp_path_factory.mktemp("helical"), (61, 41)))


@pytest.mark.slow
def test_a_helical_pair_as_points(helical):
    """Parallel axes and line contact: exact parallel surfaces, lines that touch evenly."""
    scene, points = helical
    exact, mesh = (flank_pair(one.gear_pair, Placement()) for one in (scene, points))
    normal_base_pitch = 2.0 * np.pi * exact.lever_arm(exact.pitch_point[None])[0] / scene.gear_pair.pinion_teeth
    assert mesh.base_pitch == pytest.approx(normal_base_pitch, rel=1e-6)
    contact = unloaded_contact(mesh, 11)
    assert np.abs(contact.transmission_error).max() < 0.01  # arcsec
    height = mesh.flank_place(1, np.zeros(2), np.array([1.0, 3.0]))
    assert height[0] == pytest.approx(height[1] - exact.working_radii[1], abs=1e-4)
    radius = np.hypot(mesh.pitch_point[0], mesh.pitch_point[1])
    assert radius == pytest.approx(exact.working_radii[0], abs=1e-4)


@pytest.mark.parametrize("pair", ["helical", "face gear"])
def test_coast_flanks_as_points_are_driven_the_other_way_round(pair, tmp_path):
    """Gaps of a tilted pair are those of the coast scene; between its drive flanks they open at the other end."""
    rigid = {"numerics.tooth_compliance": "rigid", "operation.loaded_flank": "coast"}
    coarse = {"numerics.face_slices": 9, "numerics.roll_positions": 8}
    scene = sw.load_scene("spur_fzg_c").replace(HELICAL) if pair == "helical" else FACE_GEAR
    scene = scene.replace(rigid | coarse)
    as_points = scene_of(exported(scene, tmp_path, (61, 41)) | {"operation": {"pinion_torque_Nm": 302.0}})
    assert (as_points.gear_pair.pinion_rotation, as_points.operation.loaded_flank) == ("positive", "drive")
    tilt = Placement(shaft_angle_error_mrad=0.3)
    meshes = flank_pair(as_points.gear_pair, tilt), plan(scene).flank_pair(tilt)
    face, roll = face_stations(meshes[1], 9), np.linspace(-0.6, 0.6, 7)
    ends = meshes[1].borders(face)
    gaps, exact = (trace_contact_lines(mesh, roll, face) for mesh in meshes)
    depth = exact.driving_profile - ends.driving_root
    inside = (exact.separation[0] < 0.1) & (depth > 0.5) & (depth < ends.driving_tip - ends.driving_root - 0.5)
    inside &= (exact.profile > ends.root + 0.5) & (exact.profile < ends.tip - 0.5)
    inside[:, [0, -1]] = False  # on the roundings of the ends
    assert inside.sum() > 15 and np.ptp(exact.separation[0][inside]) > 1e-3
    apart = (gaps.separation[0] - exact.separation[0])[inside]
    # a displaced pair is turned on until it touches: what is left is common to all
    assert np.abs(apart - np.median(apart)).max() < 1e-5


def test_a_coast_flank_is_exported_with_its_own_wear(tmp_path):
    """The worn points are those of `worn_flank`: they hold the nodes of the result."""
    scene = sw.load_scene("spur_fzg_c").replace(
        HELICAL
        | TINY
        | {
            "operation.loaded_flank": "coast",
            "numerics.tooth_compliance": "rigid",
            "numerics.wear_steps": 1,
            "wear.until.meshes": 1e8,
        }
    )
    tree = sw.simulate(scene)
    for body in ("pinion", "gear"):
        sw.export_flank(scene, body, tmp_path / "worn.nc", points=(61, 41), worn=tree)
        with xr.open_dataset(tmp_path / "worn.nc") as data:
            cloud = data.points.values.reshape(-1, 3)
        surface = sw.worn_flank(tree, body).points
        distance = np.linalg.norm(surface[:, None] - cloud, axis=-1).min(axis=1)
        assert distance.max() < 0.6  # mm, from grid point to grid point: the drive flank is millimetres away


@pytest.mark.slow
def test_an_internal_pair_as_points(tmp_path):
    teeth = {"pinion_teeth": 20, "gear_teeth": -60, "centre_distance_mm": None}
    shifts = {"pinion_profile_shift": 0.0, "gear_profile_shift": 0.0}
    scene = sw.load_scene("spur_fzg_c").replace({f"gear_pair.{k}": v for k, v in (teeth | shifts).items()})
    mesh = flank_pair(scene_of(exported(scene, tmp_path, (61, 31))).gear_pair, Placement())
    exact = flank_pair(scene.gear_pair, Placement())
    assert mesh.pitch_point == pytest.approx(exact.pitch_point, abs=1e-3)
    assert mesh.base_pitch == pytest.approx(exact.base_pitch, rel=1e-6)
    assert np.abs(unloaded_contact(mesh, 7).transmission_error).max() < 0.05  # arcsec
    # the tips of an internal gear point to its axis
    heights = mesh.flank_place(1, np.zeros(2), np.array([1.0, 3.0]))
    assert heights[0][1] > heights[0][0]
    assert heights[1][1] < heights[1][0]


@pytest.mark.slow
def test_worn_flanks_are_exported_with_their_wear(exact, face_gear, tmp_path):
    """The gear's surface lies as far below the fresh one as wear says; the pinion, which does not wear, as it was."""
    again = scene_of(exported(FACE_GEAR, tmp_path, worn=exact))
    fresh, gone = (flank_pair(scene.gear_pair, Placement()).flanks for scene in (face_gear, again))
    stations, depth = exact["flank"].face.values, exact["flank"].wear_depth.isel(wear_step=-1, body=1).values.T
    own = flank_pair(FACE_GEAR.gear_pair, Placement())
    grid = flank_grid(own, stations, depth.shape[1])
    face = stations[:, None]
    places = []
    for flanks in (fresh, gone):
        driven, v = flanks.driven, flanks.driven.v_at(face)
        profile = grid.profile - own.borders(stations, sharp=True).root[:, None]
        places.append(driven.points(driven.u_at(profile, driven.profile_length(v)), v))
    (before, normal), (after, _) = places
    below = -np.sum((after - before) * normal, axis=-1)
    assert 1e-3 * depth.max() > 0.005
    # but for the cusp on the pitch cone, which falls between rows of the grid, and the ends of the worn area
    off = np.abs(below - 1e-3 * depth) / (1e-3 * depth.max())
    assert np.quantile(off, 0.95) < 0.02
    assert off.max() < 0.2
    assert gone.driving.surface.points == pytest.approx(fresh.driving.surface.points, abs=1e-9)
    assert np.isfinite(sw.simulate(again)["history"].wear_depth_max_root.values).all()


@pytest.fixture(scope="module")
def short_steps() -> tuple[sw.Scene, xr.Dataset]:
    """Steps of 2.5 um: in twice as long ones a cycle more counts a hundredth, as much as little noise."""
    scene = FACE_GEAR.replace({"wear.until.control_depths_um": [2.5, 5.0, 7.5, 10.0]})
    return scene, sw.simulate(scene)["history"].to_dataset()


@pytest.mark.slow
@pytest.mark.parametrize("size_um", [0.1, 1.0, 3.0])
def test_noise_degrades_gracefully(size_um, short_steps, tmp_path):
    exact_scene, exact_history = short_steps
    scene = scene_of(exported(exact_scene, tmp_path, change=noisy(1e-3 * size_um)))
    assert sw.plan(scene).choices[0].why.count("smoothed by") == 2
    tree = sw.simulate(scene)
    error = tree["flank"].surface_error.values
    assert np.all(error > 0.01 * size_um)
    assert np.all(error < size_um)
    found = apart(exact_history, tree["history"].to_dataset())
    assert all(np.isfinite(value) for value in found.values())
    assert max(found.values()) < 0.005 + 0.02 * size_um, found


@pytest.mark.parametrize(
    "change",
    [
        pytest.param(
            {
                "pinion_face_width_mm": 60.0,
                "pinion_profile_shift": 0.4,
                "gear_profile_shift": -0.1,
                "helix_angle_deg": 30.0,
            },
            marks=pytest.mark.slow,
        ),
        {"face_offset_mm": 3.0, "helix_angle_deg": 20.0},
        {"pinion_face_width_mm": 40.0, "gear_teeth": -67, "helix_angle_deg": 15.0, "pinion_profile_shift": 0.3},
    ],
    ids=["wide, shifted", "offset", "internal"],
)
def test_roll_positions_of_exported_helical_flanks_are_those_of_the_pair(tmp_path, change):
    """Roll 0 is where contact passes the pitch point in the middle of the face, not of a line that a tip cuts."""
    table = {
        "type": "cylindrical",
        "pinion_teeth": 20,
        "gear_teeth": 31,
        "normal_module_mm": 4.0,
        "pressure_angle_deg": 20.0,
        "pinion_face_width_mm": 30.0,
    }
    scene = scene_from_dict({"gear_pair": table | change, "operation": {"pinion_torque_Nm": 400.0}})
    read = scene_of(exported(scene, tmp_path, (61, 61)))
    exact, points = (flank_pair(one.gear_pair, Placement()) for one in (scene, read))
    low, high = exact.face_limits
    face = np.linspace(low, high, 5)
    roll = np.array([-0.4, 0.0, 0.3])[:, None]
    met = [pair.meeting(face, pair.pitch_profile(face), roll) for pair in (exact, points)]
    np.testing.assert_allclose(met[1].position, met[0].position, atol=1e-5)
    near = met[0].separation < 0.5  # farther away the points' flanks go on as polynomials
    assert near.sum() >= 6
    np.testing.assert_allclose(met[1].separation[near], met[0].separation[near], atol=1e-5)
    np.testing.assert_allclose(points.pitch_point, exact.pitch_point, atol=1e-5)
