"""Loaded patches against Hertz, against fidelity `line`, and beyond the cells that were looked at."""

import dataclasses

import numpy as np
import pytest

import semiwear as sw
from semiwear import collect
from semiwear.closed_forms.hertz import elliptic_contact
from semiwear.contact.footprint import Footprints
from semiwear.contact.gap import gap_of_flanks
from semiwear.contact.patch_contact import PATCH as PATCHES
from semiwear.contact.patch_contact import _with_columns
from semiwear.contact.patch_gap import PatchCells
from semiwear.meshing.removed import Removed
from semiwear.plan import plan
from semiwear.wear.swept_line import fresh_sweep
from tests.scenes import one_rigid_tooth
from tests.strategies.flanks import away_from_borders
from tests.strategies.lines import even_grid, straight_lines

TOOTH_LOAD = 1.6e6 / (0.5 * 6.35 * 25 * np.cos(np.radians(25.0)))  # N, 1600 N m on one tooth
PATCH = {"numerics.fidelity": "patch", "numerics.cells_per_half_width": 8}


# ---------------------------------------------------------------- Hertz


class Ellipse:
    """The curvatures of the pitch point all along one straight line: then the ellipse is exact."""

    width = 80.0

    def __init__(self, shipped, cells, slices, along=7.032e-5, across=3.041e-2):
        teeth = plan(one_rigid_tooth(shipped, slices)).loaded_teeth(None, np.array([0.0, 0.25]))
        step = self.width / slices
        lines = straight_lines(
            np.zeros(2), slices, step=step, across=across, along=along, lever=teeth.lines.lever_arm[0, 0]
        )
        grid = even_grid(lines, 41)
        self.hertz = elliptic_contact(TOOTH_LOAD, along, across, teeth.problem.modulus)
        cell = self.hertz.minor_half_axis / cells
        problem = dataclasses.replace(teeth.problem.on_lines(lines), cells=PatchCells(lines, grid, cell))
        one = np.ones((2, slices))
        worn = Footprints(
            Removed.met(grid, np.zeros((1, *grid.profile.shape)), 2), 0.0 * one, lines.separation[0], across * one,
            self.hertz.minor_half_axis * one, 0.0 * one, lines.separation[0], 0.0 * one,
        )  # fmt: skip
        self.loads = PATCHES.solve(problem, worn)
        self.pressure = problem.cells.pressure(self.loads.cells)[0]
        self.peak = float(PATCHES.pressures(problem, self.loads, worn, 0.0).inner[0].max())
        self.approach = float(problem.approach(self.loads)[0])
        self.cell = (step, cell)
        x = lines.arc[0] - 0.5 * self.width
        y = (np.arange(self.pressure.shape[1]) - 0.5 * (self.pressure.shape[1] - 1)) * cell
        a, b = self.hertz.major_half_axis, self.hertz.minor_half_axis
        exact = self.hertz.peak_pressure * np.sqrt(np.maximum(1.0 - (x[:, None] / a) ** 2 - (y / b) ** 2, 0.0))
        self.error = float(np.sqrt(np.mean((self.pressure - exact)[exact > 0.0] ** 2)) / self.hertz.peak_pressure)


RESOLUTIONS = ((4, 31), (8, 61), (16, 121))


@pytest.fixture(scope="module")
def ellipses(shipped):
    return {resolution: Ellipse(shipped, *resolution) for resolution in RESOLUTIONS}


@pytest.mark.parametrize("resolution", RESOLUTIONS)
def test_a_line_of_even_curvature_is_the_hertz_ellipse(ellipses, resolution):
    """Tolerances: a cell's extent for the half-axes; cells' pressures are means, off by the square of c/b or so."""
    contact, hertz, cells = ellipses[resolution], ellipses[resolution].hertz, resolution[0]
    pressed = contact.pressure > 0.0
    assert 0.5 * contact.cell[0] * pressed.any(axis=1).sum() == pytest.approx(
        hertz.major_half_axis, abs=contact.cell[0]
    )
    assert 0.5 * contact.cell[1] * pressed.sum(axis=1).max() == pytest.approx(
        hertz.minor_half_axis, abs=contact.cell[1]
    )
    assert contact.peak == pytest.approx(hertz.peak_pressure, rel=0.25 / cells**2)
    assert contact.approach == pytest.approx(hertz.approach, rel=0.25 / cells**2)
    # of a peak with the same load and width
    assert contact.loads.half_width[0].max() == pytest.approx(hertz.minor_half_axis, rel=0.25 / cells**2)
    assert contact.loads.force[0].sum() == pytest.approx(TOOTH_LOAD, rel=1e-9)
    assert contact.loads.balance[0] < 1e-12
    assert contact.loads.complementarity[0] < 1e-6


