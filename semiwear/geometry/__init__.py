"""Tooth flanks, fillets and sections, a module for each kind of gear; independent of load.

Flanks as functions of plain arrays: `involute`, `face_gear_flank`.
"""

from semiwear.geometry.face_gear import FaceGearTooth, face_gear_flank
from semiwear.geometry.involute import InvoluteTooth, involute, involute_function

__all__ = ["FaceGearTooth", "InvoluteTooth", "face_gear_flank", "involute", "involute_function"]
