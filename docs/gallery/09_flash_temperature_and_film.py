"""
Heat and oil film along the engagement
======================================

How hot the contact gets and how thick the film is decide which wear coefficient is the right one. Both are read off
the same run.
"""

import matplotlib.pyplot as plt

import semiwear as sw

COARSE = {"numerics.face_slices": 11, "numerics.roll_positions": 24, "numerics.harmonics": 5}
scene = sw.load_scene("spur_fzg_c").replace(
    COARSE
    | {
        "operation.pinion_speed_rpm": 2000.0,
        "effects.flash_temperature": {"bulk_temperature_C": 70.0},
        "effects.lubrication": {"viscosity_mPas": 12.0, "roughness_um": 0.4},
        "effects.modification": {"pinion": {"tip_relief_um": 20.0}, "gear": {"tip_relief_um": 20.0}},
        "wear": None,
    }
)
pair = sw.loaded_contact(scene)["engagement"].to_dataset().isel(wear_step=0)

# %%
# Flash temperature is none where nothing slides, at roll position 0; the film is thinnest at the pinion's root.
figure, axes = plt.subplots(2, 1, sharex=True, layout="constrained")
loaded = pair.where(pair.load_share > 0.0)
axes[0].plot(pair.roll_position, loaded.flash_temperature_max, ".-")
axes[0].set(ylabel="flash temperature [K]")
axes[1].plot(pair.roll_position, loaded.film_thickness_min, ".-", color="C1")
axes[1].set(xlabel="roll position [base pitches]", ylabel="least film [um]")
