"""Flash temperatures against Jaeger's integral for a moving band, done here by quadrature."""

from math import pi, sqrt

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from scipy.special import k0e

from semiwear.contact.flash_temperature import FlashTemperature
from tests.strategies.line_states import HALF_WIDTH, line_state

STEEL = {"conductivity_W_per_mK": 46.0, "density_kg_per_m3": 7830.0, "specific_heat_J_per_kgK": 465.0}
BLOK = FlashTemperature("blok", bulk_temperature_C=80.0, **STEEL)
ANY = FlashTemperature("tian_kennedy", bulk_temperature_C=80.0, **STEEL, aspect=1e9)


def moving_band(peclet: float) -> float:
    """Greatest k theta over the heat per length: a semi-elliptic band on one half-space (Jaeger 1942)."""

    def temperature(x: float) -> float:
        def source(at: float) -> float:
            apart = peclet * abs(x - at)
            return 2.0 / pi * sqrt(max(0.0, 1.0 - at * at)) * np.exp(-2.0 * apart * (x > at)) * k0e(apart)

        return (quad(source, -1.0, x, limit=200)[0] + quad(source, x, 1.0, limit=200)[0]) / pi

    found = minimize_scalar(
        lambda x: -temperature(x), bounds=(-0.999, 0.3), method="bounded", options={"xatol": 1e-3}
    )
    return -found.fun


def standing_rectangle(aspect: float) -> float:
    """Greatest k theta over the heat per length: a standing band of length 2 a, at its middle."""

    def source(across: float) -> float:
        return 2.0 / pi * sqrt(1.0 - across * across) * np.arcsinh(aspect / across)

    return 2.0 * quad(source, 0.0, 1.0)[0] / pi


def moving_rectangle(peclet: float, aspect: float) -> float:
    """As the moving band, of length 2 a: every strip's heat summed along its length, hottest on the middle line."""
    angle = (np.arange(300) + 0.5) * pi / 300
    at, heat = np.cos(angle), 2.0 / 300 * np.sin(angle) ** 2
    along, weight = np.polynomial.legendre.leggauss(60)

    def temperature(x: float) -> float:
        apart = np.abs(x - at)
        half = 0.5 * np.arcsinh(aspect / apart)[:, None]
        distance = apart[:, None] * np.cosh(half * (1.0 + along))
        strips = (half * weight * np.exp(-peclet * (distance + (x - at)[:, None]))).sum(axis=1)
        return float((heat * strips).sum() / pi)

    return max(temperature(x) for x in np.cos((np.arange(150, 260, 2)) * pi / 300))


def speed_of(model: FlashTemperature, peclet: float) -> float:
    return 2.0 * model.diffusivity * peclet / HALF_WIDTH


def per_heat(model: FlashTemperature, peclet: float, ratio: float = 1.0) -> float:
    """Times k, over the heat per length, with the driven surface `ratio` times as fast."""
    speed = speed_of(model, peclet)
    state = line_state(100.0, speed, ratio * speed, sliding=500.0)
    return model.rise(state, np.full((1, 1), 0.05))[0, 0] * model.conductivity_W_per_mK / (0.05 * 100.0 * 500.0)


def test_blok_by_hand():
    # B = sqrt(46 * 7830 * 465) = 12941 N/(m s^0.5 K); q 300 N/mm, 4 and 3 m/s, mu 0.05, b 0.15 mm
    by_hand = 1.11 * 0.05 * 300e3 * 1.0 / (12941.5 * (2.0 + sqrt(3.0)) * sqrt(2.0 * 0.15e-3))
    rise = BLOK.rise(line_state(300.0, 4e3, 3e3), np.full((1, 1), 0.05))[0, 0]
    assert rise == pytest.approx(by_hand, rel=1e-4)
    assert rise == pytest.approx(19.9, abs=0.05)


@pytest.mark.parametrize("peclet", [1e-3, 0.03, 0.3, 1.0, 3.0, 10.0, 100.0])
def test_one_formula_serves_every_speed(peclet):
    assert 2.0 * per_heat(ANY, peclet) == pytest.approx(moving_band(peclet), rel=0.014)


def test_blok_is_good_for_fast_surfaces_only():
    assert 2.0 * per_heat(BLOK, 10.0) == pytest.approx(moving_band(10.0), rel=2e-3)
    assert 1.05 < 2.0 * per_heat(BLOK, 1.0) / moving_band(1.0) < 1.07


@pytest.mark.parametrize("ratio", [1.0, 0.3, -2.0])
def test_the_models_agree_at_high_speed(ratio):
    assert per_heat(ANY, 1e6, ratio) == pytest.approx(per_heat(BLOK, 1e6, ratio), rel=1e-5)


@pytest.mark.parametrize("aspect", [10.0, 40.0])
@pytest.mark.parametrize("kind", ["blok", "tian_kennedy"])
def test_standing_contacts_stay_finite(kind, aspect):
    model = FlashTemperature(kind, 80.0, **STEEL, aspect=aspect)
    assert 2.0 * per_heat(model, 0.0) == pytest.approx(standing_rectangle(aspect), rel=0.01)


@pytest.mark.parametrize("aspect", [10.0, 40.0])
@pytest.mark.parametrize("peclet", [1e-3, 0.03, 0.1, 0.5])
def test_slow_contacts_of_finite_length(peclet, aspect):
    model = FlashTemperature("tian_kennedy", 80.0, **STEEL, aspect=aspect)
    assert 2.0 * per_heat(model, peclet) == pytest.approx(moving_rectangle(peclet, aspect), rel=0.05)


def test_the_heat_divides_so_that_the_hottest_points_agree():
    fast, slow = per_heat(ANY, 8.0), per_heat(ANY, 2.0)
    assert per_heat(ANY, 8.0, 0.25) == pytest.approx(2.0 / (1.0 / fast + 1.0 / slow), rel=1e-9)


@pytest.mark.parametrize("model", [BLOK, ANY])
def test_scaling(model):
    state, mu = line_state([200.0, 400.0], 5e3, 4e3), np.array([[0.05, 0.05]])
    once, twice = model.rise(state, mu)[0]
    assert twice == pytest.approx(2.0 * once, rel=1e-12)
    assert model.rise(state, 3.0 * mu)[0, 0] == pytest.approx(3.0 * once, rel=1e-12)
    assert model.contact_temperature(state, mu)[0, 0] == pytest.approx(80.0 + once, rel=1e-12)
    assert not model.rise(state, 0.0 * mu).any()
    faster = model.rise(line_state(200.0, 20e3, 16e3), mu[:, :1])[0, 0]
    assert faster == pytest.approx(2.0 * once, rel=0.02)
    wider = model.rise(line_state(200.0, 5e3, 4e3, half_width=4.0 * HALF_WIDTH), mu[:, :1])[0, 0]
    assert wider == pytest.approx(0.5 * once, rel=0.02)


@pytest.mark.parametrize("model", [BLOK, FlashTemperature("tian_kennedy", 80.0, **STEEL)])
def test_slices_without_load_or_motion(model):
    state = line_state(
        [0.0, 0.0, 300.0, 300.0], [1e3, 0.0, 0.0, 2e3], [2e3, 0.0, 0.0, 2e3], sliding=[[9.0, 0, 9.0, 0]]
    )
    rise = model.rise(state, np.full((1, 4), 0.1))[0]
    assert rise[0] == rise[1] == rise[3] == 0.0
    assert 0.0 < rise[2] < 100.0
