"""Analyses of a scene without wear steps: unloaded and loaded tooth contact."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from semiwear import collect
from semiwear.arrays import FloatArray
from semiwear.compile_ahead import compile_ahead
from semiwear.compliance.blas_threads import one_blas_thread
from semiwear.errors import Collected, Problem, SceneError
from semiwear.life import hours_per_mesh
from semiwear.meshing.face_gear_pair import FaceGearMesh
from semiwear.meshing.flank_pair import BODIES, DRIVEN, DRIVING
from semiwear.meshing.roll_grid import checked_roll_positions
from semiwear.meshing.tooth_contact import unloaded_contact
from semiwear.plan import plan
from semiwear.plan.choices import kernels_of
from semiwear.results import build_dataset, build_tree
from semiwear.scene import Placement, Scene
from semiwear.simulate import attributes
from semiwear.threads import using_threads
from semiwear.wear.swept_line import fresh_sweep
from semiwear.wear.worn import Worn


def tooth_contact_analysis(scene: Scene, placement: Placement | None = None) -> xr.Dataset:
    """Unloaded contact of one tooth pair, from its first to its last touch.

    Parameters
    ----------
    scene : Scene
    placement : Placement, optional
        Rigid displacement of the pinion. Default: that of ``[effects.misalignment]``, else none.

    Returns
    -------
    Dataset
        Over `roll_position`: `path_of_contact` (roll_position, axis) [mm] in the fixed frame, `transmission_error`
        [arcsec] of the gear, `contact_ellipse_angle` [deg] between the ellipse's long axis and the pinion's axis, and
        `principal_relative_curvature` (roll_position, direction) [1/mm]; `contact_ratio` [1]; for a face gear pair
        also `undercut_radius` and `pointing_radius` [mm] of the gear.

    Raises
    ------
    SceneError
        The flanks do not meet in this placement.

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
    *,
    meshes: float = 0.0,
) -> xr.DataTree:
    """Loaded contact over one mesh cycle, for one wear state, and its safeties where the scene names failure modes.

    Parameters
    ----------
    scene : Scene
    roll_positions : array_like, optional
        Roll positions, taken modulo 1; every tooth pair there is solved. Default: ``numerics.roll_positions`` even
        ones over a mesh cycle.
    wear_depth : array_like (body, profile, face) or (profile, face), optional
        Wear depth [um] on the grid of `/flank`, as `simulate` gives it for the same numerics; without bodies, that of
        the gear. A DataArray is taken by its labels: dimensions in any order, bodies by the coordinate `body`, slices
        by the coordinate `face`, where it has them. Default: unworn.
    placement : Placement, optional
        As of `tooth_contact_analysis`.
    meshes : float
        Number of load cycles of a gear tooth, all under this contact, for which pitting and bending are rated.
        Default 0: the static safety, as at the beginning of a run.

    Returns
    -------
    DataTree
        Groups `/engagement`, `/mesh_cycle`, `/diagnostics` and, of a whole mesh cycle (no `roll_positions`) with
        tables of failure modes, `/ratings`, with a `wear_step` of length one.

    Raises
    ------
    SceneError
        With all faults, before the teeth are computed: `wear_depth` is of another shape, negative, not finite, or of
        a pinion that does not wear, or the slices of its coordinate `face` are uneven or off the flank; `meshes` is
        negative or not finite; `roll_positions` are none or not finite. Later, where the flanks do not meet.
    ConvergenceError
        The loads cannot be solved; the message names the roll position and what to change.

    Examples
    --------
    >>> import semiwear as sw
    >>> coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8}
    >>> contact = sw.loaded_contact(sw.load_scene("spur_fzg_c").replace(coarse), [0.0])
    >>> print(f"{float(contact['engagement'].load_share.sum()):.6f}")
    1.000000
    """
    problems: list[Problem] = []
    if not 0.0 <= meshes < np.inf:
        fix = "leave it out for flanks that are new"
        problems.append(Problem("meshes", f"{meshes:g}", "a finite number >= 0", fix))
    physics = plan(scene)
    face = worn = given = None
    with Collected(problems):
        face = _slices_of(wear_depth, physics.flank_pair().face_limits)
    with Collected(problems):
        worn = _worn(scene, wear_depth)
    with Collected(problems):
        given = None if roll_positions is None else checked_roll_positions(roll_positions)
    if problems or worn is None:
        raise SceneError(problems, "loaded_contact")
    compile_ahead(kernels_of(scene, wears=False), scene.numerics.threads)
    with using_threads(scene.numerics.threads):
        teeth = physics.loaded_teeth(placement, given, face)
        state = teeth.load(worn.driven, None, worn.driving)
        pressure = teeth.pressures(state)
    observed, _ = collect.observed(teeth, state, pressure, physics.observers(teeth), physics.clock)
    groups = {
        "engagement": collect.engagement(teeth, state, pressure, fresh_sweep(teeth.pair, teeth.lines)) | observed,
        "mesh_cycle": collect.mesh_cycle(teeth, state),
        "diagnostics": collect.residuals(state),
    }
    stacks = {name: collect.stacked([group]) for name, group in groups.items()}
    stacks["engagement"] |= collect.slices(teeth)
    coords, attrs = collect.coordinates(teeth), attributes(physics, "loaded_contact")
    if given is None:
        known = pressure, groups["engagement"].get("root_stress")
        with using_threads(scene.numerics.threads):
            rated = physics.contact_ratings(teeth, state, meshes, hours_per_mesh(scene, teeth.pair), known)
        if rated is not None:
            coords |= {"mode": np.array(rated.modes), "meshes": np.array([meshes])}
            return build_tree(stacks | {"ratings": rated.arrays}, coords, attrs, {"ratings": rated.factors})
    return build_tree(stacks, coords, attrs)


