"""Loaded teeth at fidelity `line`: contact lines, the grid that wears, and the solver, bound together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semiwear.contact.footprint import Footprints, footprints
from semiwear.contact.line_contact import LineContact, LineLoads
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import FlankGrid
from semiwear.meshing.flank_pair import FlankPair
from semiwear.meshing.roll_grid import RollGrid

__all__ = ["LoadedState", "LoadedTeeth"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class LoadedState:
    """Elastic contact over a mesh cycle on one worn flank.

    Attributes
    ----------
    wear : (face, profile) array [mm]
    fine, coarse : Footprints
        On the fine roll grid, and at the positions that are solved.
    loads : LineLoads
    """

    wear: FloatArray
    fine: Footprints
    coarse: Footprints
    loads: LineLoads


@dataclass(frozen=True)
class LoadedTeeth:
    """Everything that does not change while a flank wears.

    Attributes
    ----------
    pair : FlankPair
    rolls : RollGrid
    fine, lines : ContactLines
        On the fine roll grid, and at the positions that are solved.
    grid : FlankGrid
    solver : LineContact
    half_width : float [mm]
        Hertz half-width at the pitch point with the whole torque on one fresh tooth: the reference width of
        footprints and the half-width of the pitch band.
    zero : float [mm]
        Mean unloaded, unworn separation over a mesh cycle of this placement: where transmission error is zero.
    """

    pair: FlankPair
    rolls: RollGrid
    fine: ContactLines
    lines: ContactLines
    grid: FlankGrid
    solver: LineContact
    half_width: float
    zero: float

    def touch(self, wear: FloatArray) -> tuple[Footprints, Footprints]:
        """Footprints on a worn flank [mm], on the fine roll grid and at the solved positions."""
        fine = footprints(self.fine, self.grid, wear, self.half_width, self.solver.is_near(self.fine))
        return fine, fine.every(self.rolls.substeps)

    def load(self, wear: FloatArray, start: LineLoads | None = None) -> LoadedState:
        """Elastic contact on a worn flank [mm], started from other loads when given."""
        fine, coarse = self.touch(wear)
        if start is None:
            rolls, faces = self.lines.profile.shape
            start = LineLoads.none(rolls, faces, self.rolls.phase.size)
        return LoadedState(wear, fine, coarse, self.solver.solve(coarse, start))

    def on_fine_rolls(self, values: FloatArray) -> FloatArray:
        """Values at solved positions, (roll, face), linear between them on the fine grid."""
        steps = self.rolls.substeps
        if steps == 1:
            return values
        following = np.concatenate([values[1:], values[-1:]])
        share = (np.arange(steps) / steps)[None, :, None]
        return ((1.0 - share) * values[:, None] + share * following[:, None]).reshape(-1, values.shape[1])

    def at_ends(self) -> BoolArray:
        """Slices nearer than one contact width to an end of either body's face, (roll, face)."""
        borders = self.pair.borders(self.lines.face)
        face, partner = self.lines.face, self.lines.partner_face
        own = np.minimum(face - borders.face[0], borders.face[1] - face) - borders.end_edge_radius
        theirs = (
            np.minimum(partner - borders.partner_face[0], borders.partner_face[1] - partner)
            - borders.partner_end_edge_radius
        )
        return np.minimum(own, theirs) < 2.0 * self.half_width
