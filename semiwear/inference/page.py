"""Report of an inference as a single, self-contained HTML file (extra ``plot``)."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import partial
from html import escape
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.inference.lives import PosteriorLife
from semiwear.inference.observations import Channel, Observation, WornFlank
from semiwear.inference.posterior import HEAD, Posterior
from semiwear.measured.comparison import compare_wear
from semiwear.measured.life_spread import QUANTILES
from semiwear.plain_text import unit_text
from semiwear.plot.measured import measured_wear
from semiwear.plot.posterior import corner_size, posterior_corner, with_spaces
from semiwear.plot.style import SIZE
from semiwear.report.markup import card, element, figure_text, folded_toml, table, tiles
from semiwear.report.pictures import figure_uri
from semiwear.report.writing import page_of, page_target, write_page
from semiwear.scene import Scene
from semiwear.scene.units import unit_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FLANKS = (13.2, 3.9)
_FEW_PANELS = 2  # per side of the corner picture
_COLOUR, _LINE = "#0B5394", "#A63C00"


def write_posterior_report(
    found: Posterior,
    observed: Sequence[Observation],
    path: str | os.PathLike[str],
    simulate: Callable[[Scene], xr.DataTree],
    lives: Sequence[PosteriorLife] = (),
) -> Path:
    """Write an inference as a page: determined and undetermined fields, the posterior, the fit, and lives.

    Parameters
    ----------
    found : Posterior
    observed : sequence of observations
        Observations of the inference.
    path : path
        The HTML file.
    simulate : callable
        From a scene to its result; used on the scene at the posterior's medians for the pictures of flanks.
    lives : sequence of PosteriorLife, optional

    Raises
    ------
    MissingExtraError
        matplotlib is missing; install the extra ``plot``.
    OSError
        The file cannot be written.
    """
    target = page_target(path)
    sections = [
        ("Inferred fields", _summary(found)),
        ("Undetermined fields", _apart(found)),
        ("Posterior", _corner(found)),
        ("Fit at the posterior's medians", _fit(found, observed, simulate)),
        ("Life", _lives(lives)),
        ("Runs and draws", element("p", escape(found.sampled + "."))),
        ("The scene at the posterior's medians", folded_toml(found.inferred_scene.to_toml())),
    ]
    attrs = {str(name): value for name, value in found.to_dataset().attrs.items()}
    source = f"From: {attrs['observed']}."
    write_page(target, page_of(str(attrs["title"]), source, sections, attrs))
    return target


def _summary(found: Posterior) -> str:
    numbers = []
    for unknown in found.target.unknowns.every:
        low, high = found.interval(unknown.key)
        note = f"95 %: {figure_text(low)} to {figure_text(high)}"
        value = f"{figure_text(found.quantile(unknown.key, 0.5))} {unit_text(unit_of(unknown.key))}".strip()
        numbers.append((with_spaces(unknown.name), value, note))
    note = (
        "Of the prior's: standard deviation over that of the prior, near 100 % if nothing was learnt. Emulator: "
        "part of the standard deviation by its error, which the intervals include."
    )
    rows = [(*row[:-1], unit_text(row[-1])) for row in found.rows()]
    return tiles(numbers) + table("Unknown fields", [escape(head) for head in HEAD], rows) + f"<p>{note}</p>"


def _apart(found: Posterior) -> str:
    lines = found.not_told_apart
    if not lines:
        return "<p>The observations determine every unknown.</p>"
    return "<ul>" + "".join(element("li", escape(line)) for line in lines) + "</ul>"


def _corner(found: Posterior) -> str:
    data, count = found.to_dataset(), len(found.keys)
    size = corner_size(count)
    uri = figure_uri(size, count * count, lambda axes: posterior_corner(data, axes), columns=count)
    caption = "On the diagonal medians and 95 % intervals; elsewhere lines about 50 and 95 % of the draws."
    alt = "; ".join(found.not_told_apart) or "no pair is confounded"
    # a few panels are no wider than their letters allow
    return card("Draws", uri, alt, caption, size, full=count > _FEW_PANELS)


def _fit(found: Posterior, observed: Sequence[Observation], simulate: Callable[[Scene], xr.DataTree]) -> str:
    parts = ["<ul>" + "".join(element("li", escape(line)) for line in found.misfits()) + "</ul>"]
    for observation, channel in zip(observed, found.target.channels, strict=True):
        if isinstance(observation, WornFlank):
            parts.append(_flank(found, observation, channel, simulate))
        elif channel.values.size > 1:
            parts.append(_against(found, channel))
    return f'{parts[0]}<div class="cards">{"".join(parts[1:])}</div>'


def _flank(found: Posterior, given: WornFlank, channel: Channel, simulate: Callable[[Scene], xr.DataTree]) -> str:
    """Predicted beside measured wear, from a run at the medians rather than the emulator."""
    tree = simulate(found.inferred_scene.replace({"wear.until.meshes": channel.meshes}))
    compared = compare_wear(tree, given.measured, before=given.before, body=given.body, datum=given.datum)
    uri = figure_uri(FLANKS, 3, lambda axes: measured_wear(compared, axes), columns=3)
    alt = f"difference: root mean square {float(compared['difference_rms']):.2g} um"
    return card(channel.name.capitalize(), uri, alt, "From a run at the posterior's medians.", FLANKS, full=True)


def _against(found: Posterior, channel: Channel) -> str:
    """Measured over predicted values of an observation, without the movements of a datum."""
    k = list(found.target.channels).index(channel)
    amounts = found.target.amounts(np.median(found.draws.normal, axis=0)[None])[k][0]
    predicted = found.target.model.shapes[k] @ amounts
    free = channel.movements
    rest = channel.values - predicted
    moved = free @ np.linalg.lstsq(free, rest, rcond=None)[0] if free.shape[1] else np.zeros(rest.size)
    measured, deviation = channel.values - moved, found.target.evidence[k].deviation

    def draw_on(axes: list[Axes]) -> None:
        (ax,) = axes
        ends = [min(predicted.min(), measured.min()), max(predicted.max(), measured.max())]
        ax.plot(ends, ends, color=_LINE, lw=1.0)
        ax.errorbar(predicted, measured, deviation, fmt="o", color=_COLOUR, ms=4, lw=1.0)
        units = unit_text(channel.units)
        ax.set(xlabel=f"Predicted ({units})", ylabel=f"Measured ({units})")

    caption = "Bars: one standard uncertainty; on the line both are the same."
    uri = figure_uri(SIZE, 1, draw_on)
    return card(channel.name.capitalize(), uri, "measured over predicted", caption, SIZE)


def _lives(lives: Sequence[PosteriorLife]) -> str:
    cards = []
    for life in lives:
        uri = figure_uri(SIZE, 1, partial(_draw_life, life))
        title = f"Life of the {life.body} until {life.depth_limit:g} µm"
        cards.append(card(title, uri, str(life), str(life), SIZE))
    return f'<div class="cards small">{"".join(cards)}</div>' if cards else ""


def _draw_life(life: PosteriorLife, axes: list[Axes]) -> None:
    (ax,) = axes
    ax.hist(life.meshes[np.isfinite(life.meshes)], bins=40, color=_COLOUR, alpha=0.8)
    for place in filter(isfinite, map(life.quantile, QUANTILES)):
        ax.axvline(place, color=_LINE, lw=1.0)
    ax.set(xlabel="Meshes", ylabel="Draws")
