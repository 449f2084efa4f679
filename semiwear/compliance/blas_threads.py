"""One thread for dense algebra: the matrices here are small, and handing them round costs more than it saves.

More threads also sum in another order, and results would hang on their number in the last digits.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

import scipy.linalg  # noqa: F401 - a BLAS is found only once it is loaded; numpy's comes with it
from threadpoolctl import ThreadpoolController

__all__ = ["one_blas_thread"]


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Hold BLAS to one thread."""
    with _libraries().limit(limits=1, user_api="blas"):
        yield


@cache
def _libraries() -> ThreadpoolController:
    """The libraries of this process, looked for once: that takes a tenth of a run with a coarse grid."""
    return ThreadpoolController()
