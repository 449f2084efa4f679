"""Text of what the validation finds: sections of its report, computed while the site is built."""

from __future__ import annotations

import hashlib
import html
import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from validation.section import Built

_SECTIONS = ("closed_forms", "finite_elements", "helical_pairs")
_SCRIPT = """
import sys
from site_pages.validated import findings
from validation.parallel import build_all
from validation.problems import PROBLEMS
from validation.progress import progress_on
from validation.sections import SECTIONS
chosen = [plan for plan in SECTIONS if plan.name in sys.argv[1:]]
print(findings(build_all(chosen, PROBLEMS, True, progress_on(sys.stderr, len(chosen)), 2)))
"""


def findings(parts: Iterable[Built]) -> str:
    """What sections found, in Markdown.

    Raises
    ------
    RuntimeError
        A section could not be built.
    """
    from site_pages.finite_elements import finite_elements_text  # loads the validation

    lines: list[str] = []
    for part in parts:
        if part.section is None:
            raise RuntimeError(part.trace)
        tabulated = part.plan.name == "finite_elements"
        told = [text for text in part.section.found if not (tabulated and text.startswith("Fidelity line"))]
        lines += [f"## {part.plan.title}", "", *(f"- {html.unescape(text)}" for text in told), ""]
        if tabulated:
            lines.append(finite_elements_text())
    return "\n".join(lines)


def validated_text(here: Path) -> str:
    """Findings of the sections that take a minute; kept for as long as the sources are those of before."""
    kept = here / "generated" / "work" / f"validated_{_sources(here.parent)}.md"
    if not kept.is_file():
        for old in kept.parent.glob("validated_*.md"):
            old.unlink()
        command = [sys.executable, "-c", _SCRIPT, *_SECTIONS]
        paths = os.environ | {"PYTHONPATH": str(here)}
        done = subprocess.run(command, cwd=here.parent, env=paths, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(f"the validation could not be computed:\n{done.stderr}")
        kept.write_text(done.stdout, encoding="utf-8")
    return kept.read_text(encoding="utf-8")


def _sources(root: Path) -> str:
    digest = hashlib.sha256()
    for folder in ("semiwear", "fem_reference", "validation", "docs/site_pages"):
        for path in sorted((root / folder).rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts and path.suffix in {".py", ".toml", ".nc", ".json"}:
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