def test_hertz_pressures_converge(ellipses):
    """The root at the rim leaves cells there wrong by the root of c/b: of order 1 over the area, 1.5 at best."""
    coarse, middle, fine = (ellipses[resolution].error for resolution in RESOLUTIONS)
    assert middle < coarse / 1.4
    assert fine < middle / 1.4
    peaks = [abs(ellipses[r].peak / ellipses[r].hertz.peak_pressure - 1.0) for r in RESOLUTIONS]
    assert peaks[1] < peaks[0] / 2.0
    assert peaks[2] < peaks[1] / 2.0


@pytest.mark.parametrize(("along", "across"), [(3e-3, 3e-2), (7e-5, 0.1)])
def test_other_ellipses(shipped, along, across):
    contact = Ellipse(shipped, 8, 121, along, across)
    assert contact.peak == pytest.approx(contact.hertz.peak_pressure, rel=0.25 / 8**2)
    assert contact.approach == pytest.approx(contact.hertz.approach, rel=0.25 / 8**2)


def test_the_pair_at_its_pitch_point_is_nearly_the_ellipse(shipped):
    """The real valley bends a little: one rigid tooth, 910 MPa and 0.525 mm (design, section 3)."""
    tree = sw.loaded_contact(one_rigid_tooth(shipped, 61).replace(PATCH), roll_positions=[0.0])
    contact = tree["engagement"].sel(roll_position=0.0, method="nearest")
    assert contact.contact_pressure_max.item() == pytest.approx(910.0, rel=0.01)
    half_width = 2.0 * contact.line_load.max().item() / (np.pi * contact.contact_pressure_max.item())
    assert half_width == pytest.approx(0.525, rel=0.01)


# ---------------------------------------------------------------- against line loads

STEPS = (0, 4, 12)


class Loaded:
    """One wear state of the main job at one fidelity."""

    def __init__(self, scene, wear_depth):
        self.teeth = plan(scene).loaded_teeth()
        self.state = self.teeth.load(np.ascontiguousarray(1e-3 * wear_depth.sel(body="gear").values.T))
        self.pressure = self.teeth.pressures(self.state)
        parts = {
            "engagement": collect.engagement(
                self.teeth, self.state, self.pressure, fresh_sweep(self.teeth.pair, self.teeth.lines)
            ),
            "mesh_cycle": collect.mesh_cycle(self.teeth, self.state),
        }
        self.engagement = parts["engagement"]
        self.history = collect.history(self.teeth, self.state, self.pressure, parts)
        self.approach = self.teeth.problem.approach(self.state.loads)


@pytest.fixture(scope="module")
def by_fidelity(shipped, worn):
    """Line loads and patches on the flanks of the main job."""
    depth = worn["flank"].wear_depth
    patch = shipped.replace(PATCH)
    return {
        step: (Loaded(shipped, depth.isel(wear_step=step)), Loaded(patch, depth.isel(wear_step=step)))
        for step in STEPS
    }


@pytest.mark.slow
@pytest.mark.parametrize("step", STEPS)
def test_patches_and_lines_agree_on_pressures_and_load_sharing(by_fidelity, step):
    line, patch = by_fidelity[step]
    for zone in ("root", "addendum", "pitch"):
        name = f"contact_pressure_{zone}"
        assert patch.history[name] == pytest.approx(float(line.history[name]), rel=0.03), name
    np.testing.assert_allclose(patch.approach, line.approach, rtol=0.02)
    share = np.abs(patch.engagement["load_share"] - line.engagement["load_share"])
    assert share.max() < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("step", STEPS)
def test_equations_of_patches_hold_on_worn_flanks(by_fidelity, step):
    patch = by_fidelity[step][1]
    loads = patch.state.loads
    assert loads.balance.max() < 1e-9
    assert loads.complementarity.max() < 1e-6
    assert (loads.cells >= 0.0).all()
    np.testing.assert_allclose(loads.cells.sum(axis=-1), loads.force, rtol=1e-12)
    moment = np.sum(loads.force * patch.teeth.lines.lever_arm, axis=1).reshape(patch.teeth.rolls.pairs, -1)
    np.testing.assert_allclose(moment.sum(axis=0), 1.6e6, rtol=1e-9)
    for pressure in (patch.pressure.inner, patch.pressure.border):
        assert np.isfinite(pressure).all()
        assert (pressure >= 0.0).all()


