"""Loaded contact of a gear pair in finite elements, with the arguments and the result of `semiwear.loaded_contact`.

Both bodies are elastic solids (trilinear hexahedra with incompatible modes), the pinion held at its bore, the gear at
its back face. Teeth that may touch carry fine patches along the contact line; contact is frictionless, by dual mortar
multipliers on the gear's flank, with the exact gap of the true flanks, roundings of the edges and wear included. The
torque is given, the pinion's rotation solved for. Root stress is taken from finer meshes of 20-node elements under
the same contact forces. Only scene, flank geometry and result schema are shared with the core.

A position of the shipped face gear takes some 30 s of processor time. The meshes of root stress are factorised once,
by MKL Pardiso (extra `fem`) or, without it, by a nested dissection of our own that needs scipy alone.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from fem_reference.arrays import FloatArray
from fem_reference.contact import ContactMeshError
from fem_reference.fem_results import result_groups, tree_of
from fem_reference.line_meshes import usual_element_length
from fem_reference.mesh_position import MeshedPosition, MeshSettings, PositionResult
from fem_reference.pairs import pair_motion, usual_teeth
from fem_reference.rigid_lines import RigidFlank
from fem_reference.root_load import RootStress
from fem_reference.wear import wear_depth_of
from semiwear.errors import SceneError
from semiwear.scene import Placement, Scene

_WIDER = 2.0  # times the patch of a pair whose contact reached its border
_WIDEST = 1.0  # a patch as wide as that, in times of the usual one, may be made wider: once
_KNOWN_EFFECTS = ("free_edges",)  # solids have them by themselves
_LIGHT = 0.1  # share of the load of pairs that need not be resolved
_ROOT_ELEMENTS = ("fillet", "across", "flank")

POSITIONS = 9
"""Mesh positions unless they are given."""


def loaded_contact(
    scene: Scene,
    roll_positions: ArrayLike | None = None,
    wear_depth: ArrayLike | xr.Dataset | xr.DataTree | xr.DataArray | None = None,
    placement: Placement | None = None,
    *,
    elements_per_half_width: float = 3.0,
    element_length: float | None = None,
    teeth: int | None = None,
    pinion_teeth: int | None = None,
    root_stress: bool = True,
    root_elements: Mapping[str, int] | None = None,
    strict: bool = True,
    worn_flank: str = "gap",
) -> xr.DataTree:
    """Loaded contact over one mesh cycle, for one wear state.

    Parameters
    ----------
    scene : Scene
        With a face gear pair or a cylindrical one.
    roll_positions : array_like, optional
        Roll positions, taken modulo 1; every tooth pair there is solved. Default: nine even ones over a mesh cycle.
    wear_depth : optional
        Wear of the gear [um]: the `/flank` group of a result (Dataset or DataTree; its last wear step counts), or its
        `wear_depth`, (body, profile, face) or (profile, face), on the grid of the scene's own numerics.
    placement : Placement, optional
        Rigid displacement of the pinion.
    elements_per_half_width : float
        Elements across the expected half-width of the contact on the present flank: 2 gives the peak pressure to
        5 %, 3 to 2 %, 4 to 1 %.
    element_length : float, optional
        Length of the elements along the contact line [mm]. Default 0.4 modules, or a fourteenth of the gear's face
        width if that is less.
    teeth, pinion_teeth : int, optional
        Teeth in the meshes of gear and pinion, 5 and more. Default 5 of a face gear and 9 of its pinion, and every
        tooth of a cylindrical gear: those that cannot touch are condensed and cost little. A sector of fewer has free
        cut planes and is softer than the ring: by 2 % with 5 teeth on a rim of 2.5 modules, but by 70 % with 11 of
        31 on a rim of 45 mm.
    root_stress : bool
        Whether to compute root stress.
    root_elements : mapping of str to int, optional
        Numbers of elements of its meshes, by their names in `fem_reference.root_load.RootStress`. Half as many again
        in all three directions raise the stress by loads beside a fillet by 1.5 %, others by 0.3 % at most.
    strict : bool
        Refuse pressures that the mesh cannot resolve: fewer than three nodes across the contact of a pair that
        carries a tenth of the load, or a contact that reaches the border of the refined patch even after that was
        widened. Otherwise they are only flagged.
    worn_flank : str
        Treatment of wear: ``"gap"`` over the unworn mesh, or ``"moved_nodes"``: the flank's nodes moved along their
        normals, with smoothing of the mesh inside the teeth.

    Returns
    -------
    DataTree
        Groups `/engagement`, `/mesh_cycle` and `/diagnostics` as from `semiwear.loaded_contact`, with a `wear_step`
        of length one. `/diagnostics` holds, beside the schema's own, `smallest_gap`, `elements_across`,
        `reaches_border`, `edge_contact` over `roll_position` or `mesh_position`.

    Raises
    ------
    SceneError
        For a torque that is not positive, a bad wear depth, no possible contact, an effect that is not in here or a
        kind of gear pair that has no teeth to mesh (flanks given as points).
    ContactMeshError
        If `strict`.
    """
    refuse_effects(scene)
    flank = RigidFlank(pair_motion(scene, on_loaded_flank(scene, placement)))
    flank = RigidFlank(flank.pair, wear_depth_of(wear_depth, flank.pair))
    positions = _mesh_positions(roll_positions)
    usual = usual_teeth(scene)
    settings = MeshSettings(
        elements_per_half_width,
        usual_element_length(flank.pair) if element_length is None else element_length,
        usual["gear"] if teeth is None else teeth,
        usual["pinion"] if pinion_teeth is None else pinion_teeth,
        worn_flank=worn_flank,
    )
    finer = _root_elements(root_elements)
    roots = RootStress(scene, settings.gear_teeth, settings.pinion_teeth, **finer) if root_stress else None
    solved = solve_positions(flank, positions, settings, roots, strict=strict)
    groups, coords = result_groups([(flank, solved)], positions)
    return tree_of(scene, groups, coords, "loaded_contact")


def _root_elements(given: Mapping[str, int] | None) -> dict[str, int]:
    """Numbers of elements of the root's meshes, checked."""
    for name, number in (given or {}).items():
        if name not in _ROOT_ELEMENTS:
            raise SceneError.of("root_elements", name, f"one of {', '.join(_ROOT_ELEMENTS)}")
        step, allowed = (2, "an even number >= 2") if name == "fillet" else (1, "a whole number >= 1")
        if not (number >= step and number % step == 0):
            raise SceneError.of(f"root_elements.{name}", number, allowed)
    return dict(given or {})


