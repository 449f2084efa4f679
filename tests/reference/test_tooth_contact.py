"""Unloaded tooth contact against the figures of the design, and against independent computations."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import semiwear as sw
from semiwear.meshing.tooth_contact import contact_points, unloaded_contact
from semiwear.plan import plan

PRESSURE_ANGLE = np.radians(25.0)
PINION_TEETH, SHAPER_TEETH, GEAR_TEETH, MODULE = 25, 28, 160, 6.35
SHAPER_PITCH_RADIUS = 0.5 * MODULE * SHAPER_TEETH
PINION_PITCH_RADIUS = 0.5 * MODULE * PINION_TEETH
GEAR_PITCH_RADIUS = 0.5 * MODULE * GEAR_TEETH
AXIS_OFFSET = SHAPER_PITCH_RADIUS - PINION_PITCH_RADIUS
BASE_PITCH = np.pi * MODULE * np.cos(PRESSURE_ANGLE)

MISALIGNED = (
    (sw.Placement(offset_mm=0.1), 510.6),
    (sw.Placement(offset_mm=-0.1), 505.6),
    (sw.Placement(axial_gear_mm=0.1), 502.7),
    (sw.Placement(axial_gear_mm=-0.1), 513.35),
    (sw.Placement(shaft_angle_error_mrad=1.0), 515.3),
    (sw.Placement(shaft_angle_error_mrad=-1.0), 503.1),
    (sw.Placement(pinion_slope_mrad=1.0), 497.0),
    (sw.Placement(pinion_slope_mrad=-1.0), 522.5),
    (sw.Placement(axial_pinion_mm=0.1), 508.0),
    (sw.Placement(axial_pinion_mm=-0.1), 508.0),
)


@pytest.fixture(scope="module")
def analysis(shipped):
    return sw.tooth_contact_analysis(shipped)


def test_limits_of_the_gear(analysis):
    assert float(analysis.undercut_radius) == pytest.approx(465.17, abs=0.05)
    assert float(analysis.pointing_radius) == pytest.approx(569.33, abs=0.05)


def test_contact_ratio(analysis):
    assert float(analysis.contact_ratio) == pytest.approx(1.554, abs=0.005)
    # from the gear's tip at 13.07 mm before... to the pinion's tip: the path's length over the base pitch
    assert float(analysis.roll_position[0]) * BASE_PITCH == pytest.approx(-15.03, abs=0.02)
    assert float(analysis.roll_position[-1]) * BASE_PITCH == pytest.approx(13.07, abs=0.02)


def test_no_transmission_error(analysis):
    assert float(np.abs(analysis.transmission_error).max()) < 0.01


def test_path_of_contact_is_the_straight_line(analysis):
    travel = -BASE_PITCH * analysis.roll_position.values
    line = np.column_stack(
        [
            travel * np.cos(PRESSURE_ANGLE),
            -SHAPER_PITCH_RADIUS + travel * np.sin(PRESSURE_ANGLE),
            np.full(travel.size, GEAR_PITCH_RADIUS),
        ]
    )
    np.testing.assert_allclose(analysis.path_of_contact.values, line, atol=0.005)


def test_curvatures_and_ellipse_at_the_pitch_point(shipped):
    points = contact_points(plan(shipped).flank_pair(), np.zeros(1))
    np.testing.assert_allclose(points.curvature[0], [7.032e-5, 3.041e-2], rtol=0.005)
    angle = np.degrees(np.arccos(abs(points.along[0, 2])))
    assert angle == pytest.approx(8.08, abs=0.02)


def test_curvatures_in_the_dataset_pass_through_those_at_the_pitch_point(analysis):
    roll = analysis.roll_position.values
    along, across = analysis.principal_relative_curvature.values.T
    assert np.interp(0.0, roll, along) == pytest.approx(7.032e-5, rel=0.005)
    assert np.interp(0.0, roll, across) == pytest.approx(3.041e-2, rel=0.005)
    assert np.interp(0.0, roll, analysis.contact_ellipse_angle.values) == pytest.approx(8.08, abs=0.02)


@pytest.mark.parametrize(("placement", "radius"), MISALIGNED, ids=lambda value: str(value))
def test_misalignment_moves_the_contact(shipped, placement, radius):
    points = contact_points(plan(shipped).flank_pair(placement), np.zeros(1))
    assert points.inside[0]
    assert np.hypot(points.position[0, 0], points.position[0, 2]) == pytest.approx(radius, abs=0.3)


@pytest.mark.parametrize(
    "placement",
    # the quick tests take every other one: each displacement in one direction
    [pytest.param(one, marks=[pytest.mark.slow] * (n % 2), id=str(one)) for n, (one, _) in enumerate(MISALIGNED)],
)
def test_misaligned_pinion_still_transmits_evenly(shipped, placement):
    contact = unloaded_contact(plan(shipped).flank_pair(placement))
    inside = contact.points.inside
    assert inside.sum() > 20
    assert np.ptp(contact.transmission_error[inside]) < 0.01


# ---------------------------------------------------------------- the separation, by brute force


def unwound_flank() -> np.ndarray:
    """Flank of the pinion's tooth that is centred on -y, on its -x side: (n, 2), by unwinding a string.

    Only the definitions go in: a taut string from the base circle, and a tooth as thick as its space on the pitch
    circle.
    """
    base_radius = PINION_PITCH_RADIUS * np.cos(PRESSURE_ANGLE)
    angle = np.linspace(0.0, 0.95, 40001)
    radial = np.column_stack([np.cos(angle), np.sin(angle)])
    tangent = np.column_stack([-np.sin(angle), np.cos(angle)])
    curve = base_radius * (radial - angle[:, None] * tangent)
    radius = np.hypot(*curve.T)
    polar = np.unwrap(np.arctan2(curve[:, 1], curve[:, 0]))
    on_pitch = np.interp(PINION_PITCH_RADIUS, radius, polar)
    # where the pitch circle is crossed: half a tooth before the direction -y
    wanted = -0.5 * np.pi - 0.5 * np.pi / PINION_TEETH
    c, s = np.cos(wanted - on_pitch), np.sin(wanted - on_pitch)
    return curve @ np.array([[c, s], [-s, c]])


def turned(curve: np.ndarray, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return curve @ np.array([[c, s], [-s, c]])


def signed_distance(curve: np.ndarray, point: np.ndarray) -> float:
    """Distance of a point to a polyline, positive on its -x side."""
    start, step = curve[:-1], np.diff(curve, axis=0)
    share = np.clip(np.sum((point - start) * step, axis=1) / np.sum(step**2, axis=1), 0.0, 1.0)
    away = point - (start + share[:, None] * step)
    nearest = int(np.argmin(np.sum(away**2, axis=1)))
    side = step[nearest, 0] * away[nearest, 1] - step[nearest, 1] * away[nearest, 0]
    # the flank runs outward, towards -y: its -x side lies on its right
    return float(-np.sign(side) * np.linalg.norm(away[nearest]))


def generated_point(roll: float, generation: float) -> np.ndarray:
    """Point of the gear flank in the gear's frame, from the design's formulas (section 3)."""
    base_radius = SHAPER_PITCH_RADIUS * np.cos(PRESSURE_ANGLE)
    ratio = SHAPER_TEETH / GEAR_TEETH
    phase = -0.5 * np.pi / SHAPER_TEETH - (np.tan(PRESSURE_ANGLE) - PRESSURE_ANGLE)
    beta = roll + phase + generation
    point = [
        base_radius * (np.sin(beta) - roll * np.cos(beta)),
        -base_radius * (np.cos(beta) + roll * np.sin(beta)),
        base_radius / (ratio * np.cos(beta)),
    ]
    return Rotation.from_rotvec([0.0, -ratio * generation, 0.0]).apply(point)


@pytest.mark.parametrize(
    "placement",
    [
        sw.Placement(),
        sw.Placement(offset_mm=0.2, axial_pinion_mm=-0.1, axial_gear_mm=0.15),
        sw.Placement(offset_mm=-0.1, shaft_angle_error_mrad=2.0, pinion_slope_mrad=-1.5),
    ],
    ids=str,
)
def test_separation_is_how_far_the_pinion_is_from_touching(shipped, placement):
    pair = plan(shipped).flank_pair(placement)
    base_radius = PINION_PITCH_RADIUS * np.cos(PRESSURE_ANGLE)
    flank = unwound_flank()
    pitch_point = np.array([0.0, -SHAPER_PITCH_RADIUS, GEAR_PITCH_RADIUS])
    shift = np.array([placement.offset_mm, placement.axial_gear_mm, placement.axial_pinion_mm])
    turns = Rotation.from_euler("x", 1e-3 * placement.shaft_angle_error_mrad) * Rotation.from_euler(
        "y", 1e-3 * placement.pinion_slope_mrad
    )
    # a flank point is named by its gear radius and by the shaper's arc length from the pitch circle
    shaper_base = SHAPER_PITCH_RADIUS * np.cos(PRESSURE_ANGLE)
    random = np.random.default_rng(4)
    for _ in range(12):
        shaper_roll = random.uniform(0.36, 0.60)
        generation = 0.5 * np.pi / SHAPER_TEETH + random.uniform(-0.1, 0.12)
        at = random.uniform(-0.8, 0.7)
        point = generated_point(shaper_roll, generation)
        face = np.hypot(point[0], point[2])
        profile = 0.5 * shaper_base * (np.tan(PRESSURE_ANGLE) ** 2 - shaper_roll**2)
        met = pair.meeting(np.array(face), np.array(profile), np.array(at))

        pinion_turn = 0.5 * np.pi / PINION_TEETH - 2.0 * np.pi / PINION_TEETH * at
        gear_turn = pinion_turn * PINION_TEETH / GEAR_TEETH
        position = Rotation.from_rotvec([0.0, gear_turn, 0.0]).apply(point)
        np.testing.assert_allclose(met.position, position, atol=1e-9)

        local = turns.inv().apply(position - shift - pitch_point) + pitch_point
        in_plane = np.array([local[0], local[1] + AXIS_OFFSET])
        assert float(met.driving_face) == pytest.approx(local[2], abs=1e-9)
        distance = signed_distance(turned(flank, pinion_turn), in_plane)
        assert float(met.separation) == pytest.approx(distance, abs=1e-6)
        touching = brentq(
            lambda angle, p=in_plane: signed_distance(turned(flank, angle), p),
            pinion_turn - distance / base_radius - 0.02,
            pinion_turn - distance / base_radius + 0.02,
            xtol=1e-12,
        )
        assert float(met.separation) == pytest.approx(base_radius * (pinion_turn - touching), abs=1e-6)
