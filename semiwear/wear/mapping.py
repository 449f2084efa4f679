"""From loads at roll positions to wear depths on the flank: `interpolated` and `marched`.

`interpolated` (after the surface interpolation of Park, Kolivand and Kahraman 2014): few roll positions are solved.
What is smooth along the path, the line load, is interpolated between them; what is not, the sliding velocity with its
zero at the pitch line, is exact everywhere, so that the cusp of the wear there is kept. The contact's shape follows
the worn flank.

`marched` (after Park, Kolivand and Kahraman 2012): many roll positions, each with its own pressures, summed in place.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.contact.patch_contact import PatchContact
from semiwear.wear.marched import marched_wear, sliding_distance_under_contact, spread_by_contact
from semiwear.wear.swept_line import Sweep, wear_of_mesh

__all__ = ["InterpolatedWear", "MarchedWear", "WearMapping"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class WearMapping(Protocol):
    """Wear depths on the flank from loads at roll positions."""

    def of_mesh(
        self, teeth: LoadedTeeth, motion: Sweep, wear: FloatArray, loads: Any, slices: IntArray
    ) -> FloatArray:
        """Sum of p |v_s| dt over one mesh on a flank worn by `wear` [mm], in some slices: (face, profile) [N/mm]."""

    def worn(
        self,
        teeth: LoadedTeeth,
        motion: Sweep,
        wear: FloatArray,
        loads: Any,
        dose: float,
        cycles: int,
        slices: IntArray,
    ) -> FloatArray:
        """Wear at the end of a step over which the loads hold [mm], right in some slices: (face, profile).

        Parameters
        ----------
        wear : (face, profile) array [mm]
            At the start.
        dose : float [mm^2/N]
            Meshes times wear coefficient.
        cycles : int
            In how many parts of the step the contact's shape follows the wear; 1: that of the start holds.
        """


@dataclass(frozen=True)
class InterpolatedWear:
    """Line loads interpolated between roll positions, spread over footprints that follow the wear."""

    def of_mesh(
        self, teeth: LoadedTeeth, motion: Sweep, wear: FloatArray, loads: Any, slices: IntArray
    ) -> FloatArray:
        """As in `WearMapping`."""
        line_load = teeth.on_fine_rolls(teeth.solver.line_load(loads))
        return wear_of_mesh(teeth.fine, teeth.grid, wear, motion, line_load, teeth.half_width, slices)

    def worn(
        self,
        teeth: LoadedTeeth,
        motion: Sweep,
        wear: FloatArray,
        loads: Any,
        dose: float,
        cycles: int,
        slices: IntArray,
    ) -> FloatArray:
        """As in `WearMapping`."""
        line_load = teeth.on_fine_rolls(teeth.solver.line_load(loads))
        for _ in range(cycles):
            mesh = wear_of_mesh(teeth.fine, teeth.grid, wear, motion, line_load, teeth.half_width, slices)
            wear = wear + dose / cycles * mesh
        return wear


@dataclass(frozen=True)
class MarchedWear:
    """Pressures summed where they act.

    Attributes
    ----------
    solver : PatchContact
    swept : InterpolatedWear
        Carries large steps.
    """

    solver: PatchContact
    swept: InterpolatedWear = InterpolatedWear()

    def of_mesh(
        self, teeth: LoadedTeeth, motion: Sweep, wear: FloatArray, loads: Any, slices: IntArray
    ) -> FloatArray:
        """As in `WearMapping`; the loads were solved on this flank."""
        return marched_wear(teeth, self.solver, loads, _chosen(teeth, slices))

    def worn(
        self,
        teeth: LoadedTeeth,
        motion: Sweep,
        wear: FloatArray,
        loads: Any,
        dose: float,
        cycles: int,
        slices: IntArray,
    ) -> FloatArray:
        """As in `WearMapping`; a single cycle is a plain explicit step."""
        chosen = _chosen(teeth, slices)
        marched = dose * marched_wear(teeth, self.solver, loads, chosen)
        if cycles == 1:
            return wear + marched
        swept = self.swept.worn(teeth, motion, wear, loads, dose, cycles, slices)
        rest = marched - dose * self.swept.of_mesh(teeth, motion, wear, loads, slices)
        slid = sliding_distance_under_contact(teeth, self.solver, loads, chosen)
        stiffness = 0.5 * dose * teeth.solver.modulus * slid
        return np.maximum(swept + spread_by_contact(teeth.grid, rest, stiffness, chosen), wear)


def _chosen(teeth: LoadedTeeth, slices: IntArray) -> NDArray[np.bool_]:
    chosen = np.zeros(teeth.grid.face.size, dtype=bool)
    chosen[slices] = True
    return chosen
