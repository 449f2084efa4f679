"""Scenes: all inputs of a simulation, as frozen dataclasses that are read from and written to TOML.

All problems of a scene are reported together in `SceneError.problems`.
"""

from semiwear.scene.cylindrical import CylindricalControlPoint, CylindricalPair
from semiwear.scene.effects import EFFECTS, Effects, EffectTable
from semiwear.scene.external import scene_files
from semiwear.scene.flank_points import FlankPointsControlPoint, FlankPointsPair
from semiwear.scene.gear_pair import FaceGearPair
from semiwear.scene.kinds import GearPair
from semiwear.scene.load import load_scene, parse_scene, shipped_scenes
from semiwear.scene.placement import Placement
from semiwear.scene.rules import BodyCoefficients, BodyData
from semiwear.scene.scene import Check, Scene, scene_from_dict
from semiwear.scene.tables import ControlPoint, Material, Materials, Numerics, Operation, Wear, WearUntil

__all__ = [
    "EFFECTS",
    "BodyCoefficients",
    "BodyData",
    "Check",
    "ControlPoint",
    "CylindricalControlPoint",
    "CylindricalPair",
    "EffectTable",
    "Effects",
    "FaceGearPair",
    "FlankPointsControlPoint",
    "FlankPointsPair",
    "GearPair",
    "Material",
    "Materials",
    "Numerics",
    "Operation",
    "Placement",
    "Scene",
    "Wear",
    "WearUntil",
    "load_scene",
    "parse_scene",
    "scene_files",
    "scene_from_dict",
    "shipped_scenes",
]
