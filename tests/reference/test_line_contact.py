"""Loaded line contact against Hertz, against numerical integrals and against brute force."""

import dataclasses
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq, nnls

import semiwear as sw
from semiwear.closed_forms.hertz import (
    effective_modulus,
    elliptic_contact,
    line_contact_half_width,
    line_contact_pressure,
)
from semiwear.closed_forms.stripe import stripe_kernel, stripe_table
from semiwear.compliance.elastic_teeth import line_compliance
from semiwear.contact import line_contact
from semiwear.contact.active_set import ActiveSetStatus, solve_active_set
from semiwear.contact.footprint import Footprints
from semiwear.contact.line_contact import LINE
from semiwear.contact.line_solver import LineStatus
from semiwear.contact.stripe import add_pairs, near_pairs, near_stripe, pairs_among, subtract_mid_surface
from semiwear.meshing.removed import Removed
from semiwear.plan import plan
from semiwear.results.missing import away_from_edges
from tests.scenes import TINY, one_rigid_tooth, scene_of

STEEL = effective_modulus(207000.0, 0.3, 207000.0, 0.3)
TOOTH_LOAD = 1.6e6 / (0.5 * 6.35 * 25 * np.cos(np.radians(25.0)))  # N, 1600 N m on one tooth


# ---------------------------------------------------------------- closed forms


def test_hertz_of_spheres():
    load, radius, modulus = 321.0, 17.0, 115e3
    contact = elliptic_contact(load, 1.0 / radius, 1.0 / radius, modulus)
    a = (0.75 * load * radius / modulus) ** (1.0 / 3.0)
    assert contact.major_half_axis == pytest.approx(a, rel=1e-9)
    assert contact.minor_half_axis == pytest.approx(a, rel=1e-9)
    assert contact.peak_pressure == pytest.approx(1.5 * load / (np.pi * a**2), rel=1e-9)
    assert contact.approach == pytest.approx(a**2 / radius, rel=1e-9)


def test_hertz_nearly_of_spheres_is_continuous():
    round_ = elliptic_contact(100.0, 0.05, 0.05, 1e5)
    for excess in (1e-10, 1e-8, 1e-6):
        contact = elliptic_contact(100.0, 0.05, 0.05 * (1.0 + excess), 1e5)
        assert contact.major_half_axis == pytest.approx(round_.major_half_axis, rel=2.0 * excess + 1e-7)
        assert contact.peak_pressure == pytest.approx(round_.peak_pressure, rel=2.0 * excess + 1e-7)


@pytest.mark.parametrize("order", [1, -1])
def test_hertz_of_a_long_ellipse(order):
    contact = elliptic_contact(5000.0, *(1.0 / 20.0, 1.0 / 2000.0)[::order], 115e3)
    assert contact.major_half_axis == pytest.approx(6.49113, rel=2e-6)
    assert contact.minor_half_axis == pytest.approx(0.35691, rel=2e-5)
    assert contact.peak_pressure == pytest.approx(1030.47, rel=1e-5)
    assert contact.approach == pytest.approx(0.013718, rel=4e-5)


@pytest.mark.parametrize("ratio", [1.0, 3.0, 50.0, 900.0])
def test_hertz_pressure_makes_the_gap_vanish(ratio):
    """The half-space moves by approach less the gap, at the middle and on both half-axes."""
    modulus, load, curvature = 115e3, 5000.0, (0.05 / ratio, 0.05)
    contact = elliptic_contact(load, *curvature, modulus)
    a, b, p0 = contact.major_half_axis, contact.minor_half_axis, contact.peak_pressure
    for x, y in ((0.0, 0.0), (0.7 * a, 0.0), (0.0, 0.6 * b)):

        def integrand(angle, x=x, y=y):
            # along a chord through (x, y) the pressure is a semi-ellipse; every chord is met from two sides
            u, v = np.cos(angle), np.sin(angle)
            A = (u / a) ** 2 + (v / b) ** 2
            B = x * u / a**2 + y * v / b**2
            C = 1.0 - (x / a) ** 2 - (y / b) ** 2
            return 0.5 * np.pi * (C + B**2 / A) / np.sqrt(A) / 2.0

        total = quad(integrand, 0.0, 2.0 * np.pi, points=[0.5 * np.pi, np.pi, 1.5 * np.pi], limit=400)[0]
        moved = p0 / (np.pi * modulus) * total
        gap = 0.5 * (curvature[0] * x**2 + curvature[1] * y**2)
        assert moved == pytest.approx(contact.approach - gap, rel=1e-6)


