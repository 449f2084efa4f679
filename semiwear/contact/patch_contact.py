"""Loaded contact of all tooth pairs with pressure resolved in two dimensions: fidelity `patch`.

For every mesh position: cell forces f >= 0 on patches that follow the contact lines of all pairs, and one rotation
of the driving body (`patch_system`). Under each pair lies the half-space with Love's uniformly loaded rectangles;
teeth and rims are felt slice by slice, as at fidelity `line`, and that fidelity gives the start. The gap is taken
over the flanks up to their rounded edges, so that contact beyond the path of action needs no case of its own.

Slightly bent lines are treated as straight: a patch keeps its arc lengths, not its chords.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from math import pi

import numpy as np
from numpy.typing import NDArray

from semiwear.closed_forms.love import love_coefficients
from semiwear.compliance.half_space import HalfSpace
from semiwear.compliance.tooth import CompliantBody
from semiwear.contact.complementarity import ComplementarityStatus
from semiwear.contact.footprint import Footprints
from semiwear.contact.line_contact import LineContact
from semiwear.contact.line_loads import LineLoads
from semiwear.contact.mesh_position import MeshPosition
from semiwear.contact.patch_gap import PatchCells
from semiwear.contact.patch_system import PatchSystem, SharedTorque, share_torque
from semiwear.contact.subsurface import GreatestSubsurfaceStress, greatest_subsurface_stress
from semiwear.contact.teeth_solver import SlicePressures
from semiwear.errors import ConvergenceError
from semiwear.meshing.contact_lines import ContactLines

__all__ = ["PatchContact", "PatchLoads"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_APPROACHES = 60  # more cells let the approach grow less, so that a few are enough; doubled where no cell touches
_MARGIN = 1.1  # of the expected approach, within which gaps can close
_LEAST_APPROACH = 0.1  # of a usual one: what is looked at, at least
_AROUND = 8.0  # half-widths along the line that stress below the surface feels
_ROWS = 8  # rows of a patch come in multiples


@dataclass
class PatchLoads:
    """Loads on patches; changed in place while positions are solved.

    Attributes
    ----------
    cells : (roll, face, columns) array [N]
        Normal force on each cell; the fresh line in the middle of the columns.
    force : (roll, face) array [N]
        On each slice.
    half_width : (roll, face) array [mm]
        Half-width of the Hertz contact with the same load and greatest pressure.
    rotation : (mesh_position,) array [rad]
        Rotation of the driving body beyond its nominal place.
    iterations : (mesh_position,) int array
        Convolutions.
    balance, complementarity : (mesh_position,) arrays
        Relative error of the torque; greatest gap where cells press, or penetration elsewhere, over the approach.
    """

    cells: FloatArray
    force: FloatArray
    half_width: FloatArray
    rotation: FloatArray
    iterations: IntArray
    balance: FloatArray
    complementarity: FloatArray

    def copy(self) -> PatchLoads:
        """An independent copy."""
        return PatchLoads(*(getattr(self, entry.name).copy() for entry in fields(self)))

    def with_columns(self, columns: int) -> FloatArray:
        """The cells in rows of at least so many columns."""
        more = max(columns - self.cells.shape[-1], 0) // 2
        return np.pad(self.cells, ((0, 0), (0, 0), (more, more))) if more else self.cells


@dataclass
class PatchContact:
    """Contact solver on patches.

    Attributes
    ----------
    line : LineContact
        The same contact at fidelity `line`: candidates, compliance of the teeth, and the start.
    cells : PatchCells
        Cells at the positions of `line`.
    max_iterations : int
        Convolutions at a mesh position.
    """

    line: LineContact
    cells: PatchCells
    max_iterations: int = 400
    length: float = field(init=False)
    _influence: dict[tuple[int, int], FloatArray] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        near = self.line.is_near(self.line.lines)
        if not near.any():
            raise ConvergenceError(
                "no flank can touch at any mesh position: check the depth of modifications, and the placement if the "
                "pinion is displaced"
            )
        self.length = float(self.line.lines.length[near].mean())

    @property
    def lines(self) -> ContactLines:
        """Lines of all roll positions."""
        return self.line.lines

    @property
    def per_cycle(self) -> int:
        """Mesh positions in a cycle."""
        return self.line.per_cycle

    @property
    def pairs(self) -> int:
        """Tooth pairs considered at once."""
        return self.line.pairs

    @property
    def bodies(self) -> tuple[CompliantBody, ...]:
        """Tooth compliance of both bodies; empty for rigid teeth."""
        return self.line.bodies

    @property
    def modulus(self) -> float:
        """Effective modulus E* [MPa]."""
        return self.line.modulus

    @property
    def reach(self) -> float:
        """Separation beyond which no slice can touch, however loaded and worn [mm]."""
        return self.line.reach

    @property
    def resolved(self) -> PatchContact:
        """The solver itself, which resolves pressure in two dimensions."""
        return self

    def is_near(self, lines: ContactLines, depth: float = 0.0) -> BoolArray:
        """Slices whose fresh separation is small enough that elasticity and wear may close it, (roll, face).

        `depth` [mm] is the wear that there is already, where it is more than usual.
        """
        return self.line.is_near(lines, depth)

    @property
    def searched(self) -> FloatArray:
        """Separation up to which candidates are known at each mesh position; 0 where not yet looked for [mm]."""
        return self.line.searched

    def search(self, searched: FloatArray) -> None:
        """Know the candidates that a solver knew which had searched so far: its solutions are then the same."""
        self.line.search(searched)

    def line_load(self, loads: PatchLoads) -> FloatArray:
        """Line load q [N/mm], (roll, face)."""
        return loads.force / self.lines.length

    def cell_pressure(self, loads: PatchLoads) -> FloatArray:
        """Pressure of each cell [MPa], (roll, face, columns)."""
        return loads.cells / (self.lines.length * self.cells.width)[..., None]

    def cell_forces(self, loads: PatchLoads) -> tuple[FloatArray, FloatArray]:
        """Force on each cell [N], (roll, face, columns), and its distance from the line [mm], (columns,)."""
        return loads.cells, self.cells.offsets(loads.cells.shape[-1])

    def pressures(self, loads: PatchLoads, worn: Footprints, margin: float) -> SlicePressures:
        """Greatest cell pressures; as in `TeethSolver`."""
        lines, pressure = self.lines, self.cell_pressure(loads)
        offset = self.cells.offsets(pressure.shape[-1])
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

    def with_edges(self, worn: Footprints, loads: PatchLoads, before: Footprints) -> Footprints:
        """As they are: patches resolve edges."""
        return worn

    def contact_pattern(self, loads: PatchLoads) -> FloatArray:
        """Greatest pressure that each node of the flank meets in a mesh [MPa]: (face, profile)."""
        return self.cells.greatest_on_flank(self.cell_pressure(loads))

    def subsurface(self, loads: PatchLoads, roll: int, face: int, poissons_ratio: float) -> GreatestSubsurfaceStress:
        """Greatest stress below the surface around a slice of a roll position."""
        some = _AROUND * self.line.usual_half_width
        rows = slice(max(face - int(some / self.length) - 1, 0), face + int(some / self.length) + 2)
        pressure = self.cell_pressure(loads)[roll, rows]
        return greatest_subsurface_stress(
            pressure, cell=(self.length, self.cells.width), poissons_ratio=poissons_ratio
        )

    def approach(self, loads: PatchLoads) -> FloatArray:
        """Approach along the line of action at each mesh position [mm]."""
        return loads.rotation * self.lines.lever_arm[: self.per_cycle, 0]

    def no_loads(self) -> PatchLoads:
        """No loads yet."""
        rolls, faces = self.lines.profile.shape
        nothing, each = np.zeros((rolls, faces)), np.zeros(self.per_cycle)
        whole = np.zeros(self.per_cycle, dtype=np.int64)
        return PatchLoads(np.zeros((rolls, faces, 0)), nothing, nothing, each, whole, each, each)

    def solve(
        self,
        worn: Footprints,
        loads: PatchLoads,
        wear_compliance: FloatArray | None = None,
        positions: Sequence[int] | None = None,
    ) -> PatchLoads:
        """Solve mesh positions; parameters and errors as in `LineContact.solve`."""
        new = loads.copy()
        for position in range(self.per_cycle) if positions is None else positions:
            self._solve_position(position, worn, new, wear_compliance)
        return new

    def _solve_position(
        self, position: int, worn: Footprints, loads: PatchLoads, wear_compliance: FloatArray | None
    ) -> None:
        line, rolls = self.line, self.line.rolls_of(position)
        lever = float(self.lines.lever_arm.max())
        least = float(worn.least[rolls].min())
        first: LineLoads | None = None
        if loads.force[rolls].any():
            approach = lever * float(loads.rotation[position])
        else:
            first = self._line_loads(position, worn, wear_compliance)
            approach = lever * float(first.rotation[position]) if first else least + line.typical_approach
        columns = max(loads.cells.shape[-1], self.cells.columns_for(2.0 * line.usual_half_width))
        for _ in range(_APPROACHES):
            approach = least + _MARGIN * max(approach - least, _LEAST_APPROACH * line.typical_approach)
            rows = _Rows.of(line, position, worn, approach)
            gap, reach = self.cells.gap(rows.rolls, rows.faces, approach, columns, worn.removed)
            if reach > (0.5 * columns - 0.5) * self.cells.width:
                columns = self.cells.columns_for(reach)
                gap, _ = self.cells.gap(rows.rolls, rows.faces, approach, columns, worn.removed)
            if not np.isfinite(gap[rows.candidate >= 0]).any():
                approach = self._farther(position, least, approach)
                continue
            if first is not None:
                guess = self._hertz(rows, columns, worn, first)
            else:
                guess = _fitted(loads.cells[rows.rolls, rows.faces], columns)
            solution = self._solve_rows(position, rows, gap, worn, wear_compliance, guess)
            if solution.sharing.status is not ComplementarityStatus.CONVERGED:
                shorter = "" if wear_compliance is None else ", or take shorter wear steps (more numerics.wear_steps)"
                where = f"load sharing stopped at mesh position {position}/{self.per_cycle}: "
                raise ConvergenceError(where + _reason(solution) + shorter)
            # gaps up to the approach were looked at: what reaches farther is solved again with more
            approach = lever * solution.rotation
            if approach <= rows.approach:
                break
        else:
            raise ConvergenceError(
                f"load sharing stopped at mesh position {position}/{self.per_cycle}: the approach, {approach:.3g} mm "
                "by now, grows with every cell that is let touch; check the torque, the materials and "
                "numerics.tooth_compliance"
            )
        self._keep(position, rows, solution, loads)
        if wear_compliance is None:
            worn.require_followed(loads.force, rolls, f"{position}/{self.per_cycle}")

    def _farther(self, position: int, least: float, approach: float) -> float:
        """A greater approach to look at where no cell's middle is nearer: an edge may be steep over a cell."""
        height = float((self.lines.high - self.lines.low).max())
        if approach - least > height:
            raise ConvergenceError(
                f"no cell can touch at mesh position {position}/{self.per_cycle}: the contact is narrower than a "
                "cell; raise numerics.cells_per_half_width, or give edges a radius"
            )
        return least + 2.0 * (approach - least)

    def _line_loads(self, position: int, worn: Footprints, wear_compliance: FloatArray | None) -> LineLoads | None:
        """The start at fidelity `line`; none where that fails, which is no reason for patches to fail."""
        try:
            return self.line.solve(worn, self.line.no_loads(), wear_compliance, [position])
        except ConvergenceError:
            return None

    def _hertz(self, rows: _Rows, columns: int, worn: Footprints, first: LineLoads) -> FloatArray:
        """Line loads as semi-ellipses around the footprints: where cells are first taken to touch."""
        at = (rows.rolls, rows.faces)
        offset = self.cells.offsets(columns)
        centre = (worn.profile[at] - self.lines.profile[at]) * self.lines.spacing[at]
        width = np.maximum(first.half_width[at], self.cells.width)
        shape = np.sqrt(np.maximum(1.0 - ((offset - centre[:, None]) / width[:, None]) ** 2, 0.0))
        total = shape.sum(axis=1)
        return first.force[at][:, None] * shape / np.where(total > 0.0, total, 1.0)[:, None]

    def _solve_rows(
        self,
        position: int,
        rows: _Rows,
        gap: FloatArray,
        worn: Footprints,
        wear_compliance: FloatArray | None,
        guess: FloatArray,
    ) -> SharedTorque:
        columns = gap.shape[1]
        gap[rows.candidate < 0] = np.inf
        on = np.flatnonzero(rows.candidate >= 0)
        smooth = np.zeros((rows.rolls.size, rows.rolls.size))
        smooth[np.ix_(on, on)] = rows.system.compliance(rows.system.smooth, rows.candidate[on], worn, wear_compliance)
        cell = (self.length, self.cells.width)
        system = PatchSystem(
            starts=rows.starts,
            half_spaces=tuple(HalfSpace((int(count), columns), cell, self.modulus) for count in np.diff(rows.starts)),
            per_force=1.0 / (cell[0] * cell[1]),
            smooth=smooth,
            coefficients=self._coefficients(int(np.diff(rows.starts).max()), columns),
        )
        lever = self.lines.lever_arm[rows.rolls, rows.faces]
        return share_torque(system, gap, lever, float(self.line.torque[position]), guess, self.max_iterations)

    def _coefficients(self, rows: int, columns: int) -> FloatArray:
        known = self._influence.get((rows, columns))
        if known is None:
            cell = (self.length, self.cells.width)
            known = love_coefficients((rows, columns), cell) / (self.modulus * cell[0] * cell[1])
            self._influence[rows, columns] = known
        return known

    def _keep(self, position: int, rows: _Rows, solution: SharedTorque, loads: PatchLoads) -> None:
        cells = solution.sharing.pressure
        columns = cells.shape[1]
        loads.cells = loads.with_columns(columns)
        all_rolls, at = self.line.rolls_of(position), (rows.rolls, rows.faces)
        more = (loads.cells.shape[-1] - columns) // 2
        loads.cells[all_rolls] = 0.0
        loads.force[all_rolls] = 0.0
        loads.half_width[all_rolls] = 0.0
        loads.cells[rows.rolls, rows.faces, more : more + columns] = cells
        force, greatest = cells.sum(axis=1), cells.max(axis=1)
        loads.force[at] = force
        # Hertz: b = 2 q / (pi p0)
        loads.half_width[at] = 2.0 * force * self.cells.width / (pi * np.where(greatest > 0.0, greatest, 1.0))
        loads.rotation[position] = solution.rotation
        loads.iterations[position] = solution.sharing.iterations
        loads.balance[position] = solution.balance
        loads.complementarity[position] = solution.complementarity


