"""Where the bodies stand and how their flanks part, in `fem_reference`, written without the core's meshing."""

from math import cos, pi, radians, sin

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from fem_reference.fem_results import line_motion
from fem_reference.kinematics import PairKinematics
from fem_reference.pair_motion import rounded
from fem_reference.rigid_lines import RigidFlank, RigidLine, forecast
from fem_reference.wear import FlankWear, NoWear, face_stations, flank_profile, wear_depth_of
from semiwear.errors import ConvergenceError, SceneError
from semiwear.meshing.face_gear_pair import FaceGearMesh
from semiwear.scene import Placement

ASKEW = Placement(0.1, 0.3, -0.05, 0.7, -1.2)


@pytest.fixture(scope="module")
def pair(shipped: sw.Scene) -> PairKinematics:
    return PairKinematics(shipped)


@pytest.mark.parametrize("length", [-12.0, -4.0, 0.0, 6.0, 13.0])
def test_gap_is_zero_on_the_path_of_contact(pair: PairKinematics, length: float) -> None:
    """Design, section 3: the path is x = l cos a, y = -r_ps + l sin a, z = L0, with l = -base pitch * roll."""
    alpha = radians(25.0)
    point = np.array([length * cos(alpha), -88.9 + length * sin(alpha), 508.0])
    roll = -length / pair.pinion.base_pitch
    gap, profile, face = pair.distance(pair.pinion_pose(roll).back(point))
    assert abs(gap) < 1e-12
    assert face == pytest.approx(508.0, abs=1e-9)
    # the same point lies on the gear's flank: radius and height find it there
    own = pair.gear_pose(roll).back(point)
    radius = np.hypot(own[0], own[2])
    on_gear = pair.gear.profile_from_height(radius, point[1] + 88.9)
    met = pair.meeting(radius, on_gear, roll)
    assert met.position == pytest.approx(point, abs=1e-9)
    assert abs(met.gap) < 1e-10
    assert met.pinion_profile == pytest.approx(profile, abs=1e-9)


def test_pair_ahead_stands_one_base_pitch_on(pair: PairKinematics) -> None:
    """Tooth -1 of the gear and tooth +1 of the pinion are where pair 0 is one roll position later."""
    own, _ = pair.gear.points(np.array(508.0), np.array(0.5))
    turn = -2.0 * pi / pair.gear.gear_teeth
    neighbour = np.array([own[0] * cos(turn) + own[2] * sin(turn), own[1], own[2] * cos(turn) - own[0] * sin(turn)])
    assert pair.gear_pose(0.2).points(neighbour) == pytest.approx(pair.gear_pose(1.2).points(own), abs=1e-10)


@pytest.mark.parametrize("placement", [Placement(), ASKEW])
def test_agrees_with_the_core(shipped: sw.Scene, placement: Placement) -> None:
    """Two derivations, one geometry."""
    own, core = PairKinematics(shipped, placement), FaceGearMesh(shipped.gear_pair, placement)
    face, profile = np.linspace(480.0, 560.0, 7)[:, None], np.linspace(-4.0, 3.0, 5)
    for roll in (-0.7, 0.0, 0.4):
        ours, theirs = own.meeting(face, profile, roll), core.meeting(face, profile, np.array(roll))
        assert ours.gap == pytest.approx(theirs.separation, abs=1e-11)
        assert ours.normal == pytest.approx(theirs.normal, abs=1e-11)
        assert ours.pinion_face == pytest.approx(theirs.driving_face, abs=1e-9)
        assert own.sliding(ours.position) == pytest.approx(core.sliding(theirs.position), abs=1e-9)


def test_sliding_and_speeds(pair: PairKinematics) -> None:
    """No sliding at the pitch point; both lines' speeds differ by the sliding across the line."""
    assert np.linalg.norm(pair.sliding(np.array([0.0, -88.9, 508.0]))) < 1e-10
    line, motion = line_motion(RigidFlank(pair), 0.25)
    middle = int(np.argmin(line.gap))
    # along the path of contact the contact moves at the base radius a radian
    assert motion.speed["gear"][middle] == pytest.approx(motion.speed["pinion"][middle], rel=0.4)
    assert motion.sliding[middle] == pytest.approx(
        abs(motion.speed["gear"][middle] - motion.speed["pinion"][middle]), rel=0.2
    )


def test_rounded_edges(pair: PairKinematics) -> None:
    face = np.array([500.0, 559.9])
    added = rounded(pair, face, np.zeros(2), pair.meeting(face, np.zeros(2), 0.0))
    assert added[0] == 0.0
    # both bodies end near 560: two arcs of 0.2 mm that have turned by half, at least one of them
    arc = 0.2 - np.sqrt(0.2**2 - 0.1**2)
    assert arc - 1e-9 < added[1] < 2.0 * arc + 1e-9
    tip = pair.gear.tip_profile(np.array([500.0]))
    beyond = pair.meeting(np.array([500.0]), tip + 0.01, 0.0)
    assert np.isinf(rounded(pair, np.array([500.0]), tip + 0.01, beyond)).all()


