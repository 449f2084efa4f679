"""The driving flank is read at its own face coordinate: beside the station of the driven slice that meets it."""

from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import semiwear as sw
from semiwear import collect
from semiwear.contact.running_in import RunningIn
from semiwear.contact.worn_depth import worn_depth
from semiwear.meshing.driving_flank import PassedStations
from semiwear.meshing.flank_grid import at_points
from semiwear.plan import plan
from semiwear.ratings.contact import RatedContact, RatedFlanks
from semiwear.wear.swept_line import fresh_sweep
from tests.scenes import SMALL

_BOTH = {"wear.worn_bodies": ["pinion", "gear"], "numerics.tooth_compliance": "rigid"}
_SPUR = _BOTH | {"numerics.face_slices": 11, "numerics.roll_positions": 8}
_HELICAL = _SPUR | {"gear_pair.centre_distance_mm": None, "gear_pair.helix_angle_deg": 20.0}
_SHIFT = {"effects.misalignment": {"axial_pinion_mm": 2.0}}
_CASES = {
    "face gear": ("face_gear_25x160", SMALL | _BOTH),
    "face gear, displaced": (
        "face_gear_25x160",
        SMALL | _BOTH | {"effects.misalignment": {"offset_mm": 0.3, "axial_pinion_mm": -0.5}},
    ),
    "spur": ("spur_fzg_c", _SPUR),
    "helical": ("spur_fzg_c", _HELICAL),
    "spur, shifted": ("spur_fzg_c", _SPUR | _SHIFT),
    "helical, shifted": ("spur_fzg_c", _HELICAL | _SHIFT),
}
_IN_PLACE = "spur", "helical"
CASES = pytest.mark.parametrize("case", _CASES)
BESIDE = pytest.mark.parametrize("case", [name for name in _CASES if name not in _IN_PLACE])


@lru_cache
def loaded(case):
    """Teeth, and a state of them whose driving wear is linear along the face."""
    scene, changes = _CASES[case]
    teeth = plan(sw.load_scene(scene).replace(changes)).loaded_teeth()
    driven, face = np.full(teeth.grid.profile.shape, 1e-3), teeth.grid.face
    driving = np.array(np.broadcast_to(2e-3 + 5e-5 * face[:, None], driven.shape))
    return SimpleNamespace(teeth=teeth, state=teeth.load(driven, None, driving))


def inside(teeth):
    """Slices that meet the driving flank between its first and last station."""
    met, face = teeth.lines.driving_face, teeth.grid.face
    return (met >= face[0]) & (met <= face[-1])


def rated(case):
    found = loaded(case)
    return RatedContact(found.teeth, found.state, 1.0, RatedFlanks.of(found.teeth), lambda _: None)


@CASES
def test_wear_that_is_linear_along_the_driving_face_is_read_exactly(case):
    found = loaded(case)
    lines, touched = found.teeth.lines, found.state.coarse.profile
    depth = worn_depth(found.teeth, found.state, touched)
    np.testing.assert_allclose(depth[1], 1e-3, rtol=1e-12)
    # beyond the stations the last one holds
    met = np.clip(lines.driving_face, found.teeth.grid.face[0], found.teeth.grid.face[-1])
    np.testing.assert_allclose(depth[0], 2e-3 + 5e-5 * met, rtol=1e-12)


