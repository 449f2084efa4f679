"""The first screen of a report: the worn flank, and the main numbers with their meaning."""

from __future__ import annotations

from semiwear.report.contents import ReportData
from semiwear.report.markup import element
from semiwear.report.numbers import advice, main_numbers, other_numbers
from semiwear.report.picture_cards import card_of
from semiwear.report.turning import TURNING_EXTRA, can_turn, turning_flanks


def result_section(data: ReportData) -> str:
    """The worn flank beside the main numbers, then advice and further numbers."""
    still = "".join(card_of(drawn) for drawn in data.pictures if drawn.picture.part == "first" and drawn.uri)
    turning = turning_flanks(data.for_pictures)
    note = ""
    if still and not can_turn():
        install = element("code", f"pip install 'semiwear[{TURNING_EXTRA}]'")
        note = element("p", f"With {install} the worn flank can be turned in three dimensions.", class_="hint")
    flank = turning + (element("div", still, class_="still") if still else "") + note
    flank = element("div", flank, class_="worn") if flank else ""
    return f'<div class="first">{flank}{main_numbers(data.tree)}</div>{advice(data.tree)}{other_numbers(data.tree)}'
