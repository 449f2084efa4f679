"""Text of what the validation finds: sections of its report, computed while the site is built."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

__all__ = ["validated_text"]

_SECTIONS = ("closed_forms", "finite_elements", "helical_pairs")
_SCRIPT = """
import html, sys
from validation.parallel import build_all
from validation.problems import PROBLEMS
from validation.progress import progress_on
from validation.sections import SECTIONS
chosen = [plan for plan in SECTIONS if plan.name in sys.argv[1:]]
for part in build_all(chosen, PROBLEMS, True, progress_on(sys.stderr, len(chosen)), 2):
    if part.section is None:
        sys.exit(part.trace)
    print(f"## {part.section.title}\\n")
    for sentence in part.section.found:
        print(f"- {html.unescape(sentence)}")
    print()
"""


def validated_text(here: Path) -> str:
    """Findings of the sections that take a minute; kept for as long as the sources are those of before."""
    kept = here / "generated" / "work" / f"validated_{_sources(here.parent)}.md"
    if not kept.is_file():
        command = [sys.executable, "-c", _SCRIPT, *_SECTIONS]
        done = subprocess.run(command, cwd=here.parent, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(f"the validation could not be computed:\n{done.stderr}")
        kept.write_text(done.stdout, encoding="utf-8")
    return kept.read_text(encoding="utf-8")


def _sources(root: Path) -> str:
    digest = hashlib.sha256()
    for folder in ("semiwear", "fem_reference", "validation"):
        for path in sorted((root / folder).rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts and path.suffix in {".py", ".toml", ".nc", ".json"}:
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
