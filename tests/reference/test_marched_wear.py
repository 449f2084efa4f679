"""Wear marched through the roll positions: against integrals over the contact, the swept line, and large steps."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

import semiwear as sw
from semiwear.contact.patch_gap import PatchCells
from semiwear.plan import plan
from semiwear.wear.marched import marched_wear, sliding_distance_under_contact, spread_by_contact
from tests.strategies.flanks import away_from_borders
from tests.strategies.lines import even_grid, straight_lines

# ---------------------------------------------------------------- a Hertz contact that crosses a plane flank

LOAD = 300.0  # N/mm
TRAVEL = 5.0  # mm to either side of where sliding vanishes
SLIDING = 1.0  # sliding velocity per mm of travel: dv_s/ds at the line


@pytest.fixture(scope="module")
def some_teeth(shipped):
    return plan(
        shipped.replace(
            {
                "numerics.fidelity": "patch",
                "numerics.tooth_compliance": "rigid",
                "numerics.face_slices": 7,
                "numerics.roll_positions": 8,
            }
        )
    ).loaded_teeth()


class Crossing:
    """The same line load and half-width at every roll position, on cells that carry the ellipse's mean."""

    slices = 3

    def __init__(self, some_teeth, half_width, step, cells=16, offset=0.0, slope=0.0):
        """`step` in half-widths; sliding at the line is SLIDING times its place, and `offset`."""
        place = np.linspace(-TRAVEL, TRAVEL, round(2.0 * TRAVEL / (step * half_width)) + 1)
        lines = straight_lines(
            place, self.slices, half_height=6.0, sliding=offset + SLIDING * place, sliding_slope=slope
        )
        grid = even_grid(lines, 1201)
        self.cells = PatchCells(lines, grid, half_width / cells)
        problem = dataclasses.replace(some_teeth.problem.on_lines(lines), cells=self.cells)
        self.teeth = dataclasses.replace(some_teeth, lines=lines, fine=lines, grid=grid, problem=problem)
        edges = np.clip((np.arange(2 * cells + 9) - (cells + 4)) / cells, -1.0, 1.0)
        filled = (edges * np.sqrt(1.0 - edges**2) + np.arcsin(edges)) / np.pi
        forces = np.broadcast_to(LOAD * np.diff(filled), (place.size, self.slices, edges.size - 1)).copy()
        self.loads = dataclasses.replace(problem.no_loads(), cells=forces)
        self.half_width, self.offset, self.slope = half_width, offset, slope
        self.speed = 2.0 * TRAVEL * some_teeth.pair.roll_per_time
        nodes = grid.profile[1]
        self.inside = np.abs(nodes) < TRAVEL - 1.0
        self.nodes = nodes[self.inside]

    @property
    def wear(self):
        """Sum of p |v_s| dt at nodes that the whole contact has crossed."""
        return marched_wear(self.teeth, self.cells, self.loads, np.ones(self.slices, dtype=bool))[0][1, self.inside]

    @property
    def swept(self):
        return LOAD * np.abs(self.offset + SLIDING * self.nodes) / self.speed

    @property
    def integral(self):
        """Finite width: while the line stands y beside a node, that slides as the line does, less slope times y."""
        angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 4001)
        y = self.half_width * np.sin(angle)
        share = 2.0 / np.pi * np.cos(angle) ** 2  # of the load, by angle
        sliding = np.abs(self.offset + SLIDING * (self.nodes[:, None] + y) - self.slope * y)
        return LOAD / self.speed * np.trapezoid(share * sliding, angle, axis=1)

    def error(self, expected):
        """Greatest difference over the greatest wear."""
        return float(np.abs(self.wear - expected).max() / self.swept.max())

    @property
    def at_the_cusp(self):
        """Wear where sliding vanishes over its closed form, k q 4 b/(3 pi) |dv_s/ds| / v_n."""
        own = self.half_width * 4.0 / (3.0 * np.pi) * abs(SLIDING - self.slope) * LOAD / self.speed
        return float(self.wear[np.abs(self.nodes).argmin()] / own)


