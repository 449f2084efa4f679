"""Predicted wear at measured points, as a function of the meshes that a part has run.

Wear depends on the product of wear coefficient and meshes, so that one run gives the wear for every coefficient. Its
states are interpolated by a monotone cubic (Fritsch and Carlson 1980) at each point.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import PchipInterpolator

from semiwear.arrays import FloatArray, IntArray
from semiwear.compile_ahead import compile_ahead
from semiwear.errors import ConvergenceError, SceneError
from semiwear.measured.nominal import NominalFlank, unreached
from semiwear.measured.worn import MeasuredWear
from semiwear.meshing.flank_grid import FlankGrid
from semiwear.meshing.flank_pair import BODIES, DRIVEN
from semiwear.plan import plan
from semiwear.plan.choices import kernels_of
from semiwear.scene import Scene
from semiwear.wear.state import WearState
from semiwear.wear.stepping import WearStepper


@dataclass(frozen=True)
class FlankReading:
    """Interpolation of values on a body's wear grid at points, linear between slices and nodes.

    Constant beyond the grid, but zero where a narrower mate does not touch.

    Attributes
    ----------
    nodes : (points, 4) int array
        Indices into the flattened (face, profile) grid.
    weights : (points, 4) array
    """

    nodes: IntArray
    weights: FloatArray

    @classmethod
    def of(
        cls, grid: FlankGrid, face: FloatArray, profile: FloatArray, flank: NominalFlank | None = None
    ) -> FlankReading:
        """Interpolation at flank coordinates [mm], both (points,); with a flank, zero beyond its mate."""
        slices, points = grid.profile.shape
        at = np.interp(face, grid.face, np.arange(slices, dtype=float))
        low = np.clip(at.astype(np.int64), 0, max(slices - 2, 0))
        share = at - low
        nodes, weights = np.empty((face.size, 4), dtype=np.int64), np.empty((face.size, 4))
        for k, (station, part) in enumerate(((low, 1.0 - share), (np.minimum(low + 1, slices - 1), share))):
            index = np.array(
                [np.interp(p, grid.profile[i], np.arange(points)) for p, i in zip(profile, station, strict=True)]
            )
            cell = np.clip(index.astype(np.int64), 0, points - 2)
            nodes[:, 2 * k] = station * points + cell
            nodes[:, 2 * k + 1] = station * points + cell + 1
            weights[:, 2 * k] = part * (1.0 - (index - cell))
            weights[:, 2 * k + 1] = part * (index - cell)
        if flank is not None:
            below, above = unreached(flank.pair, flank.body, grid.face)
            weights[(face < below) | (face > above)] = 0.0
        return cls(nodes, weights)

    def read(self, values: FloatArray) -> FloatArray:
        """Values of a (face, profile) array at the points."""
        return np.asarray(np.sum(self.weights * values.ravel()[self.nodes], axis=1))


@dataclass(frozen=True)
class WearCurve:
    """Predicted wear at the points of a measurement, over the meshes at the scene's coefficient.

    Attributes
    ----------
    meshes : (states,) array
        From 0.
    depths : (states, points) array [mm]
    """

    meshes: FloatArray
    depths: FloatArray

    def at(self, meshes: float) -> FloatArray:
        """Wear depth after a number of meshes [mm]."""
        return np.asarray(self._curve(meshes))

    def slope(self, meshes: float) -> FloatArray:
        """Derivative of the wear depth by the logarithm of the meshes [mm]."""
        return np.asarray(meshes * self._curve(meshes, 1))

    @cached_property
    def _curve(self) -> PchipInterpolator:
        return PchipInterpolator(self.meshes, self.depths, axis=0)


@dataclass
class WearFamily:
    """Wear of one body over increasing meshes, from the unworn flank.

    Attributes
    ----------
    stepper : WearStepper
    body : int
    depth_a_step : float [mm]
        Increase of the greatest wear in a step, approximately.
    state : WearState
        State after the last step.
    rate : float [mm]
        Increase of the greatest wear for each mesh in the last step.
    meshes : list of float
    depths : list of (face, profile) arrays [mm]
    """

    stepper: WearStepper
    body: int
    depth_a_step: float
    state: WearState
    rate: float
    meshes: list[float]
    depths: list[FloatArray]

    @property
    def grid(self) -> FlankGrid:
        """Nodes of the body's wear."""
        teeth = self.stepper.teeth
        if self.body == DRIVEN:
            return teeth.grid
        assert teeth.driving is not None
        return teeth.driving.grid

    @property
    def greatest(self) -> float:
        """Greatest wear depth so far [mm]."""
        return float(self.depths[-1].max())

    def extend(self) -> None:
        """Add a wear step.

        Raises
        ------
        ConvergenceError
            If the flank cannot be worn further.
        """
        length = self.depth_a_step / self.rate
        self.state = self.stepper.step(self.state, length)
        depth = _depth(self.state, self.body)
        rate = float(depth.max() - self.depths[-1].max()) / length
        self.rate = max(rate, 0.2 * self.rate)
        self.meshes.append(self.state.meshes)
        self.depths.append(depth)

    def curve(self, reading: FlankReading) -> WearCurve:
        """Wear at measured points."""
        return WearCurve(np.array(self.meshes), np.stack([reading.read(depth) for depth in self.depths]))


def _depth(state: WearState, body: int) -> FloatArray:
    """Wear depth of a body that wears, (face, profile) [mm]."""
    depth = state.worn.driven if body == DRIVEN else state.worn.driving
    assert depth is not None
    return depth


def wear_family(scene: Scene, body: str, depth_a_step: float) -> WearFamily:
    """Wear family of a scene's body with the unworn state only, and its initial wear rate.

    Raises
    ------
    SceneError
        If the scene has no wear, or the body does not wear.
    ConvergenceError
        If its wear rate is zero.
    """
    if scene.wear is None:
        raise SceneError.of("wear", None, "a table [wear]", "give wear.coefficient_mm2_per_N, a first guess")
    if body not in scene.wear.worn_bodies:
        found = ", ".join(scene.wear.worn_bodies)
        raise SceneError.of("wear.worn_bodies", found, f"with the {body}, which was measured", "add it")
    compile_ahead(kernels_of(scene), scene.numerics.threads)
    physics = plan(scene)
    stepper = physics.wear_stepper(physics.loaded_teeth())
    index, state = BODIES.index(body), stepper.start()
    rate = float(_depth(stepper.step(state, 1.0), index).max())
    if rate <= 0.0:
        raise ConvergenceError(
            f"the {body} of this scene does not wear: its wear coefficient is 0 there, or a film carries all load"
        )
    return WearFamily(stepper, index, depth_a_step, state, rate, [0.0], [_depth(state, index)])


def reading_of(family: WearFamily, measured: MeasuredWear) -> FlankReading:
    """Interpolation of a family at the points of a measurement, those inside in their order."""
    return FlankReading.of(
        family.grid, measured.face[measured.inside], measured.profile[measured.inside], measured.flank
    )
