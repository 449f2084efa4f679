"""
Flanks from points
==================

Any flank can be given as a grid of points: from a measuring machine, or from another program. Here the shipped spur
pair is written as points and read back; both give the same contact.
"""

import tempfile
from pathlib import Path

import semiwear as sw
from semiwear.scene.guide import new_scene

COARSE = {"numerics.face_slices": 11, "numerics.roll_positions": 12, "numerics.harmonics": 5, "wear": None}
spur = sw.load_scene("spur_fzg_c").replace(COARSE)

folder = Path(tempfile.mkdtemp())
for body in ("pinion", "gear"):
    sw.export_flank(spur, body, folder / f"{body}.nc", points=(61, 21))
(folder / "points.toml").write_text(new_scene("flank_points", str(folder)), encoding="utf-8")
points = sw.load_scene(folder / "points.toml").replace(COARSE)
print(sw.plan(points))

# %%
# Load shares of both.
for name, scene in {"formulas": spur, "points": points}.items():
    share = sw.loaded_contact(scene)["engagement"].load_share.isel(wear_step=0)
    print(name, share.sel(roll_position=[-0.5, 0.0, 0.5], method="nearest").values.round(3))
