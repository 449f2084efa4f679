"""Progress of a command on a terminal."""

from __future__ import annotations

import logging
from contextlib import ExitStack
from typing import TYPE_CHECKING

from semiwear.kernel_cache import on_first_compilation

if TYPE_CHECKING:
    from tqdm import tqdm

_LOG = logging.getLogger(__name__)

_COMPILES = "compiling, which takes up to a minute; later runs use the compiled code ..."


class ProgressBar:
    """Progress bar on a terminal: tqdm's when it is installed (extra `progress`), else one line per step."""

    def __init__(self, begin: str = "computing the unworn teeth ...", unit: str = "step", task: str = "wear") -> None:
        self._begin, self._unit, self._task = begin, unit, task
        self._bar: tqdm | None = None
        self._inside = ExitStack()

    def __enter__(self) -> ProgressBar:
        _LOG.info(self._begin)
        self._inside.enter_context(on_first_compilation(lambda: _LOG.info(_COMPILES)))
        return self

    def __exit__(self, *_: object) -> None:
        self._inside.close()
        if self._bar is not None:
            self._bar.close()

    def step(self, done: int, total: int, text: str) -> None:
        """Show that `done` of `total` steps are finished."""
        if not _LOG.isEnabledFor(logging.INFO):
            return
        try:
            from tqdm import tqdm
        except ImportError:
            _LOG.info("%s, %s %d of %d: %s", self._task, self._unit, done, total, text)
            return
        if self._bar is None:
            # scenes kept from an earlier sweep count as done, but not for the rate
            first = done if self._task == "sweep" else 0
            self._bar = tqdm(total=total, unit=self._unit, desc=self._task, leave=True, initial=first)
        if done < self._bar.n:
            self._bar.reset(total)  # the coarse runs for an accuracy are finished
        self._bar.total = total
        self._bar.set_postfix_str(text)
        self._bar.update(done - self._bar.n)
