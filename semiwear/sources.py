"""Files that are read: sizes are checked before anything is loaded."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from xarray import Dataset

MOST_VALUES = 10_000_000
"""Greatest number of values of a variable: far beyond any flank, and loaded within a second."""

NETCDF = (b"\x89HDF\r\n\x1a\n", b"CDF\x01", b"CDF\x02", b"CDF\x05")
"""How netCDF files begin."""


def no_pipe(file: Path) -> Path:
    """The path of a file that is to be read, which is no pipe: opening a pipe without a writer would wait for ever.

    Raises
    ------
    OSError
        It is a pipe or a socket.
    """
    if file.is_fifo() or file.is_socket():
        raise OSError("it is a pipe or a socket, which may have no writer: save its content, and give that file")
    return file


def is_netcdf(file: Path) -> bool:
    """Whether a file begins like netCDF."""
    with file.open("rb") as opened:
        return opened.read(8).startswith(NETCDF)


def oversized(file: Path) -> str:
    """Variable of a netCDF file with more values than a flank can have, and their number; empty if there is none.

    Values that were declared and never written take no room on a disk, but do in memory.
    """
    import netCDF4  # few scenes name such a file

    try:
        with netCDF4.Dataset(file) as opened:
            for name, variable in opened.variables.items():
                if (size := math.prod(map(int, variable.shape))) > MOST_VALUES:
                    return f"{name} has {' x '.join(map(str, variable.shape))} = {size:.3g} values"
    except (OSError, RuntimeError):
        return ""  # reading it reports what is wrong
    return ""


def read_dataset(file: Path) -> Dataset:
    """A netCDF file in memory.

    Raises
    ------
    OSError, ValueError
        It cannot be read.
    """
    import xarray as xr  # few scenes name such a file

    with xr.open_dataset(file, engine="netcdf4") as opened:
        return opened.load()
