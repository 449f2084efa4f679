"""From loads at roll positions to wear depths on the flanks: `interpolated` and `marched`.

`interpolated` (after the surface interpolation of Park, Kolivand and Kahraman 2014): few roll positions are solved.
The line load, which is smooth along the path, is interpolated between them. The sliding velocity, which is zero at
the pitch line, is exact everywhere, so that the cusp of the wear there is kept. Footprints follow the worn flanks.

`marched` (after Park, Kolivand and Kahraman 2012): many roll positions, and the pressures of each summed at the
nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.contact.loads import TeethLoads
from semiwear.contact.patch_gap import PatchCells
from semiwear.meshing.flank_area import flank_area
from semiwear.meshing.flank_pair import BODIES, DRIVEN, DRIVING
from semiwear.meshing.removed import Removed
from semiwear.wear.archard import wear_depth
from semiwear.wear.marched import marched_wear, sliding_distance_under_contact, spread_by_contact
from semiwear.wear.step_influence import CyclesTo, SpreadLoad, StepInfluence, followed, mean
from semiwear.wear.swept_line import Sweep, wear_of_both_flanks, wear_of_mesh
from semiwear.wear.worn import WearMultipliers, Worn

Growth = Callable[[FloatArray, FloatArray], FloatArray]
"""New depth from a depth and the increment by the wear coefficient of the surface."""


@dataclass(frozen=True)
class WeightedLoads:
    """Loads of a load case with their weight in the wear.

    Attributes
    ----------
    teeth : LoadedTeeth
    loads : TeethLoads
    weight : float, or (roll, face) array
        Share of the meshes, times the factor on the wear coefficient where it varies.
    share : float
        Share of the meshes.
    """

    teeth: LoadedTeeth
    loads: TeethLoads
    weight: float | FloatArray = 1.0
    share: float = 1.0


def line_load_of(weighted_loads: Sequence[WeightedLoads]) -> FloatArray:
    """Line load on the fine roll grid, averaged over the load cases."""
    parts = [
        case.teeth.on_fine_rolls(case.teeth.problem.line_load(case.loads) * case.weight) for case in weighted_loads
    ]
    total = parts[0]
    for part in parts[1:]:
        total = total + part
    return total


def by_width(teeth: LoadedTeeth, weighted_loads: Sequence[WeightedLoads]) -> Sequence[SpreadLoad]:
    """Mean line loads of the load cases by the width of their footprints; on `teeth` if there is a single width."""
    widths: dict[float, list[WeightedLoads]] = {}
    for case in weighted_loads:
        widths.setdefault(case.teeth.half_width, []).append(case)
    if len(widths) == 1:
        return [SpreadLoad(teeth, line_load_of(weighted_loads))]
    shares = [sum(case.share for case in cases) for cases in widths.values()]
    return [
        SpreadLoad(cases[0].teeth, line_load_of(cases) / share, share)
        for cases, share in zip(widths.values(), shares, strict=True)
    ]


def _swept(
    teeth: LoadedTeeth,
    motion: Sweep,
    removed: Removed,
    line_load: FloatArray,
    slices: IntArray,
    taken: FloatArray | None = None,
) -> FloatArray:
    """Sum of p |v_s| dt on the driven flank under line loads [N/mm]; `removed` determines their footprints."""
    arguments = (motion, line_load, teeth.half_width, teeth.problem.modulus, slices, taken)
    return wear_of_mesh(teeth.fine, teeth.grid, removed, *arguments)


@dataclass(frozen=True)
class InterpolatedWear:
    """Line loads interpolated between roll positions, spread over footprints that follow the wear.

    Attributes
    ----------
    grow, grow_driving : callable
        New depths of the driven and the driving flank from depths and increments.
    """

    grow: Growth = np.add
    grow_driving: Growth = np.add

    def of_mesh(
        self,
        teeth: LoadedTeeth,
        motion: Sweep,
        worn: Worn,
        weighted_loads: Sequence[WeightedLoads],
        slices: IntArray,
    ) -> FloatArray:
        """Sum of p |v_s| dt over one mesh on some slices of the driven flank, (face, profile) [N/mm]."""
        removed = teeth.removed(*worn, slices)
        spread = by_width(teeth, weighted_loads)
        return mean((own.share, _swept(own.teeth, motion, removed, own.line_load, slices)) for own in spread)

    def followed(
        self,
        teeth: LoadedTeeth,
        motion: Sweep,
        worn: Worn,
        weighted_loads: Sequence[WeightedLoads],
        multipliers: WearMultipliers,
        cycles: CyclesTo,
    ) -> StepInfluence:
        """Influence of loads on the wear of a step, with footprints found under estimated loads."""

        def after(before: Worn, mesh: Worn, share: float) -> Worn:
            return self._after(before, mesh, multipliers, share)

        return followed(by_width(teeth, weighted_loads), motion, worn, after, cycles)

    def worn(
        self,
        influence: StepInfluence,
        weighted_loads: Sequence[WeightedLoads],
        multipliers: WearMultipliers,
        slices: IntArray,
    ) -> tuple[Worn, FloatArray]:
        """Wear depths at the end of a step under these loads, valid in some slices of the driven flank.

        Returns
        -------
        worn : Worn
        on_edges : (body,) array [mm^3]
            Volume worn off beyond the nodes of each flank in these slices, off the roundings of edges.
        """
        spread = by_width(influence.widths[0].teeth, weighted_loads)
        mesh, taken = influence.mesh([load.line_load for load in spread], slices)
        on_edges = np.zeros(len(BODIES))
        on_edges[DRIVEN] = multipliers.driven * taken[DRIVEN, 1]
        on_edges[DRIVING] = multipliers.driving * taken[DRIVING, 1]
        return self._after(influence.course.shapes[0], mesh, multipliers, 1.0), on_edges

    def _after(self, worn: Worn, mesh: Worn, multipliers: WearMultipliers, share: float) -> Worn:
        """Wear depths after a share of the step, from the p |v_s| dt of a mesh."""
        driven = self.grow(worn.driven, wear_depth(share * multipliers.driven, mesh.driven))
        if worn.driving is None or mesh.driving is None:
            return Worn(driven, worn.driving)
        driving = self.grow_driving(worn.driving, wear_depth(share * multipliers.driving, mesh.driving))
        return Worn(driven, driving)


@dataclass(frozen=True)
class MarchedWear:
    """Pressures summed at the nodes where they act; for wear of the driven flank alone.

    Attributes
    ----------
    swept : InterpolatedWear
        Stabilises large steps (`marched`).
    """

    swept: InterpolatedWear = InterpolatedWear()

    def of_mesh(
        self,
        teeth: LoadedTeeth,
        motion: Sweep,
        worn: Worn,
        weighted_loads: Sequence[WeightedLoads],
        slices: IntArray,
    ) -> FloatArray:
        """As `InterpolatedWear.of_mesh`; the loads were solved on this flank."""
        return _marched(weighted_loads, _chosen(teeth, slices))[0]

    def followed(
        self,
        teeth: LoadedTeeth,
        motion: Sweep,
        worn: Worn,
        weighted_loads: Sequence[WeightedLoads],
        multipliers: WearMultipliers,
        cycles: CyclesTo,
    ) -> StepInfluence:
        """As `InterpolatedWear.followed`."""
        return self.swept.followed(teeth, motion, worn, weighted_loads, multipliers, cycles)

    def worn(
        self,
        influence: StepInfluence,
        weighted_loads: Sequence[WeightedLoads],
        multipliers: WearMultipliers,
        slices: IntArray,
    ) -> tuple[Worn, FloatArray]:
        """As `InterpolatedWear.worn`; a single cycle is a plain explicit step."""
        teeth, motion, worn = influence.widths[0].teeth, influence.widths[0].motion, influence.course.shapes[0]
        chosen, multiplier = _chosen(teeth, slices), multipliers.driven
        pressed, beyond = _marched(weighted_loads, chosen)
        marched, on_edges = wear_depth(multiplier, pressed), np.zeros(len(BODIES))
        on_edges[DRIVEN] = multiplier * beyond
        if len(influence.course.parts) == 1:
            return Worn(worn.driven + marched), on_edges
        swept, swept_on_edges = self.swept.worn(influence, weighted_loads, multipliers, slices)
        removed, mesh = teeth.removed(*worn), np.zeros_like(marched)
        slid = _slid(weighted_loads, chosen)
        for own, line_load, share in by_width(teeth, weighted_loads):
            taken = np.zeros(2)
            mesh = mesh + share * _swept(own, motion, removed, line_load, slices, taken)
            swept_on_edges[DRIVEN] -= multiplier * share * taken[1]
            # damp the difference where either the cells or the footprints are in contact
            unit = np.where(line_load > 0.0, 2.0 * own.half_width, 0.0)  # mean pressure of 1: the sliding distance
            slid = np.maximum(slid, _swept(own, motion, removed, unit, slices))
        on_edges[DRIVEN] += swept_on_edges[DRIVEN]
        rest = marched - wear_depth(multiplier, mesh)
        stiffness = 0.5 * multiplier * teeth.problem.modulus * slid
        area = flank_area(teeth.pair, DRIVEN, teeth.grid)
        depth = swept.driven + spread_by_contact(teeth.grid, rest, stiffness, area, chosen)
        return Worn(np.maximum(depth, worn.driven)), on_edges


def driving_wear_at(
    teeth: LoadedTeeth, motion: Sweep, worn: Worn, weighted_loads: Sequence[WeightedLoads], slices: IntArray
) -> FloatArray:
    """Sum of p |v_s| dt over one mesh on the driving flank, valid at some slices, (face, profile) [N/mm]."""
    assert teeth.driving is not None
    slices = teeth.driving.beside(slices)
    removed = teeth.removed(*worn, slices)

    def own(of_width: LoadedTeeth, line_load: FloatArray) -> FloatArray:
        assert of_width.driving is not None
        arguments = (motion, line_load, of_width.half_width, of_width.problem.modulus, slices)
        return wear_of_both_flanks(of_width.fine, of_width.grid, of_width.driving, removed, *arguments)[0]

    return mean((load.share, own(load.teeth, load.line_load)) for load in by_width(teeth, weighted_loads))


def _cells(case: WeightedLoads) -> PatchCells:
    cells = case.teeth.problem.cells
    assert cells is not None  # the rules of the scene require fidelity `patch`
    return cells


def _marched(weighted_loads: Sequence[WeightedLoads], chosen: BoolArray) -> tuple[FloatArray, float]:
    """Sum of p |v_s| dt at the nodes [N/mm], and that of F |v_s| dt beyond them [N mm]."""
    of_cases = [marched_wear(case.teeth, _cells(case), case.loads, chosen, case.weight) for case in weighted_loads]
    return np.sum([mesh for mesh, _ in of_cases], axis=0), sum(beyond for _, beyond in of_cases)


def _slid(weighted_loads: Sequence[WeightedLoads], chosen: BoolArray) -> FloatArray:
    slid = [
        sliding_distance_under_contact(case.teeth, _cells(case), case.loads, chosen, case.weight)
        for case in weighted_loads
    ]
    return np.asarray(np.sum(slid, axis=0))


def _chosen(teeth: LoadedTeeth, slices: IntArray) -> BoolArray:
    chosen = np.zeros(teeth.grid.face.size, dtype=bool)
    chosen[slices] = True
    return chosen
