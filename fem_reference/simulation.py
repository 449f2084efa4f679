r"""Wear of the gear's flank in finite elements: cycles of meshing, contact and Archard's law.

In a cycle both bodies are meshed around the contact lines of some mesh positions and condensed onto their contact
candidates. On these condensed bodies the wear then grows in many small steps: contact at every position under the
wear so far, then depth from the pressures (`fem_reference.deposit`). A step costs a hundredth of the meshing, so it
can be small enough for explicit stepping to be stable and accurate. The next cycle meshes the worn flank anew.

Wear of the pinion is not included. Depths on the roundings of edges are not kept; at the last nodes before them the
pressure depends on the mesh, and so does the depth there.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from fem_reference.arrays import FloatArray
from fem_reference.deposit import Deposit, by_roll
from fem_reference.face_gear_scene import face_gear_pair
from fem_reference.fem_results import result_groups, tree_of
from fem_reference.kinematics import PairKinematics
from fem_reference.line_meshes import usual_element_length
from fem_reference.loaded import mesh_and_solve, on_loaded_flank, refuse_effects, torque_of
from fem_reference.mesh_position import MeshedPosition, MeshSettings, PositionResult
from fem_reference.pairs import module_of
from fem_reference.passage import Passage, flank_group
from fem_reference.rigid_lines import RigidFlank
from fem_reference.wear import FlankWear, wear_depth_of
from semiwear.errors import SceneError
from semiwear.scene import Placement, Scene

WEAR_POSITIONS = 18
"""Default number of mesh positions; lines move by less than a contact width between two of them."""

_STEP = 8e-5  # modules of greatest depth a step: explicit steps on fine elements are stable up to three times that
_FEWEST, _MOST = 4, 200  # steps a cycle
_HEIGHTS = 641


def simulate(
    scene: Scene,
    *,
    cycles: int = 1,
    meshes: float | None = None,
    wear_depth: ArrayLike | xr.Dataset | xr.DataTree | xr.DataArray | None = None,
    positions: int = WEAR_POSITIONS,
    placement: Placement | None = None,
    elements_per_half_width: float = 2.0,
    element_length: float | None = None,
    teeth: int = 5,
    pinion_teeth: int = 9,
    worn_flank: str = "gap",
) -> xr.DataTree:
    """Wear the gear's flank.

    Parameters
    ----------
    scene : Scene
        With a table [wear].
    cycles : int
        Number of meshings of the worn flank; each costs `positions` contact meshes. A cycle should not wear more
        than some 10 um, which moves the contact lines by half a width.
    meshes : float, optional
        Engagements of one gear tooth in all; default ``wear.until.meshes``.
    wear_depth : optional
        Initial wear of the gear [um], as for `loaded_contact`.
    positions : int
        Mesh positions.
    placement, elements_per_half_width, element_length, teeth, pinion_teeth, worn_flank
        As for `loaded_contact`; line loads, which decide wear, need fewer elements than peak pressures. With
        ``"moved_nodes"`` the flank is moved at the beginning of each cycle; the wear of the cycle is a gap on that.

    Returns
    -------
    DataTree
        `/flank` with `wear_depth` after every cycle, `/engagement`, `/mesh_cycle` and `/diagnostics`, with the names
        of `semiwear.simulate`; no `/history`, no root stress.

    Raises
    ------
    SceneError
        For another kind than a face gear, without a table [wear], without a number of meshes, for fewer than one
        cycle or position, a pinion that wears or an effect that is not in here.
    """
    if scene.wear is None:
        raise SceneError.of("wear", None, "a table [wear]", "use loaded_contact for a scene without wear")
    total = scene.wear.until.meshes if meshes is None else meshes
    if total is None or not (np.isfinite(total) and total > 0.0):
        raise SceneError.of("meshes", total, "> 0", "the scene wears to control depths: give the number of meshes")
    for name, count in (("cycles", cycles), ("positions", positions)):
        if not (count >= 1 and count % 1 == 0):
            raise SceneError.of(name, count, "a whole number >= 1")
    if scene.wear.worn_bodies != ("gear",):
        raise SceneError.of("wear.worn_bodies", scene.wear.worn_bodies, '["gear"]', "the pinion does not wear here")
    refuse_effects(scene)
    face_gear_pair(scene)
    pair = PairKinematics(scene, on_loaded_flank(scene, placement))
    fresh = RigidFlank(pair)
    passage = Passage.of(fresh)
    length = usual_element_length(pair) if element_length is None else element_length
    settings = MeshSettings(elements_per_half_width, length, teeth, pinion_teeth, worn_flank=worn_flank)
    places = np.arange(positions) / positions
    dose = scene.wear.coefficient("gear") * total / cycles

    start = wear_depth_of(wear_depth, pair)
    depth = start.depth(np.broadcast_to(passage.face, passage.profile.shape), passage.profile)
    depths, states = [depth], []
    for cycle in range(cycles):
        flank = RigidFlank(pair, FlankWear(passage.face, passage.profile, depth))
        torque = torque_of(flank)
        found = [mesh_and_solve(flank, float(place), settings, torque) for place in places]
        meshed, solved = [one for one, _ in found], [result for _, result in found]
        if cycle == 0:
            states.append((flank, solved))
        depth, solved = _worn(flank, meshed, solved, places, dose, torque)
        depths.append(depth)
        states.append((RigidFlank(pair, FlankWear(passage.face, passage.profile, depth)), solved))
    groups, coords = result_groups(states, places)
    groups["flank"] = flank_group(passage, depths)
    coords["meshes"] = total / cycles * np.arange(cycles + 1.0)
    return tree_of(scene, groups, coords, "simulate", f"{cycles} wear cycles on {positions} mesh positions")


def _worn(
    flank: RigidFlank,
    meshed: list[MeshedPosition],
    solved: list[PositionResult],
    places: FloatArray,
    dose: float,
    torque: float,
) -> tuple[FloatArray, list[PositionResult]]:
    """Depth [mm] and contact after a cycle that wears by `dose` [mm^2/N], meshes times wear coefficient."""
    # where an edge bounds a line, its position is a point of this grid
    fresh = RigidFlank(flank.pair, heights=_HEIGHTS)
    rolls, pressures = by_roll(places, solved, fresh)
    # the wear of a cycle may let pairs touch that do not yet
    meant = [place + j for place, result in zip(places, solved, strict=True) for j in result.pairs]
    deposit = Deposit.of(fresh, rolls, np.isin(np.round(rolls, 9), np.round(meant, 9)))
    face, profile = deposit.face, deposit.profile
    depth = flank.wear.depth(np.broadcast_to(face, profile.shape), profile)
    rate = deposit(pressures)
    step = _STEP * module_of(flank.pair.scene)
    steps = int(np.clip(np.ceil(dose * rate.max() / step), _FEWEST, _MOST))
    for _ in range(steps):
        depth = depth + dose / steps * rate
        now = RigidFlank(flank.pair, FlankWear(face, profile, depth))
        solved = [
            one.solve(torque, flank=now, start=[found.contact.active for found in last.pairs.values()])
            for one, last in zip(meshed, solved, strict=True)
        ]
        rate = deposit(by_roll(places, solved, fresh)[1])
    return depth, solved
