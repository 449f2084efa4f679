"""Textbook physics on plain arrays, without a scene, against figures and formulas of others."""

from __future__ import annotations

from math import pi, radians

import numpy as np
import pytest

from semiwear import contact, geometry, wear


def test_involute_function_of_the_tables():
    """ISO 21771 and any table of involutes: inv 20 deg = 0.014904, inv 25 deg = 0.029975."""
    assert geometry.involute_function(radians(20.0)) == pytest.approx(0.0149044, abs=5e-8)
    assert geometry.involute_function(radians(25.0)) == pytest.approx(0.0299753, abs=5e-8)
    alpha = np.radians([5.0, 20.0, 40.0])
    radius, polar = geometry.involute(46.0, np.tan(alpha))
    assert radius == pytest.approx(46.0 / np.cos(alpha), rel=1e-14)
    assert polar == pytest.approx(np.tan(alpha) - alpha, rel=1e-13)


def test_arc_and_string_of_an_involute():
    """The string that unwinds is tangent to the base circle, and as long as what it unwound."""
    base, roll = 46.0, np.linspace(0.01, 0.9, 400)
    radius, polar = geometry.involute(base, roll)
    assert np.sqrt(radius**2 - base**2) == pytest.approx(base * roll, rel=1e-12)
    x, y = radius * np.cos(polar), radius * np.sin(polar)
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    assert arc == pytest.approx(0.5 * base * (roll**2 - roll[0] ** 2), rel=1e-5, abs=1e-6)


FACE_GEAR = {"shaper_teeth": 28, "gear_teeth": 160, "module": 6.35, "pressure_angle": radians(25.0)}


def test_face_gear_flank_obeys_the_equation_of_meshing():
    """Its normal at the line of contact with the shaper is square to their relative velocity, wherever that is."""
    radius, profile = np.meshgrid(np.linspace(485.0, 555.0, 9), np.linspace(-3.0, 4.0, 7), indexing="ij")
    points, normals = geometry.face_gear_flank(radius, profile, **FACE_GEAR)
    assert np.hypot(points[..., 0], points[..., 2]) == pytest.approx(radius, rel=1e-12)
    assert np.linalg.norm(normals, axis=-1) == pytest.approx(1.0, rel=1e-12)
    # normal to the surface itself, by differences
    step = 1e-4
    along = geometry.face_gear_flank(radius + step, profile, **FACE_GEAR)[0] - points
    across = geometry.face_gear_flank(radius, profile + step, **FACE_GEAR)[0] - points
    square = np.cross(along, across)
    square /= np.linalg.norm(square, axis=-1, keepdims=True)
    assert np.abs(np.sum(square * normals, axis=-1)) == pytest.approx(1.0, abs=1e-8)
    # some turn of the gear brings the point's normal to meet shaper and gear axes with moments in the ratio of teeth
    ratio = FACE_GEAR["shaper_teeth"] / FACE_GEAR["gear_teeth"]
    base = 0.5 * 28 * 6.35 * np.cos(radians(25.0))
    moment = points[..., 2] * normals[..., 0] - points[..., 0] * normals[..., 2]  # about the gear's axis
    assert np.abs(moment) * ratio == pytest.approx(base, rel=1e-9)  # the shaper's normals touch its base circle


def test_hertz_line_and_point():
    """Johnson 1985, ch. 4: a steel roller of 10 mm on a flat under 100 N/mm, a steel ball of 10 mm under 100 N."""
    modulus = contact.effective_modulus(206e3, 0.3, 206e3, 0.3)
    assert modulus == pytest.approx(113187.0, rel=1e-5)
    half_width = contact.line_contact_half_width(100.0, 0.1, modulus)
    assert half_width == pytest.approx(0.10606, rel=1e-4)
    pressure = contact.line_contact_pressure(100.0, 0.1, modulus)
    assert 0.5 * pi * half_width * pressure == pytest.approx(100.0, rel=1e-12)
    ball = contact.elliptic_contact(100.0, 0.1, 0.1, modulus)
    assert ball.major_half_axis == pytest.approx((0.75 * 100.0 * 10.0 / modulus) ** (1 / 3), rel=1e-12)
    assert ball.approach == pytest.approx(ball.major_half_axis**2 / 10.0, rel=1e-12)


def test_stripe_kernel_far_away_is_that_of_a_point():
    far = np.array([50.0, 500.0])
    assert contact.stripe_kernel(far) == pytest.approx(1.0 / far, rel=1e-4)


def test_half_space_contact_of_a_ball():
    """Hertz again, by the solver for any gap (Johnson 1985, eqs. 4.22 to 4.24)."""
    modulus, radius, load = 113187.0, 10.0, 100.0
    x = (np.arange(64) - 31.5) * 0.012
    gap = (x[:, None] ** 2 + x**2) / (2.0 * radius)
    found = contact.solve_half_space(gap, cell=(0.012, 0.012), effective_modulus=modulus, load=load)
    exact = contact.elliptic_contact(load, 1.0 / radius, 1.0 / radius, modulus)
    assert found.pressure.max() == pytest.approx(exact.peak_pressure, rel=0.01)
    assert found.approach == pytest.approx(exact.approach, rel=0.005)


def test_wear_of_a_pass():
    """Andersson and Eriksson 1990: a pressure of any shape, carried over a point, leaves k q s."""
    k, load, sliding, speed = 1e-9, 250.0, 0.12, 3.0
    time = np.linspace(-2.0, 2.0, 20001)
    half = 0.4
    pressure = 2.0 * load / (pi * half) * np.sqrt(np.maximum(1.0 - (speed * time / half) ** 2, 0.0))
    passed = np.sum(pressure * sliding * speed) * (time[1] - time[0])
    assert wear.wear_depth(k, passed) == pytest.approx(wear.wear_per_mesh(load, sliding, k), rel=1e-4)
