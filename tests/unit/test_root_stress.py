"""Root stress counts the forces where they act: at places across a contact line, on a worn flank beside it."""

import numpy as np
import pytest

import semiwear as sw
from semiwear.compliance.beyond_prism import BeyondOnLines
from semiwear.compliance.influence import InfluenceData, InfluenceOnLines
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


def groove(teeth) -> np.ndarray:
    """Wear that leaves the lower and the upper end of the flank standing [mm]."""
    profile = teeth.grid.profile
    share = (profile - profile[:, :1]) / np.ptp(profile, axis=1)[:, None]
    return 0.06 * np.clip(8.0 * np.minimum(share - 0.2, 0.8 - share), 0.0, 1.0)


@pytest.mark.parametrize("fidelity", ["line", "patch"])
def test_worn_teeth_are_stressed_where_they_bear(small, fidelity):
    teeth = plan(small.replace({"numerics.fidelity": fidelity})).loaded_teeth()
    state = teeth.load(groove(teeth))
    lines, per_cycle = teeth.lines, teeth.rolls.phase.size
    if fidelity == "line":
        force, moved = state.loads.force, state.coarse.profile - lines.profile
    else:
        # the line is where the middle two of the columns meet
        columns, width = state.loads.cells.shape[-1], teeth.problem.cells.width
        distance = width * (np.arange(columns) - 0.5 * (columns - 1))
        force, moved = state.loads.cells, distance / lines.spacing[..., None]
    assert np.abs(moved[force > 0.0]).max() > 0.5  # the groove has driven the load away from the line
    found = teeth.root_stress(state)
    for body, stress in zip(teeth.problem.bodies, found.T, strict=True):
        np.testing.assert_allclose(stress, body.root_stress(force, per_cycle, moved), rtol=1e-9)
        on_line = body.root_stress(state.loads.force, per_cycle)
        assert not np.allclose(stress, on_line, rtol=1e-3)  # the line's places would not have done


def test_a_result_tells_the_stress_of_the_worn_places(small):
    teeth = plan(small).loaded_teeth()
    wear = groove(teeth)
    told = sw.loaded_contact(small, wear_depth=1e3 * wear.T)["engagement"].root_stress.values[0]
    np.testing.assert_allclose(told, teeth.root_stress(teeth.load(wear)), rtol=1e-9)


def test_influence_data_take_moved_forces_as_forces_on_other_lines():
    random = np.random.default_rng(7)
    heights, stations, fillet, rolls, faces, places = 5, 6, 3, 6, 4, 3
    body = InfluenceData(
        np.linspace(0.0, 1.0, heights) ** 1.5, np.linspace(0.0, 8.0, stations), np.ones((heights, stations)),
        np.zeros((3, heights, stations, heights, stations)),
        random.standard_normal((3, fillet, stations, heights, stations)), 1, 2e5, 0.3,
    )  # fmt: skip
    lines = LinePlaces(
        random.uniform(0.0, 3.0, (rolls, faces)),
        random.uniform(-1.0, 1.0, (rolls, faces)),
        random.uniform(0.0, 8.0, (rolls, faces)),
    )

    def prepared(at: LinePlaces) -> InfluenceOnLines:
        shape = at.profile.shape
        return InfluenceOnLines.of(body, at, np.zeros(shape), np.full(shape, 3.0))

    force, moved = random.uniform(0.0, 1.0, (rolls, faces, places)), random.uniform(-2.0, 2.0, (rolls, faces, places))
    profile = lines.profile[..., None] + lines.slope[..., None] * moved
    face = np.broadcast_to(lines.face[..., None], moved.shape)
    others = LinePlaces(*(x.reshape(rolls, -1) for x in (profile, np.ones_like(profile), face)))
    found = prepared(lines).root_stress(force, 2, moved)
    np.testing.assert_allclose(found, prepared(others).root_stress(force.reshape(rolls, -1), 2), rtol=1e-9)
    assert found.max() > 0.0
