"""
Crowning for a helical pair that leans
======================================

A shaft that leans by a few tenths of a mrad puts the load on one end of the teeth. Crowning keeps it in the middle,
at the price of a higher root stress when everything is straight.
"""

import matplotlib.pyplot as plt
import numpy as np

import semiwear as sw

helical = {
    "gear_pair.helix_angle_deg": 15.0,
    "gear_pair.centre_distance_mm": None,
    "gear_pair.pinion_face_width_mm": 30.0,
    "effects.free_edges": {},
    "wear": None,
}
COARSE = {"numerics.face_slices": 21, "numerics.roll_positions": 12, "numerics.harmonics": 7}
scene = sw.load_scene("spur_fzg_c").replace(helical | COARSE)

figure, ax = plt.subplots(layout="constrained")
leans = np.array([-0.6, -0.3, 0.0, 0.3, 0.6])  # mrad
for crowning in (0.0, 5.0, 15.0):
    stress = []
    for lean in leans:
        changes = {
            "effects.misalignment.pinion_slope_mrad": lean,
            "effects.modification.pinion.crowning_um": crowning,
        }
        contact = sw.loaded_contact(scene.replace(changes))
        stress.append(float(contact["engagement"].root_stress.sel(body="pinion").max()))
    ax.plot(leans, stress, "o-", label=f"crowning {crowning:g} um")
ax.set(xlabel="slope of the pinion [mrad]", ylabel="greatest root stress of the pinion [MPa]")
ax.legend()
