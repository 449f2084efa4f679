"""First runs: a second process compiles the kernels that are needed last."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from semiwear.kernel_cache import telling_of_compilation
from semiwear.scene import Scene
from semiwear.threads import available_threads

__all__ = ["compiling_ahead"]

_LATE = ("-m", "semiwear.commands.late_kernels")


@contextmanager
def compiling_ahead(scene: Scene) -> Iterator[None]:
    """Inside, the first kernel that has to be compiled starts a process for the late ones, where a core is free.

    Only for a scene that needs them: wear at fidelity line.
    """
    threads = scene.numerics.threads or available_threads()
    if threads == 1 or scene.wear is None or scene.numerics.fidelity != "line" or not sys.executable:
        yield
        return
    started: list[subprocess.Popen[bytes]] = []

    def start() -> None:
        with suppress(OSError):  # then all is compiled here
            nowhere = subprocess.DEVNULL
            command = [sys.executable, *_LATE]
            started.append(subprocess.Popen(command, stdin=nowhere, stdout=nowhere, stderr=nowhere))

    with telling_of_compilation(start):
        try:
            yield
        finally:
            for process in started:
                process.terminate()
                process.wait()
