"""A worker process of a sweep: reads tasks from standard input, writes outcomes to standard output.

``python -m semiwear.sweep.local_worker`` is started by `semiwear.sweep.processes`. Unlike processes of
`multiprocessing` it does not run the user's script again, which therefore needs no guard.
"""

from __future__ import annotations

import os
import signal
import sys

from semiwear.sweep.outcome import solve_on_one_thread
from semiwear.sweep.pipe import READY, receive, send


def main() -> None:
    """Solve scenes until standard input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the driver decides
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # prints of libraries do not mix with outcomes
    tasks = sys.stdin.buffer
    send(answers, READY)
    while True:
        try:
            task = receive(tasks)
        except EOFError:
            return
        send(answers, solve_on_one_thread(task))  # type: ignore[arg-type]


if __name__ == "__main__":
    main()
