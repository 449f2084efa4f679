"""Comparison with the published study that a scene names: a summary, and behind it every statement."""

from __future__ import annotations

from collections import Counter
from html import escape
from itertools import groupby

from semiwear.references import stated_names
from semiwear.report.comparison import Compared, Comparison, Verdict, compare
from semiwear.report.contents import ReportData
from semiwear.report.markup import badge, counts, element, verdict_class
from semiwear.report.pictures import PICTURES
from semiwear.report.trends import RULES
from semiwear.results.wearing import pitch_name

_WORDS = {Verdict.AGREE: "agree", Verdict.DISAGREE: "disagree", Verdict.NOT_COMPARED: "could not be compared"}


def verdicts_section(data: ReportData) -> str:
    """Statements of the study, folded away behind their count; empty where the scene names none."""
    reference = data.scene.get("reference")
    if reference not in stated_names():
        return ""
    found = compare(reference, data.tree, data.scene)
    summary = f"{_counted(found)} Every statement, with its rule and this result's values"
    return f"<details><summary>{escape(summary)}</summary>{_rules(found)}{_statements(data, found)}</details>"


def _counted(found: Comparison) -> str:
    number = Counter(entry.verdict for entry in found.statements)
    parts = [f"{number[verdict]} {words}" for verdict, words in _WORDS.items() if number[verdict]]
    return f"Of {len(found.statements)} statements of “{found.title}”, {', '.join(parts)}."


def _rules(found: Comparison) -> str:
    badges = counts((entry.verdict for entry in found.statements), Verdict)
    rules = "".join(f"<dt>{escape(name)}</dt><dd>{escape(rule)}.</dd>" for name, rule in RULES.items())
    return f"<p>Each verdict is computed from this result by the rule beside it.</p>{badges}<dl>{rules}</dl>"


def _statements(data: ReportData, found: Comparison) -> str:
    titles = {picture.name: picture.title for picture in PICTURES}
    order = list(titles)
    by_picture = groupby(
        sorted(found.statements, key=lambda entry: order.index(entry.picture)), lambda entry: entry.picture
    )
    parts = []
    for name, entries in by_picture:
        title = titles[name].format(body="gear", pitch=pitch_name(data.tree))
        parts.append(f"<h3>To the picture “{escape(title)}”</h3>" + "".join(map(_comparison, entries)))
    return element("div", "".join(parts), class_="paper")


def _comparison(entry: Compared) -> str:
    why = f"<dt>Why</dt><dd>{escape(entry.why)}</dd>" if entry.why else ""
    return (
        f'<div class="comparison {verdict_class(entry.verdict)}"><p class="verdict">{badge(entry.verdict)}</p><dl>'
        f"<dt>Paper</dt><dd>{escape(entry.statement)}</dd><dt>Here</dt><dd>{escape(entry.ours)}</dd>{why}"
        f'<dt class="rule">Rule</dt><dd class="rule">{escape(entry.rule)}</dd></dl></div>'
    )
