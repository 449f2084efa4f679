"""The decorator of kernels, and where numba keeps what it compiles.

numba looks for a folder that it can write: NUMBA_CACHE_DIR, beside the sources, in the user's home. In a container or
under a service account there may be none, and it would refuse to declare a kernel at all. Then a private folder
for temporary files takes them.
"""

from __future__ import annotations

import os
import stat
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numba
import numpy as np
from numba.core import event

from semiwear.errors import SemiwearError

__all__ = ["ZERO", "ensure_cache", "inner_njit", "keep_apart", "njit", "telling_of_compilation"]


def _counting(counted: bool) -> dict[str, bool]:
    """Option of numba to count references or not; none where it knows none: inner kernels are slower then."""
    try:
        from numba.core.cpu import CPUTargetOptions
    except ImportError:
        return {}
    return {"_nrt": counted} if hasattr(CPUTargetOptions, "_nrt") else {}


njit = partial(numba.njit, no_cfunc_wrapper=True, fastmath=False, **_counting(True))
"""The decorator of kernels: without an entry for C, which nothing calls and an eighth of compilation goes to.

Sums are reordered in the kernels that say so themselves. Where nothing is said, numba takes it from whichever kernel
is the first to call this one.
"""
inner_njit = partial(njit, **_counting(False))
"""The decorator of kernels that others call in their loops: they work in memory that they are given.

numba counts references whenever a part of an array is read, a third of the time of such a kernel. Where nothing is
made and no array is handed back there is nothing to count. numba refuses to compile a kernel of this kind that makes
an array; that none returns an array, or calls what does, is for a test to hold.
"""
ZERO = np.int64(0)
"""Where kernels begin to count: numba compiles anew for a plain 0 that is handed on, which is a type of its own."""


def _kernel() -> None:
    """Stands for all kernels."""


def ensure_cache() -> None:
    """Let numba have a folder that it can write.

    Raises
    ------
    SemiwearError
        There is none on this machine.
    """
    if _works():
        return
    try:
        folder = _private_folder()
    except OSError as error:
        raise SemiwearError(
            f"no folder can take compiled kernels, not even one for temporary files ({error.strerror or error}): set "
            "NUMBA_CACHE_DIR to a folder that can be written"
        ) from error
    numba.config.CACHE_DIR = folder  # type: ignore[attr-defined]
    os.environ["NUMBA_CACHE_DIR"] = folder  # for processes that this one starts
    print(
        f"semiwear: neither its own folder nor your home can be written: compiled kernels are kept in {folder}; set "
        "NUMBA_CACHE_DIR to a folder that stays",
        file=sys.stderr,
    )


def keep_apart(name: str) -> None:
    """Keep kernels that are declared from here on in a folder of their own, apart from those of the usual kind.

    numba does not see that a function which a kernel calls is another one than when the kernel was compiled.
    """
    folder = Path(numba.config.CACHE_DIR or _private_folder()) / name  # type: ignore[attr-defined]
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    numba.config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]


class _FirstCompilation(event.Listener):
    """Calls a function when the first kernel is compiled, rather than found in its folder."""

    def __init__(self, tell: Callable[[], None]):
        self._tell, self._told = tell, False

    def on_start(self, event: event.Event) -> None:
        """A kernel is about to be compiled."""
        if not self._told:
            self._told = True
            self._tell()

    def on_end(self, event: event.Event) -> None:
        """It has been."""


@contextmanager
def telling_of_compilation(tell: Callable[[], None]) -> Iterator[None]:
    """Call `tell` once if kernels have to be compiled inside."""
    listener = _FirstCompilation(tell)
    event.register("numba:compile", listener)  # type: ignore[no-untyped-call]
    try:
        yield
    finally:
        event.unregister("numba:compile", listener)  # type: ignore[no-untyped-call]


def _works() -> bool:
    """Whether a kernel can be declared; it is not compiled."""
    try:
        numba.njit(cache=True)(_kernel)
    except (RuntimeError, OSError):
        return False
    return True


def _private_folder() -> str:
    """A folder that no one else can write: numba runs what it finds there. An earlier process's serves again."""
    user = getattr(os, "getuid", lambda: "user")()
    folder = Path(tempfile.gettempdir()) / f"semiwear-kernels-{user}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
        own = stat.S_ISDIR(found.st_mode) and found.st_uid == user and not found.st_mode & 0o077
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError:
        own = False
    return str(folder) if own else tempfile.mkdtemp(prefix="semiwear-kernels-")


ensure_cache()
