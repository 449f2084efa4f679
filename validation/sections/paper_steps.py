"""What contradicts itself in the seed paper, and what its wear steps explain of its depths."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.errors import ConvergenceError
from semiwear.report.markup import figure_text, table
from validation.charts import COLOURS, MARKERS, card, cards, legend_above, plain_log
from validation.progress import Progress
from validation.tables import dataset, listed, percent, with_unit

STEPS = {"explicit": (12, 48, 120), "implicit": (12, 48)}
QUICK_STEPS = {"explicit": (12, 36), "implicit": (12, 36)}
"""Steps to the last control depth: twelve explicit ones are the paper's; the most implicit ones are converged."""
# ---- k, stress and engagements


def life_of(tree: xr.DataTree, paper: Mapping[str, Any]) -> xr.Dataset:
    """Product of wear coefficient and engagements, the paper's and ours, over the depth of the control point."""
    depths = np.array(paper["wear"]["control_depth_um"], float)
    k = paper["wear"]["coefficient_mm2_per_N"]
    theirs = k * 1e10 * np.array(paper["wear"]["engagements_1e10"])
    history = tree["history"].to_dataset()
    scene = tomllib.loads(str(tree.attrs["scene_toml"]))
    own = float(scene["wear"]["coefficient_mm2_per_N"])
    ours = own * np.interp(depths, history["wear_depth_control_point"].values, history["meshes"].values)
    return dataset(
        {"control_depth_um": depths},
        {
            "paper": (theirs, "mm2/N", "wear coefficient times engagements, the paper's"),
            "ours": (ours, "mm2/N", "wear coefficient times engagements, ours"),
            "factor": (theirs / ours, "1", "the paper's over ours"),
            "paper_load": (1e-3 * depths / theirs, "N/mm", "line load times specific sliding that the paper implies"),
            "our_load": (1e-3 * depths / ours, "N/mm", "line load times specific sliding here"),
        },
    )


def life_part(life: xr.Dataset) -> str:
    rows = [
        (
            with_unit(float(one.control_depth_um), "um"),
            figure_text(float(one.paper), 3),
            figure_text(float(one.ours), 3),
            figure_text(float(one.factor), 3),
            figure_text(float(one.paper_load), 3),
            figure_text(float(one.our_load), 3),
        )
        for one in (life.isel(control_depth_um=k) for k in range(life.sizes["control_depth_um"]))
    ]
    head = ("control depth", "k N, paper [mm²/N]", "k N, ours [mm²/N]", "paper over ours",
            "implied load x sliding, paper [N/mm]", "ours [N/mm]")  # fmt: skip
    low, high = float(life.factor.min()), float(life.factor.max())
    text = (
        "<h3>Wear coefficient, stress and engagements</h3><p>By Archard's law a depth over wear coefficient and "
        "engagements is the line load times the specific sliding. The paper's engagements leave "
        f"{with_unit(float(life.paper_load.min()), 'N/mm', 3)} to "
        f"{with_unit(float(life.paper_load.max()), 'N/mm', 3)}; teeth under the printed root stress bear "
        f"{with_unit(float(life.our_load.min()), 'N/mm', 3)} to {with_unit(float(life.our_load.max()), 'N/mm', 3)} "
        f"here. The paper's k, stress and engagements contradict each other by a factor of {figure_text(low, 3)} to "
        f"{figure_text(high, 3)}.</p>"
    )
    return text + table("Wear coefficient times engagements", head, rows)


# ---- the paper's steps


def _title(scheme: str, count: int) -> str:
    return f"{scheme}, {count} steps" + (" (the paper's)" if (scheme, count) == ("explicit", 12) else "")


def worn_by_schemes(
    scene: sw.Scene, slices: Sequence[int], steps: Mapping[str, Sequence[int]], progress: Progress
) -> xr.Dataset:
    """Wear after 60 um at the control point: the paper's explicit steps of 5 um, finer ones, and the converged."""
    own = scene.wear
    assert own is not None and own.until.control_depths_um is not None
    last = own.until.control_depths_um[-1]
    runs = {_title(scheme, count): (scheme, count) for scheme, counts in steps.items() for count in counts}
    figures = ("wear_depth_max_root", "wear_depth_max_addendum", "meshes")
    found = np.full((len(runs), len(slices), len(figures)), np.nan)
    roughness = np.full((len(runs), len(slices)), np.nan)
    for i, (title, (scheme, count)) in enumerate(runs.items()):
        for j, number in enumerate(slices):
            progress.note(f"{title}, {number} slices")
            depths = [last * (k + 1) / count for k in range(count)]
            changed = scene.replace(
                {
                    "numerics.wear_scheme": scheme,
                    "wear.until.control_depths_um": depths,
                    "numerics.face_slices": number,
                    "numerics.roll_positions": 12 if number < 60 else 24,
                }
            )
            try:
                tree = sw.simulate(changed)
            except ConvergenceError:
                continue  # the control point loses its load: the scheme does not reach the depth
            history = tree["history"].to_dataset().isel(wear_step=-1)
            found[i, j] = [float(history[name]) for name in figures]
            wear = tree["flank"].to_dataset()["wear_depth"].isel(wear_step=-1).sel(body="gear").values
            roughness[i, j] = float(np.abs(np.diff(wear, 2, axis=1)).mean() / wear.mean())
    return dataset(
        {"scheme": list(runs), "slices": np.array(slices)},
        {
            "root": (found[..., 0], "um", "greatest wear at the root"),
            "addendum": (found[..., 1], "um", "greatest wear at the addendum"),
            "meshes": (found[..., 2], "1", "meshes to the last control depth"),
            "roughness": (roughness, "1", "mean second difference of wear along the face over its mean"),
        },
    )


