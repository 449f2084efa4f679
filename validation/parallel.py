"""Sections built in processes of their own, each on one core; what goes on in them is heard here."""

from __future__ import annotations

import multiprocessing
import threading
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any

from validation.problems import Problems
from validation.progress import Progress
from validation.section import Built, SectionPlan, built

_heard: Any = None  # in a worker: where its progress goes


class _Sent:
    """Progress of a worker, sent to the process that waits for it."""

    def __init__(self, title: str) -> None:
        self._title = title

    def section(self, title: str) -> None:
        """A section begins."""
        _heard.put((title, ""))

    def note(self, text: str) -> None:
        """A piece of work begins."""
        _heard.put((self._title, text))

    def close(self) -> None:
        """Nothing more will come."""


def _listen_to(queue: Any) -> None:
    global _heard
    _heard = queue


def _built(plan: SectionPlan, problems: Problems, quick: bool) -> Built:
    progress = _Sent(plan.title)
    progress.section(plan.title)
    return built(plan, problems, quick, progress)


def build_all(
    plans: Sequence[SectionPlan], problems: Problems, quick: bool, progress: Progress, jobs: int = 1
) -> list[Built]:
    """Build sections, in this process or in several.

    Parameters
    ----------
    plans : sequence of SectionPlan
    problems : Problems
    quick : bool
    progress : Progress
    jobs : int
        Processes; with one, everything happens here.

    Returns
    -------
    list of Built
        In the order of the plans.
    """
    if jobs <= 1 or len(plans) < 2:
        parts = []
        for plan in plans:
            progress.section(plan.title)
            parts.append(built(plan, problems, quick, progress))
        return parts
    context = multiprocessing.get_context("spawn")  # a fork of a process with threads may hang
    queue = context.Queue()
    listener = threading.Thread(target=_forward, args=(queue, progress), daemon=True)
    listener.start()
    with ProcessPoolExecutor(jobs, mp_context=context, initializer=_listen_to, initargs=(queue,)) as pool:
        futures = [pool.submit(_built, plan, problems, quick) for plan in plans]
        parts = []
        for plan, future in zip(plans, futures, strict=True):
            try:
                parts.append(future.result())
            except Exception as error:  # the process died, or its section cannot be sent
                parts.append(Built(plan, None, f"{type(error).__name__}: {error}", "", 0.0, 0.0))
    queue.put(None)
    listener.join(timeout=5.0)
    return parts


def _forward(queue: Any, progress: Progress) -> None:
    while (heard := queue.get()) is not None:
        title, text = heard
        if text:
            progress.note(f"{title}: {text}")
        else:
            progress.section(title)
