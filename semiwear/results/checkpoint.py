"""Checkpoints: the wear states of a run, each in a file of its own as soon as it is solved.

A checkpoint is a folder: ``run.json`` holds the run's identity (`run_identity`), ``0000.npz`` the unworn state,
``0001.npz`` the state after the first wear step. A file is written under another name and renamed, so it is whole
or absent if a run is killed.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Protocol

import numpy as np

from semiwear.errors import ResultFileError
from semiwear.results.files import write_synced
from semiwear.results.run_identity import differences

try:
    import fcntl
except ImportError:  # not a POSIX system: no lock against a second run
    fcntl = None  # type: ignore[assignment]

_VERSION = 2
_RUN, _STEPS, _WRITTEN = "run.json", "[0-9][0-9][0-9][0-9]*.npz", ".new"
_REMEDY = "delete the folder, or run without --resume (resume=False), to start from the beginning"


@dataclass(frozen=True)
class KeptStep:
    """A finished wear step.

    Attributes
    ----------
    total : int
        Wear steps of the whole run; 0 while that is not known.
    seconds : dict of str to float
        Time of the run so far, by stage and effect [s].
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
        Complete wear steps.
    damaged : bool
        Whether the next one is damaged.
    """

    finished: int
    damaged: bool


class Keeper(Protocol):
    """Keeps finished wear steps."""

    @property
    def steps(self) -> tuple[KeptStep, ...]:
        """Wear states that an earlier run has left, the unworn one first."""

    def add(self, step: KeptStep) -> None:
        """Keep a further step."""

    def __enter__(self) -> Keeper:
        """Begin."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End."""


class NoCheckpoint:
    """A keeper that does nothing."""

    steps: tuple[KeptStep, ...] = ()

    def add(self, step: KeptStep) -> None:
        """Do nothing."""

    def __enter__(self) -> NoCheckpoint:
        return self

    def __exit__(self, *_: object) -> None:
        pass


