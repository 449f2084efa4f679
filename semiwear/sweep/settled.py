"""Numerics of a scene with a requested accuracy, chosen once for many scenes that are compared."""

from __future__ import annotations

from semiwear.accuracy import simulate
from semiwear.scene import Scene
from semiwear.scene.load import parse_scene


def settled(scene: Scene) -> Scene:
    """The scene with the numerics chosen for its accuracy, in plain wear steps; unchanged without an accuracy.

    Raises
    ------
    SemiwearError
        The scene cannot be solved, or not to that accuracy.
    """
    if scene.numerics.accuracy is None:
        return scene
    chosen = parse_scene(simulate(scene).attrs["scene_toml"]).numerics
    names = [name for name in scene.numerics.chosen_for_accuracy if name != "wear_steps"] + ["peak_positions"]
    return scene.replace({f"numerics.{name}": getattr(chosen, name) for name in names} | {"numerics.accuracy": None})