def test_hertz_of_a_line():
    line_load, radius = 420.0, 33.0
    b = line_contact_half_width(np.array(line_load), np.array(1.0 / radius), STEEL)
    p0 = line_contact_pressure(np.array(line_load), np.array(1.0 / radius), STEEL)
    assert b**2 == pytest.approx(4.0 * line_load * radius / (np.pi * STEEL), rel=1e-12)
    assert p0 * b * np.pi / 2.0 == pytest.approx(line_load, rel=1e-12)  # the semi-ellipse carries the load


# ---------------------------------------------------------------- the stripe kernel


@pytest.mark.parametrize("distance", [1e-3, 0.02, 0.3, 1.0, 4.0, 30.0, 800.0])
def test_stripe_kernel_is_the_integral_over_the_stripe(distance):
    def across(angle):
        return 2.0 / np.pi * np.cos(angle) ** 2 / np.hypot(np.sin(angle), distance)

    narrow = min(10.0 * distance, 1.0)
    expected = 2.0 * (
        quad(across, 0.0, narrow, limit=400, epsabs=1e-13)[0]
        + quad(across, narrow, 0.5 * np.pi, limit=400, epsabs=1e-13)[0]
    )
    assert float(stripe_kernel(np.array(distance))) == pytest.approx(expected, rel=1e-9)


def test_stripe_kernel_far_away_is_a_point_load():
    distance = np.array([50.0, 300.0, 2000.0])
    np.testing.assert_allclose(stripe_kernel(distance) * distance, 1.0, atol=0.15 / 50.0**2)
    # its next term is 1/(8 s^2), which is lost in rounding from some 1e7 on
    far = np.array([1e3, 1e5, 1e8, 1e100])
    np.testing.assert_allclose(stripe_kernel(far) * far, 1.0 - 0.125 / far**2, rtol=1e-12)
    assert stripe_kernel(np.array([np.inf, -np.inf])).tolist() == [0.0, 0.0]


def self_compliance(length: float, half_width: float) -> float:
    matrix = np.zeros((1, 1))
    pairs = near_pairs(np.array([0, 1]), np.zeros(1), np.array([length]), np.inf)
    add_pairs(matrix, pairs, near_stripe(pairs, np.array([half_width]), 1.0 / (np.pi * STEEL), stripe_table()))
    return float(matrix[0, 0])


@pytest.mark.parametrize("length_over_width", [0.01, 0.1, 1.0, 7.0, 100.0])
def test_self_compliance_of_a_slice_is_the_kernel_integrated(length_over_width):
    half_width = 0.4
    length = length_over_width * half_width
    t = 0.5 * length_over_width
    expected = quad(lambda u: float(stripe_kernel(np.array(t * u**2))) * 2.0 * t * u, 0.0, 1.0, limit=200)[0]
    found = self_compliance(length, half_width) * np.pi * STEEL * length / 2.0
    assert found == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("length_over_width", [50.0, 400.0, 4000.0])
def test_stripe_in_the_plane_limit_is_the_hertz_approach(length_over_width):
    half_width = 0.5
    half_length = length_over_width * half_width
    found = self_compliance(2.0 * half_length, half_width) * 2.0 * half_length * np.pi * STEEL
    assert found == pytest.approx(2.0 * np.log(4.0 * length_over_width) + 1.0, abs=1.0 / length_over_width**2 + 1e-6)