def _reason(solution: SharedTorque) -> str:
    if solution.sharing.status is ComplementarityStatus.NOT_POSITIVE:
        return "the compliance is not positive definite; raise numerics.harmonics or use fewer numerics.face_slices"
    return (
        f"the contact still changes after {solution.sharing.iterations} convolutions (gap "
        f"{solution.complementarity:.1e} of the approach); change numerics.cells_per_half_width"
    )


@dataclass(frozen=True)
class _Rows:
    """Rows of cells at a mesh position: a stretch of slices of every pair that may touch.

    Attributes
    ----------
    system : MeshPosition
    approach : float [mm]
        Gaps up to it were looked at.
    rolls, faces : (n,) int arrays
    starts : (pairs + 1,) int array
        First row of each pair that has any.
    candidate : (n,) int array
        Index in the candidates of `system`; -1 where there is none.
    """

    system: MeshPosition
    approach: float
    rolls: IntArray
    faces: IntArray
    starts: IntArray
    candidate: IntArray

    @classmethod
    def of(cls, line: LineContact, position: int, worn: Footprints, approach: float) -> _Rows:
        """Slices nearer than the approach [mm], and what lies between them."""
        system = line.mesh_position(position, approach)
        slices = line.lines.face.size
        place = np.full(line.lines.profile.size, -1)
        place[system.index] = np.arange(system.index.size)
        rolls, faces, starts = [], [], [0]
        for roll in line.rolls_of(position):
            near = np.flatnonzero(worn.least[roll] < approach)
            if near.size == 0:
                continue
            # whole multiples, so that few spectra serve all
            count = min(-(-(int(near[-1] - near[0]) + 1) // _ROWS) * _ROWS, slices)
            first = min(int(near[0]), slices - count)
            rolls.append(np.full(count, roll))
            faces.append(np.arange(first, first + count))
            starts.append(starts[-1] + count)
        at = np.concatenate(rolls), np.concatenate(faces)
        return cls(system, approach, *at, np.array(starts), place[np.ravel_multi_index(at, line.lines.profile.shape)])


def _fitted(cells: FloatArray, columns: int) -> FloatArray:
    """Rows of cells cut, or filled with zeros, to so many columns around the middle."""
    more = (columns - cells.shape[-1]) // 2
    if more >= 0:
        return np.pad(cells, ((0, 0), (more, more)))
    return cells[:, -more:more]
