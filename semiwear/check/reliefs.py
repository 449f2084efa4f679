"""Limits of the reliefs of modified flanks: none is longer than the flank."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from semiwear.check.limits import down
from semiwear.errors import Problem
from semiwear.meshing.pairs import flank_pair
from semiwear.scene import Placement, Scene

_STATIONS = 9  # along the face at which the length of the profile is evaluated


def relief_problems(scene: Scene) -> Iterator[Problem]:
    """Problems of reliefs that are longer than the flank."""
    given = {
        f"effects.{name}.{end}_relief_length_mm": (name, length)
        for name, table in scene.effects.present()
        for end in ("tip", "root")
        if (length := getattr(table, f"{end}_relief_length_mm", None)) is not None
    }
    if not given:
        return
    pair = flank_pair(scene.gear_pair, Placement())
    borders = pair.borders(np.linspace(*pair.face_limits, _STATIONS))
    longest = {
        "modification.pinion": float(borders.driving_tip - borders.driving_root),
        "modification.gear": float((borders.tip - borders.root).max()),
    }
    for field, (name, length) in given.items():
        if length > longest[name]:
            allowed = f"above 0, up to {down(longest[name])} mm, the length of the flank's profile"
            fix = "a length along the profile from its end; left out, a third of the flank"
            yield Problem(field, length, allowed, fix)
