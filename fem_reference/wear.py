"""Wear depth on the gear's flank: read from a result's grid and interpolated to nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from fem_reference.arrays import FloatArray
from fem_reference.pair_motion import PairMotion
from semiwear.errors import SceneError
from semiwear.geometry.face_slices import slice_middles

_MM = 1e-3  # mm per um
_PLACES = ("flank_height", "flank_radius")  # of `/flank`


class WearDepth(Protocol):
    """Wear depth of the gear's flank along its normal."""

    def depth(self, face: FloatArray, profile: FloatArray) -> FloatArray:
        """Depth at gear radii and profile coordinates [mm]."""


@dataclass(frozen=True)
class NoWear:
    """An unworn flank."""

    def depth(self, face: FloatArray, profile: FloatArray) -> FloatArray:
        """Zero [mm]."""
        return np.zeros(np.broadcast(face, profile).shape)


@dataclass(frozen=True)
class FlankWear:
    """Depth on the grid of `/flank`.

    Attributes
    ----------
    face : (F,) array [mm]
    profile, values : (P, F) arrays [mm]
        Profile coordinate, growing, and depth.
    """

    face: FloatArray
    profile: FloatArray
    values: FloatArray

    def depth(self, face: FloatArray, profile: FloatArray) -> FloatArray:
        """Linear along the grid lines, which preserves a cusp on them; beyond its ends constant [mm]."""
        face, profile = np.broadcast_arrays(np.asarray(face, float), np.asarray(profile, float))
        result = np.empty(face.shape)
        flat_face, flat_profile, flat = face.ravel(), profile.ravel(), result.reshape(-1)
        stations, where = np.unique(flat_face, return_inverse=True)
        for k, station in enumerate(stations):
            chosen = where == k
            place = float(np.interp(station, self.face, np.arange(len(self.face))))
            low = min(int(place), len(self.face) - 2)
            share = place - low
            nodes, values = (
                (1.0 - share) * table[:, low] + share * table[:, low + 1] for table in (self.profile, self.values)
            )
            flat[chosen] = np.interp(flat_profile[chosen], nodes, values)
        return result


def face_stations(pair: PairMotion) -> FloatArray:
    """Face stations of `/flank`: the middles of equal slices [mm]."""
    table = pair.scene.gear_pair
    radii = float(table.gear_end_edge_radius_mm), float(table.pinion_end_edge_radius_mm)
    faces = (pair.gear_face, radii[0]), (pair.pinion_face, radii[1])
    whole = max(face[0] + radius for face, radius in faces), min(face[1] - radius for face, radius in faces)
    return slice_middles(pair.gear_face, whole, pair.scene.numerics.face_slices)


def flank_profile(pair: PairMotion, face: FloatArray) -> FloatArray:
    """Profile coordinates of the gear's `/flank` grid, (profile, face), even beside the pitch cone [mm]."""
    gear, points = pair.gear, pair.scene.numerics.profile_points
    tip = gear.tip_profile(face) - pair.edge_insets(face).gear_tip
    root = np.full(face.shape, gear.root_profile)
    pitch = pair.pitch_profile(face)
    split = np.clip(np.rint((pitch - root) / (tip - root) * (points - 1)), 0, points - 1)
    split = np.where((split < 2) | (split > points - 3), points - 1, split)
    middle = np.where(split == points - 1, tip, pitch)
    index = np.arange(points)[:, None]
    below = root + (middle - root) * index / split
    above = middle + (tip - middle) * (index - split) / np.maximum(points - 1 - split, 1)
    return np.asarray(np.where(index <= split, below, above))


def _by_labels(given: xr.DataArray) -> FloatArray:
    """Values (profile, face), or (body, profile, face) with the pinion first; a body that is missing is unworn."""
    last = given.isel(wear_step=-1) if "wear_step" in given.dims else given
    if "body" in last.coords:
        last = last if "body" in last.dims else last.expand_dims("body")
        last = last.reindex(body=["pinion", "gear"], fill_value=0.0)
    order = [name for name in ("body", "profile", "face") if name in last.dims]
    return np.asarray(last.transpose(*order, ...), dtype=float)


def wear_depth_of(given: ArrayLike | xr.Dataset | xr.DataTree | xr.DataArray | None, pair: PairMotion) -> WearDepth:
    """Wear depth from user data.

    Parameters
    ----------
    given : Dataset or DataTree of `/flank`, DataArray, array or None
        A `/flank` group with `wear_depth`, `flank_height` and `flank_radius` (its last wear step counts): any grid. A
        `wear_depth` array or DataArray, (body, profile, face) or (profile, face) [um]: on the grid that the scene's
        own `numerics` give, as `simulate` and `semiwear.loaded_contact` have it, at a DataArray's own face
        coordinates where it has them. Labels count: bodies by their names, dimensions in any order. None: unworn.
    pair : PairMotion

    Raises
    ------
    SceneError
        For a wrong shape, values that are negative or not finite, or a worn pinion.
    """
    if given is None:
        return NoWear()
    if isinstance(given, xr.DataTree):
        given = given.to_dataset()
    if isinstance(given, xr.Dataset):
        table = given.isel(wear_step=-1) if "wear_step" in given.dims else given
        height, radius = (_by_labels(table[name].sel(body="gear", drop=True)) for name in _PLACES)
        face, profile = pair.flank_grid(np.asarray(table["face"]), radius, height)
        depth = _by_labels(table["wear_depth"])
    else:
        labelled = given if isinstance(given, xr.DataArray) else None
        face = (
            face_stations(pair) if labelled is None or "face" not in labelled.coords else np.asarray(labelled["face"])
        )
        profile = flank_profile(pair, face)
        depth = np.asarray(given, dtype=float) if labelled is None else _by_labels(labelled)
    if depth.ndim == 3 and depth.shape[0] == 2:
        if np.any(depth[0] != 0.0):
            raise SceneError.of("wear_depth", "a worn pinion", "zero on the pinion", "only the gear may be worn")
        depth = depth[1]
    if depth.shape != profile.shape:
        raise SceneError.of(
            "wear_depth", f"an array of shape {depth.shape}", f"(profile, face) = {profile.shape}",
            "pass the whole /flank group of the result, or use the same numerics",
        )  # fmt: skip
    if not np.all(np.isfinite(depth)) or np.any(depth < 0.0):
        raise SceneError.of("wear_depth", "negative or not finite", "finite numbers >= 0 [um]")
    return FlankWear(np.asarray(face), np.asarray(profile), _MM * depth)
