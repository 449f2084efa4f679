"""
What ends the life first?
=========================

Pitting, bending, micropitting, scuffing and flank fracture of three pairs as they wear: the shipped face gear, the
shipped spur gears and a helical pair, all of case-hardened steel with one mineral oil.
"""

import semiwear as sw

STEEL = {
    "pinion_limit_MPa": 1500,
    "gear_limit_MPa": 1500,
    "pinion_life_curve": "hardened",
    "gear_life_curve": "hardened",
}
ROOT = {f"{body}_limit_MPa": 430 for body in ("pinion", "gear")}
ROOT |= {f"{body}_life_curve": "case_hardened" for body in ("pinion", "gear")}
CASE = {"surface_hardness_HV": 700, "core_hardness_HV": 400, "case_depth_mm": 0.8}
OIL = {
    "oil_family": "mineral",
    "viscosity_40_mm2_per_s": 220,
    "viscosity_100_mm2_per_s": 19,
    "density_15_kg_per_m3": 890,
}
MODES = {
    "effects.flash_temperature": {},
    "effects.pitting": STEEL | {"viscosity_40_mm2_per_s": 220, "roughness_Rz_um": 3},
    "effects.bending": ROOT | {"root_roughness_Rz_um": 10},
    "effects.micropitting": OIL | {"bulk_temperature_C": 90, "roughness_Ra_um": 0.5, "load_stage": 9},
    "effects.scuffing": OIL
    | {"oil_temperature_C": 70, "oil_supply": "dip", "load_stage": 12, "structural_factor": 1.0},
    "effects.flank_fracture": {
        f"{body}_{name}": value for body in ("pinion", "gear") for name, value in CASE.items()
    },
}
COARSE = {
    "numerics.face_slices": 11,
    "numerics.roll_positions": 12,
    "numerics.profile_points": 81,
    "numerics.harmonics": 5,
    "numerics.wear_steps": 6,
    "wear.control_point": None,
    "wear.until.control_depths_um": None,
}


def worn(name, meshes, changes):
    """A shipped scene with all five modes, worn for a number of meshes."""
    scene = sw.load_scene(name).replace(COARSE | MODES | changes | {"wear.until.meshes": meshes})
    return sw.simulate(scene)


# %%
# The mode that governs is shaded. The face gear:
face_gear = worn("face_gear_25x160", 2e8, {"operation.pinion_speed_rpm": 1000.0})
sw.plot.safety_history(face_gear)

# %%
# The spur gears, at two thirds of their shipped torque:
spur = worn("spur_fzg_c", 2e8, {"operation.pinion_speed_rpm": 1500.0, "operation.pinion_torque_Nm": 200.0})
sw.plot.safety_history(spur)

# %%
# The same gears with helical teeth and relief at their tips:
HELICAL = {
    "gear_pair.helix_angle_deg": 15.0,
    "gear_pair.pinion_profile_shift": 0.0,
    "gear_pair.gear_profile_shift": 0.0,
    "gear_pair.centre_distance_mm": None,
    "effects.modification.pinion.tip_relief_um": 15.0,
    "effects.modification.gear.tip_relief_um": 15.0,
}
helical = worn(
    "spur_fzg_c", 2e8, HELICAL | {"operation.pinion_speed_rpm": 1500.0, "operation.pinion_torque_Nm": 200.0}
)
sw.plot.safety_history(helical)

# %%
# And where on the helical gears the film is thinnest at the end of the run:
sw.plot.safety_map(helical, mode="micropitting")
