"""Clouds of points: the worn flank is found among the points of a whole tooth, in whatever order."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import semiwear as sw
from semiwear.geometry.point_grid import read_point_grid, write_point_grid
from semiwear.measured.comparison import grid_of
from semiwear.measured.nominal import nominal_flank
from semiwear.measured.predicted import FlankReading
from semiwear.measured.rigid import Displacement

SPUR = sw.load_scene("spur_fzg_c")
FLANK = nominal_flank(SPUR, "gear")


def depth_at(u):
    """Wear [mm]."""
    return 0.02 * np.exp(-(((u - 0.3) / 0.2) ** 2))


def scanned(count=6000, noise=3e-4, turn=0.7):
    """Points of a worn flank in random order, turned about the axis, among points of other surfaces."""
    rng = np.random.default_rng(3)
    v, u = rng.uniform(-0.02, 1.02, (2, count))
    points, normals = FLANK.points(*FLANK.places(v, u))
    points = points - (depth_at(u) - noise * rng.normal(size=count))[:, None] * normals
    others = rng.normal(size=(count // 10, 3)) * [8.0, 8.0, 5.0] + points.mean(axis=0)
    return rng.permutation(Displacement.about_axis(turn).apply(np.vstack([points, others])))


CLOUD = scanned()
FEW = CLOUD[::4]


@cache
def of_few():
    """The flank that is found in few of the points as they were made."""
    return sw.flank_from_points(SPUR, FEW, shape=(12, 12))


@pytest.mark.parametrize("form", ["array", "xyz", "ply"])
def test_wear_is_found_in_a_cloud(form, tmp_path):
    given = CLOUD
    if form == "xyz":
        given = tmp_path / "scan.xyz"
        given.write_text("x y z\n" + "\n".join(" ".join(map(str, point)) for point in CLOUD.tolist()))
    elif form == "ply":
        meshio = pytest.importorskip("meshio", reason="extra view: .ply is read by meshio")
        given = tmp_path / "scan.ply"
        meshio.Mesh(CLOUD, [("vertex", np.arange(len(CLOUD))[:, None])]).write(given)
    grid = sw.flank_from_points(SPUR, given, shape=(31, 31))
    found = sw.measured_wear(SPUR, grid)
    root, tip = (end[0] for end in FLANK.limits(np.zeros(1)))
    expected = 1e3 * depth_at((found.flank_profile.values - root) / (tip - root))
    inside = found.inside.values == 1
    apart = np.abs(found.wear_depth.values - expected)[inside]
    # the noise of some seven points a cell, and what a stray point adds
    assert np.median(apart) < 0.2 and np.quantile(apart, 0.95) < 0.6


@pytest.mark.parametrize(("between", "decimal"), [(", ", "."), (";", ","), ("\t", ","), ("  ", ","), (";", ".")])
def test_text_of_a_cloud_is_read_however_numbers_are_written(between, decimal, tmp_path):
    file = tmp_path / "scan.txt"
    rows = (between.join(str(value).replace(".", decimal) for value in point) for point in FEW.tolist())
    file.write_text("\n".join(rows))
    found = sw.flank_from_points(SPUR, file, shape=(12, 12))
    np.testing.assert_array_equal(found.points, of_few().points)


def whole_tooth(body, teeth, count=6000, turn=0.3):
    """Points of a nominal tooth: its flank, the flank that mirrors it, and its tip land, turned about the axis."""
    flank = nominal_flank(SPUR, body)
    rng = np.random.default_rng(0)

    def on_flank(v, u):
        return flank.points(*flank.places(v, u))[0]

    def angles(points):
        return np.hypot(*points.T[:2]), np.arctan2(points[:, 1], points[:, 0])

    middle, normal = flank.points(*flank.places(0.5, 0.5))
    # the material lies where the normal does not point, a quarter pitch at the middle
    side = -np.sign(normal[:2] @ [-middle[1], middle[0]])
    centre = np.arctan2(middle[1], middle[0]) + side * np.pi / teeth / 2.0
    parts = [on_flank(*rng.random((2, count)))]
    for points, share in ((on_flank(*rng.random((2, count))), 1.0), (on_flank(rng.random(count // 5), 1.0), None)):
        radius, angle = angles(points)
        across = rng.random(len(points)) if share is None else share
        angle = angle + 2.0 * across * (centre - angle)
        parts.append(np.column_stack([radius * np.cos(angle), radius * np.sin(angle), points[:, 2]]))
    return Displacement.about_axis(turn).apply(np.vstack(parts))


@pytest.mark.parametrize(("body", "teeth"), [("pinion", 16), ("gear", 24)])
def test_the_flank_is_found_in_a_whole_tooth(body, teeth):
    """Other flank and tip land draw the median angle between the flanks, and leave where most points lie."""
    found = sw.register(SPUR, sw.flank_from_points(SPUR, whole_tooth(body, teeth), body, shape=(21, 21)), body)
    assert float(found.rotation) / 3600.0 == pytest.approx(np.degrees(0.3), abs=1e-4)
    assert np.abs(found.deviation).max() < 2.0  # um: where the tip land meets the flank


SHARE = np.random.default_rng(5).random((8000, 2))


def part_of_the_flank(kept):
    """Points of a worn flank where a part of it was scanned; shares from root to tip and along the tooth."""
    v, u = SHARE[:, 1], SHARE[:, 0]
    points, normals = FLANK.points(*FLANK.places(v, u))
    return (points - depth_at(u)[:, None] * normals)[kept(u, v)]


@pytest.mark.parametrize(
    ("kept", "missing"),
    [
        (lambda u, v: u > 0.2, lambda u, v: u < 0.17),
        (lambda u, v: v < 0.75, lambda u, v: v > 0.79),
        (lambda u, v: abs(u - 0.5) > 0.13, lambda u, v: abs(u - 0.5) < 0.09),
        (lambda u, v: u > 0.04, lambda u, v: u < 0.03),
    ],
)
def test_what_was_not_scanned_does_not_count(kept, missing):
    """A root, an end, a stripe that are missing; and the root's border alone."""
    grid = sw.flank_from_points(SPUR, part_of_the_flank(kept), shape=(31, 31))
    found = sw.measured_wear(SPUR, grid)
    u, v = np.meshgrid(*2 * [(np.arange(31) + 0.5) / 31], indexing="ij")
    inside = found.inside.values == 1
    assert not inside[missing(u, v)].any() and inside[kept(u, v)].mean() > 0.99
    expected = 1e3 * depth_at(u)
    # cells that were scanned in part stand for their middle: half a cell of a slope of 86 um is 1.4 um
    assert np.abs(found.wear_depth.values - expected)[inside].max() < 2.0


