"""A store of solved scenes: a folder with a file for each, written as soon as it is solved.

``sweep.json`` holds the versions that solved them; ``<key>.npz`` holds one outcome. A file is written under another
name and renamed, so that it is whole or absent if a sweep is killed. Keys are digests of the scene, of the files that
it names and of the measured variables: a sweep that was stopped, or extended, finds the outcomes of earlier ones.
Several sweeps may use a store at once.
"""

from __future__ import annotations

import io
import json
import os
import time
import uuid
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Protocol

import numpy as np

from semiwear.errors import ResultFileError
from semiwear.results.files import write_synced
from semiwear.results.run_identity import changed_entries, code_identity
from semiwear.sweep.measure import Measured
from semiwear.sweep.outcome import Outcome, Status

_VERSION = 1
_HEAD, _ENDING, _PART = "sweep.json", ".npz", ".part"
_LEFT = 3600.0  # s after which no sweep is still writing a part
_COORDINATE = "coordinate "
_REMEDY = "give another folder, or delete this one to compute everything again"


class Store(Protocol):
    """Keeps outcomes by their keys."""

    def get(self, key: str) -> Outcome | None:
        """The outcome; None if there is none."""

    def put(self, outcome: Outcome) -> None:
        """Keep an outcome."""


class MemoryStore:
    """Keeps outcomes in memory."""

    def __init__(self) -> None:
        self._kept: dict[str, Outcome] = {}

    def get(self, key: str) -> Outcome | None:
        """The outcome; None if there is none."""
        return self._kept.get(key)

    def put(self, outcome: Outcome) -> None:
        """Keep an outcome."""
        self._kept[outcome.key] = outcome


class FileStore:
    """Keeps outcomes in a folder; made by `open_store`. Those that are not lasting are kept in memory."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._passing = MemoryStore()

    def get(self, key: str) -> Outcome | None:
        """The outcome; None if there is none, or its file is damaged."""
        return self._passing.get(key) or _read(self.folder / f"{key}{_ENDING}", key)

    def put(self, outcome: Outcome) -> None:
        """Keep an outcome, which is on the disk when this returns.

        Raises
        ------
        ResultFileError
            It cannot be written.
        """
        if not outcome.lasting:
            self._passing.put(outcome)
            return
        try:
            _write(self.folder / f"{outcome.key}{_ENDING}", _packed(outcome))
        except OSError as error:
            raise ResultFileError(
                f"{self.folder}: cannot be written ({error.strerror or error}); the scenes that were solved before "
                "are kept: make room, then go on with the same store"
            ) from error


identity = cache(code_identity)
"""Versions on which a solved scene depends, found once in a process."""


def open_store(path: str | os.PathLike[str] | None) -> Store:
    """A store in a folder, created if missing; in memory without a path.

    Raises
    ------
    ResultFileError
        The folder holds something else, was written by another version, or cannot be written.
    """
    if path is None:
        return MemoryStore()
    folder = Path(path)
    try:
        if folder.exists() and not (folder.is_dir() and _is_store(folder)):
            raise ResultFileError(f"{folder}: not a store of a sweep; give a path where it may make a folder")
        folder.mkdir(parents=True, exist_ok=True)
        _remove_left(folder)
        if (folder / _HEAD).exists():
            _require_same(folder)
        else:
            _write(folder / _HEAD, json.dumps({"store": _VERSION, "versions": identity()}, indent=1).encode())
    except OSError as error:
        raise ResultFileError(
            f"{folder}: the store cannot be opened ({error.strerror or error}); give a place that you may read and "
            "write"
        ) from error
    return FileStore(folder)


def _remove_left(folder: Path) -> None:
    """Remove parts of a sweep that was killed while writing, not those that another one is writing."""
    for left in folder.glob(f"*{_PART}"):
        with suppress(FileNotFoundError):
            if time.time() - left.stat().st_mtime > _LEFT:
                left.unlink()


def kept_scenes(path: str | os.PathLike[str]) -> int:
    """Number of outcomes in a store; 0 if there is none."""
    folder = Path(path)
    return sum(1 for _ in folder.glob(f"*{_ENDING}")) if (folder / _HEAD).exists() else 0


def _is_store(folder: Path) -> bool:
    return (folder / _HEAD).exists() or not any(not entry.name.endswith(_PART) for entry in folder.iterdir())


def _require_same(folder: Path) -> None:
    try:
        found = json.loads((folder / _HEAD).read_bytes())
        version, versions = found["store"], dict(found["versions"])
    except (ValueError, KeyError, TypeError) as error:
        raise ResultFileError(f"{folder}: damaged, {_HEAD} does not say what wrote it; {_REMEDY}") from error
    changed = [] if version == _VERSION else [f"layout: {version} in the store, {_VERSION} now"]
    changed += changed_entries(versions, identity(), "store")
    if changed:
        listed = "\n".join(f"  {k + 1}. {line}" for k, line in enumerate(changed))
        raise ResultFileError(f"{folder}: its scenes were solved by another version\n{listed}\n{_REMEDY}")


def _write(file: Path, content: bytes) -> None:
    try:
        _write_once(file, content)
    except FileNotFoundError:  # an earlier version that opens the store removes the parts of others
        _write_once(file, content)


def _write_once(file: Path, content: bytes) -> None:
    part = file.with_name(f"{file.name}.{uuid.uuid4().hex}{_PART}")
    try:
        write_synced(file, part, content)
    finally:
        part.unlink(missing_ok=True)


def _packed(outcome: Outcome) -> bytes:
    record = {
        "key": outcome.key,
        "status": int(outcome.status),
        "message": outcome.message,
        "seconds": outcome.seconds,
        "arrays": [*outcome.measured.variables, *(f"{_COORDINATE}{name}" for name in outcome.measured.coords)],
    }
    arrays = [*outcome.measured.variables.values(), *outcome.measured.coords.values()]
    buffer = io.BytesIO()
    np.savez(
        buffer, allow_pickle=False, _told=np.array(json.dumps(record)), **{f"a{k}": a for k, a in enumerate(arrays)}
    )
    return buffer.getvalue()


def _read(file: Path, key: str) -> Outcome | None:
    try:
        with np.load(file, allow_pickle=False) as opened:
            record = json.loads(str(opened["_told"]))
            arrays = {name: opened[f"a{k}"] for k, name in enumerate(record["arrays"])}
        if record["key"] != key:
            return None
        coords = {name.removeprefix(_COORDINATE): a for name, a in arrays.items() if name.startswith(_COORDINATE)}
        variables = {name: a for name, a in arrays.items() if not name.startswith(_COORDINATE)}
        measured = Measured(variables, coords)
        return Outcome(key, Status(record["status"]), str(record["message"]), float(record["seconds"]), measured)
    except Exception:  # an archive that is damaged raises almost anything
        return None
