"""HTML elements, and numbers as text."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from enum import Enum
from html import escape
from math import isnan

from semiwear.html_text import folded_html
from semiwear.plain_text import power_of_ten, unit_text

NONE = "–"
"""Sign for a missing value."""


def figure_text(value: float, digits: int = 4) -> str:
    """A number with `digits` significant digits; very small and large ones with a power of ten."""
    number = float(value)
    if isnan(number):
        return NONE
    if number == 0:
        return "0"
    if float(number).is_integer() and abs(number) < 1e6:
        return f"{number:.0f}".replace("-", "−")
    # of the rounded number: 9.999 may become 10
    shown_digits = digits if 1e-3 <= abs(number) < 1e6 else digits - 1
    exponent = int(f"{number:.{max(shown_digits - 1, 0)}e}".partition("e")[2])
    if -4 < exponent < 6:
        text = f"{number:#.{digits}g}".rstrip(".") if exponent < digits else f"{number:.0f}"
    else:
        mantissa = f"{number / 10.0**exponent:.{digits - 2}f}"
        text = f"{mantissa}·{power_of_ten(exponent)}"
    return text.replace("-", "−")


def with_unit(value: float, units: str) -> str:
    """A number with its units."""
    return f"{figure_text(value)} {unit_text(units)}".strip()


def element(tag: str, content: str, **attributes: str) -> str:
    """An HTML element; `content` is markup already, attribute values are escaped (``class_`` is class)."""
    names = (name.strip("_").replace("_", "-") for name in attributes)
    written = "".join(f' {name}="{escape(text)}"' for name, text in zip(names, attributes.values(), strict=True))
    return f"<{tag}{written}>{content}</{tag}>"


def folded_toml(text: str) -> str:
    """A TOML text, folded away."""
    return folded_html("TOML", f"<pre>{escape(text)}</pre>")


def card(
    title: str,
    uri: str,
    alt: str,
    caption: str,
    size: tuple[float, float],
    *,
    full: bool = False,
    of_colours: bool = False,
) -> str:
    """A card with a figure and its heading, `full` as wide as the page; other parameters as in `figure`."""
    shown = figure(uri, alt, caption, size, title, of_colours=of_colours)
    return element("article", shown, class_="card full" if full else "card")


def figure(
    uri: str, alt: str, caption: str, size: tuple[float, float], title: str = "", *, of_colours: bool = False
) -> str:
    """A picture with its caption, and with its heading if it has a `title`; `size` is width and height [inch].

    A picture `of_colours` that represent values keeps a light background on a dark page; others are inverted there.
    """
    width, height = (round(side * 100) for side in size)
    kept = ' class="of-colours"' if of_colours else ""
    image = f'<img src="{uri}" alt="{escape(alt)}" width="{width}" height="{height}"{kept}>'
    heading = element("h3", escape(title)) if title else ""
    return f"<figure>{heading}{image}<figcaption>{escape(caption)}</figcaption></figure>"


def tiles(numbers: Iterable[tuple[str, str, str]]) -> str:
    """Numbers side by side, each with its name and a note; empty without numbers."""
    entries = "".join(
        element("li", f"<span>{escape(name)}</span><strong>{escape(value)}</strong><small>{escape(note)}</small>")
        for name, value, note in numbers
    )
    return element("ul", entries, class_="tiles") if entries else ""


# by the names of the members of `Verdict` and `Mark`
_SIGNS = {"AGREE": "✓", "DISAGREE": "✗", "DIFFER": "✗", "NOT_COMPARED": NONE}
_CLASSES = {"AGREE": "agree", "DISAGREE": "disagree", "DIFFER": "disagree", "NOT_COMPARED": "not-compared"}


def verdict_text(verdict: Enum) -> str:
    """A verdict with its sign as text."""
    return f"{_SIGNS[verdict.name]} {verdict.value}"


def verdict_class(verdict: Enum) -> str:
    """CSS class of the elements that show a verdict."""
    return _CLASSES[verdict.name]


def badge(verdict: Enum) -> str:
    """A verdict with its sign, which screen readers skip."""
    return f'<span aria-hidden="true">{_SIGNS[verdict.name]}</span> {verdict.value}'


def counts(verdicts: Iterable[Enum], kinds: Iterable[Enum]) -> str:
    """Number of verdicts of each kind, as a list."""
    found = Counter(verdicts)
    badges = "".join(
        f'<li class="{verdict_class(kind)}"><strong>{found[kind]}</strong> {badge(kind)}</li>'
        for kind in kinds
        if found[kind]
    )
    return f'<ul class="counts">{badges}</ul>'


def code_marked(text: str) -> str:
    """Text as HTML, with the parts between backticks as code."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(text))


def table(caption: str, head: Sequence[str], rows: Iterable[Sequence[str]], marks: Sequence[str] = ()) -> str:
    """A table that scrolls sideways by itself; cells are text, `head` may hold markup.

    `marks` are the CSS classes of the last cells, one for each row.
    """
    heads = "".join(element("th", cell, scope="col") for cell in head)
    lines = "".join(_row(row, marks[k] if marks else "") for k, row in enumerate(rows))
    body = element("caption", escape(caption)) + f"<thead><tr>{heads}</tr></thead><tbody>{lines}</tbody>"
    return element("div", element("table", body), class_="scroll", tabindex="0", role="region", aria_label=caption)


def _row(cells: Sequence[str], mark: str) -> str:
    first, *rest = map(escape, cells)
    *inner, last = (element("td", cell) for cell in rest)
    if mark:
        last = element("td", rest[-1], class_=mark)
    return element("tr", element("th", first, scope="row") + "".join(inner) + last)