@pytest.mark.slow
@pytest.mark.parametrize("slope", [0.0, 0.4])
def test_marched_wear_tends_to_the_finite_width_integral(some_teeth, slope):
    """As roll steps shrink: a node is pressed 2.5, 4.5, ... 32.5 times, so that the rims fall alike on the steps.

    The pressure's root there makes the sum of order 1.5.
    """
    passes = 2.0 ** np.arange(1, 6) + 0.5
    contacts = [Crossing(some_teeth, 0.5, 2.0 / n, slope=slope) for n in passes]
    errors = [contact.error(contact.integral) for contact in contacts]
    assert errors[0] > 0.03
    for coarse, fine in pairwise(errors):
        assert fine < max(coarse / 1.5, 0.002), errors
    assert errors[-1] < 0.002
    # over all four refinements at least an order of one and a quarter
    assert errors[-1] < errors[0] * (passes[0] / passes[-1]) ** 1.25
    # the wear there is small: the same error weighs more
    assert contacts[-1].at_the_cusp == pytest.approx(1.0, abs=0.02)


@pytest.mark.slow
def test_marched_wear_tends_to_the_swept_line_as_the_load_falls(some_teeth):
    """With the half-width, steps a tenth of it: only the cusp differs, by the sliding 4 b/(3 pi) aside."""
    widths = 0.8 / 2.0 ** np.arange(6)
    contacts = [Crossing(some_teeth, width, 0.097) for width in widths]
    errors = [contact.error(contact.swept) for contact in contacts]
    for contact, error in zip(contacts[:4], errors, strict=False):
        expected = 4.0 * contact.half_width / (3.0 * np.pi) / np.abs(contact.nodes).max()
        assert error == pytest.approx(expected, rel=0.1)
    for coarse, fine in pairwise(errors):
        assert fine < max(coarse / 1.5, 0.004), errors
    assert errors[-1] < 0.005


@pytest.mark.slow
def test_marched_wear_away_from_the_cusp_is_the_swept_line(some_teeth):
    contact = Crossing(some_teeth, 0.5, 0.06, offset=9.0, slope=0.3)
    assert contact.error(contact.swept) < 0.005
    np.testing.assert_allclose(contact.integral, contact.swept, rtol=1e-6)


@pytest.mark.slow
def test_cells_hardly_matter(some_teeth):
    for cells in (8, 16, 32):
        contact = Crossing(some_teeth, 0.5, 0.06, cells)
        assert contact.error(contact.integral) < 0.003


@pytest.mark.slow
def test_sliding_distance_under_contact(some_teeth):
    """|v_s| over v_n times the width that is pressed, at even sliding."""
    contact = Crossing(some_teeth, 0.5, 0.06, offset=9.0)
    found = sliding_distance_under_contact(
        contact.teeth, contact.cells, contact.loads, np.ones(contact.slices, dtype=bool)
    )[1, contact.inside]
    middle = np.abs(contact.nodes) < 0.5
    # whole roll steps count, of 0.06 half-widths
    expected = 2.0 * contact.half_width * np.abs(9.0 + contact.nodes) / contact.speed
    np.testing.assert_allclose(found[middle], expected[middle], rtol=0.06)


@pytest.mark.slow
def test_only_chosen_slices_wear(some_teeth):
    contact = Crossing(some_teeth, 0.5, 0.2)
    every = marched_wear(contact.teeth, contact.cells, contact.loads, np.ones(3, dtype=bool))[0]
    one = marched_wear(contact.teeth, contact.cells, contact.loads, np.array([False, True, False]))[0]
    assert (one[[0, 2]] == 0.0).all()
    np.testing.assert_array_equal(one[1], every[1])
    assert (every >= 0.0).all()
    assert (every[:, [0, -1]] == 0.0).all()


# ---------------------------------------------------------------- the operator of large steps


