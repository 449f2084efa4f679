"""Arrays of numbers in a page: quantised, compressed, as base64 text that a browser unpacks."""

from __future__ import annotations

import base64
import gzip

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.untyped import Table

_STEPS = 65535  # of 16 bits


class Packer:
    """Collection of arrays, each described by its offset, shape, least value and step.

    Values are stored as whole numbers of steps, 65535 over the range of their array, and are restored within 1/131070
    of that range.
    """

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._at = 0

    def add(self, values: FloatArray) -> Table:
        """Store an array; returns its description."""
        array = np.asarray(values, float)
        low = float(array.min()) if array.size else 0.0
        step = (float(array.max()) - low) / _STEPS if array.size else 0.0
        whole = np.rint((array - low) / step) if step > 0.0 else np.zeros(array.shape)
        data = whole.astype("<u2").tobytes()
        description = {"at": self._at, "shape": list(array.shape), "low": low, "step": step}
        self._parts.append(data)
        self._at += array.size
        return description

    def base64(self) -> str:
        """All stored arrays."""
        return base64.b64encode(gzip.compress(b"".join(self._parts), 9, mtime=0)).decode()
