"""Numbers of a report: the main ones with their meaning, and further ones."""

from __future__ import annotations

from collections.abc import Iterator
from math import isinf

import numpy as np
import xarray as xr

from semiwear.report.markup import element, figure_text, tiles, with_unit
from semiwear.results.deep_steps import deep_steps
from semiwear.results.life_axis import hours_of
from semiwear.results.missing import away_from_edges, group_of
from semiwear.results.pressing_tips import pressing_tips
from semiwear.results.wearing import control_place, life_bodies, pitch_surface, scene_tables, shown_bodies
from semiwear.scene.values import is_number

Number = tuple[str, str, str]


def main_numbers(tree: xr.DataTree) -> str:
    """Tiles of wear, life, pressure and transmission error, each with its meaning."""
    numbers = [*_wear(tree), *(life_numbers(tree) or _run(tree)), *_pressure(tree), *_excitation(tree)]
    return element("div", tiles(numbers), class_="main-numbers") if numbers else ""


def other_numbers(tree: xr.DataTree) -> str:
    """Tiles of contact ratio, load share, stresses and the control point at the last wear step."""
    return tiles([*_contact_ratio(tree), *_histories(tree), *_stresses(tree)])


def advice(tree: xr.DataTree) -> str:
    """Sentences on wear steps that are too deep, and on tip edges in contact with the relief that clears them."""
    return _advice_on("wear steps", deep_steps(tree)) + _advice_on("tip edges in contact", pressing_tips(tree))


def _advice_on(subject: str, texts: list[str]) -> str:
    sentences = "".join(element("li", text.replace(" um ", " µm ")) for text in texts)
    return f"<h3>Advice: {subject}</h3><ul>{sentences}</ul>" if sentences else ""


def _wear(tree: xr.DataTree) -> Iterator[Number]:
    if "flank" not in tree.children:
        return
    flank = tree["flank"].to_dataset().isel(wear_step=-1)
    for body in shown_bodies(tree):
        own = flank.sel(body=body)
        values = own["wear_depth"].values
        if not values.any():
            yield f"Greatest wear, {body}", "0 µm", "at the last wear step"
            continue
        place = np.unravel_index(int(values.argmax()), values.shape)
        height = float(own["flank_height"].values[place])
        where = f"{abs(height):.2f} mm {'above' if height >= 0.0 else 'below'} the {pitch_surface(tree, body)}"
        yield f"Greatest wear, {body}", f"{values.max():.3g} µm", where + _of_module(tree, 1e-3 * float(values.max()))


def _of_module(tree: xr.DataTree, depth: float) -> str:
    """A depth [mm] as percentage of the module, if the scene states the module."""
    pair = scene_tables(tree).get("gear_pair", {})
    module = pair.get("module_mm", pair.get("normal_module_mm"))
    if not is_number(module) or module <= 0:
        return ""
    return f"; {figure_text(100.0 * depth / module, 2)} % of the module"


def life_numbers(tree: xr.DataTree) -> list[Number]:
    """Life until a wear depth, and the failure mode that ends it earlier; empty without `[effects.run_life]`."""
    found = group_of(tree, "life")
    if "meshes_to_limit" not in found:
        return []
    life = {str(name): float(value) for name, value in found.data_vars.items() if value.dtype.kind == "f"}
    endless = isinf(life["meshes_to_limit"])
    meshes = "without end" if endless else f"{figure_text(life['meshes_to_limit'])} meshes"
    meaning = "of a gear tooth; the scene gives no speed, so no hours"
    if endless:
        meaning = "the flank wears no further before"
    elif "hours_to_limit" in life:
        meaning = f"{meshes} of a gear tooth"
        meshes = f"{figure_text(life['hours_to_limit'])} h"
    ended_by = str(found["ended_by"].values) if "ended_by" in found else "wear"
    if ended_by != "wear" and "meshes_to_end" in life:
        meaning += (
            f"; {ended_by.replace('_', ' ')} ends it earlier, after {figure_text(life['meshes_to_end'])} meshes"
        )
    body, deeper = life_bodies(tree)
    if deeper:
        meaning += f"; the {deeper} wears deeper, but no limit is set for it"
    return [(f"Life until {life['depth_limit']:g} µm of wear{body and f', {body}'}", meshes, meaning)]


