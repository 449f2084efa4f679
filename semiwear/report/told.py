"""The material of a report and its sections."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import xarray as xr

from semiwear.report.pictures import Drawn, draw_all
from semiwear.results.wearing import scene_tables
from semiwear.untyped import Table


@dataclass(frozen=True)
class Told:
    """A result, and another one that it is compared with.

    Attributes
    ----------
    tree : DataTree
    against : DataTree or None
    counted : DataTree
        The result for pictures: its life in what they are to count.
    """

    tree: xr.DataTree
    against: xr.DataTree | None
    counted: xr.DataTree

    @cached_property
    def attrs(self) -> dict[str, str]:
        """Attributes of the result."""
        return {str(name): str(value) for name, value in self.tree.attrs.items()}

    @cached_property
    def scene(self) -> Table:
        """Tables of the result's scene; empty where its text is no TOML."""
        return scene_tables(self.tree)

    @cached_property
    def drawn(self) -> list[Drawn]:
        """Every picture of the result."""
        return draw_all(self.counted)


@dataclass(frozen=True)
class Section:
    """A section of the page.

    Attributes
    ----------
    heading : str or callable
        Or what makes it of the result.
    content : callable
        From what is told to HTML; a section whose content is empty is left out.
    """

    heading: str | Callable[[Told], str]
    content: Callable[[Told], str]


def written(sections: tuple[Section, ...], told: Told) -> list[tuple[str, str]]:
    """Headings and HTML of the sections that have content."""
    found = []
    for section in sections:
        content = section.content(told)
        if content:
            heading = section.heading if isinstance(section.heading, str) else section.heading(told)
            found.append((heading, content))
    return found
