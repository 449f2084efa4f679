"""Data of a report: a result with its pictures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import xarray as xr

from semiwear.report.pictures import Drawn, draw_all
from semiwear.results.wearing import scene_tables
from semiwear.untyped import Table


@dataclass(frozen=True)
class ReportData:
    """A result, and another one that it is compared with.

    Attributes
    ----------
    tree : DataTree
    against : DataTree or None
    for_pictures : DataTree
        The result with its life in the unit of the pictures: meshes, hours or kilometres of sliding.
    """

    tree: xr.DataTree
    against: xr.DataTree | None
    for_pictures: xr.DataTree

    @cached_property
    def attrs(self) -> dict[str, str]:
        """Attributes of the result."""
        return {str(name): str(value) for name, value in self.tree.attrs.items()}

    @cached_property
    def scene(self) -> Table:
        """Tables of the result's scene; empty if its text is not TOML."""
        return scene_tables(self.tree)

    @cached_property
    def pictures(self) -> list[Drawn]:
        """Every picture of the result."""
        return draw_all(self.for_pictures)
