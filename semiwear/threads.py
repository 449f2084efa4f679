"""Threads: independent parts of a piece of work, at once on the cores that a run may use.

Results do not depend on the number of threads: each part writes its own data, and sums over parts, which are always
divided in the same way, are taken in their order. Kernels release Python's lock.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from typing import NamedTuple, TypeVar

import numpy as np

from semiwear.arrays import IntArray

Item = TypeVar("Item")
Result = TypeVar("Result")

SHARES = 8  # parts of a piece of work: enough for threads to end at about the same time


class _Helpers(NamedTuple):
    """Threads beside the one that distributes the work, and their number."""

    pool: ThreadPoolExecutor
    number: int


_helpers: ContextVar[_Helpers | None] = ContextVar("helpers", default=None)


def available_threads() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def using_threads(count: int | None) -> Iterator[None]:
    """Distribute work among `count` threads; None: among all cores that the process may use."""
    count = available_threads() if count is None else count
    with _with_helpers(None) if count == 1 else _helping(count - 1):
        yield


@contextmanager
def _with_helpers(helpers: _Helpers | None) -> Iterator[None]:
    token = _helpers.set(helpers)
    try:
        yield
    finally:
        _helpers.reset(token)


@contextmanager
def _helping(count: int) -> Iterator[None]:
    with ThreadPoolExecutor(count, thread_name_prefix="semiwear") as pool, _with_helpers(_Helpers(pool, count)):
        yield


def in_shares(work: Callable[[IntArray], Result], items: IntArray) -> list[Result]:
    """Results of `work` on up to `SHARES` runs of consecutive items, in their order.

    Work that such a part distributes again stays on its thread.
    """
    return _shared_out(work, np.array_split(items, min(SHARES, items.size)) if items.size else [])


def in_loose_shares(work: Callable[[IntArray], Result], items: IntArray) -> list[Result]:
    """As `in_shares`, for items that are independent of one another: a single thread does them all in one call."""
    return in_shares(work, items) if _helpers.get() or not items.size else [work(items)]


def in_threads(work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """Results of `work` on a few large items, in their order."""
    return _shared_out(work, list(items))


def _shared_out(work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """Results of `work`: every thread takes the next item until none is left, this one among them."""
    helpers = _helpers.get()
    if helpers is None or len(items) < 2:
        return [work(item) for item in items]
    left, lock = iter(range(len(items))), threading.Lock()
    found: dict[int, Result] = {}
    failed: dict[int, Exception] = {}

    def take() -> None:
        while True:
            with lock:
                number = next(left, None)
            if number is None:
                return
            try:
                found[number] = work(items[number])
            except Exception as error:
                failed[number] = error

    helping = [helpers.pool.submit(take) for _ in range(min(helpers.number, len(items) - 1))]
    with _with_helpers(None):
        take()
    for helper in helping:
        if not helper.cancel():  # it has begun
            helper.result()
    if failed:
        raise failed[min(failed)]
    return [found[number] for number in range(len(items))]
