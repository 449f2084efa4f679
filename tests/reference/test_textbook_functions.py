"""Textbook physics on plain arrays, without a scene, against figures and formulas of others."""

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


def test_wear_of_a_pass():
    """Andersson and Eriksson 1990: a pressure of any shape, carried over a point, leaves k q s."""
    k, load, sliding, speed = 1e-9, 250.0, 0.12, 3.0
    time = np.linspace(-2.0, 2.0, 20001)
    half = 0.4
    pressure = 2.0 * load / (pi * half) * np.sqrt(np.maximum(1.0 - (speed * time / half) ** 2, 0.0))
    passed = np.sum(pressure * sliding * speed) * (time[1] - time[0])
    assert wear.wear_depth(k, passed) == pytest.approx(wear.wear_per_mesh(load, sliding, k), rel=1e-4)


@pytest.mark.parametrize("drawer", [contact, geometry, wear])
def test_every_public_name_is_there(drawer):
    """Also those that are loaded when they are asked for."""
    assert set(drawer.__all__) <= set(dir(drawer))
    assert all(callable(getattr(drawer, name)) for name in drawer.__all__)
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        _ = drawer.nothing
