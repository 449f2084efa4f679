"""Errors of a contact problem's iterations, and the rounding in them.

Iterations know their displacement in single precision alone. Once their error is that of such a displacement, or
falls no further, it has to be found anew; where that gains nothing, rounding is left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["IterationErrors"]

_ROUGH = 2e-7  # times cells a side: error of a pressure whose displacement is rough (a quarter of it on fine grids)
_STALLS = 20  # iterations in which no error is less than nine tenths of an earlier one
_NO_GAIN = 0.5  # of the last error that was found with an exact displacement: more is left of it by rounding
_IDLE = 3  # exact displacements that gain nothing; a single one after a stall


@dataclass
class IterationErrors:
    """Errors of the iterations, which tell when to find the displacement anew, and when only rounding is left.

    Attributes
    ----------
    rough : float
        Error of a pressure whose displacement is in single precision.
    """

    rough: float
    _best: float = np.inf
    _without: int = 0
    _stalled: bool = False
    _last: float = np.inf
    _idle: int = 0

    @classmethod
    def on(cls, cells: int) -> IterationErrors:
        """Those of a problem of so many cells."""
        return cls(_ROUGH * cells**0.5)

    def small(self, error: float) -> bool:
        """Whether to find the displacement anew: the error is about that of rough displacements, or stalls."""
        if error <= self.rough:
            self.rough = 0.0
            return True
        self._best, self._without = (error, 0) if error < 0.9 * self._best else (self._best, self._without + 1)
        self._stalled = self._without >= _STALLS
        return self._stalled

    def rounding(self, error: float) -> bool:
        """Whether an error with an exact displacement is the rounding that is left."""
        self._idle = self._idle + 1 if error > _NO_GAIN * self._last else 0
        most = 1 if self._stalled else _IDLE
        self._last, self._best, self._without, self._stalled = error, np.inf, 0, False
        return self._idle >= most
