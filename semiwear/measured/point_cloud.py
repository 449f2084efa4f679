"""Unordered point clouds of a flank, from scanners, resampled to a grid."""

from __future__ import annotations

import io
import os
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator
from scipy.ndimage import binary_opening

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.errors import MissingExtraError, SceneError
from semiwear.geometry.point_grid import PointGrid
from semiwear.measured.files import check_points
from semiwear.measured.nearest import feet, turned_by_most
from semiwear.measured.nominal import nominal_flank
from semiwear.measured.rigid import Displacement
from semiwear.plain_text import with_decimal_point
from semiwear.scene import Scene

_TEXT = (".xyz", ".txt", ".asc", ".csv")
_MESHES = (".ply", ".stl", ".obj", ".vtu", ".vtk")
_LEAST = 200  # points on the flank
_COVERED = 0.7  # least part of the flank's cells with a point
_CELLS = 12  # in each direction, for this test
_GAP = 3  # empty cells in each direction that make a gap
_LEAST_COUNTED = 0.5  # of the grid's points


def flank_from_points(
    scene: Scene,
    points: str | os.PathLike[str] | ArrayLike,
    body: str = "gear",
    *,
    shape: tuple[int, int] = (61, 61),
    within_mm: float = 0.5,
) -> PointGrid:
    """A grid of points on the surface of a cloud, for `register`, `measured_wear` and `calibrate`.

    Points within `within_mm` of the nominal flank, after the best rotation about the axis, belong to the flank; in a
    scan of the whole tooth this excludes the other flank, fillets and ends. Their deviations are averaged over cells
    around the points of the grid, and linear in between. In gaps of three by three cells (at the borders: three in a
    row) without a point, the grid has points that do not count. The grid has the position of the cloud; the datum is
    found later, by the function that uses the grid.

    Parameters
    ----------
    scene : Scene
    points : path or (n, 3) array [mm]
        In the body's own frame (z is its axis, x any direction across it). Text with three numbers a line (.xyz,
        .txt, .asc, .csv; decimal commas between spaces, semicolons or tabs), or the vertices of a .ply, .stl, .obj,
        .vtu or .vtk file (extra ``view``).
    body : str
        ``"pinion"`` or ``"gear"``.
    shape : (int, int)
        Rows from root to tip and columns along the tooth, as fine as the cloud allows. The averages blur the kink at
        the border of the worn zone: for a spur flank with 6 um of wear, k is 1 % low with 61 x 61, 3 % with 31 x 31,
        10 % with 21 x 21.
    within_mm : float
        Distance from the nominal flank up to which points count [mm]. Default 0.5.

    Returns
    -------
    PointGrid
        `points` (rows, columns, 3) [mm] in the body's own frame, and which of them count.

    Raises
    ------
    SceneError
        For too few points, points in other units or of another part, a cloud that does not cover the flank, or a grid
        finer than its points.
    MissingExtraError
        The file holds a mesh, and meshio is missing; install the extra ``view``.
    """
    if len(shape) != 2 or min(shape) < _CELLS:
        raise SceneError.of("shape", shape, f"two whole numbers, {_CELLS} or more", "61 x 61 is usual")
    cloud = _cloud(points)
    flank = nominal_flank(scene, body)
    check_points(flank, PointGrid(cloud[: len(cloud) // 8 * 8].reshape(8, -1, 3)), "points")
    moved = Displacement.about_axis(turned_by_most(flank, cloud))
    at = feet(flank, moved.undo(cloud))
    on = at.inside & (np.abs(at.deviation) < within_mm)
    low, high = flank.face_ends
    root, tip = flank.limits(at.face)
    fractions = np.stack([(at.profile - root) / (tip - root), (at.face - low) / (high - low)], axis=-1)[on]
    _require_cover(fractions)
    rows, columns = shape
    number = np.clip((fractions * (rows, columns)).astype(int), 0, np.array(shape) - 1) @ (columns, 1)
    cells, cell, count = np.unique(number, return_inverse=True, return_counts=True)
    means = [np.bincount(cell, weights) / count for weights in (*fractions.T, at.deviation[on])]
    centroids = np.column_stack(means[:2])
    u, v = np.meshgrid((np.arange(rows) + 0.5) / rows, (np.arange(columns) + 0.5) / columns, indexing="ij")
    deviation = LinearNDInterpolator(centroids, means[2])(u, v)
    beyond = np.isnan(deviation)  # outside the hull of the means
    deviation[beyond] = NearestNDInterpolator(centroids, means[2])(u[beyond], v[beyond])
    nominal, normals = flank.points(*flank.places(v, u))
    counts = _near_points(cells, shape)
    return PointGrid(moved.apply(nominal + deviation[..., None] * normals), counts=counts, attributes={"body": body})


def _near_points(cells: IntArray, shape: tuple[int, int]) -> BoolArray:
    """Grid points outside of the gaps of the cloud, which are blocks of `_GAP` by `_GAP` cells without a point.

    The cells at the borders are repeated outwards, so that `_GAP` empty cells in a row are a gap there.
    """
    empty = np.ones(shape, dtype=bool)
    empty.ravel()[cells] = False
    block = np.ones((_GAP, _GAP), dtype=bool)
    gaps = binary_opening(np.pad(empty, _GAP, mode="edge"), block)[_GAP:-_GAP, _GAP:-_GAP]
    counts = np.asarray(~gaps, dtype=bool)
    if counts.mean() < _LEAST_COUNTED:
        coarser = max(int(_CELLS), int(np.sqrt(0.5 * len(cells))))
        found = f"{shape[0]} x {shape[1]} cells, of which {len(cells)} hold a point"
        raise SceneError.of("shape", found, "a grid no finer than the cloud", f"shape = ({coarser}, {coarser})")
    return counts


def _require_cover(fractions: FloatArray) -> None:
    """Refuse clouds with too few points on the flank, or with points on a part of it only."""
    if len(fractions) < _LEAST:
        fix = "check the body, the frame (z is the axis), the units and within_mm"
        raise SceneError.of("points", f"{len(fractions)} points on the flank", f"{_LEAST} or more", fix)
    number = np.clip((fractions * _CELLS).astype(int), 0, _CELLS - 1) @ (_CELLS, 1)
    cover = np.unique(number).size / _CELLS**2
    if cover < _COVERED:
        found, allowed = f"points on {100 * cover:.0f} % of the flank", f"{100 * _COVERED:.0f} % or more"
        raise SceneError.of("points", found, allowed, "scan the whole flank, or raise within_mm if it is worn deeper")


def _cloud(points: str | os.PathLike[str] | ArrayLike) -> FloatArray:
    if not isinstance(points, str | os.PathLike):
        cloud = np.asarray(points, dtype=float)
        if cloud.ndim != 2 or cloud.shape[-1] != 3:
            raise SceneError.of("points", f"an array of shape {cloud.shape}", "points (n, 3) in mm, or a file")
        return _finite(cloud)
    file = Path(points)
    allowed = f"a file {', '.join((*_TEXT, *_MESHES))}"
    if not file.is_file() or file.suffix.casefold() not in (*_TEXT, *_MESHES):
        fix = "name it by its format" if file.is_file() else "no such file"
        raise SceneError.of("points", str(file), allowed, fix)
    if file.suffix.casefold() in _TEXT:
        return _finite(_of_text(file))
    try:
        import meshio
    except ImportError as error:
        raise MissingExtraError("meshio", "view", f"a cloud in {file.suffix}") from error
    try:
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            found = meshio.read(file)
    except (SystemExit, meshio.ReadError, ValueError, KeyError, IndexError, OSError) as error:  # meshio exits
        raise SceneError.of("points", str(file), allowed, "it is damaged: export it again") from error
    return _finite(np.asarray(found.points, dtype=float))


def _of_text(file: Path) -> FloatArray:
    rows = []
    for number, line in enumerate(file.read_text(encoding="utf-8", errors="replace").splitlines(), start=1):
        words = _words(line)
        if not words or line.lstrip().startswith("#"):
            continue
        try:
            rows.append([float(word) for word in words[:3]])
        except ValueError:
            if rows:
                found = f"{file}: line {number} is no point"
                raise SceneError.of("points", found, "three numbers a line", "correct the line") from None
            continue  # heading lines
        if len(rows[-1]) < 3:
            raise SceneError.of("points", f"{file}: line {number} has {len(words)} numbers", "three numbers a line")
    return np.array(rows).reshape(-1, 3)


def _words(line: str) -> list[str]:
    """Words between spaces, semicolons, tabs or commas; commas within three or more words are decimal commas."""
    plain = line.replace(";", " ")
    words = [with_decimal_point(word) for word in plain.split()]
    decimal = len(words) >= 3 and not any("," in word for word in words[:3])
    return words if decimal else plain.replace(",", " ").split()


def _finite(cloud: FloatArray) -> FloatArray:
    if len(cloud) < _LEAST:
        raise SceneError.of("points", f"{len(cloud)} points", f"{_LEAST} or more", "scan the flank more densely")
    if not np.all(np.isfinite(cloud)):
        raise SceneError.of("points", "points that are not finite", "finite coordinates", "remove them")
    return cloud
