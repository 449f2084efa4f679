"""Measured wear: from measurements of a flank before and after, or from one measurement and the nominal flank."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scipy.interpolate import LinearNDInterpolator

from semiwear.arrays import BoolArray, FloatArray
from semiwear.errors import SceneError
from semiwear.measured.files import Measurement, read_measured
from semiwear.measured.nominal import NominalFlank, nominal_flank
from semiwear.measured.quantities import labelled
from semiwear.measured.registration import OnFlank, registered
from semiwear.meshing.flank_deviations import deviations_of
from semiwear.meshing.flank_pair import BODIES
from semiwear.scene import Scene

Measured = str | os.PathLike[str] | ArrayLike | Measurement | xr.Dataset
"""A measurement, or a dataset of `register` or `measured_wear`."""

_UM = 1e3
_SAME_PLACE = 1e-4  # mm
_LEAST_POINTS = 16


@dataclass(frozen=True)
class MeasuredWear(OnFlank):
    """Measured wear at the points of a grid.

    Attributes
    ----------
    depth : (profile, face) array [mm]
        Positive for material removed; 0 where not inside.
    """

    depth: FloatArray

    def to_dataset(self, attrs: dict[str, str]) -> xr.Dataset:
        """`wear_depth` [um] and the positions of the points."""
        return labelled({"wear_depth": _UM * self.depth, **self.where()}, attrs, "measured wear")


def measured_wear(
    scene: Scene,
    after: Measured,
    before: Measured | None = None,
    body: str = "gear",
    *,
    datum: str = "best_fit",
    fit: str = "one_sided",
) -> xr.Dataset:
    """Wear of a flank from two measurements, or from one against the nominal flank.

    Parameters
    ----------
    scene : Scene
    after : path, (P, F, 3) array [mm], PointGrid, DeviationGrid or Dataset
        Worn flank; a Dataset is that of `register`, or one of this function, taken as it is.
    before : the same, optional
        Unworn flank of the same tooth. Without it the unworn flank is assumed to be nominal, with the modifications
        of the scene; form errors of the new tooth then count as wear.
    body : str
    datum, fit : str
        As for `register`; the measurement before wear is fitted to "all" of its points. `calibrate` and
        `compare_wear` fit the datum again and so correct a remaining error.

    Returns
    -------
    Dataset
        `wear_depth` [um] over (profile, face), positive for material removed, and the positions of the points.
        Negative values are noise, build-up or an error of the datum.

    Raises
    ------
    SceneError
        As `register`; also if the two measurements do not overlap.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import semiwear as sw
    >>> coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.wear_steps": 1}
    >>> scene, path = sw.load_scene("spur_fzg_c").replace(coarse), pathlib.Path(tempfile.mkdtemp(), "worn.nc")
    >>> sw.export_flank(scene, "gear", path, points=(21, 9), worn=sw.simulate(scene))
    >>> wear = sw.measured_wear(scene, path)
    >>> wear.wear_depth.dims, wear.wear_depth.attrs["units"]
    (('profile', 'face'), 'um')
    """
    found = as_wear(scene, after, before, body, datum=datum, fit=fit)
    return found.to_dataset({"body": body, "datum": datum, "against": "nominal" if before is None else "before"})


def as_wear(
    scene: Scene,
    after: Measured,
    before: Measured | None,
    body: str,
    *,
    datum: str = "best_fit",
    fit: str = "one_sided",
    field: str = "measured",
) -> MeasuredWear:
    """As `measured_wear`, with wear in mm."""
    flank = nominal_flank(scene, body)
    if isinstance(after, xr.Dataset) and "wear_depth" in after:
        if before is not None:
            raise SceneError.of("before", "a measurement", "none beside measured wear", "the wear is known already")
        return _from_dataset(flank, after, "wear_depth", field)
    worn = _deviations(flank, after, datum, fit, field)
    if before is None:
        new = -_modified(scene, flank, worn)
        counts = worn.inside
    else:
        unworn = _deviations(flank, before, datum, "all", "before")
        new, counts = _at_points_of(unworn, worn)
    if counts.sum() < _LEAST_POINTS:
        raise SceneError.of(
            field, f"{int(counts.sum())} points in common", f"{_LEAST_POINTS} points or more",
            "measure the same part of the same flank before and after",
        )  # fmt: skip
    return MeasuredWear(flank, worn.face, worn.profile, counts, np.where(counts, new - worn.depth, 0.0))


def _deviations(flank: NominalFlank, measured: Measured, datum: str, fit: str, field: str) -> MeasuredWear:
    """Registered measurement, with its deviations in the field `depth`."""
    if isinstance(measured, xr.Dataset):
        return _from_dataset(flank, measured, "deviation", field)
    found = registered(flank, read_measured(measured, field), datum=datum, fit=fit, field=field)
    return MeasuredWear(flank, found.face, found.profile, found.inside, found.deviation)


def _from_dataset(flank: NominalFlank, data: xr.Dataset, name: str, field: str) -> MeasuredWear:
    body = BODIES[flank.body]
    other = str(data.attrs.get("body", body))
    if other != body:
        raise SceneError.of(field, f"a flank of the {other}", f"one of the {body}", f'body = "{other}"')
    missing = [variable for variable in (name, "flank_profile", "flank_face", "inside") if variable not in data]
    if missing:
        raise SceneError.of(field, f"a dataset without {missing[0]}", "one that register or measured_wear made")
    face, profile, values = (
        np.asarray(data[variable].transpose("profile", "face").values, float)
        for variable in ("flank_face", "flank_profile", name)
    )
    inside = np.asarray(data["inside"].transpose("profile", "face").values).astype(bool)
    if not all(np.all(np.isfinite(entry)) for entry in (face, profile, values)):
        raise SceneError.of(field, f"{name} that is not finite", "finite numbers", "set inside to 0 and fill with 0")
    return MeasuredWear(flank, face, profile, inside, np.where(inside, values / _UM, 0.0))


def _modified(scene: Scene, flank: NominalFlank, at: MeasuredWear) -> FloatArray:
    """Depth of the flank deviations of the scene, at the points of a measurement [mm]."""
    root, tip = flank.limits(at.face)
    depth = np.zeros(at.face.shape)
    for deviation in deviations_of(scene.effects.present(), flank.body):
        depth = depth + deviation.depth(at.profile, at.face, root, tip, flank.face_ends)
    return depth


def _at_points_of(first: MeasuredWear, second: MeasuredWear) -> tuple[FloatArray, BoolArray]:
    """Values of the first measurement, linear between its points, at those of the second, and where both count."""
    if first.face.shape == second.face.shape:
        distance = max(
            float(np.abs(a - b).max()) for a, b in ((first.face, second.face), (first.profile, second.profile))
        )
        if distance <= _SAME_PLACE:
            return first.depth, first.inside & second.inside
    low, high = first.flank.face_ends

    def fractions(at: MeasuredWear) -> FloatArray:
        root, tip = at.flank.limits(at.face)
        return np.stack([(at.face - low) / (high - low), (at.profile - root) / (tip - root)], axis=-1)

    first_values = LinearNDInterpolator(fractions(first)[first.inside], first.depth[first.inside], fill_value=np.nan)
    values = first_values(fractions(second))
    counts = second.inside & np.isfinite(values)
    return np.where(counts, values, 0.0), counts
