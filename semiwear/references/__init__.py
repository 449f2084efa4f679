"""Published figures that results are compared with, as TOML files."""

from __future__ import annotations

import tomllib
from importlib import resources
from typing import Any

from semiwear.errors import SemiwearError

__all__ = ["load_reference", "reference_names"]


def reference_names() -> tuple[str, ...]:
    """Names of the references that ship with semiwear."""
    files = resources.files(__name__).iterdir()
    return tuple(sorted(entry.name.removesuffix(".toml") for entry in files if entry.name.endswith(".toml")))


def load_reference(name: str) -> dict[str, Any]:
    """Read a reference.

    Parameters
    ----------
    name : str
        One of `reference_names`, e.g. ``"seed_paper"``.

    Returns
    -------
    dict
        The tables of its TOML file.

    Raises
    ------
    SemiwearError
        No reference has that name.
    """
    if name not in reference_names():
        raise SemiwearError(f"no reference {name!r}; there are: {', '.join(reference_names())}")
    return tomllib.loads(resources.files(__name__).joinpath(f"{name}.toml").read_text(encoding="utf-8"))
