"""The core against finite elements: stored results, refused where they are of another scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.errors import SemiwearError
from semiwear.report.markup import element, table
from validation import finite_elements as store
from validation.charts import COLOURS, Draw, card, cards
from validation.finite_elements import LIMITS, Row
from validation.problems import Problems
from validation.progress import Progress
from validation.section import Section
from validation.tables import dataset, percent, text_table, with_unit

TITLE = "Core against finite elements"
BEARS = 0.1
"""Share of the load from which a tooth pair counts."""
PRESSURE = "contact_pressure_max"
NOTHING = 0.01
"""Arcsec: transmission errors below are rounding."""

NAMES = {
    "unworn": "unworn, one mesh cycle",
    "worn": "worn to the last control depth",
    "moved_nodes": "worn, by nodes really moved",
    "finer": "worn, with more elements",
    "misaligned": "shaft angle 1 mrad off",
    "coast": "coast flank",
    "wear_cycle": "some micrometres of wear from the fresh flank",
}


@dataclass(frozen=True)
class Case:
    """A stored case.

    Attributes
    ----------
    name : str
    tree : DataTree or None
        None where it is refused or missing.
    refusal : str
        Why; empty otherwise.
    rows : mapping of str to list of Row
        Comparisons by fidelity of the core.
    failures : mapping of str to str
        Why the core could not be compared, by fidelity.
    """

    name: str
    tree: xr.DataTree | None
    refusal: str = ""
    rows: Mapping[str, list[Row]] = field(default_factory=dict)
    failures: Mapping[str, str] = field(default_factory=dict)

    def attribute(self, name: str) -> str:
        """Of the stored result."""
        return "" if self.tree is None else str(self.tree.attrs.get(name, ""))


def build(problems: Problems, quick: bool, progress: Progress) -> Section:
    """Compare the core, computed afresh, with every stored case."""
    scene = sw.load_scene(store.SCENE)
    cases = read_cases(scene, ("line",) if quick else ("line", "patch"), progress)
    read = [case for case in cases if case.tree is not None]
    html = _provenance(cases) + _comparison(read) + cards(_charts(read))
    return Section(_found(cases), html, {"rows": _rows_data(read), "stored": _stored_data(cases)})


def read_cases(
    scene: sw.Scene,
    fidelities: Sequence[str],
    progress: Progress,
    compare: Callable[[str, sw.Scene, str], list[Row]] = store.compare,
) -> list[Case]:
    """Every case: read and compared, refused, or missing."""
    cases = []
    for name in store.CASES:
        if not store.path_of(name).is_file():
            cases.append(Case(name, None, "not stored"))
            continue
        own = store.CONTACT[name].scene(scene) if name in store.CONTACT else scene
        try:
            tree = store.read(name, own)
        except SemiwearError as error:
            cases.append(Case(name, None, str(error)))
            continue
        rows, failures = {}, {}
        for fidelity in fidelities:
            progress.note(f"{name}, core at fidelity {fidelity}")
            try:
                rows[fidelity] = compare(name, scene, fidelity)
            except (SemiwearError, FileNotFoundError) as error:
                failures[fidelity] = str(error)
        cases.append(Case(name, tree, rows=rows, failures=failures))
    return cases


# ---- numbers


@dataclass(frozen=True)
class Agreement:
    """A figure of a case: where it is greatest, and where the two are farthest apart among pairs that bear load."""

    greatest: Row
    farthest: Row
    limit: float | None

    @property
    def apart(self) -> float:
        """Difference at the greatest value: absolute for shares, relative otherwise."""
        return self.greatest.difference


def summary(rows: Sequence[Row]) -> dict[str, Agreement]:
    """Agreement by figure; pairs that bear less than a tenth of the load do not count."""
    bears = _bearing(rows)
    found: dict[str, list[Row]] = {}
    for row in rows:
        if not row.where.startswith("roll") or row.where in bears:
            found.setdefault(row.name, []).append(row)
    return {
        name: Agreement(
            max(some, key=lambda row: abs(row.reference)),
            max(some, key=lambda row: abs(row.difference)),
            None if _is_nothing(some) else _limit(name),
        )
        for name, some in found.items()
    }


def _bearing(rows: Sequence[Row]) -> set[str]:
    """Roll positions at which a pair bears a share that counts."""
    return {row.where for row in rows if row.name == "load_share" and max(row.core, row.reference) > BEARS}


def _is_nothing(rows: Sequence[Row]) -> bool:
    """Whether these are transmission errors of unworn flanks without load: rounding, of no relative error."""
    return all(row.units == "arcsec" and max(abs(row.core), abs(row.reference)) < NOTHING for row in rows)


def _limit(name: str) -> float | None:
    """Agreement asked for; what edges bear hangs on the resolution, and has none."""
    if name.endswith("edge"):
        return None
    return next((limit for key, limit in LIMITS.items() if name.startswith(key)), None)


def _apart(row: Row) -> str:
    return f"{row.difference:+.3f}" if row.units == "1" else f"{100.0 * row.difference:+.1f} %"


def _found(cases: Sequence[Case]) -> tuple[str, ...]:
    read = [case for case in cases if case.tree is not None]
    missing = [case.name for case in cases if case.refusal == "not stored"]
    refused = [case.name for case in cases if case.refusal and case.name not in missing]
    first = f"{len(read)} of {len(cases)} cases are stored for this very scene"
    first += f"; not stored: {', '.join(missing)}" if missing else ""
    first += f"; REFUSED, computed for another scene: {', '.join(refused)}" if refused else ""
    sentences = [first + "."]
    texts = []
    for case in read:
        for fidelity, rows in case.rows.items():
            if case.name == "wear_cycle" or fidelity != "line":
                continue
            found = summary(rows)
            parts = [
                f"{text} {_apart(found[name].greatest)}"
                for name, text in (
                    ("contact_pressure_max", "greatest pressure"),
                    ("load_share", "load share"),
                    ("root_stress pinion", "pinion root stress"),
                    ("root_stress gear", "gear root stress"),
                    ("transmission_error_loaded, mean", "mean transmission error"),
                )
                if name in found
            ]
            texts.append(f"{NAMES[case.name]}: {', '.join(parts)}")
    if texts:
        sentences.append(f"Fidelity line less finite elements, at the greatest value of each: {'; '.join(texts)}.")
    within = [
        abs(one.apart) <= one.limit
        for case in read
        for rows in case.rows.values()
        for one in summary(rows).values()
        if one.limit is not None
    ]
    if within:
        sentences.append(f"{sum(within)} of {len(within)} figures that have a limit keep it at their greatest value.")
    return tuple(sentences)


# ---- markup


def _provenance(cases: Sequence[Case]) -> str:
    rows, marks = [], []
    for case in cases:
        seconds = case.attribute("seconds")
        rows.append(
            (
                NAMES.get(case.name, case.name),
                case.attribute("history").split(" ")[0] or "–",
                case.attribute("source") or "–",
                case.attribute("scene_sha256")[:12] or "–",
                with_unit(float(seconds), "s", 4) if seconds else "not recorded" if case.tree is not None else "–",
                case.refusal or "; ".join(case.failures.values()) or "read",
            )
        )
        marks.append("agree" if not case.refusal and not case.failures else "disagree")
    head = ("case", "computed", "by", "scene SHA-256", "took", "state")
    text = (
        "<p>Finite elements take too long for this report, so their results are stored; the core is computed in this "
        "run. <code>python -m validation --recompute</code> renews them. Nothing is fitted on either side.</p>"
    )
    notes = "".join(
        element("p", f"Refused: {escape(case.refusal)}", class_="failed", role="alert")
        for case in cases
        if case.refusal and case.refusal != "not stored"
    )
    return text + notes + text_table(table("Stored finite-element results", head, rows, marks))


def _comparison(cases: Sequence[Case]) -> str:
    html = ""
    head = (
        "figure",
        "core at fidelity",
        "where greatest",
        "core",
        "finite elements",
        "apart",
        "farthest apart",
        "where",
        "limit",
    )
    for case in cases:
        rows, marks = [], []
        for fidelity, given in case.rows.items():
            for name, one in summary(given).items():
                keeps = one.limit is None or abs(one.apart) <= one.limit
                rows.append(
                    (
                        name.replace("_", " "),
                        fidelity,
                        one.greatest.where,
                        with_unit(one.greatest.core, one.greatest.units),
                        with_unit(one.greatest.reference, one.greatest.units),
                        _apart(one.greatest),
                        _apart(one.farthest),
                        one.farthest.where,
                        "–" if one.limit is None else f"{one.limit:g}{'' if keeps else ' exceeded'}",
                    )
                )
                marks.append("" if one.limit is None else "agree" if keeps else "disagree")
        if rows:
            title = NAMES.get(case.name, case.name)
            html += table(f"{title}: the core against finite elements", head, rows, marks)
    note = (
        f"<p>Only tooth pairs that bear more than {percent(BEARS)} of the load count. The limits are those asked "
        "for at the greatest value: relative, of a load share absolute. Differences of edge pressures say little: "
        "they hang on the resolution.</p>"
    )
    return note + html if html else "<p>Nothing to compare.</p>"


def _charts(cases: Sequence[Case]) -> list[str]:
    drawn = []
    for case in cases:
        if case.name not in ("unworn", "finer"):
            continue
        for name, text, unit in (
            ("load_share", "Load share", "1"),
            (PRESSURE, "Pressure", "MPa"),
            ("root_stress pinion", "Root stress, pinion", "MPa"),
            ("root_stress gear", "Root stress, gear", "MPa"),
            ("transmission_error_loaded", "Loaded transmission error", "arcsec"),
        ):
            if any(row.name == name for rows in case.rows.values() for row in rows):
                title = f"{text}, {'unworn' if case.name == 'unworn' else 'worn'}"
                note = "Core at its fidelities, and finite elements, at the mesh positions they both solve."
                if name == PRESSURE and _light(case):
                    note += f" Grey: the pair bears less than {percent(BEARS)} of the load, which does not count."
                label = text if unit == "1" else f"{text} ({unit})"
                drawn.append(
                    card(
                        f"fe-{case.name}-{name.replace(' ', '-').replace('_', '-')}",
                        title,
                        note,
                        _over_roll(case, name, label),
                    )
                )
    return drawn


def _over_roll(case: Case, name: str, label: str) -> Draw:
    def draw(ax: Any) -> None:
        places = np.zeros(0)
        for k, (fidelity, rows) in enumerate(case.rows.items()):
            some = [row for row in rows if row.name == name]
            places = np.array([_place(row) for row in some])
            order = np.argsort(places)
            ax.plot(
                places[order],
                np.array([row.core for row in some])[order],
                "o-",
                color=COLOURS[2 * k],
                label=f"core, {fidelity}",
            )
            if k == 0:
                ax.plot(
                    places[order],
                    np.array([row.reference for row in some])[order],
                    "s--",
                    color=COLOURS[1],
                    label="finite elements",
                    fillstyle="none",
                )
        if name == PRESSURE:
            _shade(ax, np.sort(places), _light(case))
        ax.set_xlabel("Mesh position" if name.startswith("transmission") else "Roll position")
        ax.set_ylabel(label)
        if not name.startswith("transmission"):
            ax.set_ylim(bottom=0.0)
        ax.legend(loc="best")

    return draw


# ---- data


def _rows_data(cases: Sequence[Case]) -> xr.Dataset:
    flat = [(case.name, fidelity, row) for case in cases for fidelity, rows in case.rows.items() for row in rows]
    return dataset(
        {"row": np.arange(len(flat))},
        {
            "case": ([case for case, _, _ in flat], "1", "stored case"),
            "fidelity": ([fidelity for _, fidelity, _ in flat], "1", "fidelity of the core"),
            "figure": ([row.name for _, _, row in flat], "1", "figure"),
            "where": ([row.where for _, _, row in flat], "1", "roll position or mesh position"),
            "unit": ([row.units for _, _, row in flat], "1", "unit of both values"),
            "core": ([row.core for _, _, row in flat], "1", "core, in the row's unit"),
            "finite_elements": ([row.reference for _, _, row in flat], "1", "finite elements, in the row's unit"),
        },
    )


def _stored_data(cases: Sequence[Case]) -> xr.Dataset:
    def seconds(case: Case) -> float:
        return float(case.attribute("seconds") or "nan")

    return dataset(
        {"case": [case.name for case in cases]},
        {
            "history": ([case.attribute("history") for case in cases], "1", "when and by what it was computed"),
            "scene_sha256": ([case.attribute("scene_sha256") for case in cases], "1", "scene that it is of"),
            "seconds": ([seconds(case) for case in cases], "s", "time that it took"),
            "state": ([case.refusal or "read" for case in cases], "1", "read, refused or missing"),
        },
    )


def _light(case: Case) -> set[float]:
    """Roll positions of pressures that do not count, at any fidelity."""
    found = set()
    for rows in case.rows.values():
        bears = _bearing(rows)
        found |= {_place(row) for row in rows if row.name == PRESSURE and row.where not in bears}
    return found


def _place(row: Row) -> float:
    return float(row.where.split()[-1])


def _shade(ax: Any, places: np.ndarray, light: set[float]) -> None:
    """Grey beside places that do not count."""
    low, high = ax.get_xlim()
    for before, after in pairwise(places.tolist()):
        if before in light or after in light:
            ax.axvspan(before, after, color="#bbbbbb", alpha=0.3, linewidth=0.0)
    ax.set_xlim(low, high)
