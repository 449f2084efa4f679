"""Roughness that runs in: its law, and what follows for the film, wear and micropitting."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import semiwear as sw
from semiwear.contact.running_in import RunningIn
from semiwear.effect_clock import EffectClock
from semiwear.meshing.flank_grid import at_places
from semiwear.plan import plan
from semiwear.plan.effects import speeds_of
from semiwear.wear.contact_factor import ContactFactor
from tests.strategies.effect_scenes import PLAIN
from tests.strategies.oil_and_case import MICROPITTING

SMALL = PLAIN.replace(
    {
        "numerics.face_slices": 9,
        "numerics.roll_positions": 8,
        "numerics.tooth_compliance": "rigid",
        "operation.pinion_speed_rpm": 3000.0,
        "effects.lubrication": {},
        "effects.wear_law.lubrication": {},
        "effects.flash_temperature": {},
        "effects.micropitting": MICROPITTING,
    }
)
SHARES = st.floats(0.0, 0.95)
DEPTHS = st.floats(1e-5, 1e-1)


@given(SHARES, DEPTHS, st.lists(st.floats(0.0, 0.1), min_size=2, max_size=5))
def test_roughness_falls_from_new_to_run_in(share, depth, worn):
    """Between both, never rising, and steepest at first."""
    law = RunningIn(share, depth)
    found = law.remaining(np.sort(worn))
    assert law.remaining(0.0) == 1.0
    assert law.remaining(60.0 * depth) == pytest.approx(1.0 - share, abs=1e-12)
    assert (np.diff(found) <= 0.0).all() and (found >= 1.0 - share - 1e-12).all()
    assert 1.0 - law.remaining(depth) == pytest.approx(share * (1.0 - np.exp(-1.0)))


@given(SHARES, DEPTHS, st.floats(0.0, 0.1), st.floats(0.0, 0.1))
def test_running_in_forgets_how_it_came_there(share, depth, first, second):
    """What is left to go after two depths is that after one, times that after the other."""
    law = RunningIn(share, depth)
    left = [law.remaining(h) - (1.0 - share) for h in (first, second, first + second)]
    assert left[2] * share == pytest.approx(left[0] * left[1], abs=1e-12)


def rated(changes):
    tree = sw.simulate(SMALL.replace(changes))
    safety = tree["ratings"].safety.sel(mode="micropitting")
    return tree["flank"].wear_depth.sel(body="gear").values, safety.values


@pytest.fixture(scope="module")
def as_made():
    return rated({})


def test_no_share_is_no_running_in(as_made):
    wear, safety = rated({"effects.running_in": {"strength": 0.0, "acts_on": "both"}})
    np.testing.assert_array_equal(wear, as_made[0])
    np.testing.assert_array_equal(safety, as_made[1])


def test_each_place_where_it_acts(as_made):
    """Smoother flanks wear less by their film; the safety against micropitting rises up to 1/(1 - strength)."""
    table = {"strength": 0.5, "depth_um": 0.05}
    wear, safety = rated({"effects.running_in": table | {"acts_on": "micropitting"}})
    np.testing.assert_array_equal(wear, as_made[0])
    np.testing.assert_array_equal(safety[0], as_made[1][0])
    gain = safety[-1] / as_made[1][-1]
    assert (gain > 1.2).all() and (gain < 2.0).all()
    wear, _ = rated({"effects.running_in": table})
    np.testing.assert_array_equal(wear[1], as_made[0][1])  # a step wears with the roughness of its beginning
    added, before = (float((depth[-1] - depth[1]).max()) for depth in (wear, as_made[0]))
    assert 0.5 * before < added < 0.95 * before


class _AsRough:
    """A law of the wear coefficient that tells the roughness itself."""

    def factor(self, conditions):
        return np.broadcast_to(conditions.roughness_ratio, conditions.line_load.shape)


@pytest.mark.parametrize("worn", [("pinion", "gear"), ("gear",)])
def test_roughness_is_that_of_the_points_that_touch(worn):
    """Worn flanks touch off the fresh line: roughness that differs along both is read where the motions say."""
    scene = sw.load_scene("spur_fzg_c").replace(
        {"numerics.face_slices": 9, "numerics.tooth_compliance": "rigid", "wear.worn_bodies": worn}
    )
    physics, law = plan(scene), RunningIn(0.9, 1e-2)
    teeth = physics.loaded_teeth()
    lines, nodes = teeth.lines, np.stack([teeth.driving_profile, teeth.grid.profile])
    # deepest in the middle of the dedendum, so that contact moves away; and steep along both flanks
    height = (nodes - nodes[..., :1]) / np.ptp(nodes, axis=2, keepdims=True)
    wear = 0.02 * np.exp(-(((height - 0.35) / 0.12) ** 2))
    driving = wear[0] if "pinion" in worn else None
    state = teeth.load(wear[1], None, driving)
    factor = ContactFactor({"roughness": _AsRough()}, speeds_of(scene, teeth.pair, lines), EffectClock(), law)
    found, loaded = factor(teeth, state.loads, state), state.loads.half_width > 0.0
    assert np.abs(state.coarse.profile - lines.profile)[loaded].max() > 0.05

    met = teeth.pair.meeting(lines.face[None, :], state.coarse.profile, lines.roll[:, None]).driving_profile
    own = law.remaining(at_places(nodes[1], wear[1], state.coarse.profile))
    theirs = np.ones(met.shape) if driving is None else law.remaining(at_places(nodes[0], driving, met))
    np.testing.assert_allclose(found[loaded], 0.5 * (own + theirs)[loaded], rtol=2e-3)