def _slices_of(wear_depth: ArrayLike | xr.DataArray | None, limits: tuple[float, float]) -> FloatArray | None:
    """Face coordinates of a wear depth with labels [mm]; they must be evenly spaced, and on the flank."""
    if not isinstance(wear_depth, xr.DataArray) or "face" not in wear_depth.coords:
        return None
    face = np.atleast_1d(np.asarray(wear_depth["face"], float))
    width = np.diff(face)
    fix = "use the wear_depth of a result, or leave the coordinate out"
    if face.size < 2 or width.min() <= 0.0 or np.ptp(width) > 1e-6 * width.mean():
        raise SceneError.of("wear_depth.face", "uneven stations", "middles of equal slices, rising [mm]", fix)
    if face[0] < limits[0] or face[-1] > limits[1]:
        allowed = f"middles of slices on the gear's face, {limits[0]:g} to {limits[1]:g} mm"
        raise SceneError.of("wear_depth.face", f"{face[0]:g} to {face[-1]:g} mm", allowed, fix)
    return face


def _worn(scene: Scene, wear_depth: ArrayLike | xr.DataArray | None) -> Worn:
    """Wear of both flanks on their grids [mm], from a wear depth [um] in the result's layout."""
    slices, points = scene.numerics.face_slices, scene.numerics.profile_points
    if wear_depth is None:
        return Worn(np.zeros((slices, points)))
    if isinstance(wear_depth, xr.DataArray) and "face" in wear_depth.coords:
        slices = wear_depth.sizes.get("face", slices)
    depth, bodies = _by_body(wear_depth)
    problems: list[Problem] = []
    fits = depth.ndim == 3 and depth.shape[1:] == (points, slices) and 0 < depth.shape[0] <= len(BODIES)
    if not fits:
        found = f"an array of shape {np.shape(wear_depth)}"
        allowed = f"(profile, face) = {(points, slices)}, or with both bodies in front"
        fix = "use the wear_depth of a result with the same numerics, at one wear step: .isel(wear_step=-1)"
        problems.append(Problem("wear_depth", found, allowed, fix))
    if not np.all(np.isfinite(depth)) or np.any(depth < 0.0):
        problems.append(Problem("wear_depth", "negative or not finite", "finite numbers >= 0 [um]"))
    known = dict(zip(bodies, depth, strict=True)) if fits else {}
    driving_wears = scene.wear is not None and BODIES[DRIVING] in scene.wear.worn_bodies
    if not driving_wears and np.any(known.get(BODIES[DRIVING], 0.0) != 0.0):
        fix = 'name "pinion" in wear.worn_bodies'
        problems.append(Problem("wear_depth", "a worn pinion", "zero on a pinion that does not wear", fix))
    if problems:
        raise SceneError(problems)
    unworn = np.zeros((points, slices))
    driving, driven = (np.ascontiguousarray(1e-3 * known.get(body, unworn).T) for body in BODIES)
    return Worn(driven, driving if driving_wears else None)


def _by_body(wear_depth: ArrayLike | xr.DataArray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Depths (body, profile, face) and the names of the bodies, by labels if there are any."""
    labelled = isinstance(wear_depth, xr.DataArray) and {"profile", "face"} <= set(wear_depth.dims)
    if not labelled:
        depth = np.asarray(wear_depth, float)
        depth = depth[None] if depth.ndim == 2 else depth
        return depth, BODIES[-depth.shape[0] :] if depth.ndim == 3 else ()
    assert isinstance(wear_depth, xr.DataArray)
    names = tuple(str(name) for name in np.atleast_1d(wear_depth.coords.get("body", BODIES[DRIVEN])))
    if "body" in wear_depth.dims and "body" not in wear_depth.coords:
        names = BODIES[-wear_depth.sizes["body"] :]
    if not set(names) <= set(BODIES) or len(set(names)) < len(names):
        raise SceneError.of("wear_depth.body", ", ".join(names), f"each of {', '.join(BODIES)} at most once")
    depth = np.asarray(wear_depth.transpose(..., "profile", "face"), float)
    return depth if "body" in wear_depth.dims else depth[None], names