def _run(tree: xr.DataTree) -> Iterator[Number]:
    """Length of the run, and change of the wear rate."""
    history = group_of(tree, "history")
    if "meshes" not in history.coords or "flank" not in tree.children:
        return
    meshes = np.asarray(history["meshes"].values, float)
    hours = hours_of(tree)
    note = f"in {meshes.size - 1} wear steps"
    if hours is not None:
        note = f"{figure_text(float(hours[-1]), 3)} h, {note}"
    depth = group_of(tree, "flank")["wear_depth"].max(("body", "profile", "face")).values
    if meshes.size > 2 and depth[1] > 0.0:
        first, last = depth[1] / meshes[1], (depth[-1] - depth[-2]) / (meshes[-1] - meshes[-2])
        change = 100.0 * (last / first - 1.0)
        note += f"; the deepest place wears {abs(change):.0f} % {'faster' if change > 0 else 'slower'} than at first"
    yield "Meshes of a gear tooth", figure_text(meshes[-1], 4), note


def _pressure(tree: xr.DataTree) -> Iterator[Number]:
    engagement = group_of(tree, "engagement")
    if "contact_pressure_max" not in engagement:
        return
    greatest = np.fmax.reduce(away_from_edges(engagement).values, axis=1)
    if np.isnan(greatest[[0, -1]]).any():  # only edges carry load
        return
    yield (
        "Greatest contact pressure",
        with_unit(float(greatest[-1]), "MPa"),
        _change(greatest, "MPa", "away from edges"),
    )


def _change(values: np.ndarray, units: str, where: str = "") -> str:
    """Text with the unworn value and the change since."""
    first, last = float(values[0]), float(values[-1])
    prefix = f"{where}; " if where else ""
    if values.size < 2:
        return f"{prefix}unworn"
    return f"{prefix}{with_unit(first, units)} unworn{_change_text(last / first) if first > 0.0 else ''}"


def _change_text(ratio: float) -> str:
    """Text on the change of a value, from its ratio to the unworn one."""
    if ratio > 2.0:
        return f", {figure_text(ratio, 2)} times as much now"
    return f", {100.0 * abs(ratio - 1.0):.0f} % {'more' if ratio > 1.0 else 'less'} now"


def _excitation(tree: xr.DataTree) -> Iterator[Number]:
    history = group_of(tree, "history")
    if "transmission_error_amplitude" in history:
        series = history["transmission_error_amplitude"]
        units = str(series.attrs["units"])
        note = _change(series.values, units, "excites vibration")
        if "peak_positions" not in scene_tables(tree).get("numerics", {}):
            note += "; of the roll positions alone, numerics.peak_positions finds peaks between them"
        yield "Transmission error, amplitude", with_unit(float(series[-1]), units), note


def _contact_ratio(tree: xr.DataTree) -> Iterator[Number]:
    cycle = group_of(tree, "mesh_cycle")
    if "pairs_in_contact" in cycle:
        pairs = cycle["pairs_in_contact"].mean("mesh_position").values
        note = "tooth pairs that carry load, mean of a mesh cycle"
        unworn = f"; {pairs[0]:.2f} unworn" if pairs.size > 1 else ""
        yield "Contact ratio under load", f"{pairs[-1]:.2f}", note + unworn


def _histories(tree: xr.DataTree) -> Iterator[Number]:
    history = group_of(tree, "history")
    shown = {
        "wear_depth_control_point": "Wear at the control point",
        "load_share_max": "Greatest load share",
        "transmission_error_mean": "Transmission error, mean",
    }
    for name, title in shown.items():
        if name in history:
            point = control_place(tree) if name == "wear_depth_control_point" else None
            yield _first_and_last(f"{title}, {point.body}" if point else title, history[name])


def _stresses(tree: xr.DataTree) -> Iterator[Number]:
    history = group_of(tree, "history")
    if "subsurface_stress_max" in history:
        title, value, note = _first_and_last("Stress below the surface", history["subsurface_stress_max"])
        if "subsurface_stress_depth" in history:
            depth = figure_text(float(history["subsurface_stress_depth"][-1]), 3)
            note = f"{depth} mm deep" + (f"; {note}" if note else "")
        yield title, value, note
    if "root_stress_max" in history:
        for body in history["body"].values:
            yield _first_and_last(f"Root stress, {body}", history["root_stress_max"].sel(body=body))


def _first_and_last(title: str, series: xr.DataArray) -> Number:
    first, last = (with_unit(float(series[step]), series.attrs["units"]) for step in (0, -1))
    return title, last, f"{first} unworn" if series.size > 1 else ""
