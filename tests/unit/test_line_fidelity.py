"""Parts of the fidelity `line`, solvers made up: pressed edges, pressures, and what load sharing is given."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from semiwear.closed_forms.hertz import line_contact_half_width, line_contact_pressure
from semiwear.contact import line_contact
from semiwear.contact.footprint import OF_PRESSED_EDGES, Footprints
from semiwear.contact.line_contact import line_pressures, solve_lines, with_pressed_edges
from semiwear.contact.loads import SlicePressures, TeethLoads
from semiwear.contact.problem import FIRST_CAP
from semiwear.contact.rounded_contact import Rounding
from tests.strategies.lines import straight_lines

MODULUS, USUAL_LOAD, USUAL_WIDTH, APPROACH, LEVER = 115e3, 300.0, 0.2, 4e-3, 30.0
LINES = straight_lines(np.zeros(4), 5, step=2.0, across=0.02, half_height=4.0, lever=LEVER)
FORCE = np.zeros((4, 5))
FORCE[:, :3] = [200.0, 600.0, 1200.0]  # N on slices of 2 mm
LOADS = replace(TeethLoads.none(4, 5, 2), force=FORCE, rotation=np.array([1.0, 1.5]) * APPROACH / LEVER)
NEVER = np.zeros((4, 5), dtype=bool)


def problem(near: np.ndarray = ~NEVER) -> SimpleNamespace:
    """Two tooth pairs at two mesh positions."""
    return SimpleNamespace(
        lines=LINES, modulus=MODULUS, pairs=2, per_cycle=2, usual_load=USUAL_LOAD, usual_half_width=USUAL_WIDTH,
        typical_approach=APPROACH, least_curvature=1e-4, max_iterations=60, is_near=lambda lines: near,
        line_load=lambda loads: loads.force / LINES.length, no_loads=lambda: TeethLoads.none(4, 5, 2),
    )  # fmt: skip


def worn(**changes: np.ndarray) -> Footprints:
    one = np.ones((4, 5))
    removed = SimpleNamespace(varies=NEVER)
    plain = Footprints(removed, 0.0 * one, 0.0 * one, 0.02 * one, 0.2 * one, 0.0 * one, 0.0 * one, 0.0 * one, ~NEVER)  # type: ignore[arg-type]
    return replace(plain, **changes)


@pytest.fixture
def touched(monkeypatch) -> SimpleNamespace:
    """What plane contacts are asked for, and what they answer: a narrow contact in the first slices, a wide one."""
    told = SimpleNamespace(curvature=np.tile([20.0, 20.0, 0.05, 0.05, 20.0], (4, 1)), gap=1e-3, place=0.7)

    def solve(lines, footprints, line_load, modulus, margin, *, smooth=False):
        told.load, told.margin, told.smooth = line_load, margin, smooth
        on = line_load > 0.0
        shape = replace(
            footprints,
            curvature=np.where(on, told.curvature, footprints.curvature),
            gap=np.where(on, told.gap, footprints.gap),
            profile=np.where(on, told.place, footprints.profile),
        )
        exact = SlicePressures(np.full(on.shape, 900.0), np.full(on.shape, told.place), np.full(on.shape, 1500.0))
        return exact, shape

    monkeypatch.setattr(line_contact, "solve_slices", solve)
    return told


CUT = np.ones((4, 5))


def test_edges_that_press_or_pressed_before_are_looked_at_and_no_others(touched):
    """Cut off and nearer than the approach, by the least gap and not by the mean one; or another gap before."""
    cut = CUT.copy()
    cut[:, 1] = 0.0
    least = np.zeros((4, 5))
    least[:, 2] = [1.2 * APPROACH, 1.2 * APPROACH, 0.9 * APPROACH, 1.6 * APPROACH]
    near = ~NEVER
    near[:, 3] = False
    gap = 2.0 * APPROACH - least
    now = worn(cut=cut, least=least, near=near, gap=gap)
    before = replace(now, gap=gap + 1e-6 * (np.arange(5) == 1) * (np.arange(4) == 2)[:, None])
    found = with_pressed_edges(problem(), now, LOADS, before)
    expected = np.zeros((4, 5), dtype=bool)
    expected[:, [0, 4]] = True
    expected[[1, 2], 2] = True  # the approach is that of each mesh position, of both pairs
    expected[2, 1] = True
    np.testing.assert_array_equal(touched.load > 0.0, expected)
    # an edge that hardly touches is taken to bear a little
    np.testing.assert_allclose(touched.load[:, [0, 4]], np.tile([100.0, 0.03 * USUAL_LOAD], (4, 1)))
    assert touched.margin == 0.0 and not touched.smooth
    np.testing.assert_array_equal(found.gap, np.where(expected, 1e-3, gap))
    untouched = with_pressed_edges(problem(NEVER), replace(now, near=None), LOADS, now)
    assert all(np.array_equal(getattr(untouched, name), getattr(now, name)) for name in OF_PRESSED_EDGES)


def test_a_contact_that_is_too_narrow_yields_as_much_more_as_its_approach_says(touched):
    """Approaches are 2 q/(pi E*) (ln(far/b) + const): a wider contact and a spring for ln(wide/b) close as much."""
    now = worn(cut=CUT)
    found = with_pressed_edges(problem(), now, LOADS, now)
    load = touched.load
    own = line_contact_half_width(load, touched.curvature, MODULUS)
    counted = line_contact_half_width(load, found.curvature, MODULUS)
    np.testing.assert_allclose(counted, np.maximum(own, 0.11 * USUAL_WIDTH))
    assert (counted > 1.01 * own).any() and np.isclose(counted, own).any()
    far = 50.0
    closed = 2.0 * load / (np.pi * MODULUS)
    np.testing.assert_allclose(
        closed * np.log(far / own), closed * np.log(far / counted) + found.softer * load * LINES.length
    )
    assert not now.softer.any()


def test_edges_of_other_roll_positions_stay_as_they_were(touched):
    now = worn(cut=CUT)
    before = replace(now, gap=now.gap + 5e-4, profile=now.profile + 0.1, softer=now.softer + 1e-7)
    rolls = np.array([True, False, True, False])
    found = with_pressed_edges(problem(), now, LOADS, before, rolls)
    every = with_pressed_edges(problem(), now, LOADS, before)
    for name in OF_PRESSED_EDGES:
        np.testing.assert_array_equal(getattr(found, name)[rolls], getattr(every, name)[rolls])
        np.testing.assert_array_equal(getattr(found, name)[~rolls], getattr(before, name)[~rolls])


@pytest.mark.parametrize(("cut", "nearer", "part"), [(0.1, 1.0, 0.4), (1.0, 0.02, 0.4), (0.1, 0.02, 0.16), (1, 1, 1)])
def test_edges_come_to_be_felt_by_and_by_where_results_are_to_be_smooth(touched, cut, nearer, part):
    """In part where they cut off less than a quarter of the depth, or lie nearer by less than 5 % of an approach."""
    approach = np.tile(LOADS.rotation, 2)[:, None] * LEVER
    now = worn(cut=cut * CUT, least=approach - nearer * APPROACH * CUT, profile=0.1 * CUT)
    found = with_pressed_edges(problem(), now, LOADS, now, smooth=True)
    whole = with_pressed_edges(problem(), now, LOADS, now)
    for name in OF_PRESSED_EDGES:
        none, all_of_it = getattr(now, name), getattr(whole, name)
        np.testing.assert_allclose(getattr(found, name), (1.0 - part) * none + part * all_of_it, rtol=1e-12)


def test_pressures_are_hertz_s_but_across_worn_slices_and_at_edges(touched):
    """Within the margin by the distance across the line, not by profile coordinates."""
    varies = NEVER.copy()
    varies[:, 1] = True
    profile = np.tile([0.0, 0.0, 3.0, -3.0, 2.0], (4, 1))
    lines = replace(LINES, spacing=0.5 * LINES.spacing)
    cut = np.zeros((4, 5))
    cut[2, 0] = 1.0
    now = replace(worn(cut=cut, profile=profile), removed=SimpleNamespace(varies=varies))
    one = problem()
    one.lines = lines
    loads = replace(LOADS, force=FORCE + 100.0)
    found = line_pressures(one, loads, now, 0.6)
    other = np.tile([False, True, True, True, False], (4, 1))
    other[2, 0] = True
    load = loads.force / LINES.length
    np.testing.assert_array_equal(touched.load, np.where(other, load, 0.0))
    assert touched.margin == 0.6
    hertz = line_contact_pressure(load, now.curvature, MODULUS)
    np.testing.assert_allclose(found.inner, np.where(other, 900.0, hertz))
    np.testing.assert_allclose(found.place, np.where(other, 0.7, profile))
    assert (found.border == 1500.0).all()


# ---------------------------------------------------------------------- load sharing


@pytest.mark.parametrize("stepping", [False, True])
def test_load_sharing_is_given_what_edges_and_the_wear_of_a_step_yield(monkeypatch, stepping):
    """Also at which mesh positions loads are known, of either pair, and over what depth slices come to bear."""
    asked = []

    def position(problem, at, worn, slices, rules, rounding, loads, *, known, stepping):
        asked.append((at, known, stepping))
        np.testing.assert_array_equal(slices.softer, expected)
        assert tuple(rounding) == pytest.approx((0.1 * APPROACH, 0.1 * USUAL_LOAD))
        assert (rules.usual_half_width, rules.tolerance, rules.near.modulus) == (USUAL_WIDTH, 1e-6, MODULUS)
        assert rules.near.average == 2.0 * USUAL_WIDTH

    monkeypatch.setattr(line_contact, "_solve_position", position)
    softer, wears = 1e-7 * np.arange(20.0).reshape(4, 5), np.full((4, 5), 3e-7)
    expected = (softer + wears if stepping else softer).ravel()
    near = ~NEVER
    near[2] = False
    start = TeethLoads.none(4, 5, 2)
    start.force[2, 1] = 50.0  # the second pair at the first mesh position, where no one looked for a footprint
    wear = wears if stepping else None
    now = worn(softer=softer, near=near)
    if stepping:
        found = solve_lines(problem(), now, start, wear, tolerance=1e-6, rounding=0.1)
        assert found is not start and np.array_equal(found.force, start.force)
    else:
        with pytest.raises(line_contact.ConvergenceError, match="mesh position 0/2: load reaches slices"):
            solve_lines(problem(), now, start, wear, tolerance=1e-6, rounding=0.1)
    assert sorted(asked) == [(0, True, stepping), (1, False, stepping)]


@pytest.mark.parametrize(("known", "depth"), [(False, 0.0), (False, 1e-4), (True, 0.0), (True, 1e-4)])
def test_slices_are_let_touch_until_all_that_may_bear_are_among_them(monkeypatch, known, depth):
    """First within the greatest usual approach beyond the nearest gap, or what is known; then as far as was found."""
    asked, gap = [], np.full((4, 5), 7e-3)
    gap[1] = gap[3, 0] = 1e-3
    near = ~NEVER
    near[3, 0] = False
    gap[2, 4] = 2e-3
    first = 1.15 * APPROACH if known else FIRST_CAP * APPROACH + 2e-3  # of rolls 0 and 2
    one = problem(near)
    one.rolls_of = lambda position: np.array([position, position + 2])
    one.longest_lever, one.torque = np.full(2, LEVER), np.full(2, 1e5)
    one.candidates = lambda position, reached: asked.append(reached) or SimpleNamespace(cap=reached)
    found = (line_contact.LineStatus.CONVERGED, first / LEVER, 7, 0.0, 1e-9, 1e-8)
    monkeypatch.setattr(line_contact, "share_torque", lambda *_: found)
    loads = LOADS.copy()
    rounding = Rounding(depth, 1.0) if depth else None
    line_contact._solve_position(
        one, 0, worn(gap=gap), None, None, rounding, loads, known=known, stepping=False  # type: ignore[arg-type]
    )  # fmt: skip
    assert asked == pytest.approx([first, first + depth] if depth else [first])
    assert loads.rotation[0] == first / LEVER and loads.iterations[0] == 7
    assert (loads.balance[0], loads.complementarity[0]) == (1e-9, 1e-8)
