"""
Misalignment moves the contact
==============================

A face gear's bearing contact wanders along the tooth when the pinion is not where it should be. Unloaded tooth
contact analysis tells how far, in a fraction of a second for each position.
"""

import matplotlib.pyplot as plt
import numpy as np

import semiwear as sw

scene = sw.load_scene("face_gear_25x160")
errors = np.linspace(-1.0, 1.0, 9)  # mrad


def contact_radius(error):
    """Gear radius [mm] at which the pair touches at the pitch position."""
    found = sw.tooth_contact_analysis(scene, sw.Placement(shaft_angle_error_mrad=error))
    x, _, z = found.path_of_contact.sel(roll_position=0.0, method="nearest").values
    return float(np.hypot(x, z))


radii = [contact_radius(error) for error in errors]

# %%
# The teeth stand between the gear's inner and outer radius: towards either, contact reaches the end of the tooth.
figure, ax = plt.subplots(layout="constrained")
ax.plot(errors, radii, "o-")
for radius in (scene.gear_pair.gear_inner_radius_mm, scene.gear_pair.gear_outer_radius_mm):
    ax.axhline(radius, color="grey", linestyle="--")
ax.set(xlabel="shaft angle error [mrad]", ylabel="gear radius of contact [mm]")
print(f"{(radii[-1] - radii[0]) / 2:.1f} mm for each mrad")
