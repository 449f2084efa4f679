"""Pages of the API: summaries of every public name, from `__all__` of the packages."""

from __future__ import annotations

import inspect
from importlib import import_module

import semiwear as sw

GROUPS = {
    "Scenes and plans": ("load_scene", "shipped_scenes", "Scene", "Placement", "plan", "screen"),
    "Contact and wear": ("tooth_contact_analysis", "loaded_contact", "simulate"),
    "Results": ("save", "open_results", "report", "export_flank"),
    "Many scenes": (
        "sweep", "scatter", "Scatter", "Normal", "LogNormal", "Uniform", "Triangular", "usual_wear_coefficient",
        "optimise", "sensitivities", "measured_load",
    ),
    "Measured flanks": ("register", "measured_wear", "compare_wear", "calibrate"),
    "Errors": ("SemiwearError", "SceneError", "ConvergenceError", "ResultFileError", "MissingExtraError"),
}  # fmt: skip
"""Names of `semiwear` by purpose, whose functions have examples in their docstrings; new names are *Further* ones."""

PACKAGES = (
    "semiwear.plot",
    "semiwear.closed_forms",
    "semiwear.contact",
    "semiwear.wear",
    "semiwear.geometry",
    "semiwear.measured",
    "semiwear.scene",
    "semiwear.results",
    "semiwear.references",
    "fem_reference",
)


def public_names(package: str) -> list[str]:
    """Public functions and classes of a package, in the order of `__all__`."""
    module = import_module(package)
    return [name for name in module.__all__ if _documented(getattr(module, name))]


def _documented(member: object) -> bool:
    return inspect.isclass(member) or inspect.isfunction(member)


def api_pages() -> dict[str, str]:
    """File names and texts: the names of `semiwear` in groups, and a page for each of its public packages."""
    known = [name for names in GROUPS.values() for name in names]
    own = [name for name in public_names("semiwear")]
    groups = {title: [name for name in names if name in own] for title, names in GROUPS.items()}
    groups["Further"] = [name for name in own if name not in known]
    lines = ["# semiwear", "", "What `import semiwear as sw` gives.", ""]
    for title, names in groups.items():
        if names:
            lines += [f"## {title}", "", *_summary("semiwear", names)]
    pages = {"api.md": "\n".join(lines)}
    shown = {id(getattr(sw, name)) for name in own}
    for package in PACKAGES:
        names = [name for name in public_names(package) if id(getattr(import_module(package), name)) not in shown]
        shown |= {id(getattr(import_module(package), name)) for name in names}
        about = inspect.cleandoc(import_module(package).__doc__ or "").partition(">>>")[0].strip()
        text = [f"# {package}", "", about, "", *_summary(package, names)]
        pages[f"api_{package.replace('.', '_')}.md"] = "\n".join(text)
    return pages


def _summary(package: str, names: list[str]) -> list[str]:
    head = [f".. currentmodule:: {package}", "", ".. autosummary::", "   :toctree: api", "   :nosignatures:", ""]
    return ["```{eval-rst}", *head, *(f"   {name}" for name in names), "```", ""]
