"""Tables of the core against stored finite elements, the core computed afresh."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import semiwear as sw
from validation.finite_elements import CASES, SCENE, Row, compare
from validation.sections.finite_elements import BEARS, NAMES, summary

_FIGURES = {
    "contact_pressure_max": "greatest pressure",
    "load_share": "load share",
    "root_stress pinion": "root stress, pinion",
    "root_stress gear": "root stress, gear",
    "transmission_error_loaded, mean": "transmission error, mean",
    "mean wear, core in 8 step(s)": "mean wear",
    "greatest wear, core in 8 step(s)": "greatest wear",
    "correlation, core in 8 step(s)": "correlation of the wear maps",
}
_PATCH = ("unworn", "worn")


def finite_elements_text() -> str:
    """A table for each fidelity: where a figure is greatest, and where the two are farthest apart."""
    scene = sw.load_scene(SCENE)
    text = [
        "Each figure where finite elements find its greatest value, and the difference where the two are farthest",
        f"apart; tooth pairs count that bear more than {100 * BEARS:g} % of the load.",
        "",
    ]
    for fidelity, cases in (("line", CASES), ("patch", _PATCH)):
        text += [f"### Fidelity `{fidelity}`", "", *_table(scene, fidelity, cases), ""]
    return "\n".join(text)


def _table(scene: sw.Scene, fidelity: str, cases: Sequence[str]) -> Iterator[str]:
    yield "| flank | figure | core | finite elements | difference | farthest apart | where |"
    yield "|---|---|---|---|---|---|---|"
    for case in cases:
        found = summary(compare(case, scene, fidelity))
        for name, title in _FIGURES.items():
            if one := found.get(name):
                most, worst, unit = one.greatest, one.farthest, _unit(one.greatest)
                cells = f"{most.core:.4g}{unit} | {most.reference:.4g}{unit} | {_apart(most)} | {_apart(worst)}"
                yield f"| {NAMES[case]} | {title} | {cells} | {worst.where} |"


def _unit(row: Row) -> str:
    return "" if row.units == "1" else f" {row.units}"


def _apart(row: Row) -> str:
    return f"{row.difference:+.3f}" if row.units == "1" else f"{100 * row.difference:+.1f} %"