def solve_positions(
    flank: RigidFlank,
    positions: FloatArray,
    settings: MeshSettings,
    roots: RootStress | None = None,
    *,
    strict: bool = True,
) -> list[PositionResult]:
    """Contact at each of some mesh positions.

    Raises
    ------
    SceneError
        For a torque that is not positive or no possible contact.
    ContactMeshError
        If strict, for pressures that the mesh cannot resolve.
    """
    torque = torque_of(flank)
    solved = []
    for position in positions:
        _, result = mesh_and_solve(flank, float(position), settings, torque, roots)
        if strict:
            try:
                result.solution.require_resolved(least_share=_LIGHT)
            except ContactMeshError as problem:
                raise ContactMeshError(f"mesh position {position:.4g}: {problem}") from None
        solved.append(result)
    return solved


def torque_of(flank: RigidFlank) -> float:
    """The pinion's torque [N mm].

    Raises
    ------
    SceneError
        If it is not positive.
    """
    torque = 1e3 * flank.pair.scene.operation.pinion_torque_Nm
    if not (np.isfinite(torque) and torque > 0.0):
        raise SceneError.of(
            "operation.pinion_torque_Nm", 1e-3 * torque, "> 0", "the pinion drives; take the coast flank instead"
        )
    return torque


def mesh_and_solve(
    flank: RigidFlank, mesh_position: float, settings: MeshSettings, torque: float, roots: RootStress | None = None
) -> tuple[MeshedPosition, PositionResult]:
    """A mesh position with patches wide enough that no contact reaches their borders, if possible.

    Raises
    ------
    SceneError
        If no contact is possible.
    """
    flank.least_gap(mesh_position)
    wider: dict[int, float] = {}
    spent: Counter[str] = Counter()
    while True:
        meshed = MeshedPosition.of(flank, mesh_position, torque, replace(settings, wider=wider))
        result = meshed.solve(torque)
        total = sum(found.contact.load for found in result.pairs.values())
        short = [
            j for j, found in result.pairs.items() if found.contact.borders and found.contact.load > _LIGHT * total
        ]
        if not short or max(wider.get(j, 1.0) for j in short) > _WIDEST:
            if roots is not None:
                result = meshed.solve(torque, roots)
            return meshed, replace(result, seconds={name: s + spent[name] for name, s in result.seconds.items()})
        spent.update(result.seconds)
        wider |= {j: _WIDER * wider.get(j, 1.0) for j in short}


def refuse_effects(scene: Scene) -> None:
    """Refuse effects that are not in the finite elements; free edges always are.

    Raises
    ------
    SceneError
        Naming the first of them.
    """
    for name, _ in scene.effects.present():
        if name not in _KNOWN_EFFECTS:
            raise SceneError.of(
                f"effects.{name}", "a table", "no such table", "not in the finite elements: leave it out here"
            )


def on_loaded_flank(scene: Scene, placement: Placement | None) -> Placement:
    """The coast flank is the drive flank mirrored at x = 0: the placement is mirrored instead."""
    given = placement or Placement()
    if scene.operation.loaded_flank == "drive":
        return given
    return Placement(
        -given.offset_mm,
        given.axial_pinion_mm,
        given.axial_gear_mm,
        given.shaft_angle_error_mrad,
        -given.pinion_slope_mrad,
    )


def _mesh_positions(roll_positions: ArrayLike | None) -> FloatArray:
    if roll_positions is None:
        return np.arange(POSITIONS) / POSITIONS
    positions = np.atleast_1d(np.asarray(roll_positions, dtype=float))
    if positions.size == 0 or not np.all(np.isfinite(positions)):
        raise SceneError.of("roll_positions", roll_positions, "finite numbers, one at least")
    position = np.mod(np.round(positions, 12), 1.0)
    return np.unique(np.where(position > 1.0 - 1e-9, 0.0, position))
