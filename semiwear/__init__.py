"""Gear tooth wear: a fast semi-analytical core.

>>> import semiwear as sw
>>> scene = sw.load_scene("face_gear_25x160")
>>> print(sw.plan(scene))                     # what will run, what will not, and why
>>> tree = sw.simulate(scene)                 # a labelled DataTree
>>> sw.save(tree, "worn.nc"); sw.report(tree, "worn.html")
"""

from __future__ import annotations

import os
from importlib import metadata
from typing import TYPE_CHECKING, Any

# the cache comes first: what follows declares kernels
from semiwear import kernel_cache, plot  # noqa: F401
from semiwear.accuracy import simulate
from semiwear.analyses import loaded_contact, tooth_contact_analysis
from semiwear.check import geometric_problems
from semiwear.errors import ConvergenceError, MissingExtraError, ResultFileError, SceneError, SemiwearError
from semiwear.export import export_flank
from semiwear.plan import plan
from semiwear.report import write_report as report
from semiwear.results import open_results, save
from semiwear.scene import Placement, Scene, shipped_scenes
from semiwear.scene import load_scene as _load_scene
from semiwear.screen import screen

if TYPE_CHECKING:
    from semiwear.measured import calibrate, compare_wear, measured_wear, register

__all__ = [
    "ConvergenceError",
    "MissingExtraError",
    "Placement",
    "ResultFileError",
    "Scene",
    "SceneError",
    "SemiwearError",
    "calibrate",
    "compare_wear",
    "export_flank",
    "load_scene",
    "loaded_contact",
    "measured_wear",
    "open_results",
    "plan",
    "plot",
    "register",
    "report",
    "save",
    "screen",
    "shipped_scenes",
    "simulate",
    "tooth_contact_analysis",
]

try:
    __version__ = metadata.version("semiwear")
except metadata.PackageNotFoundError:
    __version__ = "unknown"


def __getattr__(name: str) -> Any:
    """Functions of measured flanks, loaded when they are asked for."""
    if name in ("calibrate", "compare_wear", "measured_wear", "register"):
        from semiwear import measured

        return getattr(measured, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def load_scene(name_or_path: str | os.PathLike[str]) -> Scene:
    """A scene by its shipped name or from a TOML file, checked: ranges and geometric limits together.

    Raises
    ------
    SceneError
        With every problem at once.
    """
    return _load_scene(name_or_path, check=geometric_problems)
