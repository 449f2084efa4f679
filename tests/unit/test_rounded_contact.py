"""Points that come to bear by and by: slopes of their forces do not jump, and less rounding comes to the corner."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from semiwear.contact.active_set import ActiveSetStatus, active_set_work, solve_active_set
from semiwear.contact.rounded_contact import solve_rounded

YIELDS = 1e-5  # mm/N
MATRIX = YIELDS * (np.eye(4) + 0.3 * np.exp(-np.abs(np.subtract.outer(np.arange(4), np.arange(4)))))
GAP = np.array([0.0, 1e-3, 2.5e-3, 9e-3])
LEVER = np.array([1.0, 1.1, 0.9, 1.0])


def sharp(load: float) -> tuple[NDArray[np.float64], float]:
    force, slack, active = np.zeros(4), np.zeros(4), np.zeros(4, dtype=bool)
    status, approach, _ = solve_active_set(MATRIX, GAP, LEVER, load, 0.0, True, active, force, slack, 50)
    assert status == ActiveSetStatus.CONVERGED
    return force, approach


def rounded(load: float, depth: float) -> tuple[NDArray[np.float64], float]:
    force, approach = sharp(load)
    slack, full = np.zeros(4), np.full(4, depth / YIELDS)
    status, approach = solve_rounded(
        active_set_work(4), False, MATRIX, GAP, LEVER, full, depth, load, 1e-13, approach, force, slack
    )
    assert status == ActiveSetStatus.CONVERGED
    return force, approach


@pytest.mark.parametrize("depth", [1e-5, 3e-4, 5e-3])
@pytest.mark.parametrize("load", [10.0, 120.0, 400.0, 1500.0])
def test_points_lie_on_the_curve_and_bear_the_load(load: float, depth: float) -> None:
    force, approach = rounded(load, depth)
    apart = (GAP + MATRIX @ force - LEVER * approach) / depth
    share = force / (depth / YIELDS)
    on = force > 0.0
    assert float(LEVER @ force) == pytest.approx(load, rel=1e-12)
    curve = np.where(share < 1.0, (1.0 - np.sqrt(np.minimum(share, 1.0))) ** 2, 0.0)
    np.testing.assert_allclose(apart[on], curve[on], atol=1e-13 * approach / depth + 1e-12)
    assert (apart[~on] >= 1.0).all()


def test_less_rounding_comes_to_the_corner() -> None:
    # the second point is just about to bear
    touches = brentq(lambda load: sharp(load)[1] * LEVER[1] - GAP[1] - MATRIX[1] @ sharp(load)[0], 20.0, 90.0)
    force = sharp(touches)[0]
    apart = [np.abs(rounded(touches, depth)[0] - force).max() for depth in (1e-4, 1e-5, 1e-6)]
    np.testing.assert_allclose(np.array(apart[:2]) / apart[1:], 10.0, rtol=1e-3)
    assert apart[2] < 1e-3 * force.max()


def test_points_that_bear_wholly_know_nothing_of_the_rounding() -> None:
    np.testing.assert_allclose(rounded(300.0, 1e-4)[0], sharp(300.0)[0], rtol=1e-12)


def test_slopes_do_not_jump_where_a_point_comes_to_bear() -> None:
    loads = np.arange(60.0, 260.0, 0.25)  # in which the second and the third begin to
    for depth, jump in ((0.0, 0.3), (4e-4, 0.03)):
        first = np.array([(rounded(load, depth) if depth else sharp(load))[0][0] for load in loads])
        slopes = np.diff(first) / 0.25
        found = np.abs(np.diff(slopes)).max() / np.abs(slopes).max()
        assert found > jump if depth == 0.0 else found < jump


def test_a_factor_of_a_contact_like_it_serves_it() -> None:
    work, slack, full = active_set_work(4), np.zeros(4), np.full(4, 3e-4 / YIELDS)
    force, approach = sharp(200.0)
    what = (LEVER, full, 3e-4, 200.0, 1e-13)
    _, approach = solve_rounded(work, False, MATRIX, GAP, *what, approach, force, slack)
    softer = 1.01 * MATRIX
    afresh, again = force.copy(), force.copy()
    _, by_its_own = solve_rounded(active_set_work(4), False, softer, GAP, *what, approach, afresh, slack)
    _, by_the_old = solve_rounded(work, True, softer, GAP, *what, approach, again, slack)
    np.testing.assert_allclose(again, afresh, rtol=1e-11)
    assert by_the_old == pytest.approx(by_its_own, rel=1e-12)


def test_what_is_not_positive_definite_is_told() -> None:
    force, full = np.full(4, 50.0), np.full(4, 1.0)
    status, _ = solve_rounded(
        active_set_work(4), False, -MATRIX, GAP, LEVER, full, 1e-5, 200.0, 1e-13, 1e-3, force, np.zeros(4)
    )
    assert status == ActiveSetStatus.NOT_POSITIVE_DEFINITE
