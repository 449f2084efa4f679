"""Loaded teeth that rub: balance of moments, power, and what friction does where sliding vanishes."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import semiwear as sw
from semiwear.contact.frictional_contact import FrictionalContact
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.traction import share_of_full_friction, share_per_speed
from semiwear.meshing.contact_lines import change_along_line
from semiwear.meshing.flank_pair import DRIVEN, DRIVING
from semiwear.meshing.own_flanks import axis_of
from semiwear.plan import plan

SMALL = {"numerics.face_slices": 9, "numerics.harmonics": 5, "gear_pair.centre_distance_mm": None, "wear": None}
NARROW = {"gear_pair.pinion_face_width_mm": 20.0}


def external(z1: int, z2: int, helix: float = 0.0, shift: float = 0.0) -> dict[str, object]:
    """Changes to the shipped spur pair."""
    return {
        "gear_pair.pinion_teeth": z1,
        "gear_pair.gear_teeth": z2,
        "gear_pair.helix_angle_deg": abs(helix),
        "gear_pair.hand": "right" if helix >= 0.0 else "left",
        "gear_pair.pinion_profile_shift": shift,
        "gear_pair.gear_profile_shift": -shift if z2 < 0 else 0.0,
    }


PAIRS = {
    "16/24": external(16, 24, shift=0.2),
    "20/31": external(20, 31, shift=0.2),
    "25/25": external(25, 25),
    "40/21": external(40, 21),
    "20/31 at 8 deg": external(20, 31, 8.0, 0.2),
    "16/24 at 15 deg": external(16, 24, 15.0, 0.2),
    "20/31 at 20 deg": external(20, 31, 20.0, 0.2),
    "25/25 at -30 deg": external(25, 25, -30.0),
    "25/-60": external(25, -60, shift=0.4),
    "20/-71": external(20, -71, shift=0.3),
    "25/-60 at 12 deg": external(25, -60, 12.0, 0.4),
    "20/-71 at -20 deg": external(20, -71, -20.0, 0.3),
}
COEFFICIENTS = (0.05, 0.1, 0.2)
CASES = [(name, COEFFICIENTS[i % 3], "line") for i, name in enumerate(PAIRS)]
CASES += [("16/24", 0.2, "patch"), ("20/31 at 20 deg", 0.1, "patch")]


# as much is asked of rigid teeth; elastic ones, which take their time, are in one pair of each kind and in 16/24
RIGID = ("25/25", "40/21", "20/31 at 8 deg", "16/24 at 15 deg", "25/25 at -30 deg", "25/-60", "25/-60 at 12 deg")


def scene_of(name: str, coefficient: float, fidelity: str = "line") -> sw.Scene:
    friction = {"effects.friction": {"coefficient": coefficient}, "numerics.fidelity": fidelity}
    teeth = {"numerics.tooth_compliance": "rigid" if name in RIGID else "prism"}
    return sw.load_scene("spur_fzg_c").replace(SMALL | NARROW | PAIRS[name] | teeth | friction)


@dataclass(frozen=True)
class Rubbing:
    """A loaded pair, and the forces on its slices."""

    teeth: LoadedTeeth
    state: LoadedState

    @classmethod
    def of(cls, scene: sw.Scene, rolls: Any) -> "Rubbing":
        teeth = plan(scene).loaded_teeth(roll_positions=np.asarray(rolls))
        return cls(teeth, teeth.load(np.zeros(teeth.grid.profile.shape)))

    @property
    def solver(self) -> FrictionalContact:
        assert isinstance(self.teeth.fidelity.solve, FrictionalContact)
        return self.teeth.fidelity.solve

    @property
    def force(self) -> np.ndarray:
        return self.state.loads.force

    @property
    def total(self) -> np.ndarray:
        """Normal force of all pairs at each mesh position [N]."""
        return self.force.sum(axis=1).reshape(self.teeth.rolls.pairs, -1).sum(axis=0)

    def moments(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Moments of all forces about both axes [N mm], and power of friction per unit speed [N mm], by position.

        Levers and velocities of rigid bodies about their axes, in eight parts of every slice; for friction Carter's
        closed form.
        """
        lines, pair = self.teeth.lines, self.teeth.pair
        face = np.broadcast_to(lines.face, lines.profile.shape)
        met = pair.meeting(face, lines.profile, lines.roll[:, None])
        speed = 1.0, 1.0 / pair.driving_meshes
        axes = [axis_of(pair, body) for body in (DRIVING, DRIVEN)]
        turns = [
            (1.0 if axis.rotation == "positive" else -1.0) * rate * axis.direction
            for axis, rate in zip(axes, speed, strict=True)
        ]
        step = change_along_line(met.position, lines.face, lines.profile, lines.low, lines.high)
        step *= np.gradient(lines.face)[:, None]
        threshold = self.solver.friction.coefficient * self.state.loads.half_width * self.state.coarse.curvature

        def tangential(velocity: np.ndarray) -> np.ndarray:
            return velocity - np.sum(velocity * met.normal, axis=-1, keepdims=True) * met.normal

        moments = [
            -self.force * np.sum(np.cross(turn, met.position - axis.point) * met.normal, axis=-1)
            for turn, axis in zip(turns, axes, strict=True)
        ]
        loss, mu = np.zeros_like(self.force), self.solver.friction.coefficient
        for part in (np.arange(8) + 0.5) / 8 - 0.5:
            position = met.position + part * step
            first, second = (np.cross(turn, position - axis.point) for turn, axis in zip(turns, axes, strict=True))
            slip = tangential(first - second)
            size = np.linalg.norm(slip, axis=-1)
            rolling = 0.5 * np.linalg.norm(tangential(first + second), axis=-1)
            creep = size / np.maximum(threshold * rolling, 1e-30)
            share = np.where(creep < 1.0, 1.0 - (1.0 - creep) ** 2, 1.0)
            friction = (mu * self.force * share / np.where(size > 0.0, size, 1.0))[..., None] * slip / 8
            moments[0] = moments[0] + np.sum(friction * first, axis=-1)
            moments[1] = moments[1] + np.sum(friction * second, axis=-1)
            loss += np.sum(friction * slip, axis=-1)
        pairs = self.teeth.rolls.pairs
        first, second, lost = (v.sum(axis=1).reshape(pairs, -1).sum(axis=0) for v in (*moments, loss))
        return first, second, lost

    def on_the_path(self) -> np.ndarray:
        """Mesh positions at which no border of a flank bears load."""
        lines = self.teeth.lines
        border = (self.force > 0.0) & ((lines.profile <= lines.low) | (lines.profile >= lines.high))
        return ~border.any(axis=1).reshape(self.teeth.rolls.pairs, -1).any(axis=0)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "coefficient", "fidelity"), CASES)
