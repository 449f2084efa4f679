"""Loaded contact on the worn flanks of a result, solved again for quantities that the result does not contain."""

from __future__ import annotations

from dataclasses import dataclass, replace

import xarray as xr

from semiwear.arrays import FloatArray
from semiwear.compile_ahead import compile_ahead
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.errors import SceneError
from semiwear.export.nodes import scene_of
from semiwear.plan import plan
from semiwear.plan.choices import kernels_of
from semiwear.results.missing import group_of

_UM = 1e-3  # mm


@dataclass(frozen=True)
class WornContact:
    """Teeth of a result at given mesh positions, to be loaded with the wear of its wear steps.

    Attributes
    ----------
    teeth : LoadedTeeth
    depth : (steps, 2, face, profile) array [mm]
        Wear of both bodies.
    """

    teeth: LoadedTeeth
    depth: FloatArray

    @classmethod
    def of(cls, tree: xr.DataTree, mesh_positions: FloatArray) -> WornContact:
        """Teeth of a result at mesh positions.

        Raises
        ------
        SceneError
            For a result without wear depths, or with wear depths on another grid than that of its scene.
        """
        data = group_of(tree, "flank")
        if "wear_depth" not in data:
            raise SceneError.of("tree", "a tree without /flank/wear_depth", "a result of simulate", "simulate it")
        scene = scene_of(tree)
        depth = _UM * data["wear_depth"].transpose("wear_step", "body", "face", "profile").values
        compile_ahead(kernels_of(scene, wears=False), scene.numerics.threads)
        teeth = plan(scene).loaded_teeth(None, mesh_positions, data["face"].values)
        if teeth.grid.profile.shape != depth.shape[2:]:
            raise SceneError.of("tree", "wear depths on another grid", "those of its scene's numerics", "run it anew")
        return cls(teeth, depth)

    def load(self, step: int, torque_factor: float = 1.0) -> LoadedState:
        """Contact on the flanks of a wear step, under the scene's torque times a factor."""
        pinion, gear = self.depth[step]
        teeth = self.teeth
        if torque_factor != 1.0:
            teeth = replace(teeth, problem=teeth.problem.under(torque_factor * teeth.problem.torque))
        return teeth.load(gear, driving_wear=None if teeth.driving is None else pinion)
