"""Result files: netCDF, written whole or not at all, and opened with clear error messages.

A file is a netCDF-4 file followed by a seal: a mark and the SHA-256 of all bytes before it. netCDF readers ignore
bytes after their own end, so any of them opens the file and may add to it. The HDF5 library can crash the interpreter
on a damaged file: a file without its seal is first opened in a separate process. Data that has changed since it was
saved is then found by check sums, in an attribute of the root.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import warnings
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

import xarray as xr

from semiwear.errors import ResultFileError, SemiwearError
from semiwear.results.datasets import check_tree
from semiwear.results.schema import GROUPS, SCHEMA_VERSION
from semiwear.sources import NETCDF
from semiwear.targets import RESULTS, file_target, replacing
from semiwear.untyped import Options

_SEAL_MARK = b"semiwear sha256:"
_SEAL_SIZE = len(_SEAL_MARK) + hashlib.sha256().digest_size
_CHUNK = 1 << 20
_CHECK_SUMS = "check_sums"  # attribute of the root, in the file only
_LONGEST_PROBE = 120.0  # s
_PROBE = """
import sys, netCDF4
def read(group):
    group.__dict__
    for variable in group.variables.values():
        variable.__dict__, variable[...]
    for inner in group.groups.values():
        read(inner)
try:
    with netCDF4.Dataset(sys.argv[1]) as opened:
        opened.set_auto_maskandscale(False)
        opened.set_auto_chartostring(False)
        read(opened)
except Exception as error:
    sys.exit(str(error) or type(error).__name__)
"""
_ANEW = "open a file that semiwear saved, or compute it anew: semiwear run SCENE -o FILE"


def save(tree: xr.DataTree, path: str | os.PathLike[str]) -> None:
    """Write a result to a netCDF-4 file.

    The tree goes to a temporary file beside `path`, which then takes its place in one step: whatever
    happens, `path` holds either the old file or the whole new one.

    Parameters
    ----------
    tree : DataTree
        A result of `simulate` or `loaded_contact`.
    path : path
        The file, named .nc; an existing file, or the one that a link points to, is replaced.

    Raises
    ------
    SemiwearError
        The tree is no result of semiwear, a variable differs from the schema, or the path is no netCDF file's.
    OSError
        The file cannot be written, for lack of space for instance.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import semiwear as sw
    >>> path = pathlib.Path(tempfile.mkdtemp(), "contact.nc")
    >>> coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8}
    >>> sw.save(sw.loaded_contact(sw.load_scene("spur_fzg_c").replace(coarse), [0.0]), path)
    >>> path.is_file()
    True
    """
    target = file_target("path", path, RESULTS)
    if "schema_version" not in tree.attrs:
        raise SemiwearError("save: the tree has no schema_version, so it is no result of semiwear")
    check_tree(tree)
    if not target.parent.is_dir():
        raise FileNotFoundError(f"save: no folder {target.parent} for {target.name}")
    with replacing(target) as temporary:
        stored = tree.copy()
        stored.attrs = {**tree.attrs, _CHECK_SUMS: _check_sums(tree)}
        stored.to_netcdf(temporary, engine="netcdf4", format="NETCDF4", encoding=_encoding(tree))
        with temporary.open("r+b") as written:
            digest = _digest(written, temporary.stat().st_size)
            written.write(_SEAL_MARK + digest)
            written.flush()
            os.fsync(written.fileno())
    sync_folder(target.parent)


def write_synced(file: Path, part: Path, content: bytes) -> None:
    """Write a file by way of a part beside it, whole or not at all; it is on the disk when this returns."""
    with part.open("wb") as opened:
        opened.write(content)
        opened.flush()
        os.fsync(opened.fileno())
    os.replace(part, file)
    sync_folder(file.parent)


def sync_folder(folder: Path) -> None:
    """Write the names in a folder to the disk, if the system can: a renamed file then survives a power cut."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def open_results(path: str | os.PathLike[str]) -> xr.DataTree:
    """Read a result into memory.

    Parameters
    ----------
    path : path
        A file that `save` wrote.

    Returns
    -------
    DataTree
        Identical to the saved tree, except for additions by other programs.

    Warns
    -----
    UserWarning
        Variables have changed since semiwear saved them.

    Raises
    ------
    FileNotFoundError
        There is no such file.
    ResultFileError
        The file is damaged, foreign, of another schema version, or may not be read.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import semiwear as sw
    >>> path = pathlib.Path(tempfile.mkdtemp(), "contact.nc")
    >>> coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8}
    >>> sw.save(sw.loaded_contact(sw.load_scene("spur_fzg_c").replace(coarse), [0.0]), path)
    >>> sw.open_results(path).attrs["fidelity"]
    'line'
    """
    source = Path(path)
    try:
        return _opened(source)
    except FileNotFoundError:
        raise FileNotFoundError(f"no result file {source}: give the path of a file that semiwear saved") from None
    except OSError as error:
        raise ResultFileError(
            f"{source}: cannot be read ({error.strerror or error}); see that you may read it"
        ) from error


