"""Public functions on plain arrays take lists and scalars, as their users write them, and refuse what no body has."""

import numpy as np
import pytest

from semiwear.contact import effective_modulus, line_contact_half_width, line_contact_pressure
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
        ((300.0, [0.1, -0.2], 113e3), "relative curvature .* not -0.2"),
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
    found = function([300.0, np.nan, 0.0], [0.1, 0.1, np.nan], 113e3)
    assert np.array_equal(np.isnan(found), [False, True, True])
