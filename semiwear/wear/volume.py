"""Worn volume: by Archard's law, on the maps of the flanks, and on edges.

Archard's law for a body, with the wear coefficient k [mm^2/N], over all contact of one tooth and all its meshes:

    V = k N (integral of F |v_s| dt)     per mesh, F: normal force, v_s: sliding velocity

(Archard 1953, J. Appl. Phys. 24, 981-988: the volume is the normal force times the sliding distance, times the
coefficient). It is the integral over the flank of dh = k p |v_s| dt, so that |v_s| is its mean over the pressure of a
contact: at the pitch point a contact of finite width slides although its middle does not.

A map of wear depths ends where the rounding of the tip begins, and with the outermost slices of the face. A pressed
rounding wears as well: this volume is on no map and is reported separately, so that

    volume on the map + volume on edges = V.

The residual of this equation checks everything between loads and maps: interpolation between roll positions,
footprints, cycles and clipping. With a wear coefficient that depends on depth (`HardnessLaw`) the map does not grow
in proportion to V, and the equation does not hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.meshing.flank_area import flank_area
from semiwear.meshing.flank_pair import BODIES, DRIVEN, DRIVING

if TYPE_CHECKING:
    from semiwear.contact.loaded_teeth import LoadedTeeth
    from semiwear.wear.mapping import WeightedLoads
    from semiwear.wear.swept_line import Sweep


_POINTS = 8  # across a contact


@dataclass(frozen=True)
class WearVolume:
    """Volume worn off a flank of one tooth; (body,) arrays [mm^3].

    Attributes
    ----------
    driven : array
        By Archard's law: wear coefficient times the integral of force times sliding.
    on_edges : array
        The part of the worn volume beyond the map of the flank, on the roundings of the tip and of the ends.
    """

    driven: FloatArray
    on_edges: FloatArray

    @classmethod
    def none(cls) -> WearVolume:
        """No volume."""
        return cls(np.zeros(len(BODIES)), np.zeros(len(BODIES)))

    def __add__(self, other: WearVolume) -> WearVolume:
        """Sum of both volumes."""
        return WearVolume(self.driven + other.driven, self.on_edges + other.on_edges)


def sliding_work(weighted_loads: Sequence[WeightedLoads], motion: Sweep, teeth: LoadedTeeth) -> float:
    """Integral of force times sliding distance over one mesh of one tooth [N mm], from the loads alone.

    Forces are linear between solved roll positions; the sliding velocity is averaged over Hertz's semi-ellipse around
    the middle of the contact.

    Parameters
    ----------
    weighted_loads : sequence of WeightedLoads
    motion : Sweep
        On the fine roll grid.
    teeth : LoadedTeeth
    """
    # Gauss-Chebyshev points of the second kind, whose weight is the semi-ellipse
    angle = np.pi * np.arange(1, _POINTS + 1) / (_POINTS + 1)
    place, weight = np.cos(angle), 2.0 / (_POINTS + 1) * np.sin(angle) ** 2
    total = 0.0
    for case in weighted_loads:
        force = teeth.on_fine_rolls(case.loads.force * case.weight)
        loaded = np.nonzero(force)
        half_width = teeth.on_fine_rolls(case.loads.half_width)[loaded]
        distance = (half_width / case.teeth.fine.spacing[loaded])[:, None] * place
        middle, slope = motion.sliding[loaded], motion.sliding_slope[loaded]
        v = [middle[:, k, None] + slope[:, k, None] * distance for k in (0, 1)]
        total += float(np.sum(force[loaded] * motion.time[loaded[0]] * (np.hypot(*v) @ weight)))
    return total


def map_volume(teeth: LoadedTeeth, driven: FloatArray, driving: FloatArray | None) -> FloatArray:
    """Volume of the wear depths on the maps of both flanks, (face, profile) [mm]: (body,) array [mm^3]."""
    volume = np.zeros(len(BODIES))
    volume[DRIVEN] = np.sum(driven * flank_area(teeth.pair, DRIVEN, teeth.grid))
    if driving is not None and teeth.driving is not None:
        volume[DRIVING] = np.sum(driving * flank_area(teeth.pair, DRIVING, teeth.driving.grid))
    return volume
