"""Fidelity `patch`: pressure resolved in two dimensions on cells that follow the contact lines of all pairs.

For every mesh position: cell forces f >= 0 and one rotation of the driving body (`patch_sharing`). Under each pair
lies the half-space with Love's uniformly loaded rectangles; teeth and rims deflect slice by slice, as at fidelity
`line`, which gives the start, but a force bends teeth at its cell, and bent flanks lean away from the cells
nearer to a tip. The gap is taken over the flanks up to their rounded edges, so that contact beyond the path of action
needs no special case.

Slightly bent lines are treated as straight: a patch keeps its arc lengths, not its chords.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from math import pi
from typing import NamedTuple

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.closed_forms.love import love_coefficients
from semiwear.contact.complementarity import ComplementarityStatus
from semiwear.contact.fidelity import Fidelity
from semiwear.contact.footprint import Footprints
from semiwear.contact.gap import FlankGap, gap_of_flanks
from semiwear.contact.line_contact import solve_lines
from semiwear.contact.loads import SlicePressures, TeethLoads
from semiwear.contact.patch_gap import PatchCells
from semiwear.contact.patch_sharing import FORCE_TOLERANCE, SharedTorque, share_torque
from semiwear.contact.patch_system import PatchSystem, rows_of_pairs
from semiwear.contact.problem import Candidates, ContactProblem
from semiwear.contact.subsurface import GreatestSubsurfaceStress, greatest_subsurface_stress
from semiwear.errors import ConvergenceError
from semiwear.kernel_cache import ZERO, njit
from semiwear.meshing.flank_grid import first_from
from semiwear.threads import in_shares

_APPROACHES = 60  # the approach grows less with more cells, so that a few are enough; doubled where no cell touches
_ROUGH_FORCE_TOLERANCE = 1e-6  # of the forces, for loads that serve only as a start or for a step length
_CONVOLUTIONS = 400  # at a mesh position
_MARGIN = 1.05  # of the expected approach, within which gaps can close
_LEAST_APPROACH = 0.1  # of a typical one: least range of gaps that is considered
_AROUND = 8.0  # half-widths along the line within which pressure contributes to the stress below the surface
_ROWS = 8  # rows of a patch come in multiples


def solve_cells(
    problem: ContactProblem,
    worn: Footprints,
    start: TeethLoads | None = None,
    wear_compliance: FloatArray | None = None,
    positions: Sequence[int] | None = None,
    *,
    tolerance: float = FORCE_TOLERANCE,
) -> TeethLoads:
    """Loads of the cells and slices; as in `SolveLoads`, with forces to a relative tolerance."""
    loads = problem.no_loads() if start is None else start.copy()
    flanks = gap_of_flanks(problem.lines, worn.removed)
    if worn.nearer is not None:
        separation = flanks.separation.copy()
        separation[0] -= worn.nearer
        flanks = flanks._replace(separation=separation)

    def solve(part: IntArray) -> list[_Found]:
        positions = (_Position(problem, int(position), worn, flanks, wear_compliance, tolerance) for position in part)
        return [position.solve(loads) for position in positions]

    chosen = np.arange(problem.per_cycle) if positions is None else np.array(positions, dtype=np.int64)
    solved = [found for part in in_shares(solve, chosen) for found in part]
    loads.cells = _with_columns(loads.cells, max((found.cells.shape[1] for found in solved), default=0))
    for found in solved:
        _keep(problem, found, loads)
    if wear_compliance is None:
        worn.require_followed(loads.force, chosen, problem.per_cycle)
    return loads


def cell_pressures(problem: ContactProblem, loads: TeethLoads, worn: Footprints, margin: float) -> SlicePressures:
    """Greatest cell pressures; as in `Fidelity`."""
    lines, cells = problem.lines, _cells_of(problem)
    pressure = cells.pressure(loads.cells)
    offset = cells.offsets(pressure.shape[-1])
    first = (lines.low - lines.profile) * lines.spacing + margin
    last = (lines.high - lines.profile) * lines.spacing - margin
    inside = (offset >= first[..., None]) & (offset <= last[..., None])
    inner = np.where(inside, pressure, 0.0)
    at = inner.argmax(axis=-1)
    return SlicePressures(
        inner=inner.max(axis=-1),
        place=lines.profile + offset[at] / lines.spacing,
        border=np.where(inside, 0.0, pressure).max(axis=-1),
    )


def _as_they_are(
    problem: ContactProblem,
    worn: Footprints,
    loads: TeethLoads,
    before: Footprints,
    rolls: BoolArray | None = None,
) -> Footprints:
    """Footprints unchanged: patches resolve edges."""
    return worn


PATCH = Fidelity(
    solve_cells, _as_they_are, cell_pressures, roughly=partial(solve_cells, tolerance=_ROUGH_FORCE_TOLERANCE)
)
"""Forces on cells, with Love's half-space under each pair."""


