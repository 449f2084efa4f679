"""Root stress of a worn flank: forces count where the flank bears them, whatever the fidelity or the influence."""

from __future__ import annotations

import numpy as np
import pytest

import semiwear as sw
from semiwear.compliance.influence import InfluenceData, InfluenceOnLines
from semiwear.compliance.tooth import LinePlaces
from semiwear.plan import plan


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
