"""Limits of tooth geometry for all kinds of gear pairs: how they are applied and reported."""

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
"""Function from a scene and its flanks in mesh to the problems of one limit."""

_DIGITS = 6  # of the limits that messages state
FAILURES = (ArithmeticError, ValueError, RuntimeError, IndexError)
"""Errors raised where a quantity of a tooth that cannot be cut does not exist."""


def find_problems(
    scene: Scene, mesh: _Mesh, limits: Mapping[Limit[_Mesh], str], usual: str, last: tuple[Limit[_Mesh], ...] = ()
) -> list[Problem]:
    """Problems found by limits, at most one for each field.

    Parameters
    ----------
    scene : Scene
    mesh : object
        The flanks in mesh, for the limits.
    limits : mapping
        Limits in their order, with the field of the gear pair named in the message if one cannot be computed.
    usual : str
        Name of a shipped scene with usual proportions.
    last : tuple of limits
        Limits that are applied only if no other has found a problem.
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
                fix = f"compare with the scene {usual}, whose proportions are all usual"
                failed.append(problem_of(scene, field, allowed, fix))
    # a limit that cannot be computed is reported only if no other problem explains it
    return list(found.values()) or failed[:1]


def problem_of(scene: Scene, field: str, allowed: str, fix: str) -> Problem:
    """A problem of a field of the gear pair."""
    return Problem(f"gear_pair.{field}", getattr(scene.gear_pair, field), allowed, fix)


def watched_point(scene: Scene, kind: type[_Point]) -> tuple[_Point, int] | None:
    """Control point of a scene and the index of its body; None without a control point of this kind."""
    if scene.wear is None or not isinstance(scene.wear.control_point, kind):
        return None
    return scene.wear.control_point, BODIES.index(scene.wear.watched_body)


def _rounded(length: float, towards: Callable[[float], int]) -> str:
    if not isfinite(length) or length == 0.0:
        return f"{length:g}"
    decimals = _DIGITS - 1 - floor(log10(abs(length)))
    return f"{towards(length * 10.0**decimals) / 10.0**decimals:.{_DIGITS}g}"


def down(length: float) -> str:
    """An upper limit as text, rounded down."""
    return _rounded(length, floor)


def up(length: float) -> str:
    """A lower limit as text, rounded up."""
    return _rounded(length, ceil)


def crossing(margin: Callable[[float], float], good: float, bad: float) -> float:
    """Value between an allowed and a forbidden one at which a margin becomes zero."""
    return float(brentq(margin, good, bad, rtol=1e-12))
