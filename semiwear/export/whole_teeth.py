"""Whole worn teeth, and input decks of worn bodies under the load of their contact, with meshes of `fem_reference`.

This is the only module of semiwear that imports `fem_reference`, and only for meshes, never for physical results.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.arrays import FloatArray
from semiwear.errors import SceneError
from semiwear.export.flank_surface import step_fields
from semiwear.export.nodes import FlankNodes, chosen_step, flank_nodes, scene_of
from semiwear.export.surface import Surface
from semiwear.export.worn_contact import WornContact
from semiwear.measured.nominal import unreached
from semiwear.meshing.flank_pair import BODIES
from semiwear.results.missing import group_of
from semiwear.scene import CylindricalPair, FaceGearPair, Scene
from semiwear.targets import replacing

if TYPE_CHECKING:
    from fem_reference.tooth_mesh import Divisions
    from fem_reference.worn_meshes import FlankLoad, FlankWear, WornBody

_LOADED = 1e-6  # of the greatest force: smaller forces are left out
_PER_MODULE = 0.5  # length of an element along the face over the module
_TEETH = 5  # in the mesh of a face gear pair's bodies


def worn_tooth(tree: xr.DataTree, body: str = "gear", wear_step: int = -1, *, exaggeration: float = 1.0) -> Surface:
    """A whole worn tooth with its rim as a closed surface, with the wear of every step as fields.

    Parameters
    ----------
    tree : DataTree
        A result of `simulate` for a face gear pair or a cylindrical pair.
    body : str
        ``"pinion"`` or ``"gear"``.
    wear_step : int
        Wear step of the shape. Default: the last.
    exaggeration : float
        Factor on the wear in the shape, but not in the fields.

    Returns
    -------
    Surface
        In the body's own frame (z is its axis). Fields: `wear_depth` and `wear_depth_step_k` [um]; 0 outside the
        flank.

    Raises
    ------
    SceneError
        For an unknown body or wear step, a result without wear depths, flanks given as points, or an exaggeration
        that folds the tooth.
    """
    from fem_reference.tooth_mesh import Divisions
    from fem_reference.worn_meshes import MeshError, worn_body

    scene, nodes = _meshed(tree), flank_nodes(tree, body)
    step = chosen_step(len(nodes.depth), wear_step)
    # facets so fine that their error of shape is less than the wear
    fine = Divisions(64, 16, land=1, across=3, depth=3, face_size=0.5 * _PER_MODULE * _module(scene))
    shapes = [_wear_of(nodes, factor * nodes.depth[step]) for factor in (exaggeration, 0.0)]
    try:
        found, unworn = (worn_body(scene, body, shape, element="hex8i", teeth=1, divisions=fine) for shape in shapes)
    except MeshError as error:
        if exaggeration == 1.0:
            raise
        raise SceneError.of("exaggeration", exaggeration, "less: such wear folds the tooth", str(error)) from error
    skin = found.skin()
    used, quads = np.unique(skin, return_inverse=True)
    rotation, shift = _into_own_frame(unworn, nodes)
    quads = quads.reshape(skin.shape)
    if np.linalg.det(rotation) < 0.0:  # the coast flank is a mirror image
        quads = quads[:, ::-1]
    depth = np.stack([1e3 * found.nodal_depth(_wear_of(nodes, step_depth))[used] for step_depth in nodes.depth])
    fields = step_fields(depth, step)
    points = found.body.points[used] @ rotation.T + shift
    return Surface(points, quads, fields, dict.fromkeys(fields, "um"))


def write_input_deck(
    tree: xr.DataTree, target: Path, body: str, wear_step: int, roll_position: float | None, teeth: int | None
) -> None:
    """Write the input deck of a worn body under the load of its contact; parameters as in `export`."""
    from fem_reference.worn_meshes import worn_body

    scene, nodes = _meshed(tree), flank_nodes(tree, body)
    step = chosen_step(len(nodes.depth), wear_step)
    roll = _roll_of(tree, body, step, roll_position)
    cylindrical = isinstance(scene.gear_pair, CylindricalPair)
    count = (None if cylindrical else _TEETH) if teeth is None else teeth
    loads = contact_loads(tree, body, step, roll)
    farthest = max((abs(load.tooth) for load in loads), default=0)
    if teeth is not None and (teeth - 1) // 2 < farthest:
        allowed = f"{2 * farthest + 1} or more: teeth beside the middle tooth bear load"
        raise SceneError.of("teeth", teeth, allowed, "leave it out for the default number")
    wear = _wear_of(nodes, nodes.depth[step])
    found = worn_body(scene, body, wear, teeth=count, divisions=deck_divisions(scene))
    title = f"semiwear: {body} of {scene.title or 'a pair'}, wear step {step}, roll position {roll:.4g}"
    with replacing(target) as part:
        found.write(part, loads, title=title.encode("ascii", "replace").decode())


def deck_divisions(scene: Scene) -> Divisions:
    """Elements of the loaded tooth of an input deck, for an error of the root stress of about 2 %."""
    from fem_reference.tooth_mesh import Divisions

    cylindrical = isinstance(scene.gear_pair, CylindricalPair)
    face_size = _PER_MODULE * _module(scene)
    return Divisions(8, 8, land=1, across=6, depth=5, face_size=face_size, towards_fillet=1.8, deeper=cylindrical)


def contact_loads(tree: xr.DataTree, body: str, wear_step: int, roll_position: float) -> list[FlankLoad]:
    """Normal forces of the contact on a worn body's teeth; the pair at the roll position is on tooth 0."""
    from fem_reference.worn_meshes import FlankLoad

    contact = WornContact.of(tree, np.array([roll_position % 1.0]))
    teeth, state = contact.teeth, contact.load(wear_step)
    lines, force, profile, face = teeth.lines, state.loads.force, state.coarse.profile, teeth.lines.face
    if body == "pinion":
        profile = lines.on_driving(profile)
    loads = []
    for k, roll in enumerate(lines.roll):
        on = force[k] > _LOADED * force.max()
        # pair j, pinion tooth j on gear tooth -j, is j pitches ahead of the pair at the roll position
        ahead = round(float(roll) - roll_position)
        at_face = lines.driving_face[k] if body == "pinion" else face
        if on.any():
            loads.append(FlankLoad(ahead if body == "pinion" else -ahead, at_face[on], profile[k, on], force[k, on]))
    return loads


