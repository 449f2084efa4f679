"""A sweep on this machine: in this process, or in worker processes."""

from __future__ import annotations

import queue
import signal
import subprocess
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import BinaryIO, Self, cast

from semiwear.errors import SemiwearError
from semiwear.own_python import command_of, own_environment
from semiwear.sweep.outcome import Outcome, Status, solve, solve_on_one_thread
from semiwear.sweep.pipe import READY, receive, send
from semiwear.sweep.scenes import Task
from semiwear.sweep.shares import Shares

ATTEMPTS = 2
"""Number of processes that may die on a scene before it counts as lost."""

COMMAND = command_of("semiwear.sweep.local_worker")


class Crew:
    """Worker processes that solve scenes one after the other, and end with the `with` block.

    A process that dies is replaced, and its scene tried once more; if that kills a process, too, the scene is lost.

    Parameters
    ----------
    workers : int
        Processes; 0: everything is solved in this one.
    helped : bool
        Whether this process is one of them: it has earlier solutions in memory. A scene that kills its
        process then ends this one, too.
    """

    def __init__(self, workers: int, *, helped: bool = False) -> None:
        self._helped = helped and workers > 0
        self._hands = [_Hand() for _ in range(workers - self._helped)]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for hand in self._hands:
            hand.end()

    def call(self) -> None:
        """Start the processes; otherwise each starts with its first scene."""
        for hand in self._hands:
            hand.call()

    def solve(self, tasks: Sequence[Task]) -> Iterator[Outcome]:
        """Outcomes as they come.

        Raises
        ------
        SemiwearError
            No process can be started.
        """
        shares = Shares(tasks)
        if not (self._hands or self._helped):
            while (task := shares.take(0)) is not None:
                yield solve(task)
            return
        found: queue.Queue[Outcome | BaseException] = queue.Queue()
        with _at_work(self._hands[: len(tasks) - self._helped], shares, found):
            for _ in tasks:
                if self._helped and found.empty() and (task := shares.take(self)) is not None:
                    yield solve_on_one_thread(task)
                    continue
                result = found.get()
                if isinstance(result, BaseException):
                    raise result
                yield result


@contextmanager
def _at_work(hands: Sequence[_Hand], shares: Shares, found: queue.Queue[Outcome | BaseException]) -> Iterator[None]:
    """Let each hand work in a thread; their processes continue unless the block is left before its end."""
    threads = [threading.Thread(target=hand.work, args=(shares, found), daemon=True) for hand in hands]
    for hand, thread in zip(hands, threads, strict=True):
        hand.stopped = False
        thread.start()
    whole = False
    try:
        yield
        whole = True
    finally:
        for hand in hands:
            if not whole:
                hand.stop()
        for thread in threads:
            thread.join()
        for hand in hands:
            if not whole:
                hand.end()


class _Died(Exception):
    """A worker process has ended, as the message states."""


class _Hand:
    """One worker process at a time."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._ready = False
        self._lock = threading.Lock()
        self.stopped = False

    def work(self, shares: Shares, found: queue.Queue[Outcome | BaseException]) -> None:
        """Solve scenes until none is left."""
        try:
            while not self.stopped and (task := shares.take(self)) is not None:
                found.put(self._solved(task))
        except BaseException as error:  # raised again in the thread that waits for outcomes
            found.put(error)

    def stop(self) -> None:
        """Kill the process."""
        with self._lock:
            self.stopped = True
            if self._process is not None:
                self._process.kill()

    def _solved(self, task: Task) -> Outcome:
        reasons: list[str] = []
        while len(reasons) < ATTEMPTS and not self.stopped:
            try:
                return self._sent(task)
            except _Died as error:
                self.end()
                reasons.append(str(error))
        reason = f"the process that solved it died: {', then '.join(reasons)}"
        return Outcome(task.key, Status.LOST, reason, lasting=False)

    def _sent(self, task: Task) -> Outcome:
        process = self._begun()
        try:
            send(cast(BinaryIO, process.stdin), task)
            return cast(Outcome, receive(cast(BinaryIO, process.stdout)))
        except (EOFError, OSError):
            raise _Died(_end_text(process.wait())) from None

    def call(self) -> None:
        """Start a process, which need not be ready yet."""
        with self._lock:
            if self.stopped:
                raise _Died("the sweep was stopped")
            self._ready = False
            self._process = subprocess.Popen(
                COMMAND,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env=own_environment(),
            )

    def _begun(self) -> subprocess.Popen[bytes]:
        """The process, ready for a scene."""
        if self._process is None:
            self.call()
        process = cast("subprocess.Popen[bytes]", self._process)
        if self._ready:
            return process
        with suppress(EOFError, OSError):
            self._ready = receive(cast(BinaryIO, process.stdout)) == READY
        if not self._ready and not self.stopped:
            raise SemiwearError(
                f"no process can be started for the sweep ({_end_text(process.wait())}); "
                "workers=0 computes in this one"
            )
        return process

    def end(self) -> None:
        """Close the process's pipes, on which it ends."""
        with self._lock:
            process, self._process = self._process, None
        if process is None:
            return
        if not self._ready:
            process.kill()  # nobody would read its outcome
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                with suppress(OSError):
                    stream.close()
        process.wait()


def _end_text(status: int) -> str:
    if status >= 0:
        return f"exit status {status}"
    try:
        name = signal.Signals(-status).name
    except ValueError:
        name = f"signal {-status}"
    return f"{name}, which a machine short of memory sends" if name == "SIGKILL" else name
