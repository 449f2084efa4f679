"""The pictures of a report in their order, with headings, captions and alternative texts."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear import plot
from semiwear.errors import SemiwearError
from semiwear.plot.style import SIZE, SIZE_PAIR, SIZE_WIDE, styled
from semiwear.report.markup import figure_text
from semiwear.results.missing import away_from_edges, group_of, why_missing
from semiwear.results.wearing import pitch_name, pitch_surface, shown_bodies

if TYPE_CHECKING:
    from matplotlib.axes import Axes

OF_COLOURS = ("wear_map", "contact_pattern", "wear_surface")
"""Pictures whose colours represent values."""

_PIXELS_PER_INCH = 150


@dataclass(frozen=True)
class Picture:
    """One picture.

    Attributes
    ----------
    name : str
        Function of `semiwear.plot` that draws it.
    title, caption : str
        Heading, and one sentence on what the picture shows.
    part : str
        Part of the page: ``"first"`` screen, worn ``"flank"``, over the ``"life"``, through the ``"mesh"``.
    panels : int
        Axes that the function takes.
    needs_wear : bool
        Whether it shows wear or a change with wear, and therefore needs two wear steps.
    optional : bool
        Whether only some results hold its data, so that no reason is given where it is left out.
    both_ends : bool
        Whether the first and the last wear step stand side by side.
    of_body : bool
        Whether it shows one flank; it is then drawn for each body that wears.
    body : str
        The body of that flank; empty for other pictures.
    size : tuple of float
        Width and height [inch].
    describe : callable
        Short text with the main numbers of a result, for readers who do not see the picture.
    """

    name: str
    title: str
    caption: str
    describe: Callable[..., str]
    part: str
    panels: int = 1
    needs_wear: bool = False
    optional: bool = False
    both_ends: bool = False
    of_body: bool = False
    body: str = ""
    size: tuple[float, float] = SIZE

    def of(self, tree: xr.DataTree, body: str) -> Picture:
        """The picture with heading and caption for a result's gear pair and, if it shows one flank, for a body."""
        names = {"body": body, "pitch": pitch_name(tree)}
        describe = partial(self.describe, body=body) if self.of_body else self.describe
        title, caption = self.title.format(**names), self.caption.format(**names)
        return replace(self, body=body, title=title, caption=caption, describe=describe)


@dataclass(frozen=True)
class Drawn:
    """A picture as a data URI with its alternative text, or the reason why it is left out."""

    picture: Picture
    uri: str
    alt: str
    left_out: str = ""


def draw_all(tree: xr.DataTree) -> list[Drawn]:
    """All pictures of a result; those of one flank for each body that wears."""
    bodies = shown_bodies(tree)
    return [
        draw(picture.of(tree, body), tree) for picture in PICTURES for body in (bodies if picture.of_body else ("",))
    ]


def draw(picture: Picture, tree: xr.DataTree) -> Drawn:
    """Draw a picture from a result."""
    steps = group_of(tree, "history").sizes.get("wear_step", 1)
    if picture.needs_wear and steps < 2:
        return Drawn(picture, "", "", "the result has one wear step, so there is no wear to show")
    try:
        uri = _png(picture, tree)
        return Drawn(picture, uri, f"{picture.title}. {picture.describe(tree)}")
    except SemiwearError as reason:
        if isinstance(reason, ImportError):
            raise
        return Drawn(picture, "", "", "" if picture.optional else str(reason))


def _png(picture: Picture, tree: xr.DataTree) -> str:
    function: Callable[..., object] = getattr(plot, picture.name)
    if picture.both_ends:
        steps = (0, -1) if group_of(tree, "flank").sizes.get("wear_step", 1) > 1 else (0,)

        def first_and_last(axes: list[Axes]) -> None:
            for step, ax in zip(steps, axes, strict=True):
                function(tree, wear_step=step, ax=ax)

        return figure_uri(picture.size, len(steps), first_and_last, columns=len(steps))
    solid = {"projection": "3d"} if picture.name == "wear_surface" else None

    options = {"body": picture.body} if picture.body else {}

    def panels(axes: list[Axes]) -> None:
        function(tree, ax=axes[0] if picture.panels == 1 else axes, **options)

    return figure_uri(picture.size, picture.panels, panels, subplot=solid)


