"""Free ends of a finite prism: what its cosine series leaves out.

The cosines mirror a prism at its ends: no shear stress there, but no axial displacement w either. A free end has no
axial stress instead; a load some 20 mm from it then stresses the root by a few per cent more. The mirror is cut open:
w gets a jump d(x, y) at an end plane, which for the series is a strain -d delta(z), and every harmonic answers it
with one more right-hand side. With W the jump's displacements (w alone), M = int B0' D B1 and j_n = 1/L, 2/L, ...

    G_n = (M + k K2) W,    u_n = j_n cos(k z_end) K_n^-1 G_n    displacement that a unit jump causes
    S = sum_n j_n cos(k z_e) cos(k z_f) (W' K2 W - G_n' K_n^-1 G_n)    stiffness of the jumps at ends e, f
    S d = sum_n j_n cos(k z_end) cos(k z0) G_n' K_n^-1 P    jumps that free the ends from the stress of load P

so that they add a product of low rank to the prism's influence. Jumps are the lowest antiplane vibrations of one
pitch between its sides (Ritz): the more of them, the freer the end, from the stiff side.

Source: T. Mura, Micromechanics of Defects in Solids, 2nd ed. 1987, ch. 1 (a jump as an eigenstrain).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix
from scipy.sparse.linalg import eigsh

from semiwear.compliance.section_mesh import SectionMesh

__all__ = ["EndJumps", "opened"]

FloatArray = NDArray[np.float64]

_SOFTEST = 1e-9  # of the stiffest jump: softer ones are copies of others


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
        if count == 0:
            none = csr_matrix((0, shear.shape[0]))
            return cls(none, none, np.zeros((0, 0)), np.zeros((len(mesh.nodes), 0)))
        start = np.ones(len(w))  # the same answer at every run
        _, shapes = eigsh(shear[w][:, w], k=count, M=axial[w][:, w], sigma=0.0, v0=start)
        where = (np.repeat(w, count), np.tile(np.arange(count), len(w)))
        jumps = coo_matrix((shapes.ravel(), where), shape=(shear.shape[0], count)).tocsr()
        stretched = (axial @ jumps).T.tocsr()
        jump = np.zeros((len(mesh.nodes), count))
        jump[nodes] = shapes
        return cls((mixed @ jumps).T.tocsr(), stretched, (stretched @ jumps).toarray(), jump)


def opened(
    weight: FloatArray, stiffness: FloatArray, own: FloatArray, moved: FloatArray, stressed: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Motion of the flank and stress of the fillet that the jumps at both ends bring, with unit stiffness.

    Parameters
    ----------
    weight : (N,) array [1/mm]
        j_n.
    stiffness : (A, A) array
        W' K2 W.
    own : (N, A, A) array
        j_n G_n' K_n^-1 G_n.
    moved : (N, A, H) array
        j_n G_n' K_n^-1 P of the load heights.
    stressed : (N, A, F) array
        j_n times the stress of unit jumps.

    Returns
    -------
    deflection : (N, E, H) array
    stress : (N, E, F) array
        E is 2 A, or fewer where the harmonics cannot tell the ends apart. A load at height j and z0 moves height i
        at z by the sum over m of (sum_n cos(k z) deflection[n, m, i]) (sum_n cos(k z0) deflection[n, m, j]);
        `stress` likewise.
    """
    count, jumps = own.shape[:2]
    ends = np.stack([np.ones(count), (-1.0) ** np.arange(count)])
    rest = weight[:, None, None] * stiffness - own
    if jumps == 0:
        return moved, stressed
    whole = np.einsum("en,fn,nab->eafb", ends, ends, rest).reshape(2 * jumps, 2 * jumps)
    value, vector = eigh(whole)
    # with one harmonic alone both ends are the same
    stiff = value > _SOFTEST * value.max()
    unit = vector[:, stiff] / np.sqrt(value[stiff])

    def of_both(values: FloatArray) -> FloatArray:
        return unit.T @ np.einsum("en,nah->neah", ends, values).reshape(count, 2 * jumps, -1)

    return of_both(moved), of_both(stressed)
