"""Public functions on plain arrays take lists and scalars, as their users write them."""

import numpy as np
import pytest

from semiwear.contact import line_contact_half_width, line_contact_pressure
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