def test_compliance_between_slices_is_the_kernel_integrated():
    arc, half_width = np.array([0.0, 0.9, 4.0, 20.0]), np.full(4, 0.5)
    length = np.full(4, 0.7)
    matrix = np.zeros((4, 4))
    pairs = near_pairs(np.array([0, 4]), arc, length, np.inf)
    add_pairs(matrix, pairs, near_stripe(pairs, half_width, 1.0 / (np.pi * STEEL), stripe_table()))
    for i, j in combinations(range(4), 2):
        expected = quad(
            lambda s, i=i, j=j: float(stripe_kernel(np.array(abs(arc[j] - arc[i] + s) / 0.5))) / 0.5, -0.35, 0.35
        )[0]
        assert matrix[i, j] == matrix[j, i]
        assert matrix[i, j] == pytest.approx(expected / (np.pi * STEEL * 0.7), rel=1e-5)


@given(st.data())
def test_near_pairs_of_some_slices_are_those_of_all_among_them(data):
    count = data.draw(st.integers(1, 12))
    starts = np.array([0, data.draw(st.integers(0, count)), count])
    steps = np.array(data.draw(st.lists(st.floats(0.1, 2.0), min_size=count, max_size=count)))
    arc, length = np.cumsum(steps), 0.1 + steps
    arc[starts[1] :] -= 0.5 * arc[-1]  # lines lie beside each other
    chosen = np.flatnonzero(data.draw(st.lists(st.booleans(), min_size=count, max_size=count)))
    some = pairs_among(near_pairs(starts, arc, length, 1.7), chosen, count)
    alone = near_pairs(np.searchsorted(chosen, starts), arc[chosen], length[chosen], 1.7)
    for found, expected in zip(some, alone, strict=True):
        np.testing.assert_array_equal(found, expected)


@given(st.integers(1, 9), st.integers(1, 9), st.integers(0, 4))
def test_slices_at_just_the_near_distance_are_near(one, other, steps):
    """Even lines of a quarter of a millimetre a slice, whose distances are exact."""
    starts, arc = np.array([0, one, one + other]), 0.25 * np.concatenate([np.arange(one), np.arange(other)])
    found = near_pairs(starts, arc, np.full(arc.size, 0.25), 0.25 * steps)
    expected = [
        (i, j)
        for first, stop in ((0, one), (one, one + other))
        for i in range(first, stop)
        for j in range(i, min(i + steps + 1, stop))
    ]
    assert list(zip(found.first.tolist(), found.second.tolist(), strict=True)) == expected
    assert all(part.size == len(expected) for part in found)


def test_slices_that_need_not_be_looked_at_change_no_loads(small, monkeypatch):
    def forces(room):
        monkeypatch.setattr("semiwear.contact.problem._ROOM", room)
        teeth = plan(small).loaded_teeth()
        found = teeth.load(np.zeros(teeth.grid.profile.shape)).loads.force
        return found, sum(known.flat.size for known in teeth.problem._kept.values())

    (few, looked_at), (many, more) = forces(1.0), forces(6.0)
    assert more > looked_at
    np.testing.assert_allclose(many, few, rtol=1e-6, atol=1e-8 * few.max())


# ---------------------------------------------------------------- one rigid tooth is a Hertz ellipse


SLICES = [40, 61, 121, 400, 2000]


@pytest.fixture(scope="module")
def at_pitch_point(shipped):
    """Engagement at roll position 0, by the number of slices; a second position goes along."""
    return {
        slices: sw.loaded_contact(one_rigid_tooth(shipped, slices), roll_positions=[0.0, 0.25])["engagement"]
        .isel(wear_step=0)
        .sel(roll_position=0.0)
        for slices in SLICES
    }


@pytest.mark.slow
@pytest.mark.parametrize("slices", SLICES)
def test_one_tooth_is_a_hertz_contact_that_carries_the_torque(at_pitch_point, slices):
    contact = at_pitch_point[slices]
    assert contact.contact_pressure_max.item() == pytest.approx(910.0, rel=0.01)
    half_width = 2.0 * contact.line_load.max().item() / (np.pi * contact.contact_pressure_max.item())
    assert half_width == pytest.approx(0.525, rel=0.01)
    assert contact.load_share.item() == pytest.approx(1.0, abs=1e-12)
    # slices are equal in gear radius; along the line, about 8.08 degrees off that direction, they are longer
    total = contact.line_load.sum().item() * 80.0 / slices / np.cos(np.radians(8.08))
    assert total == pytest.approx(TOOTH_LOAD, rel=0.01)


