"""Volume that wears off: what Archard's law drives, what the maps of the flanks hold, and what edges take.

Archard's law for a body, with the wear coefficient k [mm^2/N], over all contact of one tooth and all its meshes:

    V = k N (integral of F |v_s| dt)     per mesh, F: normal force, v_s: sliding velocity

(Archard 1953, J. Appl. Phys. 24, 981-988: the volume is the normal force times the sliding distance, times the
coefficient). It is the integral over the flank of dh = k p |v_s| dt, so that |v_s| is its mean over the pressure of a
contact: at the pitch point a contact of finite width slides although its middle does not.

A map of wear depths ends where the rounding of the tip begins, and with the outermost slices of the face. What a
pressed rounding bears there wears it: that volume is in no map and is told by itself, so that

    volume on the map + volume on edges = V.

What is left of that equation is a check of everything between loads and maps: interpolation between roll positions,
footprints, sub-cycles and clipping. With a wear coefficient that depends on depth (`HardnessLaw`) the map does not
grow in proportion to V, and the equation does not hold.
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

__all__ = ["WearVolume", "map_volume", "sliding_work"]


_POINTS = 8  # across a contact


@dataclass(frozen=True)
class WearVolume:
    """Volume that a tooth's flank has lost by Archard's law; (body,) arrays [mm^3].

    Attributes
    ----------
    driven : array
        Wear coefficient times the integral of force times sliding.
    on_edges : array
        Of what was worn, the part beyond the map of the flank: on the roundings of the tip and of the ends.
    """

    driven: FloatArray
    on_edges: FloatArray

    @classmethod
    def none(cls) -> WearVolume:
        """Nothing yet."""
        return cls(np.zeros(len(BODIES)), np.zeros(len(BODIES)))

    def __add__(self, other: WearVolume) -> WearVolume:
        """Both together."""
        return WearVolume(self.driven + other.driven, self.on_edges + other.on_edges)


def sliding_work(weighted_loads: Sequence[WeightedLoads], motion: Sweep, teeth: LoadedTeeth) -> float:
    """Integral of force times sliding distance over one mesh of one tooth [N mm], from loads alone.

    Forces are straight between solved roll positions; the sliding velocity is averaged over Hertz's semi-ellipse
    about the middle of the contact.

    Parameters
    ----------
    weighted_loads : sequence of WeightedLoads
    motion : Sweep
        Of the fine roll grid.
    teeth : LoadedTeeth
    """
    # Gauss-Chebyshev points of the second kind: their weight is the semi-ellipse
    angle = np.pi * np.arange(1, _POINTS + 1) / (_POINTS + 1)
    place, weight = np.cos(angle), 2.0 / (_POINTS + 1) * np.sin(angle) ** 2
    total = 0.0
    for one in weighted_loads:
        loads = one.loads
        force = teeth.on_fine_rolls(loads.force * one.weight)
        bears = np.nonzero(force)
        half = teeth.on_fine_rolls(loads.half_width)[bears]
        away = (half / one.teeth.fine.spacing[bears])[:, None] * place
        middle, slope = motion.sliding[bears], motion.sliding_slope[bears]
        v = [middle[:, k, None] + slope[:, k, None] * away for k in (0, 1)]
        total += float(np.sum(force[bears] * motion.time[bears[0]] * (np.hypot(*v) @ weight)))
    return total


def map_volume(teeth: LoadedTeeth, driven: FloatArray, driving: FloatArray | None) -> FloatArray:
    """Volume of the wear depths on the maps of both flanks, (face, profile) [mm]: (body,) array [mm^3]."""
    volume = np.zeros(len(BODIES))
    volume[DRIVEN] = np.sum(driven * flank_area(teeth.pair, DRIVEN, teeth.grid))
    if driving is not None and teeth.driving is not None:
        volume[DRIVING] = np.sum(driving * flank_area(teeth.pair, DRIVING, teeth.driving.grid))
    return volume