def subsurface_stress(
    problem: ContactProblem, loads: TeethLoads, roll: int, face: int, poissons_ratio: float
) -> GreatestSubsurfaceStress:
    """Greatest stress below the surface around a slice of a roll position."""
    cells, length = _cells_of(problem), problem.slice_length
    distance = _AROUND * problem.usual_half_width
    rows = slice(max(face - int(distance / length) - 1, 0), face + int(distance / length) + 2)
    pressure = cells.pressure(loads.cells)[roll, rows]
    return greatest_subsurface_stress(pressure, cell=(length, cells.width), poissons_ratio=poissons_ratio)


def _cells_of(problem: ContactProblem) -> PatchCells:
    if problem.cells is None:
        raise ValueError("the contact problem has no cells: give it PatchCells to resolve pressure across its lines")
    return problem.cells


@lru_cache(maxsize=64)
def _coefficients(rows: int, columns: int, cell: tuple[float, float], modulus: float) -> FloatArray:
    """Displacement under a unit force on a cell [mm/N], by distance in rows and columns."""
    return love_coefficients((rows, columns), cell) / (modulus * cell[0] * cell[1])


@dataclass(frozen=True)
class _Position:
    """A mesh position to be solved on worn flanks."""

    problem: ContactProblem
    position: int
    worn: Footprints
    flanks: FlankGap
    wear_compliance: FloatArray | None
    tolerance: float

    @property
    def where(self) -> str:
        """The position, for messages."""
        return f"mesh position {self.position}/{self.problem.per_cycle}"

    def solve(self, loads: TeethLoads) -> _Found:
        """Loads of the position, from those in `loads` as a start."""
        problem, worn, cells = self.problem, self.worn, _cells_of(self.problem)
        rolls, lever = problem.rolls_of(self.position), float(problem.lines.lever_arm.max())
        least, usual = float(worn.least[rolls].min()), problem.typical_approach
        first: TeethLoads | None = None
        iterations = 0
        start: FloatArray | None = None  # (pairs, slices, columns) forces
        if loads.force[rolls].any():
            approach = lever * float(loads.rotation[self.position]) + self._growth(loads.force[rolls], rolls)
        else:
            first = self._line_loads()
            approach = lever * float(first.rotation[self.position]) if first else least + usual
        most = max(loads.cells.shape[-1], cells.columns_for(2.0 * problem.usual_half_width))
        for _ in range(_APPROACHES):
            approach = least + _MARGIN * max(approach - least, _LEAST_APPROACH * usual)
            rows = _Rows.of(problem, self.position, worn, approach)
            gap, reach = cells.gap(rows.rolls, rows.faces, approach, most, self.flanks)
            columns = cells.columns_for(reach)
            if columns > most:
                gap, _ = cells.gap(rows.rolls, rows.faces, approach, columns, self.flanks)
            gap = _fitted(gap, columns)
            if not np.isfinite(gap[rows.candidate >= 0]).any():
                approach = self._farther(least, approach)
                continue
            if start is None:
                start = loads.cells[rolls] if first is None else self._hertz(rolls, columns, first)
            solution = self._share(rows, gap, _fitted(start[rows.pairs(problem), rows.faces], columns))
            iterations += solution.sharing.iterations
            if solution.sharing.status is not ComplementarityStatus.CONVERGED:
                longer = self.wear_compliance is not None
                shorter = ", or take shorter wear steps (more numerics.wear_steps)" if longer else ""
                raise ConvergenceError(f"load sharing stopped at {self.where}: {_reason(solution, problem)}{shorter}")
            # gaps up to the approach were considered: if the solution reaches farther, it is solved again with more
            approach = lever * solution.rotation
            if approach <= rows.approach:
                return _Found(self.position, rows, solution, iterations)
            start = np.zeros((problem.pairs, problem.lines.face.size, columns))
            start[rows.pairs(problem), rows.faces] = solution.sharing.pressure
        raise ConvergenceError(
            f"load sharing stopped at {self.where}: the approach, {approach:.3g} mm by now, grows with every "
            "cell that may touch; check the torque, the materials and numerics.tooth_compliance"
        )

    def _growth(self, force: FloatArray, rolls: IntArray) -> float:
        """Further approach of the flanks in a wear step [mm]: its wear, weighted with the forces.

        A start that was found in a wear step counts it twice, which only adds cells.
        """
        if self.wear_compliance is None:
            return 0.0
        return float((self.wear_compliance[rolls] * force**2).sum() / force.sum())

    def _farther(self, least: float, approach: float) -> float:
        """A greater approach, if no cell's middle is nearer: an edge may be steep over a cell."""
        lines = self.problem.lines
        if approach - least > float((lines.high - lines.low).max()):
            raise ConvergenceError(
                f"no cell can touch at {self.where}: the contact is narrower than a cell; raise "
                "numerics.cells_per_half_width, or give edges a radius"
            )
        return least + 2.0 * (approach - least)

    def _line_loads(self) -> TeethLoads | None:
        """The start at fidelity `line`; None if that fails, since patches may still converge."""
        try:
            return solve_lines(self.problem, self.worn, None, self.wear_compliance, [self.position])
        except ConvergenceError:
            return None

    def _hertz(self, rolls: IntArray, columns: int, first: TeethLoads) -> FloatArray:
        """Line loads as semi-ellipses around the footprints, the first guess of the cells' forces."""
        lines, cells = self.problem.lines, _cells_of(self.problem)
        offset = cells.offsets(columns)
        centre = (self.worn.profile[rolls] - lines.profile[rolls]) * lines.spacing[rolls]
        width = np.maximum(first.half_width[rolls], cells.width)
        shape = np.sqrt(np.maximum(1.0 - ((offset - centre[..., None]) / width[..., None]) ** 2, 0.0))
        total = shape.sum(axis=-1)
        return first.force[rolls][..., None] * shape / np.where(total > 0.0, total, 1.0)[..., None]

    def _share(self, rows: _Rows, gap: FloatArray, guess: FloatArray) -> SharedTorque:
        problem, cell = self.problem, (self.problem.slice_length, _cells_of(self.problem).width)
        flanks, wear = self.flanks, self.wear_compliance
        offsets, flat_wear = _cells_of(problem).offsets(gap.shape[1]), np.zeros(0) if wear is None else wear.ravel()
        smooth, tilt, aside, across, lever = _between_rows(
            rows.candidate, rows.candidates, rows.rolls, rows.faces, self.worn.profile, flanks.profile,
            flanks.spacing, problem.lines.lever_arm, offsets, flat_wear, gap,
        )  # fmt: skip
        system = PatchSystem(
            starts=rows.starts,
            cell=cell,
            modulus=problem.modulus,
            smooth=smooth,
            tilt=tilt,
            aside=aside,
            across=across,
            coefficients=_coefficients(max(rows_of_pairs(rows.starts)), gap.shape[1], cell, problem.modulus),
        )
        return share_torque(
            system, gap, lever, float(problem.torque[self.position]), guess, _CONVOLUTIONS, self.tolerance
        )


