"""Why two results differ: sentences that follow from the differences, a paragraph a kind.

What a fidelity does is stated; whether it shows is said only where the numbers do.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from semiwear.plot.flank_places import Place
from semiwear.plot.two_results import TwoResults
from semiwear.report.differences import Difference, Kind, Mark, shares
from semiwear.report.markup import figure_text

TAKES_MORE = 0.005
"""An edge takes more load where the pair's load share is greater by this."""

RELIEVES = 0.01
"""Share by which the greatest pressure beside has to be lower to count as relieved."""

PEAK = 2.0
"""The greatest line load is a peak of one slice where it is more than so many times the loads beside it."""

_SAME_DEPTH = 0.005
_FIDELITIES = {"line", "patch"}


def reason(kind: Kind, rows: Sequence[Difference], results: TwoResults, alike: bool) -> str:
    """The paragraph below the table of a kind; empty where nothing of it was compared.

    Where the scenes are not `alike` but for the fidelity, what is due to it cannot be told apart and is not told.
    """
    compared = [row for row in rows if row.kind is kind and row.mark is not Mark.NOT_COMPARED]
    if not compared:
        return ""
    of_fidelity = alike and set(results.names) == _FIDELITIES
    sentences = _WORDS[kind](compared, results, of_fidelity)
    if not of_fidelity and any(row.mark is Mark.DIFFER for row in compared):
        sentences.append("The scenes differ in more than the fidelity, or not in it: look for the reason there.")
    return " ".join(sentence for sentence in sentences if sentence)


def _pressure(rows: list[Difference], results: TwoResults, of_fidelity: bool) -> list[str]:
    inside = [row for row in rows if not row.border]
    border = [row for row in rows if row.border]
    sentences = [f"Away from borders the pressures {_agreement(inside)}."] if inside else []
    if of_fidelity and inside:
        sentences.append(_why_inside(inside))
    if border:
        sentences.append(_border_pressure(border, results))
    if of_fidelity and border:
        sentences += [_WHAT_EDGES_ARE, _edge_takes_load(results)]
    return sentences


_WHAT_EDGES_ARE = (
    "`line` lets an edge's rounding be the curvature in Hertz's law, slice by slice, and spreads the load of a slice "
    "over a footprint; where flanks are worn it solves the slice as a plane. `patch` resolves the pressure that "
    "leans on the rounding in both directions. Either way the raw pressure at an edge depends on the size of cells "
    "and slices: read its course, not its value."
)


def _why_inside(inside: list[Difference]) -> str:
    fresh = [row for row in inside if row.when != "last" and row.mark is Mark.DIFFER]
    worn = [row for row in inside if row.when == "last" and row.mark is Mark.DIFFER]
    if fresh:
        return (
            "Both fidelities solve the same problem there, so before any wear a difference comes from the resolution "
            "or from the load that the borders take."
        )
    if worn:
        return (
            "Both solve the same problem there and begin alike: what differs comes with wear, from the load that "
            "the borders take and from flanks that have worn differently."
        )
    return "Both solve the same problem there."


def _border_pressure(border: list[Difference], results: TwoResults) -> str:
    parts = []
    for row in border:
        ratio = f", {row.this / row.other:.2g} times" if row.other > 0.0 else ""
        parts.append(f"{row.value_text(row.this)} against {row.value_text(row.other)} ({_when(row)}{ratio})")
    words = "agree" if all(row.mark is Mark.AGREE for row in border) else "differ"
    return f"At tips, ends and corners `{results.names[0]}` and `{results.names[1]}` {words}: {'; '.join(parts)}."


@dataclass(frozen=True)
class _Edge:
    """Sentence about the last common wear step where the edges press hardest in `patch`."""

    facts: str
    takes_more: bool
    relieves: bool


