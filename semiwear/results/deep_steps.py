"""Warning about wear steps that remove too much at once, from a result."""

from __future__ import annotations

import numpy as np
import xarray as xr

from semiwear.results.missing import group_of
from semiwear.results.wearing import scene_tables
from semiwear.wear.step_count import DEEP, PLAIN_STEPS


def deep_steps(tree: xr.DataTree) -> list[str]:
    """A sentence if wear steps are several times deeper than usual, as errors grow with their depth; else none.

    Parameters
    ----------
    tree : DataTree
        With `/history` of every wear step, and `/diagnostics` with the usual depth of a step.
    """
    history, diagnostics = group_of(tree, "history"), group_of(tree, "diagnostics")
    if "wear_depth_max" not in history or "usual_step_depth" not in diagnostics:
        return []
    scene, usual = scene_tables(tree), float(diagnostics["usual_step_depth"])
    scheme = scene.get("numerics", {}).get("wear_scheme")
    to_depths = "control_depths_um" in scene.get("wear", {}).get("until", {})
    if to_depths and scheme != "explicit":  # deep ones are divided
        return []
    most = (DEEP * PLAIN_STEPS if scheme == "two-stage" else DEEP) * usual
    worn = history["wear_depth_max"].diff("wear_step").transpose("wear_step", "body").values
    deep = int((worn.max(axis=1, initial=0.0) > most).sum())
    if not deep:
        return []
    _, body = np.unravel_index(int(worn.argmax()), worn.shape)
    name = history["body"].values[body]
    more = "wear.until.control_depths_um" if to_depths else "numerics.wear_steps"
    return [
        f"{deep} of {len(worn)} wear steps take up to {worn.max():.2g} um off the {name}, where {usual:.2g} um a "
        f"step are usual: depths and pressures may be off by several per cent. Give more {more}."
    ]
