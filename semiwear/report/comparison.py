"""Comparison of a result with the statements of a published study; all verdicts are computed.

Statements and their rules of agreement are data (`semiwear.references.load_statements`); the quantities that they
name are those of `semiwear.report.measures`.
"""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from string import Formatter

import numpy as np
import xarray as xr

from semiwear.references import load_reference, load_statements
from semiwear.report.evidence import Evidence, NotComparable
from semiwear.report.markup import figure_text
from semiwear.report.measures import MEASURES
from semiwear.report.trends import LEVEL_SHARE, Trend, falls, levels, rises
from semiwear.untyped import Table

_IS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}


class Verdict(Enum):
    """Whether a result agrees with a published statement."""

    AGREE = "AGREE"
    DISAGREE = "DISAGREE"
    NOT_COMPARED = "NOT COMPARED"


@dataclass(frozen=True)
class Compared:
    """A published statement, compared.

    Attributes
    ----------
    picture : str
        Picture to which it belongs, a name in `semiwear.plot`.
    statement : str
        What was published.
    rule : str
        Condition under which a result agrees.
    verdict : Verdict
    ours : str
        The result's values.
    why : str
        Explanation of a disagreement; empty otherwise.
    """

    picture: str
    statement: str
    rule: str
    verdict: Verdict
    ours: str
    why: str


@dataclass(frozen=True)
class Comparison:
    """A result compared with a study.

    Attributes
    ----------
    title : str
        Of the study.
    statements : tuple of Compared
        In the order in which they are declared.
    """

    title: str
    statements: tuple[Compared, ...]


def compare(reference: str, tree: xr.DataTree, scene: Table) -> Comparison:
    """Compare a result with all statements of a published study.

    Parameters
    ----------
    reference : str
        Name of the study, see `load_reference`.
    tree : DataTree
        A result.
    scene : mapping
        Tables of its scene.
    """
    stated = load_statements(reference)
    evidence = Evidence(tree, load_reference(reference), scene)
    return Comparison(
        stated["title"], tuple(_compared(statement, evidence, stated) for statement in stated["statement"])
    )


def _compared(statement: Table, evidence: Evidence, stated: Table) -> Compared:
    templates = _Templates(evidence, {**stated, **statement})
    published, rule = templates.format(statement["published"]), templates.format(_rule(statement))
    why = ""
    try:
        agrees, ours = _judged(statement, evidence, templates)
        verdict = Verdict.AGREE if agrees else Verdict.DISAGREE
        if not agrees:
            why = " ".join(templates.sentences(statement["why"]))
    except NotComparable as reason:
        verdict, ours = Verdict.NOT_COMPARED, f"Not compared: {reason}."
    return Compared(statement["picture"], published, rule, verdict, ours, why)


def _rule(statement: Table) -> str:
    if "number" in statement:
        return f"Agrees within {statement['number']['within']:.0%}."
    if "course" not in statement:
        return str(statement["rule"])
    course = statement["course"]
    if "turn_um" in course:
        return (
            f"Agrees if it rises up to {course['turn_um']:g} µm at the control point and from there changes by less "
            f"than {LEVEL_SHARE:.0%} of its range."
        )
    series = "its absolute value" if course.get("size") else "it"
    return f"Agrees if {series} {' and '.join(course['does'])}."


def _judged(statement: Table, evidence: Evidence, templates: _Templates) -> tuple[bool, str]:
    """Whether a result agrees with a statement, and its values as text."""
    if "number" in statement:
        number = statement["number"]
        published, value = (templates.number(number[name]) for name in ("published", "of"))
        deviation = value / published - 1.0
        return abs(deviation) <= number["within"], f"{figure_text(value)} {number['units']} ({deviation:+.1%})"
    if "course" in statement:
        trends = _trends(statement["course"], evidence)
        return all(trend.holds for trend in trends), "; ".join(trend.text for trend in trends)
    return all(map(templates.holds, statement["holds"])), templates.format(statement["ours"])


def _trends(course: Table, evidence: Evidence) -> list[Trend]:
    history, units = evidence.history(course["of"], course.get("body")), course.get("units", "")
    if "turn_um" in course:
        turn = float(course["turn_um"])
        before = rises(evidence.until(history, turn), units)
        return [Trend(before.holds, f"up to {turn:g} µm: {before.text}"), _level_after(evidence, history, turn)]
    if course.get("size"):
        history = np.abs(history)
    kinds = {"rises": lambda: rises(history, units), "falls": lambda: falls(history, units),
             "levels": lambda: levels(evidence.meshes, history)}  # fmt: skip
    return [kinds[name]() for name in course["does"]]


def _level_after(evidence: Evidence, history: np.ndarray, turn: float) -> Trend:
    begin, end = (evidence.at_depth(history, depth) for depth in (turn, evidence.last_depth))
    spread = float(np.ptp(history))
    change = (end - begin) / spread if spread > 0 else 0.0
    text = f"from {turn:g} to {evidence.last_depth:g} µm it changes by {change:+.0%} of its whole range"
    return Trend(abs(change) < LEVEL_SHARE, text)


class _Templates(Formatter):
    """Fills templates with the fields of a study and of a statement, and with the values of `MEASURES`.

    The format ``:fig3`` gives three significant digits; negative numbers have a minus sign, not a hyphen.
    """

    def __init__(self, evidence: Evidence, fields: Table):
        self._evidence, self._fields = evidence, {**evidence.paper, **fields}

    def get_value(self, key: int | str, args: Sequence[object], kwargs: Mapping[str, object]) -> object:
        name = str(key)
        return MEASURES[name](self._evidence) if name in MEASURES else self._fields[name]

    def format_field(self, value: object, format_spec: str) -> str:
        if format_spec.startswith("fig") and isinstance(value, int | float):
            return figure_text(value, int(format_spec[3:]))
        text = str(super().format_field(value, format_spec))
        return text if isinstance(value, str) else text.replace("-", "−")

    def number(self, text: str) -> float:
        """The number in a text, or the value of the name in it."""
        try:
            return float(text)
        except ValueError:
            return float(self.get_field(text, (), {})[0])

    def holds(self, comparison: str) -> bool:
        """Whether a comparison of two numbers or names, such as ``a < b``, holds."""
        left, sign, right = comparison.split()
        return bool(_IS[sign](self.number(left), self.number(right)))

    def sentences(self, templates: list[str]) -> Iterator[str]:
        """Sentences of an explanation, without those whose values the result does not hold."""
        for template in templates:
            try:
                yield self.format(template)
            except NotComparable:
                continue
