"""Identity of a run's finished wear steps: its scene, the files it reads, the code and the libraries."""

from __future__ import annotations

import hashlib
import re
import tomllib
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path

from semiwear.results.provenance import version
from semiwear.scene.external import file_digests
from semiwear.scene.toml_io import flat
from semiwear.untyped import Value

_PACKAGE = Path(__file__).parents[1]
# packages with which wear steps are computed, ...
_PACKAGES = ("scene", "closed_forms", "geometry", "meshing", "compliance", "contact", "wear", "plan", "accuracy")
_MODULES = ("simulate.py", "life.py", "collect.py", "threads.py")  # ... and how a run is divided into them
_COMMENTS = re.compile(rb"^[ \t]*#.*\n|[ \t]+#[^'\"\n]*$", re.MULTILINE)
_LIBRARIES = ("numpy", "scipy", "numba")  # they decide the last bits
_SCENE = "scene"
# fields that no wear step depends on
_WITHOUT_EFFECT = ("title", "reference", "numerics.threads", "numerics.peak_positions")
_DEPTHS = "wear.until.control_depths_um"
_ITERATIONS = "numerics.max_iterations"
_MOST_SHOWN = 8


def run_identity(scene_toml: str) -> dict[str, str]:
    """Data that must be the same for bitwise equal wear steps, on one kind of processor.

    Parameters
    ----------
    scene_toml : str
        The whole scene.

    Returns
    -------
    dict of str to str
        The scene, versions, and digests of the code and of the files that the scene names.
    """
    digests = file_digests(tomllib.loads(scene_toml))
    contents = {f"content of {path}": digest[:16] for path, digest in digests.items()}
    return {_SCENE: scene_toml} | code_identity() | contents


def code_identity() -> dict[str, str]:
    """Versions on which every run depends: package, code, and the libraries that decide the last bits."""
    found = {"semiwear": version(), "semiwear's code": _code_digest()}
    return found | {library: metadata.version(library) for library in _LIBRARIES}


def differences(kept: Mapping[str, str], now: Mapping[str, str], finished: int) -> list[str]:
    """Differences between the kept run and the one that would continue it, as lines for a reader.

    Two changes of a scene do not affect finished wear steps and are not listed: other control depths after those
    that are reached, and, at fidelity `line`, a higher limit of iterations.

    Parameters
    ----------
    kept, now : mapping of str to str
        From `run_identity`.
    finished : int
        Wear steps that are kept.
    """
    then, here = ({name: value for name, value in own.items() if name != _SCENE} for own in (kept, now))
    lines = _scene_differences(kept.get(_SCENE, ""), now[_SCENE], finished)
    return lines + changed_entries(then, here, "checkpoint")


def changed_entries(then: Mapping[str, str], now: Mapping[str, str], place: str) -> list[str]:
    """Lines on entries that are not as they are kept in a place."""
    names = [*now, *(name for name in then if name not in now)]
    return [
        f"{name}: {then.get(name, 'absent')} in the {place}, {now.get(name, 'absent')} now"
        for name in names
        if then.get(name) != now.get(name)
    ]


def _scene_differences(kept: str, now: str, finished: int) -> list[str]:
    then, here = dict(flat(tomllib.loads(kept))), dict(flat(tomllib.loads(now)))
    lines = []
    for key in [*here, *(key for key in then if key not in here)]:
        old, new = then.get(key), here.get(key)
        if old == new or key in _WITHOUT_EFFECT:
            continue
        if key == _DEPTHS and old and new and old[:finished] == new[:finished]:
            continue
        if key == _ITERATIONS and here.get("numerics.fidelity") == "line" and (new or 0) >= (old or 0):
            continue
        lines.append(f"{key}: {_shown(old)} in the checkpoint, {_shown(new)} now")
    more = len(lines) - _MOST_SHOWN
    return lines if more <= 0 else [*lines[:_MOST_SHOWN], f"{more} more fields of the scene"]


def _shown(value: Value) -> str:
    if value is None:
        return "absent"
    return repr(value if value != {} else "a table")


def _code_digest() -> str:
    """Digest of the code without its comments, whose changes do not prevent a resume."""
    files = [path for package in _PACKAGES for path in (_PACKAGE / package).rglob("*.py")]
    files += [_PACKAGE / name for name in _MODULES]
    sha256 = hashlib.sha256()
    for path in sorted(files):
        sha256.update(path.relative_to(_PACKAGE).as_posix().encode() + b"\0" + _COMMENTS.sub(b"", path.read_bytes()))
    return sha256.hexdigest()[:16]
