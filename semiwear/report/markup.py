"""Pieces of HTML and numbers as text."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape
from math import isnan

__all__ = ["NONE", "code_marked", "element", "figure_text", "table", "unit_text"]

_SUPERSCRIPT = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_UNITS = {"um": "µm", "1": "", "deg": "°", "degC": "°C"}


def unit_text(units: str) -> str:
    """Units as a reader writes them."""
    return _UNITS.get(units, units)


NONE = "–"
"""Sign for a value that is missing."""


def figure_text(value: float, digits: int = 4) -> str:
    """A number with so many significant digits, powers of ten written out."""
    number = float(value)
    if isnan(number):
        return NONE
    if number == 0:
        return "0"
    if float(number).is_integer() and abs(number) < 1e6:
        return f"{number:.0f}".replace("-", "−")
    # of the number as it is shown: 9.999 may be written as 10
    shown_digits = digits if 1e-3 <= abs(number) < 1e6 else digits - 1
    exponent = int(f"{number:.{max(shown_digits - 1, 0)}e}".partition("e")[2])
    if -4 < exponent < 6:
        text = f"{number:#.{digits}g}".rstrip(".") if exponent < digits else f"{number:.0f}"
    else:
        mantissa = f"{number / 10.0**exponent:.{digits - 2}f}"
        text = f"{mantissa}·10{str(exponent).translate(_SUPERSCRIPT)}"
    return text.replace("-", "−")


def element(tag: str, content: str, **attributes: str) -> str:
    """An HTML element; `content` is markup already, attribute values are escaped (``class_`` is class)."""
    names = (name.strip("_").replace("_", "-") for name in attributes)
    written = "".join(f' {name}="{escape(text)}"' for name, text in zip(names, attributes.values(), strict=True))
    return f"<{tag}{written}>{content}</{tag}>"


def code_marked(text: str) -> str:
    """Text as HTML, what stands between backticks as code."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(text))


def table(caption: str, head: Sequence[str], rows: Iterable[Sequence[str]], marks: Sequence[str] = ()) -> str:
    """A table that scrolls sideways on its own; cells are text, `head` may hold markup.

    `marks`, one a row, are classes of the last cells.
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
