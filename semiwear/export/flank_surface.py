"""Worn flanks as surfaces, and flank values of a single zone."""

from __future__ import annotations

import numpy as np
import xarray as xr

from semiwear.errors import Problem, SceneError
from semiwear.export.nodes import chosen_step, flank_nodes
from semiwear.export.surface import Surface, grid_of_quads
from semiwear.meshing.flank_pair import BODIES, DRIVEN
from semiwear.plain_text import one_of
from semiwear.results import VARIABLES
from semiwear.results.missing import group_of

_FIELDS = ("flank_height", "flank_radius", "zone", "active", "specific_sliding")


def worn_flank(tree: xr.DataTree, body: str = "gear", wear_step: int = -1, *, exaggeration: float = 1.0) -> Surface:
    """The worn flank of one tooth as a surface, with the wear of every step as fields.

    Parameters
    ----------
    tree : DataTree
        A result of `simulate`.
    body : str
        ``"pinion"`` or ``"gear"``.
    wear_step : int
        Wear step of the shape. Default: the last.
    exaggeration : float
        Factor on the wear in the shape (1: to scale), but not in the fields.

    Returns
    -------
    Surface
        The nodes of the result, from the root to the tip and from the middle of the first slice to that of the last,
        in the body's own frame (z is its axis). Fields: `wear_depth` of this step, `wear_depth_step_k` of all [um],
        `flank_height` and `flank_radius` [mm], `zone`, `active`, `specific_sliding`; `contact_pattern` [MPa] of the
        gear if the result has it.

    Raises
    ------
    SceneError
        For an unknown body or wear step, or a result without wear depths.
    """
    nodes = flank_nodes(tree, body)
    step = chosen_step(len(nodes.depth), wear_step)
    points, normals = nodes.flank.points(nodes.face[:, None], nodes.profile)
    worn = points - exaggeration * nodes.depth[step][..., None] * normals
    quads = grid_of_quads(*nodes.profile.shape)
    corners = worn.reshape(-1, 3)[quads]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0])
    if np.sum(across * normals.reshape(-1, 3)[quads[:, 0]]) < 0.0:
        quads = quads[:, ::-1]
    data = group_of(tree, "flank")
    fields = step_fields(1e3 * nodes.depth.reshape(len(nodes.depth), -1), step)
    index = BODIES.index(body)
    for name in _FIELDS:
        fields[name] = data[name].isel(body=index).transpose("face", "profile").values.ravel().astype(float)
    if body == "gear" and "contact_pattern" in data:
        fields["contact_pattern"] = data["contact_pattern"].isel(wear_step=step).transpose("face", "profile").values
        fields["contact_pattern"] = fields["contact_pattern"].ravel()
    units = {name: VARIABLES["flank", "wear_depth" if name.startswith("wear") else name].units for name in fields}
    return Surface(worn.reshape(-1, 3), quads, fields, units)


def step_fields(depth: np.ndarray, step: int) -> dict[str, np.ndarray]:
    """Wear depth (steps, nodes) as fields: of the chosen step, and of every step."""
    return {"wear_depth": depth[step]} | {f"wear_depth_step_{k}": values for k, values in enumerate(depth)}


def in_zone(tree: xr.DataTree, zone: str, body: str = "gear") -> xr.Dataset:
    """Flank values of a body in one of its zones; NaN elsewhere.

    Parameters
    ----------
    tree : DataTree
        A result of `simulate`.
    zone : str
        ``"root"``, ``"pitch"`` or ``"addendum"``.
    body : str
        ``"pinion"`` or ``"gear"`` (default).

    Returns
    -------
    Dataset
        Variables of the body in `/flank` over (wear_step, profile, face): ``in_zone(tree, "root").wear_depth.max()``.
        `contact_pattern` is of the gear's flank only.

    Raises
    ------
    SceneError
        For an unknown zone or body.
    """
    zones = VARIABLES["flank", "zone"].flags
    data = group_of(tree, "flank")
    problems = [
        Problem(name, value, one_of(allowed))
        for name, value, allowed in (("body", body, BODIES), ("zone", zone, zones))
        if value not in allowed
    ]
    if problems:
        raise SceneError(problems, "in_zone")
    of_body = data.sel(body=body)
    if body != BODIES[DRIVEN]:
        of_body = of_body.drop_vars("contact_pattern", errors="ignore")
    return of_body.where(of_body["zone"] == zones.index(zone))
