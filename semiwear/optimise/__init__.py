"""Best designs: fields of a scene chosen so that a quantity of its worn flanks is least, within limits on others."""

from __future__ import annotations

from semiwear.optimise.optimum import Optimum, QuantityChange
from semiwear.optimise.run import optimise

__all__ = ["Optimum", "QuantityChange", "optimise"]
