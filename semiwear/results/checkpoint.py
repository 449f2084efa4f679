"""Checkpoints: the finished wear steps of a run, on disk as soon as they are finished.

A file is a mark and a chain of records, each sealed by its length and SHA-256: first what the run stands on
(`run_identity`), then one a wear step. The file appears whole (written, then renamed) and grows at its end; what a
killed run leaves behind the last whole record is dropped, so that at any moment the steps before it are safe.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import struct
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Protocol
from zipfile import BadZipFile

import numpy as np

from semiwear.errors import ResultFileError
from semiwear.results.files import sync_folder
from semiwear.results.run_identity import differences

try:
    import fcntl
except ImportError:  # not a POSIX system: two runs are not kept apart there
    fcntl = None  # type: ignore[assignment]

__all__ = ["Checkpoint", "Keeper", "KeptStep", "NoCheckpoint", "Peek", "open_checkpoint", "peek"]

_MARK = b"semiwear checkpoint 1\n"
_SEAL = struct.Struct("<Q32s")  # length of a record and its SHA-256
_REMEDY = "delete the file, or run without --resume (resume=False), to start from the beginning"


@dataclass(frozen=True)
class KeptStep:
    """A finished wear step.

    Attributes
    ----------
    total : int
        Wear steps of the whole run; 0 while that is not known.
    seconds : dict of str to float
        Time that the run had taken by then, by stage and effect [s].
    arrays : dict of str to array
    """

    total: int
    seconds: dict[str, float]
    arrays: dict[str, np.ndarray]


@dataclass(frozen=True)
class Peek:
    """Content of a checkpoint.

    Attributes
    ----------
    finished : int
        Wear steps that are whole.
    damaged : bool
        Whether what follows them is damaged and not merely cut off.
    """

    finished: int
    damaged: bool


class Keeper(Protocol):
    """Keeps finished wear steps."""

    @property
    def steps(self) -> tuple[KeptStep, ...]:
        """Wear states that an earlier run has left, the unworn one first."""

    def add(self, step: KeptStep) -> None:
        """Keep one more."""

    def __enter__(self) -> Keeper:
        """Begin."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End."""


class NoCheckpoint:
    """Keeps nothing."""

    steps: tuple[KeptStep, ...] = ()

    def add(self, step: KeptStep) -> None:
        """Do nothing."""

    def __enter__(self) -> NoCheckpoint:
        return self

    def __exit__(self, *_: object) -> None:
        pass


class Checkpoint:
    """A checkpoint file that is being written; made by `open_checkpoint`.

    Attributes
    ----------
    path : Path
    steps : tuple of KeptStep
        What the file held when it was opened, the unworn state first.
    """

    def __init__(self, path: Path, opened: BinaryIO, steps: tuple[KeptStep, ...] = (), waiting: Path | None = None):
        self.path, self.steps = path, steps
        self._opened, self._waiting, self._count = opened, waiting, len(steps)

    def __enter__(self) -> Checkpoint:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let the file go; it stays."""
        self._opened.close()
        if self._waiting is not None:
            self._waiting.unlink(missing_ok=True)

    def add(self, step: KeptStep) -> None:
        """Keep one more wear state; when this returns it is on the disk.

        Raises
        ------
        ResultFileError
            It cannot be written; the states before are kept.
        """
        try:
            _append(self._opened, _packed(step))
            self._count += 1
            if self._waiting is not None and self._count > 1:
                # only a finished wear step takes the place of an earlier run's checkpoint
                _take_place(self._waiting, self.path)
                self._waiting = None
        except OSError as error:
            raise ResultFileError(
                f"{self.path}: cannot be written ({error.strerror or error}); what was finished before, "
                f"{max(self._count - 1, 0)} wear steps, is kept: make room, then go on with --resume (resume=True)"
            ) from error


def open_checkpoint(path: str | os.PathLike[str], identity: Mapping[str, str], *, resume: bool) -> Checkpoint:
    """Open a checkpoint for a run.

    Parameters
    ----------
    path : path
        The file.
    identity : mapping of str to str
        What the run stands on, from `run_identity`.
    resume : bool
        Go on from the steps in the file, if there is one. Otherwise an existing file is replaced as soon as the
        new run has finished a wear step of its own.

    Raises
    ------
    ResultFileError
        The file is of another run, damaged at its start or foreign, in use, or cannot be written.
    """
    target = Path(path)
    try:
        if target.exists() and not target.is_file():
            what = "a folder" if target.is_dir() else "not a plain file"
            raise ResultFileError(f"{target}: {what}, so no checkpoint; give the path of a file")
        if not target.exists():
            return Checkpoint(target, _written(target, [_packed_identity(identity)], target))
        return _resumed(target, identity) if resume else _anew(target, identity)
    except OSError as error:
        raise ResultFileError(
            f"{target}: the checkpoint cannot be opened ({error.strerror or error}); give a file in a folder that "
            "exists, and which you may read and write"
        ) from error


def peek(path: str | os.PathLike[str]) -> Peek | None:
    """Content of a checkpoint; None where there is no such file, or none of semiwear's."""
    try:
        with Path(path).open("rb") as opened:
            payloads, damaged = _read(opened, Path(path))
    except (OSError, ResultFileError):
        return None
    return Peek(max(len(payloads) - 2, 0), damaged)


