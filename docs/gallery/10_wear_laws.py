"""
Laws of the wear coefficient
============================

Archard's coefficient is seldom one number. A hardened case that wears through, and a coefficient that rises
with the pressure, are tables of the scene.
"""

import matplotlib.pyplot as plt

import semiwear as sw

COARSE = {"numerics.face_slices": 15, "numerics.roll_positions": 12, "numerics.harmonics": 5}
scene = sw.load_scene("face_gear_25x160").replace(COARSE | {"wear.until.control_depths_um": [10, 20, 30, 40, 50, 60]})

figure, ax = plt.subplots(layout="constrained")
for name, changes in {
    "constant": {},
    "soft core below a case": {"effects.wear_law.hardness": {}},
    "rising with pressure": {"effects.wear_law.load": {}},
}.items():
    history = sw.simulate(scene.replace(changes))["history"].to_dataset()
    ax.plot(history.meshes, history.wear_depth_control_point, "o-", label=name)
ax.set(xlabel="meshes of a gear tooth", ylabel="wear at the control point [um]")
ax.legend()

# %%
# The fields of such a table, as the command line lists them.
from semiwear.scene.guide import fields_text

print(fields_text("face_gear", "effects.wear_law.hardness"))
