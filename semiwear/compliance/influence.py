"""Tooth compliance and root stress from a file of influence data, in place of finite prisms.

The data (from `fem_reference.tooth_influence` or any other source) hold, for unit loads on a grid of heights
and face stations of a flank, the deflection of the middle surface on the same grid of the tooth and its neighbours
and the tangential fillet stress. Between grid points both are interpolated by local cubics, for load and observer
in the same way, so that the compliance stays a symmetric low-rank product.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import make_interp_spline

from semiwear.arrays import FloatArray, IntArray
from semiwear.compliance.cubics import cubic_weights
from semiwear.compliance.root import ROOT_FROM, ROOT_POINTS, add_later, loads_by_height
from semiwear.compliance.tooth import LinePlaces
from semiwear.errors import SceneError
from semiwear.sources import MOST_VALUES, oversized, read_dataset

if TYPE_CHECKING:
    from xarray import Dataset

_FIELD = "numerics.tooth_compliance"
_VARIABLES = {
    "load_face": ("body", "station"),
    "depth": ("body", "height", "station"),
    "fillet_arc": ("body", "fillet_point"),
    "deflection": ("body", "tooth_offset", "observer_height", "observer_station", "height", "station"),
    "root_stress": ("body", "tooth_offset", "fillet_point", "observer_station", "height", "station"),
}
_LEAST_POINTS = 2  # heights and stations
_UNRELIABLE = 0.2  # of the fillet's length, where the data may contain the mesh-dependent stress of a load beside it
_END_TOLERANCE = 1e-3  # of the face width: greatest deviation of the grid's ends from the tooth's


@dataclass(frozen=True)
class InfluenceData:
    """Influence data of one body.

    Attributes
    ----------
    heights : (H,) array
        Heights of the grid as shares of the flank's profile, from its lower end to its tip.
    faces : (S,) array [mm]
        Face stations of the grid from end to end of the tooth.
    depth : (H, S) array [mm]
        Distance from the flank to the middle surface.
    deflection : (offset, H, S, H, S) array [mm/N]
        [tooth offset, observer, load]; the middle offset is the loaded tooth, +1 the neighbour its flank faces.
    stress : (offset, A, S, H, S) array [MPa/N]
        [tooth offset, point of the root, station, load].
    ahead : int
        As in `ToothBody`.
    youngs_modulus [MPa], poissons_ratio [1] : float
    """

    heights: FloatArray
    faces: FloatArray
    depth: FloatArray
    deflection: FloatArray
    stress: FloatArray
    ahead: int
    youngs_modulus: float
    poissons_ratio: float


def read_influence(path: str | Path) -> Dataset:
    """Read a file of influence data.

    Raises
    ------
    SceneError
        With the fault of the file and its remedy.
    """
    allowed = '"prism", "rigid" or a file of influence data'
    make = "make one with fem_reference.tooth_influence(scene).to_netcdf(file)"
    if not Path(path).is_file():
        raise SceneError.of(_FIELD, str(path), allowed, f"no such file; {make}")
    if found := oversized(Path(path)):
        raise SceneError.of(_FIELD, f"{path}: {found}", f"at most {MOST_VALUES:.0e} values", make)
    try:
        data = read_dataset(Path(path))
    except (OSError, ValueError) as error:
        raise SceneError.of(_FIELD, str(path), allowed, f"it cannot be read as netCDF ({error}); {make}") from error
    for name, dims in _VARIABLES.items():
        if name not in data or data[name].dims != dims:
            raise SceneError.of(_FIELD, str(path), f"a variable {name} over {dims}", make)
        if not np.all(np.isfinite(data[name].values)):
            raise SceneError.of(_FIELD, str(path), f"finite numbers in {name}", make)
    if min(data.sizes["height"], data.sizes["station"]) < _LEAST_POINTS or data.sizes["tooth_offset"] % 2 == 0:
        allowed = "2 heights and 2 stations at least, and an odd number of teeth"
        raise SceneError.of(_FIELD, str(path), allowed, make)
    return data


def body_influence(
    data: Dataset, body: int, limits: tuple[float, float], ahead: int, youngs_modulus: float, poissons_ratio: float
) -> InfluenceData:
    """Influence data of a body (0 the pinion, 1 the gear) whose tooth runs between two face coordinates [mm]."""
    own = data.isel(body=body)
    arc = own["fillet_arc"].values
    share = (arc - arc.min()) / np.ptp(arc)
    kept = np.flatnonzero(share >= _UNRELIABLE)
    root = np.linspace(ROOT_FROM, 1.0, ROOT_POINTS)
    along = make_interp_spline(share[kept], np.eye(len(kept)), k=min(3, len(kept) - 1))(root)
    heights = data.sizes["height"]
    profile = own["load_profile"].values if "load_profile" in data else np.arange(heights)
    share_up = (profile - profile[0]) / (profile[-1] - profile[0])
    # the stress by a load at the very end of the flank depends on the mesh: extrapolated from the loads above
    sound = slice(1, None) if heights > _LEAST_POINTS else slice(None)
    lifted = make_interp_spline(share_up[sound], np.eye(heights)[sound], k=max(min(2, heights - 2), 1))(share_up)
    faces = own["load_face"].values.astype(float)
    if np.abs(faces[[0, -1]] - limits).max() > _END_TOLERANCE * (limits[1] - limits[0]):
        found = f"teeth from {faces[0]:g} to {faces[-1]:g} mm"
        raise SceneError.of(_FIELD, found, f"{limits[0]:g} to {limits[1]:g} mm", "these are data of other gears")
    return InfluenceData(
        heights=share_up,
        faces=faces,
        depth=own["depth"].values.astype(float),
        deflection=np.ascontiguousarray(own["deflection"].values, dtype=float),
        stress=np.einsum("ra,gh,oakhs->orkgs", along, lifted, own["root_stress"].values[:, kept], optimize=True),
        ahead=ahead,
        youngs_modulus=youngs_modulus,
        poissons_ratio=poissons_ratio,
    )


@dataclass(frozen=True)
class InfluenceOnLines:
    """One body's compliance, prepared for the contact lines of all roll positions.

    Attributes
    ----------
    body : InfluenceData
    place, place_slope : (roll, face) arrays
        Height of each contact point as a share of the flank there, and its derivative by the driven profile.
    station : (roll, face, S) array
        Weights of the face stations.
    weights, slopes : (roll, face, H S) arrays
        Interpolation from the grid to each contact point, and its derivative by the driven profile [1/mm].
    depth : (roll, face) array [mm]
        Distance from the flank to the middle surface.
    """

    body: InfluenceData
    place: FloatArray
    place_slope: FloatArray
    station: FloatArray
    weights: FloatArray
    slopes: FloatArray
    depth: FloatArray

    @classmethod
    def of(cls, body: InfluenceData, places: LinePlaces, root: FloatArray, tip: FloatArray) -> InfluenceOnLines:
        """Prepare a body for contact lines at `places`, between the flank's ends `root` and `tip` there [mm]."""
        heights, stations = body.depth.shape
        per_mm = 1.0 / (tip - root)
        place, place_slope = (places.profile - root) * per_mm, per_mm * places.slope
        height, slope = cubic_weights(place, body.heights)
        station, _ = cubic_weights(places.face, body.faces)
        slope = slope * place_slope[..., None]
        shape = (*places.profile.shape, heights * stations)
        weights = (height[..., :, None] * station[..., None, :]).reshape(shape)
        slopes = (slope[..., :, None] * station[..., None, :]).reshape(shape)
        return cls(body, place, place_slope, station, weights, slopes, weights @ body.depth.ravel())

    def add_compliance(
        self, rolls: IntArray, faces: IntArray, pairs: IntArray, matrix: FloatArray, slope: FloatArray
    ) -> None:
        """As in `BodyOnLines`."""
        weights, slopes = self.weights[rolls, faces], self.slopes[rolls, faces]
        points = weights.shape[1]
        reach = self.body.deflection.shape[0] // 2
        for observer in np.unique(pairs):
            mine = pairs == observer
            for loaded in np.unique(pairs):
                offset = self.body.ahead * (int(observer) - int(loaded))
                if abs(offset) > reach:
                    continue
                theirs = pairs == loaded
                seen = self.body.deflection[reach + offset].reshape(points, points) @ weights[theirs].T
                block = np.ix_(mine, theirs)
                matrix[block] += weights[mine] @ seen
                slope[block] += slopes[mine] @ seen

    def root_stress(
        self, force: FloatArray, per_cycle: int, moved: FloatArray | None = None, stations: int = 33
    ) -> FloatArray:
        """As `BodyOnLines.root_stress`."""
        offsets, fillet, count = self.body.stress.shape[:3]
        if moved is None:
            modal = np.einsum("ki,kig->kg", force, self.weights)
        else:
            loads = loads_by_height(force, moved, self.place, self.place_slope, self.body.heights)
            modal = np.einsum("kih,kis->khs", loads, self.station).reshape(len(loads), -1)
        table = self.body.stress.reshape(offsets, fillet * count, -1)
        stress = np.zeros((len(modal), fillet * count))
        reach = offsets // 2
        for offset in range(-reach, reach + 1):
            # the observer's tooth is `offset` from the loaded one: its pair is ahead * offset rolls further on
            shift = self.body.ahead * offset * per_cycle
            add_later(stress, modal @ table[reach + offset].T, shift)
        faces = self.body.faces
        along, _ = cubic_weights(np.linspace(faces[0], faces[-1], stations), faces)
        return np.asarray(np.maximum((stress.reshape(-1, fillet, count) @ along.T).max(axis=(1, 2)), 0.0))
