"""Fidelity of contact solutions: the functions that solve a contact problem."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from semiwear.arrays import BoolArray, FloatArray
from semiwear.contact.footprint import Footprints
from semiwear.contact.loads import SlicePressures, TeethLoads
from semiwear.contact.problem import ContactProblem


class SolveLoads(Protocol):
    """Shares the torque of every mesh position among the slices of all tooth pairs."""

    def __call__(
        self,
        problem: ContactProblem,
        worn: Footprints,
        start: TeethLoads | None = None,
        wear_compliance: FloatArray | None = None,
        positions: Sequence[int] | None = None,
    ) -> TeethLoads:
        """Loads on worn flanks.

        Parameters
        ----------
        problem : ContactProblem
        worn : Footprints
            Current gaps and curvatures.
        start : TeethLoads, optional
            Loads to start from, which are not changed; those of another state are a good start.
        wear_compliance : (roll, face) array [mm/N], optional
            Wear at the end of the step per force on the slice: the implicit term.
        positions : sequence of int, optional
            Mesh positions to solve; the others keep the loads of `start`.

        Raises
        ------
        ConvergenceError
            Naming the mesh position; `start` is still the last good state.
        """


class WithEdges(Protocol):
    """Finds the contact of pressed edges under loads."""

    def __call__(
        self,
        problem: ContactProblem,
        worn: Footprints,
        loads: TeethLoads,
        before: Footprints,
        rolls: BoolArray | None = None,
    ) -> Footprints:
        """Footprints with the contact of pressed edges under these loads; `worn` itself if nothing changes.

        Parameters
        ----------
        problem : ContactProblem
        worn : Footprints
        loads : TeethLoads
        before : Footprints
            What an earlier call returned, or `worn`: edges that are pressed there stay so.
        rolls : (roll,) bool array, optional
            Roll positions to compute; the others stay as in `before`.
        """


@dataclass(frozen=True)
class Fidelity:
    """Functions that solve contact problems.

    Attributes
    ----------
    solve : SolveLoads
    with_edges : WithEdges
    pressures : function of (problem, loads, worn, margin)
        Greatest pressures of each slice; within `margin` [mm] of an end, across the line, they count as border.
    roughly : SolveLoads, optional
        As `solve` to a wider tolerance in less time: for first loads and lengths, and while the rest settles.
    """

    solve: SolveLoads
    with_edges: WithEdges
    pressures: Callable[[ContactProblem, TeethLoads, Footprints, float], SlicePressures]
    roughly: SolveLoads | None = None
