r"""Mesh stiffness and transmission error of worn teeth over a mesh cycle, for models of shafts and gear trains.

Two stiffnesses, both along the line of action, of all tooth pairs together:

    mean    F / delta: load over the approach under this load; with the unloaded transmission error e as displacement
            excitation, F = k (e - x) gives the loaded transmission error x at the torque of the scene. Both errors
            are positive if the gear leads; load makes it lag.
    local   dF / ddelta at the torque of the scene, for small vibrations about this load, by a central difference of
            1 % of the torque. The contact of worn or relieved flanks grows with load, so that the local stiffness
            is the greater of the two.

Sources: ISO 6336-1:2019, 9 (mesh stiffness); Kahraman and Singh, J. Sound Vib. 142 (1990) 49-75 (k and e as
parametric and displacement excitation); Umezawa, Suzuki and Sato, Bull. JSME 29 (1986) 1605-1611 (k over a cycle).
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from semiwear.arrays import FloatArray
from semiwear.errors import SceneError
from semiwear.export.nodes import chosen_step, scene_of
from semiwear.export.worn_contact import WornContact
from semiwear.meshing.flank_pair import reference_lever
from semiwear.plan import plan
from semiwear.results.missing import group_of

_STEP = 0.01  # of the torque
_ABOUT = {
    "mesh_stiffness": ("N/mm", "load over the approach along the line of action that it causes"),
    "mesh_stiffness_local": ("N/mm", "change of the load with the approach, at the scene's torque"),
    "torsional_mesh_stiffness": ("N m/rad", "pinion torque over the pinion's rotation, the gear held"),
    "torsional_mesh_stiffness_local": ("N m/rad", "change of the pinion torque with its rotation, the gear held"),
    "transmission_error_unloaded": ("um", "unloaded transmission error along the line of action, + gear leads"),
    "transmission_error_loaded": ("um", "loaded transmission error along the line of action, + gear leads"),
    "pinion_angle": ("deg", "rotation of the pinion from mesh position 0, growing with time"),
}


def mesh_stiffness(tree: xr.DataTree, *, local: bool = True) -> xr.Dataset:
    """Mesh stiffness and transmission error over mesh position and wear step.

    `mesh_stiffness` is the normal force over the approach that it causes, the unloaded less the loaded transmission
    error along the line of action; ``_local``, the derivative of the force by the approach at the scene's torque, is
    for small vibrations about it. Both are along the normal: c_gamma of ISO 6336-1, in the transverse plane, is
    `mesh_stiffness` times the square of the cosine of the base helix angle, over the face width.

    Parameters
    ----------
    tree : DataTree
        A result of `simulate`; without `local` also one of `loaded_contact`, finite elements included.
    local : bool
        Whether to add the local stiffness, which needs two more solutions of every wear step. Default: yes.

    Returns
    -------
    Dataset
        Over (wear_step, mesh_position): `mesh_stiffness` [N/mm] and `torsional_mesh_stiffness` [N m/rad] about the
        pinion's axis, both also ``_local``; `transmission_error_unloaded` and `_loaded` [um]; coordinates
        `pinion_angle` [deg] and `meshes`. Attributes: `lever_arm_mm`, with which approach = angle x lever arm (the
        base radius of a spur pinion), `pinion_torque_Nm`, `normal_force_N`, `pinion_teeth`, `gear_teeth`.

    Raises
    ------
    SceneError
        For a result without transmission error, or without the wear depths that a local stiffness needs.

    References
    ----------
    ISO 6336-1:2019; Kahraman and Singh, J. Sound Vib. 142 (1990) 49-75.
    """
    cycle = group_of(tree, "mesh_cycle")
    if "transmission_error_loaded" not in cycle:
        raise SceneError.of("tree", "a tree without /mesh_cycle", "a result of simulate", "simulate the scene")
    scene = scene_of(tree)
    pair = plan(scene).flank_pair()
    lever, torque = reference_lever(pair), scene.operation.pinion_torque_Nm
    loaded, unloaded = (
        cycle[f"transmission_error_{state}"].transpose("wear_step", "mesh_position").values / pair.arcsec_per_mm
        for state in ("loaded", "unloaded")
    )
    force = 1e3 * torque / lever
    stiffness = {"mesh_stiffness": force / (unloaded - loaded)}
    if local:
        stiffness["mesh_stiffness_local"] = _local(tree, cycle["mesh_position"].values) / lever**2
    values = stiffness | {f"torsional_{name}": 1e-3 * lever**2 * value for name, value in stiffness.items()}
    values |= {"transmission_error_unloaded": 1e3 * unloaded, "transmission_error_loaded": 1e3 * loaded}
    teeth = [abs(getattr(scene.gear_pair, f"{body}_teeth")) for body in ("pinion", "gear")]
    position = cycle["mesh_position"]
    coords = {name: cycle[name] for name in ("wear_step", "mesh_position", "meshes") if name in cycle.coords}
    found = xr.Dataset(
        {name: (("wear_step", "mesh_position"), value, _attrs(name)) for name, value in values.items()},
        coords | {"pinion_angle": ("mesh_position", 360.0 / teeth[0] * position.values, _attrs("pinion_angle"))},
    )
    return found.assign_attrs(
        title="mesh stiffness",
        references="ISO 6336-1:2019; Kahraman and Singh 1990, J. Sound Vib. 142, 49-75",
        lever_arm_mm=lever, pinion_torque_Nm=torque, normal_force_N=force, pinion_teeth=teeth[0], gear_teeth=teeth[1],
    )  # fmt: skip


def stiffness_over_angle(
    found: xr.Dataset, wear_step: int = -1, *, of: str = "mesh_stiffness"
) -> Callable[[ArrayLike], FloatArray]:
    """Stiffness k(theta) of a worn pair: periodic in the pinion's rotation [rad], linear between mesh positions.

    Parameters
    ----------
    found : Dataset
        Result of `mesh_stiffness`, or one wear step of it.
    wear_step : int
        Default: the last.
    of : str
        Another of its variables, such as ``"torsional_mesh_stiffness"`` or ``"transmission_error_unloaded"``.

    Returns
    -------
    callable
        From rotations of the pinion [rad], 0 at mesh position 0, to an array of values in the variable's unit.

    Raises
    ------
    SceneError
        For a wear step or a variable that the dataset does not have.
    """
    if of not in found:
        raise SceneError.of("of", of, ", ".join(map(str, found.data_vars)), "mesh_stiffness(tree, local=True)")
    array = found[of].expand_dims("wear_step") if "wear_step" not in found.dims else found[of]
    step = chosen_step(array.sizes["wear_step"], wear_step)
    angle = np.radians(found["pinion_angle"].values)
    period = 2.0 * pi / int(found.attrs["pinion_teeth"])
    values = array.isel(wear_step=step).values

    def over_angle(theta: ArrayLike) -> FloatArray:
        return np.asarray(np.interp(np.asarray(theta, float), angle, values, period=period))

    return over_angle


def _attrs(name: str) -> dict[str, str]:
    units, text = _ABOUT[name]
    return {"units": units, "long_name": text}


def _local(tree: xr.DataTree, mesh_positions: FloatArray) -> FloatArray:
    """Derivative of torque by pinion rotation at the scene's torque, (wear_step, mesh_position) [N mm/rad]."""
    contact = WornContact.of(tree, mesh_positions)
    order = np.argsort(contact.teeth.rolls.mesh_position)
    rows = []
    for step in range(len(contact.depth)):
        less, more = (contact.load(step, 1.0 + sign * _STEP).loads.rotation for sign in (-1.0, 1.0))
        rows.append(2.0 * _STEP * contact.teeth.problem.torque / (more - less))
    return np.stack(rows)[:, order]
