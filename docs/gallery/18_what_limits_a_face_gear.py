"""
How wide may a face gear be?
============================

Inside, the shaper undercuts the teeth of a face gear; outside, they become pointed. Between the two limits lies the
width that can be used.
"""

import matplotlib.pyplot as plt

import semiwear as sw

shipped = sw.load_scene("face_gear_25x160")
middle = 0.5 * shipped.gear_pair.module_mm * shipped.gear_pair.gear_teeth
angles = (20.0, 22.5, 25.0, 27.5)  # deg
inner, outer = [], []
for angle in angles:
    scene = shipped.replace(
        {
            "gear_pair.pressure_angle_deg": angle,
            "gear_pair.gear_inner_radius_mm": middle - 4.0,
            "gear_pair.gear_outer_radius_mm": middle + 16.0,
            "gear_pair.pinion_face_width_mm": 20.0,
            "gear_pair.pinion_centre_mm": None,
            "gear_pair.shaper_tip_radius_mm": None,
            "gear_pair.rack_tip_radius_mm": None,
            "wear": None,
        }
    )
    limits = sw.tooth_contact_analysis(scene)
    inner.append(float(limits.undercut_radius))
    outer.append(float(limits.pointing_radius))

# %%
# A larger pressure angle moves both limits: the one inwards, the other, too.
figure, ax = plt.subplots(layout="constrained")
ax.fill_between(angles, inner, outer, alpha=0.3)
ax.plot(angles, inner, "o-", label="undercut")
ax.plot(angles, outer, "s-", label="pointed teeth")
ax.set(xlabel="pressure angle [deg]", ylabel="radius of the gear [mm]")
ax.legend()
