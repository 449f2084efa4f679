"""Threads: independent shares of a piece of work, at once on the cores that a run may use.

Results do not depend on the number of threads: a share writes what no other share touches, and sums over shares that
are always cut alike are taken in their order. Kernels let go of Python's lock.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

import numpy as np

from semiwear.arrays import IntArray

__all__ = ["available_threads", "in_shares", "in_threads", "using_threads"]

Item = TypeVar("Item")
Result = TypeVar("Result")

SHARES = 8  # of a piece of work: enough that threads end at about the same time

_pool: ContextVar[ThreadPoolExecutor | None] = ContextVar("pool", default=None)


def available_threads() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def using_threads(count: int | None) -> Iterator[None]:
    """Let work be shared out among so many threads; None: among all cores that the process may use."""
    count = available_threads() if count is None else count
    if count == 1:
        token = _pool.set(None)
        try:
            yield
        finally:
            _pool.reset(token)
        return
    with ThreadPoolExecutor(count, thread_name_prefix="semiwear") as pool:
        token = _pool.set(pool)
        try:
            yield
        finally:
            _pool.reset(token)


def in_shares(work: Callable[[IntArray], Result], items: IntArray) -> list[Result]:
    """Results of `work` on up to `SHARES` runs of consecutive items, in their order.

    Work that is shared out again by such a share stays on its thread.
    """
    shares = np.array_split(items, min(SHARES, items.size)) if items.size else []
    pool = _pool.get()
    if pool is None or len(shares) < 2:
        return [work(share) for share in shares]
    return list(pool.map(work, shares))


def in_threads(work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """Results of `work` on a few large items, in their order."""
    pool = _pool.get()
    return [work(item) for item in items] if pool is None else list(pool.map(work, items))
