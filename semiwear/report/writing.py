"""HTML documents that need nothing but themselves, written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from html import escape
from importlib import resources
from pathlib import Path

from semiwear.targets import PAGES, file_target, replacing

__all__ = ["document", "page_of", "page_target", "write_page"]


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


def document(title: str, body: str) -> str:
    """An HTML document in the style of the reports, that loads nothing; `title` is text, `body` HTML."""
    style = resources.files("semiwear.report").joinpath("page.css").read_text(encoding="utf-8")
    policy = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        f"<title>{escape(title)}</title><style>{style}</style></head><body>{body}</body></html>\n"
    )


def page_of(title: str, told: str, sections: Iterable[tuple[str, str]], attrs: Mapping[str, object]) -> str:
    """An HTML document with a header, sections and a footer that names the program and the scene.

    Parameters
    ----------
    title, told : str
        Text of the header.
    sections : iterable of (str, str)
        Headings and HTML; those without HTML are left out.
    attrs : mapping
        With `source` and `scene_sha256`, as a result has them.
    """
    body = "".join(f"<section><h2>{escape(heading)}</h2>{html}</section>\n" for heading, html in sections if html)
    source, digest = (
        escape(str(attrs.get(name, other))) for name, other in (("source", "semiwear"), ("scene_sha256", ""))
    )
    return document(
        title,
        f"<header><h1>{escape(title)}</h1><p>{escape(told)}</p></header><main>{body}</main>"
        f"<footer><p>{source}; scene SHA-256 <code>{digest}</code></p></footer>",
    )


def write_page(target: Path, page: str) -> None:
    """Write a page; what was there is replaced once the whole is written.

    Raises
    ------
    OSError
        It cannot be written.
    """
    with replacing(target) as temporary:
        temporary.write_text(page, encoding="utf-8")
