"""Wear of spur teeth: the pattern of Flodin and Andersson 1997, and closed forms on a straight contact line."""

from math import pi, sin

import numpy as np
import pytest

import semiwear as sw
from semiwear.meshing.cylindrical_pair import CylindricalMesh
from semiwear.plan import plan

COEFFICIENT, MESHES = 1e-13, 1e6  # so few that the wear changes nothing
PINION, GEAR = 0, 1


@pytest.fixture(scope="module")
def scene() -> sw.Scene:
    return sw.load_scene("spur_fzg_c").replace(
        {
            "numerics.face_slices": 15,
            "numerics.harmonics": 9,
            "numerics.wear_steps": 1,
            "wear.coefficient_mm2_per_N": COEFFICIENT,
            "wear.until.meshes": MESHES,
        }
    )


@pytest.fixture(scope="module")
def tree(scene):
    return sw.simulate(scene)


@pytest.fixture(scope="module")
def alone(scene) -> sw.Scene:
    """One pair that carries all the load from half a base pitch before the pitch point to as much behind it.

    A third of the load: the contact (0.2 mm to either side) is narrow against the way on which sliding and speed
    change, and wide against the nodes and roll steps on which it is summed.
    """
    return scene.replace(
        {
            "numerics.tooth_pairs": 1,
            "numerics.roll_positions": 192,
            "numerics.profile_points": 281,
            "operation.pinion_torque_Nm": 100.0,
        }
    )


def over_nodes(values: np.ndarray) -> np.ndarray:
    """Means over five nodes (0.2 mm, a contact's half-width): the sum over roll steps ripples from node to node."""
    return np.convolve(values, np.ones(5) / 5.0, "valid")


@pytest.fixture(scope="module")
def alone_tree(alone):
    return sw.simulate(alone)


class Middle:
    """Wear depth per mesh of the body's own tooth in the middle of the face [mm].

    Against `travel`: the distance l from the pitch point at which a flank point is met, towards entry [mm].
    """

    def __init__(self, scene: sw.Scene, tree, body: int) -> None:
        pair = plan(scene).flank_pair()
        assert isinstance(pair, CylindricalMesh)
        self.pair, flank = pair, tree["flank"]
        middle = flank.wear_depth.shape[-1] // 2
        self.meshes = MESHES * (pair.driving_meshes if body == PINION else 1.0)
        self.depth = 1e-3 * flank.wear_depth.values[-1, body, :, middle] / self.meshes
        self.height = flank.flank_height.values[body, :, middle]
        tooth, working = (pair.pinion, pair.gear)[body], pair.working_radii[body]
        rolled = np.sqrt(flank.flank_radius.values[body, :, middle] ** 2 - tooth.base_radius**2)
        self.rolled = rolled
        sense = 1.0 if body == GEAR else -1.0
        self.travel = sense * (rolled - working * sin(scene.gear_pair.working_pressure_angle))
        first, last = pair.path_limits
        self.met = (self.travel < first - 1.2) & (self.travel > last + 1.2)
        self.single = (self.travel < last + pair.base_pitch - 0.4) & (self.travel > first - pair.base_pitch + 0.4)
        # sliding velocity, and speed of the line over the flank: along the base tangent a body rolls at omega r_b,
        # and its flank's arc grows by rolled/r_b times that
        self.sliding = np.abs(self.travel) * (1.0 + 16 / 24)
        self.speed = pair.pinion.base_radius * rolled / tooth.base_radius


