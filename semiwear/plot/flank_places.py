"""Places of a flank: its inside and the strips along its borders."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from math import pi

import numpy as np
import xarray as xr

from semiwear.arrays import BoolArray, FloatArray
from semiwear.plot.two_results import TwoResults, has
from semiwear.results.missing import away_from_edges

_HALF_WIDTHS = 2.0  # of a fresh contact: how far in from a border its strip reaches
_SMOOTHED = 5  # face stations over whose mean the ends of the active flank are taken: flags have steps of a node


class Place(Enum):
    """Part of a flank by its distance from the borders."""

    INSIDE = "away from borders"
    TIP = "at the tip"
    LOWER_END = "at the lower end"
    FACE_ENDS = "at the face ends"
    CORNERS = "in the corners"


@dataclass(frozen=True)
class FlankPlaces:
    """Strips along the borders of the active flank of a body.

    Attributes
    ----------
    width : float [mm]
        Width of the strips: two half-widths of a fresh contact with all of the load on one tooth.
    lower, upper : (face,) arrays [mm]
        Heights where the strips of the lower end and of the tip begin.
    first, last : float [mm]
        Face coordinates where the strips of the face ends begin.
    of : mapping of Place to (profile, face) bool array
        Points of each place; together the whole flank.
    """

    width: float
    lower: FloatArray
    upper: FloatArray
    first: float
    last: float
    of: Mapping[Place, BoolArray]


def flank_places(results: TwoResults, body: str = "gear") -> FlankPlaces | None:
    """Places of a body's flank that both results share; None without a flank or without line loads to measure by."""
    widths = [width for width in map(_fresh_half_width, results.trees) if width is not None]
    if not (widths and results.have("flank", "active")):
        return None
    width = _HALF_WIDTHS * widths[0]
    flanks = [tree["flank"].to_dataset().sel(body=body) for tree in results.trees]
    height = np.asarray(flanks[0]["flank_height"].values, dtype=float)
    active = np.logical_or(*(flank["active"].values > 0 for flank in flanks))
    active |= ~active.any(axis=0)  # a slice that nothing reaches counts to its ends
    lower = _smoothed(np.where(active, height, np.inf).min(axis=0)) + width
    upper = _smoothed(np.where(active, height, -np.inf).max(axis=0)) - width
    face = np.asarray(flanks[0]["face"].values, dtype=float)
    # half a slice lies beyond the outermost stations; these count in any case
    beyond = 0.5 * (face[-1] - face[0]) / max(face.size - 1, 1)
    first, last = face[0] + max(width - beyond, 0.0), face[-1] - max(width - beyond, 0.0)
    high, low = height > upper, height < lower
    end = np.broadcast_to((face <= first) | (face >= last), height.shape)
    return FlankPlaces(
        width,
        lower,
        upper,
        first,
        last,
        {
            Place.INSIDE: ~(high | low | end),
            Place.TIP: high & ~end,
            Place.LOWER_END: low & ~high & ~end,
            Place.FACE_ENDS: end & ~(high | low),
            Place.CORNERS: end & (high | low),
        },
    )


def _fresh_half_width(tree: xr.DataTree) -> float | None:
    """Half-width of the unworn contact by Hertz's law, 2 q/(pi p), with all of the load on one tooth [mm].

    It is read where the load share is greatest and grows with the root of the load.
    """
    if not all(has(tree, "engagement", name) for name in ("line_load", "contact_pressure_max", "load_share")):
        return None
    fresh = tree["engagement"].to_dataset().isel(wear_step=0)
    roll = int(fresh["load_share"].values.argmax())
    share, pressure = (float(fresh[name].values[roll]) for name in ("load_share", "contact_pressure_max"))
    load = float(fresh["line_load"].values[roll].max())
    if away_from_edges(fresh).isnull().values[roll] or min(share, pressure, load) <= 0.0:
        return None
    return float(2.0 * load / (pi * pressure * share**0.5))


def _smoothed(ends: FloatArray) -> FloatArray:
    around = _SMOOTHED // 2
    padded = np.pad(ends, around, mode="edge")
    return np.convolve(padded, np.full(_SMOOTHED, 1.0 / _SMOOTHED), mode="valid")
