"""Registration of measured flanks: known displacements come back, signs are right, bad input is told."""

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from semiwear.errors import SceneError
from semiwear.geometry.point_grid import PointGrid, write_point_grid
from semiwear.inference.observations import channels_of
from semiwear.measured.files import read_measured
from semiwear.measured.nearest import around_axis, feet
from semiwear.measured.nominal import nominal_flank
from semiwear.measured.rigid import Displacement, determined, motions_of, require_motions
from semiwear.measured.worn import as_wear
from semiwear.meshing.deviation_grid import write_deviation_grid
from tests.strategies.measured import displaced, grid_on

ARCSEC = np.pi / 180.0 / 3600.0
HELICAL = {"gear_pair.helix_angle_deg": 15.0, "gear_pair.hand": "left", "gear_pair.centre_distance_mm": None}


@pytest.fixture(scope="module")
def scenes(shipped, spur):
    coast = {"operation.loaded_flank": "coast"}
    return {
        "face gear": shipped,
        "face gear, coast": shipped.replace(coast),
        "spur": spur,
        "spur, coast": spur.replace(coast),
        "helical": spur.replace(HELICAL),
    }


KINDS = ("face gear", "face gear, coast", "spur", "spur, coast", "helical")
BODIES = ("pinion", "gear")


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("kind", KINDS)
def test_normals_are_those_of_the_surface(scenes, kind, body):
    flank = nominal_flank(scenes[kind], body)
    face, profile, *_ = grid_on(flank, 7, 5)
    h = 1e-4
    along, across = (
        (flank.points(face + a, profile + b)[0] - flank.points(face - a, profile - b)[0]) / (2.0 * h)
        for a, b in ((h, 0.0), (0.0, h))
    )
    points, normals = flank.points(face, profile)
    np.testing.assert_allclose(np.sum(normals * along, axis=-1), 0.0, atol=1e-7)
    np.testing.assert_allclose(np.sum(normals * across, axis=-1), 0.0, atol=1e-7)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1.0, rtol=1e-13)
    _, radius = flank.place(face, profile)
    np.testing.assert_allclose(np.hypot(points[..., 0], points[..., 1]), radius, rtol=1e-12)


@pytest.mark.parametrize("body", BODIES)
def test_the_coast_flank_is_the_other_side_of_the_tooth(scenes, body):
    drive, coast = (nominal_flank(scenes[kind], body) for kind in ("spur", "spur, coast"))
    face, profile, *_ = grid_on(drive, 5, 4)
    there, here = (flank.points(face, profile)[0] for flank in (drive, coast))
    for first, second in zip(around_axis(there)[:2], around_axis(here)[:2], strict=True):
        np.testing.assert_allclose(first, second, atol=1e-12)
    # a mirror image turns the other way about the axis from root to tip
    angles = [np.unwrap(np.arctan2(points[..., 1], points[..., 0]), axis=0) for points in (there, here)]
    turns = [angle - angle[0] for angle in angles]
    np.testing.assert_allclose(turns[0], -turns[1], atol=1e-12)
    assert np.abs(turns[0]).max() > 0.01


@pytest.mark.parametrize("displacement", [(0.0, 0.0), (1e-3, 0.02), (2.5, -0.3)], ids=str)
@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("kind", KINDS)
def test_a_rigid_displacement_comes_back(scenes, kind, body, displacement):
    """To 1e-6 mm, with nothing left as deviation; where the flank feels a shift along its axis, that as well."""
    flank = nominal_flank(scenes[kind], body)
    face, profile, *_ = grid_on(flank, 21, 15)
    angle, along = displacement
    points = displaced(flank, face, profile, np.zeros(face.shape), Displacement.about_axis(angle, along))
    found = sw.register(scenes[kind], points, body, fit="all")
    assert float(np.abs(found["deviation"]).max()) < 1e-3 * 1e-3  # um
    assert int(found["points"]) == face.size
    if kind.startswith("face gear") and body == "gear":
        radius = float(found["flank_radius"].max())
        assert abs(float(found["axial"]) - along) < 1e-6
        assert abs(float(found["rotation"]) * ARCSEC - angle) * radius < 1e-6
    else:
        assert found.attrs["held"] == "axial" and "axial" not in found
        if kind != "helical":  # there a shift is a rotation
            assert abs(float(found["rotation"]) * ARCSEC - angle) * float(found["flank_radius"].max()) < 1e-6


