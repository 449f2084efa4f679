"""Seconds that effects take by themselves."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager


class EffectClock:
    """Adds up seconds under the names of effects."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def measure(self, effect: str) -> Iterator[None]:
        """Add the time of the work inside."""
        begin = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[effect] = self.seconds.get(effect, 0.0) + time.perf_counter() - begin
