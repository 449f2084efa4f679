"""Wear depths of both flanks, and what turns pressures and distances into them."""

from __future__ import annotations

from typing import NamedTuple

from semiwear.arrays import FloatArray

__all__ = ["WearMultipliers", "Worn"]


class Worn(NamedTuple):
    """Wear depths of the flanks, each on its own nodes [mm]; None for a driving flank that does not wear."""

    driven: FloatArray
    driving: FloatArray | None = None

    @property
    def deepest(self) -> float:
        """Greatest wear depth of both [mm]."""
        return max(float(depth.max()) for depth in self if depth is not None)

    def deepest_since(self, before: Worn) -> float:
        """Greatest depth that either flank has worn by since then [mm]."""
        return self.plus(-1.0, before).deepest

    def plus(self, times: float, other: Worn) -> Worn:
        """Depths and so many times others."""
        driving = None
        if self.driving is not None and other.driving is not None:
            driving = self.driving + times * other.driving
        return Worn(self.driven + times * other.driven, driving)

    def towards(self, share: float, other: Worn) -> Worn:
        """Depths a share of the way to others."""
        return self.plus(share, other.plus(-1.0, self))


class WearMultipliers(NamedTuple):
    """Number of meshes times wear coefficient of each body [mm^2/N]: depths are these times pressure and distance."""

    driven: float
    driving: float = 0.0