@njit(cache=True, error_model="numpy", nogil=True)
def _between_rows(candidate, known, rolls, faces, worn, profile, spacing, lever_arm, offsets, wear, gap):  # type: ignore[no-untyped-def]
    """`smooth`, `tilt`, `aside` and `across` of a `PatchSystem`, and lever arms of its rows [mm].

    `worn` and `profile` (roll, face) are the positions of footprints and fresh lines; `wear` is flat, and empty
    outside wear steps; gaps of rows that are no candidates become infinite.
    """
    rows, columns = gap.shape
    smooth, tilt, aside = np.zeros((rows, rows)), np.zeros((rows, rows)), np.zeros((rows, rows))
    across, lever, moved = np.zeros((rows, columns)), np.empty(rows), np.zeros(rows)
    for r in range(rows):
        k, i, own = rolls[r], faces[r], candidate[r]
        lever[r] = lever_arm[k, i]
        if own < 0:
            gap[r] = np.inf
            continue
        moved[r] = min(max(worn[k, i] - known.profile[own], -known.farthest_move), known.farthest_move)
        # tooth compliance refers to the footprints
        footprint, farthest = (worn[k, i] - profile[k, i]) * spacing[k, i], known.farthest_aside[own]
        for c in range(columns):
            across[r, c] = min(max(offsets[c] - footprint, -farthest), farthest)
    for r in range(rows):
        own, per_mm = candidate[r], spacing[rolls[r], faces[r]]
        for s in range(rows):
            other = candidate[s]
            if own < 0 or other < 0:
                continue
            change = known.slope[own, other] * moved[r] + known.slope[other, own] * moved[s]
            smooth[r, s] = known.smooth[own, other] + change
            tilt[r, s] = known.slope[own, other] / per_mm
            aside[r, s] = known.aside[own, other]
        if own >= 0 and wear.size > 0:
            smooth[r, r] += wear[known.flat[own]]
    return smooth, tilt, aside, across, lever


