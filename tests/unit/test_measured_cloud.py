"""Clouds of points: the worn flank is found among the points of a whole tooth, in whatever order."""

import numpy as np
import pytest

import semiwear as sw
from semiwear.measured.nominal import nominal_flank

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
    c, s = np.cos(turn), np.sin(turn)
    others = rng.normal(size=(count // 10, 3)) * [8.0, 8.0, 5.0] + points.mean(axis=0)
    cloud = np.vstack([points, others]) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return rng.permutation(cloud)


CLOUD = scanned()


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
