"""Section of a report on the life and on the results of effects; absent without them."""

from __future__ import annotations

from collections.abc import Iterator

import xarray as xr

from semiwear.plot.history import draw_over_meshes
from semiwear.report.markup import card, element, figure_text, tiles, with_unit
from semiwear.report.numbers import life_numbers
from semiwear.report.pictures import figure_uri
from semiwear.results.missing import group_of

_TITLES = {
    "mesh_efficiency": "Efficiency of the mesh",
    "friction_power_loss_mean": "Friction loss",
    "contact_temperature_max": "Contact temperature",
    "lambda_ratio_min": "Film over roughness",
}
"""Histories that a result holds only if an effect is in its scene."""

_SIZE = (4.4, 2.8)


def effects_section(tree: xr.DataTree) -> str:
    """Tiles of the life and of the effects' histories, with charts over the wear steps; empty without them."""
    histories = list(_histories(tree))
    numbers = tiles([*_life(tree), *(_tile(title, series) for title, series in histories)])
    charts = "".join(_chart(title, series) for title, series in histories if series.size > 1)
    cards = element("div", charts, class_="cards small") if charts else ""
    return numbers + cards


def _histories(tree: xr.DataTree) -> Iterator[tuple[str, xr.DataArray]]:
    history = group_of(tree, "history")
    yield from ((title, history[name]) for name, title in _TITLES.items() if name in history)


def _life(tree: xr.DataTree) -> Iterator[tuple[str, str, str]]:
    life = group_of(tree, "life")
    if not life:
        return
    yield from life_numbers(tree)
    for name, quantity in (("wear_coefficient", "wear coefficient"), ("torque", "torque")):
        change = figure_text(float(life[f"sensitivity_to_{name}"]), 3)
        yield f"Life against {quantity}", f"{change} %", f"for 1 % more {quantity}"


def _tile(title: str, series: xr.DataArray) -> tuple[str, str, str]:
    first, last = (_value(series, step) for step in (0, -1))
    return title, last, f"{first} unworn" if series.size > 1 else "unworn"


def _value(series: xr.DataArray, step: int) -> str:
    return with_unit(float(series[step]), series.attrs["units"])


def _chart(title: str, series: xr.DataArray) -> str:
    uri = figure_uri(_SIZE, 1, lambda axes: draw_over_meshes(axes[0], series, title))
    alt = f"{title} over the wear steps: {_value(series, 0)} at first, {_value(series, -1)} at last."
    long_name = str(series.attrs["long_name"])
    caption = f"{long_name[:1].upper()}{long_name[1:]}."
    return card(title, uri, alt, caption, _SIZE)
