"""Charts of the validation report: inline SVG, drawn small, so that their text can be read on a narrow screen."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Sequence
from html import escape
from typing import Any

import numpy as np

from semiwear.plot.style import styled
from semiwear.report.markup import element

SIZE = (4.9, 3.9)
"""Width and height [inch]: at 358 px, what a narrow screen leaves, its 10 pt text is 10 px high."""

# Okabe and Ito (2008): told apart by colour-blind readers.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")

Draw = Callable[[Any], object]


def svg(name: str, draw: Draw, alt: str, size: tuple[float, float] = SIZE) -> str:
    """A chart as an SVG element.

    Parameters
    ----------
    name : str
        Of the chart, unlike any other on the page: its ids begin with it.
    draw : callable
        Gets the axes.
    alt : str
        The chart in words, for readers who do not see it.
    size : (float, float) [inch]
    """
    with styled():
        import matplotlib
        from matplotlib.figure import Figure

        with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
            figure = Figure(figsize=size, layout="constrained")
            draw(figure.subplots())
            stream = io.StringIO()
            figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.S)
    # ids are unique on the page
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r'(href="#|url\(#)', rf"\g<1>{name}-", text)
    opening, rest = text.split(">", 1)
    opening = re.sub(r' (?:width|height)="[^"]*"', "", opening)
    return f'{opening} role="img" aria-label="{escape(alt)}">{rest.strip()}'


def card(name: str, title: str, caption: str, draw: Draw, alt: str = "", size: tuple[float, float] = SIZE) -> str:
    """A chart with its heading and one sentence on what is seen."""
    picture = svg(name, draw, alt or f"{title}. {caption}", size)
    inside = f"<h3>{escape(title)}</h3>{picture}<figcaption>{escape(caption)}</figcaption>"
    return element("article", element("figure", inside), class_="card")


def cards(items: Sequence[str]) -> str:
    """Cards side by side, under one another on a narrow screen."""
    return element("div", "".join(items), class_="cards charts")


def legend_above(ax: Any, columns: int = 2, **options: Any) -> None:
    """A legend above the axes, where it hides no curve."""
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderaxespad=0.2, **options)


def plain_log(axis: Any, percent: bool = False) -> None:
    """Ticks of a logarithmic axis at round numbers, three of them or more, written as plain numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    low, high = sorted(axis.get_view_interval())
    decades = np.log10(high / low) if low > 0.0 else 1.0
    subs = (1.0, 2.0, 5.0) if decades < 1.5 else (1.0, 3.0) if decades < 3.0 else (1.0,)
    axis.set_major_locator(LogLocator(subs=subs))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:g} %" if percent else f"{value:g}"))


def pareto(cost: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Indices of the points that no other beats in both cost and error, by rising cost."""
    order = np.lexsort((error, cost))
    kept, best = [], np.inf
    for k in order:
        if error[k] < best:
            kept.append(int(k))
            best = float(error[k])
    return np.array(kept, dtype=int)
