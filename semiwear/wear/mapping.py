"""From loads at roll positions to wear depths on the flanks: `interpolated` and `marched`.

`interpolated` (after the surface interpolation of Park, Kolivand and Kahraman 2014): few roll positions are solved.
What is smooth along the path, the line load, is interpolated between them; what is not, the sliding velocity with its
zero at the pitch line, is exact everywhere, so that the cusp of the wear there is kept. The contact's shape follows
the worn flanks.

`marched` (after Park, Kolivand and Kahraman 2012): many roll positions, each with its own pressures, summed in place.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.contact.loads import TeethLoads
from semiwear.contact.patch_gap import PatchCells
from semiwear.meshing.flank_area import flank_area
from semiwear.meshing.flank_pair import BODIES, DRIVEN, DRIVING
from semiwear.meshing.removed import Removed
from semiwear.wear.archard import wear_depth
from semiwear.wear.followed_gap import FollowedGap
from semiwear.wear.marched import marched_wear, sliding_distance_under_contact, spread_by_contact
from semiwear.wear.swept_line import EdgeShares, Sweep, wear_of_both_flanks, wear_of_mesh

__all__ = [
    "Cycles",
    "Growth",
    "InterpolatedWear",
    "MarchedWear",
    "WearMapping",
    "WearMultipliers",
    "WeightedLoads",
    "Worn",
    "driving_wear_at",
]


Cycles = float | Callable[["Worn"], float]
"""In how many parts of a step the contact's shape follows the wear, the last one shorter unless it is a whole number;
or that number from the flanks that the step would leave if the shape of its start held."""
Growth = Callable[[FloatArray, FloatArray], FloatArray]
"""From a depth and what the wear coefficient of the surface would add to it, to the new depth."""


class Worn(NamedTuple):
    """Wear depths of the flanks, each on its own nodes [mm]; None for a driving flank that does not wear."""

    driven: FloatArray
    driving: FloatArray | None = None

    @property
    def deepest(self) -> float:
        """Greatest wear depth of both [mm]."""
        return max(float(depth.max()) for depth in self if depth is not None)


class WearMultipliers(NamedTuple):
    """Number of meshes times wear coefficient of each body [mm^2/N]: depths are these times pressure and distance."""

    driven: float
    driving: float = 0.0


@dataclass(frozen=True)
class WeightedLoads:
    """Loads of a load case, with its share of the meshes.

    Attributes
    ----------
    teeth : LoadedTeeth
    loads : TeethLoads
    weight : float, or (roll, face) array
        Share of the meshes; times the factor on the wear coefficient where it varies.
    """

    teeth: LoadedTeeth
    loads: TeethLoads
    weight: float | FloatArray = 1.0


class WearMapping(Protocol):
    """Wear depths on the flanks from loads at roll positions."""

    def of_mesh(
        self, teeth: LoadedTeeth, motion: Sweep, worn: Worn, weighted_loads: Sequence[WeightedLoads], slices: IntArray
    ) -> FloatArray:
        """Sum of p |v_s| dt over one mesh on the driven flank, in some slices: (face, profile) [N/mm]."""

    def worn(
        self,
        teeth: LoadedTeeth,
        motion: Sweep,
        worn: Worn,
        weighted_loads: Sequence[WeightedLoads],
        multipliers: WearMultipliers,
        cycles: Cycles,
        slices: IntArray,
    ) -> tuple[Worn, FloatArray]:
        """Depths at the end of a step over which the loads hold, right in some slices of the driven flank.

        Parameters
        ----------
        worn : Worn
            At the start.
        cycles : float or callable
            Parts of the step, after each of which the contact's shape follows the wear; 1: that of the start holds.

        Returns
        -------
        worn : Worn
        on_edges : (body,) array [mm^3]
            What the contact in these slices wears off beyond the nodes of each flank: off the roundings of edges.
        """


def _line_load(weighted_loads: Sequence[WeightedLoads]) -> FloatArray:
    """Line load on the fine roll grid, averaged over the load cases: footprints have one shape for all of them."""
    parts = [one.teeth.on_fine_rolls(one.teeth.problem.line_load(one.loads) * one.weight) for one in weighted_loads]
    total = parts[0]
    for part in parts[1:]:
        total = total + part
    return total


def _swept(
    teeth: LoadedTeeth,
    motion: Sweep,
    removed: Removed,
    line_load: FloatArray,
    slices: IntArray,
    taken: FloatArray | None = None,
) -> FloatArray:
    """Sum of p |v_s| dt on the driven flank under line loads whose footprints `removed` shapes [N/mm]."""
    what = (motion, line_load, teeth.half_width, teeth.problem.modulus, slices, taken)
    return wear_of_mesh(teeth.fine, teeth.grid, removed, *what)


@dataclass(frozen=True)
class InterpolatedWear:
    """Line loads interpolated between roll positions, spread over footprints that follow the wear.

    Attributes
    ----------
    grow, grow_driving : callable
        How depths of the driven and the driving flank add up.
    """

    grow: Growth = np.add
    grow_driving: Growth = np.add

    def of_mesh(
        self, teeth: LoadedTeeth, motion: Sweep, worn: Worn, weighted_loads: Sequence[WeightedLoads], slices: IntArray
    ) -> FloatArray:
        """As in `WearMapping`."""
        return _swept(teeth, motion, teeth.removed(*worn, slices), _line_load(weighted_loads), slices)

    def worn(
        self,
        teeth: LoadedTeeth,
        motion: Sweep,
        worn: Worn,
        weighted_loads: Sequence[WeightedLoads],
        multipliers: WearMultipliers,
        cycles: Cycles,
        slices: IntArray,
    ) -> tuple[Worn, FloatArray]:
        """As in `WearMapping`."""
        line_load = _line_load(weighted_loads)
        if worn.driving is not None and teeth.driving is not None:
            # twice: over the cycles the wear of slices beside follows that of their own neighbours
            slices = teeth.driving.beside(teeth.driving.beside(slices))
        what = (motion, line_load, teeth.half_width, teeth.problem.modulus, slices)
        gap, edges = FollowedGap(teeth, line_load, slices), EdgeShares.unknown(line_load.shape)

        def swept(worn: Worn, before: Worn) -> tuple[Worn, FloatArray]:
            """Sum of p |v_s| dt over one mesh on both flanks as they are, and what is taken."""
            taken, known = np.zeros((len(BODIES), 2)), edges.after(_deepest_by_slice(before, worn))
            if worn.driving is None or teeth.driving is None:
                mesh = wear_of_mesh(teeth.fine, teeth.grid, teeth.removed(worn.driven), *what, taken[DRIVEN], known)
                return Worn(mesh), taken
            removed = gap.removed(worn.driven, worn.driving)
            driving, mesh = wear_of_both_flanks(teeth.fine, teeth.grid, teeth.driving, removed, *what, taken, known)
            return Worn(mesh, driving), taken

        mesh, taken = swept(worn, worn)
        if callable(cycles):
            cycles = cycles(self._after(worn, mesh, multipliers, 1.0))
        lengths = _parts(cycles)
        total = lengths[0] * taken
        before, worn = worn, self._after(worn, mesh, multipliers, lengths[0] / cycles)
        for part in lengths[1:]:
            mesh, taken = swept(worn, before)
            total += part * taken
            before, worn = worn, self._after(worn, mesh, multipliers, part / cycles)
        on_edges = np.zeros(len(BODIES))
        on_edges[DRIVEN] = multipliers.driven / cycles * total[DRIVEN, 1]
        on_edges[DRIVING] = multipliers.driving / cycles * total[DRIVING, 1]
        return worn, on_edges

    def _after(self, worn: Worn, mesh: Worn, multipliers: WearMultipliers, share: float) -> Worn:
        """Depths after a share of the step under what a mesh wears."""
        driven = self.grow(worn.driven, wear_depth(share * multipliers.driven, mesh.driven))
        if worn.driving is None or mesh.driving is None:
            return Worn(driven, worn.driving)
        driving = self.grow_driving(worn.driving, wear_depth(share * multipliers.driving, mesh.driving))
        return Worn(driven, driving)


@dataclass(frozen=True)
class MarchedWear:
    """Pressures summed where they act; of the driven flank alone.

    Attributes
    ----------
    swept : InterpolatedWear
        Carries large steps.
    """

    swept: InterpolatedWear = InterpolatedWear()

    def of_mesh(
        self, teeth: LoadedTeeth, motion: Sweep, worn: Worn, weighted_loads: Sequence[WeightedLoads], slices: IntArray
    ) -> FloatArray:
        """As in `WearMapping`; the loads were solved on this flank."""
        return _marched(weighted_loads, _chosen(teeth, slices))[0]

    def worn(
        self,
        teeth: LoadedTeeth,
        motion: Sweep,
        worn: Worn,
        weighted_loads: Sequence[WeightedLoads],
        multipliers: WearMultipliers,
        cycles: Cycles,
        slices: IntArray,
    ) -> tuple[Worn, FloatArray]:
        """As in `WearMapping`; a single cycle is a plain explicit step."""
        chosen, multiplier = _chosen(teeth, slices), multipliers.driven
        mesh, beyond = _marched(weighted_loads, chosen)
        marched, on_edges = wear_depth(multiplier, mesh), np.zeros(len(BODIES))
        on_edges[DRIVEN] = multiplier * beyond
        if cycles == 1:
            return Worn(worn.driven + marched), on_edges
        swept, swept_on_edges = self.swept.worn(teeth, motion, worn, weighted_loads, multipliers, cycles, slices)
        removed, line_load, taken = teeth.removed(*worn, slices), _line_load(weighted_loads), np.zeros(2)
        rest = marched - wear_depth(multiplier, _swept(teeth, motion, removed, line_load, slices, taken))
        on_edges[DRIVEN] += swept_on_edges[DRIVEN] - multiplier * taken[1]
        # where only one of the two is in contact, what it lacks is damped as what it has elsewhere
        unit = np.where(line_load > 0.0, 2.0 * teeth.half_width, 0.0)  # mean pressure of one: distance slid
        slid = np.maximum(_slid(weighted_loads, chosen), _swept(teeth, motion, removed, unit, slices))
        stiffness = 0.5 * multiplier * teeth.problem.modulus * slid
        area = flank_area(teeth.pair, DRIVEN, teeth.grid)
        depth = swept.driven + spread_by_contact(teeth.grid, rest, stiffness, area, chosen)
        return Worn(np.maximum(depth, worn.driven)), on_edges


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


def driving_wear_at(
    teeth: LoadedTeeth, motion: Sweep, worn: Worn, weighted_loads: Sequence[WeightedLoads], slices: IntArray
) -> FloatArray:
    """Sum of p |v_s| dt over one mesh on the driving flank, right at some slices: (face, profile) [N/mm]."""
    assert teeth.driving is not None
    slices = teeth.driving.beside(slices)
    what = (motion, _line_load(weighted_loads), teeth.half_width, teeth.problem.modulus, slices)
    return wear_of_both_flanks(teeth.fine, teeth.grid, teeth.driving, teeth.removed(*worn, slices), *what)[0]


def _cells(passage: WeightedLoads) -> PatchCells:
    cells = passage.teeth.problem.cells
    assert cells is not None  # the scene's rules see to it
    return cells


def _marched(weighted_loads: Sequence[WeightedLoads], chosen: BoolArray) -> tuple[FloatArray, float]:
    """Sum of p |v_s| dt at the nodes [N/mm], and that of F |v_s| dt beyond them [N mm]."""
    found = [marched_wear(p.teeth, _cells(p), p.loads, chosen, p.weight) for p in weighted_loads]
    return np.sum([mesh for mesh, _ in found], axis=0), sum(beyond for _, beyond in found)


def _slid(weighted_loads: Sequence[WeightedLoads], chosen: BoolArray) -> FloatArray:
    slid = [sliding_distance_under_contact(p.teeth, _cells(p), p.loads, chosen, p.weight) for p in weighted_loads]
    return np.asarray(np.sum(slid, axis=0))


def _chosen(teeth: LoadedTeeth, slices: IntArray) -> BoolArray:
    chosen = np.zeros(teeth.grid.face.size, dtype=bool)
    chosen[slices] = True
    return chosen
