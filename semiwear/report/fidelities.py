"""Section that compares a result with another one on the same flank grid, such as that of the other fidelity."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from html import escape

import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.plot.against import pressure_of_both, wear_difference
from semiwear.plot.style import SIZE
from semiwear.plot.two_results import TwoResults, fidelity
from semiwear.report.differences import LOAD_SHARE, RELATIVE, Difference, Kind, Mark, differences
from semiwear.report.markup import (
    card,
    code_marked,
    counts,
    element,
    figure_text,
    table,
    verdict_class,
    verdict_text,
)
from semiwear.report.pictures import figure_uri
from semiwear.report.reasons import reason
from semiwear.results.wearing import pitch_name, scene_tables, worn_bodies
from semiwear.scene.toml_io import flat
from semiwear.untyped import Table

_DEFAULT = "default"
_OF_FIDELITY = {
    "name",
    "title",
    "reference",
    "numerics.fidelity",
    "numerics.cells_per_half_width",
    "numerics.wear_mapping",
}
"""Fields in which two scenes may differ while the reasons hold: texts, and fields of one fidelity alone."""


def heading(against: xr.DataTree) -> str:
    """Heading of the section, with the fidelity of the other result."""
    return f"Against fidelity “{fidelity(against)}”"


def against_section(tree: xr.DataTree, against: xr.DataTree) -> str:
    """Tables, reasons and pictures of the differences of two results.

    Parameters
    ----------
    tree, against : DataTree
        Results on the same flank grid.

    Returns
    -------
    str
        HTML.

    Raises
    ------
    SemiwearError
        If the results lie on different flank grids; the message names the difference and the remedy.
    """
    results = TwoResults.of(tree, against)
    scenes = scene_tables(tree), scene_tables(against)
    rows = differences(results)
    differing = _differing(scenes) if all(scenes) else None
    alike = differing is not None and set(differing) <= _OF_FIDELITY
    tables = "".join(_table(kind, rows, results, alike) for kind in Kind)
    return f"{_states(results)}{_scenes(results, differing)}{_summary(rows)}{tables}{_pictures(results)}"


def _states(results: TwoResults) -> str:
    """Paragraph on the wear states that are compared."""
    first, last = (f"<b>{escape(name)}</b>" for name in results.names)
    fidelities = ", ".join(map(fidelity, results.trees))
    text = f"This result, {first}, against the other, {last} (fidelities: {escape(fidelities)}). "
    if not results.have("history", "meshes"):
        text += "At least one of them has no wear steps: the wear states compared are the first ones."
    elif len(results.steps) == 1:
        text += "They have only the unworn state in common."
    else:
        meshes = results.values("history", "meshes", results.steps[-1])
        reached = " and ".join(figure_text(float(value)) for value in meshes)
        steps = " and ".join(map(str, results.steps[-1]))
        text += (
            f"Compared are the unworn state and the last wear state that both reached: wear steps {steps}, after "
            f"{reached} engagements of a gear tooth"
        )
        if results.have("history", "wear_depth_control_point"):
            depths = results.values("history", "wear_depth_control_point", results.steps[-1])
            text += f", with {' and '.join(figure_text(float(depth)) for depth in depths)} µm at the control point"
        text += "."
    return f"<p>{text}</p>"


def _differing(scenes: tuple[Table, Table]) -> dict[str, tuple[str, str]]:
    """Fields in which two scenes differ, with both values."""
    first, second = (dict(flat(scene)) for scene in scenes)
    return {
        name: (str(first.get(name, _DEFAULT)), str(second.get(name, _DEFAULT)))
        for name in dict.fromkeys((*first, *second))
        if first.get(name) != second.get(name)
    }


def _scenes(results: TwoResults, differing: Mapping[str, tuple[str, str]] | None) -> str:
    """Paragraph or table of the fields in which the scenes differ."""
    if differing is None:
        return "<p>At least one result holds no readable scene: the fields that differ are unknown.</p>"
    if not differing:
        return "<p>The scenes are the same.</p>"
    if set(differing) == {"numerics.fidelity"}:
        return "<p>The scenes differ in <code>numerics.fidelity</code> only.</p>"
    listed = [(name, *values) for name, values in differing.items()]
    note = "<p>The scenes differ in the fields below; each of them can cause the differences that follow.</p>"
    return note + table("Fields in which the scenes differ", ("field", *map(escape, results.names)), listed)


def _summary(rows: Sequence[Difference]) -> str:
    rule = (
        f"Two values agree where they are within {RELATIVE * 100:g} % of the greater one (wear on the map: of "
        f"the greatest wear; line load: of at least a twentieth of the greatest), two load shares where they are "
        f"within {LOAD_SHARE:g}. Differences are this result minus the other."
    )
    return f"{counts((row.mark for row in rows), Mark)}<p>{escape(rule)}</p>"


def _table(kind: Kind, rows: Sequence[Difference], results: TwoResults, alike: bool) -> str:
    """Table of a kind and the reasons below it."""
    own = [row for row in rows if row.kind is kind]
    if not own:
        return ""
    cells = [
        (
            row.quantity,
            row.where,
            row.when,
            row.value_text(row.this),
            row.value_text(row.other),
            row.text,
            verdict_text(row.mark),
        )
        for row in own
    ]
    head = ("quantity", "where", "wear state", *map(escape, results.names), "difference", "mark")
    shown = table(kind.value, head, cells, [verdict_class(row.mark) for row in own])
    why = reason(kind, rows, results, alike)
    return element("div", shown + (f"<p>{code_marked(why)}</p>" if why else ""), class_="against")


def _pictures(results: TwoResults) -> str:
    """Pictures of the differences; one that cannot be drawn is replaced by the reason."""
    names = f"{results.names[0]} minus {results.names[1]}"
    worn = (set(worn_bodies(results.this)) | set(worn_bodies(results.other))) or {"gear"}
    cards = (
        *(
            _card(
                f"Difference in wear, {body}",
                f"Wear of the {body} at the last common wear state, {names}; dashed, the band of the "
                f"{pitch_name(results.this)}"
                + ("; dotted, the strips along the borders of the active flank." if body == "gear" else "."),
                partial(wear_difference, body=body),
                results,
            )
            for body in ("pinion", "gear")
            if body in worn
        ),
        _card(
            "Greatest pressure of both",
            f"Full lines {results.names[0]}, dashed lines {results.names[1]}, from entry to exit of a tooth pair; "
            "thick away from borders, thin at the borders.",
            pressure_of_both,
            results,
        ),
    )
    return f'<div class="cards">{"".join(cards)}</div>'


def _card(title: str, caption: str, draw: Callable[..., object], results: TwoResults) -> str:
    try:
        uri = figure_uri(SIZE, 1, lambda axes: draw(results.this, results.other, ax=axes[0]))
    except SemiwearError as error:
        if isinstance(error, ImportError):
            raise
        return element("p", f"{escape(title)} is left out: {escape(str(error))}.")
    # only in the map of differences do colours represent values
    return card(title, uri, f"{title}. {caption}", caption, SIZE, of_colours=draw is not pressure_of_both)
