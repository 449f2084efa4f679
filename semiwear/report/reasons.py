"""Why two results differ: sentences that follow from the differences, one paragraph for each kind.

How a fidelity works is always stated; an effect of it only if the numbers show it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from semiwear.plot.flank_regions import Region
from semiwear.plot.two_results import TwoResults
from semiwear.report.differences import Difference, Kind, Mark, shares
from semiwear.report.markup import figure_text

TAKES_MORE = 0.005
"""Least difference of load shares from which an edge counts as carrying more load."""

RELIEVES = 0.01
"""Least relative reduction of the greatest pressure beside an edge that counts as relief."""

PEAK = 2.0
"""The greatest line load is a peak of one slice if it is more than this multiple of the loads beside it."""

_SAME_DEPTH = 0.005
_FIDELITIES = {"line", "patch"}


def reason(kind: Kind, rows: Sequence[Difference], results: TwoResults, alike: bool) -> str:
    """The paragraph below the table of a kind; empty if none of its values was compared.

    Effects of the fidelity are stated only if the scenes are `alike` in everything else.
    """
    compared = [row for row in rows if row.kind is kind and row.mark is not Mark.NOT_COMPARED]
    if not compared:
        return ""
    of_fidelity = alike and set(results.names) == _FIDELITIES
    sentences = _SENTENCES[kind](compared, results, of_fidelity)
    if not of_fidelity and any(row.mark is Mark.DIFFER for row in compared):
        sentences.append("The results do not differ by the fidelity alone: look for the reason in the scenes.")
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
        sentences += [_EDGE_MODELS, _edge_takes_load(results)]
    return sentences


_EDGE_MODELS = (
    "`line` uses an edge's rounding as the curvature in Hertz's law, slice by slice, and spreads the load of a slice "
    "over a footprint; on worn flanks it solves the slice as a plane problem. `patch` resolves the pressure on the "
    "rounding in both directions. In both, the pressure at an edge depends on the size of cells and slices: its "
    "trend is meaningful, its value is not."
)


def _why_inside(inside: list[Difference]) -> str:
    fresh = [row for row in inside if row.when != "last" and row.mark is Mark.DIFFER]
    worn = [row for row in inside if row.when == "last" and row.mark is Mark.DIFFER]
    if fresh:
        return (
            "Both fidelities solve the same problem there, so a difference before any wear comes from the resolution "
            "or from the load that the borders carry."
        )
    if worn:
        return (
            "Both fidelities solve the same problem there and agree unworn: the difference arises with wear, from "
            "the load that the borders carry and from flanks that have worn differently."
        )
    return "Both fidelities solve the same problem there."


def _border_pressure(border: list[Difference], results: TwoResults) -> str:
    parts = []
    for row in border:
        ratio = f", {row.this / row.other:.2g} times" if row.other > 0.0 else ""
        parts.append(f"{row.value_text(row.this)} against {row.value_text(row.other)} ({_when(row)}{ratio})")
    words = "agree" if all(row.mark is Mark.AGREE for row in border) else "differ"
    return f"At tips, ends and corners `{results.names[0]}` and `{results.names[1]}` {words}: {'; '.join(parts)}."


@dataclass(frozen=True)
class _Edge:
    """Load and pressure at the last common wear step where the edge pressure of `patch` is greatest."""

    facts: str
    more_load: bool
    relieves: bool


def _edge(results: TwoResults) -> _Edge | None:
    """Load and pressure where the edge pressure is greatest; None for other fidelities or without these variables."""
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
        f"Where the edge pressure of `patch` is greatest, at roll position {at:+.2f}, the tooth pair carries "
        f"{share[patch]:.3f} of the load in `patch` and {share[line]:.3f} in `line`, and the greatest pressure "
        f"beside the borders is {beside[patch]:.0f} and {beside[line]:.0f} MPa: "
    ).replace("-", "−")
    more_load = share[patch] - share[line] >= TAKES_MORE
    return _Edge(facts, more_load, beside[patch] <= (1.0 - RELIEVES) * beside[line])


def _edge_takes_load(results: TwoResults) -> str:
    """Sentence on whether the edge carries more load in `patch`."""
    edge = _edge(results)
    if edge is None:
        return ""
    if edge.more_load and edge.relieves:
        return edge.facts + "in `patch` the edge carries more load and relieves the slices beside it."
    if edge.more_load:
        return edge.facts + "in `patch` the edge carries more load, but does not relieve the slices beside it."
    if edge.relieves:
        return edge.facts + "`patch` relieves the slices beside the edge, but the pair carries hardly more load."
    return edge.facts + "no shift of load to the edge is visible there."


def _wear(rows: list[Difference], results: TwoResults, of_fidelity: bool) -> list[str]:
    sentences = []
    for body in dict.fromkeys(row.body for row in rows if row.body):
        sentences += _wear_of([row for row in rows if row.body == body], body)
    border = [row for row in rows if row.border]
    edge = _edge(results) if of_fidelity and any(row.mark is Mark.DIFFER for row in border) else None
    if edge and (edge.more_load or edge.relieves):
        sentences.append(
            "Wear follows the load, which the two fidelities distribute differently between an edge and the flank "
            "beside it (see above), and the differences accumulate over the wear steps."
        )
    return [*sentences, _engagements(rows)]


def _wear_of(rows: list[Difference], body: str) -> list[str]:
    """Sentences on the wear of one body: its greatest depths, then its maps, region by region."""
    greatest = [row for row in rows if row.region is None]
    inside = [row for row in rows if row.region is Region.INSIDE]
    sentences = [f"Greatest depths of the {body} {_agreement(greatest)}."] if greatest else []
    if inside:
        sentences.append(f"Away from borders the maps of the {body} {_agreement(inside)} of the greatest wear.")
    for mark, verb in ((Mark.DIFFER, "differ"), (Mark.AGREE, "agree")):
        parts = [
            f"{row.region.value} ({row.text.split(' of ')[0]})"
            for row in rows
            if row.border and row.region and row.mark is mark
        ]
        if parts:
            sentences.append(f"They {verb} {', '.join(parts)}.")
    return sentences


def _engagements(rows: list[Difference]) -> str:
    """Sentence on different numbers of engagements for the same wear at the control point."""
    meshes = [row for row in rows if row.units == "1"]
    control = [row for row in rows if row.where == "control point" and abs(row.size) <= _SAME_DEPTH]
    if not (meshes and control) or meshes[0].this == meshes[0].other:
        return ""
    row = meshes[0]
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
    """Sentence on the greatest line load if it is a peak of one slice and so depends on their number."""
    found = []
    for name, loads in zip(results.names, results.values("engagement", "line_load", results.steps[-1]), strict=True):
        roll, face = np.unravel_index(int(loads.argmax()), loads.shape)
        beside = [float(loads[roll, k]) for k in (face - 1, face + 1) if 0 <= k < loads.shape[1]]
        if beside and max(beside) < loads[roll, face] / PEAK:
            around = " and ".join(figure_text(load, 3) for load in beside)
            found.append(f"in `{name}` {figure_text(float(loads[roll, face]), 3)} N/mm beside {around} N/mm")
    if not found:
        return ""
    return f"Worn, the greatest line load is a peak of one slice ({'; '.join(found)}), so it depends on the slices."


def _edge_at(row: Difference, results: TwoResults) -> str:
    """Sentence on the pressure at edges where the load shares differ most."""
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
        return "There the pressure at an edge is higher than on the flank beside it."
    return "There the pressure at no edge is higher than on the flank beside it."


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
        return "Both fidelities use the same tooth compliance."
    if fresh and worn and all(row.mark is Mark.AGREE for row in fresh):
        return "Both fidelities use the same tooth compliance and agree unworn; the difference arises with wear."
    return "Both fidelities use the same tooth compliance; the difference comes from where the load acts on them."


def _agreement(rows: list[Difference]) -> str:
    """Whether rows agree, and their greatest difference."""
    size = f"{100 * max(abs(row.size) for row in rows):.1f} %"
    count = sum(row.mark is Mark.DIFFER for row in rows)
    if not count:
        return f"agree within {size}"
    return f"differ by up to {size}" + (f" ({count} of {len(rows)} values differ)" if len(rows) > 1 else "")


def _when(row: Difference) -> str:
    return {"last": "last common step"}.get(row.when, row.when)


_SENTENCES: dict[Kind, Callable[[list[Difference], TwoResults, bool], list[str]]] = {
    Kind.PRESSURE: _pressure,
    Kind.WEAR: _wear,
    Kind.LOAD: _load,
    Kind.ROOT_STRESS: _root_stress,
    Kind.TRANSMISSION_ERROR: _transmission_error,
}
