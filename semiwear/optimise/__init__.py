"""Best designs: fields of a scene chosen so that a quantity of its worn flanks is least, within limits of others."""

from __future__ import annotations

from semiwear.optimise.optimum import Optimum, Told
from semiwear.optimise.run import optimise

__all__ = ["Optimum", "Told", "optimise"]
