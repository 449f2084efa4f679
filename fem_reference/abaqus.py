r"""Any body of this package as an input deck for Abaqus or CalculiX.

One flat deck, one static step: nodes and elements of all bodies (numbered consecutively), materials, node sets,
element surfaces, contact pairs, held and displaced nodes, nodal forces. "hex8i" becomes C3D8I, "hex20" C3D20; a
27-node mesh has no counterpart in CalculiX. Lengths mm, forces N, stress MPa.

For instance the face gear of a scene under a pressure on one tooth::

    mesh = face_gear_mesh(scene, element="hex20")
    steel = {"youngs_modulus": 207000.0, "poissons_ratio": 0.3}
    body = ElasticBody(mesh.mesh, element="hex20", **steel)
    load = pressure_load(body, mesh, lambda profile, face: 50.0 + 0.0 * face)
    write_inp("gear.inp", {"gear": body}, node_sets={"back": ("gear", mesh.held)},
              boundary=[("back", 1, 3, 0.0)], forces={"gear": load})

Source: CalculiX CrunchiX user's manual, 2.20, sections 6.2 (elements) and 7 (input deck). Abaqus reads the same
keywords; its contact law and output requests may need changes.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fem_reference.arrays import FloatArray, IntArray
from fem_reference.elasticity import ELEMENTS, ElasticBody

_TYPES = {"hex8i": "C3D8I", "hex20": "C3D20"}
_CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
_FACES = [(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)]  # S1 to S6


@dataclass(frozen=True)
class ContactPair:
    """Frictionless surface-to-surface contact with a linear pressure-overclosure law.

    Attributes
    ----------
    slave, master : str
        Names of surfaces.
    stiffness : float
        Pressure per overclosure [N/mm^3].
    """

    slave: str
    master: str
    stiffness: float = 1e7


def node_offsets(bodies: Mapping[str, ElasticBody]) -> dict[str, int]:
    """Offset from a body's displacement node (from 0) to its number in the deck (from 1)."""
    ends = np.cumsum([0] + [len(body.points) for body in bodies.values()])
    return {name: int(end) + 1 for name, end in zip(bodies, ends, strict=False)}