# the curvature across the real line falls from 0.038 to 0.025 1/mm along it, which makes the contact lopsided and its
# half-length 22.30 mm; slices coarser than 0.1 mm do not resolve that
@pytest.mark.parametrize("slices", [slices for slices in SLICES if slices <= 400])
def test_half_length_of_one_tooth(shipped, slices):
    teeth = plan(one_rigid_tooth(shipped, slices)).loaded_teeth(None, np.array([0.0, 0.25]))
    force = teeth.load(np.zeros(teeth.grid.profile.shape)).loads.force[0]
    assert teeth.lines.roll[0] == 0.0
    half_length = 0.5 * teeth.lines.length[0][force > 0.0].sum()
    assert half_length == pytest.approx(22.2, abs=80.0 / slices)


@pytest.mark.slow
@pytest.mark.parametrize("slices", SLICES)
def test_a_line_of_even_curvature_is_the_hertz_ellipse(shipped, slices):
    """The curvatures of the pitch point all along the line: then the ellipse is exact, however fine the slices."""
    teeth = plan(one_rigid_tooth(shipped, slices)).loaded_teeth(None, np.array([0.0, 0.25]))
    across, along, step = 3.041e-2, 7.032e-5, 80.0 / slices
    one = np.ones((2, slices))
    arc = step * (np.arange(slices) + 0.5) * one
    separation = np.zeros((5, 2, slices))
    separation[0], separation[2] = 0.5 * along * (arc - 40.0) ** 2, across
    lines = dataclasses.replace(
        teeth.lines, profile=0.0 * one, separation=separation, spacing=one, length=step * one, arc=arc
    )
    problem = teeth.problem.on_lines(lines)
    fresh = Removed.met(teeth.grid, np.zeros((1, slices, 2)), 2)
    worn = Footprints(fresh, 0.0 * one, separation[0], across * one, 0.5 * one, 0.0 * one, separation[0], 0.0 * one)
    loads = LINE.solve(problem, worn)
    hertz = elliptic_contact(TOOTH_LOAD, along, across, problem.modulus)
    assert 0.5 * step * np.sum(loads.force[0] > 0.0) == pytest.approx(hertz.major_half_axis, abs=step)
    assert loads.half_width[0].max() == pytest.approx(hertz.minor_half_axis, rel=0.002)
    assert LINE.pressures(problem, loads, worn, 0.0).inner[0].max() == pytest.approx(hertz.peak_pressure, rel=0.002)
    assert problem.approach(loads)[0] == pytest.approx(hertz.approach, rel=0.002)


@pytest.mark.slow
def test_a_single_roll_position_is_enough(shipped, at_pitch_point):
    alone = sw.loaded_contact(one_rigid_tooth(shipped, 61), roll_positions=[0.0])["engagement"]
    expected = at_pitch_point[61].contact_pressure_max.item()
    assert alone.contact_pressure_max.item() == pytest.approx(expected, rel=1e-9)


def test_approach_of_one_tooth(shipped):
    """Rigid teeth approach as two half-spaces do: 21.56 um along the line of action."""
    tree = sw.loaded_contact(one_rigid_tooth(shipped, 121), roll_positions=[0.0, 0.25])
    approach = elliptic_contact(TOOTH_LOAD, 7.032e-5, 3.041e-2, STEEL).approach
    base_radius = 0.5 * 6.35 * 25 * np.cos(np.radians(25.0))
    expected = -approach / base_radius * 25 / 160 * np.degrees(1.0) * 3600.0
    error = tree["mesh_cycle"].transmission_error_loaded.sel(mesh_position=0.0).item()
    assert error == pytest.approx(expected, rel=0.01)


# ---------------------------------------------------------------- equations of the loaded teeth


@pytest.mark.slow
def test_residuals_fresh_and_worn(worn):
    diagnostics = worn["diagnostics"]
    assert diagnostics.load_balance_residual.sizes == {"wear_step": 13}
    assert float(diagnostics.load_balance_residual.max()) < 1e-9
    assert float(diagnostics.complementarity_residual.max()) < 1e-6


