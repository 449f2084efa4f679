"""Limits of a scene that need tooth geometry; one module for each kind of gear pair.

`geometric_problems` is passed to `load_scene` and kept by the scene, so that these limits are reported together with
those of single fields in `semiwear.scene`.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module

from semiwear.errors import Problem, SceneError
from semiwear.scene import Scene

__all__ = ["KINDS", "geometric_problems"]

KINDS = ("face_gear", "cylindrical", "flank_points")
"""Kinds of gear pairs with a module of that name here, in it `<kind>_problems`, and a module `<kind>_margins`.

A kind without them has only the limits of its fields. The modules are imported when the fields of a scene are valid,
since they need the geometry of flanks in mesh.
"""


def geometric_problems(scene: Scene) -> list[Problem]:
    """Problems of a scene's teeth.

    Parameters
    ----------
    scene : Scene
        A scene whose fields are within their ranges.

    Returns
    -------
    list of Problem
        Empty when the teeth can be cut and mesh without interference. A field is named at most once. Limits in
        messages are rounded to the safe side, so that they are accepted as values.
    """
    kind = scene.gear_pair.type
    problems: list[Problem] = []
    if kind in KINDS:
        problems += getattr(import_module(f"semiwear.check.{kind}"), f"{kind}_problems")(scene)
    if not problems and any(hasattr(table, "tip_relief_length_mm") for _, table in scene.effects.present()):
        problems += import_module("semiwear.check.reliefs").relief_problems(scene)  # needs teeth that can be cut
    return [*problems, *_deviation_problems(scene)]


def _deviation_problems(scene: Scene) -> Iterator[Problem]:
    """Problems of the files with deviations of flanks that a scene names."""
    for name, table in scene.effects.present():
        file = getattr(table, "file", None)
        if file is None:
            continue
        from semiwear.meshing.deviation_grid import read_deviation_grid  # few scenes name such a file

        try:
            read_deviation_grid(file, f"effects.{name}.file")
        except SceneError as error:
            yield from error.problems
