"""Wear of a step under any loads, from footprints that were followed through it once.

A step's loads are not known before the wear that they cause. Loads that are foreseen wear the flanks in cycles, and
each footprint is kept, averaged over the cycles. The wear of the step is linear in its loads then: no footprint is
found again while they are searched for. Loads far from the foreseen ones find their footprints in the same shapes of
the flanks. Under a load spectrum every torque has footprints of its own width, and all of them wear the same shapes.

In cycle c of n the flanks wear by what they would on a shape ahead of its start, which the wear w of the cycle before
foretells:

    h_(c+1) = h_c + w_c,   w_c = w(h_c + a_c w_(c-1)),   a_0 = 0,   a_c = 1/2 + 1/(2 (n - 1))

for cycles of equal length. The second term of a_c makes up for the first cycle, so that the sum of w errs in third
order; a_c = 0 errs in second order. All weights are positive: wear never shrinks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
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

__all__ = ["Cycles", "CyclesTo", "SpreadLoad", "StepInfluence", "followed", "mean_mesh"]


class Cycles(NamedTuple):
    """Parts of a step, in each of which the contact's shape follows the wear.

    Attributes
    ----------
    number : float
        How many; the last one is shorter unless it is a whole number.
    ahead : float
        Share of a_c by which they look ahead: 0 at the start of a part, 1 about in its middle.
    """

    number: float
    ahead: float = 0.0


CyclesTo = Cycles | Callable[[Worn], Cycles]
"""Cycles, or those of a step that would leave these flanks if the shape of its start held."""


class SpreadLoad(NamedTuple):
    """Line loads whose footprints are equally wide.

    Attributes
    ----------
    teeth : LoadedTeeth
        With the footprints that spread them.
    line_load : (roll, face) array [N/mm]
        On the fine roll grid.
    share : float
        Of the meshes.
    """

    teeth: LoadedTeeth
    line_load: FloatArray
    share: float = 1.0


_LIKE = 3.0  # times the line load whose footprint is kept: a greater one has another
_SOME = 4  # shapes of the flanks in which that one is found: so few loads are so far from what was foreseen


@dataclass(frozen=True)
class StepInfluence:
    """Wear of one mesh by line load, averaged over a step through which the contact's shape followed the wear.

    Attributes
    ----------
    teeth : LoadedTeeth
    motion : Sweep
    line_load : (roll, face) array [N/mm]
        Under which it followed.
    shapes : sequence of Worn
        Flanks at the start of every cycle, and at the end of the step.
    met : sequence of Worn
        Flanks on which the footprints of every cycle were found.
    parts : sequence of float
        Lengths of the cycles; their sum is the number of cycles.
    driven, driving : FootprintRows
        Footprints on each flank, summed over the cycles; None for a driving flank that does not wear.
    share : float
        Of the meshes, that have these line loads.
    others : sequence of StepInfluence
        Of the other meshes, whose footprints have other widths, in the same cycles.
    """

    teeth: LoadedTeeth
    motion: Sweep
    line_load: FloatArray
    shapes: Sequence[Worn]
    met: Sequence[Worn]
    parts: Sequence[float]
    driven: FootprintRows
    driving: FootprintRows | None = None
    share: float = 1.0
    others: Sequence[StepInfluence] = ()

    @property
    def widths(self) -> Sequence[StepInfluence]:
        """Influences by the width of footprints, each with its own line loads and share."""
        return (self, *self.others)

    @property
    def start(self) -> Worn:
        """Flanks at the start of the step."""
        return self.shapes[0]

    def at(self, share: float) -> Worn:
        """Flanks after a share of the step, as they were followed."""
        reached = np.cumsum([0.0, *self.parts])
        place = share * reached[-1]
        cycle = int(np.clip(np.searchsorted(reached, place) - 1, 0, len(self.parts) - 1))
        weight = (place - reached[cycle]) / self.parts[cycle]
        before, after = self.shapes[cycle : cycle + 2]
        return after if weight == 1.0 else before.towards(weight, after)

    def differs_from(self, line_loads: Sequence[FloatArray]) -> float:
        """Share of line loads, (roll, face) [N/mm] by width, by which they differ from those that were followed."""
        pairs = list(zip(self.widths, line_loads, strict=True))
        total = sum(own.share * float(one.sum()) for own, one in pairs)
        apart = sum(own.share * float(np.abs(one - own.line_load).sum()) for own, one in pairs)
        return apart / total if total > 0.0 else 0.0  # none where a law leaves no wear, which needs no footprints

    def mesh(self, line_load: FloatArray, slices: IntArray) -> tuple[Worn, FloatArray]:
        """Sum of p |v_s| dt over one mesh under line loads with footprints of this width, on both flanks.

        Parameters
        ----------
        line_load : (roll, face) array [N/mm]
        slices : int array
            Slices to do; the others stay zero.

        Returns
        -------
        mesh : Worn
            Means over the step [N/mm].
        taken : (body, 2) array [N mm]
            As in `wear_of_mesh`.
        """
        teeth, known = self.teeth, np.minimum(line_load, _LIKE * self.line_load)
        times = np.divide(known, self.line_load, out=np.zeros_like(known), where=self.line_load > 0.0)
        times /= sum(self.parts)
        taken, driving = np.zeros((len(BODIES), 2)), None
        if self.driving is not None and teeth.driving is not None:
            slices = teeth.driving.beside(slices)
            driving, taken[DRIVING] = sum_of_driving_rows(self.driving, times, teeth.fine, teeth.driving, slices)
        driven, taken[DRIVEN] = sum_of_rows(self.driven, times, teeth.grid, slices)
        mesh, rest = Worn(driven, driving), np.zeros_like(known)
        rest[:, slices] = (line_load - known)[:, slices]
        return (mesh, taken) if not rest.any() else self._with(rest, slices, mesh, taken)

    def _with(self, rest: FloatArray, slices: IntArray, mesh: Worn, taken: FloatArray) -> tuple[Worn, FloatArray]:
        """The same with line loads whose footprints are not kept: found on the flanks as they were followed."""
        passes, before = _Passes(self.teeth, self.motion, rest, slices), self.start
        count = len(self.parts)
        if not self.teeth.smooth:  # otherwise a cycle more would change them all
            count = min(count, _SOME)
        some = np.linspace(0, len(self.parts) - 1, count, dtype=int)
        shares = np.array(self.parts)[some] / sum(self.parts[cycle] for cycle in some)
        for cycle, share in zip(some, shares, strict=True):
            own, own_taken = passes.over(self.met[cycle], before)
            mesh, taken = mesh.plus(share, own), taken + share * own_taken
            before = self.met[cycle]
        return mesh, taken


def followed(
    spread: Sequence[SpreadLoad],
    motion: Sweep,
    worn: Worn,
    after: Callable[[Worn, Worn, float], Worn],
    cycles: CyclesTo,
) -> StepInfluence:
    """Let line loads wear the flanks through a step, in cycles, after each of which the contact's shape follows.

    Parameters
    ----------
    spread : sequence of SpreadLoad
    motion : Sweep
        Of the fine roll grid.
    worn : Worn
        At the start.
    after : callable
        From wear depths, the sum of p |v_s| dt over one mesh and a share of the step to the depths after it.
    cycles : Cycles or callable
        As in `CyclesTo`.
    """
    slices = np.arange(spread[0].teeth.grid.face.size)
    passes = [_Passes(one.teeth, motion, one.line_load, slices, keep=True) for one in spread]

    def over(met: Worn, before: Worn, part: float = 1.0) -> Worn:
        meshes = [one.over(met, before, part)[0] for one in passes]
        return mean_mesh(meshes, [one.share for one in spread])

    mesh = over(worn, worn)
    if callable(cycles):
        cycles = cycles(after(worn, mesh, 1.0))
    number, parts, shapes, met = cycles.number, _parts(cycles.number), [worn], [worn]
    late = 0.5 / (number - 1.0) if number > 1.0 else 0.0
    for part in parts[1:]:
        shapes.append(after(shapes[-1], mesh, 1.0 / number))  # all but the last one are whole
        ahead = cycles.ahead * (0.5 * part + late)
        met.append(after(shapes[-1], mesh, ahead / number) if ahead else shapes[-1])
        mesh = over(met[-1], met[-2], part)
    shapes.append(after(shapes[-1], mesh, parts[-1] / number))
    found: list[StepInfluence] = []
    for own, one in zip(passes, spread, strict=True):
        driving, driven = own.rows
        assert driven is not None
        found.append(StepInfluence(one.teeth, motion, one.line_load, shapes, met, parts, driven, driving, one.share))
    return replace(found[0], others=found[1:])


def mean_mesh(meshes: Sequence[Worn], shares: Sequence[float]) -> Worn:
    """Mean over the meshes of what they wear, from that of each kind and their shares."""
    if len(meshes) == 1:
        return meshes[0]
    none = meshes[0].plus(-1.0, meshes[0])
    return reduce(lambda total, one: total.plus(*one), zip(shares, meshes, strict=True), none)


@dataclass
class _Passes:
    """Wear of one mesh under the same line loads, over flanks that wear on."""

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
        """Sum of p |v_s| dt over one mesh on both flanks as they are [N/mm], and what is taken, (body, 2)."""
        teeth, taken = self.teeth, np.zeros((len(BODIES), 2))
        what = (self.motion, self.line_load, teeth.half_width, teeth.problem.modulus, self.slices)
        known = self._edges.after(_deepest_by_slice(before, worn))
        driving, driven = (None if rows is None else rows._replace(share=share) for rows in self.rows)
        if worn.driving is None or teeth.driving is None:
            removed = teeth.removed(worn.driven)
            return Worn(wear_of_mesh(teeth.fine, teeth.grid, removed, *what, taken[DRIVEN], known, driven)), taken
        rows = None if driving is None or driven is None else (driving, driven)
        removed = self._gap.removed(worn.driven, worn.driving)
        own, mesh = wear_of_both_flanks(teeth.fine, teeth.grid, teeth.driving, removed, *what, taken, known, rows)
        return Worn(mesh, own), taken


def _deepest_by_slice(before: Worn, after: Worn) -> FloatArray:
    """Greatest depth that both flanks together wear by in every slice and its neighbours, (face,) [mm]."""
    total = (after.driven - before.driven).max(axis=1)
    if after.driving is not None and before.driving is not None:
        driving = (after.driving - before.driving).max(axis=1)
        beside = np.concatenate([driving[:1], driving, driving[-1:]])
        total = total + np.maximum(driving, np.maximum(beside[:-2], beside[2:]))
    return np.asarray(total)


def _parts(cycles: float) -> list[float]:
    """Lengths of the cycles of a step in whole ones: the last grows by and by with the number."""
    whole = int(cycles)
    return [1.0] * whole + ([cycles - whole] if cycles > whole else [])
