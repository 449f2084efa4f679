"""The driven flank's nodes where the driving flank's wear is read: closer together, and on beyond the tip.

A tooth's tip passes the other's flank near its root several times as fast as its own: between the nodes of the driven
flank there would be depths of the driving one that nothing ever meets, and so never wears. The rounding of the tip
presses on the wall at the end of its own path.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.kernel_cache import ZERO, njit
from semiwear.meshing.flank_grid import FlankGrid, change_above, cubic, slope_at

__all__ = ["FinerGrid", "finer_grid"]


@dataclass(frozen=True)
class FinerGrid(FlankGrid):
    """Nodes between those of a grid, and beyond its tip.

    Attributes
    ----------
    parts : int
        Of every cell of the grid.
    """

    parts: int

    def from_grid(self, values: FloatArray) -> FloatArray:
        """Values on the grid's own nodes (..., face, profile) on these: as `smooth_value`, even beyond the tip."""
        own = np.ascontiguousarray(self.profile[:, : (values.shape[-1] - 1) * self.parts + 1 : self.parts])
        rows = np.ascontiguousarray(values).reshape(-1, *values.shape[-2:])
        inside = _read(rows, own, self.split // self.parts, self.parts).reshape(*values.shape[:-1], -1)
        beyond = self.profile.shape[1] - inside.shape[-1]
        return np.concatenate([inside, np.repeat(values[..., -1:], beyond, axis=-1)], axis=-1)


def finer_grid(grid: FlankGrid, parts: int, beyond: float) -> FinerGrid:
    """The nodes of a grid with its cells cut into `parts`, and as many beyond its tip as reach so far [mm]."""
    spacing = (grid.profile[:, -1:] - grid.profile[:, -2:-1]) / parts
    steps = np.arange(int(np.ceil(beyond / spacing.min())) + 1)
    beyond_tip = grid.profile[:, -1:] + spacing * steps
    return FinerGrid(grid.face, np.hstack([_cut(grid.profile, parts), beyond_tip]), grid.split * parts, parts)


def _cut(values: FloatArray, parts: int) -> FloatArray:
    """Values at the beginnings of the parts of all cells, straight between nodes (..., profile)."""
    between = values[..., :-1, None] + np.diff(values)[..., None] * (np.arange(parts) / parts)
    return between.reshape(*values.shape[:-1], -1)


@njit(cache=True, error_model="numpy")
def _read(values, nodes, split, parts):  # type: ignore[no-untyped-def]
    """Values at the beginnings of the parts of all cells, from those on the nodes of each slice."""
    cells = nodes.shape[1] - 1
    out = np.empty((values.shape[0], values.shape[1], cells * parts))
    for r in range(values.shape[0]):
        for i in range(values.shape[1]):
            own = values[r, i]
            after = slope_at(own, nodes[i], split[i], ZERO)
            for cell in range(cells):
                before = change_above(after, nodes[i], split[i], cell)
                after = slope_at(own, nodes[i], split[i], cell + 1)
                for part in range(parts):
                    out[r, i, cell * parts + part] = cubic(own[cell], own[cell + 1], before, after, part / parts)
    return out
