"""Wear of a mesh, and the steps from one worn flank to the next.

Archard's law on plain arrays: `wear_depth`, and `wear_per_mesh` for a contact that passes over a flank.
"""

from semiwear.wear.archard import wear_depth, wear_per_mesh

__all__ = ["wear_depth", "wear_per_mesh"]
