"""Cylindrical pairs from REXS files, the exchange standard of gear units.

>>> found = sw.read_rexs("gearbox.rexs", pinion_torque_Nm=300.0)
>>> print(found)                     # what was taken, and what has no counterpart in a scene
>>> tree = sw.simulate(found.scene)
"""

from semiwear.rexs.pair import RexsPair, read_rexs

__all__ = ["RexsPair", "read_rexs"]