def test_six_motions_come_back(scenes):
    scene = scenes["face gear"]
    flank = nominal_flank(scene, "gear")
    every = ("rotation", "axial", "radial", "tangential", "tilt_radial", "tilt_tangential")
    amounts = np.array([1e-4, 0.01, -0.02, 0.015, 4e-5, -6e-5])
    face, profile, *_ = grid_on(flank, 21, 21)
    motion = motions_of(flank, every).displacement(amounts)
    points = displaced(flank, face, profile, np.zeros(face.shape), motion)
    found = sw.register(scene, points, fit="all", motions=every)
    assert float(np.abs(found["deviation"]).max()) < 1e-6
    # as far as the flank tells them apart; which it does here to some nanometres
    told = [float(found[name]) * (ARCSEC if "rot" in name or "tilt" in name else 1.0) for name in every]
    np.testing.assert_allclose(told, amounts, atol=2e-6)


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("kind", KINDS)
def test_material_in_excess_is_positive(scenes, kind, body):
    flank = nominal_flank(scenes[kind], body)
    face, profile, p, f = grid_on(flank, 21, 15)
    deviation = 1e-3 * np.sin(5.0 * p) * np.cos(4.0 * f)
    points = displaced(flank, face, profile, deviation, Displacement.none())
    found = sw.register(scenes[kind], points, body, datum="as_measured")
    np.testing.assert_allclose(found["deviation"].values, 1e3 * deviation, atol=1e-6)
    np.testing.assert_allclose(found["flank_profile"].values, profile, atol=1e-7)
    worn = sw.measured_wear(scenes[kind], points, body=body, datum="as_measured")
    np.testing.assert_allclose(worn["wear_depth"].values, -1e3 * deviation, atol=1e-6)


def test_before_and_after_differ_by_the_wear(scenes):
    scene = scenes["face gear"]
    flank = nominal_flank(scene)
    face, profile, p, f = grid_on(flank, 25, 19)
    form = 2e-3 * np.sin(3.0 * p + f)
    wear = 8e-3 * np.exp(-(((p - 0.3) / 0.2) ** 2) - ((f - 0.5) / 0.2) ** 2)
    new = displaced(flank, face, profile, form, Displacement.none())
    worn = displaced(flank, face, profile, form - wear, Displacement.none())
    found = sw.measured_wear(scene, worn, new, datum="as_measured")
    np.testing.assert_allclose(found["wear_depth"].values, 1e3 * wear, atol=2e-3)
    # on another grid: linear between its points
    face_2, profile_2, p_2, f_2 = grid_on(flank, 61, 41, 0.02)
    denser = displaced(flank, face_2, profile_2, 2e-3 * np.sin(3.0 * p_2 + f_2), Displacement.none())
    found = sw.measured_wear(scene, worn, denser, datum="as_measured")
    assert int(found["points"]) == p.size
    np.testing.assert_allclose(found["wear_depth"].values, 1e3 * wear, atol=0.02)


def test_wear_does_not_draw_the_datum_along(scenes):
    """Half of the flank worn by up to 20 um: a one-sided fit finds the unworn rest, a plain one follows the wear."""
    scene = scenes["face gear"]
    flank = nominal_flank(scene)
    face, profile, p, f = grid_on(flank, 41, 31)
    noise = 5e-4 * np.random.default_rng(5).standard_normal(p.shape)
    wear = 2e-2 * np.maximum(1.0 - ((p - 0.35) / 0.35) ** 2 - ((f - 0.45) / 0.4) ** 2, 0.0)
    points = displaced(flank, face, profile, noise - wear, Displacement.about_axis(0.2, 0.01))
    missed = {}
    for fit in ("one_sided", "all", "unworn"):
        found = sw.register(scene, points, fit=fit, unworn=wear == 0.0)
        missed[fit] = float(np.abs(found["deviation"].values - 1e3 * (noise - wear)).max())
    assert np.mean(wear > 0.0) > 0.4
    assert missed["one_sided"] < 0.3 and missed["unworn"] < 0.3  # um
    assert missed["all"] > 2.0


