"""Kinds of gear pairs: the only list of them for scenes.

The flanks that belong to each kind are listed in `semiwear.meshing.pairs`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from semiwear.scene.cylindrical import CylindricalControlPoint, CylindricalPair
from semiwear.scene.flank_points import FlankPointsControlPoint, FlankPointsPair
from semiwear.scene.gear_pair import FaceGearPair
from semiwear.scene.tables import ControlPoint

GearPair: TypeAlias = FaceGearPair | CylindricalPair | FlankPointsPair
"""Table ``[gear_pair]`` of any kind.

Every kind has the class variables `pitch_surfaces` (names of the pair's, the pinion's and the gear's), `both_wear`
(whether both bodies wear by default) and `references`, and the property `description`.
"""

KINDS: Mapping[str, tuple[type[GearPair], type]] = {
    "face_gear": (FaceGearPair, ControlPoint),
    "cylindrical": (CylindricalPair, CylindricalControlPoint),
    "flank_points": (FlankPointsPair, FlankPointsControlPoint),
}
"""Classes of the tables ``[gear_pair]`` and ``[wear.control_point]`` by ``gear_pair.type``."""
