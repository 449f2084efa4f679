"""Registered deviations do not depend on where the measuring machine has put the tooth."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import semiwear as sw
from semiwear.measured.nearest import feet
from semiwear.measured.nominal import nominal_flank
from semiwear.measured.rigid import DATUM, MOTIONS, Displacement, motions_of
from tests.strategies.measured import displaced, displacements, gentle_deviations, grid_on

FLANKS = tuple((name, body) for name in ("face_gear_25x160", "spur_fzg_c") for body in ("gear", "pinion"))


@pytest.fixture(scope="module")
def flanks():
    scenes = {name: sw.load_scene(name) for name, _ in FLANKS}
    return {(name, body): (scenes[name], nominal_flank(scenes[name], body)) for name, body in FLANKS}


@pytest.mark.slow
@given(st.sampled_from(FLANKS), displacements(), gentle_deviations())
def test_deviations_are_the_same_wherever_the_tooth_stands(flanks, which, displacement, deviation):
    """To a nanometre, where a best fit of all points takes the datum out of both."""
    scene, flank = flanks[which]
    face, profile, p, f = grid_on(flank, 11, 9, 0.12)
    height = deviation(p, f)
    here, there = (
        sw.register(scene, displaced(flank, face, profile, height, motion), which[1], fit="all")
        for motion in (Displacement.none(), displacement)
    )
    assert here["inside"].values.all() and there["inside"].values.all()
    np.testing.assert_allclose(here["deviation"], there["deviation"], atol=1e-3)
    # a fit takes rigid motions out, and nothing else
    modes = motions_of(flank, DATUM).modes(*flank.points(face, profile)).reshape(face.size, -1)
    rest = height.ravel() - modes @ np.linalg.lstsq(modes, height.ravel(), rcond=None)[0]
    expected = 1e3 * float(np.sqrt(np.mean(rest**2)))
    assert float(here["residual_rms"]) == pytest.approx(expected, rel=0.01, abs=1e-3)


@given(st.sampled_from(FLANKS), gentle_deviations())
def test_feet_give_back_places_and_deviations(flanks, which, deviation):
    _, flank = flanks[which]
    face, profile, p, f = grid_on(flank, 9, 7)
    height = deviation(p, f)
    found = feet(flank, displaced(flank, face, profile, height, Displacement.none()))
    np.testing.assert_allclose(found.deviation, height, atol=1e-9)
    np.testing.assert_allclose(found.face, face, atol=1e-7)
    np.testing.assert_allclose(found.profile, profile, atol=1e-7)


@given(
    st.lists(st.floats(-1e-3, 1e-3), min_size=6, max_size=6),
    st.lists(st.floats(-1e-3, 1e-3), min_size=6, max_size=6),
)
def test_displacements_compose_and_undo(flanks, first, second):
    _, flank = flanks[FLANKS[0]]
    motions = motions_of(flank, MOTIONS)
    one, two = (motions.displacement(np.array(amounts)) for amounts in (first, second))
    points = flank.points(*grid_on(flank, 3, 3)[:2])[0]
    np.testing.assert_allclose(one.after(two).apply(points), one.apply(two.apply(points)), atol=1e-10)
    np.testing.assert_allclose(one.undo(one.apply(points)), points, atol=1e-10)
    told = motions.amounts(one)
    # a tilt and a rotation in one differ from one after the other by their product
    np.testing.assert_allclose([told[name] for name in MOTIONS], first, atol=2e-6)
