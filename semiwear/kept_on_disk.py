"""Disk cache of results that take seconds and depend on their arguments only.

The compliance of teeth takes most of a short run, and depends on their sections and materials alone. The folder is
that of a user's caches, or the one named by SEMIWEAR_CACHE_DIR (`off`: none). Files are read as Python objects:
a folder that others can write is not used.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import stat
import sys
import uuid
from collections.abc import Callable
from contextlib import suppress
from dataclasses import fields, is_dataclass
from functools import lru_cache, wraps
from importlib.metadata import version
from pathlib import Path
from typing import ParamSpec, TypeVar, cast

import numpy as np

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

_VARIABLE = "SEMIWEAR_CACHE_DIR"
_OFF = "off"
_MOST_BYTES = 500_000_000  # of all files; those unused for longest are removed first


def kept_on_disk(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Decorator that reads a function's results from files if the same code was called with equal arguments.

    Arguments and results are made of numbers, strings, arrays, tuples and dataclasses of such. A file that cannot be
    read is computed anew, and what cannot be written is not kept.
    """

    @wraps(function)
    def kept(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        folder = _folder()
        if folder is None:
            return function(*args, **kwargs)
        key = hashlib.sha256(_code(function.__module__).encode())
        _add(key, (args, tuple(sorted(kwargs.items()))))
        path = folder / f"{function.__name__}-{key.hexdigest()[:40]}.pickle"
        try:
            found = cast(Result, pickle.loads(path.read_bytes()))
            os.utime(path)
        except Exception:  # a damaged file may raise anything
            found = function(*args, **kwargs)
            _write(path, pickle.dumps(found, protocol=5))
        return found

    return kept


def _add(key: hashlib._Hash, value: object) -> None:
    """Add a value to a digest, so that values which differ anywhere have different digests."""
    if isinstance(value, np.ndarray):
        key.update(f"{value.dtype.str}{value.shape}".encode() + value.tobytes())
    elif isinstance(value, tuple):
        key.update(f"tuple {len(value)}".encode())
        for item in value:
            _add(key, item)
    elif is_dataclass(value) and not isinstance(value, type):
        key.update(type(value).__qualname__.encode())
        for item in fields(value):
            _add(key, getattr(value, item.name))
    elif value is None or isinstance(value, bool | int | float | str):
        key.update(f"{type(value).__name__} {value!r};".encode())
    else:
        raise TypeError(f"cannot distinguish values of type {type(value).__name__}")


def _folder() -> Path | None:
    """The folder, created if missing; None if results are not kept."""
    named = os.environ.get(_VARIABLE)
    if named == _OFF:
        return None
    try:
        folder = Path(named) if named else _default_folder()
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        return folder if _private(folder) else None
    except (OSError, RuntimeError):  # the latter: no home
        return None


def _default_folder() -> Path:
    if os.name == "nt":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "semiwear" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "semiwear"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "semiwear"


def _private(folder: Path) -> bool:
    """Whether only this user can write there."""
    if os.name == "nt":
        return True  # the default folder is private, others were chosen by the user
    found = folder.stat()
    return found.st_uid == os.getuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


@lru_cache(maxsize=8)
def _code(module: str) -> str:
    """Digest of the sources beside a module, and of the versions of the libraries that they use."""
    here = Path(cast(str, sys.modules[module].__file__)).parent
    sha256 = hashlib.sha256("".join(version(name) for name in ("numpy", "scipy", "scikit-fem")).encode())
    for path in sorted(here.glob("*.py")):
        sha256.update(path.name.encode() + b"\0" + path.read_bytes())
    return sha256.hexdigest()


def _write(path: Path, content: bytes) -> None:
    """Write a file whole or not at all, and remove those unused for longest above the limit."""
    part = path.with_name(f"{path.name}.{uuid.uuid4().hex}.part")
    with suppress(OSError):
        try:
            part.write_bytes(content)
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
        files = sorted(((found.stat(), found) for found in path.parent.iterdir()), key=lambda f: -f[0].st_mtime)
        total = 0
        for found, file in files:
            total += found.st_size
            if total > _MOST_BYTES:
                file.unlink(missing_ok=True)
