"""Loaded teeth: contact lines, the grid that wears, and a contact solver of either fidelity, bound together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.contact.fidelity import Fidelity
from semiwear.contact.footprint import Footprints, footprints
from semiwear.contact.footprint_windows import widest
from semiwear.contact.loads import SlicePressures, TeethLoads
from semiwear.contact.problem import ContactProblem
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.driving_flank import DrivingFlank, PassedStations
from semiwear.meshing.flank_grid import FlankGrid
from semiwear.meshing.flank_pair import FlankPair
from semiwear.meshing.removed import Removed
from semiwear.meshing.roll_grid import RollGrid

_TYPICAL_DEPTH = 5.5e-3  # of the base pitch: wear and modification that the problem's reach always includes
_EDGE_PASSES = 3  # pressed edges yield under their loads, and loads follow as they yield: Newton's steps
_EDGE_TOLERANCE = 1e-2  # of the greatest force on a slice
_FIRST_PASSES, _FIRST_TOLERANCE = 4, 3e-3  # of the same, if no loads are known; below it edges yield in cells
_SMOOTH_PASSES, _SMOOTH_TOLERANCE = 12, 1e-7  # of the same, where results are to be smooth
_BENDS = 0.03  # of a half-width, second difference over solved positions: a path that bends less is taken as straight
_ALONG = 6.0  # contact widths from a pressed edge, within which it affects the loads of other slices


@dataclass(frozen=True)
class LoadedState:
    """Elastic contact over a mesh cycle on one worn flank.

    Attributes
    ----------
    wear : (face, profile) array [mm]
        Of the driven flank.
    touched : Footprints
        At the solved positions, on the worn flanks.
    coarse : Footprints
        The same with the compliance of pressed edges.
    loads : TeethLoads
    driving_wear : (face, profile) array [mm] or None
        Of the driving flank, on its own grid; None where it does not wear.
    edge_residual : float
        Greatest change of a slice's force in the last pass over pressed edges, over the greatest force.
    """

    wear: FloatArray
    touched: Footprints
    coarse: Footprints
    loads: TeethLoads
    driving_wear: FloatArray | None = None
    edge_residual: float = 0.0


@dataclass(frozen=True)
class LoadedTeeth:
    """Teeth under load: everything that does not change while a flank wears.

    Attributes
    ----------
    pair : FlankPair
    rolls : RollGrid
    fine, lines : ContactLines
        On the fine roll grid, and at the positions that are solved.
    grid : FlankGrid
    problem : ContactProblem
        At the solved positions.
    fidelity : Fidelity
    half_width : float [mm]
        Hertz half-width at the pitch point with the whole torque on one fresh tooth: the reference width of
        footprints and the half-width of the pitch band.
    zero : float [mm]
        Mean unloaded, unworn separation over a mesh cycle of this placement: where transmission error is zero.
    modification : (rows, face, profile) array [mm] or None
        Material removed from unworn flanks at the driven one's nodes: one row, or one per roll position of `fine`.
    driving : DrivingFlank or None
        Grid of the driving flank's wear; None where it does not wear.
    smooth : bool
        Whether everything is iterated until results are smooth functions of the scene's fields, as differences of
        runs need; otherwise until they are accurate enough.
    """

    pair: FlankPair
    rolls: RollGrid
    fine: ContactLines
    lines: ContactLines
    grid: FlankGrid
    problem: ContactProblem
    fidelity: Fidelity
    half_width: float
    zero: float
    modification: FloatArray | None = None
    driving: DrivingFlank | None = None
    smooth: bool = False

    @property
    def on_path(self) -> BoolArray:
        """Where the lines of the solved positions lie on the flank, near contact and in motion, (roll, face)."""
        lines = self.lines
        inside = (lines.profile > lines.low) & (lines.profile < lines.high) & np.isfinite(lines.separation[0])
        # a shifted pinion turns until the flanks touch, at the separation `zero`
        inside &= lines.separation[0] - self.zero < self.problem.reach
        # where a line stops or turns at a border, its speed is not that of the flank
        inside[1:-1] &= inside[2:] & inside[:-2]
        return np.asarray(inside)

    @property
    def driving_profile(self) -> FloatArray:
        """Nodes of the driving flank, (face, profile) [mm]: those of its wear, or even from root to tip."""
        if self.driving is not None:
            return self.driving.grid.profile
        borders = self.pair.borders(self.grid.face)
        nodes = np.linspace(borders.driving_root, borders.driving_tip, self.grid.profile.shape[1])
        return np.broadcast_to(nodes, self.grid.profile.shape)

    @cached_property
    def driving_stations(self) -> PassedStations:
        """Stations of the driving flank among the slices that meet it at the solved positions."""
        return PassedStations.of(self.lines.driving_face, self.grid.face)

    def removed(
        self, wear: FloatArray, driving_wear: FloatArray | None = None, slices: IntArray | None = None
    ) -> Removed:
        """Material removed from both flanks on the fine roll grid.

        Parameters
        ----------
        wear : (face, profile) array [mm]
        driving_wear : (face, profile) array [mm], optional
        slices : int array, optional
            To compute where both flanks wear; the others are not filled.
        """
        if driving_wear is None or self.driving is None:
            return fresh_flanks(self.fine, self.grid, self.modification, wear)
        grid = self.driving.driven
        depth = self.driving.met(driving_wear, grid.from_grid(wear), self._finer_modification, slices)
        return Removed.met(grid, depth, self.fine.roll.size)

    def removed_at_nodes(
        self,
        wear: FloatArray,
        driving_wear: FloatArray,
        slices: IntArray,
        windows: IntArray,
        before: Removed | None = None,
    ) -> Removed:
        """The same with wear of both flanks, between the nodes of windows only, (roll, face, 2).

        The memory of `before` is reused.
        """
        assert self.driving is not None
        grid, unworn = self.driving.driven, self._finer_modification
        into = before.depth if before else None
        depth = self.driving.met(driving_wear, grid.from_grid(wear), unworn, slices, windows, into)
        return replace(Removed.met(grid, depth, self.fine.roll.size), windows=windows)

    def widest_windows(
        self,
        wear: FloatArray,
        driving_wear: FloatArray,
        loaded: BoolArray,
        wears: float = 0.0,
        lines: ContactLines | None = None,
    ) -> IntArray:
        """Nodes between which footprints of loaded slices (roll, face) may lie on flanks with this wear, or more.

        On `lines`; on those of the fine roll grid by default.
        """
        assert self.driving is not None
        grid = self.driving.driven
        worn = grid.from_grid(wear), self._finer_modification, driving_wear
        deepest = sum(float(depth.max()) for depth in worn) + wears  # all depths are zero or more
        return widest(self.fine if lines is None else lines, grid, loaded, deepest, self.half_width)

    @cached_property
    def _finer_modification(self) -> FloatArray:
        """`modification` at the nodes of `driving.driven`, (rows, face, profile) [mm]."""
        assert self.driving is not None
        grid = self.driving.driven
        return np.zeros((1, *grid.profile.shape)) if self.modification is None else grid.from_grid(self.modification)

    def touch(
        self, wear: FloatArray, driving_wear: FloatArray | None = None, chosen: BoolArray | None = None
    ) -> Footprints:
        """Footprints on flanks with wear [mm], on the fine roll grid.

        Of slices that can carry load, or chosen ones of them, (roll, face).
        """
        return self._touch(self.fine, 1, wear, driving_wear, chosen)

    def fine_places(self, wear: FloatArray, driving_wear: FloatArray | None, touched: Footprints) -> FloatArray:
        """Profile coordinates of the footprints' centres on the fine roll grid, (roll, face) [mm].

        Between solved positions they are computed where their path bends, and interpolated linearly elsewhere, as
        distances from the fresh line.

        Parameters
        ----------
        wear, driving_wear : arrays [mm]
            As in `removed`.
        touched : Footprints
            At the solved positions.
        """
        aside = touched.profile - self.lines.profile
        between = np.arange(self.fine.roll.size) % self.rolls.substeps > 0
        bends = np.pad(np.abs(np.diff(aside, 2, axis=0)), ((1, 1), (0, 0)))
        bends = np.maximum(bends[:-1], bends[1:]) * self.lines.spacing[:-1]
        found = np.pad(bends > (0.0 if self.smooth else _BENDS * self.half_width), ((0, 1), (0, 0)))
        found = np.repeat(found, self.rolls.substeps, axis=0) & between[:, None]
        even = self.fine.profile + self.on_fine_rolls(aside)
        return np.where(found, self.touch(wear, driving_wear, found).profile, even)

    def touch_solved(
        self, wear: FloatArray, driving_wear: FloatArray | None = None, chosen: BoolArray | None = None
    ) -> Footprints:
        """As `touch`, at the solved positions."""
        return self._touch(self.lines, self.rolls.substeps, wear, driving_wear, chosen)

    def _touch(
        self,
        lines: ContactLines,
        step: int,
        wear: FloatArray,
        driving_wear: FloatArray | None,
        chosen: BoolArray | None,
    ) -> Footprints:
        """Footprints on worn flanks on lines at every `step`-th position of the fine roll grid."""
        if driving_wear is None or self.driving is None:
            removed = self.removed(wear).every(step)
        else:
            removed = self._removed_on(lines, step, wear, driving_wear, chosen)
        if removed.windows is not None:
            near = removed.windows[..., 0] < removed.windows[..., 1]
        else:
            near = slices_near(self.problem, lines, removed) & (True if chosen is None else chosen)
        return footprints(lines, removed, self.half_width, near)

    def _removed_on(
        self, lines: ContactLines, step: int, wear: FloatArray, driving_wear: FloatArray, chosen: BoolArray | None
    ) -> Removed:
        """Material removed from both flanks on such lines, where footprints of chosen slices may lie."""
        assert self.driving is not None
        driving, unworn = replace(self.driving, lines=lines, near=self.driving.near[::step]), self._finer_modification
        if len(unworn) > 1:
            unworn = np.ascontiguousarray(unworn[::step])
        windows = None
        if chosen is not None:
            windows = self.widest_windows(wear, driving_wear, driving.near & chosen, lines=lines)
        depth = driving.met(driving_wear, driving.driven.from_grid(wear), unworn, windows=windows)
        return replace(Removed.met(driving.driven, depth, lines.roll.size), windows=windows)

    def load(
        self, wear: FloatArray, start: TeethLoads | None = None, driving_wear: FloatArray | None = None
    ) -> LoadedState:
        """Elastic contact on worn flanks [mm], started from other loads when given."""
        coarse = self.touch_solved(wear, driving_wear)
        problem, fidelity = self.problem, self.fidelity
        solved = start is None
        loads = fidelity.solve(problem, coarse) if start is None else start
        # loads of another state seldom give the final compliance of edges
        first = fidelity.solve if start is None or self.smooth else fidelity.roughly or fidelity.solve
        edged, residual = coarse, np.zeros(self.rolls.phase.size)
        unsettled = np.ones(residual.size, dtype=bool)  # mesh positions are independent of one another
        exact = np.full(residual.size, solved)
        passes, tolerance = (_FIRST_PASSES, _FIRST_TOLERANCE) if start is None else (_EDGE_PASSES, _EDGE_TOLERANCE)
        if self.smooth:
            passes, tolerance = _SMOOTH_PASSES, _SMOOTH_TOLERANCE
        for number in range(passes):
            before, rolls = edged, np.tile(unsettled, problem.pairs)
            edged = fidelity.with_edges(problem, coarse, loads, before, rolls)
            if edged is before:
                break
            positions = np.arange(residual.size)
            if solved:
                # elsewhere the loads are those of these footprints already
                positions = np.unique(np.flatnonzero((edged.gap != before.gap).any(axis=1)) % residual.size)
            force, solve = loads.force, fidelity.solve if number else first
            loads, solved = solve(problem, edged, loads, positions=positions.tolist()), True
            exact[positions] = solve is fidelity.solve
            change = np.abs(loads.force - force).max(axis=1).reshape(-1, residual.size).max(axis=0)
            residual[unsettled] = change[unsettled] / loads.force.max()
            unsettled = residual > tolerance
            if not unsettled.any():
                break
        if not exact.all():
            loads = fidelity.solve(problem, edged, loads, positions=np.flatnonzero(~exact).tolist())
        return LoadedState(wear, coarse, edged, loads, driving_wear, float(residual.max()))

    def on_fine_rolls(self, values: FloatArray) -> FloatArray:
        """Values at solved positions, (roll, face), linear between them on the fine grid."""
        steps = self.rolls.substeps
        if steps == 1:
            return values
        following = np.concatenate([values[1:], values[-1:]])
        part = (np.arange(steps) / steps)[None, :, None]
        return np.asarray(((1.0 - part) * values[:, None] + part * following[:, None]).reshape(-1, values.shape[1]))

    def pressures(self, state: LoadedState) -> SlicePressures:
        """Greatest pressures of every slice.

        Nearer than a contact width to an end of either flank, or than six along the line to where an edge presses,
        a pressure counts as at the border: there it depends on the edge's rounding and on the mesh.
        """
        margin = 2.0 * self.half_width
        found = self.fidelity.pressures(self.problem, state.loads, state.coarse, margin)
        aside = self._at_ends(margin) | self._near(found.border > found.inner, _ALONG * margin)
        return SlicePressures(
            inner=np.where(aside, 0.0, found.inner),
            place=found.place,
            border=np.where(aside, np.maximum(found.inner, found.border), found.border),
        )

    def root_stress(self, state: LoadedState) -> FloatArray:
        """Greatest root stress of each body's tooth [MPa], (roll, body), forces where they act on the worn flank.

        At fidelity `patch` they act on every cell, at `line` in the middle of each slice's footprint.
        """
        force, moved = state.loads.force, state.coarse.profile - self.lines.profile
        if self.problem.cells is not None:
            force = state.loads.cells
            moved = self.problem.cells.offsets(force.shape[-1]) / self.lines.spacing[..., None]
        per_cycle = self.rolls.phase.size
        return np.stack([body.root_stress(force, per_cycle, moved) for body in self.problem.bodies], axis=-1)

    def _at_ends(self, margin: float) -> BoolArray:
        """Slices nearer than `margin` to an end of either body's face, (roll, face)."""
        borders = self.pair.borders(self.lines.face)
        face, driving = self.lines.face, self.lines.driving_face
        own = np.minimum(face - borders.face[0], borders.face[1] - face) - borders.end_edge_radius
        theirs = (
            np.minimum(driving - borders.driving_face[0], borders.driving_face[1] - driving)
            - borders.driving_end_edge_radius
        )
        return np.minimum(own, theirs) < margin

    def _near(self, chosen: BoolArray, distance: float) -> BoolArray:
        """Slices within a distance along the line of chosen ones, (roll, face)."""
        near = np.zeros(chosen.shape, dtype=bool)
        for roll in np.flatnonzero(chosen.any(axis=1)):
            arc = self.lines.arc[roll]
            near[roll] = np.abs(arc[:, None] - arc[chosen[roll]]).min(axis=1) < distance
        return near


def fresh_flanks(
    lines: ContactLines, grid: FlankGrid, modification: FloatArray | None, wear: FloatArray | float = 0.0
) -> Removed:
    """Material removed from the flanks by modifications and by wear of the driven flank [mm].

    Parameters
    ----------
    lines : ContactLines
        On the fine roll grid.
    grid : FlankGrid
    modification : (rows, face, profile) array [mm] or None
    wear : (face, profile) array [mm], or none
    """
    depth = np.broadcast_to(wear, grid.profile.shape)[None] if modification is None else modification + wear
    return Removed.met(grid, np.ascontiguousarray(depth), lines.roll.size)


def slices_near(problem: ContactProblem, lines: ContactLines, removed: Removed) -> BoolArray:
    """Slices of lines that can carry load with this material removed, (roll, face)."""
    deepest = float(removed.depth.max())
    return problem.is_near(lines, deepest if deepest > _TYPICAL_DEPTH * problem.base_pitch else 0.0)
