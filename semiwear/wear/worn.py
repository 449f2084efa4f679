"""Wear depths of both flanks, and the factors from p |v_s| dt to depths."""

from __future__ import annotations

from typing import NamedTuple

from semiwear.arrays import FloatArray


class Worn(NamedTuple):
    """Wear depths of both flanks, each on its own nodes [mm]; None for a driving flank that does not wear."""

    driven: FloatArray
    driving: FloatArray | None = None

    @property
    def deepest(self) -> float:
        """Greatest wear depth of both flanks [mm]."""
        return max(float(depth.max()) for depth in self if depth is not None)

    def deepest_since(self, before: Worn) -> float:
        """Greatest wear of either flank since then [mm]."""
        return self.plus(-1.0, before).deepest

    def plus(self, times: float, other: Worn) -> Worn:
        """These depths plus a multiple of others."""
        driving = None
        if self.driving is not None and other.driving is not None:
            driving = self.driving + times * other.driving
        return Worn(self.driven + times * other.driven, driving)

    def towards(self, share: float, other: Worn) -> Worn:
        """Depths between these and others: the others at a share of 1."""
        return self.plus(share, other.plus(-1.0, self))


class WearMultipliers(NamedTuple):
    """Number of meshes times wear coefficient of each body [mm^2/N]: wear depth over p |v_s| dt of a mesh."""

    driven: float
    driving: float = 0.0