def test_forces_times_levers_are_the_torque(name, coefficient, fidelity):
    rubbing = Rubbing.of(scene_of(name, coefficient, fidelity), [0.0, 1e-6, 1e-3, -1e-3, 0.03, 0.15, 0.45, 0.6, 0.9])
    torque, lever = rubbing.teeth.problem.torque, rubbing.teeth.lines.lever_arm
    normal = (rubbing.force * lever).sum(axis=1).reshape(rubbing.teeth.rolls.pairs, -1).sum(axis=0)
    rubs = rubbing.solver.moment(rubbing.teeth.problem, rubbing.state.loads, rubbing.state.coarse)
    np.testing.assert_allclose(normal + rubs, torque, rtol=1e-9)
    # and by the kinematics of rigid bodies, as exactly as traced contact lines lie on the path of contact
    goes_in, comes_out, loss = rubbing.moments()
    on = rubbing.on_the_path()
    np.testing.assert_allclose(goes_in[on], torque[on], rtol=1e-4)
    np.testing.assert_allclose((goes_in - comes_out - loss)[on], 0.0, atol=1e-4 * torque[0])
    assert (loss >= 0.0).all()


@pytest.mark.slow
@pytest.mark.parametrize(("name", "coefficient"), [(name, COEFFICIENTS[i % 3]) for i, name in enumerate(PAIRS)])
def test_the_normal_force_is_one_curve_about_the_pitch_point(name, coefficient):
    """Half the step, half the greatest change from position to position; a jump would stay as it is."""
    scene = scene_of(name, coefficient)
    steps = []
    for positions in (33, 65):
        roll = np.linspace(-0.008, 0.008, positions) * coefficient / 0.2
        total = Rubbing.of(scene, roll).total
        phase = np.mod(np.round(roll, 12), 1.0)
        steps.append(np.abs(np.diff(total[np.argsort(np.argsort(phase))])).max())
    assert steps[1] < 0.65 * steps[0]


