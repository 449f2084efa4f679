"""
Load sharing as wear goes on
============================

Wear takes most where a pair slides most, at both ends of its path of contact. There the pair then bears less, and its
neighbours more.
"""

import semiwear as sw

COARSE = {"numerics.face_slices": 15, "numerics.roll_positions": 16, "numerics.harmonics": 5}
scene = sw.load_scene("face_gear_25x160").replace(COARSE | {"wear.until.control_depths_um": [20, 40, 60]})
tree = sw.simulate(scene)

# %%
# Curves of single wear steps, and the greatest share of all.
sw.plot.load_share(tree)
print(tree["history"].to_dataset().load_share_max.to_pandas().round(3))

# %%
# The transmission error feels the same: the gear lags more the deeper the flanks are worn.
sw.plot.transmission_error_curves(tree)
