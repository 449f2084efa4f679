"""Scenes as users load them: their fields and the geometry of their teeth checked together."""

from __future__ import annotations

import os

from semiwear.check import geometric_problems
from semiwear.scene import Scene
from semiwear.scene import load_scene as load_unchecked

__all__ = ["load_scene"]


def load_scene(name_or_path: str | os.PathLike[str]) -> Scene:
    """A scene by its shipped name or from a TOML file, checked: ranges and geometric limits together.

    Raises
    ------
    SceneError
        With every problem at once.
    """
    return load_unchecked(name_or_path, check=geometric_problems)
