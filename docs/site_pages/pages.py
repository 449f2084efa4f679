"""Write every generated page."""

from __future__ import annotations

from pathlib import Path

from site_pages.api import api_pages
from site_pages.command_line import command_line_page
from site_pages.extras import extras_tables
from site_pages.fields import effects_page, field_pages
from site_pages.more import more_page
from site_pages.validated import validated_text
from site_pages.variables import variables_page


def reference_pages() -> dict[str, str]:
    """File names and texts of the pages of the reference."""
    return {
        **api_pages(),
        **field_pages(),
        "effects.md": effects_page(),
        "variables.md": variables_page(),
        "command_line.md": command_line_page(),
    }


def write_all(here: Path) -> None:
    """Write them below ``generated``; what is unchanged keeps its date, so that Sphinx reads it once."""
    (here / "generated" / "work").mkdir(parents=True, exist_ok=True)
    texts = {f"reference/{name}": text for name, text in reference_pages().items()}
    texts |= {
        "more.md": more_page(here),
        "validated.md": validated_text(here),
        "extras.md": extras_tables(here.parent),
    }
    for name, text in texts.items():
        path = here / "generated" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
