"""Pieces of fidelity `patch`: the solver against dense ones, cells and their gap, pressure across a slice."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.optimize import brentq, nnls

import semiwear as sw
from semiwear.closed_forms.hertz import line_contact_half_width, line_contact_pressure
from semiwear.closed_forms.love import love_coefficients
from semiwear.contact import patch_contact, patch_iteration
from semiwear.contact import row_preconditioner as rows_alone
from semiwear.contact.complementarity import Complementarity, ComplementarityStatus
from semiwear.contact.footprint import Footprints
from semiwear.contact.gap import gap_of_flanks
from semiwear.contact.patch_gap import PatchCells
from semiwear.contact.patch_sharing import SharedTorque, share_torque
from semiwear.contact.patch_system import PatchSystem
from semiwear.contact.problem import picked
from semiwear.contact.row_preconditioner import precondition, row_preconditioner
from semiwear.contact.slice_pressure import solve_slices
from semiwear.contact.stripe import less_aside
from semiwear.meshing.removed import Removed
from semiwear.plan import plan
from tests.scenes import SMALL, scene_of
from tests.strategies.lines import even_grid, straight_lines

MODULUS = 113736.0
CELL = (0.5, 0.05)
ROWS = (8, 5)  # of two pairs
COLUMNS = 12


# ---------------------------------------------------------------- the solver


@dataclass(frozen=True)
class Dense:
    """A system of two pairs, and its compliance put together cell by cell."""

    system: PatchSystem
    gap: np.ndarray
    levers: np.ndarray
    matrix: np.ndarray
    torque: float

    def cells(self, force: np.ndarray) -> np.ndarray:
        return force[np.isfinite(self.gap)]

    @property
    def lever(self) -> np.ndarray:
        return self.cells(np.broadcast_to(self.levers[:, None], self.gap.shape))

    def share(self, start: np.ndarray, tolerance: float, most: int = 2000) -> SharedTorque:
        return share_torque(self.system, self.gap, self.levers, self.torque, start, most, tolerance)

    def slack(self, force: np.ndarray, rotation: float) -> np.ndarray:
        return self.cells(self.gap) + self.matrix @ self.cells(force) - self.lever * rotation

    def by_least_squares(self) -> tuple[np.ndarray, float]:
        """Forces and rotation: min 1/2 F C F - (a phi - g) F over F >= 0, and phi that balances the torque."""
        factor, gap = np.linalg.cholesky(self.matrix), self.cells(self.gap)

        def forces(rotation: float) -> np.ndarray:
            return nnls(factor.T, np.linalg.solve(factor, self.lever * rotation - gap), maxiter=50 * gap.size)[0]

        high = 1e-3
        while self.lever @ forces(high) < self.torque:
            high *= 2.0
        rotation = brentq(lambda phi: self.lever @ forces(phi) - self.torque, 0.0, high, xtol=1e-18, rtol=1e-14)
        return forces(rotation), rotation


def two_pairs(seed: int) -> Dense:
    """Rough parabolas, coupled rows that tilt, levers that differ, cells and a row that cannot touch."""
    random = np.random.default_rng(seed)
    rows = sum(ROWS)
    starts = np.concatenate([[0], np.cumsum(ROWS)])
    across = (np.arange(COLUMNS) - 0.5 * (COLUMNS - 1)) * CELL[1]
    aside = random.uniform(-0.1, 0.1, rows)
    gap = 0.5 * 0.04 * (across - aside[:, None]) ** 2 + 1e-3 * random.random((rows, 1))
    gap += 1e-4 * random.random(gap.shape)
    gap[random.random(gap.shape) < 0.1] = np.inf
    gap[2] = np.inf
    coefficients = love_coefficients((max(ROWS), COLUMNS), CELL) / (MODULUS * CELL[0] * CELL[1])
    root = random.normal(size=(rows, 3))
    # teeth bend together, and what they share with the half-space is taken off
    smooth = 1e-6 * (root @ root.T) - 1e-7
    tilt, less = 1e-6 * random.normal(size=(rows, rows)), 1e-7 * random.random((rows, rows))
    lever = random.uniform(70.0, 80.0, rows)
    system = PatchSystem(
        starts=starts,
        cell=CELL,
        modulus=MODULUS,
        smooth=smooth,
        tilt=tilt,
        aside=less + less.T,
        across=across - aside[:, None],
        coefficients=coefficients,
    )
    row, column = (part[np.isfinite(gap)] for part in np.indices(gap.shape))
    pair = np.searchsorted(starts, row, side="right")
    away = coefficients[np.abs(row[:, None] - row) % max(ROWS), np.abs(column[:, None] - column)]
    place = system.across[row, column]
    moved, square = tilt[np.ix_(row, row)] * place[:, None], (place[:, None] - place) ** 2
    whole = smooth[np.ix_(row, row)] + moved + moved.T + system.aside[np.ix_(row, row)] * square
    matrix = np.where(pair[:, None] == pair, away, 0.0) + whole
    assert np.linalg.eigvalsh(matrix)[0] > 0.0
    return Dense(system, gap, lever, matrix, torque=75.0 * random.uniform(20.0, 400.0))


def starts_of(dense: Dense, seed: int) -> dict[str, np.ndarray]:
    """Everything touches; one cell does, in the worst place; any do, with loads out of all proportion."""
    gap = dense.gap
    one = np.zeros(gap.shape)
    one.ravel()[np.argmax(np.where(np.isfinite(gap), gap, -1.0))] = 1.0
    some = np.random.default_rng(seed).exponential(1e4, gap.shape)
    some[some < 7e3] = 0.0
    return {"all": np.ones(gap.shape), "one": one, "some": some}


@pytest.mark.parametrize("seed", range(6))
def test_forces_against_least_squares_and_the_dense_equations(seed):
    dense = two_pairs(seed)
    expected, rotation = dense.by_least_squares()
    pressed = expected > 0.0
    assert 0 < pressed.sum() < pressed.size
    for name, start in starts_of(dense, seed).items():
        found = dense.share(start, 1e-9)
        assert found.sharing.status is ComplementarityStatus.CONVERGED, name
        assert found.rotation == pytest.approx(rotation, rel=1e-8), name
        # gaps are met to 1e-9 of the approach, and a cell's own compliance is some hundredth of the whole
        np.testing.assert_allclose(
            dense.cells(found.sharing.pressure), expected, atol=1e-6 * expected.max(), rtol=0.0, err_msg=name
        )
        found = dense.share(start, 1e-7)
        assert found.sharing.status is ComplementarityStatus.CONVERGED, name
        assert (found.sharing.pressure >= 0.0).all(), name
        assert (found.sharing.pressure[~np.isfinite(dense.gap)] == 0.0).all(), name
        assert dense.levers @ found.sharing.pressure.sum(axis=1) == pytest.approx(dense.torque, rel=1e-12), name
        slack, on = dense.slack(found.sharing.pressure, found.rotation), dense.cells(found.sharing.pressure) > 0.0
        shift = found.rotation * float(dense.levers.max())
        assert slack.min() >= -1e-6 * shift, name
        assert np.abs(slack[on]).max() <= 1e-6 * shift, name
        # what it says of itself is what the dense equations say
        approach = float((dense.lever * found.rotation - dense.cells(dense.gap)).max())
        worst = max(np.abs(slack[on]).max(), -slack.min())
        assert found.complementarity == pytest.approx(worst / approach, rel=1e-3, abs=1e-12), name
        assert found.balance < 1e-12, name


@pytest.mark.parametrize("seed", range(3))
def test_forces_beside_the_line_bend_teeth_as_those_of_a_line_that_has_moved(seed):
    """Forces at one place of each row, read there: what fidelity `line` finds for footprints at these places."""
    system, random = two_pairs(seed).system, np.random.default_rng(seed)
    rows = np.arange(system.across.shape[0])
    column = random.integers(0, COLUMNS, rows.size)
    force = np.zeros(system.across.shape)
    force[rows, column] = random.random(rows.size)
    nothing = np.zeros_like(system.smooth)
    system = system._replace(aside=nothing)
    local = system._replace(smooth=nothing, tilt=nothing).apply(force)
    moved = picked(system.smooth, system.tilt, rows, system.across[rows, column])
    seen = (system.apply(force) - local)[rows, column]
    np.testing.assert_allclose(seen, moved @ force.sum(axis=1), rtol=1e-12, atol=1e-18)


def test_less_is_subtracted_aside_as_the_half_space_displacement_falls():
    """Second differences of the point-load solution at a depth (Johnson 1985, eq. 3.18c) over a slice."""
    arc, length = np.array([0.0, 1.3, 5.0, 11.0]), np.full(4, 1.3)
    depth, shear, poisson = (
        np.array([np.full(4, 2.5), np.full(4, 4.0)]),
        np.array([1e-6, 2e-6]),
        np.array([0.3, 0.25]),
    )

    def displacement(x, i, j):
        y = np.linspace(-0.5, 0.5, 401) * length[j] + arc[j] - arc[i]
        r = np.sqrt(x**2 + y**2 + depth[:, i, None] ** 2)
        kernel = depth[:, i, None] ** 2 / r**3 + 2.0 * (1.0 - poisson[:, None]) / r
        return float(shear @ trapezoid(kernel, y, axis=1)) / length[j]

    starts = np.array([0, 3, 4])
    found, x = less_aside(starts, arc, length, depth, shear, poisson), 0.02
    for i in range(3):
        for j in range(3):
            assert found[i, j] == pytest.approx((displacement(0.0, i, j) - displacement(x, i, j)) / x**2, rel=1e-3)
    # other lines share no ground
    assert (found[3, :3] == 0.0).all() and (found[:3, 3] == 0.0).all() and found[3, 3] > 0.0


@pytest.mark.parametrize("seed", range(3))
def test_windows_grow_to_the_cells_that_touch(seed, monkeypatch):
    """From one cell at the far end of its row, whose window leaves out much of the contact: as on all columns."""
    dense = two_pairs(seed)
    columns, solve = [], patch_iteration._solve

    def told(*args):
        columns.append(args[4].columns)
        return solve(*args)

    with monkeypatch.context() as patched:
        patched.setattr(patch_iteration, "_WINDOWS", 0)
        patched.setattr(patch_iteration, "_solve", told)
        whole = dense.share(np.ones(dense.gap.shape), 1e-9)
    assert columns == [COLUMNS]
    touching = np.flatnonzero((whole.sharing.pressure > 0.0).any(axis=0))
    end = 0 if touching.min() > COLUMNS - 1 - touching.max() else COLUMNS - 1
    start = np.zeros(dense.gap.shape)
    start[np.flatnonzero(np.isfinite(dense.gap[:, end]))[0], end] = 1.0
    monkeypatch.setattr(patch_iteration, "_solve", told)
    grown = dense.share(start, 1e-9)
    assert columns[1] < COLUMNS and len(columns) > 2
    exact = whole.sharing.pressure
    np.testing.assert_allclose(grown.sharing.pressure, exact, rtol=0.0, atol=1e-7 * exact.max())
    assert grown.rotation == pytest.approx(whole.rotation, rel=1e-9)
    assert grown.complementarity < 1e-7


@pytest.mark.parametrize("seed", range(3))
def test_a_window_that_holds_the_contact_is_the_only_one(seed, monkeypatch):
    monkeypatch.setitem(globals(), "COLUMNS", 40)
    dense = two_pairs(seed)
    columns, solve = [], patch_iteration._solve

    def told(*args):
        columns.append(args[4].columns)
        return solve(*args)

    monkeypatch.setattr(patch_iteration, "_solve", told)
    start = np.zeros(dense.gap.shape)
    start[:, 18:22] = np.isfinite(dense.gap[:, 18:22])
    found = dense.share(start, 1e-9)
    assert len(columns) == 1 and columns[0] < 40
    assert found.complementarity < 1e-7


def test_every_cell_beyond_a_window_is_looked_at():
    """At an approach of 0.07 mm: gaps of 0.1 mm do not close, nor does one of 0.05 that has yielded by 0.03."""
    window, lever, rotation = patch_iteration._Window(np.array([4, 2]), 5), np.full(2, 70.0), 1e-3
    force = np.zeros((2, COLUMNS))
    force[:, 5] = 1.0
    for row, column in np.ndindex(force.shape):
        beyond = not window.first[row] <= column < window.first[row] + 5
        gap, wanted = np.full(force.shape, 0.1), np.zeros(force.shape, dtype=bool)
        gap[row, column] = 0.05
        for yielded, pierced in ((0.01, beyond), (0.03, False)):
            displacement = np.full(force.shape, yielded)
            found = patch_iteration._missed(window, gap, lever, rotation, force, displacement, 0.0, wanted)
            expected = force > 0.0
            expected[row, column] |= pierced
            assert found == pierced
            np.testing.assert_array_equal(wanted, expected)


@pytest.mark.parametrize("seed", range(3))
def test_the_preconditioner_is_positive_with_the_coupling_of_other_cells(seed):
    """Cells come and go, fewer than make the coupling be factored again."""
    system, random = two_pairs(seed).system, np.random.default_rng(seed)
    free = random.random(system.across.shape) < 0.7
    kept = row_preconditioner(*free.shape)

    def dense() -> np.ndarray:
        places = np.argwhere(free)
        columns = np.zeros((len(places), len(places)))
        for k, place in enumerate(places):
            unit, out = np.zeros(free.shape), np.empty(free.shape)
            unit[*place] = 1.0
            precondition(kept, system, unit, free, out)
            columns[:, k] = out[free]
        return columns

    fresh = dense()
    np.testing.assert_allclose(fresh, fresh.T, rtol=0.0, atol=1e-12 * fresh.max())
    assert kept.changed[0] == 0
    for row, column in random.permutation(np.argwhere(free))[:3]:
        if free[row].sum() > 1:
            free[row, column] = False
    other = dense()
    assert kept.changed[0] > 0
    np.testing.assert_allclose(other, other.T, rtol=0.0, atol=1e-12 * other.max())
    assert np.linalg.eigvalsh(other)[0] > 0.0


@pytest.mark.parametrize("rows", [1, 4, 7])
def test_rows_of_free_cells_answer_as_their_equations_say(rows):
    """Side by side or with gaps, more of them or fewer than before; four rows without gaps are solved at a time."""
    random, columns = np.random.default_rng(rows), 12
    own = love_coefficients((1, columns), (0.3, 0.05))[0]
    compliance = own[abs(np.subtract.outer(np.arange(columns), np.arange(columns)))]
    kept, out, sums = row_preconditioner(rows, columns), np.empty((rows, columns)), np.empty(rows)
    for _ in range(6):
        free = np.zeros((rows, columns), dtype=bool)
        for row in free:
            first, count = random.integers(0, columns, 2)
            row[first : first + count] = True
            row[random.integers(0, columns, random.integers(0, 3))] = False
        residual = random.standard_normal(free.shape)
        rows_alone._factor_rows(kept, own, free)
        rows_alone._solve_rows(kept, residual, out, sums)
        for r, row in enumerate(free):
            expected, even = np.zeros((2, columns))
            block = compliance[np.ix_(row, row)]
            expected[row], even[row] = np.linalg.solve(block, np.stack([residual[r, row], np.ones(row.sum())]).T).T
            np.testing.assert_allclose(out[r], expected, rtol=0.0, atol=1e-11 * np.abs(expected).max(initial=0.0))
            assert sums[r] == pytest.approx(expected.sum(), rel=1e-9, abs=1e-11 * np.abs(expected).sum())
            assert kept.stiffness[r] == pytest.approx(even.sum(), rel=1e-11)
            np.testing.assert_allclose(kept.ones[r, : row.sum()], even[row], rtol=1e-11)


def test_a_pair_far_away_carries_nothing():
    dense = two_pairs(1)
    gap = dense.gap.copy()
    gap[ROWS[0] :] += 1.0
    found = replace(dense, gap=gap).share(np.ones(gap.shape), 1e-9)
    assert found.sharing.status is ComplementarityStatus.CONVERGED
    assert (found.sharing.pressure[ROWS[0] :] == 0.0).all()
    assert found.sharing.pressure[: ROWS[0]].sum() > 0.0


@pytest.mark.parametrize("most", [0, 1, 2, 3])
def test_too_few_iterations_are_told(most):
    dense = two_pairs(0)
    start = starts_of(dense, 0)["one"]
    found = share_torque(dense.system, dense.gap, dense.levers, dense.torque, start, most, 1e-7, again=False)
    assert found.sharing.status is ComplementarityStatus.NOT_CONVERGED
    assert found.sharing.iterations == most
    assert dense.levers @ found.sharing.pressure.sum(axis=1) == pytest.approx(dense.torque, rel=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_windows_take_no_more_iterations_together_than_are_allowed(seed):
    """From one cell at the end of its row, by several windows."""
    dense = two_pairs(seed)
    start = np.zeros(dense.gap.shape)
    start[np.flatnonzero(np.isfinite(dense.gap[:, 0]))[0], 0] = 1.0

    def share(most: int) -> Complementarity:
        found = share_torque(dense.system, dense.gap, dense.levers, dense.torque, start, most, 1e-9, again=False)
        return found.sharing

    enough = share(2000).iterations
    assert share(enough).status is ComplementarityStatus.CONVERGED
    fewer = share(enough - 1)
    assert (fewer.status, fewer.iterations) == (ComplementarityStatus.NOT_CONVERGED, enough - 1)


@pytest.mark.parametrize("seed", range(3))
def test_what_iterations_leave_is_solved_by_active_sets(seed):
    """One iteration is not enough from a cell in the worst place; active sets are tried then."""
    dense = two_pairs(seed)
    expected = dense.share(np.ones(dense.gap.shape), 1e-12)
    found = dense.share(starts_of(dense, seed)["one"], 1e-12, 12)
    assert found.sharing.status is ComplementarityStatus.CONVERGED
    exact = expected.sharing.pressure
    np.testing.assert_allclose(found.sharing.pressure, exact, atol=1e-5 * exact.max())
    assert found.rotation == pytest.approx(expected.rotation, rel=1e-7)
    assert found.complementarity < 2e-6 and found.balance < 1e-9


def test_an_indefinite_half_space_is_told():
    dense = two_pairs(0)
    wrong = replace(dense, system=dense.system._replace(smooth=-dense.system.smooth, modulus=-MODULUS))
    found = wrong.share(np.ones(dense.gap.shape), 1e-7, 100)
    assert found.sharing.status is ComplementarityStatus.NOT_POSITIVE


@pytest.mark.parametrize("seed", range(4))
def test_rounding_is_not_taken_for_an_indefinite_compliance(seed):
    """A tolerance that double precision cannot meet: told so, with the solution as far as it goes."""
    dense = two_pairs(seed)
    start = np.ones(dense.gap.shape)
    found = share_torque(dense.system, dense.gap, dense.levers, dense.torque, start, 2000, 1e-30, again=False)
    exact = dense.share(start, 1e-9).sharing.pressure
    assert found.sharing.status is not ComplementarityStatus.NOT_POSITIVE
    np.testing.assert_allclose(found.sharing.pressure, exact, atol=1e-7 * exact.max())


# ---------------------------------------------------------------- cells and their gap


def test_gap_of_cells_is_curvature_and_wear():
    """Cubic and wear add up in the middle of cells; what surely lies beyond the approach is left out."""
    lines = straight_lines(np.array([-1.0, 2.0]), 3, across=0.03)
    grid = even_grid(lines, 401)
    cells = PatchCells(lines, grid, 0.11)
    wear = np.stack([1e-3 * (1.0 + np.sin(grid.profile[0] + phase)) for phase in (0.0, 1.0, 2.0)])
    rolls, faces = np.array([0, 1, 1]), np.array([2, 0, 1])
    gap, reach = cells.gap(rolls, faces, 0.02, 40, gap_of_flanks(lines, Removed.met(cells.grid, wear[None], 2)))
    away = (np.arange(40) - 19.5) * 0.11
    place = lines.profile[rolls, faces][:, None] + away
    fresh = 0.5 * 0.03 * away**2
    # least wear of a slice, and the approach, decide what can touch
    expected = fresh + 1e-3 * (1.0 + np.sin(place + faces[:, None]))
    known = np.isfinite(gap)
    np.testing.assert_array_equal(known, fresh + wear[faces].min(axis=1)[:, None] <= 0.02)
    assert 0 < known.sum() < known.size
    # cubic interpolation by mean slopes: (h^3) of nodes 0.05 mm apart
    np.testing.assert_allclose(gap[known], expected[known], atol=1e-3 * 0.05**3)
    assert reach == pytest.approx(np.abs(away)[known.any(axis=0)].max())


def test_gap_does_not_depend_on_the_number_of_columns():
    lines = straight_lines(np.array([-1.0, 2.0]), 3, across=0.03)
    cells = PatchCells(lines, even_grid(lines, 101), 0.11)
    wear = 1e-3 * np.random.default_rng(0).random(cells.grid.profile.shape)
    rolls, faces = np.array([0, 1]), np.array([0, 2])
    wide, reach = cells.gap(rolls, faces, 0.02, 80, gap_of_flanks(lines, Removed.met(cells.grid, wear[None], 2)))
    narrow, same = cells.gap(rolls, faces, 0.02, 8, gap_of_flanks(lines, Removed.met(cells.grid, wear[None], 2)))
    assert same == reach
    np.testing.assert_array_equal(narrow, wide[:, 36:44])


@pytest.mark.parametrize("reach", [-1.0, 0.01, 0.5, 3.3, 20.0])
def test_columns_cover_the_reach(reach):
    lines = straight_lines(np.zeros(1), 1)
    cells = PatchCells(lines, even_grid(lines, 11), 0.1)
    columns = cells.columns_for(reach)
    assert columns % 2 == 0
    assert (0.5 * columns - 0.5) * 0.1 >= reach


# ---------------------------------------------------------------- pressure across a slice


def slice_of(wear_of: object, *, across: float = 0.0, half_height: float = 8.0, points: int = 1001):
    """A line and its grid, worn by a function of the profile coordinate."""
    lines = straight_lines(np.zeros(1), 1, across=across, half_height=half_height)
    grid = even_grid(lines, points)
    return lines, grid, wear_of(grid.profile)


def greatest(lines, grid, wear, line_load, margin=0.0):
    nothing = np.zeros(lines.profile.shape)
    curvature = np.maximum(lines.separation[2], 1e-6) / lines.spacing**2
    worn = Footprints(
        Removed.met(grid, wear[None], 1), lines.profile, nothing, curvature, nothing + 0.5, nothing, nothing, nothing
    )
    return solve_slices(lines, worn, nothing + line_load, MODULUS, margin)[0]


def test_a_parabola_needs_no_other_gap():
    """Hertz's law with the parabola's own curvature starts from its own gap."""
    lines, grid, wear = slice_of(np.zeros_like, across=0.03)
    nothing = np.zeros(lines.profile.shape)
    curvature = lines.separation[2] / lines.spacing**2
    worn = Footprints(
        Removed.met(grid, wear[None], 1),
        lines.profile,
        nothing + 5.0,
        curvature,
        nothing + 0.5,
        nothing,
        nothing,
        nothing,
    )
    for line_load in (3.0, 300.0):
        _, touched = solve_slices(lines, worn, nothing + line_load, MODULUS, 0.0)
        # of the gap that the load closes, 2 q/(pi E*)
        closes = 2.0 * line_load / (np.pi * MODULUS)
        np.testing.assert_allclose(touched.gap, lines.separation[0], atol=0.05 * closes)
        np.testing.assert_allclose(touched.curvature, curvature, rtol=0.1)
        np.testing.assert_allclose(touched.profile, lines.profile, atol=1e-6)


@pytest.mark.parametrize("line_load", [1.0, 30.0, 1000.0])
@pytest.mark.parametrize("worn", [0.0, 0.5, 1.0])
def test_a_parabola_is_hertz(line_load, worn):
    """Of a curvature that is fresh, half fresh and half worn, or all worn."""
    curvature = 0.03
    lines, grid, wear = slice_of(lambda p: 0.5 * worn * curvature * p**2, across=(1.0 - worn) * curvature)
    peak = line_contact_pressure(np.array(line_load), np.array(curvature), MODULUS)
    found = greatest(lines, grid, wear, line_load)
    assert found.inner.item() == pytest.approx(peak, rel=0.005)
    # the two cells beside the middle press alike
    half_width = line_contact_half_width(np.array(line_load), np.array(curvature), MODULUS)
    assert abs(found.place.item()) < 0.1 * half_width
    assert found.border.item() == 0.0


def test_a_wedge_is_johnsons():
    """Half-width a = q/(E* slope) and p = E* slope/pi acosh(a/x) (Johnson 1985, section 5.2).

    What lies nearer than the margin to an end counts as border: its greatest pressure is that of the first cell
    beyond a distance from the apex.
    """
    slope, line_load, height = 1e-3, 300.0, 6.0
    half_width = line_load / (MODULUS * slope)
    lines, grid, wear = slice_of(lambda p: slope * np.abs(p), half_height=height, points=801)

    def pressure(x):
        return MODULUS * slope / np.pi * np.arccosh(np.maximum(half_width / np.maximum(x, 1e-9), 1.0))

    def beyond(x):
        return greatest(lines, grid, wear, line_load, height - x).border.item()

    # a gap of 1.02 q/E* to either side in 32 cells, or once wider
    cell = 2.0 * 1.6 * 1.1 * half_width / 32
    for x in np.array([0.1, 0.2, 0.35, 0.5, 0.7, 0.85]) * half_width:
        assert pressure(x + cell) * 0.98 <= beyond(x) <= pressure(x) * 1.02
    edge = brentq(lambda x: (beyond(x) > 0.0) - 0.5, 0.5 * half_width, 1.5 * half_width, xtol=1e-4)
    assert edge == pytest.approx(half_width, abs=cell)


@pytest.mark.parametrize("line_load", [100.0, 400.0])
def test_two_valleys_share_the_load(line_load):
    """Alike, and far enough apart to be two Hertz contacts of half the load each."""
    curvature, apart = 0.03, 0.8
    lines, grid, wear = slice_of(lambda p: 0.5 * curvature * (np.abs(p) - apart) ** 2)
    peak = line_contact_pressure(np.array(0.5 * line_load), np.array(curvature), MODULUS)
    found = greatest(lines, grid, wear, line_load)
    # a half-width of 0.14 or 0.27 mm in cells of 0.08 mm or less
    assert found.inner.item() == pytest.approx(peak, rel=0.02)
    assert abs(found.place.item()) == pytest.approx(apart, abs=0.1)
    # one valley within the margin of an end, then the other
    sides = []
    for side in (-1.0, 1.0):
        end = {"low": lines.low - 20.0} if side > 0 else {"high": lines.high + 20.0}
        sides.append(greatest(replace(lines, **end), grid, wear, line_load, 8.0).border.item())
    assert sides[0] == pytest.approx(sides[1], rel=1e-6)
    assert sides[0] == pytest.approx(found.inner.item(), rel=1e-6)


def test_the_lower_of_two_valleys_carries_more():
    curvature, apart, line_load = 0.03, 0.8, 300.0
    alike = slice_of(lambda p: 0.5 * curvature * (np.abs(p) - apart) ** 2)
    raised = slice_of(lambda p: 0.5 * curvature * (np.abs(p) - apart) ** 2 + np.where(p > 0, 5e-4, 0.0))
    even, uneven = (greatest(*case, line_load) for case in (alike, raised))
    assert uneven.place.item() == pytest.approx(-apart, abs=0.1)
    assert uneven.inner.item() > 1.02 * even.inner.item()


def test_refined_wear_maps_give_the_same_pressure():
    """A ridge as wear leaves it: its greatest pressure settles while nodes get closer."""

    def worn(p):
        return 5e-3 * (1.0 - np.exp(-np.abs(p) / 0.5))

    found = [
        greatest(*slice_of(worn, across=0.03, points=points), 300.0).inner.item() for points in (101, 201, 401, 801)
    ]
    fresh = line_contact_pressure(np.array(300.0), np.array(0.03), MODULUS)
    assert min(found) > 1.1 * fresh
    # the ridge is rounded over a node spacing, 0.16 to 0.02 mm, of the 0.6 mm that touch: so is its peak
    steps = np.abs(np.diff(found)) / found[-1]
    assert steps[-1] < 0.03
    assert steps[-1] < max(steps)


# ---------------------------------------------------------------- scene


def test_plan_says_what_runs(shipped):
    scene = shipped.replace({"numerics.fidelity": "patch", "numerics.wear_mapping": "marched"})
    chosen = {choice.slot: choice.chosen for choice in plan(scene).choices}
    assert "patches" in chosen["contact"]
    assert "marched" in chosen["wear mapping"]
    assert "interpolated" in {choice.slot: choice.chosen for choice in plan(shipped).choices}["wear mapping"]


def test_a_mesh_position_is_solved_once_under_a_wear_step(monkeypatch):
    """The wear of the step is counted in the approach that is looked at."""
    wears = {"wear.until.control_depths_um": (6.0, 12.0), "numerics.fidelity": "patch", "numerics.threads": 1}
    solved, tried = [], []
    solve, share = patch_contact._Position.solve, patch_contact.share_torque
    monkeypatch.setattr(patch_contact._Position, "solve", lambda *args: (solved.append(1), solve(*args))[1])
    monkeypatch.setattr(patch_contact, "share_torque", lambda *args: (tried.append(1), share(*args))[1])
    sw.simulate(scene_of(SMALL, wears, wears=True))
    assert len(tried) <= 1.02 * len(solved)
