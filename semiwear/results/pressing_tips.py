"""Sentences about tip edges in contact and the relief that would free them, from a result."""

from __future__ import annotations

import numpy as np
import xarray as xr

from semiwear.results.missing import group_of
from semiwear.results.wearing import scene_tables

_LEAST_SHARE = 0.01  # of the load: tips whose slices carry less are not reported


def pressing_tips(tree: xr.DataTree) -> list[str]:
    """A sentence for each tip whose slices carry more than a hundredth of the load, unworn and at the last wear step.

    Parameters
    ----------
    tree : DataTree
        With `/engagement`; the relief comes from `/history` where there is one.
    """
    engagement = group_of(tree, "engagement")
    if "tip_load_share" not in engagement:
        return []
    last = engagement.sizes["wear_step"] - 1
    sentences = []
    for step in sorted({0, last}):
        now = engagement.isel(wear_step=step)
        when = ("Unworn" if last else "As given") if step == 0 else f"At wear step {step}"
        for body in now["body"].values:
            share = now["tip_load_share"].sel(body=body).values
            if share.max() <= _LEAST_SHARE:
                continue
            roll = float(now["roll_position"].values[int(share.argmax())])
            pressure = float(np.max(now["contact_pressure_max_edge"].values, where=share > 0.0, initial=0.0))
            sentences.append(
                f"{when}, the {body}'s tip edge is in contact at roll {roll:+.2f}. Its slices carry "
                f"up to {share.max():.0%} of the load, edge and flank together, at up to {pressure:,.0f} MPa on the "
                f"edge, which depends on the edge radius{_relief(tree, step, str(body))}."
            )
    return [text.replace("-", "−") for text in sentences]


def _relief(tree: xr.DataTree, step: int, body: str) -> str:
    history = group_of(tree, "history")
    if "tip_relief_to_free" not in history:
        return ""
    relief = float(history["tip_relief_to_free"].sel(body=body).values[step])
    if relief <= 0.0:
        return ""
    key = f"effects.modification.{body}.tip_relief_um"
    more = "more " if step or _relieved(tree, body) else ""
    return f"; about {relief:.2g} um {more}of tip relief ({key}) would relieve most of it"


def _relieved(tree: xr.DataTree, body: str) -> bool:
    """Whether the scene relieves a body's tips already."""
    effects = scene_tables(tree).get("effects", {})
    return bool(effects.get("modification", {}).get(body, {}).get("tip_relief_um", 0.0))
