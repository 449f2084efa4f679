"""Results for other tools: worn flanks and teeth, tables, mesh stiffness, meshes for finite-element codes.

>>> sw.export(tree, "worn.vtu")                                    # the worn flank, for ParaView or PyVista
>>> sw.export(tree, "tooth.stl", part="tooth")                     # a whole worn tooth
>>> sw.export(tree, "history.csv"); sw.export(tree, "worn.xlsx")   # tables
>>> sw.export(tree, "gear.inp", body="gear")                       # CalculiX and Abaqus, under the contact's own load
>>> stiffness = sw.mesh_stiffness(tree)                            # over mesh position and wear step
"""

from semiwear.export.flank_points import export_flank
from semiwear.export.flank_surface import in_zone, worn_flank
from semiwear.export.frames import to_frame
from semiwear.export.stiffness import mesh_stiffness, stiffness_over_angle
from semiwear.export.whole_teeth import worn_tooth
from semiwear.export.write import export

__all__ = [
    "export",
    "export_flank",
    "in_zone",
    "mesh_stiffness",
    "stiffness_over_angle",
    "to_frame",
    "worn_flank",
    "worn_tooth",
]
