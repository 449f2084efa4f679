"""HTML documents that need nothing but themselves, written whole or not at all."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib import resources
from pathlib import Path

from semiwear.targets import PAGES, file_target, replacing


def page_target(path: str | os.PathLike[str]) -> Path:
    """Where to write a page.

    Raises
    ------
    SceneError
        The name is no HTML file's.
    FileNotFoundError
        There is no such folder.
    """
    target = file_target("path", path, PAGES)
    if not target.parent.is_dir():
        raise FileNotFoundError(f"report: no folder {target.parent} for {target.name}")
    return target


def document(title: str, body: str, scripts: Sequence[str] = ()) -> str:
    """An HTML document in the style of the reports, that loads nothing; `title` is text, `body` HTML.

    No script runs but those of the given hashes.
    """
    style = resources.files("semiwear.report").joinpath("page.css").read_text(encoding="utf-8")
    policy = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
    if scripts:
        policy += f"; script-src {' '.join(scripts)}"
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        f"<title>{escape(title)}</title><style>{style}</style></head><body>{body}</body></html>\n"
    )


def page_of(
    title: str,
    told: str,
    sections: Iterable[tuple[str, str]],
    attrs: Mapping[str, object],
    scripts: Sequence[str] = (),
) -> str:
    """An HTML document with a header, a list of contents, sections, and a footer that names program and scene.

    Parameters
    ----------
    title, told : str
        Text of the header.
    sections : iterable of (str, str)
        Headings and HTML; those without HTML are left out.
    attrs : mapping
        With `source` and `scene_sha256`, as a result has them.
    scripts : sequence of str, optional
        Hashes of the scripts that may run.
    """
    found = [(escape(heading), _place(heading), html) for heading, html in sections if html]
    links = "".join(f'<li><a href="#{place}">{heading}</a></li>' for heading, place, _ in found)
    body = "".join(f'<section id="{place}"><h2>{heading}</h2>{html}</section>\n' for heading, place, html in found)
    source, digest = (
        escape(str(attrs.get(name, other))) for name, other in (("source", "semiwear"), ("scene_sha256", ""))
    )
    return document(
        title,
        f"<header><h1>{escape(title)}</h1><p>{escape(told)}</p></header>"
        f'<nav aria-label="Contents"><ul>{links}</ul></nav><main>{body}</main>'
        f"<footer><p>{source}; scene SHA-256 <code>{digest}</code></p></footer>",
        scripts,
    )


def _place(heading: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", heading.lower()).strip("-")


def write_page(target: Path, page: str) -> None:
    """Write a page; what was there is replaced once the whole is written.

    Raises
    ------
    OSError
        It cannot be written.
    """
    with replacing(target) as temporary:
        temporary.write_text(page, encoding="utf-8")
