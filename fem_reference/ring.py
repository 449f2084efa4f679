r"""The rest of a ring: equal pitches, condensed once and joined by doubling.

Teeth far from the contact differ by a rotation only. One of their pitches is condensed onto the two planes in which
it is cut from its neighbours,

.. math:: S = K_{bb} - K_{bi} K_{ii}^{-1} K_{ib} ,

and two stretches of n and k pitches become one of n + k when the second is turned by n pitches and the plane between
them eliminated. A ring of any number of teeth costs a few dense matrices of the size of a cut plane, and the result
is that of the mesh with every tooth.

Sources: Przemieniecki, AIAA J. 1 (1963) 138 (substructures); Thomas, Int. J. Numer. Meth. Engng 14 (1979) 81
(rotationally periodic structures).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import coo_matrix, csr_matrix
from skfem import MeshHex

from fem_reference.arrays import FloatArray, IntArray
from fem_reference.elasticity import ElasticBody
from fem_reference.substructures import compliance_by_parts


@dataclass(frozen=True)
class RestOfRing:
    """Pitches that close a stretch of teeth to a ring.

    Attributes
    ----------
    pitch : skfem.MeshHex or skfem.MeshHex2
        One pitch, the next after the stretch's last tooth.
    element : str
    count : int
        Pitches, 1 or more.
    turn : (3, 3) array
        Rotation from one tooth to the next.
    held : int array
        Displacement nodes of the pitch at the bore.
    low, high : (n,) int arrays
        Displacement nodes of the pitch in the planes towards the tooth before and the tooth after it.
    last, first : (n,) int arrays
        Displacement nodes of the stretch with which the low plane of the first of the pitches and the high plane of
        the last one coincide.
    """

    pitch: MeshHex
    element: str
    count: int
    turn: FloatArray
    held: IntArray
    low: IntArray
    high: IntArray
    last: IntArray
    first: IntArray

    def stiffness(self, like: ElasticBody, rotation: FloatArray | None = None) -> csr_matrix:
        """Stiffness that the pitches add to the stretch [N/mm].

        Parameters
        ----------
        like : ElasticBody
            The stretch: its material and its number of unknowns.
        rotation : (3, 3) array, optional
            By which the stretch is turned from the frame of the mesh.

        Returns
        -------
        (3 n, 3 n) sparse array
        """
        body = ElasticBody(
            self.pitch,
            element=self.element,
            youngs_modulus=like.youngs_modulus,
            poissons_ratio=like.poissons_ratio,
        )
        # held unknowns have no stiffness to pass on
        kept = ~np.isin(self.low, self.held)
        chain = _chain(_condensed(body, self.held, self.low[kept], self.high[kept]), self.count, self.turn)
        nodes = np.concatenate([self.last[kept], self.first[kept]])
        dense = _turned(chain, np.eye(3) if rotation is None else rotation)
        unknowns = like.dofs(nodes).ravel()
        rows, columns = np.broadcast_arrays(unknowns[:, None], unknowns)
        size = like.points.size
        return coo_matrix((dense.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size)).tocsr()


def _condensed(body: ElasticBody, held: IntArray, low: IntArray, high: IntArray) -> FloatArray:
    """Stiffness of one pitch on its two planes, (6 n, 6 n) [N/mm]."""
    border = body.dofs(np.concatenate([low, high])).ravel()
    inner = np.setdiff1d(body.free_dofs(held), border)
    rows = csr_matrix(body.stiffness)
    result = rows[border][:, border].toarray()
    return np.asarray(result - compliance_by_parts(rows, inner, body.points, rows[:, border]))


def _chain(one: FloatArray, count: int, turn: FloatArray) -> FloatArray:
    """Stiffness of `count` pitches on their outermost planes, by the binary digits of the count."""
    result, done, doubled, length = None, 0, one, 1
    while True:
        if count & length:
            turned = _turned(doubled, np.linalg.matrix_power(turn, done))
            result = turned if result is None else _joined(result, turned)
            done += length
        if done == count:
            assert result is not None
            return result
        doubled = _joined(doubled, _turned(doubled, np.linalg.matrix_power(turn, length)))
        length *= 2


def _joined(before: FloatArray, after: FloatArray) -> FloatArray:
    """Two stretches without the plane between them."""
    n = len(before) // 2
    middle = cho_factor(before[n:, n:] + after[:n, :n], lower=True)
    beside = np.hstack([before[n:, :n], after[:n, n:]])
    result = np.zeros_like(before)
    result[:n, :n], result[n:, n:] = before[:n, :n], after[n:, n:]
    result -= beside.T @ cho_solve(middle, beside)
    return 0.5 * (result + result.T)


def _turned(matrix: FloatArray, rotation: FloatArray) -> FloatArray:
    """A stiffness whose nodes all turn by a rotation."""
    n = len(matrix) // 3
    blocks = matrix.reshape(n, 3, n, 3)
    return np.asarray(np.einsum("ij,ajbk,lk->aibl", rotation, blocks, rotation, optimize=True).reshape(3 * n, 3 * n))
