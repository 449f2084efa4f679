"""The report: one HTML file that needs nothing but itself."""

from __future__ import annotations

import os
from pathlib import Path

import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.plot.style import styled
from semiwear.plot.two_results import TwoResults
from semiwear.report import sections
from semiwear.report.effects import effects_section
from semiwear.report.fidelities import against_section, heading
from semiwear.report.first_screen import result_section
from semiwear.report.picture_cards import cards_of, left_out
from semiwear.report.ratings import ratings_section
from semiwear.report.told import Section, Told, written
from semiwear.report.turning import script_hashes
from semiwear.report.verdicts import verdicts_section
from semiwear.report.writing import page_of, page_target, write_page
from semiwear.results.life_axis import life_in

SECTIONS: tuple[Section, ...] = (
    Section("Result", result_section),
    Section("What ends the life", lambda told: ratings_section(told.tree)),
    Section("Worn flanks", lambda told: cards_of(told, "flank")),
    Section("Over the life", lambda told: cards_of(told, "life")),
    Section("Through the mesh", lambda told: cards_of(told, "mesh")),
    Section("What effects add", lambda told: effects_section(told.tree)),
    Section(
        lambda told: heading(told.against) if told.against is not None else "",
        lambda told: against_section(told.tree, told.against) if told.against is not None else "",
    ),
    Section("Against the paper", verdicts_section),
    Section("Every wear step", lambda told: sections.wear_steps(told.tree)),
    Section("What ran, and why", lambda told: sections.physics(told.attrs)),
    Section("Inputs", lambda told: sections.inputs(told.scene, told.attrs.get("scene_toml", ""))),
    Section("Diagnostics", lambda told: sections.residual_note(told.tree) + sections.diagnostics(told.tree)),
    Section("Left out", left_out),
    Section("References", lambda told: sections.references(told.tree)),
)
"""The sections in the order of the page: what came out, how it came to be, what went in."""


def write_report(
    tree: xr.DataTree, path: str | os.PathLike[str], against: xr.DataTree | None = None, *, over: str = "meshes"
) -> Path:
    """Write a result as one self-contained HTML page: what has worn and what that means first, what went in last.

    Pictures are inside the file and nothing is loaded from elsewhere. With the extra ``report`` the worn flank can
    be turned, over wear steps and roll positions; without it, without scripts and on paper there are pictures. Where
    the scene names ``reference = "seed_paper"``, what that paper says stands beside what came out, with verdicts
    computed from the result.

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
    if against is not None:
        TwoResults.of(tree, against)  # other flanks are refused before pictures are drawn
    with styled():  # asks for the extra before anything is drawn
        page = _page(Told(tree, against, life_in(tree, over)))
    write_page(target, page)
    return Path(path)


def _page(told: Told) -> str:
    found = written(SECTIONS, told)
    scripts = script_hashes() if any('id="turning"' in content for _, content in found) else ()
    title, history = told.attrs.get("title", "Gear tooth wear"), told.attrs.get("history", "")
    return page_of(title, history, found, told.attrs, scripts)