def waves(points):
    grid = even_grid(straight_lines(np.zeros(1), 2, half_height=0.5 * (points - 1) * 0.1), points)
    every = np.ones(2, dtype=bool)
    return grid, every


@pytest.mark.parametrize("wave", [0, 1, 7, 30])
@pytest.mark.parametrize("stiffness", [0.0, 0.3, 40.0])
def test_waves_are_damped_by_their_wave_number(wave, stiffness):
    """cos(kappa x) between walls half a step beyond the ends: divided by 1 + stiffness kappa."""
    points, spacing = 61, 0.1
    grid, every = waves(points)
    values = np.cos(np.pi * wave * (np.arange(points) + 0.5) / points) * np.array([[1.0], [2.0]])
    found = spread_by_contact(grid, values, np.full(values.shape, stiffness), np.ones_like(values), every)
    kappa = np.pi * wave / (points * spacing)
    np.testing.assert_allclose(found, values / (1.0 + stiffness * kappa), atol=1e-10)


def test_spreading_shrinks_and_keeps_the_sum_where_it_is_even():
    grid, every = waves(61)
    values, even = np.random.default_rng(0).normal(size=grid.profile.shape), np.ones(grid.profile.shape)
    found = spread_by_contact(grid, values, np.full(values.shape, 3.0), even, every)
    np.testing.assert_allclose(found.sum(axis=1), values.sum(axis=1), atol=1e-9)
    assert (np.linalg.norm(found, axis=1) < 0.5 * np.linalg.norm(values, axis=1)).all()
    # nothing is spread where nothing slides
    np.testing.assert_array_equal(spread_by_contact(grid, values, 0.0 * values, even, every), values)
    chosen = spread_by_contact(grid, values, np.full(values.shape, 3.0), even, np.array([True, False]))
    np.testing.assert_array_equal(chosen[1], 0.0)
    np.testing.assert_allclose(chosen[0], found[0], atol=1e-12)


def test_spreading_keeps_the_volume_where_contact_ends_within_a_slice():
    """Pressure moves under the contact only: nodes beyond take none of it, and the volume stays."""
    grid, every = waves(61)
    values = np.random.default_rng(1).normal(size=grid.profile.shape)
    stiffness, area = np.zeros(values.shape), np.linspace(1.0, 1.2, 61) * np.ones((2, 1))
    stiffness[:, 20:33] = 5.0
    found = spread_by_contact(grid, values, stiffness, area, every)
    np.testing.assert_allclose(np.sum(area * found, axis=1), np.sum(area * values, axis=1), rtol=1e-12)
    np.testing.assert_allclose(found[:, :20], values[:, :20], atol=1e-12)
    assert np.ptp(found[:, 20:33]) < np.ptp(values[:, 20:33])


# ---------------------------------------------------------------- the shipped pair

MESHES = {"wear.until.control_depths_um": None, "wear.control_point": None}
PATCH = {"numerics.fidelity": "patch", "numerics.cells_per_half_width": 8}


def depth_of(tree):
    return tree["flank"].wear_depth.sel(body="gear").isel(wear_step=-1).values


@pytest.mark.slow
def test_few_interpolated_roll_positions_wear_as_many_marched_ones(shipped):
    changes = {"wear.until.meshes": 5e8, "numerics.wear_steps": 4, "numerics.face_slices": 31}
    scene = shipped.replace(MESHES | PATCH | changes)
    few = sw.simulate(scene.replace({"numerics.roll_positions": 12}))
    many = sw.simulate(scene.replace({"numerics.roll_positions": 200, "numerics.wear_mapping": "marched"}))
    inside = away_from_borders(few["flank"].to_dataset())
    one, two = depth_of(few), depth_of(many)
    assert inside.sum() > 1500
    assert two[inside].max() > 5.0
    assert np.abs(one - two)[inside].max() < 0.02 * two.max()
    assert one[inside].max() == pytest.approx(two[inside].max(), rel=0.02)


