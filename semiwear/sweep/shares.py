"""Order in which workers take scenes: those that share contact lines stay together on one worker."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Hashable, Iterable

from semiwear.sweep.scenes import Task, shared_by

__all__ = ["Shares"]


class Shares:
    """Scenes that are still to be solved, by what they share.

    A worker goes on with the group that it has begun, then takes one that no one has, of the same teeth if there is
    one, and at last helps with the group of which most is left.

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
        """Scenes that no worker has."""
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
            near = [group for group in free if own is not None and group[0] == own[0]]
            self._taken[worker] = (near or free)[0]
            return self._taken[worker]
        return max(self._groups, key=lambda group: len(self._groups[group]), default=None)
