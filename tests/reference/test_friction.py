"""Friction of a spur pair, whose mesh is integrated slice by slice, against Ohlendorf's loss factor."""

from dataclasses import dataclass
from math import pi

import numpy as np
import pytest

from semiwear.contact.conditions import ContactConditions
from semiwear.contact.friction import Friction, mesh_efficiency, power_loss
from tests.strategies.line_states import line_state
from tests.strategies.spur_pair import SpurPair


@dataclass(frozen=True)
class LoadedPair:
    """Spur pair under load; its path of contact by the distance from the pitch point, in base pitches."""

    pair: SpurPair
    speed: float = 100.0  # rad/s of the pinion
    torque: float = 1e5  # N mm on the pinion

    def radii(self, roll):
        """Radii of curvature of both flanks."""
        (first, second), at = self.pair.pitch_curvature, roll * self.pair.base_pitch
        return first + at, second - at

    def roll(self, positions=20001):
        first, second = self.pair.addendum_ratios
        return np.linspace(-second, first, positions)

    def share(self, roll):
        first, second = self.pair.addendum_ratios
        return 1.0 / (1.0 + (roll + 1.0 < first) + (roll - 1.0 > -second))

    def conditions(self, roll, slices=3) -> ContactConditions:
        driving, driven = self.radii(roll)
        speed = np.stack([self.speed * driving, self.speed * self.pair.teeth[0] / self.pair.teeth[1] * driven])
        load = self.torque / self.pair.base_radius[0] / self.pair.width * self.share(roll)
        every = [
            np.repeat(values[:, None], slices, axis=1) for values in (load, 1.0 / driving + 1.0 / driven, *speed)
        ]
        return ContactConditions(
            line_load=every[0],
            half_width=np.full_like(every[0], 0.1),
            curvature=every[1],
            pressure=np.full_like(every[0], 800.0),
            surface_speed=np.stack(every[2:]),
            sliding_speed=np.abs(every[2] - every[3]),
        )

    def loss_factor(self) -> float:
        (first, second), (z1, z2) = self.pair.addendum_ratios, self.pair.teeth
        u = z2 / z1
        return pi * (u + 1.0) / (z1 * u) * (1.0 - first - second + first**2 + second**2)


PLAIN = LoadedPair(SpurPair((20, 40), 3.0, 90.0, (33.0, 63.0), 12.0))
# FZG type C test gears, as a public program reports them (C. M. C. G. Fernandes, GEARpie, 2022, report of C40)
FZG_C = LoadedPair(SpurPair((16, 24), 4.5, 91.5, (41.318, 59.272), 40.0), 2.0 * pi * 30.0, 215.5e3)


def efficiency(loaded: LoadedPair, friction: Friction, slices: int = 3) -> float:
    roll = loaded.roll()
    conditions = loaded.conditions(roll, slices)
    loss = power_loss(conditions, friction.coefficient_of(conditions), np.full(slices, loaded.pair.width / slices))
    return mesh_efficiency(loss, roll, 1e-3 * loaded.torque * loaded.speed)


@pytest.mark.parametrize("pair", [PLAIN, FZG_C])
@pytest.mark.parametrize("slices", [1, 4])
def test_the_loss_of_an_evenly_shared_mesh_is_ohlendorfs(pair, slices):
    lost = 1.0 - efficiency(pair, Friction("constant", coefficient=0.06), slices)
    assert lost == pytest.approx(0.06 * pair.loss_factor(), rel=3e-4)


def test_the_loss_factor_of_fzg_c_gears():
    assert FZG_C.loss_factor() == pytest.approx(0.1986, abs=5e-5)  # GEARpie's report: 0.1986
    assert (1.0 - efficiency(FZG_C, Friction("constant", coefficient=0.05))) / 0.05 == pytest.approx(0.1986, abs=1e-4)


def test_the_mean_coefficient_at_the_pitch_point_of_fzg_c_gears():
    # GEARpie's report of C40: F_bt/b = 6370.7/40 N/mm, 49.85 mPa s, Ra 0.4 and 0.31 um, X_L 0.65: 0.0256
    oil = Friction("iso_14179", viscosity_mPas=49.85, roughness_um=0.355, lubricant_factor=0.65)
    conditions = FZG_C.conditions(np.zeros(1))
    assert conditions.line_load[0, 0] == pytest.approx(6370.7 / 40.0, rel=1e-4)
    assert oil.coefficient_of(conditions)[0, 0] == pytest.approx(0.0256, abs=5e-5)


def test_the_two_forms_of_the_mean_coefficient_agree_at_161_mm():
    oil = {"viscosity_mPas": 60.0, "roughness_um": 0.6}
    conditions = PLAIN.conditions(PLAIN.roll(11))
    local = Friction("iso_14179", **oil).coefficient_of(conditions)
    np.testing.assert_allclose(
        Friction("iso_14179", **oil, reference_diameter_mm=161.0).coefficient_of(conditions), local, rtol=1e-3
    )
    small = Friction("iso_14179", **oil, reference_diameter_mm=73.2).coefficient_of(conditions)
    np.testing.assert_allclose(small, 1.22 * local, rtol=5e-3)


def conditions(load, speed) -> ContactConditions:
    return line_state(load, speed, 0.8 * np.asarray(speed))


OIL = Friction("iso_14179", viscosity_mPas=50.0, roughness_um=0.5)


def test_the_mean_coefficient_is_held_at_its_limits():
    light, limit, heavy = OIL.coefficient_of(conditions([1.0, 150.0, 300.0], 5e3))[0]
    assert light == limit
    assert heavy == pytest.approx(2.0**0.2 * limit, rel=1e-12)
    still, slow, edge, fast = OIL.coefficient_of(conditions(300.0, [0.0, 100.0, 1e3 / 1.8, 2e3 / 1.8]))[0]
    assert still == slow == pytest.approx(edge, rel=1e-12)
    assert fast == pytest.approx(0.5**0.2 * edge, rel=1e-12)


@pytest.mark.parametrize("law", [OIL, Friction("constant", coefficient=0.1)])
def test_slices_without_load_rub_nothing(law):
    state = conditions([0.0, 200.0, 0.0], [3e3, 3e3, 0.0])
    mu = law.coefficient_of(state)
    assert mu[0, 0] == mu[0, 2] == 0.0 < mu[0, 1]
    assert power_loss(state, mu, np.array([2.0, 2.0, 2.0])) == pytest.approx(
        [mu[0, 1] * 200.0 * 600.0 * 2.0 * 1e-3], rel=1e-12
    )


def test_moments_with_friction_differ_by_the_power_loss():
    pair, roll, mu = FZG_C.pair, FZG_C.roll(41), 0.08
    state = FZG_C.conditions(roll, 1)
    side = state.sliding_direction[:, 0]
    force = state.line_load[:, 0] * pair.width
    # of the normal force about both axes, friction included: it acts along the tangent, at the radius of curvature
    levers = [base + mu * side * rho for base, rho in zip(pair.base_radius, FZG_C.radii(roll), strict=True)]
    speeds = FZG_C.speed, FZG_C.speed * pair.teeth[0] / pair.teeth[1]
    loss = 1e-3 * force * (levers[0] * speeds[0] - levers[1] * speeds[1])
    expected = power_loss(state, np.full_like(state.line_load, mu), np.full(1, pair.width))
    np.testing.assert_allclose(loss, expected, rtol=1e-9, atol=1e-9 * expected.max())
    assert np.all(
        levers[0][roll < -0.01] < pair.base_radius[0]
    )  # approaching teeth: friction helps the driver's moment
    assert np.all(levers[0][roll > 0.01] > pair.base_radius[0])
