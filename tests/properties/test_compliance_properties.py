"""The compliance that load sharing solves with is positive definite, also where that of the teeth alone is not."""

from math import pi

import numpy as np
import pytest

import semiwear as sw
from semiwear.closed_forms.stripe import stripe_table
from semiwear.contact.stripe import add_pairs, near_stripe
from semiwear.plan import plan
from tests.scenes import SMALL


@pytest.mark.parametrize(
    ("width", "helix_angle", "slices"),
    [
        (14.0, 20.0, 11),
        pytest.param(8.0, 45.0, 41, marks=pytest.mark.slow),
        pytest.param(14.0, 35.0, 41, marks=pytest.mark.slow),
        pytest.param(14.0, 20.0, 81, marks=pytest.mark.slow),
        pytest.param(40.0, 35.0, 41, marks=pytest.mark.slow),
        pytest.param(100.0, 10.0, 11, marks=pytest.mark.slow),
    ],
)
def test_helical_teeth_and_their_contact_yield_to_every_load(width, helix_angle, slices):
    """Any load does work on what yields under it, whatever the pairs, slices and places on the flank.

    The teeth alone do not obey: of 4.5 mm modules and 14 mm width some loads of alternating sign have -1 % of the
    greatest compliance, since the exchange of the virtual gear's ring for the wheel is of few shapes.
    """
    scene = sw.load_scene("spur_fzg_c").replace(
        SMALL
        | {
            "gear_pair.centre_distance_mm": None,
            "gear_pair.helix_angle_deg": helix_angle,
            "gear_pair.pinion_face_width_mm": width,
            "gear_pair.gear_face_width_mm": width,
            "numerics.face_slices": slices,
        }
    )
    problem = plan(scene).loaded_teeth().problem
    for position in range(problem.per_cycle):
        among = problem.candidates(position, 1e3)  # all that lies on the flanks, and far more than can touch
        matrix = among.static.copy()
        half_width = np.full(len(matrix), problem.usual_half_width)
        add_pairs(
            matrix, among.pairs, near_stripe(among.pairs, half_width, 1.0 / (pi * problem.modulus), stripe_table())
        )
        np.testing.assert_allclose(matrix, matrix.T, rtol=0.0, atol=1e-12 * matrix.max())
        assert np.linalg.eigvalsh(matrix)[0] > 0.1 * np.diagonal(matrix).mean()
