"""
A worn spur pair, flank by flank
================================

Both flanks of the shipped spur pair after its life, as maps, and what wear does to the greatest depth of each body.
"""

import matplotlib.pyplot as plt

import semiwear as sw

COARSE = {"numerics.face_slices": 15, "numerics.roll_positions": 16, "numerics.harmonics": 5}
scene = sw.load_scene("spur_fzg_c").replace(COARSE | {"numerics.wear_steps": 4})
tree = sw.simulate(scene)

# %%
# Wear is none where the flanks roll on each other, at the pitch cylinder, and greatest at the root of each body:
# there its own surface is slow and is rubbed for longer.
figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
for body, ax in zip(("pinion", "gear"), axes, strict=True):
    sw.plot.wear_map(tree, ax=ax, body=body)

# %%
# The pinion has fewer teeth, so that each of them meets more often: it wears deeper.
print(tree["history"].to_dataset().wear_depth_max.to_pandas().round(2))
