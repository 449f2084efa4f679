"""One thread for dense algebra: the matrices here are small, and distributing them costs more than it saves.

More threads also sum in another order, and results would depend on their number in the last digits.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache

from threadpoolctl import ThreadpoolController


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Hold BLAS to one thread."""
    with _libraries(len(sys.modules)).limit(limits=1, user_api="blas"):
        yield


@lru_cache(maxsize=1)
def _libraries(modules: int) -> ThreadpoolController:
    """The BLAS libraries of this process, cached by the number of imported modules: new modules may load others.

    The search for them takes a tenth of a run with a coarse grid.
    """
    return ThreadpoolController()
