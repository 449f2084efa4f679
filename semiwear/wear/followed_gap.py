"""Material removed from two worn flanks where footprints may lie, followed over the cycles of a wear step."""

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

__all__ = ["FollowedGap"]

_FOLLOWED = 4.0  # depths of a footprint that the flanks wear by before its nodes are looked for anew


@dataclass
class FollowedGap:
    """Material removed from two flanks that wear, at the nodes that footprints can close.

    Attributes
    ----------
    teeth : LoadedTeeth
    line_load : (roll, face) array [N/mm]
    slices : int array
        Of the driven flank, that are followed.
    """

    teeth: LoadedTeeth
    line_load: FloatArray
    slices: IntArray
    _since: tuple[FloatArray, FloatArray] | None = field(default=None, init=False)
    _windows: IntArray | None = field(default=None, init=False)
    _last: Removed | None = field(default=None, init=False)

    def removed(self, driven: FloatArray, driving: FloatArray) -> Removed:
        """Of flanks as worn as this [mm], in arrays that nobody changes; what it gave before is overwritten."""
        if self._since is None or self._windows is None or self._worn_since(driven, driving) > self.margin:
            wide = self.teeth.widest_windows(driven, driving, self.line_load > 0.0, self.margin)
            whole = self.teeth.removed_at_nodes(driven, driving, self.slices, wide, self._last)
            self._since = driven, driving
            closes = closed_alone(self.line_load, self.teeth.problem.modulus)
            self._windows = narrow(self.teeth.fine, whole, self.teeth.half_width, closes, self.margin, self.slices)
            self._last = replace(whole, windows=self._windows)
        else:
            self._last = self.teeth.removed_at_nodes(driven, driving, self.slices, self._windows, self._last)
        return self._last

    def _worn_since(self, driven: FloatArray, driving: FloatArray) -> float:
        """By how much both flanks together have worn at most since the windows were found [mm]."""
        assert self._since is not None
        return sum(float((now - then).max()) for now, then in zip((driven, driving), self._since, strict=True))

    @cached_property
    def margin(self) -> float:
        """Wear of both flanks together after which their nodes are looked for anew [mm]."""
        lines, loaded = self.teeth.fine, self.line_load > 0.0
        bends = lines.separation[2][loaded] / lines.spacing[loaded] ** 2
        return float(_FOLLOWED * depth_of(float(np.median(bends)), self.teeth.half_width))
