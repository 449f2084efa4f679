"""Problems of the validation as objects: one definition for tests, benchmarks and the report.

A `WearProblem` is a scene with what is compared on it; a `Method` is a way to solve it, with the settings that are
swept and the finer ones that count as converged. `BlockOnRing` is a published wear test in the plane.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.references import load_reference
from semiwear.scene import Scene

KINDS: dict[str, tuple[str, ...]] = {
    "wear": ("wear_depth_max_root", "wear_depth_max_addendum", "wear_depth_max_pitch", "wear_depth_control_point"),
    "pressure": ("contact_pressure_root", "contact_pressure_addendum", "contact_pressure_pitch"),
    "load share": ("load_share_max",),
    "root stress": ("root_stress_max",),
    "transmission error": ("transmission_error_mean", "transmission_error_amplitude"),
    "meshes": ("meshes",),
}
"""Variables of /history by kind."""

REFERENCE: dict[str, Any] = {
    "numerics.accuracy": 0.003,  # of the wear steps: every other number is given
    "numerics.roll_positions": 160,
    "numerics.face_slices": 161,
    "numerics.profile_points": 401,
    "numerics.harmonics": 49,
}
"""Fine numbers for a whole run of fidelity `line`, adaptive wear steps included."""


# ---- what is compared


@dataclass(frozen=True)
class Figure:
    """A figure of merit of a wear run: the greatest of some variables of /history after the last wear step.

    Attributes
    ----------
    name, units : str
    variables : tuple of str
        Those that a result does not have do not count.
    """

    name: str
    units: str
    variables: tuple[str, ...]

    def values(self, tree: xr.DataTree) -> np.ndarray:
        """Values after the last wear step, variable by variable, bodies one after the other."""
        history = tree["history"].to_dataset().isel(wear_step=-1)
        found = [np.atleast_1d(history[name].values).ravel() for name in self.variables if name in history]
        return np.concatenate(found).astype(float)

    def greatest(self, tree: xr.DataTree) -> float:
        """The value of greatest magnitude."""
        values = self.values(tree)
        return float(values[np.abs(values).argmax()])

    def error(self, tree: xr.DataTree, reference: xr.DataTree) -> float:
        """How far the greatest value is from that of a reference, relative to it."""
        there = self.greatest(reference)
        return abs(self.greatest(tree) - there) / abs(there)


FIGURES: tuple[Figure, ...] = (
    Figure(
        "greatest wear",
        "um",
        ("wear_depth_max_root", "wear_depth_max_addendum", "wear_depth_max_pitch", "wear_depth_max_pinion"),
    ),
    Figure("peak pressure", "MPa", KINDS["pressure"]),
    Figure("root stress", "MPa", KINDS["root stress"]),
    Figure("transmission error", "arcsec", ("transmission_error_mean",)),
)


# ---- what is solved


@dataclass(frozen=True)
class WearProblem:
    """A scene worn for a number of meshes.

    Attributes
    ----------
    name : str
        In tables and file names.
    title : str
    base : str
        The shipped scene that it changes.
    changes : mapping
        Fields of the scene.
    """

    name: str
    title: str
    base: str
    changes: Mapping[str, Any] = field(default_factory=dict)

    def scene(self, *more: Mapping[str, Any]) -> Scene:
        """The scene, with further changes."""
        merged = dict(self.changes)
        for changes in more:
            merged |= changes
        return sw.load_scene(self.base).replace(merged)

    @property
    def marches(self) -> bool:
        """Whether `marched` wear can solve it, which needs the gear worn alone."""
        wear = self.scene().wear
        return wear is not None and wear.worn_bodies == ("gear",)


_TO_MESHES: dict[str, Any] = {"wear.until.control_depths_um": None, "wear.control_point": None}
FACE_GEAR_LIFE = 9e9
"""Meshes after which the shipped scene has worn by some 60 um."""

WEAR_PROBLEMS: tuple[WearProblem, ...] = (
    WearProblem(
        "face_gear",
        "face gear 25/160 as shipped",
        "face_gear_25x160",
        _TO_MESHES | {"wear.until.meshes": FACE_GEAR_LIFE},
    ),
    WearProblem(
        "misaligned",
        "face gear 25/160, misaligned by 0.05 mm and 0.3 mrad",
        "face_gear_25x160",
        _TO_MESHES
        | {
            "wear.until.meshes": FACE_GEAR_LIFE / 2,
            "effects.misalignment.offset_mm": 0.05,
            "effects.misalignment.shaft_angle_error_mrad": 0.3,
        },
    ),
    WearProblem(
        "spur",
        "spur gears FZG C, the gear worn, free edges",
        "spur_fzg_c",
        # teeth end together: on a half-space that goes on beyond them the load at their ends has no limit
        {"wear.worn_bodies": ["gear"], "effects.free_edges": {}},
    ),
)


def wear_problem(name: str) -> WearProblem:
    """The problem of a name."""
    return next(problem for problem in WEAR_PROBLEMS if problem.name == name)


@dataclass(frozen=True)
class Setting:
    """Resolution of a run.

    Attributes
    ----------
    roll_positions, face_slices, profile_points, harmonics, wear_steps, cells_per_half_width : int
        Of `[numerics]`.
    """

    roll_positions: int
    face_slices: int
    profile_points: int
    harmonics: int
    wear_steps: int
    cells_per_half_width: int = 8

    @property
    def changes(self) -> dict[str, Any]:
        """Fields of a scene."""
        return {f"numerics.{name}": value for name, value in vars(self).items()}

    @property
    def label(self) -> str:
        """In a few characters."""
        return f"{self.roll_positions} x {self.face_slices}, {self.wear_steps} steps"


@dataclass(frozen=True)
class Method:
    """A way to solve wear problems.

    Attributes
    ----------
    name : str
    changes : mapping
        Fields of a scene that choose it.
    settings, quick_settings : tuple of Setting
        What is swept, the coarsest first.
    reference, quick_reference : Setting
        Finer than all of them: what counts as converged.
    """

    name: str
    changes: Mapping[str, Any]
    settings: tuple[Setting, ...]
    quick_settings: tuple[Setting, ...]
    reference: Setting
    quick_reference: Setting

    def swept(self, quick: bool) -> tuple[Setting, ...]:
        """Settings of a report."""
        return self.quick_settings if quick else self.settings

    def converged(self, quick: bool) -> Setting:
        """What counts as converged in a report."""
        return self.quick_reference if quick else self.reference


_LINE = (
    Setting(8, 15, 61, 9, 2),
    Setting(12, 31, 81, 17, 4),
    Setting(18, 45, 121, 25, 6),
    Setting(24, 61, 141, 33, 8),
    Setting(36, 91, 161, 33, 12),
)
_PATCH = (
    Setting(8, 15, 61, 9, 2, 3),
    Setting(12, 31, 81, 17, 3, 4),
    Setting(18, 45, 121, 25, 4, 6),
    Setting(24, 61, 141, 33, 6, 8),
)
_MARCHED = (
    Setting(30, 15, 61, 9, 2, 3),
    Setting(60, 31, 81, 17, 3, 4),
    Setting(100, 31, 121, 17, 4, 4),
)
METHODS: tuple[Method, ...] = (
    Method(
        "line",
        {"numerics.fidelity": "line"},
        _LINE,
        _LINE[:4],
        Setting(144, 161, 401, 49, 24),
        Setting(30, 75, 161, 33, 12),
    ),
    Method(
        "patch",
        {"numerics.fidelity": "patch", "numerics.wear_mapping": "interpolated"},
        _PATCH,
        _PATCH[:2],
        Setting(36, 81, 161, 33, 10, 12),
        Setting(18, 45, 121, 17, 4, 6),
    ),
    Method(
        "patch, marched",
        {"numerics.fidelity": "patch", "numerics.wear_mapping": "marched"},
        _MARCHED,
        _MARCHED[:1],
        Setting(160, 45, 141, 25, 6, 6),
        Setting(60, 21, 81, 9, 3, 4),
    ),
)


# ---- a published test in the plane


@dataclass(frozen=True)
class BlockOnRing:
    """The block-on-ring test of Cruzado et al. 2010: a steel ring slides on a steel block, which alone wears.

    Attributes
    ----------
    ring_radius : float [mm]
    line_load : float [N/mm]
    modulus : float [MPa]
        Effective modulus E* of both bodies.
    coefficient : float [mm^2/N]
    distances : tuple of float [m]
        Sliding distances at which depths are published.
    umeshmotion, rigid : tuple of float [um]
        Published greatest depths: Abaqus with UMESHMOTION; a rigid ring on a rigid block.
    umeshmotion_half_width : tuple of float [mm]
        Of the scar, read to within 0.02 mm.
    measured_place : array [mm]
    measured : (test, place) array [um]
        Profiles after the last distance.
    """

    ring_radius: float
    line_load: float
    modulus: float
    coefficient: float
    distances: tuple[float, ...]
    umeshmotion: tuple[float, ...]
    umeshmotion_half_width: tuple[float, ...]
    rigid: tuple[float, ...]
    measured_place: np.ndarray
    measured: np.ndarray

    @classmethod
    def published(cls) -> BlockOnRing:
        """As it was published."""
        table = load_reference("block_on_ring")
        plane = table["youngs_modulus_MPa"] / (1.0 - table["poissons_ratio"] ** 2)
        return cls(
            ring_radius=table["ring_radius_mm"],
            line_load=table["line_load_N_per_mm"],
            modulus=0.5 * plane,
            coefficient=table["wear_coefficient_mm2_per_N"],
            distances=tuple(float(one) for one in table["sliding_distance_m"]),
            umeshmotion=tuple(table["umeshmotion_max_depth_um"]),
            umeshmotion_half_width=tuple(table["umeshmotion_scar_half_width_mm"]),
            rigid=tuple(table["rigid_closed_form_um"]),
            measured_place=np.array(table["measured_x_mm"]),
            measured=np.array([table[f"measured_test_{k}_um"] for k in (1, 2, 3)]),
        )


@dataclass(frozen=True)
class Problems:
    """Everything that the report solves."""

    wear: tuple[WearProblem, ...]
    methods: tuple[Method, ...]
    figures: tuple[Figure, ...]
    block_on_ring: BlockOnRing


PROBLEMS = Problems(WEAR_PROBLEMS, METHODS, FIGURES, BlockOnRing.published())