class _Found(NamedTuple):
    """Loads of a mesh position.

    Attributes
    ----------
    position : int
    rows : _Rows
    solution : SharedTorque
    iterations : int
        Of all approaches that were tried.
    """

    position: int
    rows: _Rows
    solution: SharedTorque
    iterations: int

    @property
    def cells(self) -> FloatArray:
        """Forces on the cells of the rows [N]."""
        return self.solution.sharing.pressure


def _keep(problem: ContactProblem, found: _Found, loads: TeethLoads) -> None:
    """Store the loads of a mesh position in `loads`."""
    rows, position = found.rows, found.position
    _put(
        found.cells, rows.rolls, rows.faces, problem.rolls_of(position), _cells_of(problem).width, loads.cells,
        loads.force, loads.half_width,
    )  # fmt: skip
    loads.rotation[position] = found.solution.rotation
    loads.iterations[position] = found.iterations
    loads.balance[position] = found.solution.balance
    loads.complementarity[position] = found.solution.complementarity


@njit(cache=True, error_model="numpy", nogil=True)
def _put(found, rolls, faces, every, width, cells, force, half_width):  # type: ignore[no-untyped-def]
    """Store forces on rows of cells [N] in those of all slices; the rest is zero at the roll positions `every`.

    Parameters
    ----------
    found : (rows, columns) array [N]
    rolls, faces : (rows,) int arrays
    every : (pairs,) int array
    width : float [mm]
        Of a cell.
    cells : (roll, face, at least as many columns) array [N], changed
    force, half_width : (roll, face) arrays [N], [mm], changed
    """
    for roll in every:
        cells[roll], force[roll], half_width[roll] = 0.0, 0.0, 0.0
    more = (cells.shape[2] - found.shape[1]) // 2
    for r in range(rolls.shape[0]):
        k, i, total, greatest = rolls[r], faces[r], 0.0, 0.0
        for c in range(found.shape[1]):
            cells[k, i, more + c] = found[r, c]
            total += found[r, c]
            greatest = max(greatest, found[r, c])
        force[k, i] = total
        # Hertz: b = 2 q / (pi p0)
        half_width[k, i] = 2.0 * total * width / (pi * greatest) if greatest > 0.0 else 0.0