class WornBySteps:
    """Wear of 2e9 meshes: its greatest depth [um], and how rough it is along the profile."""

    def __init__(self, shipped, mapping, scheme, steps):
        scene = shipped.replace(
            MESHES
            | PATCH
            | {
                "wear.until.meshes": 2e9,
                "numerics.face_slices": 31,
                "numerics.roll_positions": 48 if mapping == "marched" else 12,
                "numerics.wear_mapping": mapping,
                "numerics.wear_scheme": scheme,
                "numerics.wear_steps": steps,
            }
        )
        tree = sw.simulate(scene)
        self.every = tree["flank"].wear_depth.sel(body="gear").values
        depth = self.every[-1]
        inside = away_from_borders(tree["flank"].to_dataset())[1:-1]
        bend = depth[2:] - 2.0 * depth[1:-1] + depth[:-2]
        self.greatest = float(depth[1:-1][inside].max())
        self.roughness = float(np.sqrt(np.mean(bend[inside] ** 2))) / self.greatest


COUNTS = (1, 2, 6)


@pytest.fixture(scope="module", params=["marched", "interpolated"])
def by_steps(shipped, request):
    runs = {("implicit", steps): WornBySteps(shipped, request.param, "implicit", steps) for steps in COUNTS}
    return runs | {("explicit", steps): WornBySteps(shipped, request.param, "explicit", steps) for steps in (1, 2)}


MOST_OFF = 0.25  # of the greatest depth: a single step


@pytest.mark.slow
def test_large_implicit_steps_converge(by_steps):
    """Of first order in the length of a step: from 2 to 6 steps by 0.4 of what it changes from 1 to 6."""
    one, two, six = (by_steps["implicit", steps].every[-1] for steps in COUNTS)
    assert np.linalg.norm(two - six) < 0.6 * np.linalg.norm(one - six)
    assert by_steps["implicit", 1].greatest == pytest.approx(by_steps["implicit", 6].greatest, rel=MOST_OFF)
    for steps in COUNTS:
        depth = by_steps["implicit", steps].every
        assert (depth[0] == 0.0).all()
        assert (np.diff(depth, axis=0) >= 0.0).all()


@pytest.mark.slow
def test_large_implicit_steps_leave_no_saw_tooth(by_steps):
    six = by_steps["implicit", 6].roughness
    for steps in (1, 2):
        assert by_steps["implicit", steps].roughness < 1.5 * six


@pytest.mark.slow
def test_large_explicit_steps_overshoot(by_steps):
    """So that the tests above could fail."""
    assert by_steps["explicit", 1].greatest > (1.0 + MOST_OFF) * by_steps["implicit", 6].greatest


@pytest.mark.slow
@pytest.mark.parametrize("by_steps", ["marched"], indirect=True)
def test_large_explicit_marched_steps_saw_tooth(by_steps):
    """From the second on: the first wears as the unworn flanks press, which is smooth."""
    assert by_steps["explicit", 2].roughness > 5.0 * by_steps["implicit", 6].roughness
    assert by_steps["explicit", 2].roughness > by_steps["explicit", 1].roughness


@pytest.mark.slow
def test_no_ridge_is_left_where_the_tip_of_the_pinion_digs_in(shipped):
    """Cells much finer than the nodes: what long steps leave out once stood there as ridges that bore 2,500 MPa."""
    scene = shipped.replace(
        {
            "numerics.fidelity": "patch", "numerics.wear_mapping": "marched", "numerics.roll_positions": 40,
            "numerics.face_slices": 15, "numerics.profile_points": 141, "numerics.harmonics": 9,
            "numerics.cells_per_half_width": 6, "numerics.wear_steps": 6, "wear.until.control_depths_um": None,
            "wear.until.meshes": 9e9, "wear.control_point": None,
        }
    )  # fmt: skip
    pressure = sw.simulate(scene)["history"].contact_pressure_root.values
    assert (pressure[1:] < pressure[0]).all()
    assert (pressure[1:] < 1.05 * pressure[:-1]).all()