@pytest.mark.slow
def test_load_shares_sum_to_one(worn):
    share = worn["engagement"].load_share
    phase = np.round(np.mod(share.roll_position.values, 1.0), 9) % 1.0
    positions = np.unique(phase)
    assert positions.size == worn["mesh_cycle"].sizes["mesh_position"]
    for position in positions:
        total = share.values[:, phase == position].sum(axis=1)
        np.testing.assert_allclose(total, 1.0, atol=1e-9)


class Assembled:
    """Equations of one mesh position, put together anew from the public pieces, without the solver's shortcuts."""

    def __init__(self, teeth, state, position):
        problem, lines = teeth.problem, teeth.lines
        rolls = np.arange(teeth.rolls.pairs) * teeth.rolls.phase.size + position
        pair, face = np.nonzero(problem.is_near(lines)[rolls])
        at = (rolls[pair], face)
        starts = np.searchsorted(pair, np.arange(teeth.rolls.pairs + 1))
        self.force = state.loads.force[at]
        self.gap = state.coarse.gap[at]
        self.lever = lines.lever_arm[at]
        self.rotation = state.loads.rotation[position]
        tooth, slope = line_compliance(problem.bodies, rolls[pair], face, pair)
        # footprints that an edge cuts off lie aside from the valley
        moved = slope * (state.coarse.profile - lines.profile)[at][:, None]
        self.tooth = tooth + moved + moved.T
        self.matrix = self.tooth + np.diag(state.coarse.softer[at])
        width = np.where(self.force > 0.0, state.loads.half_width[at], 0.3)
        factor = 1.0 / (np.pi * problem.modulus)
        bodies = [on_lines.body for on_lines in problem.bodies]
        subtract_mid_surface(
            self.matrix, starts, lines.arc[at], lines.length[at],
            np.stack([on_lines.depth[at] for on_lines in problem.bodies]),
            np.array([(1.0 + b.poissons_ratio) / (2.0 * np.pi * b.youngs_modulus) for b in bodies]),
            np.array([b.poissons_ratio for b in bodies]),
        )  # fmt: skip
        pairs = near_pairs(starts, lines.arc[at], lines.length[at], np.inf)
        add_pairs(self.matrix, pairs, near_stripe(pairs, width, factor, stripe_table()))


def test_slices_that_yield_by_wear_far_more_than_by_strain_share_as_springs():
    """A compliance c of wear, a thousand times what a slice yields by strain: c F = lever rotation - gap."""
    teeth = plan(sw.load_scene("spur_fzg_c").replace(TINY)).loaded_teeth()
    worn = teeth.touch_solved(np.zeros(teeth.grid.profile.shape))
    problem = teeth.problem
    usual = 1e3 * problem.typical_approach / (problem.usual_load * problem.lines.length.mean())
    loads = LINE.solve(problem, worn, None, np.full(problem.lines.profile.shape, usual))
    rotation = np.tile(loads.rotation, problem.pairs)[:, None]
    spring = np.maximum(problem.lines.lever_arm * rotation - worn.gap, 0.0) / usual
    np.testing.assert_allclose(loads.force, spring, rtol=0.0, atol=0.01 * spring.max())


@pytest.fixture(scope="module")
def fresh_teeth(shipped):
    teeth = plan(shipped).loaded_teeth()
    return teeth, teeth.load(np.zeros(teeth.grid.profile.shape))


@pytest.mark.slow
@pytest.mark.parametrize("position", [0, 7, 15])
def test_equations_hold_when_put_together_anew(fresh_teeth, position):
    teeth, state = fresh_teeth
    equations = Assembled(teeth, state, position)
    slack = equations.gap + equations.matrix @ equations.force - equations.lever * equations.rotation
    approach = float(np.max(equations.lever * equations.rotation - equations.gap))
    on = equations.force > 0.0
    assert 10 < on.sum() < on.size
    assert equations.lever @ equations.force == pytest.approx(1.6e6, rel=1e-9)
    # the solver replaces the kernel beyond twelve half-widths by its far field, and its widths are 1e-5 old
    assert np.abs(slack[on]).max() < 1e-3 * approach
    assert slack[~on].min() > -1e-3 * approach