def _anew(target: Path, identity: Mapping[str, str]) -> Checkpoint:
    """A checkpoint that waits beside an existing one."""
    with target.open("rb") as old:
        _lock(old, target)  # another run's steps are not taken away under its hands
    waiting = target.with_name(f".{target.name}.new")
    return Checkpoint(target, _written(waiting, [_packed_identity(identity)], None), waiting=waiting)


def _resumed(target: Path, identity: Mapping[str, str]) -> Checkpoint:
    opened = target.open("r+b")
    try:
        _lock(opened, target)
        payloads, _ = _read(opened, target)
        kept = _unpacked_identity(payloads[0], target)
        steps = tuple(_unpacked(payload, target) for payload in payloads[1:])
        finished = max(len(steps) - 1, 0)
        changed = differences(kept, identity, finished)
        if changed and finished:
            listed = "\n".join(f"  {k + 1}. {line}" for k, line in enumerate(changed))
            raise ResultFileError(
                f"{target}: cannot be resumed, its {finished} finished wear steps are of another run\n{listed}\n"
                f"undo the changes to resume it; or {_REMEDY}"
            )
        if changed:
            payloads, steps = payloads[:1], ()  # nothing is lost
        if kept == dict(identity):
            opened.truncate()  # behind the last whole record lies what a killed run had begun to write
            return Checkpoint(target, opened, steps)
        # what has changed does not touch the finished steps, but may touch those to come
        beside = target.with_name(f".{target.name}.new")
        again = _written(beside, [_packed_identity(identity), *payloads[1:]], target)
    except BaseException:
        opened.close()
        raise
    opened.close()
    return Checkpoint(target, again, steps)


def _written(path: Path, payloads: Sequence[bytes], target: Path | None) -> BinaryIO:
    """A new file with these records, open at its end; under the name `target`, when given, once it is whole."""
    if target == path:
        path = target.with_name(f".{target.name}.new")
    opened = path.open("wb")
    try:
        _lock(opened, path)
        opened.write(_MARK)
        for payload in payloads:
            _append(opened, payload)
        if target is not None:
            _take_place(path, target)
    except BaseException:
        opened.close()
        raise
    return opened


def _take_place(path: Path, target: Path) -> None:
    os.replace(path, target)
    sync_folder(target.parent)


def _lock(opened: BinaryIO, path: Path) -> None:
    """Hold the file until it is closed, or the process ends."""
    if fcntl is None:
        return
    try:
        fcntl.flock(opened.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise ResultFileError(
            f"{path}: another run is writing this checkpoint; wait for it, stop it, or give another output file"
        ) from None
    except OSError:
        pass  # a file system without locks


# ---------------------------------------------------------------------- records


def _append(opened: BinaryIO, payload: bytes) -> None:
    opened.write(_SEAL.pack(len(payload), _digest(payload)) + payload)
    opened.flush()
    os.fsync(opened.fileno())


def _digest(payload: bytes) -> bytes:
    return hashlib.sha256(len(payload).to_bytes(8, "little") + payload).digest()


def _read(opened: BinaryIO, path: Path) -> tuple[list[bytes], bool]:
    """Whole records up to the first that is not, the position left behind them; whether that one is damaged.

    A record that ends before it should is what a killed run had begun to write, and no damage.
    """
    mark = opened.read(len(_MARK))
    if mark != _MARK:
        if mark.startswith(_MARK[:-2]):
            raise ResultFileError(f"{path}: a checkpoint of another version of semiwear; {_REMEDY}")
        what = "empty" if not mark else "not a checkpoint of semiwear, or damaged at its start"
        raise ResultFileError(f"{path}: {what}; {_REMEDY}")
    size = os.fstat(opened.fileno()).st_size
    payloads: list[bytes] = []
    damaged = False
    while True:
        begin = opened.tell()
        seal = opened.read(_SEAL.size)
        if len(seal) == _SEAL.size:
            length, digest = _SEAL.unpack(seal)
            payload = opened.read(length) if length <= size - opened.tell() else b""
            if _digest(payload) == digest:
                payloads.append(payload)
                continue
            damaged = len(payload) == length
        opened.seek(begin)
        break
    if not payloads:
        raise ResultFileError(f"{path}: damaged at its start, so that no wear step in it can be used; {_REMEDY}")
    return payloads, damaged


def _packed_identity(identity: Mapping[str, str]) -> bytes:
    return json.dumps(dict(identity)).encode()


def _unpacked_identity(payload: bytes, path: Path) -> dict[str, str]:
    try:
        return {str(name): str(value) for name, value in json.loads(payload).items()}
    except (ValueError, AttributeError) as error:
        raise ResultFileError(f"{path}: damaged, it does not say of which run it is; {_REMEDY}") from error


def _packed(step: KeptStep) -> bytes:
    buffer = io.BytesIO()
    told = json.dumps({"total": step.total, "seconds": step.seconds})
    np.savez(buffer, allow_pickle=False, _told=np.array(told), **step.arrays)
    return zlib.compress(buffer.getvalue(), 1)  # cells of patches are zeros for the most part


def _unpacked(payload: bytes, path: Path) -> KeptStep:
    try:
        with np.load(io.BytesIO(zlib.decompress(payload)), allow_pickle=False) as arrays:
            found = {name: arrays[name] for name in arrays.files}
        told = json.loads(str(found.pop("_told")))
        return KeptStep(int(told["total"]), dict(told["seconds"]), found)
    except (ValueError, KeyError, TypeError, OSError, zlib.error, BadZipFile) as error:
        raise ResultFileError(f"{path}: damaged, a wear step in it cannot be read ({error}); {_REMEDY}") from error