@pytest.mark.slow
def test_at_the_pitch_point_a_spur_pair_does_not_rub():
    """Its curve passes the frictionless force in the middle, from one plateau of Coulomb's law to the other."""
    coefficient = 0.1
    scene = scene_of("20/31", coefficient).replace({"numerics.tooth_pairs": 1})
    rubbing, free = (Rubbing.of(s, [-0.01, 0.0, 0.01]) for s in (scene, scene.replace({"effects.friction": None})))
    before, middle, after = rubbing.total
    pair = rubbing.teeth.pair
    base = pair.lever_arm(np.zeros((1, 3)))[0]
    radius = base * np.tan(scene.gear_pair.working_pressure_angle)
    shift = 0.01 * pair.base_pitch
    np.testing.assert_allclose(middle, free.total[1], rtol=1e-4)
    np.testing.assert_allclose(before, free.total[0] / (1.0 - coefficient * (radius - shift) / base), rtol=1e-6)
    np.testing.assert_allclose(after, free.total[2] / (1.0 + coefficient * (radius + shift) / base), rtol=1e-6)


@pytest.mark.slow
def test_hands_mirror_each_other():
    right, left = (
        Rubbing.of(scene_of("20/31 at 20 deg", 0.1).replace({"gear_pair.hand": hand}), [0.0, 0.2, 0.7])
        for hand in ("right", "left")
    )
    np.testing.assert_allclose(left.force[:, ::-1], right.force, atol=1e-7 * right.force.max())


def test_carters_traction_sticks_where_it_should():
    """Surfaces stretch under the traction by as much as they would slide, where it is below mu p (Johnson, 8.3)."""
    places = (np.arange(20000) + 0.5) / 10000 - 1.0  # over the half-width; points enter at -1
    for creep in (0.1, 0.5, 0.9):
        stick = 1.0 - creep  # half-width of the band that sticks, at the entering side
        inside = np.clip(1.0 - ((places + creep) / stick) ** 2, 0.0, None)
        traction = np.sqrt(1.0 - places**2) - stick * np.sqrt(inside)
        share = traction.mean() * 2.0 / (0.5 * np.pi)
        assert share == pytest.approx(float(share_of_full_friction(np.array(creep), np.array(1.0))), rel=1e-4)
        # strains of both bodies together, over mu b/R: the principal value of -1/pi sum q/(x - s)
        at = np.linspace(-0.95, -1.0 + 2.0 * stick - 0.05, 7)
        at = (np.floor(at * 10000) + 0.0) / 10000
        strain = np.array([np.sum(traction / (x - places)) for x in at]) / np.pi / 10000
        np.testing.assert_allclose(strain, -creep, atol=2e-3)


def test_friction_is_odd_and_has_a_value_without_sliding():
    speed = np.array([0.0, 1e-300, 1e-15, 1e-3, 0.5, 1.0 - 1e-12, 1.0, 2.0])
    share = share_of_full_friction(speed, np.ones(8))
    np.testing.assert_allclose(share, [0.0, 2e-300, 2e-15, 1.999e-3, 0.75, 1.0, 1.0, 1.0], rtol=1e-9)
    np.testing.assert_array_equal(share_per_speed(np.array([0.0, 4.0]), np.zeros(2)), [0.0, 0.25])
