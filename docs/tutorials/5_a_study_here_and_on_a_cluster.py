"""
A study on two cores, and on a cluster
======================================

Which torque, which misalignment? A sweep solves one scene with some fields varied and gives one labelled dataset. It
runs on the cores of this machine or on a Dask cluster, with the same call and the same numbers.
"""

import tempfile
from pathlib import Path

import numpy as np
from distributed import Client

import semiwear as sw

# %%
# Coarse grids for this page.
scene = sw.load_scene("face_gear_25x160").replace(
    {
        "numerics.face_slices": 11,
        "numerics.roll_positions": 8,
        "numerics.harmonics": 3,
        "wear.until.control_depths_um": [20, 40],
    }
)
vary = {
    "operation.pinion_torque_Nm": np.linspace(600, 1800, 5),
    "effects.misalignment.offset_mm": [-0.05, 0.0, 0.05],
}

# %%
# On two cores
# ------------
#
# Two processes solve the scenes, each on one thread; every scene is kept in ``store`` as soon as it is solved.
store = Path(tempfile.mkdtemp(), "store")
found = sw.sweep(scene, vary, workers=2, store=store)
print(found.root_stress_max.isel(wear_step=-1).sel(body="pinion").to_pandas().round(1))

# %%
# Curves over the torque, one for each offset.
sw.plot.sweep_curves(found, "root_stress_max", body="pinion")

# %%
# More torques later: only the new scenes are solved.
more = sw.sweep(scene, vary | {"operation.pinion_torque_Nm": np.linspace(600, 1800, 7)}, workers=2, store=store)
print(dict(more.sizes))

# %%
# On a cluster
# ------------
#
# Give the address of a Dask scheduler; here a cluster of one worker is started on this machine.
with Client(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as client:
    there = sw.sweep(scene, vary, client=client)
print("the same to the last bit:", bool((there.root_stress_max == found.root_stress_max).all()))

# %%
# On a cluster with a batch system, workers start as jobs (``srun``, ``qsub``, or the package dask-jobqueue)::
#
#     dask scheduler --scheduler-file scheduler.json &
#     srun -n 64 dask worker --scheduler-file scheduler.json --nthreads 1
#     semiwear sweep study.toml -o study.nc --scheduler tcp://ADDRESS:8786