@pytest.mark.slow
def test_finer_cells_change_little(shipped, worn, by_fidelity):
    """Cells half as wide: pressures on the worn ridge, the sharpest there is, move by (c/b) squared or so."""
    depth = worn["flank"].wear_depth.isel(wear_step=12)
    fine = Loaded(shipped.replace(PATCH | {"numerics.cells_per_half_width": 16}), depth)
    coarse = by_fidelity[12][1]
    for zone in ("root", "addendum", "pitch"):
        name = f"contact_pressure_{zone}"
        assert coarse.history[name] == pytest.approx(float(fine.history[name]), rel=0.02), name
    np.testing.assert_allclose(coarse.approach, fine.approach, rtol=0.005)


@pytest.mark.slow
def test_a_start_changes_nothing(by_fidelity):
    """From the loads of another wear state, or from none."""
    fresh, patch = by_fidelity[0][1], by_fidelity[12][1]
    again = patch.teeth.load(patch.state.wear, fresh.state.loads)
    columns = max(again.loads.cells.shape[-1], patch.state.loads.cells.shape[-1])
    expected = _with_columns(patch.state.loads.cells, columns)
    # gaps are met to 1e-6 of the approach; a cell's own compliance is some hundredth of the whole
    np.testing.assert_allclose(
        _with_columns(again.loads.cells, columns), expected, atol=1e-3 * expected.max(), rtol=0.0
    )
    np.testing.assert_allclose(again.loads.rotation, patch.state.loads.rotation, rtol=1e-5)


MESHES = {"wear.until.control_depths_um": None, "wear.control_point": None, "wear.until.meshes": 5e8}


@pytest.mark.slow
def test_patches_and_lines_wear_alike(shipped):
    scene = shipped.replace(MESHES | {"numerics.wear_steps": 4, "numerics.cells_per_half_width": 8})
    line, patch = (sw.simulate(scene, fidelity=fidelity) for fidelity in ("line", "patch"))
    inside = away_from_borders(line["flank"].to_dataset())
    one, two = (tree["flank"].wear_depth.sel(body="gear").isel(wear_step=-1).values for tree in (line, patch))
    assert inside.sum() > 3000
    assert one[inside].max() > 5.0
    assert np.abs(two - one)[inside].max() < 0.03 * one.max()
    assert two.max() == pytest.approx(one.max(), rel=0.03)
    assert two[inside].max() == pytest.approx(one[inside].max(), rel=0.03)


# ---------------------------------------------------------------- contact far from the fresh line


def on_cells(teeth, rolls, wear, columns):
    """Gap in the middle of cells, from the fresh separation and wear anew: (roll, face, columns).

    NaN beyond the flank, and from where a slice's separation bends away from it.
    """
    lines, grid = teeth.lines, teeth.grid
    offset = (np.arange(columns) - 0.5 * (columns - 1)) * teeth.problem.cells.width
    away = offset / lines.spacing[rolls][..., None]
    place = lines.profile[rolls][..., None] + away
    value, slope, bend, third, fourth = lines.separation[:, rolls][..., None]
    gap = value + away * (slope + away * (0.5 * bend + away * (third / 6.0 + away * fourth / 24.0)))
    part = np.linspace(0.0, 1.0, 33) * away[..., None]
    convex = (bend[..., None] + part * (third[..., None] + 0.5 * part * fourth[..., None])).min(axis=-1) > 0.0
    for i in range(grid.face.size):
        gap[:, i] += np.interp(place[:, i], grid.profile[i], wear[i])
    inside = (place >= lines.low[rolls][..., None]) & (place <= lines.high[rolls][..., None])
    return np.where(inside & convex, gap, np.nan)


class Ridge:
    """A deeply worn flank on which a ridge is left, 2 mm beside the fresh line of the pitch point."""

    def __init__(self, shipped):
        self.teeth = teeth = plan(shipped.replace(PATCH | {"numerics.roll_positions": 8})).loaded_teeth()
        at = int(np.abs(teeth.lines.roll).argmin())
        self.position = at % teeth.rolls.phase.size
        self.rolls = teeth.problem.rolls_of(self.position)
        self.pair = int(np.flatnonzero(self.rolls == at)[0])
        aside = (teeth.grid.profile - teeth.lines.profile[at][:, None]) * teeth.lines.spacing[at][:, None] - 2.0
        self.wear = 0.15 * (1.0 - np.exp(-0.5 * (aside / 0.5) ** 2))
        self.removed = teeth.removed(self.wear)
        coarse = teeth.touch_solved(self.wear)
        self.loads = teeth.fidelity.solve(teeth.problem, coarse, positions=[self.position])
        self.approach = self.loads.rotation[self.position] * teeth.lines.lever_arm[self.rolls]


