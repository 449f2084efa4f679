"""Numbers of a scene that asks for an accuracy, chosen once for many scenes that are compared."""

from __future__ import annotations

from semiwear.accuracy import simulate
from semiwear.scene import Scene
from semiwear.scene.load import parse_scene

__all__ = ["settled"]


def settled(scene: Scene) -> Scene:
    """The scene with the numbers that its accuracy takes, in plain wear steps; one without an accuracy as it is.

    Raises
    ------
    SemiwearError
        The scene cannot be solved, or not as accurately.
    """
    if scene.numerics.accuracy is None:
        return scene
    chosen = parse_scene(simulate(scene).attrs["scene_toml"]).numerics
    names = [name for name in scene.numerics.chosen_for_accuracy if name != "wear_steps"] + ["peak_positions"]
    return scene.replace({f"numerics.{name}": getattr(chosen, name) for name in names} | {"numerics.accuracy": None})
