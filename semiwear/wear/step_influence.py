"""Influence of loads on the wear of a step, from footprints found under predicted loads.

The loads of a step depend on the wear that they cause. Predicted loads wear the flanks in n cycles, and the footprint
of every loaded slice is kept, averaged over the cycles. The wear of the step is then a linear function of its loads,
and no footprint is found again while the loads are iterated. Loads far above the predicted ones get footprints of
their own on the same sequence of worn flanks. Under a load spectrum every torque has footprints of its own width, and
all of them wear the same flanks.

In cycle c the footprints are found on flanks ahead of the start of the cycle, extrapolated with the wear w of the
previous cycle:

    h_(c+1) = h_c + w_c,   w_c = w(h_c + a_c w_(c-1)),   a_0 = 0,   a_c = 1/2 + 1/(2 (n - 1))

for cycles of equal length. The second term of a_c compensates for the first cycle, so that the error of the sum of w
is of third order; with a_c = 0 it is of second order. All weights are positive: wear never shrinks.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import reduce
from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.meshing.flank_pair import BODIES, DRIVEN, DRIVING
from semiwear.wear.deposit import sum_of_rows
from semiwear.wear.driving_deposit import sum_of_driving_rows
from semiwear.wear.followed_gap import FollowedGap
from semiwear.wear.footprint_rows import FootprintRows, rows_of
from semiwear.wear.swept_line import EdgeShares, Sweep, wear_of_both_flanks, wear_of_mesh
from semiwear.wear.worn import Worn


class Cycles(NamedTuple):
    """Cycles of a step; the contact geometry is updated after each.

    Attributes
    ----------
    number : float
        Number of cycles; with a fraction the last cycle is shorter.
    ahead : float
        Share of a_c: 0 finds footprints at the start of a cycle, 1 about in its middle.
    """

    number: float
    ahead: float = 0.0


CyclesTo = Cycles | Callable[[Worn], Cycles]
"""Cycles, or a function that chooses them from the wear depths that a single cycle would leave."""


class SpreadLoad(NamedTuple):
    """Line loads with footprints of one width.

    Attributes
    ----------
    teeth : LoadedTeeth
        With the half-width of these footprints.
    line_load : (roll, face) array [N/mm]
        On the fine roll grid.
    share : float
        Share of the meshes.
    """

    teeth: LoadedTeeth
    line_load: FloatArray
    share: float = 1.0


_MOST_SCALED = 3.0  # line load over the predicted one up to which its footprint is used
_EXTRA_CYCLES = 4  # in which footprints of greater loads are found; few loads are so far from the prediction


class WearCourse(NamedTuple):
    """Wear depths through the cycles of a step.

    Attributes
    ----------
    shapes : sequence of Worn
        At the start of every cycle and at the end of the step.
    met : sequence of Worn
        On which the footprints of every cycle were found.
    parts : sequence of float
        Lengths of the cycles; their sum is the number of cycles.
    """

    shapes: Sequence[Worn]
    met: Sequence[Worn]
    parts: Sequence[float]

    def at(self, share: float) -> Worn:
        """Wear depths after a share of the step under the predicted loads."""
        ends = np.cumsum([0.0, *self.parts])
        cycles = share * ends[-1]
        cycle = int(np.clip(np.searchsorted(ends, cycles) - 1, 0, len(self.parts) - 1))
        weight = (cycles - ends[cycle]) / self.parts[cycle]
        before, after = self.shapes[cycle : cycle + 2]
        return after if weight == 1.0 else before.towards(weight, after)


@dataclass(frozen=True)
class StepInfluence:
    """Wear of one mesh as a linear function of the line loads, averaged over the cycles of a step.

    Attributes
    ----------
    course : WearCourse
        Under the predicted loads.
    widths : sequence of WidthInfluence
        Footprints of every width.
    """

    course: WearCourse
    widths: Sequence[WidthInfluence]

    def differs_from(self, line_loads: Sequence[FloatArray]) -> float:
        """Relative difference of line loads, (roll, face) [N/mm] for each width, from the predicted ones."""
        pairs = list(zip(self.widths, line_loads, strict=True))
        total = sum(own.share * float(load.sum()) for own, load in pairs)
        difference = sum(own.share * float(np.abs(load - own.line_load).sum()) for own, load in pairs)
        return difference / total if total > 0.0 else 0.0  # loads are weighted by wear laws, which may leave no wear

    def mesh(self, line_loads: Sequence[FloatArray], slices: IntArray) -> tuple[Worn, FloatArray]:
        """Sum of p |v_s| dt over one mesh under these line loads, on both flanks.

        Parameters
        ----------
        line_loads : sequence of arrays (roll, face) [N/mm]
            For each width.
        slices : int array
            Slices to evaluate; the others stay zero.

        Returns
        -------
        mesh : Worn
            Means over the step [N/mm].
        taken : (body, 2) array [N mm]
            As in `wear_of_mesh`.
        """
        found = [own.mesh(load, slices, self.course) for own, load in zip(self.widths, line_loads, strict=True)]
        shares = [own.share for own in self.widths]
        taken = mean((share, own) for share, (_, own) in zip(shares, found, strict=True))
        return _mean_wear([mesh for mesh, _ in found], shares), taken


@dataclass(frozen=True)
class WidthInfluence:
    """Footprints of one width on both flanks.

    Attributes
    ----------
    teeth : LoadedTeeth
        With the half-width of these footprints.
    motion : Sweep
    line_load : (roll, face) array [N/mm]
        Predicted line loads, under which the footprints were found.
    share : float
        Share of the meshes with these line loads.
    driven, driving : FootprintRows
        Footprints on each flank, summed over the cycles; None for a driving flank that does not wear.
    """

    teeth: LoadedTeeth
    motion: Sweep
    line_load: FloatArray
    share: float
    driven: FootprintRows
    driving: FootprintRows | None = None

    def mesh(self, line_load: FloatArray, slices: IntArray, course: WearCourse) -> tuple[Worn, FloatArray]:
        """As `StepInfluence.mesh`, for the line loads of this width."""
        teeth, covered = self.teeth, np.minimum(line_load, _MOST_SCALED * self.line_load)
        times = np.divide(covered, self.line_load, out=np.zeros_like(covered), where=self.line_load > 0.0)
        times /= sum(course.parts)
        taken, driving = np.zeros((len(BODIES), 2)), None
        if self.driving is not None and teeth.driving is not None:
            slices = teeth.driving.beside(slices)
            driving, taken[DRIVING] = sum_of_driving_rows(self.driving, times, teeth.fine, teeth.driving, slices)
        driven, taken[DRIVEN] = sum_of_rows(self.driven, times, teeth.grid, slices)
        mesh, rest = Worn(driven, driving), np.zeros_like(covered)
        rest[:, slices] = (line_load - covered)[:, slices]
        slices = np.flatnonzero(rest.any(axis=0))  # few, as a rule
        return (mesh, taken) if slices.size == 0 else self._with(rest, slices, course, mesh, taken)

    def _with(
        self, rest: FloatArray, slices: IntArray, course: WearCourse, mesh: Worn, taken: FloatArray
    ) -> tuple[Worn, FloatArray]:
        """The same with the wear of line loads that have no kept footprints, found on the flanks of some cycles."""
        meshes, before = _MeshWear(self.teeth, self.motion, rest, slices), course.shapes[0]
        count = len(course.parts)
        if not self.teeth.smooth:  # smooth results use all cycles: a choice of them would change with their number
            count = min(count, _EXTRA_CYCLES)
        chosen = np.linspace(0, len(course.parts) - 1, count, dtype=int)
        shares = np.array(course.parts)[chosen] / sum(course.parts[cycle] for cycle in chosen)
        for cycle, share in zip(chosen, shares, strict=True):
            extra, extra_taken = meshes.over(course.met[cycle], before)
            mesh, taken = mesh.plus(share, extra), taken + share * extra_taken
            before = course.met[cycle]
        return mesh, taken


def followed(
    spread: Sequence[SpreadLoad],
    motion: Sweep,
    worn: Worn,
    after: Callable[[Worn, Worn, float], Worn],
    cycles: CyclesTo,
) -> StepInfluence:
    """Wear the flanks under given line loads through a step, in cycles, and keep the footprints.

    Parameters
    ----------
    spread : sequence of SpreadLoad
    motion : Sweep
        On the fine roll grid.
    worn : Worn
        Wear depths at the start.
    after : callable
        From wear depths, the sum of p |v_s| dt over one mesh and a share of the step to the depths after it.
    cycles : Cycles or callable
        As in `CyclesTo`.
    """
    slices = np.arange(spread[0].teeth.grid.face.size)
    of_widths = [_MeshWear(load.teeth, motion, load.line_load, slices, keep=True) for load in spread]

    def mesh_over(met: Worn, before: Worn, part: float = 1.0) -> Worn:
        meshes = [own.over(met, before, part)[0] for own in of_widths]
        return _mean_wear(meshes, [load.share for load in spread])

    mesh = mesh_over(worn, worn)
    if callable(cycles):
        cycles = cycles(after(worn, mesh, 1.0))
    number, parts, shapes, met = cycles.number, _parts(cycles.number), [worn], [worn]
    late = 0.5 / (number - 1.0) if number > 1.0 else 0.0
    for part in parts[1:]:
        shapes.append(after(shapes[-1], mesh, 1.0 / number))  # only the last cycle may be shorter
        ahead = cycles.ahead * (0.5 * part + late)
        met.append(after(shapes[-1], mesh, ahead / number) if ahead else shapes[-1])
        mesh = mesh_over(met[-1], met[-2], part)
    shapes.append(after(shapes[-1], mesh, parts[-1] / number))
    widths: list[WidthInfluence] = []
    for own, load in zip(of_widths, spread, strict=True):
        driving, driven = own.rows
        assert driven is not None
        widths.append(WidthInfluence(load.teeth, motion, load.line_load, load.share, driven, driving))
    return StepInfluence(WearCourse(shapes, met, parts), widths)


def mean(weighted: Iterable[tuple[float, FloatArray]]) -> FloatArray:
    """Mean over footprints of different widths, from their shares of the meshes and the arrays of each."""
    return reduce(np.add, [share * array for share, array in weighted])


def _mean_wear(meshes: Sequence[Worn], shares: Sequence[float]) -> Worn:
    """Mean of the wear of meshes."""
    driving = [mesh.driving for mesh in meshes if mesh.driving is not None]
    driven = mean(zip(shares, [mesh.driven for mesh in meshes], strict=True))
    return Worn(driven, mean(zip(shares, driving, strict=True)) if driving else None)


@dataclass
class _MeshWear:
    """Wear of one mesh under the same line loads on flanks that wear from cycle to cycle."""

    teeth: LoadedTeeth
    motion: Sweep
    line_load: FloatArray
    slices: IntArray
    keep: bool = False
    rows: tuple[FootprintRows | None, FootprintRows | None] = field(default=(None, None), init=False)

    def __post_init__(self) -> None:
        teeth, load = self.teeth, self.line_load
        self._gap, self._edges = FollowedGap(teeth, load, self.slices), EdgeShares.unknown(load.shape)
        if self.keep:
            driven = rows_of(load > 0.0, teeth.grid.profile.shape[1])
            own = teeth.driving
            self.rows = (None if own is None else rows_of(load > 0.0, own.grid.profile.shape[1])), driven

    def over(self, worn: Worn, before: Worn, share: float = 1.0) -> tuple[Worn, FloatArray]:
        """Sum of p |v_s| dt over one mesh on flanks worn to these depths [N/mm], and `taken`, (body, 2).

        Footprints are kept times `share`; `before` are the depths of the previous call.
        """
        teeth, taken = self.teeth, np.zeros((len(BODIES), 2))
        arguments = (self.motion, self.line_load, teeth.half_width, teeth.problem.modulus, self.slices)
        edges = self._edges.after(_deepest_by_slice(before, worn))
        driving, driven = (None if rows is None else rows._replace(share=share) for rows in self.rows)
        if worn.driving is None or teeth.driving is None:
            removed = teeth.removed(worn.driven)
            return Worn(
                wear_of_mesh(teeth.fine, teeth.grid, removed, *arguments, taken[DRIVEN], edges, driven)
            ), taken
        rows = None if driving is None or driven is None else (driving, driven)
        removed = self._gap.removed(worn.driven, worn.driving)
        driving_mesh, mesh = wear_of_both_flanks(
            teeth.fine, teeth.grid, teeth.driving, removed, *arguments, taken, edges, rows
        )
        return Worn(mesh, driving_mesh), taken


def _deepest_by_slice(before: Worn, after: Worn) -> FloatArray:
    """Greatest wear of both flanks together in every slice and its neighbours, (face,) [mm]."""
    total = (after.driven - before.driven).max(axis=1)
    if after.driving is not None and before.driving is not None:
        driving = (after.driving - before.driving).max(axis=1)
        beside = np.concatenate([driving[:1], driving, driving[-1:]])
        total = total + np.maximum(driving, np.maximum(beside[:-2], beside[2:]))
    return np.asarray(total)


def _parts(cycles: float) -> list[float]:
    """Lengths of the cycles of a step: 1 each, and the fraction for the last."""
    whole = int(cycles)
    return [1.0] * whole + ([cycles - whole] if cycles > whole else [])
