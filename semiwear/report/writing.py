"""Self-contained HTML documents, written completely or not at all."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib import resources
from pathlib import Path

from semiwear.targets import PAGES, file_target, replacing


def page_target(path: str | os.PathLike[str]) -> Path:
    """Path of a page that is to be written.

    Raises
    ------
    SceneError
        The name is not that of an HTML file.
    FileNotFoundError
        The folder does not exist.
    """
    target = file_target("path", path, PAGES)
    if not target.parent.is_dir():
        raise FileNotFoundError(f"report: no folder {target.parent} for {target.name}")
    return target


def document(title: str, body: str, scripts: Sequence[str] = ()) -> str:
    """An HTML document in the style of the reports that loads no other file; `title` is text, `body` HTML.

    Only scripts with the given hashes run.
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
    subtitle: str,
    sections: Iterable[tuple[str, str]],
    attrs: Mapping[str, object],
    scripts: Sequence[str] = (),
) -> str:
    """An HTML document with a header, a list of contents, sections, and a footer that names program and scene.

    Parameters
    ----------
    title, subtitle : str
        Text of the header.
    sections : iterable of (str, str)
        Headings and HTML; those without HTML are left out.
    attrs : mapping
        With `source` and `scene_sha256`, as in a result.
    scripts : sequence of str, optional
        Hashes of the scripts that may run.
    """
    filled = [(escape(heading), _anchor(heading), html) for heading, html in sections if html]
    links = "".join(f'<li><a href="#{anchor}">{heading}</a></li>' for heading, anchor, _ in filled)
    body = "".join(f'<section id="{anchor}"><h2>{heading}</h2>{html}</section>\n' for heading, anchor, html in filled)
    source, digest = (
        escape(str(attrs.get(name, other))) for name, other in (("source", "semiwear"), ("scene_sha256", ""))
    )
    return document(
        title,
        f"<header><h1>{escape(title)}</h1><p>{escape(subtitle)}</p></header>"
        f'<nav aria-label="Contents"><ul>{links}</ul></nav><main>{body}</main>'
        f"<footer><p>{source}; scene SHA-256 <code>{digest}</code></p></footer>",
        scripts,
    )


def _anchor(heading: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", heading.lower()).strip("-")


def write_page(target: Path, page: str) -> None:
    """Write a page; an existing file is replaced once the new one is complete.

    Raises
    ------
    OSError
        The file cannot be written.
    """
    with replacing(target) as temporary:
        temporary.write_text(page, encoding="utf-8")
