"""
Life, and nine gears of ten
===========================

When is the control point worn by 30 um? One wear coefficient gives one life; coefficients and loads scatter, and so
do lives.
"""

import matplotlib.pyplot as plt
import numpy as np

import semiwear as sw

COARSE = {"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.harmonics": 3}
scene = sw.load_scene("face_gear_25x160").replace(COARSE | {"wear.until.control_depths_um": [30]})
fields = {
    "wear.coefficient_mm2_per_N": sw.usual_wear_coefficient(scene),
    "operation.pinion_torque_Nm": sw.Normal(1600.0, 80.0, low=1.0),
}
found = sw.scatter(scene, fields, samples=32, crew=0)
b10 = found.quantile("meshes", 0.1)
print(f"B10: {b10.value:.3g} meshes, 95 % interval {b10.low:.3g} to {b10.high:.3g}")

# %%
# Lives from the shortest to the longest, and B10, the one that nine of ten reach. Most of the scatter is that of the
# wear coefficient, which costs no run of its own: wear knows it only times the number of meshes.
lives = np.sort(found.values("meshes"))
figure, ax = plt.subplots(layout="constrained")
ax.step(lives, np.arange(1, lives.size + 1) / lives.size, where="post")
ax.axvline(b10.value, color="grey", linestyle="--", label="B10")
ax.set(xlabel="meshes of a gear tooth until 30 um", ylabel="share of the pairs worn so far", xscale="log")
ax.legend()
