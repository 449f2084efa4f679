"""The validation report as files: one page that needs nothing but itself, its numbers as netCDF and CSV."""

from __future__ import annotations

import datetime
import os
import platform
from collections.abc import Sequence
from html import escape
from importlib import metadata, resources
from pathlib import Path

import xarray as xr

from semiwear.report.markup import element, figure_text, table
from semiwear.targets import replacing
from validation.section import Built

_STYLE = """
nav ol { columns: 18rem; margin: .4rem 0 0; }
nav { background: var(--paper); border: 1px solid var(--line); border-radius: 8px; padding: .7rem 1rem;
  margin: 1.2rem 0; }
a { color: var(--accent); }
.found { background: var(--paper); border-left: 5px solid var(--accent); border-radius: 6px; padding: .6rem .9rem;
  max-width: 75rem; margin: 0 0 1rem; }
.failed { background: var(--disagree-ground); border-left: 5px solid var(--disagree); border-radius: 6px;
  padding: .6rem .9rem; color: var(--disagree); overflow-wrap: anywhere; }
.charts { grid-template-columns: repeat(auto-fill, minmax(min(25rem, 100%), 1fr)); margin: 1rem 0; }
.charts svg { display: block; width: 100%; max-width: 33rem; height: auto; }
.scroll { margin: 1rem 0; }
.text td { text-align: left; white-space: normal; min-width: 9rem; }
.text th { text-align: left; }
tbody th { white-space: normal; min-width: 9rem; }
.statements { display: grid; gap: .7rem; align-items: start;
  grid-template-columns: repeat(auto-fill, minmax(min(24rem, 100%), 1fr)); }
.text td.agree, .text td.disagree, .text td.not-compared { font-weight: 650; min-width: 0; }
h3 { margin-top: 1.4rem; }
figure h3 { margin-top: 0; }
section > p { max-width: 75rem; }
td.agree, td.disagree, td.not-compared { border-color: var(--line); font-weight: 650; }
"""


def write(parts: Sequence[Built], folder: Path, *, quick: bool) -> Path:
    """Write `validation.html`, `validation.nc` and one CSV a dataset into a folder.

    Parameters
    ----------
    parts : sequence of Built
    folder : path
        Made if it is not there.
    quick : bool

    Returns
    -------
    Path
        The page.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with replacing(folder / "validation.nc") as path:
        _tree(parts, quick).to_netcdf(path)
    for part in parts:
        for name, data in part.section.datasets.items() if part.section else ():
            with replacing(folder / f"{part.plan.name}_{name}.csv") as path:
                data.to_dataframe().to_csv(path)
    target = folder / "validation.html"
    with replacing(target) as path:
        path.write_text(page(parts, quick=quick), encoding="utf-8")
    return target


def _tree(parts: Sequence[Built], quick: bool) -> xr.DataTree:
    groups = {
        f"/{part.plan.name}/{name}": data
        for part in parts
        if part.section
        for name, data in part.section.datasets.items()
    }
    tree = xr.DataTree.from_dict({"/": xr.Dataset(), **groups})
    tree.attrs = {
        "title": "Validation of semiwear",
        "source": f"semiwear {metadata.version('semiwear')}",
        "history": f"{_now()} python -m validation{' --quick' if quick else ''}",
    }
    return tree


def page(parts: Sequence[Built], *, quick: bool) -> str:
    """The page as text."""
    style = resources.files("semiwear.report").joinpath("page.css").read_text(encoding="utf-8")
    kind = "quick report: fewer points, coarser references" if quick else "full report"
    policy = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
    contents = "".join(
        f'<li><a href="#{part.plan.name}">{escape(part.plan.title)}</a>{" (failed)" if part.error else ""}</li>'
        for part in parts
    )
    contents += '<li><a href="#made">How this report was made</a></li>'
    body = "".join(_section(number, part) for number, part in enumerate(parts, 1))
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        f"<title>Validation of semiwear</title><style>{style}{_STYLE}</style></head><body>"
        f"<header><h1>Validation of semiwear</h1><p>{_now()}, semiwear {metadata.version('semiwear')}, {kind}</p>"
        f'</header><main><nav aria-label="Contents"><strong>Contents</strong><ol>{contents}</ol></nav>'
        f"{body}{_made(len(parts) + 1, parts)}</main></body></html>\n"
    )


def _section(number: int, part: Built) -> str:
    heading = f"<h2>{number} {escape(part.plan.title)}</h2>"
    if part.section is None:
        note = (
            f'<div class="failed" role="alert"><p><strong>This section could not be built.</strong> '
            f"{escape(part.error)}</p><details><summary>Where</summary><pre>{escape(part.trace)}</pre></details></div>"
        )
        return element("section", heading + note, id=part.plan.name)
    found = element("p", escape(" ".join(part.section.found)), class_="found")
    return element("section", heading + found + part.section.html, id=part.plan.name)


def _made(number: int, parts: Sequence[Built]) -> str:
    rows = [
        (part.plan.title, figure_text(part.processor_seconds, 3), figure_text(part.seconds, 3), part.error or "built")
        for part in parts
    ]
    processor, clock = (sum(getattr(part, name) for part in parts) for name in ("processor_seconds", "seconds"))
    rows.append(("all, one after the other", figure_text(processor, 3), figure_text(clock, 3), ""))
    versions = ", ".join(f"{name} {_version(name)}" for name in ("numpy", "scipy", "numba", "scikit-fem", "xarray"))
    text = (
        f"<p>Python {platform.python_version()}, {escape(versions)}, on {escape(platform.machine())} under "
        f"{escape(platform.system())}, {os.cpu_count()} processors, one thread. Unless it is said otherwise, seconds "
        "are of the processor, with kernels compiled and tooth compliance at hand (warm).</p>"
    )
    head = ("section", "processor [s]", "clock [s]", "outcome")
    made = f"<h2>{number} How this report was made</h2>{text}{table('What each section took', head, rows)}"
    return element("section", made, id="made")


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "missing"


def _now() -> str:
    return datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
