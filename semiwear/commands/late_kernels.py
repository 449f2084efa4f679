"""Kernels that a run needs last, compiled: those of pressures across slices, and those that lay down wear.

``python -m semiwear.commands.late_kernels`` compiles them in a process of its own while a first run compiles those
that it needs at once, and finds these compiled when it comes to them (`compile_ahead`).
"""

from __future__ import annotations

import numpy as np

import semiwear as sw
from semiwear.contact.footprint import Footprints
from semiwear.contact.slice_pressure import solve_slices
from semiwear.plan import plan
from semiwear.wear.swept_line import fresh_sweep, wear_of_mesh

__all__ = ["compile_late_kernels"]

_COARSE = {
    "numerics.face_slices": 7,
    "numerics.roll_positions": 8,
    "numerics.profile_points": 31,
    "numerics.harmonics": 3,
    "numerics.tooth_compliance": "rigid",
    "numerics.threads": 1,
}
_LOAD = 100.0  # N/mm: any that closes a gap


def compile_late_kernels() -> None:
    """Call them once, on a coarse grid and under an even load, without what a run compiles before."""
    teeth = plan(sw.load_scene("face_gear_25x160").replace(_COARSE)).loaded_teeth()
    removed, load = teeth.removed(np.zeros(teeth.grid.profile.shape)), np.where(teeth.on_path, _LOAD, 0.0)
    lines, nothing = teeth.lines, np.zeros(load.shape)
    worn = Footprints(removed.every(teeth.rolls.substeps), lines.profile, nothing, nothing, nothing, nothing, nothing)
    solve_slices(lines, worn, load, teeth.problem.modulus, teeth.half_width)
    # by then the first process has compiled the footprints, of which these are made
    motion, taken = fresh_sweep(teeth.pair, teeth.fine), np.zeros(2)
    what = (motion, teeth.on_fine_rolls(load), teeth.half_width, teeth.problem.modulus, None, taken)
    wear_of_mesh(teeth.fine, teeth.grid, removed, *what)


if __name__ == "__main__":
    compile_late_kernels()
