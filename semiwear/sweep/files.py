"""Files of sweeps: netCDF, or a zarr folder (extra ``sweep``), written whole or not at all."""

from __future__ import annotations

import os
import shutil
import uuid
import warnings
from pathlib import Path

import xarray as xr

from semiwear.errors import MissingExtraError, ResultFileError, SceneError
from semiwear.results.files import sync_folder
from semiwear.sources import no_pipe
from semiwear.targets import RESULTS, file_target, naming

_ZARR = ".zarr"
ENDINGS = (*RESULTS, _ZARR)
"""Endings of the names of sweep files."""


def sweep_target(field: str, path: str | os.PathLike[str]) -> Path:
    """Path to write a sweep to.

    Raises
    ------
    SceneError
        For a name of another kind of file, or something at the path that is no sweep.
    """
    given = Path(path)
    if given.suffix.casefold() != _ZARR:
        if given.suffix.casefold() not in RESULTS and given.name and not given.is_dir():
            allowed = "the name of a netCDF file or a zarr folder, *.nc or *.zarr"
            raise SceneError.of(field, os.fspath(path), allowed, f"call it {given.with_suffix('.nc')}")
        return file_target(field, path, RESULTS)
    target = Path(os.path.realpath(given))
    if target.exists() and not _is_zarr(target):
        allowed = "a zarr folder, or a path where there is nothing"
        raise SceneError.of(field, os.fspath(path), allowed, "it is something else: give another name")
    return target


def _is_zarr(folder: Path) -> bool:
    return folder.is_dir() and any((folder / name).exists() for name in (".zgroup", "zarr.json"))


def write_sweep(dataset: xr.Dataset, path: str | os.PathLike[str]) -> None:
    """Write the dataset of a sweep; an existing one is replaced once the new one is complete.

    Raises
    ------
    SceneError
        As `sweep_target`.
    MissingExtraError
        zarr is missing.
    OSError
        It cannot be written.
    """
    target = sweep_target("path", path)
    if not target.parent.is_dir():
        raise FileNotFoundError(f"no folder {target.parent} for {target.name}")
    part = target.with_name(f".{target.name}.{uuid.uuid4().hex}.part")
    old = part.with_name(f"{part.name}.old")
    try:
        with naming(target):
            if target.suffix.casefold() == _ZARR:
                _to_zarr(dataset, part)
                if target.exists():  # a folder takes no other's place
                    os.replace(target, old)
            else:
                dataset.to_netcdf(part, engine="netcdf4", format="NETCDF4")
            os.replace(part, target)
            if old.exists():
                shutil.rmtree(old)
        sync_folder(target.parent)
    finally:
        if part.is_dir():
            shutil.rmtree(part, ignore_errors=True)
        else:
            part.unlink(missing_ok=True)


def _to_zarr(dataset: xr.Dataset, folder: Path) -> None:
    try:
        import zarr  # noqa: F401 - xarray's own error does not name the package
    except ImportError as error:
        raise MissingExtraError("zarr", "sweep", "a zarr folder") from error
    text = {name: array.astype(object) for name, array in dataset.variables.items() if array.dtype.kind == "U"}
    with warnings.catch_warnings():  # of the third format: how text is stored there is not settled
        warnings.simplefilter("ignore", UserWarning)
        warnings.simplefilter("ignore", FutureWarning)
        dataset.assign(text).to_zarr(folder, mode="w", consolidated=False)


def open_sweep(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read the dataset of a sweep into memory.

    Raises
    ------
    FileNotFoundError
        There is no such file.
    ResultFileError
        It is not the file of a sweep, or cannot be read.
    """
    source = Path(path)
    if not source.exists():
        raise FileNotFoundError(f"no file {source}: give the path of a sweep that semiwear wrote")
    try:
        if source.suffix.casefold() == _ZARR:
            with xr.open_zarr(source, consolidated=False) as opened:
                found: xr.Dataset = opened.load()
        else:
            with xr.open_dataset(no_pipe(source), engine="netcdf4") as opened:
                found = opened.load()
    except (OSError, ValueError, RuntimeError, KeyError) as error:
        raise ResultFileError(f"{source}: cannot be read as a sweep ({error})") from error
    if "varied" not in found.attrs or "status" not in found:
        raise ResultFileError(f"{source}: no sweep of semiwear; a result of one scene is for `semiwear report`")
    return found
