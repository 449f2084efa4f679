"""Scenes as users load them: their fields and the geometry of their teeth checked together."""

from __future__ import annotations

import os

from semiwear.check import geometric_problems
from semiwear.scene import Scene
from semiwear.scene import load_scene as load_unchecked


def load_scene(name_or_path: str | os.PathLike[str]) -> Scene:
    """A scene by its shipped name or from a TOML file, checked: ranges and geometric limits together.

    Parameters
    ----------
    name_or_path : str or path
        A name from `shipped_scenes`, or the path of a TOML file.

    Raises
    ------
    SceneError
        With every problem at once.

    Examples
    --------
    >>> import semiwear as sw
    >>> scene = sw.load_scene("face_gear_25x160")
    >>> scene.gear_pair.pinion_teeth, scene.gear_pair.gear_teeth
    (25, 160)
    """
    return load_unchecked(name_or_path, check=geometric_problems)
