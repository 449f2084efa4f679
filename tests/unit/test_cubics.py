"""Local cubic interpolation: which nodes it takes, and that it is a cubic."""

import numpy as np
import pytest
from scipy.interpolate import lagrange

from semiwear.compliance.cubics import cubic_weights

NODES = np.array([0.0, 0.7, 1.1, 2.0, 3.3, 3.6, 5.0])


@pytest.mark.parametrize(
    ("place", "first"),
    [(-1.0, 0), (0.3, 0), (0.9, 0), (1.1, 1), (1.5, 1), (2.0, 2), (3.4, 3), (4.0, 3), (5.0, 3), (9.0, 3)],
)
def test_a_cubic_runs_through_two_nodes_on_either_side_or_the_last_four(place, first):
    values = np.sin(NODES)
    polynomial = lagrange(NODES[first : first + 4], values[first : first + 4])
    inside = np.clip(place, NODES[0], NODES[-1])
    (weights,), (slopes,) = cubic_weights(np.array([place]), NODES)
    assert not weights[:first].any() and not weights[first + 4 :].any()
    assert weights @ values == pytest.approx(polynomial(inside), abs=1e-12)
    assert slopes @ values == pytest.approx(polynomial.deriv()(inside), abs=1e-11)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_fewer_nodes_make_a_lower_degree(count):
    nodes, places = NODES[:count], np.linspace(0.0, NODES[count - 1], 5)
    weights, slopes = cubic_weights(places, nodes)
    for power in range(count):
        np.testing.assert_allclose(weights @ nodes**power, places**power, atol=1e-12)
        np.testing.assert_allclose(slopes @ nodes**power, power * places ** max(power - 1, 0), atol=1e-12)
