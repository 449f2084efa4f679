"""Progress of a sweep: scenes done, rate and time left, in a terminal or a notebook (extra ``progress``)."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from types import TracebackType
from typing import TYPE_CHECKING

from semiwear.errors import MissingExtraError
from semiwear.simulate import NoProgress, Progress

if TYPE_CHECKING:
    from tqdm import tqdm


class Bar:
    """A progress bar of tqdm; scenes kept from an earlier sweep count as done, but not for the rate."""

    def __init__(self) -> None:
        try:
            from tqdm import auto
        except ImportError as error:
            raise MissingExtraError("tqdm", "progress", "a progress bar") from error
        self._make = auto.tqdm
        self._bar: tqdm | None = None

    def __enter__(self) -> Bar:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.close()

    def step(self, done: int, total: int, text: str) -> None:
        """Show that `done` of `total` scenes are finished."""
        if self._bar is None:
            self._bar = self._make(total=total, initial=done, unit="scene", desc="sweep")
        if text:
            self._bar.set_postfix_str(text)
        self._bar.update(done - self._bar.n)


def progress_receiver(progress: Progress | bool | None) -> AbstractContextManager[Progress]:
    """Receiver of progress, for a `with` statement: a new bar if True, one that does nothing if None."""
    return Bar() if progress is True else nullcontext(progress or NoProgress())