def _reason(solution: SharedTorque, problem: ContactProblem) -> str:
    if solution.sharing.status is ComplementarityStatus.NOT_POSITIVE:
        return problem.why_not_positive()
    return (
        f"the contact still changes after {solution.sharing.iterations} convolutions (gap "
        f"{solution.complementarity:.1e} of the approach); change numerics.cells_per_half_width"
    )


@dataclass(frozen=True)
class _Rows:
    """Rows of cells at a mesh position: a stretch of slices of every pair that may touch.

    Attributes
    ----------
    candidates : Candidates
    approach : float [mm]
        Greatest gap that was considered.
    rolls, faces : (n,) int arrays
    starts : (pairs + 1,) int array
        First row of each pair that has rows.
    candidate : (n,) int array
        Index in `candidates`; -1 where there is none.
    """

    candidates: Candidates
    approach: float
    rolls: IntArray
    faces: IntArray
    starts: IntArray
    candidate: IntArray

    def pairs(self, problem: ContactProblem) -> IntArray:
        """Tooth pair of each row."""
        return self.rolls // problem.per_cycle

    @classmethod
    def of(cls, problem: ContactProblem, position: int, worn: Footprints, approach: float) -> _Rows:
        """Slices nearer than the approach [mm], and those between them."""
        candidates = problem.candidates(position, approach)
        return cls(
            candidates, approach, *_find_rows(problem.rolls_of(position), worn.least, approach, candidates.flat)
        )


@njit(cache=True, error_model="numpy", nogil=True)
def _find_rows(rolls, least, approach, flat):  # type: ignore[no-untyped-def]
    """`rolls`, `faces`, `starts` and `candidate` of `_Rows`; `flat` are the candidates, rising."""
    slices = least.shape[1]
    most = rolls.size * slices
    row_rolls, row_faces = np.empty(most, dtype=np.int64), np.empty(most, dtype=np.int64)
    index = np.empty(most, dtype=np.int64)
    starts, pairs, n = np.zeros(rolls.size + 1, dtype=np.int64), ZERO, ZERO
    for roll in rolls:
        near, last = slices, -1
        for i in range(slices):
            if least[roll, i] < approach:
                near, last = min(near, i), i
        if last < 0:
            continue
        # in multiples, so that few spectra are needed
        count = min((last - near + _ROWS) // _ROWS * _ROWS, slices)
        first = min(near, slices - count)
        for i in range(first, first + count):
            flat_index = roll * slices + i
            at = first_from(flat, flat_index)
            row_rolls[n], row_faces[n] = roll, i
            index[n] = at if at < flat.size and flat[at] == flat_index else -1
            n += 1
        pairs += 1
        starts[pairs] = n
    return row_rolls[:n], row_faces[:n], starts[: pairs + 1], index[:n]


def _with_columns(cells: FloatArray, columns: int) -> FloatArray:
    """The cells in rows of at least `columns` columns."""
    more = max(columns - cells.shape[-1], 0) // 2
    return np.pad(cells, ((0, 0), (0, 0), (more, more))) if more else cells


def _fitted(cells: FloatArray, columns: int) -> FloatArray:
    """Rows of cells cut, or filled with zeros, to `columns` columns around the middle."""
    more = (columns - cells.shape[-1]) // 2
    if more > 0:
        wider = np.zeros((cells.shape[0], columns))
        wider[:, more:-more] = cells
        return wider
    return np.ascontiguousarray(cells[:, -more : cells.shape[1] + more])
