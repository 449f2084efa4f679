"""Predicted wear at measured places, as a function of the meshes that a part has run.

Wear knows the wear coefficient only times the meshes: one run over growing meshes gives the wear for every
coefficient. Its states are interpolated by a monotone cubic (Fritsch and Carlson 1980) at each place.
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
    """Reads values on a body's wear grid at places, linear between slices and nodes.

    Held beyond them, but nothing where the mate is narrower and does not touch.

    Attributes
    ----------
    nodes : (places, 4) int array
        Into the flattened (face, profile) grid.
    weights : (places, 4) array
    """

    nodes: IntArray
    weights: FloatArray

    @classmethod
    def of(
        cls, grid: FlankGrid, face: FloatArray, profile: FloatArray, flank: NominalFlank | None = None
    ) -> FlankReading:
        """A reading at flank coordinates [mm], both (places,); with the flank, of nothing beyond its mate."""
        slices, points = grid.profile.shape
        at = np.interp(face, grid.face, np.arange(slices, dtype=float))
        low = np.clip(at.astype(np.int64), 0, max(slices - 2, 0))
        share = at - low
        nodes, weights = np.empty((face.size, 4), dtype=np.int64), np.empty((face.size, 4))
        for k, (station, part) in enumerate(((low, 1.0 - share), (np.minimum(low + 1, slices - 1), share))):
            place = np.array(
                [np.interp(p, grid.profile[i], np.arange(points)) for p, i in zip(profile, station, strict=True)]
            )
            cell = np.clip(place.astype(np.int64), 0, points - 2)
            nodes[:, 2 * k] = station * points + cell
            nodes[:, 2 * k + 1] = station * points + cell + 1
            weights[:, 2 * k] = part * (1.0 - (place - cell))
            weights[:, 2 * k + 1] = part * (place - cell)
        if flank is not None:
            below, above = unreached(flank.pair, flank.body, grid.face)
            weights[(face < below) | (face > above)] = 0.0
        return cls(nodes, weights)

    def read(self, values: FloatArray) -> FloatArray:
        """Values of a (face, profile) array at the places."""
        return np.asarray(np.sum(self.weights * values.ravel()[self.nodes], axis=1))


@dataclass(frozen=True)
class WearCurve:
    """Predicted wear at the points of a measurement over the meshes at the scene's coefficient.

    Attributes
    ----------
    meshes : (states,) array
        From 0.
    depths : (states, places) array [mm]
    """

    meshes: FloatArray
    depths: FloatArray

    def at(self, meshes: float) -> FloatArray:
        """Wear depth after some meshes [mm]."""
        return np.asarray(self._curve(meshes))

    def slope(self, meshes: float) -> FloatArray:
        """Change of the wear depth per relative change of the meshes [mm]."""
        return np.asarray(meshes * self._curve(meshes, 1))

    @cached_property
    def _curve(self) -> PchipInterpolator:
        return PchipInterpolator(self.meshes, self.depths, axis=0)


@dataclass
class WearFamily:
    """Wear of one body from unworn on, over growing meshes.

    Attributes
    ----------
    stepper : WearStepper
    body : int
    depth_a_step : float [mm]
        Greatest wear that a step adds, about.
    state : WearState
        The last one.
    rate : float [mm]
        Greatest wear that a mesh added of late.
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
        """One step further.

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
        """The wear at measured places."""
        return WearCurve(np.array(self.meshes), np.stack([reading.read(depth) for depth in self.depths]))


def _depth(state: WearState, body: int) -> FloatArray:
    """Wear depth of a body that wears, (face, profile) [mm]."""
    depth = state.worn.driven if body == DRIVEN else state.worn.driving
    assert depth is not None
    return depth


def wear_family(scene: Scene, body: str, depth_a_step: float) -> WearFamily:
    """The wear of a scene's body, unworn, and how fast it begins.

    Raises
    ------
    SceneError
        If the scene has no wear, or the body does not wear.
    ConvergenceError
        If nothing wears it.
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
    """Where a measurement reads a family, its points in the order of `inside`."""
    return FlankReading.of(
        family.grid, measured.face[measured.inside], measured.profile[measured.inside], measured.flank
    )
