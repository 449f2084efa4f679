"""Pictures that compare two results on the same flank grid, such as those of both fidelities."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.meshing.flank_pair import BODIES
from semiwear.plot.curve_names import name_curves, name_place
from semiwear.plot.flank import along_tooth, chosen_body, flank_axes, mark_pitch_band
from semiwear.plot.flank_regions import flank_regions
from semiwear.plot.style import (
    ROLL_LABEL,
    axes_for,
    colour_bar,
    label,
    need,
    pressure_scale,
    step_name,
    styled,
)
from semiwear.plot.two_results import TwoResults
from semiwear.untyped import Options

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LEAST_SCALE = 1e-3  # least end of the colour scale [um]: equal flanks are white


@styled()
def wear_difference(
    tree: xr.DataTree, against: xr.DataTree, ax: Axes | None = None, *, body: str | None = None
) -> Axes:
    """Difference of a body's wear along the tooth and over its height, at the last wear step that both results have.

    Parameters
    ----------
    tree, against : DataTree
        Results with `/flank` on the same grid; the picture shows `tree` minus `against`.
    ax : Axes, optional
        Where to draw; a new figure unless given.
    body : str, optional
        ``"pinion"`` or ``"gear"``. Default: the gear, unless the pinion alone wears.

    Returns
    -------
    Axes

    Raises
    ------
    SemiwearError
        If the results have no worn flank in common, or different grids.
    """
    results = TwoResults.of(tree, against)
    if not results.worn:
        raise SemiwearError("the two results have no worn flank in common")
    first, second = results.values("flank", "wear_depth", results.steps[-1])
    body = chosen_body(tree, body)
    difference = first[BODIES.index(body)] - second[BODIES.index(body)]
    scale = max(float(np.abs(difference).max()), _LEAST_SCALE)
    (ax,) = axes_for(ax)
    wear = need(tree, "flank", "wear_depth")
    mesh = flank_axes(ax, tree, difference, "RdBu_r", -scale, scale, body)
    mark_pitch_band(ax, tree, "#333333", body=body)
    if body == "gear":
        _mark_strips(ax, results, tree)
    ax.set_title(f"{results.names[0]} minus {results.names[1]}, {step_name(wear, results.steps[-1][0])}")
    colour_bar(ax, mesh, label(wear, "Difference in wear depth"))
    return ax


@styled()
def pressure_of_both(tree: xr.DataTree, against: xr.DataTree, ax: Axes | None = None) -> Axes:
    """Greatest pressure over the engagement of two results, at the first and last wear step that both have.

    Thick lines: away from borders; thin lines: at the borders, where it depends on the mesh. Parameters and return
    value as in `wear_difference`.
    """
    results = TwoResults.of(tree, against)
    (ax,) = axes_for(ax)
    chosen = sorted({results.steps[0], results.steps[-1]})
    colours = dict(zip(chosen, ("#0072B2", "#D55E00"), strict=False))
    positions = results.labels("engagement", "roll_position")
    highest = {"contact_pressure_max": 0.0, "contact_pressure_max_edge": 0.0}
    for step, colour in colours.items():
        step_names = [
            step_name(need(result, "engagement", "contact_pressure_max"), index)
            for result, index in zip(results.trees, step, strict=True)
        ]
        for variable in highest:
            if not results.have("engagement", variable):
                continue
            edge = variable.endswith("edge")
            curves = results.values("engagement", variable, step)
            for k, (curve, roll, dashes) in enumerate(zip(curves, positions, ("-", "--"), strict=True)):
                text = None if edge else f"{results.names[k]}, {step_names[k]}"
                shown = np.where(curve > 0.0, curve, np.nan)
                width = 0.8 if edge else 1.8
                ax.plot(roll, shown, color=colour, ls=dashes, lw=width, label=text)
                highest[variable] = float(np.fmax.reduce(curve, initial=highest[variable]))
    pressure_scale(ax, highest["contact_pressure_max"], highest["contact_pressure_max_edge"])
    pressure = need(tree, "engagement", "contact_pressure_max")
    ax.set(xlabel=ROLL_LABEL, ylabel=label(pressure, "Greatest contact pressure"))
    name_curves(ax)
    return ax


def _mark_strips(ax: Axes, results: TwoResults, tree: xr.DataTree) -> None:
    """Draw the limits of the strips along the borders."""
    regions = flank_regions(results)
    if regions is None:
        return
    gear, _ = along_tooth(tree)
    along = gear.values.mean(axis=0)
    ends = np.interp((regions.first, regions.last), gear["face"].values, along)
    style: Options = {"color": "#117733", "lw": 0.9, "ls": ":"}
    ax.plot(along, regions.lower, **style)
    last = int(np.argmax(along))
    width = f"{regions.width:.2g} mm from the borders"
    name_place(ax, float(along[last]), float(regions.lower[last]), width, colour="#117733", above=True)
    ax.plot(along, regions.upper, **style)
    for end in ends:
        ax.axvline(end, **style)