@CASES
def test_the_gap_reads_the_same_wear(case):
    """What the gap has more than without wear of the driving flank, where slices can touch."""
    found = loaded(case)
    teeth, state = found.teeth, found.state
    step, near = teeth.rolls.substeps, teeth.driving.near
    worn, driven = (teeth.removed(state.wear, wear) for wear in (state.driving_wear, 0.0 * state.driving_wear))
    more = (worn.depth - driven.depth)[::step]
    ours = worn_depth(teeth, state, state.coarse.profile)[0]
    for node in (0, more.shape[2] // 2):
        np.testing.assert_allclose(more[..., node][near[::step]], ours[near[::step]], rtol=1e-11)


@BESIDE
def test_roughness_is_that_of_the_driving_flank_where_it_is_met(case):
    found, law = loaded(case), RunningIn(0.9, 1e-2)
    lines, touched, within = found.teeth.lines, found.state.coarse.profile, inside(found.teeth)
    theirs = law.remaining(2e-3 + 5e-5 * lines.driving_face)
    ratio = law.of_both(found.teeth, found.state, touched)
    np.testing.assert_allclose(ratio[within], (0.5 * (theirs + law.remaining(1e-3)))[within], rtol=1e-12)
    at_stations = 0.5 * (law.remaining(2e-3 + 5e-5 * lines.face) + law.remaining(1e-3))
    assert np.abs(ratio / at_stations - 1.0).max() > 1e-4


@CASES
def test_values_that_are_linear_along_the_driving_face_stand_at_its_stations(case):
    """Away from the ends of the contact lines, where the worst value of each line stands."""
    contact = rated(case)
    teeth, flanks = contact.teeth, contact.flanks
    values = 100.0 + 7.0 * teeth.lines.driving_face
    found = contact.on_flanks(values)
    assert np.nanmax(found[0]) == values[contact.rated].max()
    inner = np.isfinite(found[0])
    ends = np.sort(teeth.lines.driving_face[contact.rated])[[0, -1]]
    slice_width = flanks.face[1] - flanks.face[0]
    inner &= ((flanks.face > ends[0] + slice_width) & (flanks.face < ends[1] - slice_width))[:, None]
    assert inner.any(axis=1).sum() >= 4
    where = np.broadcast_to(flanks.face[:, None], inner.shape)[inner]
    expected = 100.0 + 7.0 * where
    off = np.abs(found[0][inner] - expected)
    # lines end elsewhere at every roll position: there the last slice stands for what it covers
    assert np.median(off) < 1e-9 and off.max() <= 7.0 * slice_width
    np.testing.assert_array_equal(contact.on_flanks(contact.pressures.inner)[1], plainly(contact)[1])


def plainly(contact):
    """Pressures as on flanks whose stations are those of the slices, both of them."""
    profile, on, pressure = contact.flanks.profile, contact.rated, contact.pressures.inner
    found = np.full(profile.shape, np.nan)
    for body in range(2):
        for i in np.flatnonzero(on.any(axis=0)):
            place = contact.places[body, on[:, i], i]
            order = np.argsort(place)
            passed = (profile[body, i] >= place[order[0]]) & (profile[body, i] <= place[order[-1]])
            values = pressure[on[:, i], i]
            found[body, i, passed] = np.interp(profile[body, i, passed], place[order], values[order])
            nearest = np.searchsorted(0.5 * (profile[body, i, 1:] + profile[body, i, :-1]), place)
            np.fmax.at(found[body, i], nearest, values)
    return found


@pytest.mark.parametrize("case", _IN_PLACE)
def test_cylindrical_pairs_in_place_are_read_at_their_stations(case):
    contact = rated(case)
    np.testing.assert_array_equal(contact.on_flanks(contact.pressures.inner), plainly(contact))


@BESIDE
@pytest.mark.parametrize("worst", [np.fmax, np.fmin])
def test_no_extreme_is_lost_beside_stations(case, worst):
    contact = rated(case)
    pressure = contact.pressures.inner
    found = contact.on_flanks(pressure, worst=worst)
    for body in range(2):
        assert worst.reduce(found[body], axis=None) == worst.reduce(pressure[contact.rated])


def test_a_shifted_pinion_is_rated_where_it_bears():
    """Moved 2 mm along its axis, it bears on the stretch of its face that the gear covers."""
    contact = rated("spur, shifted")
    bears = np.isfinite(contact.on_flanks(contact.pressures.inner)).any(axis=2)
    face = contact.flanks.face
    middle = [face[on].mean() for on in bears]
    moved = (contact.teeth.lines.driving_face - contact.teeth.lines.face).mean()
    assert abs(moved) == pytest.approx(2.0)
    assert middle[0] - middle[1] == pytest.approx(moved, abs=0.5 * (face[1] - face[0]))


@pytest.mark.parametrize("case", ["face gear", "spur, shifted", "helical, shifted"])
def test_active_nodes_of_the_driving_flank_are_those_that_the_path_of_contact_crosses(case):
    teeth = loaded(case).teeth
    told = collect.flank(teeth, fresh_sweep(teeth.pair, teeth.lines))
    met = teeth.lines.driving_face[teeth.on_path]
    active, face = (told["active"][0] > 0).any(axis=0), teeth.grid.face
    width = face[1] - face[0]
    assert not active[(face < met.min() - 0.51 * width) | (face > met.max() + 0.51 * width)].any()
    assert active[(face > met.min()) & (face < met.max())].all()


@pytest.mark.parametrize("shift", [2.0, -4.0])
def test_a_control_point_of_a_shifted_pinion_wears_to_its_depths(shift):
    """Slices that pass the point are found, however far beside its station they lie."""
    changes = {
        "gear_pair.pinion_face_width_mm": 24.0,
        "numerics.face_slices": 31,
        "numerics.roll_positions": 8,
        "numerics.tooth_compliance": "rigid",
        "effects.misalignment": {"axial_pinion_mm": shift},
        "wear.until.meshes": None,
        "wear.until.control_depths_um": [1.0, 2.0],
        "wear.control_point": {"face_mm": 2.0, "height_mm": -1.5, "body": "pinion"},
    }
    flank = sw.simulate(sw.load_scene("spur_fzg_c").replace(changes))["flank"].sel(body="pinion")
    wear, height = flank.wear_depth.values, flank.flank_height.values
    at_height = [[np.interp(-1.5, height[:, i], w[:, i]) for i in range(height.shape[1])] for w in wear]
    found = [np.interp(2.0, flank["face"].values, depth) for depth in at_height]
    np.testing.assert_allclose(found, [0.0, 1.0, 2.0], rtol=1e-3)


@st.composite
def slices_and_stations(draw):
    """Face coordinates that slices meet, growing or falling, and even stations."""
    count = draw(st.integers(3, 12))
    widths = draw(st.lists(st.floats(0.5, 2.0), min_size=count - 1, max_size=count - 1))
    met = draw(st.floats(-3.0, 3.0)) + np.concatenate([[0.0], np.cumsum(widths)])
    stations = np.linspace(-2.0, 10.0, draw(st.integers(2, 15)))
    return (met if draw(st.booleans()) else met[::-1]), stations


@given(slices_and_stations(), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_slices_are_read_linearly_between_and_held_half_a_slice_beyond(where, offset, slope):
    met, stations = where
    found = PassedStations.of(met[None], stations)
    values, all_of_them = (offset + slope * met)[None], np.ones((1, met.size), dtype=bool)
    expected = offset + slope * np.clip(stations, met.min(), met.max())
    np.testing.assert_allclose(found.read(values)[0], expected, atol=1e-12)
    np.testing.assert_allclose(found.read_within(values, all_of_them)[0], expected, atol=1e-12)
    between = (stations >= met.min()) & (stations <= met.max())
    assert found.within(all_of_them)[0][between].all()
    assert not found.within(~all_of_them).any()
    # a slice alone stands for the stations within its width
    one = np.zeros_like(all_of_them)
    one[0, 1] = True
    within = found.within(one)[0]
    borders = np.sort([0.5 * (met[0] + met[1]), 0.5 * (met[1] + met[2])])
    clear = np.abs(stations[:, None] - borders).min(axis=1) > 1e-9
    np.testing.assert_array_equal(within[clear], ((stations > borders[0]) & (stations < borders[1]))[clear])
    assert (found.read_within(values, one)[0][within] == values[0, 1]).all()


@given(st.integers(3, 9), st.floats(-4.0, 4.0), st.floats(-4.0, 4.0), st.floats(-4.0, 4.0))
def test_points_of_a_flank_are_read_linearly(count, offset, along, up):
    stations = np.linspace(-3.0, 5.0, count)
    nodes = np.array([np.linspace(0.0, 4.0 + 0.1 * k, 6) for k in range(count)])
    values = offset + along * stations[:, None] + up * nodes
    face, places = np.meshgrid(np.linspace(-3.0, 5.0, 17), np.linspace(0.0, 4.0, 7))
    found = at_points(stations, nodes, values, face, places)
    np.testing.assert_allclose(found, offset + along * face + up * places, atol=1e-12)
    held = at_points(stations, nodes, values, np.array([-9.0, 9.0]), np.array([1.0, 1.0]))
    np.testing.assert_allclose(held, offset + up + along * stations[[0, -1]], atol=1e-12)
