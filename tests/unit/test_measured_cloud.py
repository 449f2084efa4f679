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
    c, s = np.cos(turn), np.sin(turn)
    return np.vstack(parts) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize(("body", "teeth"), [("pinion", 16), ("gear", 24)])
def test_the_flank_is_found_in_a_whole_tooth(body, teeth):
    """Other flank and tip land draw the median angle between the flanks, and leave where most points lie."""
    found = sw.register(SPUR, sw.flank_from_points(SPUR, whole_tooth(body, teeth), body, shape=(21, 21)), body)
    assert float(found.rotation) / 3600.0 == pytest.approx(np.degrees(0.3), abs=1e-4)
    assert np.abs(found.deviation).max() < 2.0  # um: where the tip land meets the flank


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
