"""Tooth flanks, fillets and sections; one file a kind of gear; no knowledge of load.

Flanks as functions of plain arrays: `involute`, `face_gear_flank`.
"""

from semiwear.geometry.face_gear import FaceGearTooth, face_gear_flank
from semiwear.geometry.involute import InvoluteTooth, involute, involute_function

__all__ = ["FaceGearTooth", "InvoluteTooth", "face_gear_flank", "involute", "involute_function"]
