"""Pictures of a report on cards, by the part of the page in which they stand."""

from __future__ import annotations

from html import escape

from semiwear.report.markup import card, element
from semiwear.report.pictures import OF_COLOURS, Drawn
from semiwear.report.told import Told


def cards_of(told: Told, part: str) -> str:
    """Cards of the pictures of a part, those of one height together; empty without any."""
    drawn = [one for one in told.drawn if one.picture.part == part and one.uri]
    drawn.sort(key=lambda one: (not one.picture.both_ends, one.picture.panels))
    return element("div", "".join(map(card_of, drawn)), class_="cards") if drawn else ""


def card_of(drawn: Drawn) -> str:
    """One picture with its heading, words for those who do not see it, and caption."""
    shown = drawn.picture
    in_colours = shown.name in OF_COLOURS
    return card(
        shown.title, drawn.uri, drawn.alt, shown.caption, shown.size, full=shown.both_ends, of_colours=in_colours
    )


def left_out(told: Told) -> str:
    """Pictures that are left out, each with its reason."""
    reasons = "".join(
        f"<li>{escape(one.picture.title)}: {escape(one.left_out)}.</li>" for one in told.drawn if one.left_out
    )
    return f"<ul>{reasons}</ul>" if reasons else ""
