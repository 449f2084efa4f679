"""Analyses of a scene without wear steps: unloaded and loaded tooth contact."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from semiwear import collect
from semiwear.compliance.blas_threads import one_blas_thread
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.errors import SceneError
from semiwear.meshing.face_gear_pair import FaceGearMesh
from semiwear.meshing.tooth_contact import unloaded_contact
from semiwear.plan import plan
from semiwear.results import build_dataset, build_tree
from semiwear.scene import Placement, Scene
from semiwear.simulate import attributes
from semiwear.threads import using_threads
from semiwear.wear.swept_line import fresh_sweep

__all__ = ["loaded_contact", "tooth_contact_analysis"]


def tooth_contact_analysis(scene: Scene, placement: Placement | None = None) -> xr.Dataset:
    """Unloaded contact of one tooth pair, from its first to its last touch.

    Parameters
    ----------
    scene : Scene
    placement : Placement, optional
        Rigid displacement of the pinion.

    Returns
    -------
    Dataset
        `path_of_contact` [mm, fixed frame], `transmission_error` [arcsec, gear side], `contact_ellipse_angle` [deg
        off the pinion axis] and `principal_relative_curvature` [1/mm] over `roll_position`; `contact_ratio`,
        `undercut_radius`, `pointing_radius` [mm].

    Examples
    --------
    >>> import semiwear as sw
    >>> found = sw.tooth_contact_analysis(sw.load_scene("spur_fzg_c"))
    >>> print(f"{float(found.contact_ratio):.3f}")
    1.438
    """
    physics = plan(scene)
    pair = physics.flank_pair(placement)
    contact = unloaded_contact(pair)
    points = contact.points
    mirror = np.array([1.0 if scene.operation.loaded_flank == "drive" else -1.0, 1.0, 1.0])
    variables: dict[str, ArrayLike] = {
        "path_of_contact": points.position * mirror,
        "transmission_error": contact.transmission_error,
        "principal_relative_curvature": points.curvature,
        "contact_ellipse_angle": np.degrees(np.arccos(np.minimum(np.abs(points.along[:, 2]), 1.0))),
        "contact_ratio": contact.contact_ratio,
    }
    if isinstance(pair, FaceGearMesh):
        variables["undercut_radius"] = pair.gear.undercut_radius()
        variables["pointing_radius"] = pair.gear.pointing_radius()
    arrays = {name: np.asarray(value) for name, value in variables.items()}
    attrs = attributes(physics, "tooth_contact_analysis")
    return build_dataset("tooth_contact", arrays, {"roll_position": contact.roll}, attrs)


@one_blas_thread()
def loaded_contact(
    scene: Scene,
    roll_positions: ArrayLike | None = None,
    wear_depth: ArrayLike | xr.DataArray | None = None,
    placement: Placement | None = None,
) -> xr.DataTree:
    """Loaded contact over one mesh cycle, for one wear state.

    Parameters
    ----------
    scene : Scene
    roll_positions : array_like, optional
        Roll positions, taken modulo 1; every tooth pair there is solved. Default: ``numerics.roll_positions`` even
        ones over a mesh cycle.
    wear_depth : array_like (body, profile, face) or (profile, face), optional
        Wear depth [um] on the grid of `/flank`, as `simulate` gives it for the same numerics. The slices are those of
        a DataArray's coordinate `face`, where it has one. Default: unworn.
    placement : Placement, optional
        Rigid displacement of the pinion.

    Returns
    -------
    DataTree
        Groups `/engagement`, `/mesh_cycle` and `/diagnostics`, with a `wear_step` of length one.

    Examples
    --------
    >>> import semiwear as sw
    >>> coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8}
    >>> contact = sw.loaded_contact(sw.load_scene("spur_fzg_c").replace(coarse), [0.0])
    >>> print(f"{float(contact['engagement'].load_share.sum()):.6f}")
    1.000000
    """
    physics = plan(scene)
    given = None if roll_positions is None else np.atleast_1d(np.asarray(roll_positions, float))
    with using_threads(scene.numerics.threads):
        teeth = physics.loaded_teeth(placement, given, _slices_of(wear_depth, physics.flank_pair().face_limits))
        state = teeth.load(_wear_of_gear(teeth, wear_depth))
        pressure = teeth.pressures(state)
    told, _ = collect.observed(teeth, state, pressure, physics.observers(teeth), physics.clock)
    groups = {
        "engagement": collect.engagement(teeth, state, pressure, fresh_sweep(teeth.pair, teeth.lines)) | told,
        "mesh_cycle": collect.mesh_cycle(teeth, state),
        "diagnostics": collect.residuals(state),
    }
    stacks = {name: collect.stacked([group]) for name, group in groups.items()}
    stacks["engagement"] |= collect.slices(teeth)
    return build_tree(stacks, collect.coordinates(teeth), attributes(physics, "loaded_contact"))


def _slices_of(wear_depth: ArrayLike | xr.DataArray | None, limits: tuple[float, float]) -> np.ndarray | None:
    """Face coordinates that a wear depth brings along [mm]; they must be even, and on the flank."""
    if not isinstance(wear_depth, xr.DataArray) or "face" not in wear_depth.coords:
        return None
    face = np.asarray(wear_depth["face"], float)
    width = np.diff(face)
    fix = "use the wear_depth of a result, or leave the coordinate out"
    if face.size < 2 or width.min() <= 0.0 or np.ptp(width) > 1e-6 * width.mean():
        raise SceneError.of("wear_depth.face", "uneven stations", "middles of even slices, growing [mm]", fix)
    if face[0] < limits[0] or face[-1] > limits[1]:
        allowed = f"middles of slices on the gear's face, {limits[0]:g} to {limits[1]:g} mm"
        raise SceneError.of("wear_depth.face", f"{face[0]:g} to {face[-1]:g} mm", allowed, fix)
    return face


def _wear_of_gear(teeth: LoadedTeeth, wear_depth: ArrayLike | xr.DataArray | None) -> np.ndarray:
    """Wear of the driven flank on the grid [mm], from a wear depth [um] in the result's layout."""
    shape = teeth.grid.profile.shape
    if wear_depth is None:
        return np.zeros(shape)
    depth = np.asarray(wear_depth, float)
    if depth.ndim == 3 and depth.shape[0] == 2:
        if np.any(depth[0] != 0.0):
            raise SceneError.of(
                "wear_depth", "a worn pinion", "zero on the pinion", "only the gear's wear can be given as yet"
            )
        depth = depth[1]
    if depth.shape != shape[::-1]:
        raise SceneError.of(
            "wear_depth",
            f"an array of shape {np.shape(wear_depth)}",
            f"(profile, face) = {shape[::-1]}, or with both bodies in front",
            "use the wear_depth of a result with the same numerics",
        )
    if not np.all(np.isfinite(depth)) or np.any(depth < 0.0):
        raise SceneError.of("wear_depth", "negative or not finite", "finite numbers >= 0 [um]")
    return np.ascontiguousarray(1e-3 * depth.T)