def _opened(source: Path) -> xr.DataTree:
    if source.is_dir():
        raise ResultFileError(f"{source}: a folder; give the path of a result file in it, e.g. {source / 'worn.nc'}")
    if source.exists() and not source.is_file():
        raise ResultFileError(f"{source}: not a plain file; give the path of a result file")
    sealed = _sealed(source)
    if not sealed:
        _probe(source)
    try:
        with xr.open_datatree(source, engine="netcdf4") as opened:
            version = str(opened.attrs.get("schema_version", ""))
            _check_version(version, source)
            tree = opened.load()
    except (ResultFileError, FileNotFoundError, PermissionError):
        raise
    except Exception as error:  # netCDF4, HDF5 and xarray raise almost any type on damage
        raise ResultFileError(
            f"{source}: cannot be read as a netCDF file, it is damaged or something else ({error}); {_ANEW}"
        ) from error
    kept = tree.attrs.pop(_CHECK_SUMS, "")
    if not set(tree.children) & set(GROUPS):
        raise ResultFileError(f"{source}: damaged, it has no group of a result ({', '.join(GROUPS)}); {_ANEW}")
    try:
        check_tree(tree)
    except SemiwearError as error:
        raise ResultFileError(f"{source}: damaged, {error}; {_ANEW}") from error
    if not sealed:
        _warn_of_changes(source, str(kept), _check_sums(tree))
    return tree


def _sealed(source: Path) -> bool:
    """Whether the bytes of a file are those that `save` wrote; an error if it is no netCDF file."""
    size = source.stat().st_size
    with source.open("rb") as opened:
        start = opened.read(8)
        if not start.startswith(NETCDF):
            fault = "empty" if size == 0 else "not a netCDF file, or damaged at its start"
            raise ResultFileError(f"{source}: {fault}; {_ANEW}")
        opened.seek(max(size - _SEAL_SIZE, 0))
        seal = opened.read()
        opened.seek(0)
        return seal.startswith(_SEAL_MARK) and _digest(opened, size - _SEAL_SIZE) == seal.removeprefix(_SEAL_MARK)


def _probe(source: Path) -> None:
    """Open a file in a separate process, which a damaged file may crash."""
    try:
        probe = subprocess.run(
            [sys.executable, "-c", _PROBE, str(source)], capture_output=True, text=True, timeout=_LONGEST_PROBE
        )
        messages = probe.stderr.strip().splitlines()
        why = messages[-1] if messages else f"its reader ended with {probe.returncode}"
    except subprocess.TimeoutExpired:
        why = f"it is not read within {_LONGEST_PROBE:g} s"
    else:
        if probe.returncode == 0:
            return
    raise ResultFileError(f"{source}: damaged, cut off, or written by something else ({why}); {_ANEW}")


def _check_sums(tree: xr.DataTree) -> str:
    """A line for each variable of a tree: its path and the start of its SHA-256."""
    lines = []
    for node in tree.subtree:
        for name, array in sorted(node.to_dataset(inherit=False).variables.items(), key=lambda item: str(item[0])):
            values = array.values
            # texts are stored as objects, whose bytes are addresses
            content = repr(values.astype(str).tolist()).encode() if values.dtype.kind in "OUS" else values.tobytes()
            lines.append(f"{node.path.rstrip('/')}/{name} {hashlib.sha256(content).hexdigest()[:16]}")
    return "\n".join(lines)


def _warn_of_changes(source: Path, kept: str, found: str) -> None:
    """Warn of variables that have changed since they were saved."""
    before, now = ({line.split(" ")[0]: line for line in text.splitlines()} for text in (kept, found))
    changed = [path for path in before if now.get(path) != before[path]]
    if not before:
        change = "its data cannot be checked: the check sums are missing"
    elif changed:
        change = f"{', '.join(changed[:5])}{' and others' if changed[5:] else ''} changed after semiwear saved them"
    else:
        return
    warnings.warn(f"{source}: {change}", stacklevel=5)


def _digest(opened: BinaryIO, size: int) -> bytes:
    """SHA-256 of the first `size` bytes; the position is then behind them."""
    sha256 = hashlib.sha256()
    while size > 0 and (block := opened.read(min(size, _CHUNK))):
        sha256.update(block)
        size -= len(block)
    return sha256.digest()


def _check_version(version: str, source: Path) -> None:
    if version == SCHEMA_VERSION:
        return
    if not version:
        raise ResultFileError(f"{source}: a netCDF file, but not of semiwear (it has no schema_version); {_ANEW}")
    if not version.isdecimal():
        raise ResultFileError(f"{source}: schema_version {version!r} is not one of semiwear; {_ANEW}")
    age, remedy = "newer", "open it with a newer semiwear"
    if int(version) < int(SCHEMA_VERSION):
        age, remedy = "older", "compute it anew with this semiwear"
    raise ResultFileError(
        f"{source}: schema version {version} is {age} than this semiwear's {SCHEMA_VERSION}; {remedy}"
    )


def _encoding(tree: xr.DataTree) -> dict[str, dict[str, Options]]:
    """Light compression for numbers; no fill values, since a result has no gaps."""
    packed: Options = {"zlib": True, "complevel": 1, "shuffle": True, "_FillValue": None}
    encoding: dict[str, dict[str, Options]] = {}
    for node in tree.subtree:
        encoding[node.path] = {
            str(name): (packed if array.ndim else {"_FillValue": None})
            for name, array in node.to_dataset(inherit=False).variables.items()
            if array.dtype.kind in "biuf"
        }
    return encoding
