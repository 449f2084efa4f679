"""All limits of a pair's teeth, each with the value of the pair and the values allowed.

`semiwear.check.geometric_problems` reports broken limits only.
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
        Value of the pair; NaN if it cannot be computed.
    low, high : float or None
        Least and greatest value allowed; None for no limit.
    unit : str
        ``"mm"``, ``"deg"`` or ``"1"``.
    field : str
        Field of the scene that changes it most directly.
    usual : str
        Usual values, in words.
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
        """Whether the value is within its limits."""
        if isnan(self.value):
            return False
        return (self.low is None or self.value >= self.low) and (self.high is None or self.value <= self.high)

    @property
    def legal(self) -> str:
        """Allowed values in words, rounded to the safe side."""
        low = None if self.low is None else self._as_text(self.low, up)
        high = None if self.high is None else self._as_text(self.high, down)
        if low is not None and high is not None:
            return f"{low} to {high}"
        return f"at least {low}" if low is not None else f"up to {high}" if high is not None else "unknown"

    def _as_text(self, limit: float, rounded: Callable[[float], str]) -> str:
        """A limit as text, with more digits if the value is close to it."""
        return f"{limit:.10g}" if abs(self.value - limit) <= _CLOSE * abs(limit) else rounded(limit)


@dataclass(frozen=True)
class GeometryCheck:
    """Every limit of a scene's teeth; `print` shows a table.

    Attributes
    ----------
    title : str
        Title of the pair.
    margins : tuple of Margin
    problems : tuple of Problem
        Reasons why the scene cannot be computed, with fixes.
    """

    title: str
    margins: tuple[Margin, ...]
    problems: tuple[Problem, ...]

    @property
    def holds(self) -> bool:
        """Whether all limits are kept."""
        return not self.problems and all(margin.holds for margin in self.margins)

    def to_dict(self) -> Table:
        """Plain values for JSON; None for NaN."""
        rows = [asdict(margin) | {"holds": margin.holds} for margin in self.margins]
        rows = [{name: None if value != value else value for name, value in row.items()} for row in rows]
        return {
            "title": self.title,
            "holds": self.holds,
            "limits": rows,
            "problems": [{name: str(value) for name, value in asdict(problem).items()} for problem in self.problems],
        }

    def __str__(self) -> str:
        head = ("limit", "here", "legal", "unit", "kept", "field", "usual")
        rows = [
            (
                margin.limit, "-" if isnan(margin.value) else f"{margin.value:.6g}", margin.legal,
                "" if margin.unit == "1" else margin.unit, "yes" if margin.holds else "NO",
                margin.field.removeprefix("gear_pair."), margin.usual,
            )
            for margin in self.margins
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
    """A limit, with NaN for numbers that cannot be computed on a tooth that cannot be cut."""

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
        A scene given by name or file may break limits of its teeth; its fields must be within their ranges.

    Returns
    -------
    GeometryCheck
        Every limit with its value, printed as a table; `holds` is whether all are kept.

    Raises
    ------
    SceneError
        The scene cannot be read, or a field is wrong.
    """
    scene = scene if isinstance(scene, Scene) else load_scene(scene)
    problems = tuple(geometric_problems(scene))
    margins: tuple[Margin, ...] = ()
    kind = scene.gear_pair.type
    if kind in KINDS:
        margins_of: Callable[[Scene], Iterator[Margin]] = getattr(
            import_module(f"semiwear.check.{kind}_margins"), f"{kind}_margins"
        )
        with np.errstate(all="ignore"):
            margins = tuple(margins_of(scene))
    return GeometryCheck(f"{scene.title or 'scene'}: {scene.gear_pair.description}", margins, problems)
