"""Runs whose results are frozen: every kind of pair, fidelity, scheme and effect, on grids as coarse as will do."""

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.contact import solve_half_space
from tests.scenes import SMALL
from tests.strategies.point_flanks import exported, scene_of

Result = xr.DataTree | xr.Dataset


_FACE: dict[str, Any] = SMALL | {"wear.until.control_depths_um": [5.0, 20.0]}
_MESHES = {"wear.until.control_depths_um": None, "wear.until.meshes": 2e8, "wear.control_point": None}
_BOTH = {
    "wear.worn_bodies": ["pinion", "gear"],
    "wear.coefficient_mm2_per_N": {"pinion": 1e-14, "gear": 1e-13},
}
_STEPS = _MESHES | {"numerics.wear_steps": 2}
_SPEED = {"operation.pinion_speed_rpm": 600.0}
_CYLINDER = SMALL | {"gear_pair.centre_distance_mm": None, "numerics.face_slices": 11}
_HELICAL = _CYLINDER | {"gear_pair.helix_angle_deg": 20.0}
_INTERNAL = _CYLINDER | {
    "gear_pair.pinion_teeth": 25,
    "gear_pair.gear_teeth": -60,
    "gear_pair.pinion_profile_shift": 0.4,
    "gear_pair.gear_profile_shift": -0.4,
}


@dataclass(frozen=True)
class _Run:
    """A shipped scene, changes of it, and what is computed."""

    scene: str
    changes: Mapping[str, Any]
    compute: Callable[[sw.Scene], Result] = sw.simulate

    def result(self) -> Result:
        return self.compute(sw.load_scene(self.scene).replace(dict(self.changes)))


def _face(changes: Mapping[str, Any] | None = None, compute: Callable[[sw.Scene], Result] = sw.simulate) -> _Run:
    return _Run("face_gear_25x160", _FACE | dict(changes or {}), compute)


def _cylindrical(changes: Mapping[str, Any], compute: Callable[[sw.Scene], Result] = sw.simulate) -> _Run:
    return _Run("spur_fzg_c", changes, compute)


def _worn_contact(scene: sw.Scene) -> xr.DataTree:
    """Contact on a flank worn in a band, at roll positions that are not those of the grid."""
    numerics = scene.numerics
    height = np.linspace(-1.0, 1.0, numerics.profile_points)[:, None]
    depth = 20.0 * np.exp(-((height + 0.4) ** 2) / 0.02) * np.ones(numerics.face_slices)
    return sw.loaded_contact(scene, roll_positions=np.array([-0.6, -0.25, 0.0, 0.4]), wear_depth=depth)


def _unloaded(scene: sw.Scene) -> xr.DataTree:
    return sw.tooth_contact_analysis(scene, sw.Placement(offset_mm=0.05, shaft_angle_error_mrad=0.5))


def _of_points(scene: sw.Scene) -> xr.DataTree:
    with tempfile.TemporaryDirectory() as folder:
        return sw.simulate(scene_of(exported(scene, Path(folder), points=(41, 31))))


def _half_space(load: float | None, approach: float | None) -> Result:
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, 41), np.linspace(-8.0, 8.0, 57), indexing="ij")
    gap = x**2 / 40 + y**2 / 4000 + 2e-4 * np.cos(20.0 * x) * np.cos(2.0 * y)
    tolerance = 1e-12  # the rest of a looser one goes with the processor
    found = solve_half_space(
        gap, cell=(0.025, 16.0 / 56), effective_modulus=115e3, load=load, approach=approach, tolerance=tolerance
    )
    return xr.Dataset({"pressure": (("x", "y"), found.pressure), "approach": found.approach})


def _half_space_under_load(_: sw.Scene) -> Result:
    return _half_space(4000.0, None)


def _half_space_at_approach(_: sw.Scene) -> Result:
    return _half_space(None, 1.5e-3)


RUNS: dict[str, _Run] = {
    "face gear": _face(),
    "face gear, coast flank": _face({"operation.loaded_flank": "coast"}),
    "face gear, both worn": _face(_BOTH),
    "face gear, pinion worn": _face(_STEPS | {"wear.worn_bodies": ["pinion"]}),
    "face gear, marched": _face(
        _STEPS | {"numerics.fidelity": "patch", "numerics.wear_mapping": "marched", "numerics.roll_positions": 24}
    ),
    "face gear, patches": _face({"numerics.fidelity": "patch"}),
    "face gear, patches, both worn": _face(_BOTH | {"numerics.fidelity": "patch", "effects.friction": {}}),
    "face gear, two stages": _face({"numerics.wear_scheme": "two-stage"}),
    "face gear, explicit": _face(
        _STEPS | {"wear.until.meshes": 2e6, "numerics.wear_scheme": "explicit", "numerics.wear_steps": 3}
    ),
    "face gear, automatic steps": _face(_MESHES),
    "face gear, rigid teeth": _face({"numerics.tooth_compliance": "rigid"}),
    "face gear, load spectrum": _face(
        {"effects.load_spectrum": {"torques_Nm": [800.0, 1600.0, 2200.0], "shares": [0.3, 0.5, 0.2]}}
    ),
    "face gear, friction": _face(_SPEED | {"effects.friction.coefficient": 0.08}),
    "face gear, pitch errors": _face({"effects.pitch_error.pinion_um": [0.0, 6.0, -3.0]}),
    "face gear, misaligned": _face(
        {"effects.misalignment": {"offset_mm": 0.1, "shaft_angle_error_mrad": -0.5, "pinion_slope_mrad": 0.5}}
    ),
    "face gear, modified": _face(
        {
            "effects.modification.pinion.tip_relief_um": 20.0,
            "effects.modification.gear.crowning_um": 8.0,
        }
    ),
    "face gear, free edges": _face({"effects.free_edges": {}}),
    "face gear, shafts": _face({"effects.shaft_compliance.offset_um_per_kN": 3.0}),
    "face gear, film and flash": _face(
        _SPEED
        | {
            "effects.lubrication": {},
            "effects.flash_temperature": {},
            "effects.wear_law.lubrication": {},
            "effects.wear_law.temperature": {},
        }
    ),
    "face gear, hardness and pressure": _face(
        {
            "effects.wear_law.hardness": {
                "surface_hardness_HV": 700.0,
                "core_hardness_HV": 400.0,
                "case_depth_um": 10.0,
            },
            "effects.wear_law.load.exponent": 0.5,
        }
    ),
    "face gear, life": _face(_STEPS | {"wear.until.meshes": 1e8, "effects.run_life.depth_limit_um": 10.0}),
    "face gear, points": _face({}, _of_points),
    "face gear, worn contact": _face({}, _worn_contact),
    "face gear, unloaded": _face({}, _unloaded),
    "spur": _cylindrical(_CYLINDER),
    "spur, patches": _cylindrical(_CYLINDER | {"numerics.fidelity": "patch", "effects.free_edges": {}}),
    "helical": _cylindrical(_HELICAL),
    "helical, friction": _cylindrical(_HELICAL | {"effects.friction.coefficient": 0.05}),
    "helical, unloaded": _cylindrical(_HELICAL, _unloaded),
    "internal": _cylindrical(_INTERNAL),
    "half-space under load": _face({}, _half_space_under_load),
    "half-space at an approach": _face({}, _half_space_at_approach),
}


def result(name: str) -> Result:
    """The result of a run."""
    return RUNS[name].result()
