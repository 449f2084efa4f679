"""Standard output and error: streams that tolerate failures, notes, and results as JSON."""

from __future__ import annotations

import io
import json
import logging
import math
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, redirect_stderr, redirect_stdout, suppress
from typing import TextIO

from semiwear.errors import SceneError
from semiwear.untyped import Table, Value

_OF_THE_COMMAND_LINE = ("semiwear.commands", "semiwear.cli", "semiwear.console")


class _Tolerant:
    """A text stream that records its first failure and drops later output."""

    def __init__(self, stream: TextIO):
        self._stream = stream
        self.failure: OSError | None = None

    def write(self, text: str) -> int:
        """Write unless the stream has failed."""
        self._attempt(lambda: self._stream.write(text))
        return len(text)

    def flush(self) -> None:
        """Flush unless the stream has failed."""
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
        """Discard the buffer, which the interpreter would otherwise try to write, with an error, when it ends."""
        with suppress(OSError, ValueError, AttributeError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            try:
                os.dup2(nowhere, self._stream.fileno())
            finally:
                os.close(nowhere)

    def __getattr__(self, name: str) -> object:
        return getattr(self._stream, name)


class Streams:
    """Standard output and error with their failures.

    Parameters
    ----------
    output, error : streams
    """

    def __init__(self, output: TextIO, error: TextIO):
        self.output, self.error = _Tolerant(output), _Tolerant(error)

    @property
    def failed(self) -> bool:
        """Whether output was lost by a failure, such as a full disk, other than a closed reader."""
        return any(
            stream.failure is not None and not isinstance(stream.failure, BrokenPipeError)
            for stream in (self.output, self.error)
        )


@contextmanager
def tolerant_streams() -> Iterator[Streams]:
    """Standard output and error whose failures do not end the work inside."""
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


class _Notes(logging.Handler):
    """Notes of the command line, and warnings of the package, on the present standard error."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print the note."""
        if record.levelno >= logging.WARNING or record.name.startswith(_OF_THE_COMMAND_LINE):
            print(record.getMessage(), file=sys.stderr, flush=True)


@contextmanager
def notes_on_standard_error(quiet: bool) -> Iterator[None]:
    """Show notes of the loggers under ``semiwear``; only warnings of a quiet command."""
    logger, handler = logging.getLogger("semiwear"), _Notes()
    level, propagate, standard_format = logger.level, logger.propagate, warnings.formatwarning

    def as_a_note(
        message: Warning | str, category: type[Warning], filename: str, lineno: int, line: str | None = None
    ) -> str:
        if issubclass(category, UserWarning):
            return f"semiwear: {message}\n"
        return standard_format(message, category, filename, lineno, line)

    logger.addHandler(handler)
    logger.setLevel(logging.WARNING if quiet else logging.INFO)
    logger.propagate = False
    warnings.formatwarning = as_a_note
    try:
        yield
    finally:
        warnings.formatwarning = standard_format
        logger.removeHandler(handler)
        logger.setLevel(level)
        logger.propagate = propagate


def hidden_output(hidden: bool) -> redirect_stdout[io.StringIO] | nullcontext[None]:
    """Discard what a command prints for people, if its result is read by a program."""
    return redirect_stdout(io.StringIO()) if hidden else nullcontext()


def as_json(result: Table) -> str:
    """A command's result as one JSON document; NaN and missing values are null."""
    return json.dumps(_plain(result), indent=1, ensure_ascii=False, allow_nan=False)


def error_as_json(error: Exception) -> str:
    """An error as one JSON document: its kind, its message, and the problems of a scene one by one."""
    report: Table = {"error": type(error).__name__, "message": str(error)}
    if isinstance(error, SceneError):
        report["problems"] = [
            {
                "field": problem.field,
                "found": _json_value(problem.value),
                "allowed": problem.allowed,
                "fix": problem.fix,
            }
            for problem in error.problems
        ]
    return as_json(report)


def _json_value(value: Value) -> Value:
    return value if value is None or isinstance(value, bool | int | float | str) else repr(value)


def _plain(value: Value) -> Value:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):  # of numpy
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if value is None or isinstance(value, bool | int | float) else str(value)
