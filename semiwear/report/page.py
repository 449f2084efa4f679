"""The report: one HTML file that needs nothing but itself."""

from __future__ import annotations

import os
from html import escape
from pathlib import Path

import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.references import stated_names
from semiwear.report import sections
from semiwear.report.comparison import Compared, Comparison, Verdict, compare
from semiwear.report.effects import effects_section
from semiwear.report.fidelities import against_section, heading
from semiwear.report.markup import badge, counts, element, picture, verdict_class
from semiwear.report.pictures import Drawn, draw_all
from semiwear.report.trends import RULES
from semiwear.report.writing import document, page_target, write_page
from semiwear.results.life_axis import life_in
from semiwear.results.wearing import scene_tables
from semiwear.untyped import Table

__all__ = ["write_report"]


def write_report(
    tree: xr.DataTree, path: str | os.PathLike[str], against: xr.DataTree | None = None, *, over: str = "meshes"
) -> Path:
    """Write a result as one self-contained HTML page.

    Pictures are inside the file and nothing is loaded from elsewhere. Where the scene names
    ``reference = "seed_paper"``, each picture stands beside what that paper says, with a verdict computed
    from the result.

    Parameters
    ----------
    tree : DataTree
        A result of `simulate` or `loaded_contact`.
    path : path
        The HTML file, called .html; an existing one is replaced once the page is complete.
    against : DataTree, optional
        Another result on the same flank grid, such as that of the other fidelity: the page then says where the two
        differ, by how much and why.
    over : str
        What pictures count a life in: ``"meshes"``, ``"hours"`` or ``"km"`` of sliding, see `life_in`.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    MissingExtraError
        matplotlib is missing; install the extra ``plot``.
    SemiwearError
        A tree is no result of semiwear, the two lie on different flank grids, or the path is no HTML file's.
    OSError
        The file cannot be written.
    """
    for name, given in (("the tree", tree), ("the tree of `against`", against)):
        if given is not None and "schema_version" not in given.attrs:
            raise SemiwearError(f"report: {name} has no schema_version, so it is no result of semiwear")
    target = page_target(path)
    write_page(target, _page(tree, against, life_in(tree, over)))
    return Path(path)


def _page(tree: xr.DataTree, against: xr.DataTree | None, drawn_over: xr.DataTree) -> str:
    attrs = {str(name): str(value) for name, value in tree.attrs.items()}
    scene = scene_tables(tree)
    other = ""
    if against is not None:
        other = _section(heading(against), against_section(tree, against))
    comparison = _comparison_of(tree, scene)
    drawn = draw_all(drawn_over)
    title = attrs.get("title", "Gear tooth wear")
    parts = [
        f"<header><h1>{escape(title)}</h1><p>{escape(attrs.get('history', ''))}</p></header><main>",
        _section("Key numbers", sections.key_numbers(tree)),
        _section("Tips that press", sections.tips_that_press(tree)),
        _section("What effects add", effects_section(tree)),
        _section("What ran, and why", sections.physics(attrs)),
        _section("Inputs", sections.inputs(scene, attrs.get("scene_toml", ""))),
        other,
        _section("Against the paper", _summary(comparison)) if comparison else "",
        _section("Pictures", _pictures(drawn, comparison.statements if comparison else ())),
        _section("Wear steps", sections.wear_steps(tree)) if "history" in tree.children else "",
        _section("Diagnostics", sections.residual_note(tree) + sections.diagnostics(tree)),
        _section("References", sections.references(tree)),
        f"</main><footer><p>{escape(attrs.get('source', 'semiwear'))}; scene SHA-256 "
        f"<code>{escape(attrs.get('scene_sha256', ''))}</code></p></footer>",
    ]
    return document(title, "".join(parts))


def _section(heading: str, content: str) -> str:
    return f"<section><h2>{escape(heading)}</h2>{content}</section>\n" if content else ""


def _comparison_of(tree: xr.DataTree, scene: Table) -> Comparison | None:
    """The result beside the study that the scene names."""
    reference = scene.get("reference")
    return compare(reference, tree, scene) if reference in stated_names() else None


def _summary(comparison: Comparison) -> str:
    """Count of the verdicts, and the rules behind them."""
    badges = counts((entry.verdict for entry in comparison.statements), Verdict)
    rules = "".join(f"<dt>{escape(name)}</dt><dd>{escape(rule)}.</dd>" for name, rule in RULES.items())
    return (
        f"<p>“{escape(comparison.title)}”. Each verdict is computed from this result by the rule beside it.</p>"
        f"{badges}<details><summary>What “rises”, “falls” and “levels” mean</summary>"
        f"<dl>{rules}</dl></details>"
    )


def _pictures(drawn: list[Drawn], compared: tuple[Compared, ...]) -> str:
    """Cards of the pictures; without a paper they stand side by side, those of one height together."""
    if not compared:
        drawn = sorted(drawn, key=lambda one: (not one.picture.both_ends, one.picture.panels))
    cards = "".join(_card(one, _beside(one, compared)) for one in drawn if one.uri)
    left_out = "".join(
        f"<li>{escape(one.picture.title)}: {escape(one.left_out)}.</li>" for one in drawn if one.left_out
    )
    note = f"<p>Left out:</p><ul>{left_out}</ul>" if left_out else ""
    return f'<div class="cards">{cards}</div>{note}'


def _beside(drawn: Drawn, compared: tuple[Compared, ...]) -> list[Compared]:
    """Caption of a paper's figure; of one flank it is the gear's."""
    of_gear = drawn.picture.body in ("", "gear")
    return [entry for entry in compared if of_gear and entry.picture == drawn.picture.name]


def _card(drawn: Drawn, compared: list[Compared]) -> str:
    shown = drawn.picture
    figure = picture(shown.title, drawn.uri, drawn.alt, shown.caption, shown.size)
    if not compared:
        return element("article", figure, class_="card full" if shown.both_ends else "card")
    beside = "".join(_comparison(entry) for entry in compared)
    return element("article", f'{figure}<div class="paper">{beside}</div>', class_="card wide")


def _comparison(entry: Compared) -> str:
    why = f"<dt>Why</dt><dd>{escape(entry.why)}</dd>" if entry.why else ""
    return (
        f'<div class="comparison {verdict_class(entry.verdict)}"><p class="verdict">{badge(entry.verdict)}</p><dl>'
        f"<dt>Paper</dt><dd>{escape(entry.statement)}</dd><dt>Here</dt><dd>{escape(entry.ours)}</dd>{why}"
        f'<dt class="rule">Rule</dt><dd class="rule">{escape(entry.rule)}</dd></dl></div>'
    )
