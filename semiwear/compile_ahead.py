"""Compilation of kernels ahead of first runs, in as many processes as there are cores, each kernel by one of them.

A process claims a kernel once those that it calls are in the folder where numba keeps kernels, where later calls find
it.
"""

from __future__ import annotations

import gc
import inspect
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from numba.core.dispatcher import Dispatcher
from numba.core.errors import NumbaError

from semiwear.kernel_cache import on_first_compilation
from semiwear.kernel_list import ListedKernel, kernel_list
from semiwear.own_python import command_of, own_environment
from semiwear.threads import available_threads
from semiwear.untyped import CompilerPart

_PAUSE = 5e-3  # s between checks of what others have finished
_MOST = 6  # processes: more of them wait for one another
_LONGEST = 600.0  # s: a helper that is not ended by then ends by itself

_ready: set[str] = set()
"""Kinds of run whose kernels were found or compiled by this process."""


def compile_ahead(run: str, threads: int | None) -> None:
    """Compile the kernels of a kind of run in up to `threads` processes, if none are kept from an earlier one.

    Parameters
    ----------
    run : str
        As in the list of kernels.
    threads : int or None
        None: as many as there are cores for this process.
    """
    if run in _ready:
        return
    kernels = kernel_list(run)
    if not _kept(kernels):
        with suppress(OSError):  # no folder, no process: then each kernel is compiled when it is called
            _compile_in_processes(run, kernels, min(threads or available_threads(), _MOST) if _is_python() else 1)
    _ready.add(run)


def _compile_in_processes(run: str, kernels: Sequence[ListedKernel], count: int) -> None:
    """Compile kernels in `count` processes, this one among them."""
    with tempfile.TemporaryDirectory(prefix="semiwear-") as folder, ExitStack() as processes:
        helpers = [processes.enter_context(_helper(run, folder)) for _ in range(count - 1)]
        if _compile_shared(kernels, Path(folder), lambda: not any(helper.poll() for helper in helpers)):
            for helper in helpers:
                helper.wait()


def _is_python() -> bool:
    """Whether a process can be started as this one was: not from a program with Python built in."""
    return Path(sys.executable or "").stem.lower().startswith("python")


def _kept(kernels: Sequence[ListedKernel]) -> bool:
    """Load the kernels that Python calls; False if one is not kept: it is compiled, a short one from the end."""
    compiled: list[bool] = []
    with on_first_compilation(lambda: compiled.append(True)):
        for kernel in reversed(kernels):
            if kernel.called:
                _compile(kernel)
            if compiled:
                return False
    return True


@contextmanager
def _helper(run: str, folder: str) -> Iterator[subprocess.Popen[bytes]]:
    """A process that compiles with this one, and ends with the context."""
    nowhere = subprocess.DEVNULL
    command, environment = command_of("semiwear.compile_ahead", run, folder), own_environment()
    with subprocess.Popen(command, env=environment, stdin=nowhere, stdout=nowhere, stderr=nowhere) as process:
        try:
            yield process
        finally:
            process.terminate()


def _compile_shared(kernels: Sequence[ListedKernel], folder: Path, others: Callable[[], bool]) -> bool:
    """Claim and compile kernels until all are claimed, by this process or by `others`.

    The folder holds a file for every kernel that is claimed, and one more when it is compiled. Returns False where
    kernels remain that wait for processes which have ended.
    """
    waits = _waits_for(kernels)
    unclaimed = list(range(len(kernels)))
    with _no_garbage_collected():
        while unclaimed:
            done = {int(path.stem) for path in folder.glob("*.done")}
            ready = next((i for i in unclaimed if waits[i] <= done), None)
            if ready is None:
                if not others():
                    return False
                time.sleep(_PAUSE)
                continue
            unclaimed.remove(ready)
            if _claimed(folder / f"{ready}.claimed"):
                _compile(kernels[ready])
                (folder / f"{ready}.done").touch()
    return True


def _claimed(path: Path) -> bool:
    """Create a file; False if another process has created it."""
    try:
        path.touch(exist_ok=False)
    except FileExistsError:
        return False
    return True


def _compile(kernel: ListedKernel) -> None:
    with suppress(NumbaError):  # types that have changed: the call gives the right ones
        kernel.kernel.compile(kernel.types)


def _waits_for(kernels: Sequence[ListedKernel]) -> list[set[int]]:
    """Numbers of the kernels that each one calls, directly or not."""
    numbers: dict[CompilerPart, list[int]] = {}
    for number, listed in enumerate(kernels):
        numbers.setdefault(listed.kernel, []).append(number)
    return [{j for called in called_by(listed.kernel) for j in numbers.get(called, ())} for listed in kernels]


def called_by(kernel: CompilerPart) -> set[CompilerPart]:
    """Kernels that a kernel calls, directly or not."""
    found: set[CompilerPart] = set()
    left = [kernel]
    while left:
        names = inspect.getclosurevars(left.pop().py_func)
        named = {value for value in {**names.globals, **names.nonlocals}.values() if isinstance(value, Dispatcher)}
        left += named - found
        found |= named
    return found - {kernel}


@contextmanager
def _no_garbage_collected() -> Iterator[None]:
    """Stop garbage collection while numba creates very many objects, which saves an eighth of the time."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


def _help(run: str, folder: Path) -> None:
    """Compile together with the process that has made the folder."""
    end = time.monotonic() + _LONGEST
    _compile_shared(kernel_list(run), folder, lambda: folder.exists() and time.monotonic() < end)


if __name__ == "__main__":
    _help(sys.argv[1], Path(sys.argv[2]))
