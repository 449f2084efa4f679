"""What wear and results ask of a contact solver, whatever its fidelity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from semiwear.compliance.tooth import CompliantBody
from semiwear.contact.footprint import Footprints
from semiwear.meshing.contact_lines import ContactLines

__all__ = ["SlicePressures", "TeethLoads", "TeethSolver"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


class TeethLoads(Protocol):
    """Loads of all tooth pairs over a mesh cycle.

    Attributes
    ----------
    force : (roll, face) array [N]
        Normal force on each slice.
    half_width : (roll, face) array [mm]
        Hertz half-width.
    rotation : (mesh_position,) array [rad]
        Rotation of the driving body beyond its nominal place.
    iterations : (mesh_position,) int array
    balance, complementarity : (mesh_position,) arrays
        Relative errors of the torque and of contact.
    """

    force: FloatArray
    half_width: FloatArray
    rotation: FloatArray
    iterations: IntArray
    balance: FloatArray
    complementarity: FloatArray


@dataclass(frozen=True)
class SlicePressures:
    """Greatest pressures of every slice; arrays are (roll, face).

    Attributes
    ----------
    inner : array [MPa]
        Away from the borders of both flanks; zero where there is none.
    place : array [mm]
        Profile coordinate where it is found.
    border : array [MPa]
        At the borders: the raw value, which depends on the mesh.
    """

    inner: FloatArray
    place: FloatArray
    border: FloatArray


class TeethSolver(Protocol):
    """Loaded contact of all tooth pairs; `Any` are the loads of the solver's own kind."""

    @property
    def bodies(self) -> tuple[CompliantBody, ...]:
        """Tooth compliance of both bodies; empty for rigid teeth."""

    @property
    def reach(self) -> float:
        """Separation beyond which no slice can touch, however loaded and worn [mm]."""

    @property
    def modulus(self) -> float:
        """Effective modulus E* [MPa]."""

    @property
    def resolved(self) -> Any:
        """The `PatchContact` that resolves pressure in two dimensions, or None."""

    @property
    def line(self) -> Any:
        """The `LineContact` of the same teeth: at fidelity `line` the solver itself."""

    def is_near(self, lines: ContactLines, depth: float = 0.0) -> BoolArray:
        """Slices whose fresh separation is small enough that elasticity and wear may close it, (roll, face)."""

    def no_loads(self) -> Any:
        """No loads yet."""

    def solve(
        self,
        worn: Footprints,
        loads: Any,
        wear_compliance: FloatArray | None = None,
        positions: Sequence[int] | None = None,
    ) -> Any:
        """Solve mesh positions, starting from `loads`, which stays as it is."""

    def with_edges(self, worn: Footprints, loads: Any, before: Footprints) -> Footprints:
        """Footprints with the contact of pressed edges as these loads make it; the same object if nothing changes.

        Edges that are pressed in `before`, footprints that an earlier call returned or `worn`, stay so.
        """

    @property
    def searched(self) -> FloatArray:
        """Separation up to which candidates are known at each mesh position; 0 where not yet looked for [mm]."""

    def search(self, searched: FloatArray) -> None:
        """Know the candidates that a solver knew which had searched so far: its solutions are then the same."""

    def line_load(self, loads: Any) -> FloatArray:
        """Line load q [N/mm], (roll, face)."""

    def pressures(self, loads: Any, worn: Footprints, margin: float) -> SlicePressures:
        """Greatest pressures of each slice; less than `margin` [mm] across the line from an end is at the border."""

    def approach(self, loads: Any) -> FloatArray:
        """Approach along the line of action at each mesh position [mm]."""
