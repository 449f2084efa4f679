"""
Tip relief against pressed edges
================================

Loaded teeth bend, so that the next pair meets too early and its tip edge digs into the mate's root. Tip relief takes
the edge out of the way. How much is enough?
"""

import matplotlib.pyplot as plt
import numpy as np

import semiwear as sw

COARSE = {"numerics.face_slices": 15, "numerics.roll_positions": 24, "numerics.harmonics": 5, "wear": None}
scene = sw.load_scene("spur_fzg_c").replace(COARSE)
reliefs = np.arange(0.0, 73.0, 12.0)  # um

share, amplitude = [], []
for relief in reliefs:
    both = {f"effects.modification.{body}.tip_relief_um": relief for body in ("pinion", "gear")}
    contact = sw.loaded_contact(scene.replace(both))
    share.append(float(contact["engagement"].tip_load_share.sum("body").max()))
    error = contact["mesh_cycle"].transmission_error_loaded
    amplitude.append(float(error.max() - error.min()))

# %%
# Where the upper curve reaches zero no edge bears any more: that relief, and little more, is what the edges ask for.
figure, axes = plt.subplots(2, 1, sharex=True, layout="constrained")
axes[0].plot(reliefs, share, "o-")
axes[0].set(ylabel="greatest load share of slices\nwhose tip edge presses")
axes[1].plot(reliefs, amplitude, "s-", color="C1")
axes[1].set(xlabel="tip relief of both bodies [um]", ylabel="transmission error,\npeak to peak [arcsec]")
