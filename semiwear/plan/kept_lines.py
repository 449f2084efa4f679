"""Contact lines and first contact of unworn flanks, cached between plans, since they depend on geometry alone."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.meshing.contact_lines import ContactLines, trace_contact_lines
from semiwear.meshing.flank_pair import FlankPair
from semiwear.meshing.roll_grid import RollGrid
from semiwear.meshing.tooth_contact import ContactPoints, contact_points

_MOST_ROLLS = 2048  # roll positions of a pair whose lines are kept


def contact_lines(pair: FlankPair, rolls: RollGrid, face: FloatArray) -> tuple[ContactLines, ContactLines]:
    """Contact lines on the fine roll grid, and those at the solved positions; read-only.

    Equal arguments give the same objects, so that what is prepared for them can be cached as well.
    """
    return _traced(pair, rolls.fine_roll.tobytes(), face.tobytes(), rolls.substeps)


@lru_cache(maxsize=8)
def _traced(pair: FlankPair, roll: bytes, face: bytes, substeps: int) -> tuple[ContactLines, ContactLines]:
    fine = trace_contact_lines(pair, np.frombuffer(roll).copy(), np.frombuffer(face).copy())
    return fine, fine.every(substeps)


def lines_at(pair: FlankPair, rolls: RollGrid, face: FloatArray) -> ContactLines:
    """As `contact_lines` at single mesh positions, each traced once, whichever others are asked for with it."""
    known = _known_lines(pair, face.tobytes())
    new = np.array([roll for roll in rolls.roll if roll not in known])
    if new.size:
        if len(known) + new.size > _MOST_ROLLS:
            known.clear()
            new = rolls.roll
        lines = trace_contact_lines(pair, new, face)
        known.update((roll, (lines, k)) for k, roll in enumerate(new))
    return ContactLines.of_rolls([known[roll] for roll in rolls.roll])


@lru_cache(maxsize=8)
def _known_lines(pair: FlankPair, face: bytes) -> dict[float, tuple[ContactLines, int]]:
    """Lines that hold a roll position, and its number among theirs."""
    return {}


@lru_cache(maxsize=8)
def middle_contact(pair: FlankPair) -> ContactPoints:
    """First contact of a pair in the middle of its path of contact; read-only."""
    return contact_points(pair, np.zeros(1))
