"""Limits of a scene that need tooth geometry; one file a kind of gear pair.

`geometric_problems` is passed to `load_scene` and stays with the scene, so that these limits and the plain ones of
`semiwear.scene` are reported at once.
"""

from __future__ import annotations

from collections.abc import Callable

from semiwear.check.cylindrical import cylindrical_problems
from semiwear.check.face_gear import face_gear_problems
from semiwear.check.flank_points import flank_points_problems
from semiwear.errors import Problem
from semiwear.scene import Scene

__all__ = ["geometric_problems"]

# by kind of gear pair; one that is not listed has no limits but those of its fields
_LIMITS: dict[str, Callable[[Scene], list[Problem]]] = {
    "face_gear": face_gear_problems,
    "cylindrical": cylindrical_problems,
    "flank_points": flank_points_problems,
}


def geometric_problems(scene: Scene) -> list[Problem]:
    """Problems of a scene's teeth.

    Parameters
    ----------
    scene : Scene
        A scene whose fields are each in their own range.

    Returns
    -------
    list of Problem
        Empty when the teeth can be cut and mesh without interference. A field is named once at most. The
        numbers in a message are rounded to the safe side: such a limit, typed in, is accepted.
    """
    limits = _LIMITS.get(scene.gear_pair.type)
    return limits(scene) if limits is not None else []
