"""
Why wear steps are implicit
===========================

An explicit wear step takes the pressures at its beginning for the whole of it. Where it wears more than the contact
gives way, the next step presses elsewhere, and the flank becomes rough. Implicit steps of the same length do not.
"""

import matplotlib.pyplot as plt

import semiwear as sw

COARSE = {"numerics.face_slices": 15, "numerics.roll_positions": 12, "numerics.harmonics": 5}
scene = sw.load_scene("face_gear_25x160").replace(
    COARSE
    | {
        "wear.until.control_depths_um": None,
        "wear.until.meshes": 8e9,
        "wear.control_point": None,
        "numerics.wear_steps": 6,
    }
)

figure, ax = plt.subplots(layout="constrained")
for scheme in ("implicit", "two-stage", "explicit"):
    tree = sw.simulate(scene.replace({"numerics.wear_scheme": scheme}))
    history = tree["history"].to_dataset()
    ax.plot(history.meshes, history.wear_depth_max.sel(body="gear"), "o-", label=scheme)
ax.set(xlabel="meshes of a gear tooth", ylabel="greatest wear of the gear [um]", yscale="log")
ax.legend()
