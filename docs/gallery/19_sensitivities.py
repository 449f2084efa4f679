"""
What does wear hang on?
=======================

Derivatives of wear and root stress with respect to fields of the scene, in relative terms: 1 means that one per cent
more of the field is one per cent more of the quantity.
"""

import matplotlib.pyplot as plt

import semiwear as sw

COARSE = {"numerics.face_slices": 11, "numerics.roll_positions": 10, "numerics.harmonics": 3}
scene = sw.load_scene("spur_fzg_c").replace(COARSE | {"wear.until.meshes": 2e7, "numerics.wear_steps": 1})
fields = ["operation.pinion_torque_Nm", "wear.coefficient_mm2_per_N", "gear_pair.pinion_face_width_mm"]
slopes = sw.sensitivities(scene, ["wear_depth_max", "root_stress_max[pinion]"], fields, workers=0)

relative = slopes.relative.to_pandas()
print(relative.round(2))
figure, ax = plt.subplots(figsize=(7, 3), layout="constrained")
relative.T.plot.barh(ax=ax)
ax.set(xlabel="relative change of the quantity over that of the field", ylabel="")
