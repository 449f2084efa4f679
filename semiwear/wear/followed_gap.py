"""Material removed from two worn flanks where footprints may lie, updated over the cycles of a wear step."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.contact.edge_share import closed_alone
from semiwear.contact.footprint import depth_of
from semiwear.contact.footprint_windows import narrow
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.meshing.removed import Removed

_MARGIN = 4.0  # footprint depths that the flanks wear before the windows of nodes are found again


@dataclass
class FollowedGap:
    """Material removed from two flanks while they wear, at the nodes within reach of footprints.

    Attributes
    ----------
    teeth : LoadedTeeth
    line_load : (roll, face) array [N/mm]
    slices : int array
        Slices of the driven flank that are needed.
    """

    teeth: LoadedTeeth
    line_load: FloatArray
    slices: IntArray
    _since: tuple[FloatArray, FloatArray] | None = field(default=None, init=False)
    _last: Removed | None = field(default=None, init=False)

    def removed(self, driven: FloatArray, driving: FloatArray) -> Removed:
        """Material removed at these wear depths [mm]; read-only, and overwritten by the next call."""
        teeth, last = self.teeth, self._last
        if last is not None and last.windows is not None and self._worn_since(driven, driving) <= self.margin:
            self._last = teeth.removed_at_nodes(driven, driving, self.slices, last.windows, last)
            return self._last
        wide = teeth.widest_windows(driven, driving, self.line_load > 0.0, self.margin)
        whole = teeth.removed_at_nodes(driven, driving, self.slices, wide, last)
        closes = closed_alone(self.line_load, teeth.problem.modulus)
        windows = narrow(teeth.fine, whole, teeth.half_width, closes, self.margin, self.slices)
        self._since, self._last = (driven, driving), replace(whole, windows=windows)
        return self._last

    def _worn_since(self, driven: FloatArray, driving: FloatArray) -> float:
        """Greatest wear of both flanks together since the windows were found [mm]."""
        assert self._since is not None
        return sum(float((now - then).max()) for now, then in zip((driven, driving), self._since, strict=True))

    @cached_property
    def margin(self) -> float:
        """Wear of both flanks together after which the windows are found again [mm]."""
        bends = self.teeth.fine.curvature[self.line_load > 0.0]
        if bends.size == 0:  # no load, no wear
            return 0.0
        return float(_MARGIN * depth_of(float(np.median(bends)), self.teeth.half_width))
