"""Comparison of predicted with measured wear: `compare_wear`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from semiwear.arrays import FloatArray
from semiwear.errors import SceneError, SemiwearError
from semiwear.measured.fit import PartFit, datum_modes
from semiwear.measured.predicted import FlankReading
from semiwear.measured.quantities import labelled
from semiwear.measured.rigid import DATUM, require_motions
from semiwear.measured.worn import Measured, MeasuredWear, as_wear
from semiwear.meshing.driving_flank import driving_grid
from semiwear.meshing.flank_grid import FlankGrid, flank_grid
from semiwear.meshing.flank_pair import BODIES, DRIVEN
from semiwear.plan import plan
from semiwear.results.missing import group_of
from semiwear.scene import Scene, parse_scene

_UM = 1e3
_SAME_HEIGHT = 1e-3  # mm


def compare_wear(
    tree: xr.DataTree,
    measured: Measured,
    *,
    before: Measured | None = None,
    body: str = "gear",
    wear_step: int = -1,
    datum: Sequence[str] = DATUM,
) -> xr.Dataset:
    """Predicted and measured wear at the measured points.

    Parameters
    ----------
    tree : DataTree
        A result of `simulate`.
    measured, before : measurement
        As for `measured_wear`.
    body : str
    wear_step : int
        Index of the wear step; default the last.
    datum : sequence of str
        Motions of the measured tooth, as in `calibrate`, that are fitted to the difference and subtracted from it,
        since the position of a tooth is no wear. () for none.

    Returns
    -------
    Dataset
        `predicted`, `wear_depth` (measured, less the datum's part) and `difference`, predicted minus measured [um]
        over (profile, face); `difference_max`, the greatest one with its sign, and `difference_rms` [um];
        `correlation`; `scale`, measured over predicted wear by least squares (fitted together with the datum): above
        1 the part wore more.

    Raises
    ------
    SemiwearError
        If the result has no worn flank, or one on another grid than that of its scene.
    SceneError
        As `measured_wear`.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import semiwear as sw
    >>> coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.wear_steps": 1}
    >>> scene, path = sw.load_scene("spur_fzg_c").replace(coarse), pathlib.Path(tempfile.mkdtemp(), "worn.nc")
    >>> tree = sw.simulate(scene)
    >>> sw.export_flank(scene, "gear", path, points=(21, 9), worn=tree)
    >>> print(f"{float(sw.compare_wear(tree, path).scale):.1f}")
    1.0
    """
    motions = require_motions(datum, "datum")
    flank = group_of(tree, "flank")
    if "wear_depth" not in flank:
        raise SemiwearError("compare_wear needs /flank/wear_depth, which this result does not have")
    scene = parse_scene(str(tree.attrs.get("scene_toml", "")), name="scene of the result")
    worn = as_wear(scene, measured, before, body, datum="best_fit" if motions else "as_measured")
    grid = _grid_of(scene, flank, body)
    steps = flank.sizes["wear_step"]
    if not -steps <= wear_step < steps:
        raise SceneError.of("wear_step", wear_step, f"an index of {steps} wear steps")
    depth = flank["wear_depth"].isel(wear_step=wear_step).sel(body=body).transpose("face", "profile").values / _UM
    inside = worn.inside
    predicted = FlankReading.of(grid, worn.face[inside], worn.profile[inside], worn.flank).read(depth)
    names, modes = datum_modes(worn, motions)
    attrs = {"body": body, "meshes": f"{float(flank['meshes'][wear_step]):.6g}", "datum": ", ".join(names)}
    return _compared(worn, predicted, modes[inside], attrs)


def comparison_of_fit(worn: MeasuredWear, part: PartFit, attrs: dict[str, str]) -> xr.Dataset:
    """The same for a calibrated part, at its own wear coefficient."""
    _, modes = datum_modes(worn, tuple(part.datum))
    return _compared(worn, part.predicted[worn.inside], modes[worn.inside], attrs)


def grid_of(scene: Scene, face: FloatArray, points: int, body: str) -> FlankGrid:
    """Nodes of a body's wear in a result: a number of points along the profile at each face coordinate [mm]."""
    pair = plan(scene).flank_pair()
    make = flank_grid if BODIES.index(body) == DRIVEN else driving_grid
    return make(pair, np.asarray(face, float), points)


def _grid_of(scene: Scene, flank: xr.Dataset, body: str) -> FlankGrid:
    """Nodes of a result's wear, rebuilt from its scene and checked against its heights."""
    grid = grid_of(scene, flank["face"].values, flank.sizes["profile"], body)
    height, _ = plan(scene).flank_pair().flank_place(BODIES.index(body), grid.face[:, None], grid.profile)
    stored = flank["flank_height"].sel(body=body).transpose("face", "profile").values
    if not np.allclose(height, stored, atol=_SAME_HEIGHT, rtol=0.0):
        raise SemiwearError(
            f"/flank/flank_height of the {body} is not that of the result's own scene: does this body wear in it?"
        )
    return grid


def _compared(worn: MeasuredWear, predicted: FloatArray, modes: FloatArray, attrs: dict[str, str]) -> xr.Dataset:
    inside = worn.inside
    wear = worn.depth[inside]
    amounts = np.linalg.lstsq(modes, wear - predicted, rcond=None)[0]
    aligned = wear - modes @ amounts
    columns = np.column_stack([predicted, modes])
    scale = float(np.linalg.lstsq(columns, wear, rcond=None)[0][0])
    deviations = float(np.std(predicted) * np.std(aligned))
    covariance = float(np.mean((predicted - predicted.mean()) * (aligned - aligned.mean())))
    difference = predicted - aligned
    values: dict[str, object] = {
        "predicted": worn.on_grid(_UM * predicted),
        "wear_depth": worn.on_grid(_UM * aligned),
        "difference": worn.on_grid(_UM * difference),
        **worn.where(),
        "difference_max": _UM * float(difference[np.argmax(np.abs(difference))]),
        "difference_rms": _UM * float(np.sqrt(np.mean(difference**2))),
        "correlation": covariance / deviations if deviations > 0.0 else 0.0,
        "scale": scale,
    }
    return labelled(values, attrs, "predicted and measured wear")
