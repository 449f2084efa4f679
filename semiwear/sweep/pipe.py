"""Objects through the pipe between a sweep and its worker processes, each after its length."""

from __future__ import annotations

import pickle
import struct
from typing import BinaryIO

__all__ = ["READY", "receive", "send"]

READY = "ready"
"""First word of a worker that has loaded what it computes with."""

_LENGTH = struct.Struct(">Q")


def send(stream: BinaryIO, what: object) -> None:
    """Write one object."""
    content = pickle.dumps(what, protocol=5)
    stream.write(_LENGTH.pack(len(content)))
    stream.write(content)
    stream.flush()


def receive(stream: BinaryIO) -> object:
    """Read one object.

    Raises
    ------
    EOFError
        The other side has gone.
    """
    head = stream.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        raise EOFError
    (length,) = _LENGTH.unpack(head)
    content = stream.read(length)
    if len(content) < length:
        raise EOFError
    return pickle.loads(content)