def _edge(results: TwoResults) -> _Edge | None:
    """Load and pressure where edges press hardest; None for other fidelities and where nothing can be told."""
    names = ("load_share", "contact_pressure_max", "contact_pressure_max_edge")
    if set(results.names) != _FIDELITIES or not all(results.have("engagement", name) for name in names):
        return None
    step = results.steps[-1]
    values = {name: results.values("engagement", name, step) for name in names}
    rolls = results.labels("engagement", "roll_position")
    patch = results.names.index("patch")
    line = 1 - patch
    at = float(rolls[patch][int(values["contact_pressure_max_edge"][patch].argmax())])
    share, beside = (
        [float(np.interp(at, roll, np.nan_to_num(curve))) for roll, curve in zip(rolls, values[name], strict=True)]
        for name in names[:2]
    )
    facts = (
        f"Where the edge pressure of `patch` is greatest, at roll position {at:+.2f}, the tooth pair takes "
        f"{share[patch]:.3f} of the load in `patch` and {share[line]:.3f} in `line`, and the greatest pressure "
        f"beside the borders is {beside[patch]:.0f} and {beside[line]:.0f} MPa: "
    ).replace("-", "−")
    more = share[patch] - share[line] >= TAKES_MORE
    return _Edge(facts, more, beside[patch] <= (1.0 - RELIEVES) * beside[line])


def _edge_takes_load(results: TwoResults) -> str:
    """Whether `patch` lets the edge take more load, from the numbers."""
    edge = _edge(results)
    if edge is None:
        return ""
    if edge.takes_more and edge.relieves:
        return edge.facts + "`patch` lets the edge take more load and relieves the slices beside it."
    if edge.takes_more:
        return edge.facts + "`patch` lets the edge take more load, but does not relieve what lies beside it."
    if edge.relieves:
        return edge.facts + "`patch` relieves what lies beside the edge, but the pair takes hardly more load."
    return edge.facts + "no shift of load to the edge shows there."


def _wear(rows: list[Difference], results: TwoResults, of_fidelity: bool) -> list[str]:
    sentences = []
    for body in dict.fromkeys(row.body for row in rows if row.body):
        sentences += _wear_of([row for row in rows if row.body == body], body)
    border = [row for row in rows if row.border]
    edge = _edge(results) if of_fidelity and any(row.mark is Mark.DIFFER for row in border) else None
    if edge and (edge.takes_more or edge.relieves):
        sentences.append(
            "Wear follows load, which the two share differently between an edge and the flank beside it (above), and "
            "each wear step builds on the last."
        )
    return [*sentences, _engagements(rows)]


def _wear_of(rows: list[Difference], body: str) -> list[str]:
    """How the wear of one body compares: the greatest depths, then its maps place by place."""
    greatest = [row for row in rows if row.place is None]
    inside = [row for row in rows if row.place is Place.INSIDE]
    sentences = [f"Greatest depths of the {body} {_agreement(greatest)}."] if greatest else []
    if inside:
        sentences.append(f"Away from borders the maps of the {body} {_agreement(inside)} of the greatest wear.")
    for mark, verb in ((Mark.DIFFER, "differ"), (Mark.AGREE, "agree")):
        parts = [
            f"{row.place.value} ({row.text.split(' of ')[0]})"
            for row in rows
            if row.border and row.place and row.mark is mark
        ]
        if parts:
            sentences.append(f"They {verb} {', '.join(parts)}.")
    return sentences


def _engagements(rows: list[Difference]) -> str:
    """That the same wear at the control point took other numbers of engagements."""
    meshes = [row for row in rows if row.units == "1"]
    control = [row for row in rows if row.where == "control point" and abs(row.size) <= _SAME_DEPTH]
    if not (meshes and control) or meshes[0].this == meshes[0].other:
        return ""
    (row,) = meshes[:1]
    return (
        f"The states compared have the same wear at the control point, reached in {figure_text(row.this)} and "
        f"{figure_text(row.other)} engagements ({row.text})."
    )


