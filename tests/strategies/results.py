"""Results made of smooth formulas, shaped like the wear of the face gear pair, and random small ones."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import xarray as xr
from hypothesis import strategies as st

from semiwear.results import build_tree, provenance

SCENE = """\
name = "face_gear_25x160"
reference = "seed_paper"

[gear_pair]
type = "face_gear"
pinion_teeth = 25
gear_teeth = 160
module_mm = 6.35

[material.pinion]
youngs_modulus_MPa = 206000
poissons_ratio = 0.3

[operation]
pinion_torque_Nm = 1600

[wear]
coefficient_mm2_per_N = 1.0e-13
control_depth_um = [5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60]
"""


def pitch_cone_height(radius: np.ndarray) -> np.ndarray:
    """Height of the pair's pitch cone above the pitch plane [mm]."""
    return 88.9 - 9.525 - 79.375 * radius / 508


def synthetic_flank(profiles: int, faces: int, life: np.ndarray) -> dict[str, np.ndarray]:
    """Flank grid and wear depth, in proportion to `life` (1 at 60 um of control depth)."""
    radius = np.linspace(480.0, 560.0, faces)
    gear_height = np.linspace(-7.9, 6.35, profiles)[:, None] * np.ones(faces)
    pinion_height = np.linspace(-6.0, 7.5, profiles)[:, None] * np.ones(faces)
    height = np.stack([pinion_height, gear_height])
    own_radius = np.stack([79.375 + pinion_height, np.broadcast_to(radius, gear_height.shape)])
    distance = np.stack([pinion_height, gear_height - pitch_cone_height(radius)])
    zone = np.where(np.abs(distance) < 0.6, 1, np.where(distance < 0, 0, 2))
    sliding = -distance / 8.0
    along_face = np.exp(-(((radius - 505.0) / 26.0) ** 2))
    shape = np.where(distance < 0, 17.0, 4.0) * np.abs(distance) * along_face
    wear = life[:, None, None, None] * shape
    wear[:, 0] *= 6.4 / 10
    return {
        "flank_height": height,
        "flank_radius": own_radius,
        "zone": zone,
        "active": np.ones(zone.shape, dtype=int),
        "specific_sliding": sliding,
        "surface_error": np.array([0.02, 0.05]),
        "wear_depth": wear,
        "contact_pattern": 900 * np.broadcast_to(along_face, (life.size, profiles, faces)),
    }


def synthetic_engagement(roll: np.ndarray, faces: int, life: np.ndarray) -> dict[str, np.ndarray]:
    """One tooth pair from entry to exit."""
    worn = life[:, None]
    hill = np.exp(-((roll / 0.85) ** 6))
    share = (0.30 + (0.48 + 0.12 * (1 - np.exp(-4 * worn))) * np.cos(np.pi * roll / 2.6) ** 2) * hill
    pressure = 900 * np.sqrt(share) * (1 + 0.25 * np.abs(roll) * np.exp(-4 * worn))
    edge = pressure * (1 + 0.3 * np.abs(roll))
    station = np.linspace(-1, 1, faces)
    line_load = share[..., None] * 420 * np.clip(1 - (station - 0.5 * roll[:, None]) ** 2, 0, None)
    sliding = np.abs(roll)[:, None] * np.array([1.1, 0.8]) * (pressure / 900)[..., None]
    stress = (90 + 45 * share)[..., None] * np.array([1.02, 1.0]) * hill[:, None]
    return {
        "load_share": share,
        "contact_pressure_max": pressure,
        "contact_pressure_on_edge": np.zeros(share.shape, dtype=int),
        "contact_pressure_max_edge": edge,
        "tip_load_share": np.where(np.abs(roll) > 0.9, share, 0.0)[..., None] * np.array([0.5, 0.6]),
        "line_load": line_load,
        "line_length": np.ones((roll.size, faces)),
        "lever_arm": np.full((roll.size, faces), 70.0),
        "sliding_distance": sliding,
        "root_stress": stress,
        "friction_coefficient": 0.05 * hill * (1 + worn),
        "friction_power_loss": 400.0 * np.abs(roll) * share,
        "friction_torque_loss": 0.5 * np.abs(roll) * share,
        "flash_temperature_max": 20.0 * np.abs(roll) * share,
        "film_thickness_min": 0.3 * hill * (1 + worn),
    }


