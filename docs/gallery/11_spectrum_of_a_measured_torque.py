"""
A measured torque becomes a load spectrum
=========================================

Torque over time, as a drive records it, in levels with their shares of all meshes.
"""

import matplotlib.pyplot as plt
import numpy as np

import semiwear as sw

seconds = np.linspace(0.0, 600.0, 6001)
random = np.random.default_rng(1)
torque = 220.0 + 90.0 * np.sin(0.05 * seconds) + 25.0 * random.standard_normal(seconds.size)
load = sw.measured_load(torque, time=seconds, speed=np.full(seconds.size, 1500.0))

COARSE = {"numerics.face_slices": 11, "numerics.roll_positions": 12, "numerics.harmonics": 5}
scene = sw.load_scene("spur_fzg_c").replace(COARSE | {"numerics.wear_steps": 2})
table = load.spectrum(levels=6)

# %%
# Six levels; their mean is that of the measurement.
figure, ax = plt.subplots(layout="constrained")
ax.bar(table["torques_Nm"], table["shares"], width=20.0)
ax.set(xlabel="torque on the pinion [N m]", ylabel="share of the meshes")

# %%
# The spectrum against one torque of the same mean.
mean = float(np.dot(table["torques_Nm"], table["shares"]))
for name, one in {
    "mean torque": scene.replace({"operation.pinion_torque_Nm": mean}),
    "spectrum": scene.replace({"effects.load_spectrum": table}),
}.items():
    depth = sw.simulate(one)["history"].wear_depth_max.isel(wear_step=-1)
    print(f"{name}: {', '.join(f'{body} {float(depth.sel(body=body)):.2f} um' for body in depth.body.values)}")
