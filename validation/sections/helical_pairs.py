"""Helical and spur pairs, thin and thick: the core against finite elements with every tooth."""

from __future__ import annotations

from typing import Any

import numpy as np

from semiwear.errors import SemiwearError
from semiwear.meshing.flank_pair import BODIES
from semiwear.report.markup import table
from validation import helical_pairs as store
from validation.charts import COLOURS, MARKERS, card, cards
from validation.helical_pairs import HelicalPair, HelicalResult
from validation.problems import Problems
from validation.progress import Progress
from validation.section import Section
from validation.tables import dataset, failures_note, percent

TITLE = "Helical pairs against finite elements"
TREND_WIDTH = 30.0
"""Face width of the pairs whose mesh stiffness is followed over the helix angle [mm]."""

_Compared = tuple[HelicalPair, HelicalResult, HelicalResult]


def build(problems: Problems, quick: bool, progress: Progress) -> Section:
    """Compare the core, computed afresh, with every stored pair."""
    try:
        stored = store.read()
    except (SemiwearError, FileNotFoundError) as error:
        return Section((f"No stored results: {error}",), "")
    compared: list[_Compared] = []
    failures = []
    for pair in store.PAIRS:
        if pair.name not in stored:
            continue
        progress.note(pair.name)
        try:
            compared.append((pair, store.core_result(pair), stored[pair.name]))
        except SemiwearError as error:
            failures.append(f"{pair.name}: {error}")
    if not compared:
        return Section(("No pair could be compared.",), failures_note(failures))
    error = np.array([_error_ratio(one) for one in compared])
    root = np.array([[_root_ratio(one, body) for body in BODIES] for one in compared])
    worst, lowest = int(np.argmax(np.abs(error - 1.0))), np.unravel_index(np.argmax(np.abs(root - 1.0)), root.shape)
    found = (
        f"Mean loaded transmission error of {len(compared)} pairs: core {percent(float(error.min() - 1.0))} to "
        f"{percent(float(error.max() - 1.0))} off finite elements with every tooth, farthest for "
        f"{_words(compared[worst][0])}.",
        f"Greatest root stress: {percent(float(root.min() - 1.0))} to {percent(float(root.max() - 1.0))} off, "
        f"farthest on the {BODIES[int(lowest[1])]} of {_words(compared[int(lowest[0])][0])}.",
    )
    drawn = [
        card("helical-error", "Transmission error, core over finite elements",
             "1 is agreement; the bodies of thick gears give way as much as their teeth.",
             lambda ax: _over_angle(ax, compared, _error_ratio, "Core / finite elements (1)")),
        card("helical-root", "Greatest root stress, core over finite elements",
             "The larger of pinion and gear by its distance from 1.",
             lambda ax: _over_angle(ax, compared, _farthest_root, "Core / finite elements (1)")),
        card("helical-stiffness", "Mesh stiffness over the helix angle",
             f"Load over mean approach along the transverse line of action, face width {TREND_WIDTH:g} mm, relative "
             "to the spur pair; the single stiffness of ISO 6336-1 falls as the cosine of the helix angle.",
             lambda ax: _trend(ax, compared)),
    ]  # fmt: skip
    return Section(found, failures_note(failures) + _table(compared) + cards(drawn), {"pairs": _data(compared)})


def _words(pair: HelicalPair) -> str:
    inside = "internal, " if pair.gear_teeth < 0 else ""
    return f"{inside}{pair.helix_angle:g} degrees, {pair.face_width:g} mm wide, {pair.bodies} bodies"


def _mean(result: HelicalResult) -> float:
    return float(np.mean(result.transmission_error))


def _error_ratio(one: _Compared) -> float:
    return _mean(one[1]) / _mean(one[2])


def _root_ratio(one: _Compared, body: str) -> float:
    return one[1].root_stress[body] / one[2].root_stress[body]


def _farthest_root(one: _Compared) -> float:
    return max((_root_ratio(one, body) for body in BODIES), key=lambda ratio: abs(ratio - 1.0))


def _over_angle(ax: Any, compared: list[_Compared], value: Any, label: str) -> None:
    kinds = sorted({(pair.face_width, pair.bodies, pair.gear_teeth < 0) for pair, _, _ in compared})
    for k, kind in enumerate(kinds):
        some = [one for one in compared if (one[0].face_width, one[0].bodies, one[0].gear_teeth < 0) == kind]
        some.sort(key=lambda one: one[0].helix_angle)
        text = f"b {kind[0]:g} mm, {kind[1]}" + (", internal" if kind[2] else "")
        ax.plot([one[0].helix_angle for one in some], [value(one) for one in some],
                f"{MARKERS[k % len(MARKERS)]}-", color=COLOURS[k % len(COLOURS)], label=text)  # fmt: skip
    ax.axhline(1.0, color="#888888", linewidth=0.8)
    ax.set_xlabel("Helix angle (deg)")
    ax.set_ylabel(label)
    ax.legend(loc="best")


def _trend(ax: Any, compared: list[_Compared]) -> None:
    colour = 0
    for bodies in ("thin", "thick"):
        some = [
            one
            for one in compared
            if (one[0].bodies, one[0].face_width) == (bodies, TREND_WIDTH) and one[0].gear_teeth > 0
        ]
        some.sort(key=lambda one: one[0].helix_angle)
        if not some or some[0][0].helix_angle > 0.0:
            continue
        angles = [one[0].helix_angle for one in some]
        for side, name, style in ((1, "core", "o-"), (2, "finite elements", "s--")):
            values = np.array([store.mesh_stiffness(one[0], one[side]) for one in some])  # type: ignore[arg-type]
            ax.plot(angles, values / values[0], style, color=COLOURS[colour], label=f"{name}, {bodies}")
        colour += 1
    angles = np.linspace(0.0, 30.0, 61)
    ax.plot(angles, np.cos(np.radians(angles)), ":", color="#000000", label="single stiffness, ISO 6336-1")
    ax.set_xlabel("Helix angle (deg)")
    ax.set_ylabel("Mesh stiffness over the spur pair's (1)")
    ax.legend(loc="best")


def _table(compared: list[_Compared]) -> str:
    head = ["Pair", "TE, core (arcsec)", "TE, FE (arcsec)", "Apart", "Root pinion", "Root gear"]
    rows = [
        [
            _words(pair), f"{_mean(core):.2f}", f"{_mean(judge):.2f}",
            percent(_error_ratio((pair, core, judge)) - 1.0),
            *(percent(_root_ratio((pair, core, judge), body) - 1.0) for body in BODIES),
        ]
        for pair, core, judge in compared
    ]  # fmt: skip
    return table("Core and finite elements with every tooth, stored pairs", head, rows)


def _data(compared: list[_Compared]) -> Any:
    return dataset(
        {"pair": [pair.name for pair, _, _ in compared], "side": ["core", "finite elements"]},
        {
            "transmission_error": (
                [[_mean(core), _mean(judge)] for _, core, judge in compared],
                "arcsec",
                "mean loaded transmission error",
            ),
            **{
                f"root_stress_{body}": (
                    [[core.root_stress[body], judge.root_stress[body]] for _, core, judge in compared], "MPa",
                    f"greatest root stress of the {body}",
                )
                for body in BODIES
            },
        },
    )  # fmt: skip
