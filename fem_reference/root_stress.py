"""Pressure on a flank, and the tangential stress of the fillets that it causes.

The fillet carries strain gauges: the strain of its surface along the fillet and across it follows from the motion of
its own nodes, is read at the Gauss points of each element face, where it is most accurate, and carried on to the
nodes. The surface is free, so that stress follows from these two strains alone (plane stress):

    stress_t = E/(1 - nu^2) (strain_t + nu strain_f)

This converges faster than stress from within, which must be extrapolated through the steepest gradient. The
component along the fillet in the section superposes; principal stress does not.

Source: J. Barlow, Int. J. Numer. Meth. Engng 10 (1976) 243-251 (points); ISO 6336-3:2019, 5 (tensile side).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.sparse import coo_matrix, csr_matrix
from skfem import ElementQuad1, ElementQuad2, ElementQuadS2
from skfem.quadrature import get_quadrature

from fem_reference.elasticity import ElasticBody
from fem_reference.tooth_mesh import LOADED, ToothMesh

__all__ = ["FilletStress", "fillet_operator", "fillet_stress", "pressure_load"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_FACES = {"hex8i": ElementQuad1(), "hex20": ElementQuadS2(), "hex27": ElementQuad2()}


@dataclass(frozen=True)
class FilletStress:
    """Tangential stress of one fillet.

    Attributes
    ----------
    arc : (arc, face) array [mm]
        Length from the end of the flank.
    face : (face,) array [mm]
    stress : (arc, face) array [MPa]
        Tensile positive.
    """

    arc: FloatArray
    face: FloatArray
    stress: FloatArray

    @property
    def greatest_along_face(self) -> FloatArray:
        """Greatest stress along the fillet at every face coordinate, between the nodes by a cubic spline [MPa]."""
        peaks = np.empty(len(self.face))
        for k in range(len(self.face)):
            arc = self.arc[:, k]
            peaks[k] = CubicSpline(arc, self.stress[:, k])(np.linspace(arc[0], arc[-1], 401)).max()
        return peaks

    @property
    def greatest(self) -> float:
        """Greatest stress of the fillet [MPa]."""
        return float(self.greatest_along_face.max())


def pressure_load(
    body: ElasticBody,
    mesh: ToothMesh,
    pressure: Callable[[FloatArray, FloatArray], FloatArray],
    *,
    tooth: int = 0,
    side: int = LOADED,
) -> FloatArray:
    """Consistent nodal forces of a pressure on a flank.

    Parameters
    ----------
    body : ElasticBody
        Made of `mesh.mesh` with `mesh.element`.
    mesh : ToothMesh
    pressure : function
        Pressure [MPa] at arrays of profile and face coordinates [mm].
    tooth, side : int
        The flank.

    Returns
    -------
    (3 n,) array [N]
    """
    flank, element, step = mesh.flanks[tooth, side], _FACES[body.element], _step(body)
    points, weights = get_quadrature(element.refdom, 6)

    def of_faces(values: NDArray, kind: Any) -> NDArray:
        _, rows, columns = _element_faces(flank.nodes, step, kind)
        return values[rows, columns]

    full = ElementQuad1() if step == 1 else ElementQuad2()
    face = np.broadcast_to(flank.face, flank.profile.shape)
    nodes = of_faces(flank.nodes, element)
    values, slopes = zip(*[element.lbasis(points, a) for a in range(nodes.shape[1])], strict=True)
    tangents = np.einsum("ajq,fai->fqji", np.array(slopes), of_faces(flank.points, element))
    area = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    inner = np.array([full.lbasis(points, a)[0] for a in range(len(full.doflocs))])
    normals = np.einsum("aq,fai->fqi", inner, of_faces(flank.normals, full))
    inwards = -area * np.sign(np.einsum("fqi,fqi->fq", area, normals))[..., None]
    profile, place = (np.einsum("aq,fa->fq", inner, of_faces(v, full)) for v in (flank.profile, face))
    forces = np.einsum("q,fq,fqi,aq->fai", weights, pressure(profile, place), inwards, np.array(values))
    load = np.zeros_like(body.points)
    np.add.at(load, nodes, forces)
    return load.ravel()


def fillet_operator(body: ElasticBody, mesh: ToothMesh, *, tooth: int = 0, side: int = LOADED) -> csr_matrix:
    """Matrix from a displacement to the tangential stress of a fillet, rows (arc, face) flattened [MPa/mm].

    The face stations are those of element corners, where every element has all its nodes along the fillet.
    """
    number, step, element = mesh.fillets[tooth, side].nodes, _step(body), _FACES[body.element]
    nodes, rows, columns = _element_faces(number, step, element)
    gauges, _ = get_quadrature(ElementQuad1().refdom, 3 if step == 2 else 1)
    slopes = np.array([element.lbasis(gauges, a)[1] for a in range(nodes.shape[1])])  # (a, 2, q)
    tangents = np.einsum("ajq,fai->fqji", slopes, body.points[nodes])
    metric = np.linalg.inv(tangents @ tangents.swapaxes(2, 3))
    gradient = np.einsum("ajq,fqjk,fqki->fqai", slopes, metric, tangents)  # of the shape functions, in the surface
    along = tangents[:, :, 0] / np.linalg.norm(tangents[:, :, 0], axis=-1, keepdims=True)
    normal = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    across = np.cross(normal / np.linalg.norm(normal, axis=-1, keepdims=True), along)
    e, nu = body.youngs_modulus, body.poissons_ratio
    reading = np.einsum("fqak,fqk,fqi->fqai", gradient, along, along)
    reading += nu * np.einsum("fqak,fqk,fqi->fqai", gradient, across, across)
    reading = e / (1.0 - nu**2) * reading.reshape(*reading.shape[:2], -1)

    # carried on from the gauges to the nodes of each face, and averaged over the faces of a node
    local = np.rint(step * np.asarray(element.doflocs)).astype(int)
    wanted = local[:, 1] % step == 0
    carried = np.einsum("pq,fqa->fpa", _bilinear(local[wanted] / step, gauges.T), reading)
    stations = (number.shape[1] - 1) // step + 1
    row = rows[:, wanted] * stations + columns[:, wanted] // step
    share = np.bincount(row.ravel(), minlength=number.shape[0] * stations)
    carried /= share[row][..., None]
    unknowns = body.dofs(nodes.ravel()).reshape(len(nodes), 1, -1)
    where = (np.broadcast_to(row[..., None], carried.shape).ravel(), np.broadcast_to(unknowns, carried.shape).ravel())
    return coo_matrix((carried.ravel(), where), shape=(len(share), body.points.size)).tocsr()


def fillet_stress(
    body: ElasticBody, mesh: ToothMesh, displacement: FloatArray, *, tooth: int = 0, side: int = LOADED
) -> FilletStress:
    """Tangential stress of a fillet under a displacement (3 n,) [mm]; the loaded side is the tensile one."""
    fillet, step = mesh.fillets[tooth, side], _step(body)
    arc = fillet.arc[:, ::step]
    stress = fillet_operator(body, mesh, tooth=tooth, side=side) @ displacement
    return FilletStress(arc, fillet.face[::step], stress.reshape(arc.shape))


def _step(body: ElasticBody) -> int:
    """Grid columns from one corner of an element to the next."""
    return 1 if body.element == "hex8i" else 2


def _element_faces(number: IntArray, step: int, element: Any) -> tuple[IntArray, IntArray, IntArray]:
    """Nodes of every element face of a grid, and their rows and columns in it: three (faces, nodes) arrays."""
    row, column = np.rint(step * np.asarray(element.doflocs).T).astype(int)
    rows = step * np.arange((number.shape[0] - 1) // step)[:, None, None] + row
    columns = step * np.arange((number.shape[1] - 1) // step)[None, :, None] + column
    rows, columns = (part.reshape(-1, len(row)) for part in np.broadcast_arrays(rows, columns))
    return number[rows, columns], rows, columns


def _bilinear(at: FloatArray, through: FloatArray) -> FloatArray:
    """Weights that carry values at one point, or bilinearly at four points `through`, on to points `at`."""
    if len(through) == 1:
        return np.ones((len(at), 1))

    def terms(x: FloatArray) -> FloatArray:
        return np.stack([np.ones(len(x)), x[:, 0], x[:, 1], x[:, 0] * x[:, 1]], axis=1)

    return terms(at) @ np.linalg.inv(terms(through))
