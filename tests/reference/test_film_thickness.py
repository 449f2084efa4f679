"""Film thickness against an inlet analysis, a public program's report and the dimensional forms."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from semiwear.closed_forms.hertz import elliptic_contact
from semiwear.contact.conditions import ContactConditions
from semiwear.contact.film_thickness import (
    FilmThickness,
    dowson_higginson_minimum,
    dowson_toyoda_central,
    hamrock_dowson_central,
    hamrock_dowson_minimum,
)
from tests.strategies.line_states import line_state

MODULUS = 206e3 / 2.0 / (1.0 - 0.3**2)  # E* of steel on steel
OIL = {"viscosity_mPas": 49.85, "pressure_viscosity_per_GPa": 20.36, "roughness_um": sqrt(2.0) * 0.6}
LINE = FilmThickness("dowson_higginson", **OIL, effective_modulus=MODULUS)
ELLIPSE = FilmThickness("hamrock_dowson", **OIL, effective_modulus=MODULUS)


def conditions(load, driving, driven, curvature) -> ContactConditions:
    load, driving, driven, curvature = np.broadcast_arrays(
        *(np.atleast_2d(np.asarray(values, float)) for values in (load, driving, driven, curvature))
    )
    safe = np.where(load > 0.0, curvature, 1.0)
    found = ContactConditions.hertz(load, safe, np.stack([driving, driven]), MODULUS)
    return replace(found, curvature=np.where(load > 0.0, curvature, 0.0))


def ertel_grubin(state: ContactConditions, film: FilmThickness) -> float:
    """Film [um] with which the reduced pressure reaches 1/alpha at the inlet edge of the dry Hertz gap."""
    load, b = state.line_load[0, 0], state.half_width[0, 0]
    viscosity, alpha = 1e-9 * film.viscosity_mPas, 1e-3 * film.pressure_viscosity_per_GPa

    def excess(log_height: float) -> float:
        height = np.exp(log_height)

        def slope(distance: float) -> float:
            x = 1.0 + distance
            gap = 2.0 * load / (pi * MODULUS) * (x * sqrt(x * x - 1.0) - np.log(x + sqrt(x * x - 1.0)))
            return gap / (gap + height) ** 3

        parts = [quad(slope, *ends, limit=200)[0] for ends in ((0.0, 0.1), (0.1, 1.0), (1.0, 50.0))]
        return 12.0 * viscosity * state.entraining_speed[0, 0] * b * sum(parts) - 1.0 / alpha

    return 1e3 * float(np.exp(brentq(excess, np.log(1e-6), np.log(1e-1))))


@pytest.mark.parametrize("load", [150.0, 600.0])
@pytest.mark.parametrize("speed", [1e3, 5e3])
def test_the_film_is_that_of_an_inlet_analysis(load, speed):
    state = conditions(load, speed, speed, 1.0 / 10.0)
    expected = ertel_grubin(state, LINE)
    assert LINE.central(state)[0, 0] == pytest.approx(expected, rel=0.15)
    assert 0.7 < LINE.minimum(state)[0, 0] / expected < 1.0


def test_the_film_along_the_path_of_fzg_c_gears():
    # report of C40 by a public program (C. M. C. G. Fernandes, GEARpie, 2022): least 0.40, greatest 0.65, mean
    # 0.57 um, with 0.5 % taken off for inlet heating and E* for E', which gives 2 % more
    first, second = -9.68, 9.75  # AE 19.43 mm with the pitch point at 9.68 mm; base pitch 13.285 mm
    path = np.linspace(first, second, 201)
    driving, driven = 13.971 + path, 20.956 - path
    double = (path + 13.285 < second) | (path - 13.285 > first)
    state = conditions(
        6370.7 / 40.0 * np.where(double, 0.5, 1.0), 188.5 * driving, 125.67 * driven, 1.0 / driving + 1.0 / driven
    )
    film = 1.021 * 0.995 * LINE.minimum(state)
    assert film.min() == pytest.approx(0.40, abs=0.01)
    assert film.max() == pytest.approx(0.65, abs=0.01)
    assert film.mean() == pytest.approx(0.57, abs=0.01)


def test_the_line_formula_in_its_dimensional_form():
    # h = 2.65 alpha^0.54 (eta u)^0.70 R^0.43 E'^-0.03 q^-0.13 in SI units
    expected = 2.65 * 20.36e-9**0.54 * (49.85e-3 * 2.5) ** 0.7 * 0.012**0.43 * (2e6 * MODULUS) ** -0.03 * 250e3**-0.13
    found = LINE.minimum(conditions(250.0, 2e3, 3e3, 1.0 / 12.0))[0, 0]
    assert found == pytest.approx(1e6 * expected, rel=1e-12)
    assert LINE.lambda_ratio(conditions(250.0, 2e3, 3e3, 1.0 / 12.0))[0, 0] == pytest.approx(
        found / (sqrt(2.0) * 0.6), rel=1e-12
    )


def test_a_long_ellipse_and_a_line_have_much_the_same_film():
    state = conditions([150.0, 300.0, 600.0], 4e3, 3e3, 1.0 / 10.0)
    np.testing.assert_allclose(ELLIPSE.minimum(state), LINE.minimum(state), rtol=0.15)
    np.testing.assert_allclose(ELLIPSE.central(state), LINE.central(state), rtol=0.15)
    assert np.all(ELLIPSE.minimum(state) < ELLIPSE.central(state))
    assert np.all(LINE.minimum(state) < LINE.central(state))


def test_the_force_of_the_ellipse_is_the_one_that_has_the_line_load():
    ellipse = elliptic_contact(500.0, 1e-3, 0.1, MODULUS)
    k = ellipse.major_half_axis / ellipse.minor_half_axis
    line_load = 0.5 * pi * ellipse.peak_pressure * ellipse.minor_half_axis
    assert 4.0 / 3.0 * k * ellipse.minor_half_axis * line_load == pytest.approx(500.0, rel=1e-9)
    of_the_ellipse = {"half_width": ellipse.minor_half_axis, "pressure": ellipse.peak_pressure}
    state = line_state(line_load, 3e3, 3e3, **of_the_ellipse)
    modulus = 2.0 * MODULUS
    groups = 49.85e-9 * 3e3 / (modulus * 10.0), 20.36e-3 * modulus, 500.0 / (modulus * 100.0)
    exact = FilmThickness("hamrock_dowson", **OIL, effective_modulus=MODULUS, ellipticity=k)
    assert exact.minimum(state)[0, 0] == pytest.approx(1e4 * hamrock_dowson_minimum(*groups, k), rel=1e-9)
    assert exact.central(state)[0, 0] == pytest.approx(1e4 * hamrock_dowson_central(*groups, k), rel=1e-9)


def test_coefficients_where_every_group_is_one():
    assert dowson_higginson_minimum(1.0, 1.0, 1.0) == 2.65
    assert dowson_toyoda_central(1.0, 1.0, 1.0) == 3.06
    assert hamrock_dowson_minimum(1.0, 1.0, 1.0, 1.0) == pytest.approx(3.63 * 0.4934, abs=1e-4)
    assert hamrock_dowson_central(1.0, 1.0, 1.0, 1.0) == pytest.approx(2.69 * 0.7060, abs=1e-4)


@pytest.mark.parametrize("film", [LINE, ELLIPSE])
def test_no_load_or_no_entrainment_leaves_no_film(film):
    state = conditions([0.0, 0.0, 300.0, 300.0, 300.0], [1e3, 0.0, 0.0, 2e3, 1e3], [1e3, 0.0, 0.0, -2e3, 2e3], 0.1)
    for values in (film.minimum(state), film.central(state), film.lambda_ratio(state)):
        assert not values[0, :4].any()
        assert values[0, 4] > 0.0
