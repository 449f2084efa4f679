"""Provenance of a result, as the attributes of its root."""

from __future__ import annotations

import hashlib
import platform
import tomllib
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from importlib import metadata

from semiwear.scene.external import file_digests

_LIBRARIES = ("numpy", "scipy", "numba", "scikit-fem", "xarray", "netCDF4")


def provenance(
    *,
    title: str,
    scene_toml: str,
    physics: str,
    fidelity: str,
    references: str,
    action: str = "simulate",
    input_files: Mapping[str, str] | None = None,
) -> dict[str, str]:
    """Attributes of the root of a result.

    Parameters
    ----------
    title : str
        Short description of the computation.
    scene_toml : str
        The whole scene as TOML text; its SHA-256 is kept beside it.
    physics : str
        Physics that ran and that did not, with reasons (a line for each choice).
    fidelity : str
        ``"line"``, ``"patch"`` or ``"finite elements"``.
    references : str
        Published sources of the physics that ran, a line each.
    action : str
        The function that made the result, for `history`.
    input_files : mapping, optional
        SHA-256 of the files that the scene names, by path, when they were read. Default: at present.

    Returns
    -------
    dict of str to str
    """
    files = _files(scene_toml) if input_files is None else input_files
    software = f"semiwear {version()}"
    now = datetime.now(UTC).isoformat(timespec="seconds").replace("+00:00", "Z")
    return {
        "title": title,
        "source": software,
        "history": f"{now} {software}: {action}",
        "scene_toml": scene_toml,
        "scene_sha256": hashlib.sha256(scene_toml.encode()).hexdigest(),
        "input_files": "\n".join(f"{path}: sha256 {digest}" for path, digest in files.items()) or "none",
        "libraries": _libraries(),
        "platform": f"Python {platform.python_version()}, {platform.platform()}",
        "physics": physics,
        "fidelity": fidelity,
        "accuracy": "not asked for",
        "references": references,
    }


def _files(scene_toml: str) -> dict[str, str]:
    """Digests of the files that a scene names; none if its text is no TOML."""
    try:
        return file_digests(tomllib.loads(scene_toml))
    except tomllib.TOMLDecodeError:
        return {}


@cache  # reading the metadata of installed packages takes milliseconds, which sweeps would spend on every scene
def _libraries() -> str:
    """Libraries that compute, with their versions."""
    return ", ".join(f"{name} {metadata.version(name)}" for name in _LIBRARIES)


@cache
def version() -> str:
    """Version of the installed semiwear, in words where it is not installed."""
    try:
        return metadata.version("semiwear")
    except metadata.PackageNotFoundError:
        return "(version unknown: not installed)"
