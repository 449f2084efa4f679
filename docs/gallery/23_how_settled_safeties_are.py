"""
How settled are safeties, and what do they cost?
================================================

The spur gears of :download:`rated_pair.toml <../../rated_pair.toml>` with all five failure modes, worn over their
life in more and more wear steps and on finer and finer grids. What one step says of a life, what one worn state says
by itself, and the processor time that the ratings take.
"""

import time

import numpy as np

import semiwear as sw

SCENE = sw.load_scene("../rated_pair.toml")
MODES = ("pitting", "bending", "micropitting", "scuffing", "flank_fracture")


def run(scene=SCENE, **numerics):
    """The pair, worn on a changed grid."""
    return sw.simulate(scene.replace({f"numerics.{name}": value for name, value in numerics.items()}))


def least(tree):
    """The least safety of each mode at the end of the run."""
    last = tree["ratings"].safety.isel(wear_step=-1).min("body")
    return np.array([float(last.sel(mode=mode)) for mode in MODES])


# %%
# The least safety of each mode, and the meshes until pitting, with 1 to 24 wear steps. One step tells a life roughly:
# it is what `semiwear screen` takes.
print("wear steps " + " ".join(f"{mode:>14}" for mode in MODES) + "  meshes until pitting")
worn = {steps: run(wear_steps=steps) for steps in (1, 3, 6, 12, 24)}
for steps, tree in worn.items():
    until = float(tree["ratings"].meshes_to_failure.sel(mode="pitting").min())
    print(f"{steps:10} " + " ".join(f"{safety:14.3f}" for safety in least(tree)) + f"  {until:.3g}")

# %%
# What twice as fine a grid changes, in per cent; the worn ridge at the pitch point settles slowest:
finer = {
    "roll positions and profile points": run(wear_steps=6, roll_positions=24, profile_points=161),
    "slices": run(wear_steps=6, face_slices=21),
}
for name, tree in finer.items():
    change = 100.0 * (least(tree) / least(worn[6]) - 1.0)
    print(f"{name:34}" + " ".join(f"{mode} {moved:+.1f}" for mode, moved in zip(MODES, change, strict=True)))

# %%
# One worn state does not know how it came about: rated by itself, all meshes count under its own contact. S_H of the
# state beside S_H of the run:
wear, meshes = worn[6]["flank"].wear_depth.isel(wear_step=-1), float(worn[6]["history"].meshes[-1])
state = sw.loaded_contact(SCENE, wear_depth=wear, meshes=meshes)["ratings"].safety.sel(mode="pitting").squeeze()
over_life = worn[6]["ratings"].safety.sel(mode="pitting").isel(wear_step=-1)
for body in ("pinion", "gear"):
    alone, of_run = float(state.sel(body=body)), float(over_life.sel(body=body))
    print(f"{body:6} {alone:.3f}, over the life {of_run:.3f}: {100.0 * (alone / of_run - 1.0):+.1f} %")


# %%
# The processor time that ratings add to a run at the usual resolution with three wear steps: the least of three runs
# with and three without them, in turns. It scatters by some per cent on a busy machine.
def seconds(scene):
    """Processor time of a run."""
    start = time.process_time()
    sw.simulate(scene)
    return time.process_time() - start


usual = {"numerics.face_slices": None, "numerics.roll_positions": None}
usual |= {"numerics.profile_points": None, "numerics.harmonics": None, "numerics.wear_steps": 3}
usual = SCENE.replace(usual)
few = usual.replace({f"effects.{mode}": None for mode in MODES[2:]})
none = few.replace({f"effects.{mode}": None for mode in MODES[:2]})
spent = np.array([[seconds(scene) for scene in (none, few, usual)] for _ in range(3)]).min(axis=0)
for name, own in zip(("pitting and bending", "all five modes"), spent[1:], strict=True):
    print(f"{name}: {100.0 * (own / spent[0] - 1.0):.0f} % of {spent[0]:.1f} s")
