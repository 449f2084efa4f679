"""Objects through the pipe between a sweep and its worker processes, each after its length."""

from __future__ import annotations

import pickle
import struct
from typing import BinaryIO

READY = "ready"
"""First message of a worker that has loaded its modules."""

_LENGTH = struct.Struct(">Q")


def send(stream: BinaryIO, item: object) -> None:
    """Write one object."""
    content = pickle.dumps(item, protocol=5)
    stream.write(_LENGTH.pack(len(content)))
    stream.write(content)
    stream.flush()


def receive(stream: BinaryIO) -> object:
    """Read one object.

    Raises
    ------
    EOFError
        The other process has ended.
    """
    head = stream.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        raise EOFError
    (length,) = _LENGTH.unpack(head)
    content = stream.read(length)
    if len(content) < length:
        raise EOFError
    return pickle.loads(content)
