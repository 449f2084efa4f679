"""Cylindrical pairs from REXS files, the exchange format for gear units.

>>> found = sw.read_rexs("gearbox.rexs", pinion_torque_Nm=300.0)
>>> print(found)                     # fields that were taken, and attributes without a counterpart in a scene
>>> tree = sw.simulate(found.scene)
"""

from semiwear.rexs.pair import RexsPair, read_rexs

__all__ = ["RexsPair", "read_rexs"]
