"""
Relief against wear
===================

Where a tip edge digs into its mate's root, the first micrometres wear off quickly. How much tip relief is best?
First by hand, then by ``sw.optimise``.
"""

import matplotlib.pyplot as plt
import numpy as np

import semiwear as sw

# %%
# Coarse grids for this page.
scene = sw.load_scene("spur_fzg_c").replace(
    {
        "numerics.face_slices": 11,
        "numerics.roll_positions": 16,
        "numerics.harmonics": 5,
        "numerics.wear_steps": 2,
        "wear.until.meshes": 2e7,
    }
)


def with_relief(um):
    """The scene with the same tip relief on both bodies."""
    return scene.replace({f"effects.modification.{body}.tip_relief_um": um for body in ("pinion", "gear")})


# %%
# By hand
# -------
#
# Greatest wear and transmission error of a few reliefs.
reliefs = np.arange(0.0, 51.0, 12.5)
histories = [sw.simulate(with_relief(um))["history"].to_dataset().isel(wear_step=-1) for um in reliefs]

figure, axes = plt.subplots(2, 1, sharex=True, layout="constrained")
for body in ("pinion", "gear"):
    axes[0].plot(reliefs, [float(one.wear_depth_max.sel(body=body)) for one in histories], "o-", label=body)
axes[0].set(ylabel="greatest wear [um]")
axes[0].legend()
axes[1].plot(reliefs, [float(one.transmission_error_amplitude) for one in histories], "s-", color="C2")
axes[1].set(xlabel="tip relief of both bodies [um]", ylabel="transmission error,\npeak to peak [arcsec]")

# %%
# By search
# ---------
#
# Relief of either body, least wear, and a limit on the transmission error. The search is cut short for this page.
limit = 1.1 * min(float(one.transmission_error_amplitude) for one in histories)
best = sw.optimise(
    scene,
    vary={f"effects.modification.{body}.tip_relief_um": (0, 50) for body in ("pinion", "gear")},
    minimise="wear_depth_max",
    subject_to={"transmission_error_amplitude": f"<= {limit:.1f}"},
    most=8,
    workers=0,
)
print(best)

# %%
# The best design is a scene like any other: ``best.scene.to_toml()`` writes it.
print(best.scene.to_toml().partition("[effects")[2])