def test_a_flank_without_wear_is_fitted_alike_either_way(scenes):
    scene = scenes["spur"]
    flank = nominal_flank(scene)
    face, profile, *_ = grid_on(flank, 41, 31)
    noise = 5e-4 * np.random.default_rng(6).standard_normal(face.shape)
    points = displaced(flank, face, profile, noise, Displacement.about_axis(0.1))
    one, every = (sw.register(scene, points, fit=fit) for fit in ("one_sided", "all"))
    assert float(every["residual_rms"]) == pytest.approx(0.5, rel=0.1)  # um: the noise
    apart = np.abs(one["deviation"].values - every["deviation"].values).max()
    assert apart < 0.05  # um: a tenth of the noise
    assert abs(float(every["rotation"]) * ARCSEC - 0.1) < 4.0 * float(every["rotation_uncertainty"]) * ARCSEC
    lever = float(flank.pair.lever_arm(flank.pair.pitch_point[None])[0]) * flank.pair.driving_meshes
    expected = 5e-4 / np.sqrt(face.size) / lever / ARCSEC
    assert float(every["rotation_uncertainty"]) == pytest.approx(expected, rel=0.35)


def test_motions_that_a_flank_cannot_tell():
    x = np.linspace(0.0, 1.0, 20)
    modes = np.stack([np.ones(20), 2.0 * np.ones(20), x, np.zeros(20), 3.0 - x], axis=1)
    assert determined(modes).tolist() == [True, False, True, False, False]


def test_feet_beyond_the_flank_do_not_count(scenes):
    flank = nominal_flank(scenes["spur"])
    face, profile, *_ = grid_on(flank, 11, 9)
    profile = profile + 0.3 * np.ptp(profile)
    found = feet(flank, flank.points(face, profile)[0])
    tip = flank.limits(face)[1]
    assert not found.inside[profile > tip + 0.01].any()
    assert found.inside[profile < tip - 0.01].all()


# ---- bad input


@pytest.fixture
def good(spur):
    flank = nominal_flank(spur)
    face, profile, *_ = grid_on(flank, 11, 9)
    return displaced(flank, face, profile, np.zeros(face.shape), Displacement.about_axis(0.3))


def refused(scene, points, *words, **options):
    with pytest.raises(SceneError) as error:
        sw.register(scene, points, **options)
    assert all(word in str(error.value) for word in words), str(error.value)


def with_gap(points):
    points[3, 4, 1] = np.nan
    return points


REFUSED = {
    "a gap": (with_gap, ["1 points that are not finite", "(3, 4)"]),
    "metres": (lambda points: 1e-3 * points, ["points in mm", "metres"]),
    "micrometres": (lambda points: 1e3 * points, ["points in mm", "micrometres"]),
    "inches": (lambda points: points / 25.4, ["points in mm", "inches"]),
    # in a mirror a spur tooth's drive flank is its coast flank
    "a mirror image": (lambda points: points * np.array([-1.0, 1.0, 1.0]), ["other flank or a mirror image"]),
    "another axis": (lambda points: points[..., ::-1], ["measured"]),
    "beside the flank": (
        lambda points: points + np.array([0.0, 0.0, 13.0]),
        ["on the nominal flank", "axial position"],
    ),
    "too few": (lambda points: points[:3], ["3 x 9 points"]),
    "one point over and over": (lambda points: np.broadcast_to(points[5, 5], points.shape), ["points within 0 mm"]),
    "no points": (lambda points: points[..., :2], ["(11, 9, 2)"]),
}


@pytest.mark.parametrize("name", REFUSED)
def test_points_that_are_not_of_this_flank_are_refused(spur, good, name):
    change, words = REFUSED[name]
    refused(spur, change(good), *words)


def test_points_of_another_flank_are_refused(spur, good):
    refused(spur.replace({"operation.loaded_flank": "coast"}), good, "other flank or a mirror image")
    refused(spur, good, "points at radii from", body="pinion")


def test_options_out_of_range_are_refused(spur, good):
    refused(spur, good, "datum", datum="none")
    refused(spur, good, "fit", fit="some")
    refused(spur, good, "unworn", fit="unworn")
    refused(spur, good, "(2, 2)", fit="unworn", unworn=np.ones((2, 2)))
    refused(spur, good, "motions", motions=("spin",))
    refused(spur, good, "body", body="wheel")


# ---- files


@pytest.mark.parametrize("suffix", ["nc", "csv"])
def test_points_from_files(spur, good, tmp_path, suffix):
    path = tmp_path / f"tooth.{suffix}"
    write_point_grid(path, PointGrid(good))
    np.testing.assert_array_equal(sw.register(spur, path)["deviation"], sw.register(spur, good)["deviation"])