def test_valley_and_forecast(shipped: sw.Scene, pair: PairKinematics) -> None:
    flank = RigidFlank(pair)
    for position in (0.0, 0.3, 0.8):
        assert abs(flank.least_gap(position)) < 2e-6  # conjugate: no unloaded transmission error
    lines = flank.lines(0.0)
    expected = forecast(lines, -3, 22000.0, 113700.0)
    length = {j: np.linalg.norm(np.gradient(line.position, axis=0), axis=1) for j, line in expected.lines.items()}
    total = sum(float(load @ length[j]) for j, load in expected.line_load.items())
    assert total == pytest.approx(22000.0, rel=1e-6)
    assert 0.3 < expected.half_width[0].max() < 0.6
    with pytest.raises(ConvergenceError, match=r"approach of .* mm, and the flank is .* mm high; check torque"):
        forecast(lines, -3, 1e12, 113700.0)


def test_no_contact_possible(shipped: sw.Scene) -> None:
    far = RigidFlank(PairKinematics(shipped, Placement(axial_pinion_mm=200.0)))
    with pytest.raises(SceneError, match="no contact is possible"):
        far.least_gap(0.0)


def test_wear_from_array_and_from_flank_group(shipped: sw.Scene, pair: PairKinematics) -> None:
    face = face_stations(pair)
    profile = flank_profile(pair, face)
    depth = 20.0 + profile + 0.05 * (face - 520.0)
    given = wear_depth_of(depth, pair)
    assert isinstance(given, FlankWear)
    places = np.array([490.3, 520.0, 551.1]), np.array([-1.3, 0.4, 1.7])
    expected = 1e-3 * (20.0 + places[1] + 0.05 * (places[0] - 520.0))
    assert given.depth(*places) == pytest.approx(expected, abs=1e-6)

    height = pair.gear.height(np.broadcast_to(face, profile.shape), profile)
    both = {name: (("body", "profile", "face"), np.stack([v, v])) for name, v in (("flank_height", height),)}
    both["flank_radius"] = (("body", "profile", "face"), np.stack([np.broadcast_to(face, profile.shape)] * 2))
    both["wear_depth"] = (
        ("wear_step", "body", "profile", "face"),
        np.stack([[0 * depth, 0 * depth], [0 * depth, depth]]),
    )
    group = xr.Dataset(both, {"body": ["pinion", "gear"]})
    assert wear_depth_of(group, pair).depth(*places) == pytest.approx(expected, abs=1e-6)
    assert isinstance(wear_depth_of(None, pair), NoWear)


def test_labelled_wear_is_taken_by_its_labels(pair: PairKinematics) -> None:
    face = face_stations(pair)
    depth = np.arange(flank_profile(pair, face).size, dtype=float).reshape(-1, len(face))
    both = xr.DataArray(
        np.stack([0.0 * depth, depth]), dims=("body", "profile", "face"), coords={"body": ["pinion", "gear"]}
    )
    steps = xr.concat([0.0 * both, both], "wear_step")
    for given in (
        both, both.transpose("face", "body", "profile"), both.isel(body=[1, 0]), both.sel(body="gear"),
        both.sel(body=["gear"]), both.sel(body="gear").T, steps, steps.transpose(..., "wear_step"),
    ):  # fmt: skip
        found = wear_depth_of(given, pair)
        assert isinstance(found, FlankWear)
        np.testing.assert_array_equal(found.values, 1e-3 * depth)
    worn_pinion = both.assign_coords(body=["gear", "pinion"]).sel(body="pinion")
    with pytest.raises(SceneError, match="a worn pinion"):
        wear_depth_of(worn_pinion, pair)


def test_bad_wear_is_refused(pair: PairKinematics) -> None:
    shape = flank_profile(pair, face_stations(pair)).shape
    for wrong in (np.full(shape, np.nan), np.full(shape, -1.0), np.zeros((3, 4)), np.ones((2, *shape))):
        with pytest.raises(SceneError, match="wear_depth"):
            wear_depth_of(wrong, pair)


def test_half_width_of_a_ridge() -> None:
    """Hertz's half-width over a parabola; on a worn ridge as wide as the ridge is at that height."""
    across = np.broadcast_to(np.linspace(-2.0, 2.0, 161), (2, 161))
    parabola = 0.5 * 0.03 * across[0] ** 2
    ridge = parabola + np.minimum(np.abs(across[0]), 0.3) * 0.05
    zero = np.zeros(2)
    line = RigidLine(
        roll=0.0,
        face=np.array([500.0, 502.0]),
        profile=zero,
        gap=zero,
        position=np.array([[0.0, 0.0, 500.0], [0.0, 0.0, 502.0]]),
        pinion_profile=zero,
        pinion_face=zero,
        spacing=zero + 1.0,
        across=across,
        gap_across=np.stack([parabola, ridge]),
    )
    modulus, load = 115385.0, np.array([600.0, 600.0])
    rise = 2.0 * load / (np.pi * modulus)
    hertz = np.sqrt(4.0 * load[0] / (np.pi * modulus * 0.03))
    found = line.half_width(rise)
    assert found[0] == pytest.approx(hertz, rel=0.01)
    # 0.015 x^2 + 0.05 x = rise
    assert found[1] == pytest.approx((np.sqrt(0.05**2 + 0.06 * rise[1]) - 0.05) / 0.03, rel=0.02)
    assert line.arc == pytest.approx([0.0, 2.0])
