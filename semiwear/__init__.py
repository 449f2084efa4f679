"""Gear tooth wear: a fast semi-analytical core.

>>> import semiwear as sw
>>> scene = sw.load_scene("face_gear_25x160")
>>> print(sw.plan(scene))                     # what will run, what will not, and why
>>> tree = sw.simulate(scene)                 # a labelled DataTree
>>> sw.save(tree, "worn.nc"); sw.report(tree, "worn.html")
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from semiwear import plot
    from semiwear.accuracy import simulate
    from semiwear.analyses import loaded_contact, tooth_contact_analysis
    from semiwear.check.margins import check_geometry
    from semiwear.citing import citations
    from semiwear.errors import (
        ConvergenceError,
        EndlessWearError,
        MissingExtraError,
        ResultFileError,
        SceneError,
        SemiwearError,
    )
    from semiwear.export import (
        export,
        export_flank,
        in_zone,
        mesh_stiffness,
        stiffness_over_angle,
        to_frame,
        worn_flank,
        worn_tooth,
    )
    from semiwear.inference import Reading, TransmissionErrorCurve, WearAtPoints, WornFlank, infer
    from semiwear.loading import load_scene
    from semiwear.measured import (
        calibrate,
        compare_wear,
        flank_from_points,
        flank_from_traces,
        measured_wear,
        read_traces,
        register,
    )
    from semiwear.measured_load import measured_load
    from semiwear.optimise import optimise
    from semiwear.plan import plan
    from semiwear.report import write_report as report
    from semiwear.results import open_results, save
    from semiwear.results.life_axis import life_in
    from semiwear.rexs import read_rexs
    from semiwear.scatter import (
        LogNormal,
        Normal,
        Scatter,
        Triangular,
        Uniform,
        scatter,
        usual_wear_coefficient,
    )
    from semiwear.scene import Placement, Scene, shipped_scenes
    from semiwear.screen import screen
    from semiwear.sensitivities import sensitivities
    from semiwear.sweep import sweep

__all__ = [
    "ConvergenceError",
    "EndlessWearError",
    "LogNormal",
    "MissingExtraError",
    "Normal",
    "Placement",
    "Reading",
    "ResultFileError",
    "Scatter",
    "Scene",
    "SceneError",
    "SemiwearError",
    "TransmissionErrorCurve",
    "Triangular",
    "Uniform",
    "WearAtPoints",
    "WornFlank",
    "calibrate",
    "check_geometry",
    "citations",
    "compare_wear",
    "export",
    "export_flank",
    "flank_from_points",
    "flank_from_traces",
    "in_zone",
    "infer",
    "life_in",
    "load_scene",
    "loaded_contact",
    "measured_load",
    "measured_wear",
    "mesh_stiffness",
    "open_results",
    "optimise",
    "plan",
    "plot",
    "read_rexs",
    "read_traces",
    "register",
    "report",
    "save",
    "scatter",
    "screen",
    "sensitivities",
    "shipped_scenes",
    "simulate",
    "stiffness_over_angle",
    "sweep",
    "to_frame",
    "tooth_contact_analysis",
    "usual_wear_coefficient",
    "worn_flank",
    "worn_tooth",
]

# Imported on first use (SPEC 1): reading a scene needs none of the compiled kernels.
_MODULES = {
    "accuracy": ("simulate",),
    "analyses": ("loaded_contact", "tooth_contact_analysis"),
    "check.margins": ("check_geometry",),
    "citing": ("citations",),
    "errors": (
        "ConvergenceError",
        "EndlessWearError",
        "MissingExtraError",
        "ResultFileError",
        "SceneError",
        "SemiwearError",
    ),
    "export": (
        "export",
        "export_flank",
        "in_zone",
        "mesh_stiffness",
        "stiffness_over_angle",
        "to_frame",
        "worn_flank",
        "worn_tooth",
    ),
    "inference": ("Reading", "TransmissionErrorCurve", "WearAtPoints", "WornFlank", "infer"),
    "loading": ("load_scene",),
    "measured": (
        "calibrate",
        "compare_wear",
        "flank_from_points",
        "flank_from_traces",
        "measured_wear",
        "read_traces",
        "register",
    ),
    "measured_load": ("measured_load",),
    "optimise": ("optimise",),
    "plan": ("plan",),
    "results.life_axis": ("life_in",),
    "results": ("open_results", "save"),
    "rexs": ("read_rexs",),
    "scatter": ("LogNormal", "Normal", "Scatter", "Triangular", "Uniform", "scatter", "usual_wear_coefficient"),
    "scene": ("Placement", "Scene", "shipped_scenes"),
    "screen": ("screen",),
    "sensitivities": ("sensitivities",),
    "sweep": ("sweep",),
}
_SOURCES = {name: (module, name) for module, names in _MODULES.items() for name in names}
_SOURCES["report"] = ("report", "write_report")
_PACKAGES = ("contact", "errors", "geometry", "measured", "plot", "references", "results", "scene", "wear")


def __getattr__(name: str) -> Any:  # the type depends on the name; a checker reads the imports above
    """Public functions and classes, imported on first use, and the version."""
    if name == "__version__":
        return _version()
    if name in _PACKAGES:
        return import_module(f"semiwear.{name}")
    if name not in _SOURCES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, own = _SOURCES[name]
    found = getattr(import_module(f"semiwear.{module}"), own)
    setattr(sys.modules[__name__], name, found)
    return found


def __dir__() -> list[str]:
    return sorted({*__all__, *_PACKAGES, "__version__"})


class _Package(ModuleType):
    """A package whose functions stay functions when modules of the same name load."""

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _SOURCES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def _version() -> str:
    from importlib import metadata

    try:
        return metadata.version("semiwear")
    except metadata.PackageNotFoundError:
        return "unknown"