@pytest.mark.parametrize("body", [PINION, GEAR])
def test_closed_form_of_a_constant_line_load(alone, alone_tree, body):
    """k q |v_s|/v_n, with v_s and v_n of ISO 21771 and all the load on one pair."""
    at = Middle(alone, alone_tree, body)
    engagement = alone_tree["engagement"]
    roll, load = engagement.roll_position.values, engagement.line_load.values[0]
    line_load = np.interp(-at.travel / at.pair.base_pitch, roll, load[:, load.shape[1] // 2])
    # farther from the pitch point, and from where the load begins, than the contact is wide: no part of the identity
    there = (np.abs(at.travel) > 1.0) & (np.abs(at.travel) < 0.5 * at.pair.base_pitch - 1.0)
    assert there.sum() > 20
    expected = COEFFICIENT * line_load * at.sliding / at.speed
    for side in (at.travel > 0.0, at.travel < 0.0):
        found, wanted = (over_nodes(values[there & side]) for values in (at.depth, expected))
        np.testing.assert_allclose(found, wanted, rtol=0.01)


@pytest.mark.parametrize("body", [PINION, GEAR])
def test_least_wear_is_at_the_pitch_circle(scene, tree, body):
    """No sliding there; the width of the contact leaves k q (4 b/(3 pi)) |dv_s/ds|/v_n.

    While the contact passes a point at v_n, the point runs r_b1 (1 radian a unit of time) along the line of action.
    """
    at = Middle(scene, tree, body)
    depth = np.where(at.met, at.depth, np.inf)
    least = int(np.argmin(depth))
    assert abs(at.height[least]) < 0.1
    engagement = tree["engagement"]
    roll, load = engagement.roll_position.values, engagement.line_load.values[0]
    line_load = float(np.interp(0.0, roll, load[:, load.shape[1] // 2]))
    modulus = plan(scene).modulus
    working = scene.gear_pair.working_pressure_angle
    curvature = sum(1.0 / (radius * sin(working)) for radius in at.pair.working_radii)
    half_width = np.sqrt(4.0 * line_load / (pi * modulus * curvature))
    slope = (1.0 + 16 / 24) * at.pair.pinion.base_radius / at.speed[least]
    expected = COEFFICIENT * line_load * 4.0 * half_width / (3.0 * pi) * slope / at.speed[least]
    assert depth[least] == pytest.approx(float(expected), rel=0.05, abs=0.0)
    assert depth[least] < 0.1 * at.depth[at.met].max()


def test_the_pinion_root_wears_most(scene, tree):
    """Flodin and Andersson 1997, fig. 8: deepest at the pinion's root, then the gear's root; tips wear less."""
    pinion, gear = Middle(scene, tree, PINION), Middle(scene, tree, GEAR)
    depth = {
        name: float((at.depth * at.meshes)[at.met & side(at.height)].max())
        for name, at, side in (
            ("pinion root", pinion, lambda height: height < -0.2),
            ("pinion tip", pinion, lambda height: height > 0.2),
            ("gear root", gear, lambda height: height < -0.2),
            ("gear tip", gear, lambda height: height > 0.2),
        )
    }
    assert depth["pinion root"] > depth["gear root"] > depth["pinion tip"] > depth["gear tip"]
    # monotonic from the pitch circle down to the root of the pinion where one pair carries all
    below = pinion.single & (pinion.height < -0.2)
    assert np.all(np.diff(pinion.depth[below]) < 0.0)


def test_both_bodies_wear_in_the_ratio_of_tooth_numbers_and_specific_sliding(alone, alone_tree):
    """Points that meet carry one load: their depths differ by z_2/z_1 meshes and by their speeds over the flanks."""
    pinion, gear = Middle(alone, alone_tree, PINION), Middle(alone, alone_tree, GEAR)
    travel = np.concatenate([np.linspace(-4.5, -1.0, 9), np.linspace(1.0, 4.5, 9)])
    depths, speeds = [], []
    for at in (pinion, gear):
        order = np.argsort(at.travel)
        smooth = over_nodes((at.depth * at.meshes)[order])
        depths.append(np.interp(travel, at.travel[order][2:-2], smooth))
        speeds.append(np.interp(travel, at.travel[order], at.speed[order]))
    np.testing.assert_allclose(depths[0] / depths[1], 24 / 16 * speeds[1] / speeds[0], rtol=0.01)


def test_specific_sliding(scene, tree):
    """1 - v_other/v_own of the surfaces, positive on the addendum (ISO 21771, 5.6)."""
    for body in (PINION, GEAR):
        at = Middle(scene, tree, body)
        sense = 1.0 if body == GEAR else -1.0
        expected = sense * at.travel * (1.0 + 16 / 24) / at.speed
        found = tree["flank"].specific_sliding.values[body, :, tree["flank"].face.size // 2]
        np.testing.assert_allclose(found[at.met], expected[at.met], atol=0.01 * np.abs(expected[at.met]).max())


def test_wear_is_even_along_the_face_of_a_spur_tooth(scene, tree):
    """But for the ends, where the load falls off over the rounded edges."""
    wear = tree["flank"].wear_depth.values[-1]
    at = Middle(scene, tree, PINION)
    inner = wear[PINION][at.single][:, 3:-3]
    assert np.ptp(inner, axis=1).max() < 0.1 * inner.max()
    np.testing.assert_allclose(wear, wear[..., ::-1], rtol=1e-6, atol=1e-9)