def synthetic_ratings(height: np.ndarray, meshes: np.ndarray) -> dict[str, np.ndarray]:
    """Safeties of two modes that fall with wear, of which the first fails near the middle of a long life."""
    steps, share = meshes.size, np.linspace(0.0, 1.0, meshes.size)
    fall = np.stack([1.6 - 1.0 * share, 3.0 - 1.2 * share])[:, :, None] * np.array([1.0, 1.1])
    fails = np.full((2, 2), np.nan)
    step = np.full((2, 2), -1)
    if steps > 1:
        fails[0], step[0] = [0.6 * meshes[-1], 0.7 * meshes[-1]], [steps - 1, steps - 1]
    on_flank = np.broadcast_to(fall[:, -1, :, None, None] + 0.02 * height**2, (2, *height.shape)).copy()
    on_flank[0, :, 0] = np.nan
    return {
        "required_safety": np.array([1.0, 1.4]),
        "safety": fall,
        "safety_error": np.array([0.02, 0.03]),
        "safety_height": 0.0 * fall - 2.0,
        "safety_face": 0.0 * fall + 508.0,
        "damage_sum": 0.5 / fall,
        "safety_on_flank": on_flank,
        "meshes_to_failure": fails,
        "meshes_to_failure_exponent": np.where(np.isfinite(fails), -2.5, np.nan),
        "meshes_to_failure_error": 0.05 * fails,
        "hours_to_failure": 1e-7 * fails,
        "wear_step_of_failure": step,
        "fails_first": np.array([int(steps > 1), 0]),
        "hours": 1e-7 * meshes,
    }


def synthetic_tree(
    wear_steps: int = 13,
    *,
    profiles: int = 41,
    faces: int = 33,
    mesh_positions: int = 12,
    scene_toml: str = SCENE,
) -> xr.DataTree:
    """A complete result that follows the trends of the seed paper, 5 um of control depth a step."""
    return _tree(wear_steps, profiles, faces, mesh_positions, scene_toml).copy(deep=True)


