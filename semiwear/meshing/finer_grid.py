"""Finer nodes of the driven flank at which the driving flank's wear is interpolated, continued beyond the tip.

The contact passes the flank of one tooth near its root much more slowly than the other's near its tip: between the
nodes of the driven flank, points of the driving one would never be met and so never wear. The rounding of the tip
presses on the wall at the end of its own path.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.kernel_cache import ZERO, njit
from semiwear.meshing.flank_grid import FlankGrid, change_above, cubic, slopes_between


@dataclass(frozen=True)
class FinerGrid(FlankGrid):
    """Nodes between those of a grid, and beyond its tip.

    Attributes
    ----------
    parts : int
        Parts of every cell of the grid.
    """

    parts: int

    def from_grid(self, values: FloatArray) -> FloatArray:
        """Values at the grid's nodes (..., face, profile), by `smooth_value` at these; constant beyond the tip."""
        own = np.ascontiguousarray(self.profile[:, : (values.shape[-1] - 1) * self.parts + 1 : self.parts])
        rows = np.ascontiguousarray(values).reshape(-1, *values.shape[-2:])
        inside = _read(rows, own, self.split // self.parts, self.parts).reshape(*values.shape[:-1], -1)
        beyond = self.profile.shape[1] - inside.shape[-1]
        return np.concatenate([inside, np.repeat(values[..., -1:], beyond, axis=-1)], axis=-1)


def finer_grid(grid: FlankGrid, parts: int, beyond: float) -> FinerGrid:
    """The nodes of a grid with its cells cut into `parts`, continued beyond its tip by a distance [mm]."""
    spacing = (grid.profile[:, -1:] - grid.profile[:, -2:-1]) / parts
    steps = np.arange(int(np.ceil(beyond / spacing.min())) + 1)
    beyond_tip = grid.profile[:, -1:] + spacing * steps
    return FinerGrid(grid.face, np.hstack([_cut(grid.profile, parts), beyond_tip]), grid.split * parts, parts)


def _cut(values: FloatArray, parts: int) -> FloatArray:
    """Values at the beginnings of the parts of all cells, linear between nodes (..., profile)."""
    between = values[..., :-1, None] + np.diff(values)[..., None] * (np.arange(parts) / parts)
    return between.reshape(*values.shape[:-1], -1)


@njit(cache=True, error_model="numpy")
def _read(values, nodes, split, parts):  # type: ignore[no-untyped-def]
    """Values at the beginnings of the parts of all cells, from those on the nodes of each slice."""
    cells = nodes.shape[1] - 1
    out, slope = np.empty((values.shape[0], values.shape[1], cells * parts)), np.empty(nodes.shape[1])
    for r in range(values.shape[0]):
        for i in range(values.shape[1]):
            own = values[r, i]
            slopes_between(own, nodes[i], split[i], ZERO, nodes.shape[1], slope)
            for cell in range(cells):
                before, after = change_above(slope[cell], nodes[i], split[i], cell), slope[cell + 1]
                for part in range(parts):
                    out[r, i, cell * parts + part] = cubic(own[cell], own[cell + 1], before, after, part / parts)
    return out
