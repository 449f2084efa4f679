"""Section of a report on failure modes: the first failure, safeties over the life and on the flanks."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from math import isfinite

import numpy as np
import xarray as xr

from semiwear.plot.ratings import mode_words, safety_history, safety_map
from semiwear.plot.style import SIZE_WIDE
from semiwear.report.markup import NONE, card, element, figure_text, table
from semiwear.report.pictures import figure_uri
from semiwear.results.missing import group_of

_SIZE = (8.0, 4.6)
_HEAD = ("mode", "body", "required", "unworn", "last", "where it is least", "falls below", "error")


def ratings_section(tree: xr.DataTree) -> str:
    """A sentence on the first failure, a table and a chart of all modes, a map of each; empty without ratings."""
    ratings = group_of(tree, "ratings")
    if not ratings:
        return ""
    uri = figure_uri(_SIZE, 1, lambda axes: safety_history(tree, axes[0]))
    modes = ratings["mode"].values if "wear_depth" in group_of(tree, "flank") else ()
    maps = "".join(_map(tree, str(mode)) for mode in modes)
    caption = (
        "Safety over required safety of each failure mode, for pinion and gear; the background has the colour of the "
        "mode with the least value, and a cross marks where a safety falls below the required one. Safeties from "
        "accumulated damage begin at static strength and fall along life curves."
    )
    text = first_failure_text(ratings)
    life = card("Safeties over the life", uri, text, caption, _SIZE, full=True)
    rows = table("Safeties of the failure modes", _HEAD, _rows(ratings))
    cards = element("div", life + maps, class_="cards")
    return f"<p>{escape(text)}</p>{rows}{cards}{_factors(ratings)}"


def first_failure_text(ratings: xr.Dataset) -> str:
    """A sentence on the failure mode that ends the life first, and when."""
    first = ratings["fails_first"].values.astype(bool)
    if not first.any():
        words = ", ".join(mode_words(str(mode)) for mode in ratings["mode"].values)
        return f"None of the rated failure modes ({words}) falls below its required safety within this run."
    mode = str(ratings["mode"].values[first][0])
    ends = ratings["meshes_to_failure"].sel(mode=mode)
    body = str(ends["body"].values[int(np.nanargmin(ends.values))])
    return f"{mode_words(mode).capitalize()} of the {body} ends the life first: {_end(ratings, mode, body)}."


def _end(ratings: xr.Dataset, mode: str, body: str) -> str:
    meshes = float(ratings["meshes_to_failure"].sel(mode=mode, body=body))
    if not isfinite(meshes):
        return NONE
    if meshes == 0.0:
        return "before any wear"
    hours = f" ({figure_text(_value(ratings, 'hours_to_failure', mode, body))} h)" if "hours" in ratings else ""
    return f"after {figure_text(meshes)} meshes{hours}"


def _value(ratings: xr.Dataset, name: str, mode: str, body: str, wear_step: int | None = None) -> float:
    found = ratings[name].sel(mode=mode, body=body)
    return float(found if wear_step is None else found.isel(wear_step=wear_step))


def _rows(ratings: xr.Dataset) -> Iterator[tuple[str, ...]]:
    for mode in map(str, ratings["mode"].values):
        required = figure_text(float(ratings["required_safety"].sel(mode=mode)), 3)
        for body in map(str, ratings["body"].values):
            first, last = (figure_text(_value(ratings, "safety", mode, body, step)) for step in (0, -1))
            height, face = (_value(ratings, f"safety_{name}", mode, body, -1) for name in ("height", "face"))
            where = f"height {height:+.2f} mm, face {face:.1f} mm".replace("-", "−") if isfinite(height) else NONE
            end = _end(ratings, mode, body), _error(ratings, mode, body)
            yield mode_words(mode), body, required, first, last, where, *end


def _error(ratings: xr.Dataset, mode: str, body: str) -> str:
    if "safety_error" not in ratings:
        return NONE
    text = f"safety {figure_text(float(ratings['safety_error'].sel(mode=mode)), 2)}"
    life = _value(ratings, "meshes_to_failure_error", mode, body)
    return f"{text}, life {figure_text(life, 2)} meshes" if isfinite(life) else text


def _map(tree: xr.DataTree, mode: str) -> str:
    safety = tree["ratings"].to_dataset()["safety_on_flank"].sel(mode=mode)
    uri = figure_uri(SIZE_WIDE, 2, lambda axes: safety_map(tree, axes, mode=mode), columns=2)
    least = ", ".join(f"{body} {figure_text(float(safety.sel(body=body).min()), 3)}" for body in ("pinion", "gear"))
    meaning = "with the load at each point" if mode == "bending" else "of each point"
    caption = f"Safety {meaning} at the last wear step, along the tooth and over its height; white: not rated."
    title = f"{mode_words(mode).capitalize()} on the worn flanks"
    alt = f"{title}. Least safety: {least}."
    return card(title, uri, alt, caption, SIZE_WIDE, full=True, of_colours=True)


def _factors(ratings: xr.Dataset) -> str:
    """The factors of every mode, folded."""
    entries = "".join(
        f"<dt>{escape(mode_words(str(mode)))}</dt><dd>{escape(str(ratings.attrs[str(mode)]))}</dd>"
        for mode in ratings["mode"].values
        if str(mode) in ratings.attrs
    )
    summary = "<summary>Factors of the ratings, and why they have their values</summary>"
    return f"<details>{summary}<dl>{entries}</dl></details>"
