"""Laws of the wear coefficient: closed forms and properties."""

from math import exp
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from semiwear.contact.conditions import ContactConditions
from semiwear.contact.film_thickness import FilmThickness
from semiwear.contact.flash_temperature import FlashTemperature
from semiwear.contact.friction import Friction
from semiwear.effect_clock import EffectClock
from semiwear.wear import contact_factor
from semiwear.wear.laws import HardnessLaw, LoadLaw, LubricationLaw, TemperatureLaw
from tests.strategies.line_states import line_state

FILM = FilmThickness("dowson_higginson", 50.0, 20.0, roughness_um=0.5, effective_modulus=113e3)
FLASH = FlashTemperature("tian_kennedy", 80.0, 46.0, 7830.0, 465.0)
RUBBING = Friction("constant", coefficient=0.08)


def conditions(load, pressure=900.0, speed=3e3) -> ContactConditions:
    return line_state(load, speed, 0.7 * np.asarray(speed), pressure=pressure)


LAWS = (
    LoadLaw(0.5, 1000.0),
    LoadLaw(-0.5, 1000.0),
    LoadLaw(0.0, 1000.0),
    LubricationLaw(FILM),
    TemperatureLaw(FLASH, RUBBING, 40.0, 100.0),
)


@pytest.mark.parametrize("law", LAWS)
def test_factors_are_finite_and_none_without_load(law):
    factor = law.factor(conditions([0.0, 200.0, 0.0, 200.0], speed=[2e3, 2e3, 0.0, 0.0]))
    assert np.isfinite(factor).all()
    assert factor[0, 0] == factor[0, 2] == 0.0
    assert factor[0, 1] > 0.0
    assert factor[0, 3] > 0.0


@pytest.mark.parametrize("exponent", [-2.0, -1.2, -0.5])
def test_load_law_has_a_value_at_zero_pressure(exponent):
    pressure = np.array([0.0, 1e-300, 1e-3, 8.0, 80.0, 800.0])
    factor = LoadLaw(exponent, 800.0).factor(conditions(200.0, pressure=pressure))[0]
    np.testing.assert_allclose(factor, (np.maximum(pressure, 8.0) / 800.0) ** exponent, rtol=1e-12)


def test_load_law():
    factor = LoadLaw(1.5, 800.0).factor(conditions(200.0, pressure=[800.0, 1600.0, 200.0]))
    np.testing.assert_allclose(factor[0], [1.0, 2.0**1.5, 0.125], rtol=1e-12)


def test_lubrication_law_is_that_of_priest_and_taylor():
    speeds = np.geomspace(1.0, 1e6, 60)
    state = conditions(200.0, speed=speeds)
    ratio = FILM.lambda_ratio(state)[0]
    expected = np.where(ratio < 0.5, 1.0, np.where(ratio > 4.0, 0.0, 2.0 / 7.0 * (4.0 - ratio)))
    assert ((ratio > 0.5) & (ratio < 4.0)).sum() > 3
    np.testing.assert_allclose(LubricationLaw(FILM).factor(state)[0], expected, atol=1e-12)
    half = LubricationLaw(FILM, strength=0.5).factor(state)[0]
    np.testing.assert_allclose(half, 0.5 + 0.5 * expected, atol=1e-12)


def test_temperature_law():
    state = conditions([100.0, 400.0])
    mu = RUBBING.coefficient_of(state)
    hot = FLASH.contact_temperature(state, mu)[0] + 273.15
    law = TemperatureLaw(FLASH, RUBBING, 40.0, 100.0)
    expected = [exp(-40e3 / 8.314462618 * (1.0 / t - 1.0 / 373.15)) for t in hot]
    np.testing.assert_allclose(law.factor(state)[0], expected, rtol=1e-12)
    at_reference = TemperatureLaw(FLASH, RUBBING, 40.0, float(hot[0]) - 273.15).factor(state)[0]
    assert at_reference[0] == pytest.approx(1.0, rel=1e-12)
    assert at_reference[1] > 1.0
    assert not np.any(TemperatureLaw(FLASH, RUBBING, 0.0, 20.0).factor(state) - 1.0)


def test_laws_multiply(monkeypatch):
    state = conditions([0.0, 150.0, 300.0], speed=[1e3, 1e3, 2e3])
    monkeypatch.setattr(contact_factor, "line_conditions", lambda *of_the_contact: state)
    laws = {"load": LAWS[0], "lubrication": LAWS[3], "temperature": LAWS[4]}
    teeth, contact = SimpleNamespace(problem=None), SimpleNamespace(coarse=None)
    together = contact_factor.ContactFactor(laws, None, EffectClock())(teeth, None, contact)
    product = LAWS[0].factor(state) * LAWS[3].factor(state) * LAWS[4].factor(state)
    np.testing.assert_allclose(together, np.where(state.loaded, product, 1.0))


DEPTH = st.floats(0.0, 2.0)
HARDNESS = st.floats(100.0, 900.0)


