"""The decorator of kernels, and where numba keeps what it compiles.

numba looks for a folder that it can write: NUMBA_CACHE_DIR, beside the sources, in the user's home. In a container or
under a service account there may be none, and it would refuse to declare a kernel at all. A private folder for
temporary files is then used.
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


def _counting(counted: bool) -> dict[str, bool]:
    """Option of numba to count references or not; empty if it has none, with which inner kernels are slower."""
    try:
        from numba.core.cpu import CPUTargetOptions
    except ImportError:
        return {}
    return {"_nrt": counted} if hasattr(CPUTargetOptions, "_nrt") else {}


njit = partial(numba.njit, no_cfunc_wrapper=True, fastmath=False, **_counting(True))
"""The decorator of kernels: without the entry for C, which is not used and takes an eighth of compilation.

Sums are reordered only in kernels that state so. Without a statement, numba would take the option of whichever kernel
is the first to call this one.
"""
inner_njit = partial(njit, **_counting(False))
"""The decorator of kernels that others call in their loops: they work in memory that they are given.

numba counts references whenever a part of an array is read, which takes a third of the time of such a kernel. A
kernel that creates and returns no array needs no counts. numba refuses to compile a kernel of this kind that creates
an array; a test checks that none returns an array, or calls a kernel that does.
"""
ZERO = np.int64(0)
"""First index in kernels: numba compiles again for a plain 0 that is passed on, which is a type of its own."""


def _kernel() -> None:
    """A kernel to test the declaration of kernels with."""


def ensure_cache() -> None:
    """Give numba a folder that it can write.

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
    """Keep kernels that are declared from here on in a separate folder.

    numba does not notice that a function which a kernel calls has changed since the kernel was compiled.
    """
    folder = Path(numba.config.CACHE_DIR or _private_folder()) / name  # type: ignore[attr-defined]
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    numba.config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]


class _FirstCompilation(event.Listener):
    """Calls a function when the first kernel is compiled, rather than found in its folder."""

    def __init__(self, call: Callable[[], None]):
        self._call, self._called = call, False

    def on_start(self, event: event.Event) -> None:
        """Call the function before the first compilation."""
        if not self._called:
            self._called = True
            self._call()

    def on_end(self, event: event.Event) -> None:
        """Do nothing after a compilation."""


@contextmanager
def on_first_compilation(call: Callable[[], None]) -> Iterator[None]:
    """Call a function once if kernels have to be compiled inside."""
    listener = _FirstCompilation(call)
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
    """A folder that only this user can write, as numba runs its content; an earlier process's if there is one."""
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