@pytest.mark.slow
@pytest.mark.parametrize("position", [0, 7, 15])
def test_compliance_is_symmetric_and_positive_definite(fresh_teeth, position):
    equations = Assembled(*fresh_teeth, position)
    for matrix in (equations.tooth, equations.matrix):
        np.testing.assert_allclose(matrix, matrix.T, rtol=0.0, atol=1e-15 * np.abs(matrix).max())
    assert np.linalg.eigvalsh(equations.matrix)[0] > 0.0


@pytest.mark.slow
def test_pinion_compliance_is_reciprocal_before_it_is_made_symmetric(fresh_teeth):
    teeth, _ = fresh_teeth
    pinion = teeth.problem.bodies[0]
    pairs = teeth.rolls.pairs
    rolls = np.repeat(np.arange(pairs) * teeth.rolls.phase.size + 3, 5)
    faces = np.tile(np.linspace(5, 55, 5).astype(int), pairs)
    matrix, slope = np.zeros((rolls.size, rolls.size)), np.zeros((rolls.size, rolls.size))
    pinion.add_compliance(rolls, faces, np.repeat(np.arange(pairs), 5), matrix, slope)
    np.testing.assert_allclose(matrix, matrix.T, rtol=0.0, atol=1e-3 * np.abs(matrix).max())


@pytest.fixture(scope="module")
def worn_small(small):
    scene = small.replace({"wear.until.meshes": 1e10, "numerics.wear_steps": 4})
    return scene, sw.simulate(scene)


@pytest.mark.slow
@pytest.mark.parametrize("state", ["fresh", "worn"])
def test_given_roll_positions_equal_those_of_the_even_grid(worn_small, state):
    scene, tree = worn_small
    depth = None if state == "fresh" else tree["flank"].wear_depth.isel(wear_step=-1)
    even = sw.loaded_contact(scene, wear_depth=depth)
    wanted = np.array([0.0, 0.25, 0.5, 11.0 / 12.0])
    given = sw.loaded_contact(scene, roll_positions=wanted[::-1] - 3.0, wear_depth=depth)
    assert given["mesh_cycle"].sizes["mesh_position"] == wanted.size
    for group, dim in (("engagement", "roll_position"), ("mesh_cycle", "mesh_position")):
        for name, values in given[group].data_vars.items():
            if name == "sliding_distance":  # speeds are differences between neighbouring roll positions
                continue
            same = even[group][name].sel({dim: values[dim]}, method="nearest", tolerance=1e-9)
            # half-widths are solved to 1e-5
            np.testing.assert_allclose(values, same, rtol=0.0, atol=1e-5 * float(np.abs(same).max()), err_msg=name)


@pytest.mark.slow
def test_wear_depth_of_a_result_gives_its_loads_again(worn_small):
    scene, tree = worn_small
    again = sw.loaded_contact(scene, wear_depth=tree["flank"].wear_depth.isel(wear_step=-1))
    last = tree["engagement"].isel(wear_step=-1)
    fresh = again["engagement"].isel(wear_step=0)
    # edges are found from loads on the way, and settle as far as is told
    settled = max(float(one["diagnostics"].edge_residual[-1]) for one in (tree, again))
    assert settled <= 1e-2
    for name, here, there in (
        ("load share", fresh.load_share, last.load_share),
        ("pressure", away_from_edges(fresh), away_from_edges(last)),
        # where an edge bears less than a hundredth of the load, its share of that is only as exact as edges settle
        ("pressed edge", *(part.contact_pressure_max_edge.where(part.load_share > 0.01) for part in (fresh, last))),
        ("root stress", *(part.root_stress.where(part.load_share > 0.01) for part in (fresh, last))),
    ):
        apart, most = np.abs(here - there).values, float(np.abs(there).max())
        assert np.array_equal(np.isnan(here), np.isnan(there)), name
        within = apart[np.isfinite(apart)] <= 1e-4 * most
        assert within.all() or (name == "pressed edge" and within.mean() > 0.9), name
        assert np.nanmax(apart) <= max(settled, 1e-4) * most, name


# ---------------------------------------------------------------- the active set


def loads_of(matrix, gap, lever, torque):
    n = gap.size
    force, slack = np.zeros(n), np.zeros(n)
    status, rotation, _ = solve_active_set(
        matrix, gap, lever, torque, 0.0, True, np.zeros(n, dtype=bool), force, slack, 400
    )
    assert status == ActiveSetStatus.CONVERGED
    return force, rotation, slack


