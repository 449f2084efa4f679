"""Shapes of the axial displacement at a free end of a tooth.

The cosines of a prism mirror it at its ends: no shear stress there, but no axial displacement w either. A free end
has no axial stress instead. At a free end w has a jump d(x, y) in the end plane, which for the series is a strain
-d delta(z): with W the jump's displacements (w alone) and M = int B0' D B1 every harmonic is loaded by the forces

    G_n = (M + k K2) W.

Jumps are the lowest antiplane vibrations of one pitch between its sides (Ritz).

Source: T. Mura, Micromechanics of Defects in Solids, 2nd ed. 1987, ch. 1 (a jump as an eigenstrain).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix
from scipy.sparse.linalg import eigsh

from semiwear.arrays import FloatArray
from semiwear.compliance.section_mesh import SectionMesh


@dataclass(frozen=True)
class EndJumps:
    """Shapes of the axial jump at an end plane, (A of them).

    Attributes
    ----------
    strained, stretched : (A, 3 n) sparse matrices
        M W and K2 W, transposed: the forces of a jump at wave number k are `strained` + k `stretched`.
    stiffness : (A, A) array
        W' K2 W.
    jump : (n, A) array [mm]
        The jump at the nodes.
    """

    strained: csr_matrix
    stretched: csr_matrix
    stiffness: FloatArray
    jump: FloatArray

    @classmethod
    def of(cls, mesh: SectionMesh, shear: csc_matrix, mixed: csc_matrix, axial: csc_matrix, count: int) -> EndJumps:
        """The `count` lowest antiplane vibrations of a pitch whose sides and foot do not jump.

        Parameters
        ----------
        mesh : SectionMesh
        shear, mixed, axial : (3 n, 3 n) sparse matrices
            K0, M = int B0' D B1, and K2.
        count : int
        """
        nodes = np.setdiff1d(np.arange(len(mesh.nodes)), np.concatenate([mesh.held, mesh.left, mesh.right]))
        w = 3 * nodes + 2
        start = np.ones(len(w))  # the same answer at every run
        _, shapes = eigsh(shear[w][:, w], k=count, M=axial[w][:, w], sigma=0.0, v0=start)
        where = (np.repeat(w, count), np.tile(np.arange(count), len(w)))
        jumps = coo_matrix((shapes.ravel(), where), shape=(shear.shape[0], count)).tocsr()
        stretched = (axial @ jumps).T.tocsr()
        jump = np.zeros((len(mesh.nodes), count))
        jump[nodes] = shapes
        return cls((mixed @ jumps).T.tocsr(), stretched, (stretched @ jumps).toarray(), jump)
