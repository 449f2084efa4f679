"""Files that are written: permitted names, links, and errors that name the file."""

from __future__ import annotations

import errno
import os
import shutil
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from semiwear.errors import Problem, SceneError, SemiwearError

RESULTS = (".nc", ".nc4")
"""How the names of result files end."""

PAGES = (".html", ".htm")
"""How the names of reports end."""

AnyPath = str | os.PathLike[str]

_KINDS = {".nc": "netCDF", ".nc4": "netCDF", ".html": "HTML", ".htm": "HTML", ".csv": "CSV"}
_FULL = 1 << 20  # bytes: with less than this left a disk is full


def file_target(field: str, path: AnyPath, endings: Sequence[str]) -> Path:
    """Path of a file to write: links are followed, so that the file behind a link is replaced and not the link.

    Parameters
    ----------
    field : str
        Argument or option that gave the path, for the error.
    path : path
    endings : sequence of str
        Permitted endings of its name, in small letters, the default first.

    Raises
    ------
    SceneError
        For a name of another kind of file, a folder, or anything but a plain file: a device, a pipe, a socket.
    """
    given = os.fspath(path)
    kind = _KINDS.get(endings[0], endings[0])
    article = "an" if kind == "HTML" else "a"
    names = " or ".join(f"*{ending}" for ending in endings)
    several = len({_KINDS.get(ending, ending) for ending in endings}) > 1
    allowed = f"the name of a file, {names}" if several else f"the name of {article} {kind} file, {names}"
    if not given or "\0" in given:
        raise SceneError.of(field, given, allowed, "give the name of a file")
    target = Path(os.path.realpath(given))
    if target.is_dir():
        raise SceneError.of(field, given, allowed, f"it is a folder: give e.g. {Path(given) / f'worn{endings[0]}'}")
    if os.path.exists(given) and not os.path.isfile(given):  # a pipe has no real path
        raise SceneError.of(field, given, allowed, "it is a device or a pipe: give a plain file")
    if Path(given).suffix.casefold() not in endings:
        better = Path(given).with_suffix(endings[0])
        fix = (
            f"the ending says what is written: e.g. {better}"
            if several
            else f"what is written is {kind}: call it {better}"
        )
        raise SceneError.of(field, given, allowed, fix)
    return target


def target_problems(field: str, path: AnyPath | None, target: Callable[[str, AnyPath], Path]) -> list[Problem]:
    """Problems of a path that is to be written: those that `target` raises, or a folder that does not exist.

    Parameters
    ----------
    field : str
        Option that gave the path.
    path : path or None
        None if nothing is to be written.
    target : callable
        From field and path to the target, such as `file_target` with its endings.
    """
    if path is None:
        return []
    try:
        folder = target(field, path).parent
    except SceneError as error:
        return list(error.problems)
    if folder.is_dir() and os.access(folder, os.W_OK):
        return []
    fix = f"{folder} may not be written: give another" if folder.is_dir() else f"make {folder}"
    return [Problem(field, os.fspath(path), "a file in a folder that exists and can be written", fix)]


def require_apart(outputs: Mapping[str, AnyPath], inputs: Mapping[str, AnyPath]) -> None:
    """Refuse outputs that would replace input files, or one another; links are followed.

    Parameters
    ----------
    outputs, inputs : mappings from option or field to path

    Raises
    ------
    SceneError
        Naming both.
    """
    known, problems = list(inputs.items()), list[Problem]()
    for field, path in outputs.items():
        fixes = [f"{other} is that file: give another" for other, taken in known if _same(path, taken)]
        problems += [Problem(field, os.fspath(path), "a file of its own", fix) for fix in fixes]
        known.append((field, path))
    if problems:
        raise SceneError(problems, "files")


def _same(one: AnyPath, other: AnyPath) -> bool:
    if os.path.realpath(one) == os.path.realpath(other):
        return True
    try:
        return os.path.samefile(one, other)
    except (OSError, ValueError):
        return False  # one of them is not there


@contextmanager
def naming(target: Path) -> Iterator[None]:
    """Name the file, and the full disk, in the error of what writes it.

    Raises
    ------
    OSError
        With the file, the reason and what to do.
    """
    try:
        yield
    except SemiwearError:
        raise
    except (OSError, RuntimeError) as error:  # netCDF4 and HDF5 report full disks with either
        number = getattr(error, "errno", None)
        reason = os.strerror(number) if number is not None and number > 0 else str(error)
        full = number in (errno.ENOSPC, errno.EDQUOT)
        with suppress(OSError):
            full = full or shutil.disk_usage(target.parent).free < _FULL
        why, fix = (f"the disk is full: {reason}", "make room") if full else (reason, "see that it may be written")
        failed = OSError(f"{target}: cannot be written ({why}); {fix}, or give a file in another place")
        failed.errno = number
        raise failed from error


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """A new file that replaces a target once it is written: there is either the old file or the whole new one.

    Raises
    ------
    OSError
        As `naming`.
    """
    temporary = target.with_name(f".{target.name}.{uuid.uuid4().hex}.part")
    try:
        with naming(target):
            yield temporary
            os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)
