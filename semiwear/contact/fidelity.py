"""How a contact problem is solved: the functions that make up a fidelity."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from semiwear.arrays import BoolArray, FloatArray
from semiwear.contact.footprint import Footprints
from semiwear.contact.loads import SlicePressures, TeethLoads
from semiwear.contact.problem import ContactProblem

__all__ = ["Fidelity", "SolveLoads", "WithEdges"]


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
            Loads to start from, which stay as they are; those of another state serve well.
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
    """Lets pressed edges yield as loads make them."""

    def __call__(
        self,
        problem: ContactProblem,
        worn: Footprints,
        loads: TeethLoads,
        before: Footprints,
        rolls: BoolArray | None = None,
    ) -> Footprints:
        """Footprints with the contact of pressed edges as these loads make it; `worn` itself if nothing changes.

        Parameters
        ----------
        problem : ContactProblem
        worn : Footprints
        loads : TeethLoads
        before : Footprints
            What an earlier call returned, or `worn`: edges that are pressed there stay so.
        rolls : (roll,) bool array, optional
            Where to look; elsewhere all stays as in `before`.
        """


@dataclass(frozen=True)
class Fidelity:
    """A way to solve contact problems.

    Attributes
    ----------
    solve : SolveLoads
    with_edges : WithEdges
    pressures : function of (problem, loads, worn, margin)
        Greatest pressures of each slice; less than `margin` [mm] across the line from an end is at the border.
    roughly : SolveLoads, optional
        As `solve` with fewer digits, where that takes less time: for a start, a length, or what has not settled yet.
    """

    solve: SolveLoads
    with_edges: WithEdges
    pressures: Callable[[ContactProblem, TeethLoads, Footprints, float], SlicePressures]
    roughly: SolveLoads | None = None
