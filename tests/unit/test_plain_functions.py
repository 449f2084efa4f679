"""Public functions on plain arrays take lists and scalars, as their users write them, and refuse what no body has."""

from dataclasses import replace

import numpy as np
import pytest

from semiwear.contact import (
    effective_modulus,
    line_contact_half_width,
    line_contact_pressure,
    love_coefficients,
    rectangle_stress,
)
from semiwear.geometry import FaceGearTooth, InvoluteTooth, face_gear_flank, involute, involute_function
from semiwear.wear import wear_depth, wear_per_mesh

FUNCTIONS = {
    "half-width": lambda load, other: line_contact_half_width(load, other, 113e3),
    "pressure": lambda load, other: line_contact_pressure(load, other, 113e3),
    "depth of a mesh": lambda load, other: wear_per_mesh(load, other, 1e-13),
    "depth": lambda load, other: wear_depth(1e-13, load),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_lists_give_what_arrays_and_scalars_give(name):
    function, loads, others = FUNCTIONS[name], [300, 100.0], [0.1, 0.2]
    found = function(loads, others)
    assert np.array_equal(found, function(np.array(loads), np.array(others)))
    assert np.array_equal(found, [function(load, other) for load, other in zip(loads, others, strict=True)])


@pytest.mark.parametrize(
    ("elastic", "word"),
    [
        ((0.0, 0.3, 206e3, 0.3), "Young"),
        ((206e3, 0.3, -1.0, 0.3), "Young"),
        ((206e3, 0.3, np.nan, 0.3), "Young"),
        ((206e3, 0.6, 206e3, 0.3), "Poisson"),
        ((206e3, 0.3, 206e3, -1.0), "Poisson"),
        ((206e3, 0.3, 206e3, np.nan), "Poisson"),
    ],
)
def test_elastic_constants_that_no_body_has_are_refused(elastic, word):
    with pytest.raises(ValueError, match=word):
        effective_modulus(*elastic)


def test_a_rigid_body_leaves_the_modulus_of_the_other():
    assert effective_modulus(206e3, 0.3, np.inf, 0.3) == pytest.approx(206e3 / 0.91, rel=1e-15)
    assert effective_modulus(1e3, 0.5, 1e3, 0.5) == pytest.approx(1e3 / 1.5, rel=1e-15)


@pytest.mark.parametrize("function", [line_contact_half_width, line_contact_pressure])
@pytest.mark.parametrize(
    ("given", "word"),
    [
        (([300.0, -1.0], 0.1, 113e3), "line load .* not -1"),
        ((300.0, [0.1, -0.2], 113e3), "relative curvature under load .* not -0.2"),
        ((300.0, 0.0, 113e3), "relative curvature .* not 0:"),
        ((300.0, 0.1, 0.0), "modulus .* not 0"),
        ((300.0, 0.1, np.nan), "modulus .* not nan"),
    ],
)
def test_line_contacts_that_cannot_be_are_refused(function, given, word):
    with pytest.raises(ValueError, match=word):
        function(*given)


@pytest.mark.parametrize("function", [line_contact_half_width, line_contact_pressure])
def test_missing_numbers_of_line_contacts_stay_missing(function):
    found = function([300.0, np.nan, 0.0, 0.0], [0.1, 0.1, np.nan, -0.1], 113e3)
    assert np.array_equal(np.isnan(found), [False, True, True, False]) and found[-1] == 0.0


TOOTH = InvoluteTooth(20.0, 4.0, np.radians(20.0), 4.0, 5.0, 1.0, 15.0)
FLANK = {"shaper_teeth": 28, "gear_teeth": 160, "module": 4.0, "pressure_angle": np.radians(25.0)}


@pytest.mark.parametrize(
    ("called", "word"),
    [
        (lambda: wear_depth(-1e-13, 1.0), "wear coefficient must be at least 0 mm.2/N, not -1e-13"),
        (lambda: wear_depth(1e-13, [1.0, -2.0]), "sliding distance .* not -2"),
        (lambda: wear_per_mesh([-1.0], 0.1, 1e-13), "line load .* not -1"),
        (lambda: wear_per_mesh(1.0, -0.1, 1e-13), "specific sliding .* not -0.1"),
        (lambda: love_coefficients((4, 4), (0.0, 1.0)), "sides of a cell must be above 0 mm, not 0"),
        (lambda: love_coefficients((0, 4), (1.0, 1.0)), "number of offsets must be at least 1, not 0"),
        (lambda: rectangle_stress(4, 4, cell=(1.0, 1.0), depth=-1.0, poissons_ratio=0.3), "depth .* not -1"),
        (lambda: rectangle_stress(4, 4, cell=(1.0, np.nan), depth=1.0, poissons_ratio=0.3), "cell .* not nan"),
        (lambda: rectangle_stress(4, 4, cell=(1.0, 1.0), depth=1.0, poissons_ratio=0.6), "above -1 and at most 0.5"),
        (lambda: involute(0.0, np.zeros(1)), "base radius must be above 0 mm, not 0"),
        (lambda: involute_function(20.0), "rad, not 20: numpy.radians"),
        (lambda: face_gear_flank(320.0, 0.0, **FLANK | {"pressure_angle": 25.0}), "rad, not 25: numpy.radians"),
        (lambda: face_gear_flank(320.0, 0.0, **FLANK | {"gear_teeth": 0}), "teeth .* not 0"),
        (lambda: replace(TOOTH, teeth=0.0), "number of teeth must be above 0, not 0"),
        (lambda: replace(TOOTH, pressure_angle=20.0), "pressure angle .* not 20: numpy.radians"),
        (lambda: replace(TOOTH, bore_radius=np.nan), "bore .* not nan"),
        (lambda: replace(TOOTH, rack_tip_radius=-1.0), "tip radius of the rack .* not -1"),
        (lambda: FaceGearTooth(28, 0.5, 4.0, 0.4, 4.0, 5.0, 1.0, 10.0), "shaper and gear must be .* not 0.5"),
        (lambda: face_gear_flank(320.0, 0.0, **FLANK | {"module": -4.0}), "module .* not -4"),
        (lambda: face_gear_flank(320.0, [0.0, 6.0], **FLANK), "profile coordinate must be at most 5.5.* not 6"),
        (lambda: face_gear_flank([320.0, 290.0], 0.0, **FLANK), "no flank at a radius of 290 mm"),
        (lambda: face_gear_flank(100.0, 0.0, **FLANK), "no flank at a radius of 100 mm"),
    ],
)
def test_numbers_out_of_range_are_refused(called, word):
    with pytest.raises(ValueError, match=word):
        called()


def test_points_of_a_face_gears_flank_lie_at_their_radii():
    """Up to 5.518 mm, where the shaper's involute of a base radius of 50.75 mm begins."""
    points, normals = face_gear_flank([300.0, 340.0, 380.0], [[-4.0], [0.0], [5.5179]], **FLANK)
    assert np.hypot(points[..., 0], points[..., 2]) == pytest.approx(
        np.tile([300.0, 340.0, 380.0], (3, 1)), rel=1e-12
    )
    assert np.linalg.norm(normals, axis=-1) == pytest.approx(np.ones((3, 3)), rel=1e-12)