def explained(schemes: xr.Dataset, paper: Mapping[str, Any]) -> str:
    """In words: how much of the printed wear at the root the paper's step size explains."""
    printed = paper["at_60_um"]["max_wear_root_um"]
    coarse = schemes["root"].sel(scheme=_title("explicit", 12)).values
    fine = schemes["root"].isel(scheme=-1).values
    known = np.isfinite(coarse) & np.isfinite(fine)
    if not known.any():
        return "The paper's 12 explicit steps do not reach 60 µm at the control point here."
    texts = []
    for number, first, second in zip(schemes["slices"].values[known], coarse[known], fine[known], strict=True):
        share = (first - second) / (printed - second)
        texts.append(f"{figure_text(first)} µm at {number} slices ({percent(share)} of the way)")
    return (
        f"Its 12 explicit steps, imitated, give {listed(texts)} from {figure_text(fine[known][-1])} µm, converged, "
        f"to its {printed:g} µm at the root."
    )


def schemes_part(schemes: xr.Dataset, paper: Mapping[str, Any]) -> str:
    rows = []
    for title in schemes["scheme"].values:
        for number in schemes["slices"].values:
            one = schemes.sel(scheme=title, slices=number)
            if np.isfinite(float(one.root)):
                cells = [with_unit(float(one[name]), "um") for name in ("root", "addendum")]
                rows.append(
                    (
                        str(title),
                        str(number),
                        *cells,
                        figure_text(float(one.meshes), 3),
                        percent(float(one.roughness)),
                    )
                )
            else:
                rows.append((str(title), str(number), "not reached", "not reached", "–", "–"))
    at_60 = paper["at_60_um"]
    printed = [with_unit(at_60[f"max_wear_{zone}_um"], "um", 5) for zone in ("root", "addendum")]
    rows.append(("the paper", "–", *printed,
                 figure_text(1e10 * paper["wear"]["engagements_1e10"][-1], 3), "–"))  # fmt: skip

    def draw(ax: Any) -> None:
        steps = np.array([int(str(title).split()[1]) for title in schemes["scheme"].values])
        for k, number in enumerate(schemes["slices"].values):
            for scheme, style in (("explicit", "-"), ("implicit", "--")):
                own = np.array([str(title).startswith(scheme) for title in schemes["scheme"].values])
                wear = schemes["root"].sel(slices=number).values[own]
                ax.semilogx(steps[own], wear, style, marker=MARKERS[k], color=COLOURS[scheme == "implicit"],
                            label=f"{scheme}, {number} slices")  # fmt: skip
        ax.axhline(at_60["max_wear_root_um"], color="#555555", linestyle=":", label="printed")
        plain_log(ax.xaxis)
        ax.set_xlabel("Wear steps to 60 µm at the control point")
        ax.set_ylabel("Greatest wear at the root (µm)")
        ax.set_ylim(bottom=0.0)
        legend_above(ax, fontsize=8)

    explicit = schemes["addendum"].sel(scheme=_title("explicit", 12)).values
    known = [figure_text(value, 3) for value in explicit if np.isfinite(value)]
    intro = (
        "<h3>The paper's wear steps</h3><p>The paper holds pressures while the control point wears by 5 µm, twelve "
        "times: explicit steps. Here the same, finer ones, and implicit ones, the most of which count as converged, "
        f"all to the same depth. {explained(schemes, paper)} At the addendum the same steps give {listed(known)} "
        f"µm, where {at_60['max_wear_addendum_um']:g} µm is printed. What an explicit scheme overshoots depends on "
        "its grid and on how the mesh is smoothed, of which the paper says nothing.</p>"
    )
    chart = card("steps", "Wear at the root by scheme", "After 60 µm at the control point.", draw, size=(4.9, 4.3))
    head = ("scheme", "slices", "root", "addendum", "meshes", "roughness along the face")
    return intro + cards([chart]) + table("Wear after 60 µm at the control point", head, rows)