def _load(rows: list[Difference], results: TwoResults, of_fidelity: bool) -> list[str]:
    share = [row for row in rows if not row.scale and row.units == "1"]
    sentences = []
    if share:
        most = max(share, key=lambda row: abs(row.size))
        words = "agree" if all(row.mark is Mark.AGREE for row in share) else "differ"
        sentences.append(
            f"Load shares {words}; the greatest difference is {most.text} at {most.where} ({_when(most)})."
        )
        sentences.append(_edge_at(most, results))
    line = [row for row in rows if row.units == "N/mm"]
    if line:
        sentences.append(f"Greatest line loads {_agreement(line)}.")
        if any(row.mark is Mark.DIFFER for row in line):
            sentences.append(_peaks(results))
    return sentences


def _peaks(results: TwoResults) -> str:
    """Whether the greatest line load is a peak of one slice, which the slices decide."""
    found = []
    for name, loads in zip(results.names, results.values("engagement", "line_load", results.steps[-1]), strict=True):
        roll, face = np.unravel_index(int(loads.argmax()), loads.shape)
        beside = [float(loads[roll, k]) for k in (face - 1, face + 1) if 0 <= k < loads.shape[1]]
        if beside and max(beside) < loads[roll, face] / PEAK:
            around = " and ".join(figure_text(load, 3) for load in beside)
            found.append(f"in `{name}` {figure_text(float(loads[roll, face]), 3)} N/mm beside {around} N/mm")
    if not found:
        return ""
    return f"Worn, the greatest line load stands alone on a slice ({'; '.join(found)}), so that the slices decide it."


def _edge_at(row: Difference, results: TwoResults) -> str:
    """Whether edges press where the load shares differ most."""
    names = ("contact_pressure_max", "contact_pressure_max_edge")
    if not all(results.have("engagement", name) for name in names):
        return ""
    step = results.steps[-1] if row.when == "last" else results.steps[0]
    roll, this, other = shares(results, step)
    at = roll[int(np.abs(this - other).argmax())]
    rolls = results.labels("engagement", "roll_position")
    inside, edge = (
        max(
            np.interp(at, own, np.nan_to_num(curve))
            for own, curve in zip(rolls, results.values("engagement", name, step), strict=True)
        )
        for name in names
    )
    if edge > inside:
        return "There an edge presses harder than the flank beside it."
    return "There no edge presses harder than the flank beside it."


def _root_stress(rows: list[Difference], results: TwoResults, of_fidelity: bool) -> list[str]:
    return [f"Root stresses {_agreement(rows)}.", _same_teeth(rows, of_fidelity)]


def _transmission_error(rows: list[Difference], results: TwoResults, of_fidelity: bool) -> list[str]:
    return [f"Mean and amplitude {_agreement(rows)}.", _same_teeth(rows, of_fidelity)]


def _same_teeth(rows: list[Difference], of_fidelity: bool) -> str:
    if not of_fidelity:
        return ""
    fresh = [row for row in rows if row.when != "last"]
    worn = [row for row in rows if row.when == "last"]
    if all(row.mark is Mark.AGREE for row in rows):
        return "Both fidelities bend the same teeth."
    if fresh and worn and all(row.mark is Mark.AGREE for row in fresh):
        return "Both fidelities bend the same teeth and agree unworn; the difference comes with the worn flanks."
    return "Both fidelities bend the same teeth; the difference comes from where on them the load lies."


def _agreement(rows: list[Difference]) -> str:
    """Whether rows agree, and their greatest difference."""
    size = f"{100 * max(abs(row.size) for row in rows):.1f} %"
    count = sum(row.mark is Mark.DIFFER for row in rows)
    if not count:
        return f"agree within {size}"
    return f"differ by up to {size}" + (f" ({count} of {len(rows)} values differ)" if len(rows) > 1 else "")


def _when(row: Difference) -> str:
    return {"last": "last common step"}.get(row.when, row.when)


_WORDS: dict[Kind, Callable[[list[Difference], TwoResults, bool], list[str]]] = {
    Kind.PRESSURE: _pressure,
    Kind.WEAR: _wear,
    Kind.LOAD: _load,
    Kind.ROOT_STRESS: _root_stress,
    Kind.TRANSMISSION_ERROR: _transmission_error,
}