def write_inp(  # noqa: C901
    path: str | os.PathLike[str],
    bodies: Mapping[str, ElasticBody],
    *,
    node_sets: Mapping[str, tuple[str, IntArray]] | None = None,
    surfaces: Mapping[str, tuple[str, IntArray]] | None = None,
    boundary: Sequence[tuple[str, int, int, float]] = (),
    forces: Mapping[str, FloatArray] | None = None,
    contacts: Sequence[ContactPair] = (),
    increment: float = 1.0,
    reactions: Sequence[str] = (),
    title: str = "semiwear",
) -> Path:
    """Write an input deck.

    Parameters
    ----------
    path : path
        Of the deck, usually ending in ``.inp``.
    bodies : mapping from name to ElasticBody
        The name also names the element set ``NAME`` and the material.
    node_sets : mapping from name to (body, displacement nodes)
    surfaces : mapping from name to (body, displacement nodes)
        All element faces whose corners are among the nodes.
    boundary : sequence of (node set, first, last, value)
        Displacement of the components first to last (1 to 3) [mm].
    forces : mapping from body to (n, 3) or (3 n,) array [N]
        Nodal forces.
    contacts : sequence of ContactPair
    increment : float
        First load increment as part of the step; below 1 for contact.
    reactions : sequence of str
        Node sets whose total reaction is printed.
    title : str

    Returns
    -------
    Path
        Of the deck.

    Raises
    ------
    ValueError
        For an element without a counterpart or an empty surface.
    """
    path = Path(path)
    offsets = node_offsets(bodies)
    node_sets, surfaces = node_sets or {}, surfaces or {}
    lines = ["*HEADING", title]
    first_element, elements = 1, {}
    for name, body in bodies.items():
        if body.element not in _TYPES:
            raise ValueError(f"body {name!r}: {body.element} has no counterpart in CalculiX; use 'hex8i' or 'hex20'")
        numbers = _abaqus_order(body) + offsets[name]
        elements[name] = (first_element, numbers)
        lines += ["*NODE"]
        lines += [f"{k + offsets[name]},{x:.12e},{y:.12e},{z:.12e}" for k, (x, y, z) in enumerate(body.points)]
        lines += [f"*ELEMENT,TYPE={_TYPES[body.element]},ELSET={name}"]
        for k, row in enumerate(numbers):
            lines += _rows([first_element + k, *row])
        first_element += len(numbers)
        lines += [f"*MATERIAL,NAME={name}", "*ELASTIC", f"{body.youngs_modulus:.9e},{body.poissons_ratio:.9e}"]
        lines += [f"*SOLID SECTION,ELSET={name},MATERIAL={name}"]
    for name, (owner, nodes) in node_sets.items():
        lines += [f"*NSET,NSET={name}", *(f"{node}," for node in np.asarray(nodes) + offsets[owner])]
    for name, (owner, nodes) in surfaces.items():
        first, numbers = elements[owner]
        faces = list(_faces_on(numbers[:, :8], np.asarray(nodes) + offsets[owner]))
        if not faces:
            raise ValueError(f"surface {name!r}: no element face has all its corners among the nodes")
        lines += [f"*SURFACE,NAME={name},TYPE=ELEMENT", *(f"{first + element},S{side}" for element, side in faces)]
    for k, pair in enumerate(contacts):
        lines += [f"*SURFACE INTERACTION,NAME=contact{k}", "*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR"]
        lines += [f"{pair.stiffness:.6e}"]
        lines += [f"*CONTACT PAIR,INTERACTION=contact{k},TYPE=SURFACE TO SURFACE", f"{pair.slave},{pair.master}"]
    lines += ["*STEP,NLGEOM=NO" if not contacts else "*STEP,INC=200", "*STATIC", f"{increment},1.0"]
    if boundary:
        lines += ["*BOUNDARY", *(f"{name},{first},{last},{value:.12e}" for name, first, last, value in boundary)]
    if forces:
        lines += ["*CLOAD"]
        for name, force in forces.items():
            rows = np.asarray(force, dtype=float).reshape(-1, 3)
            node, axis = np.nonzero(rows)
            values = rows[node, axis]
            lines += [f"{n + offsets[name]},{a + 1},{v:.12e}" for n, a, v in zip(node, axis, values, strict=True)]
    lines += ["*NODE FILE", "U", "*EL FILE", "S"]
    lines += ["*CONTACT FILE", "CDIS,CSTR"] if contacts else []
    for name in reactions:
        lines += [f"*NODE PRINT,NSET={name},TOTALS=ONLY", "RF"]
    lines += ["*END STEP"]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return path


def _abaqus_order(body: ElasticBody) -> IntArray:
    """Displacement nodes of each element in Abaqus's order, right-handed."""
    places = _CORNERS
    if body.element == "hex20":
        places = np.vstack([2 * _CORNERS, [_CORNERS[a] + _CORNERS[b] for a, b in _EDGES]]) / 2
    own = np.asarray(ELEMENTS[body.element].element.doflocs)

    def order(points: FloatArray) -> IntArray:
        return np.array([int(np.argmin(np.abs(own - point).sum(axis=1))) for point in points])

    right, mirrored = order(places), order(places * (1, 1, -1) + (0, 0, 1))
    corners = body.points[body.elements[:, right[:8]]]
    edges = [corners[:, k] - corners[:, 0] for k in (1, 3, 4)]
    positive = np.einsum("mi,mi->m", np.cross(edges[0], edges[1]), edges[2]) > 0.0
    return np.where(positive[:, None], body.elements[:, right], body.elements[:, mirrored])


def _faces_on(corners: IntArray, nodes: IntArray) -> Iterator[tuple[int, int]]:
    """Elements (from 0) and faces (from 1) whose corners are all among the nodes."""
    among = np.isin(corners, nodes)
    for side, members in enumerate(_FACES, start=1):
        for element in np.flatnonzero(among[:, members].all(axis=1)):
            yield int(element), side


def _rows(numbers: Sequence[int]) -> list[str]:
    """A data line of an element, broken so that no line holds more than 16 entries."""
    parts = [",".join(str(n) for n in numbers[k : k + 11]) for k in range(0, len(numbers), 11)]
    return [f"{part}," for part in parts[:-1]] + parts[-1:]
