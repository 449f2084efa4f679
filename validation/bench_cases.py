"""Cases of the benchmark: what is run, on which scene; read by `bench_main.py` and by asv alike."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi
from typing import Any, Literal

Action = Literal["simulate", "screen", "loaded_contact", "compliance"]


@dataclass(frozen=True)
class BenchCase:
    """Something that takes time.

    Attributes
    ----------
    name : str
    about : str
        What it is, in one line, for who reads the list.
    scene : str
        A shipped scene.
    changes : dict
        By field of the scene.
    action : {"simulate", "screen", "loaded_contact", "compliance"}
        `compliance` computes the influence matrices of both bodies' teeth anew.
    """

    name: str
    about: str
    scene: str = "face_gear_25x160"
    changes: dict[str, Any] = field(default_factory=dict)
    action: Action = "simulate"

    def request(self, threads: int = 1) -> dict[str, Any]:
        """What `bench_worker.py` is asked to do."""
        return {"action": self.action, "scene": self.scene, "changes": self.changes, "threads": threads}


CASES: tuple[BenchCase, ...] = (
    BenchCase("main", "face gear 25/160 to a control depth of 60 um, twelve implicit wear steps"),
    BenchCase("patch", "the same at fidelity patch", changes={"numerics.fidelity": "patch"}),
    BenchCase("both", "the same with both bodies worn", changes={"wear.worn_bodies": ["pinion", "gear"]}),
    BenchCase("spur", "FZG type C, both bodies worn", scene="spur_fzg_c"),
    BenchCase(
        "helical",
        "the same with a helix of 20 degrees and thrice its face",
        scene="spur_fzg_c",
        changes={
            "gear_pair.helix_angle_deg": 20,
            "gear_pair.normal_module_mm": 4.2,
            "gear_pair.pinion_face_width_mm": 42,
            "gear_pair.gear_face_width_mm": 42,
            "gear_pair.pinion_profile_shift": 0.2,
            "gear_pair.gear_profile_shift": None,
        },
    ),
    BenchCase("unworn", "one mesh of the unworn face gear", action="loaded_contact"),
    BenchCase("screen", "effects ranked for the face gear", action="screen"),
    BenchCase("compliance", "influence matrices of the teeth of both bodies", action="compliance"),
)


@dataclass(frozen=True)
class Growth:
    """A number that makes a run larger, and its values.

    Attributes
    ----------
    name : str
    label : str
        Of the axis.
    changes : dict of float to dict
        By value of the number.
    scene : str
    """

    name: str
    label: str
    changes: dict[float, dict[str, Any]]
    scene: str = "face_gear_25x160"


def _numbers(name: str, values: tuple[int, ...], **fixed: Any) -> dict[float, dict[str, Any]]:
    return {float(value): {f"numerics.{name}": value} | fixed for value in values}


_HELICAL = {
    "gear_pair.helix_angle_deg": 30,
    "gear_pair.normal_module_mm": 3.95,
    "gear_pair.centre_distance_mm": None,
    "gear_pair.pinion_profile_shift": 0.1,
    "gear_pair.gear_profile_shift": -0.1,
    "numerics.face_slices": 61,
}

GROWTH: tuple[Growth, ...] = (
    Growth("slices", "slices across the face", _numbers("face_slices", (31, 61, 121, 241))),
    Growth("roll positions", "roll positions", _numbers("roll_positions", (12, 24, 48, 96))),
    Growth("profile points", "points along the profile", _numbers("profile_points", (101, 201, 401, 801))),
    Growth("wear steps", "implicit wear steps to one depth", {
        float(steps): {
            "wear.until.control_depths_um": [60.0 * (k + 1) / steps for k in range(steps)]
        } for steps in (6, 12, 24, 48)
    }),
    Growth("tooth pairs", "face width over axial pitch", {
        overlap: _HELICAL
        | {
            f"gear_pair.{body}_face_width_mm": round(overlap * pi * 3.95 / 0.5, 3)
            for body in ("pinion", "gear")
        }
        | {"operation.pinion_torque_Nm": 150.0 * overlap}
        for overlap in (0.5, 1.0, 2.0, 4.0)
    }, scene="spur_fzg_c"),
)  # fmt: skip
