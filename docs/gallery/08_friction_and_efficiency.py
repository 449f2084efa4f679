"""
Friction and the efficiency of the mesh
=======================================

Friction takes power where the flanks slide, and changes the loads through the balance of torques. Both follow from
one table.
"""

import matplotlib.pyplot as plt

import semiwear as sw

COARSE = {"numerics.face_slices": 11, "numerics.roll_positions": 24, "numerics.harmonics": 5}
scene = sw.load_scene("spur_fzg_c").replace(
    COARSE | {"operation.pinion_speed_rpm": 1500.0, "wear.until.meshes": 1e6, "numerics.wear_steps": 1}
)

figure, ax = plt.subplots(layout="constrained")
for table in ({"coefficient": 0.03}, {"coefficient": 0.06}, {"law": "iso_14179", "viscosity_mPas": 15.0}):
    tree = sw.simulate(scene.replace({"effects.friction": table}))
    loss = tree["engagement"].friction_power_loss.isel(wear_step=0)
    efficiency = float(tree["history"].mesh_efficiency[0])
    name = table.get("law", f"mu = {table.get('coefficient')}")
    ax.plot(loss.roll_position, loss, label=f"{name}: efficiency {100 * efficiency:.2f} %")
ax.set(xlabel="roll position [base pitches]", ylabel="power loss of a tooth pair [W]")
ax.legend()
