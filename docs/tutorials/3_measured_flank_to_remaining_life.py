"""
From a measured flank to the remaining life
===========================================

A gear came back from the test bench and its flank was measured. How fast does it wear, and how long will others last?
Here the measurement is made by the computer, from a wear coefficient that the calibration is not told; with a
machine's file, give its name.
"""

import matplotlib.pyplot as plt
import numpy as np

import semiwear as sw

# %%
# Coarse grids for this page, and one body that wears.
scene = sw.load_scene("spur_fzg_c").replace(
    {
        "numerics.face_slices": 15,
        "numerics.roll_positions": 12,
        "numerics.harmonics": 5,
        "numerics.wear_steps": 3,
        "wear.worn_bodies": ["gear"],
        "effects.run_life": {"depth_limit_um": 50.0, "body": "gear"},
    }
)

# %%
# The measurement
# ---------------
#
# The gear of this test has worn with a coefficient of its own for 1e8 meshes. Points of the flank come with noise of
# a third of a micrometre, as a coordinate measuring machine gives them.
import tempfile
from pathlib import Path

import xarray as xr

truth = 1.6e-13
bench = sw.simulate(scene.replace({"wear.coefficient_mm2_per_N": truth, "wear.until.meshes": 1e8}))
folder = Path(tempfile.mkdtemp())
sw.export_flank(scene, "gear", folder / "new.nc", points=(41, 15))
sw.export_flank(scene, "gear", folder / "worn.nc", points=(41, 15), worn=bench)
with xr.open_dataset(folder / "worn.nc") as file:
    points, normals = file["points"].values, file["normals"].values
noise = 3e-4 * np.random.default_rng(7).standard_normal(points.shape[:2])
measured = points + noise[..., None] * normals

# %%
# Deviations from the nominal flank
# ---------------------------------
#
# The datum of the machine is not that of the gear: rotation and shift are fitted to the points that wear has left
# highest, which needs unworn parts of the flank. Hardly any is unworn here, so that a rotation remains, which the
# calibration below corrects.
deviations = sw.register(scene, measured, "gear")
print(f"rotation {float(deviations.rotation):.2f} arcsec, rest {float(deviations.residual_rms):.2f} um")

# %%
# The wear coefficient, with its confidence interval
# --------------------------------------------------
#
# The interval allows for the correlation of neighbouring residuals.
found = sw.calibrate(scene, measured, meshes=1e8)
print(found)

# %%
# Prediction with the coefficient that was found, measurement, and the difference.
sw.plot.measured_wear(found.comparison())
plt.gcf().set_size_inches(11, 4)

# %%
# Remaining life
# --------------
#
# Life until 50 um are worn off: of the measured part, as uncertain as the measurement, and of the next part, with an
# assumed scatter of the coefficient from part to part.
own = found.life(50.0, k_scatter=0.0)
print(own)
print(found.life(50.0))

# %%
# The meshes that the part has run already are part of its life.
print(f"meshes of a gear tooth: {1e8:.2e} so far, {own.median - 1e8:.2e} remain")
