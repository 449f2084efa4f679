"""The torque behind the printed figures of the seed paper: for each by itself, and for several at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.errors import ConvergenceError
from semiwear.plain_text import unit_text
from semiwear.report.markup import figure_text, table
from validation.charts import COLOURS, MARKERS, card, cards, legend_above, plain_log
from validation.progress import Progress
from validation.tables import percent, text_table, with_unit
from validation.torque_inference import BestTorque, Inferred

TORQUES = (100.0, 200.0, 400.0, 600.0, 800.0, 1000.0, 1300.0, 1600.0, 2000.0, 2600.0, 3400.0, 4500.0)
QUICK_TORQUES = (100.0, 300.0, 800.0, 1200.0, 1600.0, 2200.0, 3200.0)
QUICK = {
    "numerics.face_slices": 31,
    "numerics.roll_positions": 12,
    "wear.until.control_depths_um": [10.0, 20.0, 40.0, 60.0],
}
TOLERANCE = 0.10
"""Within which a figure counts as met."""

FIGURES: dict[str, tuple[str, str]] = {
    "gear root stress": ("root_bending_stress_gear_MPa", "MPa"),
    "pinion root stress": ("root_bending_stress_pinion_MPa", "MPa"),
    "mean transmission error": ("transmission_error_mean_arcsec", "arcsec"),
    "mean transmission error without the rigid part of wear": ("transmission_error_mean_arcsec", "arcsec"),
    "amplitude of the transmission error": ("transmission_error_amplitude_arcsec", "arcsec"),
    "amplitude of the transmission error without the rigid part of wear": (
        "transmission_error_amplitude_arcsec",
        "arcsec",
    ),
    "greatest wear at the root": ("max_wear_root_um", "um"),
    "greatest wear at the addendum": ("max_wear_addendum_um", "um"),
}
"""Figures that a torque is sought for, with their keys in the reference and units."""

SETS = {
    "root stress and transmission error as printed": [
        "gear root stress",
        "pinion root stress",
        "mean transmission error",
        "amplitude of the transmission error",
    ],
    "the same with the rigid part of wear taken out": [
        "gear root stress",
        "pinion root stress",
        "mean transmission error without the rigid part of wear",
        "amplitude of the transmission error without the rigid part of wear",
    ],
    "root stress alone": ["gear root stress", "pinion root stress"],
    "transmission error alone, as printed": ["mean transmission error", "amplitude of the transmission error"],
    "transmission error alone, rigid part of wear taken out": [
        "mean transmission error without the rigid part of wear",
        "amplitude of the transmission error without the rigid part of wear",
    ],
}


def figures_of(tree: xr.DataTree, depth: float) -> dict[str, float]:
    """Figures of `FIGURES` when the control point has worn to a depth [um].

    The rigid part of wear is the unloaded transmission error of the worn flanks; taken out, the deflection is left.
    """
    history, cycle = tree["history"].to_dataset(), tree["mesh_cycle"].to_dataset()
    worn = history["wear_depth_control_point"].values

    def at(values: np.ndarray) -> float:
        return float(np.interp(depth, worn, values))

    deflection = (
        (cycle["transmission_error_loaded"] - cycle["transmission_error_unloaded"])
        .transpose("wear_step", "mesh_position")
        .values
    )
    stress = history["root_stress_max"]
    return {
        "gear root stress": at(stress.sel(body="gear").values),
        "pinion root stress": at(stress.sel(body="pinion").values),
        "mean transmission error": at(history["transmission_error_mean"].values),
        "mean transmission error without the rigid part of wear": at(deflection.mean(axis=1)),
        "amplitude of the transmission error": at(history["transmission_error_amplitude"].values),
        "amplitude of the transmission error without the rigid part of wear": at(np.ptp(deflection, axis=1)),
        "greatest wear at the root": at(history["wear_depth_max_root"].values),
        "greatest wear at the addendum": at(history["wear_depth_max_addendum"].values),
    }


def _at_torque(scene: sw.Scene, torque: float) -> dict[str, float]:
    tree = sw.simulate(scene.replace({"operation.pinion_torque_Nm": torque}))
    return figures_of(tree, float(tree["history"].to_dataset()["wear_depth_control_point"].values[-1]))


def over_torque(
    scene: sw.Scene, torques: Sequence[float], progress: Progress
) -> tuple[dict[str, list[float]], list[float]]:
    """Figures over torque, and the torques at which the control point wears to the last depth."""
    values: dict[str, list[float]] = {name: [] for name in FIGURES}
    kept = []
    for torque in torques:
        progress.note(f"{torque:g} N m")
        try:
            figures = _at_torque(scene, torque)
        except ConvergenceError:
            continue  # the control point loses its load under this torque: nothing to compare
        kept.append(torque)
        for name, value in figures.items():
            values[name].append(value)
    return values, kept


def model_of(scene: sw.Scene, name: str, progress: Progress) -> Callable[[float], float]:
    def figure(torque: float) -> float:
        progress.note(f"{name}, checked at {torque:.0f} N m")
        return _at_torque(scene, torque)[name]

    return figure


def torque_part(
    inferred: Sequence[Inferred],
    best: Mapping[str, BestTorque],
    torques: Sequence[float],
    values: Mapping[str, Sequence[float]],
    printed: Mapping[str, float],
) -> str:
    rows = []
    for one in inferred:
        unit = FIGURES[one.name][1]
        at = ", ".join(f"{torque:.0f}" for torque in one.torques) or "none"
        checked = ", ".join(figure_text(value) for value in one.checked) or "–"
        low, high = (figure_text(value, 3) for value in one.range)
        rows.append((one.name, with_unit(one.printed, unit), at, checked, f"{low} to {high} {unit_text(unit)}"))
    head = ("figure at 60 µm", "printed", "torque that gives it [N m]", "computed there", "what the torques give")
    fits = [
        (
            title,
            f"{one.torque:.0f}",
            percent(one.worst),
            one.figure,
            "one torque fits" if one.fits else "none fits",
        )
        for title, one in best.items()
    ]
    marks = ["agree" if one.fits else "disagree" for one in best.values()]
    best_head = ("figures", "best torque [N m]", "greatest deviation there", "of", f"within {100 * TOLERANCE:g} %")

    def draw(ax: Any) -> None:
        shown = [name for name in FIGURES if not name.startswith("greatest")]
        for k, name in enumerate(shown):
            ratio = np.array(values[name]) / printed[name]
            style = "--" if "rigid" in name else "-"
            text = name.replace("amplitude of the", "amplitude of").replace("transmission error", "TE")
            text = text.replace(" without the rigid part of wear", ", no rigid part")
            ax.loglog(torques, ratio, style, marker=MARKERS[k], color=COLOURS[k], label=text)
        ax.axhline(1.0, color="#555555", linewidth=1.0)
        ax.axhspan(1 - TOLERANCE, 1 + TOLERANCE, color="#EEEEEE", zorder=0)
        plain_log(ax.xaxis)
        plain_log(ax.yaxis)
        ax.set_xlabel("Pinion torque (N m)")
        ax.set_ylabel("Ours over the printed figure")
        legend_above(ax, fontsize=8)

    chart = card(
        "torque",
        "Figures over torque",
        "One torque would fit where all curves cross 1 together; the band is the tolerance.",
        draw,
        size=(4.9, 4.4),
    )
    intro = (
        "<h3>Torque inferred from each printed figure</h3><p>The paper prints no torque. The shipped scene is worn "
        f"to 60 µm at the control point at {len(torques)} torques from {torques[0]:g} to {torques[-1]:g} N m, and "
        "the model solved for the torque at which it gives each printed figure. The rigid part of wear is what the "
        "transmission error of the worn flanks is without load.</p>"
    )
    return (
        intro
        + cards([chart])
        + text_table(table("Torque by printed figure", head, rows))
        + text_table(table("One torque for several figures", best_head, fits, marks))
    )
