"""Registration of a measured flank to the nominal one: datum, best fit, deviations.

The rotation of a measured tooth about its axis and its position along it are unknown. Deviations are measured along
the nominal normals, positive for material in excess (ISO 1328-1). The datum is one of

    "as_measured"   the points are used as they are;
    "best_fit"      least squares over the chosen motions (default: rotation about the axis and shift along it).

A best fit has one of three weightings: "all" points with equal weight, "unworn" only those of a given mask, or
"one_sided" (default) those at or above the fit (`semiwear.measured.robust`), since wear only removes material.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from semiwear.arrays import BoolArray, FloatArray
from semiwear.errors import SceneError
from semiwear.geometry.point_grid import PointGrid
from semiwear.measured.correlated import Estimate, estimate
from semiwear.measured.files import Measurement, check_points, check_side, read_measured
from semiwear.measured.nearest import Feet, feet, turned_by
from semiwear.measured.nominal import NominalFlank, nominal_flank
from semiwear.measured.quantities import labelled
from semiwear.measured.rigid import DATUM, TURNS, Displacement, Motions, determined, motions_of, require_motions
from semiwear.measured.robust import local_noise, one_sided_fit, weighted_fit
from semiwear.meshing.deviation_grid import DeviationGrid
from semiwear.meshing.flank_pair import ARCSEC
from semiwear.plain_text import one_of
from semiwear.scene import Scene

_PASSES = 60
_SETTLED = 1e-9  # mm, last displacement along any normal
_LEAST_INSIDE = 0.2  # of the points
_DATUMS = ("best_fit", "as_measured")
_FITS = ("one_sided", "all", "unworn")
_UM = 1e3


@dataclass(frozen=True)
class OnFlank:
    """A grid of points on a nominal flank; arrays are (profile, face).

    Attributes
    ----------
    flank : NominalFlank
    face, profile : array [mm]
        Flank coordinates of the points.
    inside : bool array
        Points that count: they lie on the nominal flank.
    """

    flank: NominalFlank
    face: FloatArray
    profile: FloatArray
    inside: BoolArray

    @property
    def places(self) -> tuple[FloatArray, FloatArray]:
        """Mean profile and face coordinate of the grid's rows and columns [mm]."""
        return grid_places(self.profile, self.face)

    def on_grid(self, values: FloatArray) -> FloatArray:
        """Values (points that count, ...) on the grid, (profile, face, ...); 0 elsewhere."""
        out = np.zeros((*self.inside.shape, *values.shape[1:]))
        out[self.inside] = values
        return out

    def where(self) -> dict[str, object]:
        """Positions of the points, as quantities of a dataset."""
        height, radius = self.flank.place(self.face, self.profile)
        return {
            "flank_profile": self.profile,
            "flank_face": self.face,
            "flank_height": height,
            "flank_radius": radius,
            "inside": self.inside,
            "points": int(self.inside.sum()),
        }


@dataclass(frozen=True)
class Registration(OnFlank):
    """A measured flank on the nominal one.

    Attributes
    ----------
    deviation : array [mm]
        Positive for material in excess; 0 where not inside.
    weights : array
        Weights of the fit; as `inside` without a fit.
    amounts : mapping of str to float [rad, mm]
        Fitted motions.
    errors : mapping of str to float [rad, mm]
        Their standard uncertainties.
    held : tuple of str
        Requested motions that this flank does not determine.
    noise : Estimate or None
    """

    deviation: FloatArray
    weights: FloatArray
    amounts: dict[str, float]
    errors: dict[str, float]
    held: tuple[str, ...]
    noise: Estimate | None

    def to_dataset(self, attrs: dict[str, str]) -> xr.Dataset:
        """Deviations in um, the datum with its uncertainties, and the root mean square residual."""
        values = {"deviation": _UM * self.deviation, **self.where(), "weight": self.weights}
        for name, amount in self.amounts.items():
            factor = ARCSEC if name in TURNS else 1.0
            values[name] = factor * amount
            if name in self.errors:
                values[f"{name}_uncertainty"] = factor * self.errors[name]
        total = float(self.weights.sum())
        values["residual_rms"] = _UM * float(np.sqrt(np.sum(self.weights * self.deviation**2) / total))
        if self.noise is not None:
            found = self.noise.correlation
            values["correlation_share"] = found.share
            values["correlation_length_profile"] = found.profile_length
            values["correlation_length_face"] = found.face_length
        return labelled(values, {**attrs, "held": ", ".join(self.held)}, "measured flank on the nominal flank")


