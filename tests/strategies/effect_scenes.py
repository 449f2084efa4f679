"""A plain small scene that the tests of effects share, and every effect with strength zero."""

from typing import Any

from tests.scenes import MEDIUM, SHIPPED
from tests.strategies.oil_and_case import FLANK_FRACTURE, MICROPITTING, SCUFFING
from tests.strategies.ratings import BENDING, PITTING

PLAIN = SHIPPED.replace(
    MEDIUM
    | {
        "numerics.wear_steps": 2,
        "wear.until.meshes": 2e9,
        "wear.control_point": None,
    }
)
SPEED: dict[str, Any] = {"operation.pinion_speed_rpm": 300.0}
_HOT = SPEED | {"effects.flash_temperature": {}}
_FILM = SPEED | {"effects.lubrication": {}}
_SMOOTH_ALREADY = {"strength": 0.0, "acts_on": "micropitting"}

_TORQUE = PLAIN.operation.pinion_torque_Nm
_RIGID_SHAFTS = {
    f"{freedom}_{unit}": 0.0
    for unit, freedoms in {
        "um_per_kN": ("offset", "axial_pinion", "axial_gear"),
        "mrad_per_kNm": ("shaft_angle", "pinion_slope"),
    }.items()
    for freedom in freedoms
}
_ONE_HARDNESS = {"surface_hardness_HV": 600.0, "core_hardness_HV": 600.0, "case_depth_um": 10.0}

# Name of the effect, and changes of `PLAIN` with which its table is there and does nothing.
NEUTRAL: tuple[tuple[str, dict[str, Any]], ...] = (
    ("misalignment", {"effects.misalignment": {}}),
    ("modification.pinion", {"effects.modification.pinion": {}}),
    ("modification.gear", {"effects.modification.gear": {}}),
    ("free_edges", {"effects.free_edges.strength": 0.0}),
    ("friction", {"effects.friction.coefficient": 0.0}),
    ("flash_temperature", SPEED | {"effects.flash_temperature": {}}),
    ("lubrication", SPEED | {"effects.lubrication": {}}),
    ("wear_law.hardness", {"effects.wear_law.hardness": _ONE_HARDNESS}),
    (
        "wear_law.hardness",
        {"effects.wear_law.hardness": _ONE_HARDNESS | {"transition_um": 5.0, "pitch_hardness_HV": 600.0}},
    ),
    (
        "wear_law.lubrication",
        SPEED | {"effects.lubrication": {}, "effects.wear_law.lubrication.strength": 0.0},
    ),
    (
        "wear_law.temperature",
        SPEED | {"effects.flash_temperature": {}, "effects.wear_law.temperature.activation_energy_kJ_per_mol": 0.0},
    ),
    ("wear_law.load", {"effects.wear_law.load.exponent": 0.0}),
    ("running_in", _FILM | {"effects.wear_law.lubrication.strength": 0.0, "effects.running_in": {}}),
    ("running_in", _HOT | {"effects.micropitting": MICROPITTING, "effects.running_in": _SMOOTH_ALREADY}),
    ("load_spectrum", {"effects.load_spectrum": {"torques_Nm": [_TORQUE], "shares": [1.0]}}),
    ("load_spectrum", {"effects.load_spectrum": {"torques_Nm": [_TORQUE, _TORQUE], "shares": [0.5, 0.5]}}),
    ("pitch_error", {"effects.pitch_error.pinion_um": [0.0, 0.0]}),
    ("pitch_error", {"effects.pitch_error.pinion_um": [7.0, 7.0, 7.0]}),
    ("shaft_compliance", {"effects.shaft_compliance": _RIGID_SHAFTS}),
    ("pitting", SPEED | {"effects.pitting": PITTING}),
    ("bending", {"effects.bending": BENDING}),
    ("micropitting", _HOT | {"effects.micropitting": MICROPITTING}),
    ("scuffing", _HOT | {"effects.scuffing": SCUFFING}),
    ("flank_fracture", {"effects.flank_fracture": FLANK_FRACTURE}),
    ("run_life", {"effects.run_life.depth_limit_um": 5.0}),
)
