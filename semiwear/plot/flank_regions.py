"""Regions of a flank: its inside and the strips along its borders."""

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

_HALF_WIDTHS = 2.0  # of the unworn contact: width of the strip along a border
_SMOOTHED = 5  # face stations over which the ends of the active flank are averaged: they lie on nodes


class Region(Enum):
    """Region of a flank by its distance from the borders."""

    INSIDE = "away from borders"
    TIP = "at the tip"
    LOWER_END = "at the lower end"
    FACE_ENDS = "at the face ends"
    CORNERS = "in the corners"


@dataclass(frozen=True)
class FlankRegions:
    """Strips along the borders of the active flank of a body.

    Attributes
    ----------
    width : float [mm]
        Width of the strips: two half-widths of the unworn contact with all of the load on one tooth.
    lower, upper : (face,) arrays [mm]
        Heights where the strips of the lower end and of the tip begin.
    first, last : float [mm]
        Face coordinates where the strips of the face ends begin.
    points : mapping of Region to (profile, face) bool array
        Grid points of each region; together the whole flank.
    """

    width: float
    lower: FloatArray
    upper: FloatArray
    first: float
    last: float
    points: Mapping[Region, BoolArray]


def flank_regions(results: TwoResults, body: str = "gear") -> FlankRegions | None:
    """Regions of a body's flank, common to both results; None without flanks or without line loads for the width."""
    widths = [width for width in map(_unworn_half_width, results.trees) if width is not None]
    if not (widths and results.have("flank", "active")):
        return None
    width = _HALF_WIDTHS * widths[0]
    flanks = [tree["flank"].to_dataset().sel(body=body) for tree in results.trees]
    height = np.asarray(flanks[0]["flank_height"].values, dtype=float)
    active = np.logical_or(*(flank["active"].values > 0 for flank in flanks))
    active |= ~active.any(axis=0)  # a slice without contact counts as active up to its ends
    lower = _smoothed(np.where(active, height, np.inf).min(axis=0)) + width
    upper = _smoothed(np.where(active, height, -np.inf).max(axis=0)) - width
    face = np.asarray(flanks[0]["face"].values, dtype=float)
    # half a slice lies beyond the outermost stations, which belong to the strips in any case
    beyond = 0.5 * (face[-1] - face[0]) / max(face.size - 1, 1)
    first, last = face[0] + max(width - beyond, 0.0), face[-1] - max(width - beyond, 0.0)
    high, low = height > upper, height < lower
    end = np.broadcast_to((face <= first) | (face >= last), height.shape)
    return FlankRegions(
        width,
        lower,
        upper,
        first,
        last,
        {
            Region.INSIDE: ~(high | low | end),
            Region.TIP: high & ~end,
            Region.LOWER_END: low & ~high & ~end,
            Region.FACE_ENDS: end & ~(high | low),
            Region.CORNERS: end & (high | low),
        },
    )


def _unworn_half_width(tree: xr.DataTree) -> float | None:
    """Half-width of the unworn contact by Hertz's law, 2 q/(pi p), with all of the load on one tooth [mm].

    It is taken where the load share is greatest, and is proportional to the root of the load.
    """
    if not all(has(tree, "engagement", name) for name in ("line_load", "contact_pressure_max", "load_share")):
        return None
    unworn = tree["engagement"].to_dataset().isel(wear_step=0)
    roll = int(unworn["load_share"].values.argmax())
    share, pressure = (float(unworn[name].values[roll]) for name in ("load_share", "contact_pressure_max"))
    load = float(unworn["line_load"].values[roll].max())
    if away_from_edges(unworn).isnull().values[roll] or min(share, pressure, load) <= 0.0:
        return None
    return float(2.0 * load / (pi * pressure * share**0.5))


def _smoothed(ends: FloatArray) -> FloatArray:
    """Moving average over `_SMOOTHED` stations."""
    around = _SMOOTHED // 2
    padded = np.pad(ends, around, mode="edge")
    return np.convolve(padded, np.full(_SMOOTHED, 1.0 / _SMOOTHED), mode="valid")
