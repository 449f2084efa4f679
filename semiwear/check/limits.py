"""How limits of tooth geometry are applied and told, whatever the kind of gear pair."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import ceil, floor, isfinite, log10
from typing import TypeVar

import numpy as np
from scipy.optimize import brentq

from semiwear.errors import Problem
from semiwear.meshing.flank_pair import BODIES
from semiwear.scene import Scene

_Mesh = TypeVar("_Mesh")
_Point = TypeVar("_Point")

Limit = Callable[[Scene, _Mesh], Iterator[Problem]]
"""From a scene and its flanks in mesh to what is wrong."""

_DIGITS = 6  # of the limits that messages state
FAILURES = (ArithmeticError, ValueError, RuntimeError, IndexError)
"""Errors of numbers that a tooth which cannot be cut does not have."""


def find_problems(
    scene: Scene, mesh: _Mesh, limits: Mapping[Limit[_Mesh], str], usual: str, last: tuple[Limit[_Mesh], ...] = ()
) -> list[Problem]:
    """Problems that limits find, a field named once at most.

    Parameters
    ----------
    scene : Scene
    mesh : object
        The flanks in mesh, for the limits.
    limits : mapping
        Limits in their order, and the field of the gear pair that is named when one cannot be computed.
    usual : str
        Name of a scene whose proportions are usual.
    last : tuple of limits
        Those that only make sense on a sound tooth.
    """
    found: dict[str, Problem] = {}
    failed: list[Problem] = []
    with np.errstate(all="ignore"):
        for limit, field in limits.items():
            if limit in last and (found or failed):
                continue
            try:
                for problem in limit(scene, mesh):
                    found.setdefault(problem.field, problem)
            except FAILURES:
                allowed = "a tooth that can be cut; for this one the limit cannot even be computed"
                fix = f"compare with the scene {usual}, which is usual in every proportion"
                failed.append(problem_of(scene, field, allowed, fix))
    # a limit that cannot be computed is only news while nothing else says why
    return list(found.values()) or failed[:1]


def problem_of(scene: Scene, field: str, allowed: str, fix: str) -> Problem:
    """A problem of a field of the gear pair."""
    return Problem(f"gear_pair.{field}", getattr(scene.gear_pair, field), allowed, fix)


def watched_point(scene: Scene, kind: type[_Point]) -> tuple[_Point, int] | None:
    """The control point of a scene and on which body it lies; None without one of this kind."""
    if scene.wear is None or not isinstance(scene.wear.control_point, kind):
        return None
    return scene.wear.control_point, BODIES.index(scene.wear.watched_body)


def _rounded(length: float, towards: Callable[[float], int]) -> str:
    if not isfinite(length) or length == 0.0:
        return f"{length:g}"
    decimals = _DIGITS - 1 - floor(log10(abs(length)))
    return f"{towards(length * 10.0**decimals) / 10.0**decimals:.{_DIGITS}g}"


def down(length: float) -> str:
    """A limit from above, as text."""
    return _rounded(length, floor)


def up(length: float) -> str:
    """A limit from below, as text."""
    return _rounded(length, ceil)


def crossing(margin: Callable[[float], float], good: float, bad: float) -> float:
    """The value between a good and a bad one at which a margin becomes zero."""
    return float(brentq(margin, good, bad, rtol=1e-12))