@lru_cache(maxsize=64)
def _tree(wear_steps: int, profiles: int, faces: int, mesh_positions: int, scene_toml: str) -> xr.DataTree:
    step = np.arange(wear_steps)
    life = step / 12.0
    meshes = 6e8 * step * (1 + 0.035 * step)
    mesh_position = np.arange(mesh_positions) / mesh_positions
    roll = np.concatenate([mesh_position - 2, mesh_position - 1, mesh_position, mesh_position + 1])
    flank = synthetic_flank(profiles, faces, life)
    engagement = synthetic_engagement(roll, faces, life)
    level = 1 - np.exp(-4 * life)
    mean = -10.0 - 2.83 * life
    amplitude = 3.0 + 1.31 * life
    wave = np.cos(2 * np.pi * mesh_position) / 2
    history = {}
    for stem, wear, zone in zip(("pinion_", ""), flank["wear_depth"].swapaxes(0, 1), flank["zone"], strict=True):
        for value, name in enumerate(("root", "pitch", "addendum")):
            history[f"wear_depth_max_{stem}{name}"] = np.where(zone == value, wear, 0.0).max(axis=(1, 2))
    history |= {
        "wear_depth_max": flank["wear_depth"].max(axis=(2, 3)),
        "wear_depth_control_point": 60.0 * life,
        "load_share_max": engagement["load_share"].max(axis=1),
        "root_stress_max": np.stack([121.59 + 10 * life, 120.12 + 10 * life], axis=1),
        "contact_pressure_root": 1300 - 500 * level,
        "contact_pressure_addendum": 1100 - 300 * level,
        "contact_pressure_pitch": 800 + 120 * np.minimum(life * 1.5, 1) - 15 * np.clip(life - 2 / 3, 0, 1),
        "subsurface_stress_max": 480 + 120 * life,
        "subsurface_stress_depth": 0.33 - 0.15 * life,
        "transmission_error_mean": mean,
        "transmission_error_amplitude": amplitude,
        "wear_depth_max_pinion": flank["wear_depth"][:, 0].max(axis=(1, 2)),
        "wear_volume": life[:, None] * np.array([3.0, 1.0]),
        "wear_volume_on_edges": life[:, None] * np.array([0.03, 0.01]),
        "tip_relief_to_free": np.stack([20.0 - 5.0 * life, 0.0 * life], axis=1),
        "mesh_efficiency": 0.99 - 0.001 * life,
        "friction_power_loss_mean": 200.0 + 20.0 * life,
        "contact_temperature_max": 100.0 - 5.0 * life,
        "lambda_ratio_min": 0.2 + 0.01 * life,
    }
    mesh_cycle = {
        "transmission_error_loaded": mean[:, None] + amplitude[:, None] * wave,
        "transmission_error_unloaded": -3.0 * life[:, None] + 0.5 * life[:, None] * wave,
        "pairs_in_contact": np.where(mesh_position < 0.5, 2, 1) * np.ones((wear_steps, 1), dtype=int),
    }
    diagnostics = {
        "iterations": 4 + step % 3,
        "load_balance_residual": 1e-9 * (1 + step),
        "complementarity_residual": 1e-12 * (1 + step),
        "edge_residual": 1e-3 / (1 + step),
        "wear_law_residual": 1e-4 * step,
        "wear_volume_residual": 1e-4 * np.ones((wear_steps, 2)),
        "seconds": np.array([0.4, 1.1, 2.6]),
        "elements_across": 4.0 + 0.0 * engagement["load_share"],
        "reaches_border": 0.0 * engagement["load_share"],
        "edge_contact": 1.0 * (np.abs(roll) > 0.8) + 0.0 * engagement["load_share"],
        "usual_step_depth": np.asarray(6.0),
        "smallest_gap": -1e-7 + 0.0 * mesh_cycle["transmission_error_loaded"],
        "effect_seconds": np.array([0.1, 0.2]),
        "error_estimate": np.array([0.004, 0.02]),
    }
    life_of_run = {
        "depth_limit": np.asarray(50.0),
        "meshes_to_limit": np.asarray(8e9),
        "hours_to_limit": np.asarray(1200.0),
        "sensitivity_to_wear_coefficient": np.asarray(-1.0),
        "sensitivity_to_torque": np.asarray(-0.7),
        "meshes_to_end": np.asarray(5e9),
        "hours_to_end": np.asarray(750.0),
        "ended_by": np.asarray("pitting"),
    }
    return build_tree(
        {
            "flank": flank,
            "engagement": engagement,
            "mesh_cycle": mesh_cycle,
            "history": history,
            "life": life_of_run,
            "ratings": synthetic_ratings(flank["flank_height"], meshes),
            "diagnostics": diagnostics,
        },
        {
            "face": np.linspace(480.0, 560.0, faces),
            "meshes": meshes,
            "mesh_position": mesh_position,
            "roll_position": roll,
            "stage": np.array(["geometry", "compliance", "wear"]),
            "effect": np.array(["friction", "lubrication"]),
            "quantity": np.array(["wear_depth_max_root", "root_stress_max"]),
            "mode": np.array(["pitting", "bending"]),
        },
        provenance(
            title="Wear of the face gear pair 25 x 160",
            scene_toml=scene_toml,
            physics="contact: line loads along the valley of the gap\nwear: swept line, implicit steps",
            fidelity="line",
            references="Archard 1953, J. Appl. Phys. 24, 981-988\nJohnson 1985, Contact Mechanics",
        ),
    )


def changed(tree: xr.DataTree, path: str, change: Callable[[np.ndarray], np.ndarray]) -> xr.DataTree:
    """A copy in which a variable is changed."""
    copy = tree.copy(deep=True)
    copy[path].values[:] = change(copy[path].values)
    return copy


def without(tree: xr.DataTree, group: str, *names: str) -> xr.DataTree:
    """A copy without a group, or without some of its variables."""
    copy = tree.copy(deep=True)
    if names:
        copy[group] = xr.DataTree(copy[group].to_dataset().drop_vars(names))
    else:
        del copy[group]
    return copy


def of_one_state(tree: xr.DataTree) -> xr.DataTree:
    """A copy whose engagement and mesh cycle are those of a single contact: of one wear step, without meshes."""
    copy = tree.copy(deep=True)
    for group in ("engagement", "mesh_cycle"):
        copy[group] = xr.DataTree(copy[group].to_dataset().isel(wear_step=[0]).drop_vars("meshes"))
    return copy


def trees() -> st.SearchStrategy[xr.DataTree]:
    """Small results of random size."""
    return st.builds(
        synthetic_tree,
        st.integers(1, 5),
        profiles=st.integers(3, 7),
        faces=st.integers(3, 6),
        mesh_positions=st.integers(1, 6),
    )
