"""Roll positions at which a mesh cycle is solved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import FloatArray
from semiwear.errors import SceneError
from semiwear.meshing.flank_pair import FlankPair
from semiwear.meshing.tooth_contact import misplaced, separation_of_neighbours

_FARTHEST = 4  # roll positions from the pitch point within which pairs are searched
_STEPS = 8  # per roll position in that search

_LESS_REACH = "lower operation.pinion_torque_Nm, give stiffer materials, or set numerics.tooth_pairs"


@dataclass(frozen=True)
class RollGrid:
    """Roll positions of several tooth pairs over one mesh cycle.

    Attributes
    ----------
    start : float
        Roll position from which the first pair is followed.
    pairs : int
        Tooth pairs; pair j of position m stands at ``start + phase[m] + j``.
    phase : (M,) array
        Mesh positions relative to `start`, in [0, 1), rising.
    substeps : int
        Steps of the fine grid, on which wear is summed, between two of these positions.
    """

    start: float
    pairs: int
    phase: FloatArray
    substeps: int = 1

    @property
    def roll(self) -> FloatArray:
        """All roll positions, rising: (pairs * M,) array."""
        return (self.start + np.arange(self.pairs)[:, None] + self.phase).ravel()

    @property
    def fine_roll(self) -> FloatArray:
        """The same with `substeps` positions for each."""
        if self.substeps == 1:
            return self.roll
        steps = self.phase.size * self.substeps
        return self.start + np.arange(self.pairs * steps) / steps

    @property
    def mesh_position(self) -> FloatArray:
        """Mesh positions modulo 1, in the order of `phase`."""
        position = np.mod(self.start + self.phase, 1.0)
        # rounding must not turn a whole number into one just below the next
        return np.where(position > 1.0 - 1e-9, 0.0, position)


def pairs_that_can_touch(pair: FlankPair, reach: float) -> tuple[float, int]:
    """First roll position, and number of pairs, that follow every contact nearer than `reach` [mm].

    Relative to the nearest pair at the same mesh position, since misaligned flanks transmit unevenly.

    Raises
    ------
    SceneError
        If the flanks meet nowhere at some mesh position, or still beyond the range of the search.
    """
    roll, separation, least = separation_of_neighbours(pair, _FARTHEST, _STEPS)
    near = roll[separation <= least + reach]
    if near[0] == roll[0] or near[-1] == roll[-1]:
        raise misplaced(
            pair,
            f"flanks nearer than {reach:.3g} mm to contact more than {_FARTHEST} base pitches from the pitch point",
            "contact that ends before, even under load",
            placed=f"bring the pinion closer to its nominal place, {_LESS_REACH}",
            aligned=_LESS_REACH,
        )
    start = float(np.floor(near[0]))
    return start, max(int(np.floor(near[-1]) - start) + 1, 1)


def even_roll_grid(start: float, pairs: int, positions: int, fine: int) -> RollGrid:
    """Evenly spaced mesh positions, with substeps for at least `fine` per mesh cycle."""
    substeps = max(1, -(-fine // positions))
    return RollGrid(start, pairs, np.arange(positions) / positions, substeps)


def checked_roll_positions(roll_positions: ArrayLike) -> FloatArray:
    """Roll positions, (K,): one at least, and finite ones."""
    given = np.atleast_1d(np.asarray(roll_positions, float))
    if given.size == 0 or not np.all(np.isfinite(given)):
        raise SceneError.of("roll_positions", given, "finite numbers, one at least")
    return given


def given_roll_grid(start: float, pairs: int, roll_positions: FloatArray) -> RollGrid:
    """Mesh positions given as roll positions, taken modulo 1."""
    phase = np.mod(np.round(checked_roll_positions(roll_positions) - start, 12), 1.0)
    return RollGrid(start, pairs, np.unique(phase))