def _meshed(tree: xr.DataTree) -> Scene:
    scene = scene_of(tree)
    if not isinstance(scene.gear_pair, CylindricalPair | FaceGearPair):
        fix = 'export part = "flank"; teeth of flanks given as points are not meshed'
        raise SceneError.of("gear_pair.type", scene.gear_pair.type, '"face_gear" or "cylindrical"', fix)
    return scene


def _module(scene: Scene) -> float:
    pair = scene.gear_pair
    if isinstance(pair, CylindricalPair):
        return pair.normal_module_mm
    assert isinstance(pair, FaceGearPair)
    return pair.module_mm


def _wear_of(nodes: FlankNodes, depth: FloatArray) -> FlankWear:
    """Wear of the flank; where the body is wider than its mate, it falls to zero over the last half slice."""
    from fem_reference.worn_meshes import FlankWear

    face, profile = nodes.face, nodes.profile
    for end, border in zip((0, -1), unreached(nodes.flank.pair, nodes.flank.body, nodes.face), strict=True):
        if np.isfinite(border):
            at = 0 if end == 0 else len(face)
            face, depth = np.insert(face, at, border), np.insert(depth, at, 0.0, axis=0)
            # linear extrapolation of the grid by half a slice
            neighbour = nodes.profile[1] if end == 0 else nodes.profile[-2]
            profile = np.insert(profile, at, 1.5 * nodes.profile[end] - 0.5 * neighbour, axis=0)
    return FlankWear(face, profile.T, depth.T)


def _into_own_frame(unworn: WornBody, nodes: FlankNodes) -> tuple[FloatArray, FloatArray]:
    """Rotation (mirroring for a coast flank) and shift from the frame of the mesh to the body's own frame.

    Found from the points of a flank with the same flank coordinates in both frames (Kabsch 1976).
    """
    flank = unworn.mesh.flanks[0, 0]
    own, _ = nodes.flank.points(np.broadcast_to(flank.face, flank.profile.shape), flank.profile)
    in_mesh, in_own = flank.points.reshape(-1, 3), own.reshape(-1, 3)
    left, _, right = np.linalg.svd((in_mesh - in_mesh.mean(axis=0)).T @ (in_own - in_own.mean(axis=0)))
    rotation = right.T @ left.T
    return rotation, in_own.mean(axis=0) - rotation @ in_mesh.mean(axis=0)


def _roll_of(tree: xr.DataTree, body: str, step: int, roll_position: float | None) -> float:
    """The given roll position; default that of the body's greatest root stress, or of the greatest load share."""
    data = group_of(tree, "engagement")
    rolls = data["roll_position"].values
    if roll_position is None:
        worn = data.isel(wear_step=step)
        severity = worn["root_stress"].isel(body=BODIES.index(body)) if "root_stress" in worn else worn["load_share"]
        return float(rolls[int(np.argmax(severity.values))])
    if not rolls.min() <= roll_position <= rolls.max():
        allowed = f"{rolls.min():g} to {rolls.max():g}, where the pair may be in contact"
        raise SceneError.of("roll_position", roll_position, allowed, "0 is the pitch point")
    return float(roll_position)
