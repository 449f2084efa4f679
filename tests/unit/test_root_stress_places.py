"""Root stress counts the forces where they act: at places across a contact line, on a worn flank beside it."""

from __future__ import annotations

import numpy as np
import pytest

from semiwear.compliance.beyond_prism import BeyondOnLines
from semiwear.compliance.tooth import BodyOnLines, LinePlaces
from semiwear.plan import plan

DRIVING, DRIVEN = 0, 1


@pytest.fixture(scope="module")
def unworn(small):
    teeth = plan(small).loaded_teeth()
    return teeth, teeth.load(np.zeros(teeth.grid.profile.shape))


def places_of(teeth, body: int) -> LinePlaces:
    lines = teeth.lines
    if body == DRIVING:
        return LinePlaces(lines.driving_profile, lines.driving_slope, lines.driving_face)
    shape = lines.profile.shape
    return LinePlaces(lines.profile, np.ones(shape), np.broadcast_to(lines.face, shape))


def on_places(teeth, body: int, moved: np.ndarray) -> BodyOnLines:
    """The body prepared anew for places (roll, slices times places) that far from the lines."""
    here = places_of(teeth, body)
    rolls = len(moved)
    profile = (here.profile[..., None] + here.slope[..., None] * moved).reshape(rolls, -1)
    face = np.broadcast_to(here.face[..., None], moved.shape).reshape(rolls, -1)
    whole, places = teeth.problem.bodies[body], LinePlaces(profile, np.ones_like(profile), face)
    teeth_of, beyond = whole.body, None
    if whole.beyond is not None:
        along = face - (teeth_of.start + 0.5 * teeth_of.width)
        beyond = BeyondOnLines.of(whole.beyond.ends, whole.beyond.width, along, teeth_of.heights(places))
    return BodyOnLines.of(teeth_of, places, beyond)


@pytest.mark.parametrize("body", [DRIVING, DRIVEN])
def test_forces_on_the_line_are_forces_that_have_not_moved(unworn, body):
    teeth, state = unworn
    force, per_cycle = state.loads.force, teeth.rolls.phase.size
    one = teeth.problem.bodies[body]
    still = one.root_stress(force, per_cycle, np.zeros_like(force))
    np.testing.assert_allclose(still, one.root_stress(force, per_cycle), rtol=1e-10)


@pytest.mark.parametrize("body", [DRIVING, DRIVEN])
def test_moved_forces_are_forces_on_other_lines(unworn, body):
    """Several places across a slice are as many slices, each on its own place; also beyond the flank's ends."""
    teeth, state = unworn
    random = np.random.default_rng(5)
    force = state.loads.force[..., None] * random.uniform(0.0, 1.0, (*state.loads.force.shape, 3))
    moved = random.uniform(-6.0, 6.0, force.shape)
    per_cycle = teeth.rolls.phase.size
    found = teeth.problem.bodies[body].root_stress(force, per_cycle, moved)
    expected = on_places(teeth, body, moved).root_stress(force.reshape(len(force), -1), per_cycle)
    np.testing.assert_allclose(found, expected, rtol=1e-10)
    assert found.max() > 0.0