@pytest.fixture(scope="module")
def ridge(shipped):
    return Ridge(shipped)


@pytest.mark.slow
def test_the_patch_follows_the_contact_to_a_ridge(ridge):
    columns = ridge.loads.cells.shape[-1]
    offset = (np.arange(columns) - 0.5 * (columns - 1)) * ridge.teeth.problem.cells.width
    loaded = ridge.loads.cells[ridge.rolls[ridge.pair]].sum(axis=0)
    # it lies four half-widths of the fresh contact aside
    assert loaded @ offset / loaded.sum() == pytest.approx(2.0, abs=ridge.teeth.half_width)
    assert columns > ridge.teeth.problem.cells.columns_for(2.0 * ridge.teeth.half_width)
    assert ridge.loads.balance[ridge.position] < 1e-9
    assert ridge.loads.complementarity[ridge.position] < 1e-6


@pytest.mark.slow
def test_nothing_is_pierced_beyond_the_patch(ridge):
    """On the whole flank: elasticity only opens gaps, so what is farther than the approach is not touched."""
    columns = ridge.loads.cells.shape[-1]
    more = int(6.0 / ridge.teeth.problem.cells.width)
    clear = on_cells(ridge.teeth, ridge.rolls, ridge.wear, columns + 2 * more) - ridge.approach[..., None]
    inner = clear[..., more:-more]
    beyond = np.concatenate([clear[..., :more], clear[..., -more:]], axis=-1)
    assert np.isfinite(beyond).sum() > 3000
    assert np.nanmin(beyond) >= 0.0
    # where cells press the gap is closed, but for what lies between straight and smooth wear
    pressed = (ridge.loads.cells[ridge.rolls] > 0.0) & np.isfinite(inner)
    assert pressed.sum() > 100
    assert inner[pressed].max() < 1e-3
    # and the ridge is not what the fresh contact would reach
    assert np.nanmin(inner[ridge.pair]) < -5e-3


@pytest.mark.slow
def test_gap_of_the_cells_is_fresh_separation_and_wear(ridge):
    """`PatchCells` with many more columns: what it leaves out is farther than the approach."""
    cells, approach, columns = ridge.teeth.problem.cells, float(ridge.approach.max()), 400
    faces = np.arange(10, 50, 8)
    at = ridge.rolls[ridge.pair]
    found, reach = cells.gap(
        np.full(faces.size, at), faces, approach, columns, gap_of_flanks(cells.lines, ridge.removed)
    )
    expected = on_cells(ridge.teeth, ridge.rolls, ridge.wear, columns)[ridge.pair, faces]
    known, flank = np.isfinite(found), np.isfinite(expected)
    assert (known & flank).sum() > 100
    assert 2.0 < reach < 0.5 * columns * cells.width
    # straight between nodes here, 0.11 mm apart, on a ridge of curvature 0.6/mm
    np.testing.assert_allclose(found[known & flank], expected[known & flank], atol=0.125 * 0.6 * 0.11**2)
    assert expected[flank & ~known].min() >= approach


@pytest.fixture(scope="module")
def patched_teeth(shipped):
    return plan(shipped.replace(PATCH | {"numerics.tooth_compliance": "rigid"})).loaded_teeth()


@pytest.mark.parametrize("approach", [0.03, 0.06, 0.1, 0.2])
def test_no_cell_is_nearer_than_its_line(patched_teeth, approach):
    """The line is where the fresh separation is least, however far the cells reach."""
    teeth = patched_teeth
    least = teeth.lines.separation[0]
    rolls, faces = np.nonzero(least < approach)
    flanks = gap_of_flanks(teeth.problem.lines, teeth.removed(np.zeros(teeth.grid.profile.shape)))
    gap, _ = teeth.problem.cells.gap(rolls, faces, approach, 900, flanks)
    # lines are traced in two steps: where flanks are far apart, to some micrometres
    assert (gap.min(axis=1) - least[rolls, faces]).min() > -5e-3


@pytest.mark.slow
def test_large_steps_to_control_depths_wear_alike(small):
    """The main job in two large steps: patches follow where lines do."""
    scene = small.replace({"wear.until.control_depths_um": [30.0, 60.0], "numerics.cells_per_half_width": 8})
    line, patch = (sw.simulate(scene, fidelity=fidelity)["history"] for fidelity in ("line", "patch"))
    np.testing.assert_allclose(patch.wear_depth_control_point, line.wear_depth_control_point, atol=0.05)
    np.testing.assert_allclose(patch.transmission_error_mean, line.transmission_error_mean, rtol=0.03)
