"""A supported body condensed onto the nodes that may touch: once, then only dense algebra."""

from __future__ import annotations

from functools import cached_property
from time import perf_counter

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix

from fem_reference.arrays import FloatArray, IntArray
from fem_reference.elasticity import ElasticBody
from fem_reference.solvers import Factor, factorise
from fem_reference.substructures import compliance_by_parts
from fem_reference.tooth_mesh import ToothMesh
from semiwear.errors import SceneError

BLOCK = 64
"""Right-hand sides solved at once."""


class SupportedBody:
    """Stiffness of a body with some unknowns held.

    Parameters
    ----------
    stiffness : (n, n) sparse array [N/mm]
        Of the free body, as `fem_reference.elasticity.ElasticBody.stiffness`.
    held : int array
        Unknowns with prescribed displacement (zero by default).
    points : (n / 3, 3) array, optional [mm]
        Coordinates of the nodes, three unknowns each. With them the compliance comes from substructures, which takes
        a third of the time of a factor and its solutions for all loads.

    Attributes
    ----------
    free : (m,) int array
        The other unknowns.
    seconds : dict
        Time taken by ``"factor"`` and, summed, by ``"compliance"`` [s].
    """

    def __init__(self, stiffness: csr_matrix, held: IntArray, points: FloatArray | None = None):
        free = np.ones(stiffness.shape[0], dtype=bool)
        free[np.asarray(held, dtype=np.int64).ravel()] = False
        if free.all():
            raise SceneError.of("held", 0, "at least one held unknown", "hold its bore or back face")
        self.stiffness = csr_matrix(stiffness)
        self.free = np.flatnonzero(free)
        self.points = points
        self.seconds = {"factor": 0.0, "compliance": 0.0}

    @classmethod
    def of(cls, mesh: ToothMesh, body: ElasticBody, rotation: FloatArray | None = None) -> SupportedBody:
        """A body held at its bore or back face, closed to a ring if its mesh has the rest of the ring.

        `rotation` (3, 3) is that by which the body is turned from the frame of the mesh.
        """
        stiffness = body.stiffness
        if mesh.rest is not None:
            stiffness = stiffness + mesh.rest.stiffness(body, rotation)
        return cls(stiffness, body.dofs(mesh.held), body.points)

    @cached_property
    def factor(self) -> Factor:
        """Of the free unknowns' stiffness."""
        started = perf_counter()
        factor = factorise(
            csc_matrix(self.stiffness[self.free][:, self.free]),
            places=None if self.points is None else self.points[self.free // 3],
        )
        self.seconds["factor"] += perf_counter() - started
        return factor

    @property
    def size(self) -> int:
        """Unknowns of the body, held ones included."""
        return int(self.stiffness.shape[0])

    def compliance(self, unit_loads: csr_matrix) -> FloatArray:
        """Displacements that loads see of one another, B' K^-1 B.

        Parameters
        ----------
        unit_loads : (n, k) sparse array
            B: each column a load on the unknowns of the body.

        Returns
        -------
        (k, k) array, symmetric [mm/N]
        """
        if self.points is not None:
            started = perf_counter()
            by_parts = compliance_by_parts(self.stiffness, self.free, self.points, unit_loads)
            self.seconds["compliance"] += perf_counter() - started
            return by_parts
        factor, started = self.factor, perf_counter()
        loads = csc_matrix(unit_loads)[self.free]
        back = csr_matrix(loads.T)
        result = np.empty((loads.shape[1], loads.shape[1]))
        for start in range(0, loads.shape[1], BLOCK):
            block = slice(start, start + BLOCK)
            result[:, block] = back @ factor.solve(loads[:, block].toarray())
        self.seconds["compliance"] += perf_counter() - started
        return 0.5 * (result + result.T)

    def displacement(self, force: FloatArray, given: FloatArray | None = None) -> FloatArray:
        """Displacement of all unknowns [mm].

        Parameters
        ----------
        force : (n,) or (n, k) array [N]
        given : (n,) array, optional [mm]
            Displacement of the held unknowns (the entries of the free ones are not used); default zero.
        """
        result = np.zeros(np.shape(force))
        load = np.asarray(force, dtype=float)[self.free]
        if given is not None:
            result[:] = given
            result[self.free] = 0.0
            load = load - (self.stiffness @ result)[self.free]
        result[self.free] = self.factor.solve(load)
        return result
