"""Progress of the validation report: a bar where tqdm is installed, lines elsewhere."""

from __future__ import annotations

import time
from typing import Any, Protocol, TextIO


class Progress(Protocol):
    """Hears what is going on."""

    def section(self, title: str) -> None:
        """A section begins."""

    def note(self, text: str) -> None:
        """A piece of work within the section begins."""

    def close(self) -> None:
        """Nothing more will come."""


class NoProgress:
    """Hears nothing."""

    def section(self, title: str) -> None:
        """Do nothing."""

    def note(self, text: str) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""


class Lines:
    """A line for everything, with the seconds since the start."""

    def __init__(self, stream: TextIO) -> None:
        self._stream, self._began = stream, time.perf_counter()

    def section(self, title: str) -> None:
        """A section begins."""
        self._write(title)

    def note(self, text: str) -> None:
        """A piece of work begins."""
        self._write(f"    {text}")

    def close(self) -> None:
        """Nothing more will come."""
        self._write("done")

    def _write(self, text: str) -> None:
        print(f"[{time.perf_counter() - self._began:5.0f} s] {text}", file=self._stream, flush=True)


class Bar:
    """One tqdm bar over the sections, which also says what is being done."""

    def __init__(self, bar: Any) -> None:
        self._bar, self._begun = bar, False

    def section(self, title: str) -> None:
        """A section begins; the one before is done."""
        if self._begun:
            self._bar.update()
        self._begun = True
        self._bar.set_description_str(title)

    def note(self, text: str) -> None:
        """A piece of work begins."""
        self._bar.set_postfix_str(text)

    def close(self) -> None:
        """The last section is done."""
        self._bar.update()
        self._bar.set_postfix_str("")
        self._bar.close()


def progress_on(stream: TextIO, sections: int) -> Progress:
    """A bar on a terminal with tqdm installed, lines otherwise."""
    try:
        from tqdm import tqdm
    except ImportError:
        return Lines(stream)
    if not stream.isatty():
        return Lines(stream)
    return Bar(tqdm(total=sections, file=stream, unit="section", dynamic_ncols=True))
