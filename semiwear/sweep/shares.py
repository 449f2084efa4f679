"""Order in which workers take scenes: those with common contact lines stay on one worker."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Hashable, Iterable

from semiwear.sweep.scenes import Task, shared_by


class Shares:
    """Remaining scenes, grouped by their common data.

    A worker continues with the group that it has begun, then takes a free one, of the same teeth if possible, and
    finally helps with the largest remaining group.

    Parameters
    ----------
    tasks : iterable of Task
    """

    def __init__(self, tasks: Iterable[Task]) -> None:
        groups: dict[tuple[str, str], deque[Task]] = {}
        for task in tasks:
            groups.setdefault(shared_by(task), deque()).append(task)
        self._groups = groups
        self._taken: dict[Hashable, tuple[str, str]] = {}
        self._lock = threading.Lock()

    def __len__(self) -> int:
        """Number of scenes that no worker has."""
        with self._lock:
            return sum(map(len, self._groups.values()))

    def take(self, worker: Hashable) -> Task | None:
        """The next scene for a worker; None where none is left."""
        with self._lock:
            group = self._group_for(worker)
            if group is None:
                return None
            left = self._groups[group]
            # a helper takes from the end, where the group's own worker comes last
            task = left.popleft() if self._taken.get(worker) == group else left.pop()
            if not left:
                del self._groups[group]
            return task

    def _group_for(self, worker: Hashable) -> tuple[str, str] | None:
        own = self._taken.get(worker)
        if own in self._groups:
            return own
        others = {group for name, group in self._taken.items() if name != worker}
        free = [group for group in self._groups if group not in others]
        if free:
            same_teeth = [group for group in free if own is not None and group[0] == own[0]]
            self._taken[worker] = (same_teeth or free)[0]
            return self._taken[worker]
        return max(self._groups, key=lambda group: len(self._groups[group]), default=None)
