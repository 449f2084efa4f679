"""A sweep on a cluster: on the workers of a Dask client (extra ``sweep``)."""

from __future__ import annotations

import uuid
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from semiwear.errors import SemiwearError
from semiwear.sweep.outcome import Outcome, Status, solve_on_one_thread
from semiwear.sweep.scenes import Task
from semiwear.sweep.shares import Shares
from semiwear.sweep.store import identity

if TYPE_CHECKING:
    from distributed import Client, Future

_AHEAD = 2  # scenes submitted for each worker: one at work, one waiting
_WAIT = 30.0  # s, for a first worker


def on_cluster(tasks: Sequence[Task], client: Client) -> Iterator[Outcome]:
    """Outcomes as they come from a cluster.

    Each worker is given scenes that share their geometry, two at a time; the scheduler passes scenes of a worker that
    has died to another.

    Raises
    ------
    SemiwearError
        There is no worker, or one has another version of semiwear.
    """
    from distributed import as_completed

    shares = Shares(tasks)
    run = uuid.uuid4().hex[:8]
    submitted: dict[Future, tuple[Task, str]] = {}
    waiting = as_completed()

    def submit() -> None:
        for worker in sorted(client.nthreads()):
            ahead = sum(1 for _, other in submitted.values() if other == worker)
            for _ in range(_AHEAD - ahead):
                task = shares.take(worker)
                if task is None:
                    return
                future = client.submit(
                    _solved, task, identity(), key=f"scene-{run}-{task.key}",
                    workers=[worker], allow_other_workers=True, pure=False,
                )  # fmt: skip
                submitted[future] = task, worker
                waiting.add(future)

    try:
        _require_workers(client)
        while True:
            submit()
            if not submitted and not len(shares):
                return
            if not submitted:  # every worker has died
                _require_workers(client)
                continue
            future = next(waiting)
            task, _ = submitted.pop(future)
            yield _outcome(task, future)
            future.release()
    finally:
        client.cancel(list(submitted))


def _solved(task: Task, versions: dict[str, str]) -> Outcome:
    """On a worker: solve a scene, if its code is that of the driver."""
    if versions != identity():
        here = identity()
        differing = (
            f"{name} {here.get(name)} for {value}" for name, value in versions.items() if here.get(name) != value
        )
        raise SemiwearError(
            f"a worker of the cluster has other versions: {', '.join(differing)}; install the driver's there"
        )
    return solve_on_one_thread(task)


def _outcome(task: Task, future: Future) -> Outcome:
    from distributed import KilledWorker

    try:
        found: Outcome = future.result()
    except KilledWorker as error:
        return Outcome(task.key, Status.LOST, f"its workers died: {error}", lasting=False)
    return found


def _require_workers(client: Client) -> None:
    try:
        client.wait_for_workers(1, timeout=_WAIT)
    except TimeoutError:
        raise SemiwearError(f"the cluster has no worker after {_WAIT:g} s: start one, or leave out client=") from None