def test_a_whole_flank_counts_everywhere(tmp_path):
    grid = sw.flank_from_points(SPUR, part_of_the_flank(lambda u, v: u >= 0.0), shape=(31, 31))
    assert grid.counts.all()
    some = replace(grid, counts=grid.points[..., 2] > 0.0)
    write_point_grid(tmp_path / "some.nc", some)
    np.testing.assert_array_equal(read_point_grid(tmp_path / "some.nc").counts, some.counts)
    with pytest.raises(sw.SceneError, match="call it"):
        write_point_grid(tmp_path / "some.csv", some)
    write_point_grid(tmp_path / "all.csv", grid)


@pytest.mark.slow
@pytest.mark.parametrize("least", [0.0, 0.2])
def test_the_coefficient_is_found_from_a_cloud(least):
    """Of a whole flank, and of one whose root was not scanned: its kink is blurred, and nothing else lost."""
    coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.harmonics": 5}
    scene = SPUR.replace({**coarse, "numerics.wear_steps": 3, "wear.until.meshes": 1e8})
    flank = sw.simulate(scene)["flank"].to_dataset().isel(wear_step=-1).sel(body="gear")
    depth = 1e-3 * flank["wear_depth"].transpose("face", "profile").values
    rng = np.random.default_rng(0)
    u, v = rng.random((2, 20000))
    face, profile = FLANK.places(u, v)
    wear = FlankReading.of(grid_of(scene, flank["face"].values, depth.shape[1], "gear"), face, profile).read(depth)
    points, normals = FLANK.points(face, profile)
    cloud = (points - (wear + 3e-4 * rng.standard_normal(wear.size))[:, None] * normals)[v > least]
    found = sw.calibrate(scene, sw.flank_from_points(scene, cloud, shape=(31, 31)), meshes=1e8)
    assert found.coefficient == pytest.approx(1e-13, rel=0.05)


def test_a_grid_finer_than_the_cloud_is_refused():
    with pytest.raises(sw.SceneError, match=r"shape = \("):
        sw.flank_from_points(SPUR, part_of_the_flank(lambda u, v: u >= 0.0)[:600], shape=(61, 61))


@pytest.mark.parametrize(
    ("points", "words"),
    [
        (CLOUD[:50], "50 points"),
        (CLOUD / 25.4, "inches"),
        (CLOUD[:, :2], "shape"),
        (np.where(np.arange(len(CLOUD))[:, None] == 7, np.nan, CLOUD), "not finite"),
        (CLOUD[CLOUD[:, 2] < -2.0], "% of the flank"),
        ("none.xyz", "no such file"),
    ],
)
def test_clouds_that_are_none_of_the_flank_are_refused(points, words):
    with pytest.raises(sw.SceneError, match=words):
        sw.flank_from_points(SPUR, points)


def test_text_that_is_no_cloud_is_refused(tmp_path):
    for name, text, words in (
        ("a.xyz", "1 2 3\n4 5\n", "2 numbers"),
        ("b.xyz", "1 2 3\nx y z\n", "line 2 is no point"),
        ("c.dat", "1 2 3\n", "name it"),
        ("d.ply", "no ply\n", "damaged"),
    ):
        (tmp_path / name).write_text(text)
        with pytest.raises(sw.SceneError, match=words):
            sw.flank_from_points(SPUR, tmp_path / name)
