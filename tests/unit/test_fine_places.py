"""Where footprints lie between solved roll positions: found where their way bends, even elsewhere."""

from dataclasses import replace

import numpy as np
import pytest

import semiwear as sw
from semiwear.arrays import FloatArray
from semiwear.contact import loaded_teeth
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.plan import plan
from tests.scenes import TINY


@pytest.fixture(scope="module", params=[["gear"], ["pinion", "gear"]])
def case(request: pytest.FixtureRequest) -> tuple[LoadedTeeth, FloatArray, FloatArray | None]:
    """Teeth and the depths of grooves on either side of a ridge, on one flank or both."""
    teeth = plan(sw.load_scene("face_gear_25x160").replace(TINY | {"wear.worn_bodies": request.param})).loaded_teeth()
    grids = [teeth.grid] if teeth.driving is None else [teeth.grid, teeth.driving.grid]
    depths = [0.04 * (1.0 - np.exp(-0.5 * (grid.profile / 0.6) ** 2)) for grid in grids]
    return teeth, depths[0], None if len(depths) == 1 else depths[1]


def half_widths_off(teeth: LoadedTeeth, wear: FloatArray, driving: FloatArray | None) -> FloatArray:
    """How far from the footprints that are found everywhere, (roll, face); zero where none are."""
    exact = teeth.touch(wear, driving)
    assert exact.near is not None
    apart = teeth.fine_places(wear, driving, teeth.touch_solved(wear, driving)) - exact.profile
    return np.where(exact.near, np.abs(apart) * teeth.fine.spacing / teeth.half_width, 0.0)


def test_places_between_are_those_of_the_footprints(case) -> None:
    teeth, wear, driving = case
    off = half_widths_off(teeth, wear, driving)
    assert 1e-5 < off.max() < 0.01
    assert off[:: teeth.rolls.substeps].max() < 1e-9


def test_footprints_are_found_where_their_way_bends(case, monkeypatch) -> None:
    """Fresh ones go on evenly; an even way over these grooves would be a part of a half-width off."""
    teeth, wear, driving = case
    found: list[int] = []
    touch = LoadedTeeth._touch

    def counted(self, lines, step, worn, other, chosen):
        if chosen is not None:
            found.append(int(chosen.sum()))
        return touch(self, lines, step, worn, other, chosen)

    monkeypatch.setattr(LoadedTeeth, "_touch", counted)
    fresh = 0.0 * wear, None if driving is None else 0.0 * driving
    assert half_widths_off(teeth, *fresh).max() < 0.01
    half_widths_off(teeth, wear, driving)
    assert found[0] < 0.7 * found[1]  # those that an end of the flank cuts off
    monkeypatch.setattr(loaded_teeth, "_BENDS", np.inf)
    assert half_widths_off(teeth, wear, driving).max() > 0.05


def test_smooth_results_have_footprints_everywhere(case) -> None:
    """What is found here and even there would jump from one to the other."""
    teeth, wear, driving = case
    smooth = replace(teeth, smooth=True)
    assert half_widths_off(smooth, wear, driving).max() < 1e-9


def test_chosen_footprints_are_those_that_are_found_with_all(case) -> None:
    """Where both flanks wear, nothing is read beyond them."""
    teeth, wear, driving = case
    every = teeth.touch_solved(wear, driving)
    assert every.near is not None
    chosen = np.random.default_rng(1).random(every.gap.shape) < 0.3
    some = teeth.touch_solved(wear, driving, chosen)
    found, left = chosen & every.near, ~chosen & np.isfinite(teeth.lines.separation[0])
    assert 20 < found.sum() < 0.4 * every.near.sum()
    for name in ("profile", "gap", "curvature", "half_width", "least", "cut"):
        one, other = getattr(some, name), getattr(every, name)
        np.testing.assert_allclose(one[found], other[found], rtol=1e-9, atol=1e-12)
        assert np.isfinite(one[left]).all()
    np.testing.assert_array_equal(some.profile[~chosen], teeth.lines.profile[~chosen])
