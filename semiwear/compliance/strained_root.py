"""Root stress of a tooth by strain of its wheel: a notch in a remote stress field.

Under a stress in the wheel along its surface, normal to the teeth, the fillet has that stress times a
notch factor: 2 or more on the root between the teeth, which is one of a row of equal notches, about 1 where a load on
the tooth stresses the fillet most, and falling to 0 towards the flank, which is outside the stress flow.

Plane strain of one pitch, whose sides and foot follow a uniform strain across the teeth and are free otherwise: with
straight sides and without a tooth the stress would be uniform.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import spsolve

from semiwear.arrays import FloatArray
from semiwear.compliance.section_elements import fillet_edges, fillet_shares, harmonic_integrals
from semiwear.compliance.section_mesh import elements_at_root, section_mesh
from semiwear.geometry.section import ToothSection
from semiwear.kept_on_disk import kept_on_disk


@kept_on_disk
def strained_root(section: ToothSection, *, poissons_ratio: float) -> tuple[FloatArray, FloatArray]:
    """Tangential stress of the fillet for a unit stress of the wheel's surface, normal to the teeth.

    Parameters
    ----------
    section : ToothSection
        Normal to the tooth [mm].
    poissons_ratio : float

    Returns
    -------
    share : (F,) array
        Positions along the fillet as fractions of its length from the end of the flank.
    factor : (F,) array
    """
    along, across, growth = elements_at_root(section)
    mesh = section_mesh(section, heights=5, fillet_elements=along, elements_across=across, towards_surface=growth)
    # the modulus cancels
    stiffness = harmonic_integrals(mesh, 1.0, poissons_ratio)[0]
    moved = np.zeros((len(mesh.nodes), 3))
    given = np.zeros(moved.shape, dtype=bool)
    given[:, 2] = True
    around = np.unique(np.concatenate([mesh.left, mesh.right, mesh.held]))
    given[around, 0] = True
    moved[around, 0] = mesh.nodes[around, 0]
    given[mesh.centre_line[-1], 1] = True
    free = np.flatnonzero(~given.ravel())
    moved.ravel()[free] = spsolve(stiffness[free][:, free], -(stiffness @ moved.ravel())[free])
    nodes, slopes, _, tangent, _ = fillet_edges(mesh)
    # plane strain on a free surface: E/(1 - nu^2) times the strain along it, and the same for the wheel's
    factor: FloatArray = np.einsum("fa,fi,fai->f", slopes, tangent, moved[nodes, :2])
    return fillet_shares(mesh), factor
