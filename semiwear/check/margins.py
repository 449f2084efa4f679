"""Limits of a pair's teeth side by side: what each is, what the pair has, and what would be legal.

`semiwear.check.geometric_problems` tells what is broken; this tells how much room is left everywhere.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from importlib import import_module
from math import isnan, nan

import numpy as np

from semiwear.check import KINDS, geometric_problems
from semiwear.check.limits import FAILURES, down, up
from semiwear.errors import Problem
from semiwear.plain_text import folded, table
from semiwear.scene import Scene, load_scene
from semiwear.untyped import Table

_CLOSE = 1e-5  # of a limit


@dataclass(frozen=True)
class Margin:
    """One limit of a pair's teeth.

    Attributes
    ----------
    limit : str
        Its name, e.g. ``"undercut of the pinion"``.
    value : float
        What the pair has; NaN where it cannot be computed.
    low, high : float or None
        Least and greatest legal value; None where there is none.
    unit : str
        ``"mm"``, ``"deg"`` or ``"1"``.
    field : str
        Field of the scene that moves it most directly.
    usual : str
        What is usual, in words.
    """

    limit: str
    value: float
    low: float | None
    high: float | None
    unit: str
    field: str
    usual: str = ""

    @property
    def holds(self) -> bool:
        """Whether the value is legal."""
        if isnan(self.value):
            return False
        return (self.low is None or self.value >= self.low) and (self.high is None or self.value <= self.high)

    @property
    def legal(self) -> str:
        """Legal values in words, rounded to the safe side."""
        low = None if self.low is None else self._told(self.low, up)
        high = None if self.high is None else self._told(self.high, down)
        if low is not None and high is not None:
            return f"{low} to {high}"
        return f"at least {low}" if low is not None else f"up to {high}" if high is not None else "unknown"

    def _told(self, limit: float, rounded: Callable[[float], str]) -> str:
        """A limit as text, with all its digits where the value is that close."""
        return f"{limit:.10g}" if abs(self.value - limit) <= _CLOSE * abs(limit) else rounded(limit)


@dataclass(frozen=True)
class GeometryCheck:
    """Every limit of a scene's teeth: printed as a table.

    Attributes
    ----------
    title : str
        Of the pair.
    margins : tuple of Margin
    problems : tuple of Problem
        All that makes the scene impossible to compute, with fixes.
    """

    title: str
    margins: tuple[Margin, ...]
    problems: tuple[Problem, ...]

    @property
    def holds(self) -> bool:
        """Whether all limits are kept."""
        return not self.problems and all(one.holds for one in self.margins)

    def to_dict(self) -> Table:
        """Plain values, for machines; NaN is None."""
        rows = [asdict(one) | {"holds": one.holds} for one in self.margins]
        rows = [{name: None if value != value else value for name, value in row.items()} for row in rows]
        return {
            "title": self.title,
            "holds": self.holds,
            "limits": rows,
            "problems": [{name: str(value) for name, value in asdict(one).items()} for one in self.problems],
        }

    def __str__(self) -> str:
        head = ("limit", "here", "legal", "unit", "kept", "field", "usual")
        rows = [
            (
                one.limit, "-" if isnan(one.value) else f"{one.value:.6g}", one.legal,
                "" if one.unit == "1" else one.unit, "yes" if one.holds else "NO",
                one.field.removeprefix("gear_pair."), one.usual,
            )
            for one in self.margins
        ]  # fmt: skip
        parts = [self.title, table(head, rows)] if rows else [self.title]
        if self.problems:
            parts.append("\n".join(folded(f"- {problem}") for problem in self.problems))
        parts.append("All limits are kept." if self.holds else "Limits are broken: the scene would be refused.")
        return "\n\n".join(parts)


def margin(
    limit: str,
    value: Callable[[], float],
    field: str,
    *,
    low: float | Callable[[], float] | None = None,
    high: float | Callable[[], float] | None = None,
    unit: str = "mm",
    usual: str = "",
) -> Margin:
    """A limit whose numbers may fail to be computed on a tooth that cannot be cut."""

    def number(given: float | Callable[[], float]) -> float:
        try:
            return float(given()) if callable(given) else given
        except FAILURES:
            return nan

    ends = [None if end is None or isnan(found := number(end)) else found for end in (low, high)]
    has_limit = any(end is not None for end in ends)
    return Margin(limit, number(value) if has_limit else nan, ends[0], ends[1], unit, f"gear_pair.{field}", usual)


def check_geometry(scene: Scene | str | os.PathLike[str]) -> GeometryCheck:
    """All limits of a pair's teeth: undercut, pointing, clearances, interference, contact ratio, tip thickness.

    Parameters
    ----------
    scene : Scene, or a scene's shipped name or file
        Given by its name it may break limits of its teeth; its fields must be sound.

    Raises
    ------
    SceneError
        The scene cannot be read, or its fields are wrong.
    """
    scene = scene if isinstance(scene, Scene) else load_scene(scene)
    problems = tuple(geometric_problems(scene))
    margins: tuple[Margin, ...] = ()
    kind = scene.gear_pair.type
    if kind in KINDS:
        found: Callable[[Scene], Iterator[Margin]] = getattr(
            import_module(f"semiwear.check.{kind}_margins"), f"{kind}_margins"
        )
        with np.errstate(all="ignore"):
            margins = tuple(found(scene))
    return GeometryCheck(f"{scene.title or 'scene'}: {scene.gear_pair.description}", margins, problems)
