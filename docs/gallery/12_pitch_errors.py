"""
Teeth that are not in their place
=================================

A tooth that stands forward of its place takes over the load of its neighbours: for some micrometres a single pair
bears what two should share.
"""

import matplotlib.pyplot as plt
import numpy as np

import semiwear as sw

COARSE = {"numerics.face_slices": 11, "numerics.roll_positions": 12, "numerics.harmonics": 5}
scene = sw.load_scene("face_gear_25x160").replace(COARSE | {"wear": None})

deviations = np.array([0.0, 3.0, 6.0, 10.0, 15.0])
share = []
for um in deviations:
    table = {"effects.pitch_error": {"pinion_um": [0.0, um]}} if um else {}
    share.append(float(sw.loaded_contact(scene.replace(table))["engagement"].load_share.max()))

figure, ax = plt.subplots(layout="constrained")
ax.plot(deviations, share, "o-")
ax.set(xlabel="deviation of every second pinion tooth [um]", ylabel="greatest load share of a tooth pair")
