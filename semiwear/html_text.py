"""Tables in HTML, as notebooks show them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

_CELL = "text-align:left;vertical-align:top"


def html_table(head: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "") -> str:
    """A table; every text is escaped."""
    above = f'<caption style="text-align:left;font-weight:bold">{escape(caption)}</caption>' if caption else ""
    first = "".join(f'<th scope="col" style="{_CELL}">{escape(text)}</th>' for text in head)
    body = "".join(
        "<tr>" + "".join(f'<td style="{_CELL}">{escape(text)}</td>' for text in row) + "</tr>" for row in rows
    )
    return f"<table>{above}<thead><tr>{first}</tr></thead><tbody>{body}</tbody></table>"


def folded_html(title: str, content: str) -> str:
    """HTML that is collapsed to its title."""
    return f"<details><summary>{escape(title)}</summary>{content}</details>"