class Checkpoint:
    """A checkpoint that is being written; made by `open_checkpoint`.

    Attributes
    ----------
    folder : Path
    steps : tuple of KeptStep
        Wear states that it held when it was opened, the unworn one first.
    """

    def __init__(self, folder: Path, lock: int, steps: tuple[KeptStep, ...], anew: Mapping[str, str] | None = None):
        self.folder, self.steps = folder, steps
        self._lock, self._anew, self._waiting, self._count = lock, anew, list[KeptStep](), len(steps)

    def __enter__(self) -> Checkpoint:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Unlock the folder, which remains."""
        os.close(self._lock)

    def add(self, step: KeptStep) -> None:
        """Keep a further wear state, which is on the disk when this returns.

        Raises
        ------
        ResultFileError
            It cannot be written; the states before are kept.
        """
        self._waiting.append(step)
        try:
            if self._anew is not None:
                if len(self._waiting) < 2:
                    return  # only a finished wear step replaces those of an earlier run
                _begin(self.folder, self._anew)
                self._anew = None
            while self._waiting:
                _write(_file_of(self.folder, self._count), _packed(self._waiting[0]))
                self._count += 1
                del self._waiting[0]
        except OSError as error:
            raise ResultFileError(
                f"{self.folder}: cannot be written ({error.strerror or error}); what was finished before, "
                f"{max(self._count - 1, 0)} wear steps, is kept: make room, then go on with --resume (resume=True)"
            ) from error


def open_checkpoint(path: str | os.PathLike[str], identity: Mapping[str, str], *, resume: bool) -> Checkpoint:
    """Open a checkpoint for a run.

    Parameters
    ----------
    path : path
        The folder; made where it does not exist.
    identity : mapping of str to str
        Identity of the run, from `run_identity`.
    resume : bool
        Continue from the steps in the folder, if there are any. Otherwise they are replaced as soon as the new run
        has finished a wear step of its own.

    Raises
    ------
    ResultFileError
        The checkpoint is of another run, damaged at its start or foreign, in use, or cannot be written.
    """
    folder = Path(path)
    try:
        if folder.exists() and not _is_checkpoint(folder):
            raise ResultFileError(f"{folder}: not a checkpoint of semiwear; give a path where it may make a folder")
        folder.mkdir(exist_ok=True)
        with _locked(folder) as lock:
            for left in folder.glob(f"*{_WRITTEN}"):  # by a run that was killed while writing
                left.unlink(missing_ok=True)
            if not (folder / _RUN).exists():
                _begin(folder, identity)
                return Checkpoint(folder, lock, ())
            if resume:
                return Checkpoint(folder, lock, _resumed(folder, identity))
            return Checkpoint(folder, lock, (), anew=identity)
    except OSError as error:
        raise ResultFileError(
            f"{folder}: the checkpoint cannot be opened ({error.strerror or error}); give a place in a folder that "
            "exists, and which you may read and write"
        ) from error


def peek(path: str | os.PathLike[str]) -> Peek | None:
    """Content of a checkpoint; None where there is none."""
    folder = Path(path)
    try:
        _identity(folder)
        steps = _steps(folder)
    except (OSError, ResultFileError):
        return None
    return Peek(max(len(steps) - 1, 0), _file_of(folder, len(steps)).exists())


def remove_checkpoint(path: str | os.PathLike[str]) -> None:
    """Remove a checkpoint, but nothing else that lies in its folder."""
    folder = Path(path)
    if folder.is_dir() and _is_checkpoint(folder):
        _clear(folder)
        (folder / _RUN).unlink(missing_ok=True)
        with suppress(OSError):
            folder.rmdir()


def _is_checkpoint(folder: Path) -> bool:
    """Whether a run may write there: a checkpoint, or an empty folder, left by a run that was killed at once."""
    if not folder.is_dir():
        return False
    return (folder / _RUN).exists() or all(entry.name.endswith(_WRITTEN) for entry in folder.iterdir())


def _resumed(folder: Path, identity: Mapping[str, str]) -> tuple[KeptStep, ...]:
    kept, steps = _identity(folder), _steps(folder)
    finished = max(len(steps) - 1, 0)
    changed = differences(kept, identity, finished)
    if changed and finished:
        listed = "\n".join(f"  {k + 1}. {line}" for k, line in enumerate(changed))
        raise ResultFileError(
            f"{folder}: cannot be resumed, its {finished} finished wear steps are of another run\n{listed}\n"
            f"undo the changes to resume it; or {_REMEDY}"
        )
    if changed:
        _begin(folder, identity)  # nothing is lost
        return ()
    _clear(folder, len(steps))
    if kept != dict(identity):  # the changes do not affect the finished steps, but may affect later ones
        _write(folder / _RUN, _packed_identity(identity))
    return steps


def _begin(folder: Path, identity: Mapping[str, str]) -> None:
    """Empty a checkpoint, and write the identity of its run."""
    _clear(folder)
    _write(folder / _RUN, _packed_identity(identity))


def _clear(folder: Path, kept: int = 0) -> None:
    """Remove all states but the first `kept`, the last one first: a kill then leaves a shorter run."""
    steps = {int(file.stem): file for file in folder.glob(_STEPS) if file.stem.isdecimal()}
    for step in sorted(steps, reverse=True):
        if step >= kept:
            steps[step].unlink()


@contextmanager
def _locked(folder: Path) -> Iterator[int]:
    """Hold a folder until its descriptor is closed, or the process ends; closed at once on an error."""
    lock = os.open(folder, os.O_RDONLY)
    try:
        if fcntl is not None:
            with suppress(OSError):  # a file system without locks
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    raise ResultFileError(
                        f"{folder}: another run is writing this checkpoint; wait for it, stop it, or give another "
                        "output file"
                    ) from None
        yield lock
    except BaseException:
        os.close(lock)
        raise


# ---------------------------------------------------------------------- files


def _write(file: Path, content: bytes) -> None:
    write_synced(file, file.with_name(f"{file.name}{_WRITTEN}"), content)


def _file_of(folder: Path, k: int) -> Path:
    return folder / f"{k:04d}.npz"


def _steps(folder: Path) -> tuple[KeptStep, ...]:
    """Wear states up to the first that is absent or damaged."""
    found: list[KeptStep] = []
    while (step := _step(_file_of(folder, len(found)))) is not None:
        found.append(step)
    return tuple(found)


def _step(file: Path) -> KeptStep | None:
    try:
        with np.load(file, allow_pickle=False) as arrays:
            found = {name: arrays[name] for name in arrays.files}
        record = json.loads(str(found.pop("_told")))
        if record["arrays"] != list(found):
            return None
        return KeptStep(int(record["total"]), dict(record["seconds"]), found)
    except Exception:  # an archive that is damaged raises almost anything
        return None


def _packed(step: KeptStep) -> bytes:
    buffer = io.BytesIO()
    record = json.dumps({"total": step.total, "seconds": step.seconds, "arrays": list(step.arrays)})
    np.savez_compressed(buffer, allow_pickle=False, _told=np.array(record), **step.arrays)
    return buffer.getvalue()


def _packed_identity(identity: Mapping[str, str]) -> bytes:
    return json.dumps({"checkpoint": _VERSION, "run": dict(identity)}, indent=1).encode()


def _identity(folder: Path) -> dict[str, str]:
    try:
        found = json.loads((folder / _RUN).read_bytes())
        version = found["checkpoint"]
        identity = {str(name): str(value) for name, value in found["run"].items()}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ResultFileError(f"{folder}: damaged, {_RUN} does not say of which run it is; {_REMEDY}") from error
    if version != _VERSION:
        raise ResultFileError(f"{folder}: a checkpoint of another version of semiwear; {_REMEDY}")
    return identity
