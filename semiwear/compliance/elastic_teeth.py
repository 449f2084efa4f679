"""Elastic teeth on the contact lines of a pair: compliance between contact points, of all bodies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from semiwear.arrays import FloatArray, IntArray

_MOST_KEPT = 2**27  # bytes of cached compliance between points, about


class Elastic(Protocol):
    """An elastic body."""

    @property
    def youngs_modulus(self) -> float:
        """[MPa]."""

    @property
    def poissons_ratio(self) -> float:
        """Poisson's ratio [1]."""


class CompliantBody(Protocol):
    """One body's compliance, prepared for the contact lines of all roll positions."""

    @property
    def body(self) -> Elastic:
        """The body."""

    @property
    def depth(self) -> FloatArray:
        """Distance from the flank to the middle surface, at which deflection is taken: (roll, face) [mm]."""

    def add_compliance(
        self, rolls: IntArray, faces: IntArray, pairs: IntArray, matrix: FloatArray, slope: FloatArray
    ) -> None:
        """Add the compliance between contact points [mm/N], and its derivative by the observer's profile."""

    def root_stress(self, force: FloatArray, per_cycle: int, moved: FloatArray | None = None) -> FloatArray:
        """Greatest tensile tangential stress along the root [MPa], (roll,), as `tooth.BodyOnLines.root_stress`."""


def line_compliance(
    bodies: tuple[CompliantBody, ...], rolls: IntArray, faces: IntArray, pairs: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Tooth compliance of all bodies between contact points, and its change when a point moves.

    Returns
    -------
    matrix : (n, n) array [mm/N]
        Symmetric.
    slope : (n, n) array [mm/N/mm]
        Derivative of row i by the profile coordinate of point i; by symmetry column j changes by its transpose.
    """
    matrix = np.zeros((rolls.size, rolls.size))
    slope = np.zeros_like(matrix)
    for body in bodies:
        body.add_compliance(rolls, faces, pairs, matrix, slope)
    return 0.5 * (matrix + matrix.T), slope


class PointCompliance(NamedTuple):
    """Tooth compliance between contact points; not to be changed in place.

    Attributes
    ----------
    matrix, slope : (n, n) arrays [mm/N], [mm/N/mm]
        As of `line_compliance`.
    depth : (bodies, n) array [mm]
        Distance from the flank to the middle surface.
    elastic : tuple of Elastic
        The bodies.
    """

    matrix: FloatArray
    slope: FloatArray
    depth: FloatArray
    elastic: tuple[Elastic, ...]


@dataclass(frozen=True, eq=False)
class ElasticTeeth:
    """Compliant bodies on the contact lines of a pair, with a cache of the compliance between points.

    It depends on geometry and material alone, so that runs under other loads, and other roll grids, share it.

    Attributes
    ----------
    roll : (K,) array
        Roll positions of the lines.
    prepare : callable
        Gives the bodies on the lines, driving one first: needed once a compliance is not in the cache.
    known : dict
        The cache, by roll positions and slices of the points.
    """

    roll: FloatArray
    prepare: Callable[[], tuple[CompliantBody, ...]]
    known: dict[tuple[bytes, bytes], PointCompliance] = field(default_factory=dict, repr=False)

    @cached_property
    def bodies(self) -> tuple[CompliantBody, ...]:
        """Driving one first; empty for rigid teeth."""
        return self.prepare()

    def compliance(self, rolls: IntArray, faces: IntArray, pairs: IntArray) -> PointCompliance:
        """Compliance between contact points; arguments as of `line_compliance`."""
        key = self.roll[rolls].tobytes(), faces.tobytes()
        found = self.known.get(key)
        if found is None:
            bodies = self.bodies
            depth = np.array([body.depth[rolls, faces] for body in bodies]).reshape(len(bodies), rolls.size)
            elastic = tuple(body.body for body in bodies)
            found = PointCompliance(*line_compliance(bodies, rolls, faces, pairs), depth, elastic)
            if (len(self.known) + 1) * (found.matrix.nbytes + found.slope.nbytes) < _MOST_KEPT:
                self.known[key] = found
        return found
