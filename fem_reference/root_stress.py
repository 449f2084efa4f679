"""Pressure on a flank, and the resulting tangential stress of the fillets.

Fillet stress is read as by strain gauges: the strain of the surface along the fillet and across it follows from the
displacement of its nodes, is read at the Gauss points of each element face, where it is most accurate, and
interpolated to the nodes by cubic splines along the fillet and along the face. (Straight lines through the Gauss
points of one face overshoot a peak by its curvature times a twelfth of the element's length squared.) The surface is
free, so that stress follows from these two strains alone (plane stress):

    stress_t = E/(1 - nu^2) (strain_t + nu strain_f)

This converges faster than stress from within, which must be extrapolated through the steepest gradient. The
component along the fillet in the section, of helical teeth the normal section (ISO 6336-3:2019, 5), superposes;
principal stress does not.

Root stress is the greatest from `ROOT_FROM` of the fillet's length on. Nearer to the flank a load beside the fillet
causes local contact stress, which no mesh of a tooth resolves. The greatest stress of the notch lies a third
of the way down or lower (plane sections, loads from 0.3 mm above the flank's end to the tip).

Source: J. Barlow, Int. J. Numer. Meth. Engng 10 (1976) 243-251 (points); ISO 6336-3:2019, 5 (tensile side).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, make_interp_spline
from scipy.sparse import coo_matrix, csr_matrix, kron
from skfem import Element, ElementQuad1, ElementQuad2, ElementQuadS2
from skfem.quadrature import get_quadrature

from fem_reference.arrays import FloatArray, IntArray
from fem_reference.elasticity import ElasticBody
from fem_reference.tooth_mesh import LOADED, ToothMesh

_T = TypeVar("_T", bound=np.generic)

ROOT_FROM = 0.3
"""Fraction of the fillet's length, from the end of the flank, in which stress does not count as root stress."""

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
        """Greatest stress of the root at every face coordinate, between the nodes by a cubic spline [MPa]."""
        peaks = np.empty(len(self.face))
        for k in range(len(self.face)):
            arc = self.arc[:, k]
            root = np.linspace(arc[0] + ROOT_FROM * (arc[-1] - arc[0]), arc[-1], 401)
            peaks[k] = CubicSpline(arc, self.stress[:, k])(root).max()
        return peaks

    @property
    def greatest(self) -> float:
        """Greatest stress of the root, between the nodes by a cubic spline [MPa]."""
        peaks = self.greatest_along_face
        if len(peaks) < 3:
            return float(peaks.max())
        return float(CubicSpline(self.face, peaks)(np.linspace(self.face[0], self.face[-1], 401)).max())


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

    def of_faces(values: NDArray[_T], kind: Element) -> NDArray[_T]:
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
    down, beside = (t / np.linalg.norm(t, axis=-1, keepdims=True) for t in np.moveaxis(tangents, 2, 0))
    normal = np.cross(down, beside)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    # an inclined tooth bends across the lines that follow it, not in the transverse section
    along = np.cross(beside, normal) if mesh.inclined else down
    across = np.cross(normal, along)
    e, nu = body.youngs_modulus, body.poissons_ratio
    reading = np.einsum("fqak,fqk,fqi->fqai", gradient, along, along)
    reading += nu * np.einsum("fqak,fqk,fqi->fqai", gradient, across, across)
    reading = e / (1.0 - nu**2) * reading.reshape(*reading.shape[:2], -1)

    # the gauges stand in rows along the fillet and along the face: smooth curves through them give the stations
    fillet = mesh.fillets[tooth, side]
    lines = (fillet.arc[:, fillet.arc.shape[1] // 2], fillet.face)
    first = (rows.min(axis=1) // step, columns.min(axis=1) // step)
    places, grid = [], []
    for line, element_of, xi in zip(lines, first, gauges, strict=True):
        levels, rank = np.unique(np.round(xi, 9), return_inverse=True)
        places.append(_within_elements(line, step, levels))
        grid.append(element_of[:, None] * len(levels) + rank)
    unknowns = body.dofs(nodes.ravel()).reshape(len(nodes), 1, -1)
    place = (grid[0] * len(places[1]) + grid[1])[..., None]
    where = tuple(np.broadcast_to(part, reading.shape).ravel() for part in (place, unknowns))
    shape = (len(places[0]) * len(places[1]), body.points.size)
    curves = [
        csr_matrix(make_interp_spline(at, np.eye(len(at)), k=min(3, len(at) - 1))(line))
        for at, line in zip(places, (lines[0], lines[1][::step]), strict=True)
    ]
    return (kron(*curves) @ coo_matrix((reading.ravel(), where), shape=shape)).tocsr()


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


def _element_faces(number: IntArray, step: int, element: Element) -> tuple[IntArray, IntArray, IntArray]:
    """Nodes of every element face of a grid, and their rows and columns in it: three (faces, nodes) arrays."""
    row, column = np.rint(step * np.asarray(element.doflocs).T).astype(int)
    rows = step * np.arange((number.shape[0] - 1) // step)[:, None, None] + row
    columns = step * np.arange((number.shape[1] - 1) // step)[None, :, None] + column
    rows, columns = (part.reshape(-1, len(row)) for part in np.broadcast_arrays(rows, columns))
    return number[rows, columns], rows, columns


def _within_elements(line: FloatArray, step: int, at: FloatArray) -> FloatArray:
    """Coordinates at places `at` (0 to 1) of each element of a line of nodes, `step` of them an element."""
    corners = line[::step]
    middles = line[1::2] if step == 2 else (line[1:] + line[:-1]) / 2
    shapes = np.stack([(1 - at) * (1 - 2 * at), 4 * at * (1 - at), at * (2 * at - 1)])
    return (np.stack([corners[:-1], middles, corners[1:]], axis=1) @ shapes).ravel()
