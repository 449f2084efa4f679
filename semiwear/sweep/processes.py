"""Where a sweep runs on this machine: in this process, or in processes beside it."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO, cast

from semiwear.errors import SemiwearError
from semiwear.sweep.outcome import Outcome, Status, solve
from semiwear.sweep.pipe import READY, receive, send
from semiwear.sweep.scenes import Task
from semiwear.sweep.shares import Shares

__all__ = ["in_processes", "in_this_process"]

ATTEMPTS = 2
"""Processes that may die of a scene before it counts as lost."""

COMMAND = [sys.executable, "-m", "semiwear.sweep.local_worker"]


def in_this_process(tasks: Sequence[Task]) -> Iterator[Outcome]:
    """Outcomes, one after the other."""
    shares = Shares(tasks)
    while (task := shares.take(0)) is not None:
        yield solve(task)


def in_processes(tasks: Sequence[Task], workers: int) -> Iterator[Outcome]:
    """Outcomes as they come from so many processes.

    A process that dies is replaced, and its scene tried once more; if that kills a process, too, the scene is lost.

    Raises
    ------
    SemiwearError
        No process can be started.
    """
    shares = Shares(tasks)
    found: queue.Queue[Outcome | BaseException] = queue.Queue()
    crew = [_Hand(shares, found) for _ in range(min(workers, len(tasks)))]
    try:
        for hand in crew:
            hand.start()
        for _ in tasks:
            one = found.get()
            if isinstance(one, BaseException):
                raise one
            yield one
    finally:
        for hand in crew:
            hand.stop()
        for hand in crew:
            hand.join()


class _Died(Exception):
    """A worker process has ended; the message says how."""


class _Hand(threading.Thread):
    """Keeps one worker process busy."""

    def __init__(self, shares: Shares, found: queue.Queue[Outcome | BaseException]) -> None:
        super().__init__(daemon=True)
        self._shares, self._found = shares, found
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()
        self._stopped = False

    def run(self) -> None:
        """Solve scenes until none is left."""
        try:
            while not self._stopped and (task := self._shares.take(self.ident)) is not None:
                self._found.put(self._solved(task))
        except BaseException as error:  # it ends the sweep, in the thread that waits for its outcomes
            self._found.put(error)
        finally:
            self._end()

    def stop(self) -> None:
        """End the process, whatever it does."""
        with self._lock:
            self._stopped = True
            if self._process is not None:
                self._process.kill()

    def _solved(self, task: Task) -> Outcome:
        reasons: list[str] = []
        while len(reasons) < ATTEMPTS and not self._stopped:
            try:
                return self._asked(task)
            except _Died as error:
                self._end()
                reasons.append(str(error))
        reason = f"the process that solved it died: {', then '.join(reasons)}"
        return Outcome(task.key, Status.LOST, reason, lasting=False)

    def _asked(self, task: Task) -> Outcome:
        process = self._process or self._begun()
        try:
            send(cast(BinaryIO, process.stdin), task)
            return cast(Outcome, receive(cast(BinaryIO, process.stdout)))
        except (EOFError, OSError):
            raise _Died(_how_it_ended(process.wait())) from None

    def _begun(self) -> subprocess.Popen[bytes]:
        here = str(Path(__file__).parents[2])
        path = os.pathsep.join([here, *filter(None, [os.environ.get("PYTHONPATH")])])
        with self._lock:
            if self._stopped:
                raise _Died("the sweep was stopped")
            self._process = process = subprocess.Popen(
                COMMAND,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env={**os.environ, "PYTHONPATH": path},
            )
        try:
            ready = receive(cast(BinaryIO, process.stdout))
        except (EOFError, OSError):
            ready = None
        if ready != READY and not self._stopped:
            raise SemiwearError(
                f"no process can be started for the sweep ({_how_it_ended(process.wait())}); "
                "workers=0 computes in this one"
            )
        return process

    def _end(self) -> None:
        """Let the process go: it ends when nothing more can come."""
        with self._lock:
            process, self._process = self._process, None
        if process is None:
            return
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                with suppress(OSError):
                    stream.close()
        process.wait()


def _how_it_ended(status: int) -> str:
    if status >= 0:
        return f"exit status {status}"
    try:
        name = signal.Signals(-status).name
    except ValueError:
        name = f"signal {-status}"
    return f"{name}, which a machine short of memory sends" if name == "SIGKILL" else name
