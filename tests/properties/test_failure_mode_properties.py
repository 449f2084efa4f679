"""Failure modes go the way that they should with load, speed, roughness, oil and case, in any units."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from semiwear.closed_forms import effective_modulus, line_contact_half_width, line_contact_pressure
from semiwear.ratings.flank_fracture import (
    FlankMaterial,
    line_contact_stress,
    material_exposure,
    shear_stress_intensity,
)
from semiwear.ratings.hardness import hardness_of_case, residual_stress
from semiwear.ratings.load_stages import film_of_test
from semiwear.ratings.oil import Oil, OilFamily
from semiwear.ratings.scuffing import (
    bulk_temperature_flash,
    flash_temperature_safety,
    integral_temperature_safety,
    scuffing_integral_temperature,
    scuffing_temperature,
)
from semiwear.ratings.specific_film import FilmContact, specific_film

MODULUS = effective_modulus(206e3, 0.3, 206e3, 0.3)
FAMILIES: list[OilFamily] = ["mineral", "polyalphaolefin", "polyglycol"]

oils = st.builds(
    lambda family, cold, ratio: Oil(family, cold, cold / ratio, 880.0),
    st.sampled_from(FAMILIES),
    st.floats(40.0, 600.0),
    st.floats(4.0, 12.0),
)
loads, radii, speeds = st.floats(20.0, 2000.0), st.floats(2.0, 80.0), st.floats(200.0, 4e4)
hotter, rougher, more = st.floats(1.0, 60.0), st.floats(0.1, 1.6), st.floats(1.01, 3.0)


def film(oil, load, radius, speed, flash=20.0, bulk=80.0, roughness=0.5):
    pressure = line_contact_pressure(np.array([load]), np.array([1.0 / radius]), MODULUS)
    contact = FilmContact(np.array([speed]), pressure, np.array([1.0 / radius]), np.array([bulk + flash]), MODULUS)
    return float(specific_film(contact, oil, bulk, roughness)[0])


@given(oil=oils, load=loads, radius=radii, speed=speeds, more=more)
@settings(deadline=None)
def test_film_grows_with_speed_and_radius_and_shrinks_with_load_heat_and_roughness(oil, load, radius, speed, more):
    here = film(oil, load, radius, speed)
    assert film(oil, load, radius, more * speed) > here > film(oil, more * load, radius, speed)
    assert film(oil, load, more * radius, speed) > here
    assert here > film(oil, load, radius, speed, flash=20.0 * more)
    assert here > film(oil, load, radius, speed, bulk=80.0 + 10.0 * more)
    assert film(oil, load, radius, speed, roughness=0.5 * more) == pytest.approx(here / more)
    thicker = Oil(oil.family, more * oil.viscosity_40, more * oil.viscosity_100, oil.density_15)
    assert film(thicker, load, radius, speed) > here


@given(oil=oils, load=loads, radius=radii, speed=speeds, scale=st.floats(0.1, 10.0))
@settings(deadline=None)
def test_film_in_other_units_of_length(oil, load, radius, speed, scale):
    """Lengths and speeds scale alike at equal pressure: U and W stay, the film grows with them."""
    assert film(oil, scale * load, scale * radius, scale * speed) == pytest.approx(
        scale * film(oil, load, radius, speed), rel=1e-9
    )


@given(oil=oils, stage=st.floats(5.0, 9.9))
@settings(deadline=None, max_examples=30)
def test_an_oil_that_bears_more_needs_less_film(oil, stage):
    assert film_of_test(oil, stage) > film_of_test(oil, stage + 0.1) > 0.0


@given(oil=oils, warmer=hotter)
@settings(deadline=None)
def test_oil_thins_with_heat(oil, warmer):
    first, second = oil.dynamic_viscosity([50.0, 50.0 + warmer])
    assert first > second > 0.0
    first, second = oil.pressure_viscosity([50.0, 50.0 + warmer])
    assert first > second > 0.0


@given(oil=oils, load=loads, radius=radii, speed=speeds)
@settings(deadline=None)
def test_a_contact_hotter_than_the_oils_formulas_has_no_film(oil, load, radius, speed):
    """The pressure-viscosity coefficient falls to nothing at 510 degrees, the density at 1300."""
    films = [film(oil, load, radius, speed, flash=flash) for flash in (300.0, 420.0, 429.0, 431.0, 900.0, 2000.0)]
    assert (np.diff(films[:4]) < 0.0).all() and films[3:] == [0.0, 0.0, 0.0]


@given(oil=oils, stage=st.floats(3.0, 13.0), mean=st.floats(1.0, 150.0), peak=st.floats(1.0, 3.0), more=more)
@settings(deadline=None)
def test_scuffing_is_nearer_with_heat_and_farther_with_the_oils_load_stage(oil, stage, mean, peak, more):
    def safeties(mean, stage, structure=1.0, lubrication="dip"):
        bulk = bulk_temperature_flash(60.0, mean, lubrication)
        by_flash = flash_temperature_safety(
            bulk + peak * mean, scuffing_temperature(oil, 60.0, stage, structure), 60.0
        )
        by_integral = integral_temperature_safety(bulk, mean, scuffing_integral_temperature(oil, stage, structure))
        return np.array([by_flash, by_integral], float)

    here = safeties(mean, stage)
    assert (safeties(more * mean, stage) < here).all()
    assert (safeties(mean, more * stage) > here).all()
    assert (safeties(mean, stage, structure=1.5) > here).all()
    assert (safeties(mean, stage, lubrication="spray") < here).all()
    assert (safeties(mean, stage, lubrication="submerged") > here).all()


surfaces, cores = st.floats(600.0, 850.0), st.floats(250.0, 480.0)


def exposure(surface, core, case, load, radius, factor=1.0):
    width = line_contact_half_width(np.array(load), np.array(1.0 / radius), MODULUS)
    pressure = line_contact_pressure(np.array(load), np.array(1.0 / radius), MODULUS)
    return float(
        material_exposure(pressure, width, FlankMaterial(hardness_of_case(surface, core, case), core, factor))[0]
    )


@given(surface=surfaces, core=cores, case=st.floats(0.2, 4.0), load=loads, radius=radii, more=more)
@settings(deadline=None)
def test_flank_fracture_is_nearer_with_load_and_farther_with_case_and_strength(
    surface, core, case, load, radius, more
):
    here = exposure(surface, core, case, load, radius)
    assert exposure(surface, core, case, more * load, radius) >= here - 1e-9
    assert exposure(surface, core, more * case, load, radius) <= here + 2e-3  # of what a grid of depths leaves
    assert exposure(surface, core, case, load, radius, more) <= here + 1e-9


@given(surface=surfaces, core=cores, case=st.floats(0.2, 4.0), load=loads, radius=radii, scale=st.floats(0.1, 10.0))
@settings(deadline=None)
def test_flank_fracture_in_other_units_of_length(surface, core, case, load, radius, scale):
    here = exposure(surface, core, case, load, radius)
    assert exposure(surface, core, scale * case, scale * load, scale * radius) == pytest.approx(here, rel=1e-9)


@given(surface=surfaces, core=cores, case=st.floats(0.1, 5.0))
@settings(deadline=None)
def test_hardness_falls_and_compression_with_it(surface, core, case):
    depth = np.linspace(0.0, 6.0 * case, 200)
    hardness = hardness_of_case(surface, core, case)(depth)
    assert (np.diff(hardness) <= 0.0).all() and hardness[0] == pytest.approx(surface)
    assert (residual_stress(hardness, core) <= 0.0).all()


@given(pressure=st.floats(1.0, 3000.0), depth=st.floats(1e-3, 50.0), scale=st.floats(0.01, 100.0))
@settings(deadline=None)
def test_stress_is_proportional_to_pressure(pressure, depth, scale):
    stress = line_contact_stress(pressure, depth)
    assert (stress <= 0.0).all()
    assert line_contact_stress(scale * pressure, depth) == pytest.approx(scale * stress)
    assert shear_stress_intensity(scale * stress) == pytest.approx(scale * shear_stress_intensity(stress))
    assert shear_stress_intensity(stress - 500.0) == pytest.approx(shear_stress_intensity(stress), rel=1e-6, abs=1e-6)
