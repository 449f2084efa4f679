"""Published figures for comparison with results, as TOML files."""

from __future__ import annotations

import tomllib
from importlib import resources

from semiwear.errors import SemiwearError
from semiwear.untyped import Table

__all__ = ["load_reference", "load_statements", "reference_names", "stated_names"]


def reference_names() -> tuple[str, ...]:
    """Names of the references that ship with semiwear."""
    return _names()


def stated_names() -> tuple[str, ...]:
    """Names of the references with statements in words."""
    return _names("statements")


def _names(*folder: str) -> tuple[str, ...]:
    files = resources.files(__name__).joinpath(*folder).iterdir()
    return tuple(sorted(entry.name.removesuffix(".toml") for entry in files if entry.name.endswith(".toml")))


def load_reference(name: str) -> Table:
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
        For an unknown name.
    """
    return _load(name)


def load_statements(name: str) -> Table:
    """Read the statements of a reference in words, and the conditions under which a result agrees with them.

    Parameters
    ----------
    name : str
        One of `stated_names`, e.g. ``"seed_paper"``.

    Returns
    -------
    dict
        ``title``, ``unstated`` and the list ``statement``; their fields are explained in the file.

    Raises
    ------
    SemiwearError
        For an unknown name.
    """
    return _load(name, "statements")


def _load(name: str, *folder: str) -> Table:
    names = _names(*folder)
    if name not in names:
        raise SemiwearError(f"no reference {name!r}; there are: {', '.join(names)}")
    return tomllib.loads(resources.files(__name__).joinpath(*folder, f"{name}.toml").read_text(encoding="utf-8"))
