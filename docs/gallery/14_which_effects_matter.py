"""
Which effects matter for this pair?
===================================

Before a scene is made complicated: what would each effect change, and what would it cost? ``sw.screen`` tries them
all on one mesh cycle.
"""

import semiwear as sw

COARSE = {"numerics.face_slices": 11, "numerics.roll_positions": 12, "numerics.harmonics": 5}
scene = sw.load_scene("spur_fzg_c").replace(COARSE | {"wear.until.meshes": 1e7, "numerics.wear_steps": 1})
print(sw.screen(scene))