@styled()
def figure_uri(
    size: tuple[float, float],
    panels: int,
    draw_on: Callable[[list[Axes]], object],
    *,
    columns: int = 1,
    subplot: dict[str, str] | None = None,
) -> str:
    """A figure of a `size` [inch] in the common style, as a data URI; `draw_on` is called with its axes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    draw_on(list(figure.subplots(panels // columns, columns, squeeze=False, subplot_kw=subplot).flat))
    stream = io.BytesIO()
    # transparent, since the background of the page is light or dark
    figure.savefig(stream, format="png", dpi=_PIXELS_PER_INCH, transparent=True, metadata={"Software": None})
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode()


def _history_text(*names: str, body: bool = False) -> Callable[[xr.DataTree], str]:
    """Text with the first and last values of some histories."""

    def describe(tree: xr.DataTree) -> str:
        parts = []
        for name in names:
            array = tree["history"].to_dataset()[name]
            for series in (array.sel(body=name) for name in array["body"].values) if body else (array,):
                owner = f" of the {series['body'].item()}" if body else ""
                first, last = (_value_text(series, step) for step in (0, -1))
                parts.append(f"{array.attrs['long_name']}{owner}: {first} at first, {last} at last")
        return "; ".join(parts) + "."

    return describe


def _value_text(series: xr.DataArray, step: int) -> str:
    value = float(series[step])
    return f"none ({why_missing(series)})" if np.isnan(value) else figure_text(value)


def _greatest_text(array: xr.DataArray) -> str:
    """Greatest value over the engagement with its roll position, or the reason why there is none."""
    if np.isnan(array.values).all():
        return f"none ({why_missing(array)})"
    place = int(np.nanargmax(array.values))
    roll = f"{array['roll_position'].values[place]:+.2f}".replace("-", "−")
    return f"{figure_text(float(array.values[place]))} {array.attrs['units']} at roll position {roll}"


def _sliding_text(tree: xr.DataTree) -> str:
    array = tree["engagement"].to_dataset()["sliding_distance"].isel(wear_step=-1)
    parts = (f"{body} {_greatest_text(array.sel(body=body))}" for body in map(str, array["body"].values))
    return f"Greatest at the last wear step: {', '.join(parts)}."


def _pressure_text(tree: xr.DataTree) -> str:
    engagement = tree["engagement"].to_dataset().isel(wear_step=-1)
    text = f"Greatest away from borders at the last wear step: {_greatest_text(away_from_edges(engagement))}"
    edge = engagement.get("contact_pressure_max_edge")
    if edge is not None and float(edge.max()) > 0.0:
        text += f"; at an edge {_greatest_text(edge)}"
    return f"{text}."


def _flank_text(tree: xr.DataTree, body: str) -> str:
    flank = tree["flank"].to_dataset().sel(body=body).isel(wear_step=-1)
    wear = flank["wear_depth"].values
    place = np.unravel_index(int(wear.argmax()), wear.shape)
    height = float(flank["flank_height"].values[place])
    return (
        f"Greatest wear of the {body} {wear[place]:.3g} µm at radius "
        f"{flank['flank_radius'].values[place]:.1f} mm, "
        f"{abs(height):.2f} mm {'above' if height >= 0.0 else 'below'} the {pitch_surface(tree, body)}."
    )


def _worn_text(tree: xr.DataTree) -> str:
    wear = tree["flank"].to_dataset()["wear_depth"].isel(wear_step=-1)
    greatest = (f"{body} {float(wear.sel(body=body).max()):.3g} µm" for body in shown_bodies(tree))
    return f"Greatest wear at the last wear step: {', '.join(greatest)}."


def _pattern_text(tree: xr.DataTree) -> str:
    gear = tree["flank"].to_dataset()
    parts = []
    for step in (0, -1):
        pressure = gear["contact_pattern"].values[step]
        loaded = float((pressure > 0.0).mean())
        parts.append(f"{loaded:.0%} of the flank's points carry pressure, at most {pressure.max():.0f} MPa")
    return f"At the first wear step {parts[0]}; at the last {parts[1]}."


def _curves_text(tree: xr.DataTree) -> str:
    values = tree["mesh_cycle"].to_dataset()["transmission_error_loaded"].values
    first, last = (f"from {curve.min():.4g} to {curve.max():.4g} arcsec" for curve in (values[0], values[-1]))
    return f"At the first wear step {first}, at the last {last}."


PICTURES: tuple[Picture, ...] = (
    Picture(
        "wear_map",
        "Wear of the {body}'s flank",
        "Wear depth along the tooth and over its height at the last wear step; dashed, the band of the {pitch}; "
        "circle, the greatest wear; diamond, the control point if it lies on this flank.",
        _flank_text,
        "flank",
        needs_wear=True,
        of_body=True,
    ),
    Picture(
        "wear_history",
        "Wear over the life",
        "Greatest wear of every body that wears, and in the zones of its flank: root, addendum and the band of the "
        "{pitch}.",
        _worn_text,
        "life",
        needs_wear=True,
    ),
    Picture(
        "contact_pattern",
        "Contact pattern",
        "Greatest pressure at each point of the gear's flank in a mesh, at the first and the last wear step; "
        "the colour scale ends at the greatest pressure away from borders.",
        _pattern_text,
        "flank",
        optional=True,
        both_ends=True,
        size=SIZE_WIDE,
    ),
    Picture(
        "wear_profiles",
        "Sections through the wear of the {body}",
        "Wear depth along the tooth height at a few places, and along the face width at a few heights; thick, "
        "through the deepest place.",
        _flank_text,
        "flank",
        panels=2,
        needs_wear=True,
        of_body=True,
        size=SIZE_PAIR,
    ),
    Picture(
        "sliding_along_path",
        "Sliding along the path of contact",
        "Distance by which a point of each flank slides in one mesh, where the pressure is greatest.",
        _sliding_text,
        "mesh",
    ),
    Picture(
        "meshes_against_depth",
        "Meshes for a wear depth",
        "Engagements of a gear tooth until the control point reaches a wear depth; dashed, a constant wear rate.",
        _history_text("wear_depth_control_point"),
        "life",
        needs_wear=True,
    ),
    Picture(
        "load_share",
        "Load share",
        "Share of the load on one tooth pair over its engagement, and its greatest value over the life.",
        _history_text("load_share_max"),
        "mesh",
        panels=2,
        needs_wear=True,
        size=SIZE_PAIR,
    ),
    Picture(
        "root_stress_history",
        "Root stress",
        "Greatest tangential stress in the root fillets of pinion and gear over the life.",
        _history_text("root_stress_max", body=True),
        "life",
        needs_wear=True,
    ),
    Picture(
        "contact_stress_history",
        "Contact pressure by zone",
        "Greatest contact pressure at root, {pitch} and addendum of the gear over the life; its root meets the "
        "pinion's addendum.",
        _history_text("contact_pressure_root", "contact_pressure_pitch", "contact_pressure_addendum"),
        "life",
        needs_wear=True,
    ),
    Picture(
        "transmission_error_history",
        "Transmission error over the life",
        "Mean and amplitude of the loaded transmission error over the life; zero is the unloaded, unworn mean.",
        _history_text("transmission_error_mean", "transmission_error_amplitude"),
        "life",
        panels=2,
        needs_wear=True,
        size=SIZE_PAIR,
    ),
    Picture(
        "transmission_error_curves",
        "Transmission error over the mesh cycle",
        "Loaded transmission error over one mesh cycle, one curve per wear step.",
        _curves_text,
        "mesh",
    ),
    Picture(
        "contact_pressure_over_engagement",
        "Contact pressure over the engagement",
        "Greatest contact pressure on one tooth pair from entry to exit, away from borders; dotted, a higher "
        "pressure at an edge; hatched, roll positions where only edges carry load.",
        _pressure_text,
        "mesh",
    ),
    Picture(
        "wear_surface",
        "Worn flank of the {body}",
        "The worn flank on a piece of the tooth, the unworn flank drawn as a plane (dashed); colours show the wear "
        "depth, which is drawn enlarged by the factor in the title.",
        _flank_text,
        "first",
        needs_wear=True,
        of_body=True,
        size=(5.8, 4.0),
    ),
)
"""The pictures, in the order of the report."""
