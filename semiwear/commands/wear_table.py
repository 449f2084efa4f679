"""The result of a run as text: one row per wear step, and its life in one sentence."""

from __future__ import annotations

from math import isinf

import numpy as np
import xarray as xr

from semiwear.results.life_axis import hours_of
from semiwear.results.missing import missing_notes
from semiwear.results.wearing import control_place, life_bodies, shown_bodies

_COLUMNS = (
    ("meshes", "meshes", "{:.3e}"),
    ("control {} [um]", "wear_depth_control_point", "{:.1f}"),
    ("load share", "load_share_max", "{:.3f}"),
    ("p root [MPa]", "contact_pressure_root", "{:.0f}"),
    ("p pitch [MPa]", "contact_pressure_pitch", "{:.0f}"),
    ("root stress p/g [MPa]", "root_stress_max", "{:.1f}"),
    ("TE mean [arcsec]", "transmission_error_mean", "{:.2f}"),
    ("TE ampl. [arcsec]", "transmission_error_amplitude", "{:.2f}"),
)


def wear_table(tree: xr.DataTree) -> str:
    """Table of a result as text, one row per wear step."""
    history = tree["history"].to_dataset()
    columns = [(heading, form, history[name].values) for heading, name, form in _COLUMNS if name in history.variables]
    columns[2 if "wear_depth_control_point" in history else 1 : 0] = _wear_columns(tree, history)
    if (hours := hours_of(tree)) is not None:
        columns.insert(1, ("hours", "{:.4g}", hours))
    point = control_place(tree)
    rows = [[heading.format(point.body if point else "point") for heading, *_ in columns]]
    for step in range(history.sizes["wear_step"]):
        row = []
        for _, form, values in columns:
            each = np.atleast_1d(values[step])
            row.append("/".join("-" if np.isnan(value) else form.format(value) for value in each))
        rows.append(row)
    wide = [max(len(row[k]) for row in rows) for k in range(len(columns))]
    lines = ["  ".join(text.rjust(width) for text, width in zip(row, wide, strict=True)) for row in rows]
    missing = missing_notes(history)
    lines += [f"- {heading}: {missing[name]}" for heading, name, _ in _COLUMNS if name in missing]
    return "\n".join(lines)


def _wear_columns(tree: xr.DataTree, history: xr.Dataset) -> list[tuple[str, str, np.ndarray]]:
    """Columns of the greatest wear depth of every body that wears: whole flank, root zone and addendum zone."""
    bodies = shown_bodies(tree)
    of = "{} p/g [um]" if len(bodies) > 1 else f"{bodies[0]} {{}} [um]"
    stems = ["wear_depth_max_pinion" if body == "pinion" else "wear_depth_max" for body in bodies]
    whole = tree["flank"].to_dataset()["wear_depth"].max(("profile", "face")).sel(body=list(bodies)).values
    columns = [(of.format("wear"), "{:.1f}", whole)]
    for zone in ("root", "addendum"):
        if all(f"{stem}_{zone}" in history for stem in stems):
            values = np.stack([history[f"{stem}_{zone}"].values for stem in stems], axis=-1)
            columns.append((of.format(zone), "{:.1f}", values))
    return columns


def life_sentence(tree: xr.DataTree) -> str:
    """The life in one sentence."""
    life = tree["life"].to_dataset()
    body, deeper = life_bodies(tree)
    of = f" on the {body}" if body else ""
    warning = f'; the {deeper} wears deeper: limit it by effects.run_life.body = "{deeper}"' if deeper else ""
    if isinf(life["meshes_to_limit"]):
        ended_by = str(life["ended_by"].values).replace("_", " ")
        return (
            f"life until {float(life['depth_limit']):g} um{of}: without end, the flank wears no further before "
            f"that depth; {ended_by} ends it after {float(life['meshes_to_end']):.4g} meshes{warning}"
        )
    hours = f" ({float(life['hours_to_limit']):.4g} h)" if "hours_to_limit" in life else ""
    return (
        f"life until {float(life['depth_limit']):g} um{of}: {float(life['meshes_to_limit']):.4g} meshes{hours}; "
        f"it changes by {float(life['sensitivity_to_wear_coefficient']):.3g} % for each per cent of the "
        f"wear coefficient, {float(life['sensitivity_to_torque']):.3g} % for each per cent of torque{warning}"
    )
