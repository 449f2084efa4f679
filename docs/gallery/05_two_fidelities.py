"""
Lines or patches
================

Fidelity ``line`` puts Hertz's pressure across a line load; ``patch`` resolves the pressure in two dimensions. On a
clean flank they agree; ``patch`` also has the contact pattern, and the stress below the surface.
"""

import matplotlib.pyplot as plt

import semiwear as sw

COARSE = {"numerics.face_slices": 21, "numerics.roll_positions": 12, "numerics.cells_per_half_width": 4}
scene = sw.load_scene("face_gear_25x160").replace(COARSE | {"numerics.harmonics": 9, "wear": None})
both = {name: sw.loaded_contact(scene.replace({"numerics.fidelity": name})) for name in ("line", "patch")}

# %%
figure, ax = plt.subplots(layout="constrained")
for name, contact in both.items():
    part = contact["engagement"].to_dataset().isel(wear_step=0)
    clear = part.contact_pressure_max.where(part.contact_pressure_on_edge == 0)
    ax.plot(part.roll_position, clear, "o-" if name == "line" else "x--", label=name)
ax.set(xlabel="roll position [base pitches]", ylabel="greatest pressure away from edges [MPa]")
ax.legend()
