"""
The face gear of the paper
==========================

A face gear pair of 25 and 160 teeth ships with semiwear. It follows a published finite-element wear run, whose
figures a report sets beside ours. This tutorial loads it, sees what will run, wears it, and reads the answer.
"""

import semiwear as sw

scene = sw.load_scene("face_gear_25x160")
print(scene.gear_pair.description)

# %%
# Coarse grids for this page; leave this out for numbers to rely on.
scene = scene.replace({"numerics.face_slices": 31, "numerics.roll_positions": 16, "numerics.harmonics": 9})
scene = scene.replace({"wear.until.control_depths_um": [10, 20, 30, 40, 50, 60]})

# %%
# What will run, and why
# ----------------------
#
# A plan states which models a scene asks for before anything is computed. An effect runs if its table is there.
print(sw.plan(scene))

# %%
# Unloaded contact
# ----------------
#
# The pinion has fewer teeth than the shaper that generated the gear, so that the flanks touch at a point, which moves
# along the path of contact. Limits of the face are known in closed form.
unloaded = sw.tooth_contact_analysis(scene)
for name in ("contact_ratio", "undercut_radius", "pointing_radius"):
    unit = unloaded[name].attrs["units"].replace("1", "")
    print(f"{unloaded[name].attrs['long_name']}: {float(unloaded[name]):.2f} {unit}")

# %%
# Under load the point becomes a long ellipse, and several pairs share the torque.
contact = sw.loaded_contact(scene)
sw.plot.contact_pressure_over_engagement(contact)

# %%
# Wear
# ----
#
# The run ends where the control point is worn by the last depth. Every step is implicit, so that six of them reach
# it.
tree = sw.simulate(scene)
sw.plot.wear_map(tree)

# %%
# Along the pitch cone nothing slides, and a ridge remains. Root and addendum wear about equally deep.
sw.plot.wear_profiles(tree)

# %%
# What wear does to the pair: pressure rises on the ridge that is left at the pitch line and falls beside it.
sw.plot.contact_stress_history(tree)

# %%
# The same in numbers; the amplitude of the transmission error is its peak-to-peak value.
history = tree["history"].to_dataset()
names = ["wear_depth_max_root", "contact_pressure_pitch", "load_share_max", "transmission_error_amplitude"]
print(history[names].to_pandas().round(3).to_string())

# %%
# Keep it, and write the page
# ---------------------------
#
# A result is one netCDF file; the report is one page that needs nothing but itself.
import tempfile
from pathlib import Path

folder = Path(tempfile.mkdtemp())
sw.save(tree, folder / "worn.nc")
sw.report(tree, folder / "worn.html")
print(sorted(path.name for path in folder.iterdir()))

# %%
# The sources of the physics that ran are in the result, ready to be cited.
print(tree.attrs["references"])