def random_contact(random, n):
    root = random.normal(size=(n, n + 2))
    matrix = root @ root.T / n + 0.05 * np.eye(n)
    return matrix, np.abs(random.normal(size=n)), random.uniform(0.5, 2.0, n), random.uniform(0.05, 5.0)


@pytest.mark.parametrize("seed", range(12))
def test_active_set_against_all_sets(seed):
    random = np.random.default_rng(seed)
    n = 8
    matrix, gap, lever, torque = random_contact(random, n)
    found = []
    for size in range(1, n + 1):
        for members in combinations(range(n), size):
            on = list(members)
            whole = np.zeros((size + 1, size + 1))
            whole[:size, :size] = matrix[np.ix_(on, on)]
            whole[:size, size], whole[size, :size] = -lever[on], lever[on]
            solution = np.linalg.solve(whole, np.append(-gap[on], torque))
            force = np.zeros(n)
            force[on] = solution[:size]
            slack = gap + matrix @ force - lever * solution[size]
            if force.min() >= 0.0 and slack.min() >= -1e-12:
                found.append((force, solution[size]))
    assert len(found) == 1
    force, rotation, slack = loads_of(matrix, gap, lever, torque)
    np.testing.assert_allclose(force, found[0][0], atol=1e-10)
    assert rotation == pytest.approx(found[0][1], rel=1e-10)
    np.testing.assert_allclose(slack, gap + matrix @ force - lever * rotation, atol=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_active_set_against_least_squares(seed):
    random = np.random.default_rng(100 + seed)
    n = 60
    matrix, gap, lever, torque = random_contact(random, n)
    factor = np.linalg.cholesky(matrix).T

    def forces(rotation):
        # min 1/2 F C F - (a phi - g) F over F >= 0 is a least-squares problem in the Cholesky factor
        return nnls(factor, np.linalg.solve(factor.T, lever * rotation - gap), maxiter=50 * n)[0]

    high = 1.0
    while lever @ forces(high) < torque:
        high *= 2.0
    rotation = brentq(lambda phi: lever @ forces(phi) - torque, 0.0, high, xtol=1e-14)
    force, found, _ = loads_of(matrix, gap, lever, torque)
    assert found == pytest.approx(rotation, rel=1e-9)
    np.testing.assert_allclose(force, forces(rotation), atol=1e-9)
    assert (force > 0.0).sum() < n


def test_active_set_refuses_an_indefinite_compliance():
    n = 3
    matrix = np.array([[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    force, slack = np.zeros(n), np.zeros(n)
    status = solve_active_set(
        matrix, np.zeros(n), np.ones(n), 1.0, 0.0, True, np.ones(n, dtype=bool), force, slack, 400
    )[0]
    assert status == ActiveSetStatus.NOT_POSITIVE_DEFINITE


@pytest.mark.parametrize(
    ("status", "words"),
    [
        (LineStatus.WIDTHS_CHANGE, "half-widths still change by 3.0e-04; raise numerics.max_iterations above 60"),
        (LineStatus.NO_CONTACT_SET, "the contact set does not settle; change numerics.face_slices"),
        (LineStatus.NOT_POSITIVE_DEFINITE, "the compliance is not positive definite; raise numerics.harmonics"),
    ],
)
def test_every_failure_says_what_to_change(status, words):
    assert words in line_contact._reason(status, 3e-4, plan(scene_of({})).loaded_teeth().problem)


@pytest.mark.parametrize("fidelity", ["line", "patch"])
def test_contact_that_is_nearly_as_wide_as_a_flank_is_told_as_such(fidelity):
    """Found: raising the harmonics was the advice, and no number of them helped."""
    soft = {"numerics.tooth_compliance": "prism", "material.gear.youngs_modulus_MPa": 501.0}
    with pytest.raises(sw.ConvergenceError, match=r"13 mm wide is not small beside flanks 20.7 mm high; choose less"):
        sw.loaded_contact(scene_of(soft | {"numerics.fidelity": fidelity}))
