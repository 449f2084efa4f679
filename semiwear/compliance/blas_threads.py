"""One thread for dense algebra: the matrices here are small, and handing them round costs more than it saves.

More threads also sum in another order, and results would hang on their number in the last digits.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits

__all__ = ["one_blas_thread"]


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Hold BLAS to one thread."""
    with threadpool_limits(1, user_api="blas"):
        yield
