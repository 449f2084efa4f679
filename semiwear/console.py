"""Standard output and error that may break, at no one's loss: a run goes on when its reader has gone."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from typing import TextIO

__all__ = ["Streams", "tolerant_streams"]


class _Tolerant:
    """A text stream whose failures are noted; what follows one is dropped."""

    def __init__(self, stream: TextIO):
        self._stream = stream
        self.failure: OSError | None = None

    def write(self, text: str) -> int:
        """Write what can be written."""
        self._attempt(lambda: self._stream.write(text))
        return len(text)

    def flush(self) -> None:
        """Flush, likewise."""
        self._attempt(self._stream.flush)

    def _attempt(self, action: Callable[[], object]) -> None:
        if self.failure is not None or self._stream is None:  # no stream at all in a process without a terminal
            return
        try:
            action()
        except OSError as error:
            self.failure = error
            self._drop()

    def _drop(self) -> None:
        """Send what is still in the buffer nowhere, or the interpreter would try, and complain, as it ends."""
        with suppress(OSError, ValueError, AttributeError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            try:
                os.dup2(nowhere, self._stream.fileno())
            finally:
                os.close(nowhere)

    def __getattr__(self, name: str) -> object:
        return getattr(self._stream, name)


class Streams:
    """How it went with standard output and error.

    Parameters
    ----------
    output, error : streams
    """

    def __init__(self, output: TextIO, error: TextIO):
        self.output, self.error = _Tolerant(output), _Tolerant(error)

    @property
    def failed(self) -> bool:
        """Whether output was lost that someone still waited for: a full disk, and not a reader that has gone."""
        return any(
            one.failure is not None and not isinstance(one.failure, BrokenPipeError)
            for one in (self.output, self.error)
        )


@contextmanager
def tolerant_streams() -> Iterator[Streams]:
    """Let writing to standard output and error never end what is done inside."""
    streams = Streams(sys.stdout, sys.stderr)
    with redirect_stdout(streams.output), redirect_stderr(streams.error):
        try:
            yield streams
        finally:
            streams.output.flush()
            failure = streams.output.failure
            if failure is not None and not isinstance(failure, BrokenPipeError):
                streams.error.write(f"semiwear: standard output cannot be written ({failure.strerror})\n")
            streams.error.flush()
