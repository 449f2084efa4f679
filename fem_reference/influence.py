r"""Influence data of both bodies: deflection and root stress for unit loads on a grid of flank points.

A load P, normal to the loaded flank of tooth 0 and into the material, at height h and face station s of the load grid
moves the teeth around by and stresses their fillets with

    deflection[body, tooth_offset, i, k, h, s] P   [mm]     at height i and station k of the same grid on that tooth
    root_stress[body, tooth_offset, a, k, h, s] P  [MPa]    at fillet point a and station k, tangential

Local deflection under the load is left out, as in the core's prisms: deflection is that of the tooth's middle
surface, at its intersection with the inward normal of the observer in its section, along that normal. It is
symmetrised (load and observer exchanged, tooth offset reversed); `asymmetry` is the change.

Loads fall linearly from their station to the next ones, so that a line load is their smooth sum: a point force a
millimetre above the fillet causes a peak that stations 5 mm apart would spread to a multiple of its load.

Layout of the dataset, all grids per body:

=================================  ====================================================================
``load_profile(body, height)``     profile coordinate of the load grid, from the end of the flank to the tip [mm]
``load_face(body, station)``       gear radius, or place along the pinion axis [mm]
``depth(body, height, station)``   distance from the flank to the middle surface along the inward normal [mm]
``fillet_arc(body, fillet_point)`` length along the fillet from the end of the flank, at the middle of the face [mm]
``deflection``, ``root_stress``    as above, [mm/N] and [MPa/N]; ``tooth_offset`` +1 faces the loaded flank
=================================  ====================================================================
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.interpolate import make_interp_spline
from scipy.sparse import coo_matrix, csr_matrix

from fem_reference.arrays import FloatArray
from fem_reference.elasticity import ElasticBody
from fem_reference.face_gear_mesh import face_gear_mesh
from fem_reference.face_gear_scene import face_gear_pair
from fem_reference.pinion_mesh import pinion_mesh
from fem_reference.root_stress import fillet_operator
from fem_reference.solvers import factorise
from fem_reference.tooth_mesh import LOADED, Divisions, FlankGrid, ToothMesh
from semiwear.scene import Material, Scene

OFFSETS = (-2, -1, 0, 1, 2)
"""Observed teeth; +1 is the neighbour on the side that the loaded flank faces."""

_LOADS_AT_ONCE = 32
_TOWARDS_FILLET = 1.6  # exponent by which load heights spread out from the fillet to the tip
_TEETH = (15, 7)  # of the pinion's sector and of the gear's stretch


@dataclass(frozen=True)
class _Resolution:
    heights: int
    stations: int
    elements_between_stations: int
    fillet: int


def tooth_influence(
    scene: Scene,
    *,
    heights: int = 10,
    stations: int = 33,
    elements_between_stations: int = 1,
    fillet_elements: int = 8,
    prefer: str = "auto",
) -> xr.Dataset:
    """Influence data of the teeth of a scene, with 20-node hexahedra.

    Parameters
    ----------
    scene : Scene
    heights, stations : int
        Load grid along the profile, closer together towards the fillet, and along the face, equally spaced from
        border to border (2.5 mm in the shipped scene).
    elements_between_stations : int
        Elements from one face station to the next.
    fillet_elements : int
        Elements along the fillet (even); gives ``2 fillet_elements + 1`` fillet points.
    prefer : str
        Solver, see `solvers.factorise`.

    Returns
    -------
    Dataset
        Layout in this module's description; save it with ``to_netcdf``.

    Notes
    -----
    The gear is a stretch of seven teeth on its held back face, the pinion a sector of fifteen on its held bore, which
    is as stiff as the whole ring to 0.02 % (a sector of seven is 1.3 % too soft).

    The defaults bring root stress in the shipped scene within 2 % of `root_load.RootStress` under the same contact
    forces, wherever a pair carries more than a tenth of the load. Eight heights on six elements along the fillet do
    too on the gear, but loads low on the pinion's flank are 8 % too high; 17 stations bring loads low on the gear's
    flank to -11 %.
    """
    if heights < 3 or stations < 2 or elements_between_stations < 1:
        raise ValueError("influence data need 3 heights, 2 stations and 1 element between them at least")
    resolution = _Resolution(heights, stations, elements_between_stations, fillet_elements)
    materials = (scene.material.pinion, scene.material.gear)
    bodies = [_body_influence(scene, k, material, resolution, prefer) for k, material in enumerate(materials)]
    names = {
        "load_profile": (("body", "height"), "mm", "profile coordinate of the load grid"),
        "load_face": (("body", "station"), "mm", "face coordinate of the load grid"),
        "depth": (("body", "height", "station"), "mm", "distance from flank to middle surface"),
        "fillet_arc": (("body", "fillet_point"), "mm", "length along the fillet from the end of the flank"),
        "deflection": (
            ("body", "tooth_offset", "observer_height", "observer_station", "height", "station"),
            "mm/N",
            "deflection of the middle surface for a unit load",
        ),
        "root_stress": (
            ("body", "tooth_offset", "fillet_point", "observer_station", "height", "station"),
            "MPa/N",
            "tangential fillet stress for a unit load",
        ),
        "asymmetry": (
            ("body",),
            "1",
            "change that making the deflection reciprocal brought, relative to the greatest",
        ),
    }
    variables = {
        name: (dims, np.stack([body[name] for body in bodies]), {"units": units, "long_name": text})
        for name, (dims, units, text) in names.items()
    }
    coordinates = {"body": ["pinion", "gear"], "tooth_offset": list(OFFSETS)}
    attributes = {"title": "influence data of teeth", "source": "fem_reference, hex20", "scene_sha256": scene.sha256}
    return xr.Dataset(variables, coordinates, attributes)


def _body_influence(
    scene: Scene, which: int, material: Material, resolution: _Resolution, prefer: str
) -> dict[str, FloatArray]:
    """The variables of one body."""
    pair = face_gear_pair(scene)
    width = (pair.pinion_face_width_mm, pair.gear_outer_radius_mm - pair.gear_inner_radius_mm)[which]
    face_elements = (resolution.stations - 1) * resolution.elements_between_stations
    divisions = Divisions(
        flank=resolution.heights - 1,
        fillet=resolution.fillet,
        land=1,
        across=5,
        depth=5,
        face_size=width / face_elements,
        towards_fillet=_TOWARDS_FILLET,
    )
    mesh = (pinion_mesh, face_gear_mesh)[which](scene, element="hex20", teeth=_TEETH[which], divisions=divisions)
    body = ElasticBody.of(mesh.mesh, "hex20", material)
    every = 2 * resolution.elements_between_stations  # lattice columns from station to station
    flank = mesh.flanks[0, LOADED]
    nodes = flank.nodes[::2, ::every]
    spread = _spread_loads(body, flank, every)

    readers, depth = zip(*[_deflection_operator(body, mesh, tooth, every) for tooth in OFFSETS], strict=True)
    gauges = [_stress_operator(body, mesh, tooth, resolution.elements_between_stations) for tooth in OFFSETS]
    deflection, stress = _solve(body, mesh, spread, readers, gauges, prefer)

    turned = deflection[::-1].swapaxes(1, 2)
    asymmetry = np.abs(deflection - turned).max() / (2.0 * np.abs(deflection).max())
    shape = nodes.shape
    fillet = mesh.fillets[0, LOADED]
    return {
        "load_profile": flank.profile[::2, flank.profile.shape[1] // 2],
        "load_face": flank.face[::every],
        "depth": depth[OFFSETS.index(0)],
        "fillet_arc": fillet.arc[:, fillet.arc.shape[1] // 2],
        "deflection": (0.5 * (deflection + turned)).reshape(len(OFFSETS), *shape, *shape),
        "root_stress": stress.reshape(len(OFFSETS), -1, shape[1], *shape),
        "asymmetry": np.array(asymmetry),
    }


def _solve(
    body: ElasticBody,
    mesh: ToothMesh,
    loads: csr_matrix,
    readers: tuple[csr_matrix, ...],
    gauges: list[csr_matrix],
    prefer: str,
) -> tuple[FloatArray, FloatArray]:
    """Readings (tooth, observers, loads) of deflection and stress for unit forces into the material."""
    free = body.free_dofs(mesh.held)
    factor = factorise(body.stiffness[free][:, free], places=body.points[free // 3], prefer=prefer)
    parts: tuple[list[FloatArray], list[FloatArray]] = ([], [])
    free_operators = [[op[:, free] for op in operators] for operators in (readers, gauges)]
    for start in range(0, loads.shape[0], _LOADS_AT_ONCE):
        load = loads[start : start + _LOADS_AT_ONCE, free].toarray().T
        moved = factor.solve(load)
        for part, operators in zip(parts, free_operators, strict=True):
            part.append(np.stack([op @ moved for op in operators]))
    return np.concatenate(parts[0], axis=2), np.concatenate(parts[1], axis=2)


def _spread_loads(body: ElasticBody, flank: FlankGrid, every: int) -> csr_matrix:
    """Unit loads (height and station, unknowns) into the material, falling linearly to the stations beside."""
    face = flank.face
    share = np.maximum(1.0 - np.abs(face - face[::every, None]) / (face[every] - face[0]), 0.0)
    share *= np.where(np.arange(len(face)) % 2, 4.0, 2.0)  # consistent with quadratic elements
    share[:, [0, -1]] *= 0.5
    share /= share.sum(axis=1, keepdims=True)
    nodes, normals = flank.nodes[::2], flank.normals[::2]
    values = -share[None, :, :, None] * normals[:, None]  # (height, station, column, component)
    unknowns = np.broadcast_to(body.dofs(nodes.ravel()).reshape(len(nodes), 1, len(face), 3), values.shape)
    rows = np.arange(len(nodes) * len(share)).reshape(len(nodes), -1, 1, 1)
    where = (np.broadcast_to(rows, values.shape).ravel(), unknowns.ravel())
    return coo_matrix((values.ravel(), where), shape=(rows.size, body.points.size)).tocsr()


def _deflection_operator(body: ElasticBody, mesh: ToothMesh, tooth: int, every: int) -> tuple[csr_matrix, FloatArray]:
    """Matrix to the inward motion of the middle surface at the load grid of a tooth; distances to that surface.

    The load grid is that of tooth 0, turned on to the tooth, whose own mesh may be coarser.
    """
    own, grid = mesh.flanks[tooth, LOADED], mesh.flanks[0, LOADED]
    middle = mesh.middles[tooth][:, ::every]
    rows, columns, values = [], [], []
    count, stations = grid.profile[::2, ::every].shape
    depth = np.empty((count, stations))
    for k in range(stations):
        column = k * every
        at = grid.profile[::2, column]
        along = own.profile[:, column]
        places = make_interp_spline(along, own.points[:, column], k=3)(at)
        normals = make_interp_spline(along, own.normals[:, column], k=3)(at)
        line = body.points[middle[:, k]]
        # in the section, the middle is where the flank's inward normal meets the line of the middle nodes: distance
        # across the tooth is measured along `across`, which is normal to that line and to the face direction
        down = line[-1] - line[0]
        down /= np.linalg.norm(down)
        across = normals - np.outer(normals @ down, down)
        across -= np.outer(across @ _face_direction(mesh, tooth, column), _face_direction(mesh, tooth, column))
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        distance = np.einsum("ni,ni->n", places - line[0], across) / np.einsum("ni,ni->n", normals, across)
        met = (places - distance[:, None] * normals - line[0]) @ down
        stations_down = (line - line[0]) @ down
        basis = make_interp_spline(stations_down, np.eye(len(line)), k=3)(np.clip(met, 0.0, stations_down[-1]))
        weights = -basis[:, :, None] * normals[:, None, :]
        row = np.arange(count) * stations + k
        rows.append(np.broadcast_to(row[:, None, None], weights.shape).ravel())
        columns.append(np.broadcast_to(body.dofs(middle[:, k]), weights.shape).ravel())
        values.append(weights.ravel())
        depth[:, k] = distance
    triplets = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return coo_matrix(triplets, shape=(count * stations, body.points.size)).tocsr(), depth


def _face_direction(mesh: ToothMesh, tooth: int, column: int) -> FloatArray:
    """Unit vector along the face on the tooth's middle surface: radial for a gear, axial for a pinion."""
    nodes = mesh.middles[tooth][0, ::2]
    ends = mesh.mesh.doflocs[:, nodes[[0, -1]]]
    direction = ends[:, 1] - ends[:, 0]
    return np.asarray(direction / np.linalg.norm(direction))


def _stress_operator(body: ElasticBody, mesh: ToothMesh, tooth: int, every: int) -> csr_matrix:
    """Matrix to the fillet stress of a tooth at the fillet points of tooth 0, at the load stations."""
    own, target = mesh.fillets[tooth, LOADED].arc[:, ::2], mesh.fillets[0, LOADED].arc[:, ::2]
    operator = fillet_operator(body, mesh, tooth=tooth)
    points, stations = own.shape
    parts = []
    for k in range(0, stations, every):
        rows = operator[np.arange(points) * stations + k]
        if own.shape != target.shape:
            rows = csr_matrix(make_interp_spline(own[:, k], np.eye(points), k=3)(target[:, k])) @ rows
        parts.append(rows.tocoo())
    # rows of each station -> (fillet point, station)
    count = target.shape[0]
    row = np.concatenate([part.row * len(parts) + k for k, part in enumerate(parts)])
    column = np.concatenate([part.col for part in parts])
    value = np.concatenate([part.data for part in parts])
    return coo_matrix((value, (row, column)), shape=(count * len(parts), body.points.size)).tocsr()
