"""The report: one self-contained HTML file."""

from __future__ import annotations

import os
from pathlib import Path

import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.plot.style import styled
from semiwear.plot.two_results import TwoResults
from semiwear.report import sections
from semiwear.report.contents import ReportData
from semiwear.report.effects import effects_section
from semiwear.report.fidelities import against_section, heading
from semiwear.report.first_screen import result_section
from semiwear.report.picture_cards import cards_of, left_out
from semiwear.report.ratings import ratings_section
from semiwear.report.turning import script_hashes
from semiwear.report.verdicts import verdicts_section
from semiwear.report.writing import page_of, page_target, write_page
from semiwear.results.life_axis import counted_in


def write_report(
    tree: xr.DataTree, path: str | os.PathLike[str], against: xr.DataTree | None = None, *, over: str = "meshes"
) -> Path:
    """Write a result as one self-contained HTML page: wear and its consequences first, inputs last.

    Pictures are inside the file and nothing is loaded from elsewhere. With the extra ``report`` the worn flank can
    be turned, over wear steps and roll positions; without it, without scripts and on paper there are pictures. Where
    the scene names ``reference = "seed_paper"``, the page compares the statements of that paper with the result; the
    verdicts are computed.

    Parameters
    ----------
    tree : DataTree
        A result of `simulate` or `loaded_contact`.
    path : path
        The HTML file, called .html; an existing one is replaced once the page is complete.
    against : DataTree, optional
        Another result on the same flank grid, such as that of the other fidelity: the page then shows where the two
        differ, by how much and why.
    over : str
        Unit of the life in the pictures: ``"meshes"``, ``"hours"`` or ``"km"`` of sliding, see `life_in`.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    MissingExtraError
        matplotlib is missing; install the extra ``plot``.
    SemiwearError
        A tree is not a result of semiwear, the two have different flank grids, the path is no HTML file's, or `over`
        is unknown or needs a speed that the scene does not give.
    OSError
        The file cannot be written.
    """
    for name, given in (("the tree", tree), ("the tree of `against`", against)):
        if given is not None and "schema_version" not in given.attrs:
            raise SemiwearError(f"report: {name} has no schema_version, so it is no result of semiwear")
    target = page_target(path)
    if against is not None:
        TwoResults.of(tree, against)  # refuses results of different flanks before pictures are drawn
    with styled():  # MissingExtraError before anything is drawn
        page = _page(ReportData(tree, against, counted_in(tree, over, "over")))
    write_page(target, page)
    return Path(path)


def _page(data: ReportData) -> str:
    parts = _sections(data)
    scripts = script_hashes() if any('id="turning"' in content for _, content in parts) else ()
    title, history = data.attrs.get("title", "Gear tooth wear"), data.attrs.get("history", "")
    return page_of(title, history, parts, data.attrs, scripts)


def _sections(data: ReportData) -> list[tuple[str, str]]:
    """Headings and HTML in the order of the page: results, how they were computed, inputs."""
    tree, against, attrs = data.tree, data.against, data.attrs
    return [
        ("Result", result_section(data)),
        ("What ends the life", ratings_section(tree)),
        ("Worn flanks", cards_of(data, "flank")),
        ("Over the life", cards_of(data, "life")),
        ("Through the mesh", cards_of(data, "mesh")),
        ("What effects add", effects_section(tree)),
        *([] if against is None else [(heading(against), against_section(tree, against))]),
        ("Against the paper", verdicts_section(data)),
        ("Every wear step", sections.wear_steps(tree)),
        ("What ran, and why", sections.physics(attrs)),
        ("Inputs", sections.inputs(data.scene, attrs.get("scene_toml", ""))),
        ("Diagnostics", sections.residual_note(tree) + sections.diagnostics(tree)),
        ("Left out", left_out(data)),
        ("References", sections.references(tree)),
    ]
