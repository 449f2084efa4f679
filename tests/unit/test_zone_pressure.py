"""Greatest pressure in each zone: as far as the zone's clear border, however roll positions lie to it."""

import numpy as np
import pytest

from semiwear.collect import _Zones
from semiwear.contact import slice_pressure
from semiwear.contact.loads import SlicePressures
from semiwear.results import Zone

SLICES = 9
ZONES = _Zones(np.full(SLICES, -0.4), np.full(SLICES, 0.4))
CLEAR = -0.6  # a quarter of the band below it


def pressures(step: float, shift: float, ripple: float = 0.0, side: float = 1.0) -> SlicePressures:
    """Pressure that rises towards the band and falls by half inside it; `side` -1 has it beyond the band."""
    place = np.arange(-3.0 + shift, 3.0, step)
    value = np.where(place < CLEAR + 0.01, 700.0 + 100.0 * place, 300.0)
    values = np.repeat(value[:, None], SLICES, axis=1)
    if ripple:
        last = np.flatnonzero(place < CLEAR)[-1]
        values[last - 1, 0] -= ripple  # a steep slope in one slice
    return SlicePressures(values, side * np.repeat(place[:, None], SLICES, axis=1), np.zeros_like(values))


@pytest.mark.parametrize(("side", "zone"), [(1.0, Zone.ROOT), (-1.0, Zone.ADDENDUM)])
@pytest.mark.parametrize("shift", np.linspace(0.0, 0.3, 7))
def test_does_not_depend_on_where_roll_positions_lie(shift, side, zone):
    found = ZONES.greatest_clear(pressures(0.3, shift, side=side))
    assert found[zone] == pytest.approx(700.0 + 100.0 * CLEAR, rel=1e-12)


def test_is_the_same_for_a_path_run_the_other_way():
    there = pressures(0.3, 0.1)
    back = SlicePressures(there.inner[::-1], there.place[::-1], there.border[::-1])
    assert ZONES.greatest_clear(there) == ZONES.greatest_clear(back)


def test_ripple_of_one_slice_is_not_carried_on():
    smooth, rippled = (ZONES.greatest_clear(pressures(0.3, 0.05, ripple=ripple)) for ripple in (0.0, 60.0))
    assert rippled == smooth


@pytest.mark.parametrize("rounding", [0.0, 1e-15, -1e-15])
def test_two_positions_at_one_place_tell_no_slope(rounding):
    """Both may lie on an edge: by that slope the pressure at the border would have no limit."""
    pressure = pressures(0.3, 0.05)
    last = np.flatnonzero(pressure.place[:, 0] < CLEAR)[-1]
    pressure.place[last - 1] = pressure.place[last] + rounding
    assert ZONES.greatest_clear(pressure)[Zone.ROOT] == pressure.inner[last, 0]


def test_what_ends_before_the_border_is_not_carried_on():
    pressure = pressures(0.3, 0.05)
    pressure.inner[pressure.place[:, 0] > -1.5] = 0.0
    assert ZONES.greatest_clear(pressure)[Zone.ROOT] == pressure.inner.max()


def test_pressures_in_the_band_are_those_of_positions():
    pressure = pressures(0.3, 0.05)
    inside = np.abs(pressure.place) <= 0.4
    assert ZONES.greatest_clear(pressure)[Zone.PITCH] == pressure.inner[inside].max()
    assert ZONES.greatest_clear(pressure)[Zone.ADDENDUM] == 300.0


@pytest.mark.parametrize(
    ("gaps", "active"), [([5.0, 3.0, 4.0], [1]), ([2.0, 2.0, 7.0], [0]), ([1.2, 1.7, 1.4, 9.0], [0, 2])]
)
def test_cells_that_a_hertz_contact_closes_press_at_first_or_the_nearest(gaps, active):
    """From the least gap of 1 on, 0.5 is closed; gaps are in units of deflection, of 0.1."""
    work, count = slice_pressure._work_space(4), len(gaps)
    work.gap[:count] = gaps
    slice_pressure._open(work, count, 1.0, 0.5, 0.1)
    assert np.flatnonzero(work.active[:count]).tolist() == active
    np.testing.assert_allclose(work.gap[:count], (np.array(gaps) - 1.0) / 0.1, rtol=1e-14)
