"""Stress below a contact: a pressure known cell by cell on an elastic half-space, without friction.

Love's rectangle solution is convolved with the pressure, one depth at a time, by a Fourier transform padded so
that nothing wraps round (Liu, Wang and Liu, Wear 243, 2000, 101-111). Tension is positive, z points into the body.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from math import ceil, log, sqrt

import numpy as np
from numpy.typing import ArrayLike
from scipy.fft import irfft2, next_fast_len, rfft2
from scipy.optimize import minimize_scalar

from semiwear.arrays import FloatArray
from semiwear.closed_forms.love_stress import COMPONENTS, point_stress, rectangle_stress
from semiwear.errors import Problem

__all__ = [
    "COMPONENTS",
    "GreatestSubsurfaceStress",
    "default_depths",
    "greatest_subsurface_stress",
    "maximum_shear",
    "subsurface_stress",
    "von_mises",
]

Place = tuple[int, int]

# sign of each component of `COMPONENTS` on the other side of the loaded cell, in x and in y
_MIRROR_X = np.array([1.0, 1.0, 1.0, -1.0, -1.0, 1.0])[:, None, None]
_MIRROR_Y = np.array([1.0, 1.0, 1.0, -1.0, 1.0, -1.0])[:, None, None]

_DEPTH_RATIO = 1.35  # of neighbouring default depths; the shear stress below a Hertz contact is that flat
_DEPTH_TOLERANCE = 1e-4  # of the bracket
_TURNS = 5  # of depth and place; the first plane's best cell is already near
_EQUAL = 1e-6  # a neighbour that is greater by less is no reason to move
_RIVAL = 0.9  # depths at which the stress peaks above this fraction of the greatest are refined as well


@dataclass(frozen=True)
class GreatestSubsurfaceStress:
    """Greatest equivalent stresses below a contact.

    Attributes
    ----------
    von_mises : float [MPa]
    von_mises_depth : float [mm]
    von_mises_place : (ix, iy)
        Cell below whose middle it occurs; the middle lies at ((ix + 0.5) dx, (iy + 0.5) dy).
    shear : float [MPa]
        Half the difference of the outer principal stresses (Tresca).
    shear_depth : float [mm]
    shear_place : (ix, iy)
    """

    von_mises: float
    von_mises_depth: float
    von_mises_place: Place
    shear: float
    shear_depth: float
    shear_place: Place


def subsurface_stress(
    pressure: ArrayLike, *, cell: tuple[float, float], poissons_ratio: float, depths: ArrayLike
) -> FloatArray:
    """Stress tensor below the middles of all cells, exact for a pressure constant over each cell.

    Parameters
    ----------
    pressure : (nx, ny) array [MPa]
    cell : (dx, dy) [mm]
    poissons_ratio : float
        0 to 0.5.
    depths : (nz,) array [mm]
        Positive.

    Returns
    -------
    (6, nz, nx, ny) array [MPa]
        In the order of `COMPONENTS`: xx, yy, zz, xy, xz, yz.

    Raises
    ------
    ValueError
        An argument is out of its range; the message names it.

    References
    ----------
    Love (1929), *The stress produced in a semi-infinite solid by pressure on part of the boundary*.
    """
    pressure = _checked_pressure(pressure)
    cell = _checked_cell(cell)
    poissons_ratio = _checked_poissons_ratio(poissons_ratio)
    depths = _checked_depths(depths)
    stress = np.empty((6, depths.size, *pressure.shape))
    for k, plane in enumerate(_planes(pressure, cell, poissons_ratio, depths)):
        stress[:, k] = plane
    return stress


def greatest_subsurface_stress(
    pressure: ArrayLike,
    *,
    cell: tuple[float, float],
    poissons_ratio: float,
    depths: ArrayLike | None = None,
) -> GreatestSubsurfaceStress:
    """Greatest von Mises and Tresca stress below a contact, with their depths and places.

    All planes are searched below the rectangle that holds the loaded cells, and the best depths are then refined
    below their own cells. Without a load all is zero.

    Parameters
    ----------
    pressure : (nx, ny) array [MPa]
    cell : (dx, dy) [mm]
    poissons_ratio : float
        0 to 0.5.
    depths : (nz,) array [mm], optional
        Depths of the first search; the answer lies between the least and the greatest. Default: `default_depths`.

    Raises
    ------
    ValueError
        An argument is out of its range; the message names it.
    """
    pressure = _checked_pressure(pressure)
    cell = _checked_cell(cell)
    poissons_ratio = _checked_poissons_ratio(poissons_ratio)
    if depths is not None:
        depths = np.unique(_checked_depths(depths))
    loaded_x, loaded_y = np.flatnonzero(pressure.any(axis=1)), np.flatnonzero(pressure.any(axis=0))
    if loaded_x.size == 0:
        return GreatestSubsurfaceStress(0.0, 0.0, (0, 0), 0.0, 0.0, (0, 0))
    corner = (int(loaded_x[0]), int(loaded_y[0]))
    pressure = pressure[corner[0] : loaded_x[-1] + 1, corner[1] : loaded_y[-1] + 1]
    if depths is None:
        depths = default_depths(pressure, cell=cell)

    measures = (von_mises, maximum_shear)
    peaks = np.empty((2, depths.size))
    places = np.empty((2, depths.size), int)
    for k, plane in enumerate(_planes(pressure, cell, poissons_ratio, depths)):
        for m, measure in enumerate(measures):
            field = measure(plane)
            places[m, k] = field.argmax()
            peaks[m, k] = field.flat[places[m, k]]

    found = []
    for m, measure in enumerate(measures):

        def at(depth: float, place: Place, measure: Callable[[FloatArray], FloatArray] = measure) -> float:
            stress = point_stress(pressure, place, cell=cell, depth=depth, poissons_ratio=poissons_ratio)
            return float(measure(stress))

        value, depth, place = max(
            _refined(at, divmod(int(places[m, k]), pressure.shape[1]), depths[max(k - 1, 0) : k + 2], pressure.shape)
            for k in _peaks(peaks[m])
        )
        found.append((value, depth, (place[0] + corner[0], place[1] + corner[1])))
    return GreatestSubsurfaceStress(*found[0], *found[1])


def default_depths(pressure: ArrayLike, *, cell: tuple[float, float]) -> FloatArray:
    """Depths [mm] in a constant ratio that hold the greatest stress below the narrowest part and below the whole.

    They run from 0.02 of the half-width of the loaded stretches (less where a quarter of a cell is less, down to
    0.002 of it: one cell may carry a spike) to 3 minor half-widths of the patch.

    Parameters
    ----------
    pressure : (nx, ny) array [MPa]
        Not all zero.
    cell : (dx, dy) [mm]
    """
    weight = np.abs(_checked_pressure(pressure))
    cell = _checked_cell(cell)
    if not weight.any():
        _refuse("pressure", "no load", "a pressure with a loaded cell", "choose the depths yourself")
    narrow = 0.5 * min(_mean_stretch(weight) * cell[0], _mean_stretch(weight.T) * cell[1])
    whole = max(narrow, _minor_half_width(weight, cell))
    low, high = min(max(0.25 * min(cell), 0.002 * narrow), 0.02 * narrow), 3.0 * whole
    return np.geomspace(low, high, ceil(log(high / low) / log(_DEPTH_RATIO)) + 1)


def von_mises(stress: FloatArray) -> FloatArray:
    """Von Mises stress [MPa] of a (6, ...) stress [MPa] in the order of `COMPONENTS`."""
    return np.sqrt(3.0 * _second_invariant(stress))


def maximum_shear(stress: FloatArray) -> FloatArray:
    """Greatest shear stress [MPa], half of Tresca's, of a (6, ...) stress [MPa] in the order of `COMPONENTS`.

    With Lode's angle t, cos 3t = (3 sqrt 3/2) J3/J2^(3/2), it is sqrt(J2) sin(t + pi/3).
    """
    mean = (stress[0] + stress[1] + stress[2]) / 3.0
    xx, yy, zz = stress[0] - mean, stress[1] - mean, stress[2] - mean
    xy, xz, yz = stress[3:]
    j2 = _second_invariant(stress)
    j3 = xx * (yy * zz - yz**2) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    root = np.sqrt(j2)
    cosine = 1.5 * sqrt(3.0) * j3 / np.maximum(root**3, np.finfo(float).tiny)
    return np.asarray(root * np.sin((np.arccos(np.clip(cosine, -1.0, 1.0)) + np.pi) / 3.0))


def _second_invariant(stress: FloatArray) -> FloatArray:
    """J2 [MPa^2] from differences of the normal stresses, which hydrostatic pressure does not disturb."""
    xx, yy, zz, xy, xz, yz = stress
    return np.asarray(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 6.0 + xy**2 + xz**2 + yz**2)


def _planes(
    pressure: FloatArray, cell: tuple[float, float], poissons_ratio: float, depths: FloatArray
) -> Iterator[FloatArray]:
    """Stress (6, nx, ny) [MPa] at one depth after the other."""
    nx, ny = pressure.shape
    # twice the grid less one holds every distance between two cells, so that none wraps round
    size = (next_fast_len(2 * nx - 1, real=True), next_fast_len(2 * ny - 1, real=True))
    spectrum = rfft2(pressure, size)
    kernel = np.zeros((6, *size))
    for depth in depths:
        quarter = rectangle_stress(nx, ny, cell=cell, depth=float(depth), poissons_ratio=poissons_ratio)
        kernel[:, :nx, :ny] = quarter
        kernel[:, size[0] - nx + 1 :, :ny] = _MIRROR_X * quarter[:, :0:-1]
        kernel[:, :, size[1] - ny + 1 :] = _MIRROR_Y * kernel[:, :, ny - 1 : 0 : -1]
        yield irfft2(rfft2(kernel) * spectrum, size)[:, :nx, :ny]


def _peaks(profile: FloatArray) -> list[int]:
    """Places of the local maxima of a profile that rival its greatest value."""
    padded = np.concatenate([[-np.inf], profile, [-np.inf]])
    local = (profile >= padded[:-2]) & (profile > padded[2:])
    return [int(k) for k in np.flatnonzero(local & (profile >= _RIVAL * profile.max()))]


def _refined(
    at: Callable[[float, Place], float], place: Place, depths: FloatArray, shape: tuple[int, ...]
) -> tuple[float, float, Place]:
    """Greatest value, depth and place between some depths, by turns in depth and among the neighbouring cells."""
    value, depth = max((at(float(z), place), float(z)) for z in depths)
    bracket = float(depths[0]), float(depths[-1])
    for _ in range(_TURNS):
        if bracket[1] > bracket[0]:
            best = minimize_scalar(
                lambda z, place=place: -at(z, place),
                bounds=bracket,
                method="bounded",
                options={"xatol": _DEPTH_TOLERANCE * (bracket[1] - bracket[0])},
            )
            # the search never tries the ends of its bracket
            if -best.fun > value:
                value, depth = -float(best.fun), float(best.x)
        around = product(*(range(max(i - 1, 0), min(i + 2, count)) for i, count in zip(place, shape, strict=True)))
        rival, neighbour = max((at(depth, (i, j)), (i, j)) for i, j in around)
        if rival <= value * (1.0 + _EQUAL):
            break
        value, place = rival, neighbour
    return value, depth, place


def _mean_stretch(weight: FloatArray) -> float:
    """Mean number of loaded cells in a row along the first axis, weighted with the load."""
    row = np.pad(weight, ((0, 1), (0, 0))).T.ravel()  # an empty cell parts one line from the next
    loaded = row > 0.0
    stretch = np.cumsum(~loaded)[loaded]
    return float(row[loaded] @ np.bincount(stretch)[stretch] / row.sum())


def _minor_half_width(weight: FloatArray, cell: tuple[float, float]) -> float:
    """Minor half-axis [mm] of the Hertz ellipse with the second moments of a load; there they are a^2/5 and b^2/5."""
    middles = [(np.arange(count) + 0.5) * width for count, width in zip(weight.shape, cell, strict=True)]
    fraction = weight / weight.sum()
    along_x, along_y = fraction.sum(axis=1), fraction.sum(axis=0)
    x, y = middles[0] - along_x @ middles[0], middles[1] - along_y @ middles[1]
    # plus each cell's own moment
    xx, yy = along_x @ x**2 + cell[0] ** 2 / 12.0, along_y @ y**2 + cell[1] ** 2 / 12.0
    xy = x @ fraction @ y
    return sqrt(5.0 * float(np.linalg.eigvalsh([[xx, xy], [xy, yy]])[0]))


def _refuse(field: str, value: object, allowed: str, fix: str) -> None:
    raise ValueError(str(Problem(field, value, allowed, fix)))


def _checked_pressure(pressure: ArrayLike) -> FloatArray:
    values = np.asarray(pressure, float)
    if values.ndim != 2 or values.size == 0:
        _refuse("pressure", f"shape {values.shape}", "a (nx, ny) array [MPa]", "pass one value for each cell")
    if not np.isfinite(values).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(values))[0])
        _refuse("pressure", f"{values[where]} at {where}", "finite values [MPa]", "set cells without contact to 0")
    return values


def _checked_cell(cell: tuple[float, float]) -> tuple[float, float]:
    sides = np.asarray(cell, float)
    if sides.shape != (2,) or not np.isfinite(sides).all() or sides.min() <= 0.0:
        _refuse("cell", cell, "two positive lengths (dx, dy) [mm]", "pass the sides of one cell in mm")
    return float(sides[0]), float(sides[1])


def _checked_poissons_ratio(poissons_ratio: float) -> float:
    if not 0.0 <= poissons_ratio <= 0.5:
        _refuse("poissons_ratio", poissons_ratio, "0 to 0.5", "use the material's own; 0.3 for steel")
    return float(poissons_ratio)


def _checked_depths(depths: ArrayLike) -> FloatArray:
    values = np.atleast_1d(np.asarray(depths, float))
    if values.ndim != 1 or values.size == 0:
        _refuse("depths", f"shape {values.shape}", "a (nz,) array [mm]", "pass one depth at least")
    bad = values[~(np.isfinite(values) & (values > 0.0))]
    if bad.size:
        _refuse("depths", float(bad[0]), "positive depths [mm]", "z points into the body; near 0 for the surface")
    return values