@pytest.mark.parametrize("suffix", ["nc", "csv"])
def test_deviations_from_files(spur, tmp_path, suffix):
    path = tmp_path / f"tooth.{suffix}"
    p, f = np.linspace(0.0, 1.0, 9), np.linspace(0.0, 14.0, 7)
    deviation = 3.0 * p[:, None] - 0.1 * f
    write_deviation_grid(path, p, f, deviation, face_unit="mm")
    found = sw.register(spur, path)
    np.testing.assert_allclose(found["deviation"], deviation)
    np.testing.assert_allclose(found["flank_face"][0], f - 7.0)
    root, tip = nominal_flank(spur).limits(np.zeros(1))
    np.testing.assert_allclose(found["flank_profile"][[0, -1], 0], [root[0], tip[0]])


def test_an_exported_flank_registers(spur, tmp_path):
    path = tmp_path / "gear.nc"
    sw.export_flank(spur, "gear", path, points=(31, 21))
    found = sw.register(spur, path)
    assert float(np.abs(found["deviation"]).max()) < 1e-6
    assert float(found["points"]) > 0.8 * 31 * 21  # the rest lies on the roundings of tip and ends


def test_missing_files_are_told(spur, tmp_path):
    refused(spur, tmp_path / "none.nc", "no such file")
    (tmp_path / "empty.nc").write_bytes(b"nothing")
    refused(spur, tmp_path / "empty.nc", "netCDF")
    (tmp_path / "words.csv").write_text("one,two\n1,2\n")
    refused(spur, tmp_path / "words.csv", "profile")


def test_measurements_pass_through(good):
    grid = PointGrid(good)
    assert read_measured(grid) is grid


def test_modifications_are_no_wear(spur):
    """A flank that has the scene's tip relief has not worn."""
    relieved = spur.replace({"effects.modification.gear.tip_relief_um": 20.0})
    flank = nominal_flank(spur)
    face, profile, *_ = grid_on(flank, 21, 9)
    root, tip = flank.limits(face)
    t = np.maximum((profile - tip) / ((tip - root) / 3.0) + 1.0, 0.0)
    points = displaced(flank, face, profile, -20e-3 * t**2, Displacement.none())
    found = sw.measured_wear(relieved, points, datum="as_measured")
    assert float(np.abs(found["wear_depth"]).max()) < 1e-6
    assert float(sw.measured_wear(spur, points, datum="as_measured")["wear_depth"].max()) > 15.0


@pytest.mark.parametrize("datum", ["best_fit", "rotation", ("rotaton",), ["rotation", "spin"], 3, (3,)])
def test_a_datum_of_no_motion_is_refused_wherever_it_is_given(spur, datum):
    """A name without a list about it, or a name of none, would mean that no motion is open."""
    scene = spur.replace({"wear.until.meshes": 1e8})
    flank = nominal_flank(spur)
    points, _ = flank.points(*grid_on(flank, 9, 7)[:2])
    tree = xr.DataTree()  # looked at afterwards
    for call, field in (
        (lambda: sw.calibrate(scene, points, datum=datum), "datum"),
        (lambda: sw.register(scene, points, motions=datum), "motions"),
        (lambda: channels_of(scene, sw.WornFlank(points, datum=datum)), "observed.datum"),
        (lambda: sw.compare_wear(tree, points, datum=datum), "datum"),
    ):
        with pytest.raises(SceneError, match=f"{field}: found"):
            call()


def test_a_typing_error_in_a_datum_is_told(spur):
    with pytest.raises(SceneError, match="did you mean rotation"):
        require_motions(("rotaton",), "datum")
    assert require_motions(iter(("axial", "rotation")), "datum") == ("axial", "rotation")
    assert require_motions((), "datum") == ()


def test_datasets_of_the_other_body_are_refused(spur):
    """Deviations and wear alike say whose they are."""
    flank = nominal_flank(spur, "pinion")
    points, _ = flank.points(*grid_on(flank, 9, 7)[:2])
    for data in (sw.register(spur, points, "pinion"), sw.measured_wear(spur, points, body="pinion")):
        with pytest.raises(SceneError, match="found 'a flank of the pinion'; allowed: one of the gear"):
            as_wear(spur, data, None, "gear")
        assert as_wear(spur, data, None, "pinion").depth.shape == (9, 7)