def grid_places(profile: FloatArray, face: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean profile coordinate of a grid's rows and mean face coordinate of its columns [mm]."""
    rows, columns = profile.mean(axis=1), face.mean(axis=0)
    if np.ptp(columns) < np.ptp(face.mean(axis=1)):  # rows and columns were exchanged in the measurement
        rows, columns = face.mean(axis=1), profile.mean(axis=0)
    return rows, columns


def register(
    scene: Scene,
    measured: str | os.PathLike[str] | ArrayLike | Measurement,
    body: str = "gear",
    *,
    datum: str = "best_fit",
    fit: str = "one_sided",
    unworn: ArrayLike | None = None,
    motions: Sequence[str] = DATUM,
) -> xr.Dataset:
    """Deviations of a measured flank from the nominal one.

    Parameters
    ----------
    scene : Scene
    measured : path, (P, F, 3) array [mm], PointGrid or DeviationGrid
        Points in the body's own frame (z is its axis), or deviations, which are taken as registered.
    body : str
        ``"pinion"`` or ``"gear"``.
    datum : str
        ``"best_fit"`` (default) or ``"as_measured"``.
    fit : str
        Points of the best fit: ``"one_sided"`` (default), ``"all"`` or ``"unworn"``, those of `unworn`.
    unworn : (P, F) bool array, optional
        Points that have not worn.
    motions : sequence of str
        Motions of the best fit: of ``"rotation"``, ``"axial"`` (both by default), ``"radial"``, ``"tangential"``,
        ``"tilt_radial"``, ``"tilt_tangential"``. A motion that the flank does not determine (a spur flank: along its
        axis), or not separately (a helical flank: along its axis as well as about it), is not fitted and listed in
        the attribute `held`.

    Returns
    -------
    Dataset
        `deviation` [um] over (profile, face), positive for material in excess; positions of the points
        (`flank_profile`, `flank_face`, `flank_height`, `flank_radius`, `inside`) and their `weight` in the fit; the
        fitted motions, such as `rotation` [arcsec] and `axial` [mm], with standard uncertainties (``_uncertainty``)
        that account for the correlation of neighbours (`semiwear.measured.correlated`); `residual_rms` [um].

    Raises
    ------
    SceneError
        For points that are not finite, too few, in other units, of another flank or outside it.

    Examples
    --------
    >>> import numpy as np
    >>> import semiwear as sw
    >>> import tempfile, pathlib
    >>> scene = sw.load_scene("spur_fzg_c")
    >>> path = pathlib.Path(tempfile.mkdtemp(), "gear.nc")
    >>> sw.export_flank(scene, "gear", path, points=(21, 9))
    >>> deviations = sw.register(scene, path)
    >>> bool(np.abs(deviations.deviation).max() < 0.1)  # um: it is the nominal flank
    True
    """
    flank = nominal_flank(scene, body)
    found = registered(flank, read_measured(measured), datum=datum, fit=fit, unworn=unworn, motions=motions)
    attrs = {"body": body, "datum": datum, "fit": fit if datum == "best_fit" else "none", "scene": scene.title}
    return found.to_dataset(attrs)


def registered(
    flank: NominalFlank,
    measured: Measurement,
    *,
    datum: str = "best_fit",
    fit: str = "one_sided",
    unworn: ArrayLike | None = None,
    motions: Sequence[str] = DATUM,
    field: str = "measured",
) -> Registration:
    """As `register`, with a nominal flank."""
    for name, value, allowed in (("datum", datum, _DATUMS), ("fit", fit, _FITS)):
        if value not in allowed:
            raise SceneError.of(name, value, one_of(allowed))
    names = require_motions(motions, "motions")
    if isinstance(measured, DeviationGrid):
        return _of_deviations(flank, measured, field)
    check_points(flank, measured, field)
    mask = _mask(unworn, fit, measured.points.shape[:2])
    return _of_points(flank, measured, motions_of(flank, names if datum == "best_fit" else ()), fit, mask, field)


def _mask(unworn: ArrayLike | None, fit: str, shape: tuple[int, ...]) -> BoolArray:
    if fit != "unworn":
        return np.ones(shape, dtype=bool)
    if unworn is None:
        raise SceneError.of("unworn", None, "a mask over (profile, face)", 'give it, or fit = "one_sided"')
    mask = np.asarray(unworn, dtype=bool)
    if mask.shape != shape:
        raise SceneError.of("unworn", f"a mask of shape {mask.shape}", f"(profile, face) = {shape}")
    return mask


def _of_deviations(flank: NominalFlank, grid: DeviationGrid, field: str) -> Registration:
    """Registration of a grid of deviations, at the coordinates that it gives."""
    low, high = flank.face_ends
    face = low + (grid.face * (high - low) if grid.face_unit == "1" else grid.face)
    face = np.broadcast_to(face, grid.deviation.shape)
    root, tip = flank.limits(face)
    along = grid.profile[:, None]
    profile = root + (along * (tip - root) if grid.profile_unit == "1" else along)
    inside = (profile <= tip + 1e-3) & (face <= high + 1e-3) & (profile >= root - 1e-3) & (face >= low - 1e-3)
    _require_inside(inside, field)
    deviation = np.where(inside, grid.deviation, 0.0)
    return Registration(flank, face, profile, inside, deviation, inside.astype(float), {}, {}, (), None)


def _of_points(
    flank: NominalFlank, grid: PointGrid, motions: Motions, fit: str, mask: BoolArray, field: str
) -> Registration:
    points = grid.points
    moved = Displacement.none()
    if "rotation" in motions.names:
        moved = Displacement.about_axis(turned_by(flank, points))
    at: Feet | None = None
    fitted = np.zeros(len(motions.names), dtype=bool)
    weights = mask.astype(float)
    for k in range(_PASSES):
        at = _measured_feet(flank, grid, moved, at)
        if k == 0:
            _require_inside(at.inside, field)
            check_side(at.normals, moved.undo(points), at.inside, field)
        counts = (mask & at.inside).ravel()
        modes = motions.modes(at.points, at.normals).reshape(counts.size, -1)
        fitted = determined(modes[counts])
        if not fitted.any():
            weights = counts.astype(float).reshape(mask.shape)
            break
        if counts.sum() <= 2 * fitted.sum():
            raise SceneError.of(field, f"{int(counts.sum())} points to fit", "more", "choose other unworn points")
        amounts = np.zeros(fitted.size)
        noise = local_noise(at.deviation, at.inside)
        amounts[fitted], flat = _fitted(at.deviation.ravel(), modes[:, fitted], counts, fit, noise)
        weights = flat.reshape(mask.shape)
        moved = moved.after(motions.displacement(amounts))
        if np.abs(modes[counts] @ amounts).max() < _SETTLED:
            break
    at = _measured_feet(flank, grid, moved, at)
    _require_inside(at.inside, field)
    names = [name for name, is_fitted in zip(motions.names, fitted, strict=True) if is_fitted]
    all_amounts = motions.amounts(moved)
    estimated = None
    errors: dict[str, float] = {}
    weights = np.where(at.inside, weights, 0.0)
    if names:
        fitted_modes = motions.modes(at.points, at.normals)[..., fitted]
        estimated = estimate(at.deviation, fitted_modes, weights, *grid_places(at.profile, at.face))
        errors = dict(zip(names, map(float, estimated.errors), strict=True))
    held = tuple(name for name in motions.names if name not in names)
    face, profile = _held_to_flank(flank, at)
    deviation = np.where(at.inside, at.deviation, 0.0)
    fitted_amounts = {name: all_amounts[name] for name in names}
    return Registration(flank, face, profile, at.inside, deviation, weights, fitted_amounts, errors, held, estimated)


def _measured_feet(flank: NominalFlank, grid: PointGrid, moved: Displacement, start: Feet | None) -> Feet:
    """Feet of a grid's points; points that were not measured are not inside."""
    at = feet(flank, moved.undo(grid.points), start)
    return at if grid.counts is None else replace(at, inside=at.inside & grid.counts)


def _fitted(
    deviation: FloatArray, modes: FloatArray, counts: BoolArray, fit: str, noise: float
) -> tuple[FloatArray, FloatArray]:
    """Amounts of the motions, and the weights of the points."""
    if fit == "one_sided":
        return one_sided_fit(deviation, modes, counts, noise)
    weights = counts.astype(float)
    return weighted_fit(modes, deviation, weights), weights


def _held_to_flank(flank: NominalFlank, at: Feet) -> tuple[FloatArray, FloatArray]:
    """Flank coordinates of feet, limited to the ends of the flank [mm]."""
    low, high = flank.face_ends
    face = np.clip(at.face, low, high)
    root, tip = flank.limits(face)
    return face, np.clip(at.profile, root, tip)


def _require_inside(inside: BoolArray, field: str) -> None:
    if inside.sum() < max(16, _LEAST_INSIDE * inside.size):
        raise SceneError.of(
            field,
            f"{int(inside.sum())} of {inside.size} points on the nominal flank",
            "points that lie on it",
            "check the body, the flank, the axial position (z) and the units",
        )
