"""
An internal gear
================

A negative number of teeth makes a ring. Convex meets concave: the contact is wide and the pressure lower than that
of an external pair of the same pinion.
"""

import semiwear as sw

COARSE = {"numerics.face_slices": 15, "numerics.roll_positions": 16, "numerics.harmonics": 5}
pair = {
    "gear_pair.centre_distance_mm": None,
    "gear_pair.pinion_profile_shift": 0.2,
    "gear_pair.gear_profile_shift": 0.2,
}
external = sw.load_scene("spur_fzg_c").replace(COARSE | pair | {"wear": None, "gear_pair.gear_teeth": 48})
internal = external.replace({"gear_pair.gear_teeth": -48})

# %%
# Contact ratio, and the greatest pressure away from edges.
for scene in (external, internal):
    contact = sw.loaded_contact(scene)["engagement"].to_dataset().isel(wear_step=0)
    pressure = contact.contact_pressure_max.where(contact.contact_pressure_on_edge == 0)
    ratio = float(sw.tooth_contact_analysis(scene).contact_ratio)
    print(f"{scene.gear_pair.description}: contact ratio {ratio:.2f}, {float(pressure.max()):.0f} MPa")

# %%
# Contact pressure over the engagement of the internal pair.
sw.plot.contact_pressure_over_engagement(sw.loaded_contact(internal))
