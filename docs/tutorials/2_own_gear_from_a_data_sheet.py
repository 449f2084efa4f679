"""
Your own gear from a data sheet
===============================

A helical pair as a data sheet or a gear program describes it, made into a scene, checked, worn for some hours and
read. The table of :doc:`/how_to/drawing` says which word of a drawing becomes which field.
"""

import matplotlib.pyplot as plt

import semiwear as sw
from semiwear.scene import scene_from_dict

# %%
# The data sheet
# --------------
#
# Numbers of teeth 19 and 53, normal module 3 mm, pressure angle 20 degrees, helix angle 12 degrees, centre distance
# 112 mm, profile shift coefficients 0.35 and 0.19, face width 32 mm; steel, 180 N m at 1450 rev/min on the pinion.
# Tips, fillets and rims are left out and follow from these.
sheet = {
    "gear_pair": {
        "type": "cylindrical",
        "pinion_teeth": 19,
        "gear_teeth": 53,
        "normal_module_mm": 3.0,
        "pressure_angle_deg": 20.0,
        "helix_angle_deg": 12.0,
        "centre_distance_mm": 112.0,
        "pinion_profile_shift": 0.35,
        "gear_profile_shift": 0.19,
        "pinion_face_width_mm": 32.0,
    },
    "operation": {"pinion_torque_Nm": 180.0, "pinion_speed_rpm": 1450.0},
    "wear": {"coefficient_mm2_per_N": 5e-14, "until": {"meshes": 1.5e8}},
    "effects": {"free_edges": {}, "run_life": {"depth_limit_um": 50.0, "body": "pinion"}},
    # coarse, for this page
    "numerics": {"face_slices": 15, "roll_positions": 12, "harmonics": 5, "wear_steps": 3},
}
scene = scene_from_dict(sheet)
print(scene.to_toml().partition("[material")[0])

# %%
# A mistake is reported with its field, the allowed values and the likely remedy; all mistakes at once.
try:
    scene_from_dict(sheet | {"gear_pair": sheet["gear_pair"] | {"normal_module_mm": -3.0, "pinion_teeth": 3}})
except sw.SceneError as error:
    print(error)

# %%
# A file of the same kind comes from ``semiwear new cylindrical -o my_pair.toml``, and `sw.load_scene` reads it.
#
# Hours and meshes
# ----------------
#
# Meshes count the engagements of one gear tooth. Each turn of the pinion takes a gear tooth to the mesh z1/z2 times.
teeth = scene.gear_pair
per_hour = 60.0 * scene.operation.pinion_speed_rpm * teeth.pinion_teeth / teeth.gear_teeth
print(f"{scene.wear.until.meshes / per_hour:.0f} h at {scene.operation.pinion_speed_rpm:g} rev/min")

# %%
# Wear it
# -------
tree = sw.simulate(scene)
figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
for body, ax in zip(("pinion", "gear"), axes, strict=True):
    sw.plot.wear_map(tree, ax=ax, body=body)

# %%
# Life: until 50 um are worn off anywhere on the pinion, and its sensitivity to torque and wear coefficient.
life = tree["life"].to_dataset()
for value in life.data_vars.values():
    unit = value.attrs["units"].replace("1", "")
    print(f"{value.attrs['long_name']}: {float(value):.4g} {unit}")

# %%
# How sure is it?
# ---------------
#
# The wear coefficient is seldom known better than to a factor of two, and wear is as uncertain as that. The result
# states the error of the numerics: run it with ``numerics.accuracy = 0.03``, read ``/diagnostics/error_estimate``.
print(sw.plan(scene.replace({"numerics": {"accuracy": 0.03}})))
