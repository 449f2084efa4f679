"""Cards with the pictures of a report, by part of the page."""

from __future__ import annotations

from html import escape

from semiwear.report.contents import ReportData
from semiwear.report.markup import card, element
from semiwear.report.pictures import OF_COLOURS, Drawn


def cards_of(data: ReportData, part: str) -> str:
    """Cards of the pictures of a part, those of equal height together; empty without pictures."""
    drawn = [shown for shown in data.pictures if shown.picture.part == part and shown.uri]
    drawn.sort(key=lambda shown: (not shown.picture.both_ends, shown.picture.panels))
    return element("div", "".join(map(card_of, drawn)), class_="cards") if drawn else ""


def card_of(drawn: Drawn) -> str:
    """Card of a picture with its heading, alternative text and caption."""
    picture = drawn.picture
    return card(
        picture.title,
        drawn.uri,
        drawn.alt,
        picture.caption,
        picture.size,
        full=picture.both_ends,
        of_colours=picture.name in OF_COLOURS,
    )


def left_out(data: ReportData) -> str:
    """Titles of the pictures that are left out, each with the reason."""
    reasons = "".join(
        f"<li>{escape(drawn.picture.title)}: {escape(drawn.left_out)}.</li>"
        for drawn in data.pictures
        if drawn.left_out
    )
    return f"<ul>{reasons}</ul>" if reasons else ""
