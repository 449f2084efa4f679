"""From a scene's gear pair to its flanks in mesh: the one place that knows which kinds there are."""

from __future__ import annotations

from dataclasses import replace

from semiwear.meshing.cylindrical_pair import CylindricalMesh
from semiwear.meshing.face_gear_pair import FaceGearMesh
from semiwear.meshing.flank_pair import FlankPair
from semiwear.scene import CylindricalPair, FaceGearPair, Placement

__all__ = ["GearPair", "flank_pair", "on_loaded_flank"]

GearPair = FaceGearPair | CylindricalPair


def flank_pair(table: GearPair, placement: Placement) -> FlankPair:
    """The two flanks in mesh."""
    if isinstance(table, CylindricalPair):
        return CylindricalMesh(table, placement)
    return FaceGearMesh(table, placement)


def on_loaded_flank(table: GearPair, placement: Placement, loaded_flank: str) -> tuple[GearPair, Placement]:
    """The pair and placement whose drive flank is, in a mirror at x = 0, the loaded one of these.

    The coast flank is the drive flank in that mirror: what turns the placement is mirrored instead, and a helix.
    """
    if loaded_flank == "drive":
        return table, placement
    if isinstance(table, CylindricalPair):
        table = replace(table, hand="left" if table.hand == "right" else "right")
    mirrored = replace(placement, offset_mm=-placement.offset_mm, pinion_slope_mrad=-placement.pinion_slope_mrad)
    return table, mirrored
