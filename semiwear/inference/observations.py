"""Measurements for an inference, and their predicted values from a run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import BoolArray, FloatArray
from semiwear.errors import Collected, Problem, SceneError
from semiwear.inference.evidence import Evidence, FlankNoise, known_noise, unknown_noise
from semiwear.measured.comparison import grid_of
from semiwear.measured.fit import datum_modes
from semiwear.measured.nominal import nominal_flank
from semiwear.measured.predicted import FlankReading
from semiwear.measured.rigid import DATUM, require_motions
from semiwear.measured.worn import Measured as MeasuredFlank
from semiwear.measured.worn import as_wear
from semiwear.meshing.flank_pair import BODIES
from semiwear.optimise.quantity import quantity_of, unmet_needs
from semiwear.scene import Scene
from semiwear.scene.values import Unreadable, number, numbers, shown
from semiwear.sweep.measure import Measured

_UM = 1e3
_LEAST_GRID = 5  # rows and columns of a flank's grid
_WEAR = "/flank/wear_depth"
_CURVE = "/mesh_cycle/transmission_error_loaded"
_UNCERTAINTIES = ("error", "error_um", "uncertainty_arcsec")
_FINE = 401  # points along a profile, to find a height


@dataclass(frozen=True)
class WornFlank:
    """A measured worn flank.

    Attributes
    ----------
    measured : measurement
        As for `calibrate`: a file or array of points, deviations, or a dataset of `register` or `measured_wear`.
    meshes : float, optional
        Engagements of one gear tooth that it has run. Default: those at which the scene's run ends, if it ends at
        meshes or hours.
    body : str
        ``"pinion"`` or ``"gear"`` (default), a body that wears in the scene.
    before : measurement, optional
        The same flank before it was worn. Default: the nominal one.
    datum : sequence of str
        Motions of the measured tooth that its measurement leaves open: they are treated as unknown, and integrated
        over. Of ``"rotation"`` and ``"axial"`` (about the body's axis and along it; the default), ``"radial"``,
        ``"tangential"``, ``"tilt_radial"`` and ``"tilt_tangential"``, as of `calibrate`; () for none.
    """

    measured: MeasuredFlank
    meshes: float | None = None
    body: str = "gear"
    before: MeasuredFlank | None = None
    datum: Sequence[str] = DATUM


@dataclass(frozen=True)
class WearAtPoints:
    """Wear depth measured at a few points of a flank, with an error each.

    Attributes
    ----------
    face_mm, height_mm : array_like
        Coordinate along the face, as `face` of a result, and height above the pitch surface [mm].
    depth_um, error_um : array_like
        Wear depth, and its standard uncertainty (one for all, or one each) [um].
    meshes, body
        As of `WornFlank`.
    """

    face_mm: ArrayLike
    height_mm: ArrayLike
    depth_um: ArrayLike
    error_um: ArrayLike
    meshes: float | None = None
    body: str = "gear"


@dataclass(frozen=True)
class TransmissionErrorCurve:
    """Loaded transmission error measured over a mesh cycle; its mean is left open, as its zero is arbitrary.

    Attributes
    ----------
    mesh_position : array_like
        Phase in the mesh cycle, 0 to 1, as in a result: 0 where the contact passes the pitch point.
    error_arcsec : array_like
        Transmission error of the gear, positive when it leads [arcsec].
    uncertainty_arcsec : array_like
        Standard uncertainty [arcsec], one for all or one each.
    meshes : float, optional
        As of `WornFlank`; 0 for an unworn pair.
    """

    mesh_position: ArrayLike
    error_arcsec: ArrayLike
    uncertainty_arcsec: ArrayLike
    meshes: float | None = None


@dataclass(frozen=True)
class Reading:
    """A measured value of a variable of `/history`.

    Attributes
    ----------
    quantity : str
        As in `optimise`: ``"transmission_error_amplitude"``, ``"wear_depth_max[pinion]"``.
    value, error : float
        The value and its standard uncertainty, in the unit of the variable.
    meshes : float, optional
        As of `WornFlank`; 0 for an unworn pair.
    """

    quantity: str
    value: float
    error: float
    meshes: float | None = None


Observation = WornFlank | WearAtPoints | TransmissionErrorCurve | Reading


@dataclass(frozen=True)
class Channel:
    """An observation in the form used by an inference.

    Attributes
    ----------
    name : str
    meshes : float
        0: unworn.
    path : str
        Variable of a result that it needs.
    values : (places,) array
        Measured values.
    units : str
        Units of the values.
    movements : (places, movements) array
        Movements that a datum leaves open.
    read : callable
        From a scene and its run to predicted values, (wear states, places).
    evidence : callable
        From shapes (places, shapes) to the evidence on their amounts.
    """

    name: str
    meshes: float
    path: str
    values: FloatArray
    units: str
    movements: FloatArray
    read: Callable[[Scene, Measured], FloatArray]
    evidence: Callable[[FloatArray], Evidence]


def channels_of(scene: Scene, observed: object) -> list[Channel]:
    """Channels of observations.

    Raises
    ------
    SceneError
        With all their faults.
    """
    given = list(observed) if isinstance(observed, list | tuple) else [observed]
    problems: list[Problem] = []
    found = []
    for k, observation in enumerate(given):
        field = f"observed[{k}]" if len(given) > 1 else "observed"
        with Collected(problems):
            found.append(_channel(scene, observation, field))
    if not given:
        problems.append(Problem("observed", "nothing", "one observation or more", "such as WornFlank(...)"))
    if problems:
        raise SceneError(problems, "infer")
    return found


def _channel(scene: Scene, observation: object, field: str) -> Channel:
    if isinstance(observation, WornFlank):
        return _flank_channel(scene, observation, field)
    if isinstance(observation, WearAtPoints):
        return _points_channel(scene, observation, field)
    if isinstance(observation, TransmissionErrorCurve):
        return _curve_channel(scene, observation, field)
    if isinstance(observation, Reading):
        return _reading_channel(scene, observation, field)
    allowed = "WornFlank, WearAtPoints, TransmissionErrorCurve or Reading"
    raise SceneError.of(field, shown(observation), allowed, "a file of a worn flank goes into WornFlank(...)")


def _meshes(scene: Scene, given: object, field: str, *, least: float = 0.0) -> float:
    meshes = given
    if meshes is None and scene.wear is not None:
        meshes = scene.wear.until.meshes
    if meshes is None:
        fix = "give the number of engagements of a gear tooth"
        raise SceneError.of(f"{field}.meshes", None, "a number", fix)
    try:
        count = number(meshes)
    except Unreadable:
        count = -np.inf
    if count < least:
        raise SceneError.of(f"{field}.meshes", shown(meshes), f"{least:g} or more", "engagements of a gear tooth")
    return count


def _worn_body(scene: Scene, body: str, field: str) -> None:
    worn = () if scene.wear is None else scene.wear.worn_bodies
    if body not in BODIES or body not in worn:
        allowed = " or ".join(worn) or "a body that wears"
        raise SceneError.of(f"{field}.body", shown(body), allowed, "see wear.worn_bodies")


class _FlankReader:
    """Wear [um] of a body at places of its flank, in every wear state of a run."""

    def __init__(self, body: str, face: FloatArray, profile: FloatArray) -> None:
        self._body, self._face, self._profile = body, face, profile
        self._known: tuple[FloatArray, FlankReading] | None = None

    def __call__(self, scene: Scene, measured: Measured) -> FloatArray:
        depth = measured.variables[_WEAR][:, [str(body) for body in measured.coords["body"]].index(self._body)]
        grid = grid_of(scene, measured.coords["face"], depth.shape[1], self._body)
        if self._known is None or not np.array_equal(self._known[0], grid.profile):
            flank = nominal_flank(scene, self._body)
            self._known = grid.profile, FlankReading.of(grid, self._face, self._profile, flank)
        return np.stack([self._known[1].read(state.T) for state in depth])


def _flank_channel(scene: Scene, flank: WornFlank, field: str) -> Channel:
    _worn_body(scene, flank.body, field)
    meshes = _meshes(scene, flank.meshes, field, least=1.0)
    motions = require_motions(flank.datum, f"{field}.datum")
    datum = "best_fit" if motions else "as_measured"
    worn = as_wear(scene, flank.measured, flank.before, flank.body, datum=datum, field=field)
    rows, columns = _without_holes(worn.inside)
    if min(rows.sum(), columns.sum()) < _LEAST_GRID:
        raise SceneError.of(
            field, f"{rows.sum()} x {columns.sum()} points without a hole",
            f"a grid of {_LEAST_GRID} x {_LEAST_GRID} points or more on the flank", "measure a grid within the flank",
        )  # fmt: skip
    place = np.ix_(rows, columns)
    if not np.ptp(worn.depth[place]):
        raise SceneError.of(
            field, "the same depth at every point", "depths with the noise of their measurement",
            "give them as they were measured: their uncertainty is estimated from their noise",
        )  # fmt: skip
    shape = (int(rows.sum()), int(columns.sum()))
    modes = _UM * datum_modes(worn, motions)[1][place]
    along, across = (axis[kept] for axis, kept in zip(worn.places, (rows, columns), strict=True))

    def evidence(shapes: FloatArray) -> Evidence:
        noise = FlankNoise(along, across, _UM * worn.depth[place], shapes.reshape(*shape, -1), modes)
        return unknown_noise(noise)

    reader = _FlankReader(flank.body, worn.face[place].ravel(), worn.profile[place].ravel())
    movements = modes.reshape(shape[0] * shape[1], modes.shape[-1])
    name = f"worn flank of the {flank.body}, {shape[0]} x {shape[1]} points"
    return Channel(name, meshes, _WEAR, _UM * worn.depth[place].ravel(), "um", movements, reader, evidence)


def _without_holes(inside: BoolArray) -> tuple[BoolArray, BoolArray]:
    """Rows and columns of a grid that have no hole: those with the most holes are removed one after the other."""
    rows, columns = (np.ones(size, dtype=bool) for size in inside.shape)
    while rows.any() and columns.any():
        holes = ~inside & rows[:, None] & columns
        if not holes.any():
            break
        fractions = [holes.sum(axis=1) / columns.sum(), holes.sum(axis=0) / rows.sum()]
        worst = [int(fraction.argmax()) for fraction in fractions]
        axis = 0 if fractions[0][worst[0]] >= fractions[1][worst[1]] else 1
        (rows, columns)[axis][worst[axis]] = False
    return rows, columns


def _columns(field: str, **given: ArrayLike) -> dict[str, FloatArray]:
    """Columns of numbers of equal length."""
    problems: list[Problem] = []
    found = {name: _finite(f"{field}.{name}", values, problems) for name, values in given.items()}
    if problems:
        raise SceneError(problems, "infer")
    first, size = next((name, values.size) for name, values in found.items())
    if not size:
        raise SceneError.of(f"{field}.{first}", "no number", "one or more", "one for each measured value")
    for name, values in found.items():
        if values.size not in (1, size):
            allowed = f"{size} finite numbers"
            problems.append(Problem(f"{field}.{name}", f"{values.size} numbers", allowed, "one each"))
        elif name in _UNCERTAINTIES and np.any(values <= 0.0):
            fix = "the standard uncertainty of a value"
            problems.append(Problem(f"{field}.{name}", float(values.min()), "greater than 0", fix))
    if problems:
        raise SceneError(problems, "infer")
    return {name: np.broadcast_to(values, (size,)).copy() for name, values in found.items()}


def _finite(field: str, values: ArrayLike, problems: list[Problem]) -> FloatArray:
    """A number or a list of finite numbers, (values,); a problem if they are something else."""
    raw: object = np.asarray(values).tolist() if hasattr(values, "__array__") else values
    listed = list(raw) if isinstance(raw, Sequence) and not isinstance(raw, str) else [raw]
    try:
        return np.asarray(numbers(listed), float)
    except Unreadable as error:
        problems.append(Problem(field, shown(values), "finite numbers", str(error)))
        return np.zeros(0)


def _points_channel(scene: Scene, points: WearAtPoints, field: str) -> Channel:
    _worn_body(scene, points.body, field)
    meshes = _meshes(scene, points.meshes, field, least=1.0)
    given = _columns(
        field, face_mm=points.face_mm, height_mm=points.height_mm, depth_um=points.depth_um, error_um=points.error_um
    )
    face, profile = given["face_mm"], _profile_at(scene, points.body, given["face_mm"], given["height_mm"], field)
    reader = _FlankReader(points.body, face, profile)
    known = given["depth_um"], given["error_um"], "um"
    return _known_channel(f"wear of the {points.body} at {face.size} points", meshes, _WEAR, reader, known)


def _profile_at(scene: Scene, body: str, face: FloatArray, height: FloatArray, field: str) -> FloatArray:
    """Profile coordinates of points at heights above the pitch surface [mm]."""
    flank = nominal_flank(scene, body)
    low, high = flank.face_ends
    if np.any((face < low) | (face > high)):
        outside = float(face[np.argmax(np.abs(face - 0.5 * (low + high)))])
        raise SceneError.of(f"{field}.face_mm", outside, f"{low:g} to {high:g} mm", "a coordinate along the face")
    found = np.empty(face.size)
    for k in range(face.size):
        root, tip = flank.limits(face[k])
        nodes = np.linspace(float(root), float(tip), _FINE)
        heights, _ = flank.place(np.full(_FINE, face[k]), nodes)
        order = np.argsort(heights)
        if not heights[order[0]] <= height[k] <= heights[order[-1]]:
            allowed = f"{heights[order[0]]:.4g} to {heights[order[-1]]:.4g} mm at face {face[k]:g} mm"
            raise SceneError.of(f"{field}.height_mm", float(height[k]), allowed, "height above the pitch surface")
        found[k] = np.interp(height[k], heights[order], nodes[order])
    return found


def _known_channel(
    name: str,
    meshes: float,
    path: str,
    read: Callable[[Scene, Measured], FloatArray],
    known: tuple[FloatArray, FloatArray, str],
    movements: FloatArray | None = None,
) -> Channel:
    """A channel of values with known errors: `known` holds both and their unit."""
    values, error, units = known
    free = np.zeros((values.size, 0)) if movements is None else movements

    def evidence(shapes: FloatArray) -> Evidence:
        return known_noise(values, shapes, free, error)

    return Channel(name, meshes, path, values, units, free, read, evidence)


def _curve_channel(scene: Scene, curve: TransmissionErrorCurve, field: str) -> Channel:
    meshes = _meshes(scene, curve.meshes, field)
    given = _columns(
        field,
        mesh_position=curve.mesh_position,
        error_arcsec=curve.error_arcsec,
        uncertainty_arcsec=curve.uncertainty_arcsec,
    )
    phase = given["mesh_position"] % 1.0
    if phase.size < 3:
        raise SceneError.of(
            f"{field}.mesh_position", f"{phase.size} values", "three or more", "its mean is left open"
        )

    def read(scene: Scene, measured: Measured) -> FloatArray:
        values = measured.variables[_CURVE]
        known = np.append(measured.coords["mesh_position"], measured.coords["mesh_position"][0] + 1.0)
        around = np.column_stack([values, values[:, 0]])
        return np.stack([np.interp(phase, known, curve, period=1.0) for curve in around])

    measured_curve = given["error_arcsec"], given["uncertainty_arcsec"], "arcsec"
    name = f"transmission error at {phase.size} mesh positions"
    return _known_channel(name, meshes, _CURVE, read, measured_curve, np.ones((phase.size, 1)))


def _reading_channel(scene: Scene, reading: Reading, field: str) -> Channel:
    problems: list[Problem] = []
    quantity = quantity_of(f"{field}.quantity", reading.quantity, problems)
    if quantity is not None and (quantity.variable.group != "history" or quantity.time != "end"):
        fix = "meshes=0 for an unworn pair; a life is inferred, not observed"
        problems.append(Problem(f"{field}.quantity", reading.quantity, "a variable of /history without a time", fix))
    elif quantity is not None:
        problems += unmet_needs(f"{field}.quantity", quantity, scene)
    if problems or quantity is None:
        raise SceneError(problems, "infer")
    meshes = _meshes(scene, reading.meshes, field)
    path, body = quantity.path, quantity.body

    def read(scene: Scene, measured: Measured) -> FloatArray:
        values = np.asarray(measured.variables[path], float)
        if values.ndim == 2:  # the greater of both bodies
            bodies = [str(reading) for reading in measured.coords["body"]]
            values = values[:, bodies.index(body)] if body in bodies else np.nanmax(values, axis=1)
        return values[:, None]

    given = _columns(field, value=reading.value, error=reading.error)
    if given["value"].size > 1:
        raise SceneError.of(f"{field}.value", shown(reading.value), "one number", "one Reading for each")
    known = given["value"], given["error"], quantity.units
    return _known_channel(reading.quantity, meshes, path, read, known)
