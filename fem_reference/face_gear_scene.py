"""The table of a face gear pair, for the parts that take no other kind."""

from __future__ import annotations

from semiwear.errors import SceneError
from semiwear.scene import FaceGearPair, Scene


def face_gear_pair(scene: Scene) -> FaceGearPair:
    """The scene's table ``[gear_pair]``.

    Raises
    ------
    SceneError
        For another kind of gear pair than a face gear.
    """
    pair = scene.gear_pair
    if not isinstance(pair, FaceGearPair):
        raise SceneError.of(
            "gear_pair.type",
            pair.type,
            '"face_gear"',
            "this part of the finite elements takes face gears only; loaded_contact takes cylindrical pairs too",
        )
    return pair