@st.composite
def hardness_laws(draw) -> HardnessLaw:
    case_depth = draw(st.floats(0.0, 1.0))
    transition = draw(st.one_of(st.just(0.0), st.floats(0.0, 2.0))) * case_depth
    band = draw(st.one_of(st.none(), st.lists(st.floats(0.5, 2.0), min_size=3, max_size=3)))
    surface = None if band is None else np.array([band])
    return HardnessLaw(draw(HARDNESS), draw(HARDNESS), case_depth, transition, surface)


@given(hardness_laws(), DEPTH, DEPTH, DEPTH)
def test_depth_does_not_depend_on_the_division_of_wear(law, depth, first, second):
    start = np.full((1, 3), depth)
    divided = law.advance(law.advance(start, first), second)
    np.testing.assert_allclose(divided, law.advance(start, first + second), rtol=1e-9, atol=1e-12)


@given(hardness_laws(), DEPTH, DEPTH, DEPTH)
def test_depth_grows_with_wear_and_within_the_hardness(law, depth, first, second):
    start = np.full((1, 3), depth)
    low, high = sorted((first, second))
    less, more = law.advance(start, low), law.advance(start, high)
    assert np.all(less >= start)
    assert np.all(more >= less - 1e-12)
    case = 1.0 if law.surface is None else law.surface
    core = law.core_hardness / law.surface_hardness
    softest, hardest = np.minimum(case, core), np.maximum(case, core)
    assert np.all(high / hardest * (1.0 - 1e-9) - 1e-12 <= more - start)
    assert np.all(more - start <= high / softest * (1.0 + 1e-9) + 1e-12)
    factor = law.factor(start)
    assert np.all((factor >= 1.0 / hardest * (1.0 - 1e-9)) & (factor <= 1.0 / softest * (1.0 + 1e-9)))


@given(DEPTH, DEPTH, st.floats(0.0, 1.0))
def test_one_hardness_through_is_archards_law_to_the_last_bit(depth, increment, transition):
    law = HardnessLaw(650.0, 650.0, 0.5, transition)
    start = np.array([[depth, 0.5 * depth, 0.0]])
    assert np.array_equal(law.advance(start, increment), start + increment)
    assert np.array_equal(law.factor(start), np.ones((1, 3)))


def test_two_layers_have_a_kink():
    law = HardnessLaw(700.0, 350.0, 0.3, 0.0)
    wear = np.array([[0.1, 0.3, 0.4, 1.3]])
    np.testing.assert_allclose(law.advance(np.zeros((1, 4)), wear), [[0.1, 0.3, 0.5, 2.3]], rtol=1e-12)
    np.testing.assert_array_equal(law.factor(np.array([[0.29, 0.31]])), [[1.0, 2.0]])


def test_the_transition_lies_about_the_case_depth():
    """From half a transition above the case depth (ISO 18203) to half of it below; linear between."""
    law = HardnessLaw(700.0, 350.0, case_depth=0.3, transition=0.1)
    depth = np.array([[0.0, 0.2499, 0.25, 0.275, 0.3, 0.35, 0.3501, 1.0]])
    assert 1.0 / law.factor(depth)[0] == pytest.approx([1.0, 1.0, 1.0, 0.875, 0.75, 0.5, 0.5, 0.5], rel=1e-12)
    soft = HardnessLaw(700.0, 350.0, case_depth=0.3, transition=0.1, surface=np.array([[0.05]]))
    assert 1.0 / soft.factor(np.zeros((1, 1))) == pytest.approx(0.05)


def test_a_transition_is_the_solution_of_its_equation():
    law = HardnessLaw(700.0, 250.0, 0.3, 0.4, surface=np.array([[1.0, 1.3]]))
    found = law.advance(np.full((1, 2), 0.05), np.full((1, 2), 0.6))
    solved = solve_ivp(
        lambda s, h: law.factor(h[None])[0], (0.0, 0.6), [0.05, 0.05], rtol=1e-10, atol=1e-12, max_step=0.01
    )
    np.testing.assert_allclose(found[0], solved.y[:, -1], rtol=1e-6)


def test_a_harder_band_wears_less_until_it_is_worn_through():
    band = np.array([[1.0, 1.25]])
    law = HardnessLaw(700.0, 700.0, 0.3, 0.0, surface=band)
    np.testing.assert_allclose(law.advance(np.zeros((1, 2)), np.full((1, 2), 0.25)), [[0.25, 0.2]], rtol=1e-12)
    np.testing.assert_allclose(law.advance(np.zeros((1, 2)), np.full((1, 2), 0.5)), [[0.5, 0.425]], rtol=1e-12)


@pytest.mark.parametrize(
    "wrong",
    [
        {"surface_hardness": 0.0},
        {"core_hardness": -1.0},
        {"transition": 0.7},
        {"transition": -0.1},
        {"surface": np.array([[1.0, 0.0]])},
    ],
)
def test_hardness_laws_that_cannot_be(wrong):
    with pytest.raises(ValueError, match="hardness"):
        HardnessLaw(
            **{"surface_hardness": 700.0, "core_hardness": 350.0, "case_depth": 0.3, "transition": 0.1, **wrong}
        )
