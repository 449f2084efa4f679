"""Errors of a contact problem's iterations, and the rounding in them.

Iterations compute the displacement in single precision only. Once the error is that of such a displacement, or falls
no further, the displacement is computed again in double precision; if that brings no gain, only rounding is left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_SINGLE_PRECISION = 2e-7  # times cells a side: error of the pressure (a quarter of it on fine grids)
_STALLS = 20  # iterations in which no error is less than nine tenths of an earlier one
_NO_GAIN = 0.5  # of the last error with an exact displacement: an error above it is rounding
_IDLE = 3  # exact displacements that gain nothing; a single one after a stall


@dataclass
class IterationErrors:
    """Errors of the iterations: when to compute the displacement again, and when only rounding is left.

    Attributes
    ----------
    single_precision : float
        Error of a pressure whose displacement is in single precision.
    """

    single_precision: float
    _best: float = np.inf
    _without: int = 0
    _stalled: bool = False
    _last: float = np.inf
    _idle: int = 0

    @classmethod
    def on(cls, cells: int) -> IterationErrors:
        """Errors of a problem of `cells` cells."""
        return cls(_SINGLE_PRECISION * cells**0.5)

    def small(self, error: float) -> bool:
        """Whether to compute the displacement again: the error is about that of single precision, or stalls."""
        if error <= self.single_precision:
            self.single_precision = 0.0
            return True
        self._best, self._without = (error, 0) if error < 0.9 * self._best else (self._best, self._without + 1)
        self._stalled = self._without >= _STALLS
        return self._stalled

    def rounding(self, error: float) -> bool:
        """Whether an error with an exact displacement is only rounding."""
        self._idle = self._idle + 1 if error > _NO_GAIN * self._last else 0
        most = 1 if self._stalled else _IDLE
        self._last, self._best, self._without, self._stalled = error, np.inf, 0, False
        return self._idle >= most
